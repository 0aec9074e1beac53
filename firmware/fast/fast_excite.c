/* The excitation of a motor whose data are unknown: fast/control/excite.h with the inverter. It runs only
 * while the medium task commissions, and from flash. */
#include "fast/fast_parts.h"

abc_t fast_excite(fast_t *fast, fast_orders_t orders)
{
    const inverter_tuning_t *tuning = &orders.tuning->inverter;
    const measured_t *measured = &fast->measure.measured;
    const ab_t none = {0.0f, 0.0f};
    const ab_t made = frames_clarke(fast->inverter.duty_prev[1]);
    const ab_t acted = {made.alpha * fast->acted.link, made.beta * fast->acted.link};
    const ab_t asked = excite_step(&fast->control.excite, &orders.setpoint->excite, measured->current, acted);
    /* the watch of the sensors compares them with a reference that control reaches at once: here is none */
    fast->demand.current = frames_park(measured->current, fast->demand.frame.rotation);
    current_control_reset(&fast->current_control, (dq_t){0.0f, 0.0f});
    fast->control.voltage = frames_park(asked, fast->demand.frame.rotation);
    fast->control.limited = 0u;
    /* without a current no leg has a loss that could be compensated */
    return inverter_make(&fast->inverter, tuning, asked, none, measured->u_dc).duty;
}
