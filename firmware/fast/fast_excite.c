/* The excitation of a motor whose data are unknown: fast/control/excite.h with the inverter. It runs only
 * while the medium task commissions, and from flash. */
#include "fast/fast_parts.h"

/* The voltage [V] of the loop that is checked, in the stationary frame. */
static ab_t loop(fast_t *fast, const excite_order_t *order)
{
    const dq_t none = {0.0f, 0.0f};
    if (order->serial != fast->control.excite.seen.serial) {
        current_control_reset(&fast->current_control, none);
    }
    const dq_t current = frames_park(fast->measure.measured.current, order->axis);
    const dq_t wanted = excite_loop(&fast->control.excite, order, current);
    const dq_t asked =
        current_control_step(&fast->current_control, (dq_t){wanted.d, current.q}, current, 0.0f, none);
    current_control_applied(&fast->current_control, asked);
    return frames_inverse_park((dq_t){asked.d, wanted.q}, order->axis);
}

/* The voltage [V] of the other kinds, in the stationary frame. */
static ab_t excitation(fast_t *fast, const excite_order_t *order)
{
    const ab_t made = frames_clarke(fast->inverter.duty_prev[1]);
    const ab_t acted = {made.alpha * fast->acted.link, made.beta * fast->acted.link};
    return excite_step(&fast->control.excite, order, fast->measure.measured.current, acted);
}

abc_t fast_excite(fast_t *fast, fast_orders_t orders)
{
    const inverter_tuning_t *tuning = &orders.tuning->inverter;
    const measured_t *measured = &fast->measure.measured;
    const ab_t none = {0.0f, 0.0f};
    const excite_order_t *order = &orders.setpoint->excite;
    const ab_t asked = order->kind == (int32_t)EXCITE_LOOP ? loop(fast, order) : excitation(fast, order);
    /* the watch of the sensors compares them with a reference that control reaches at once; an excitation has
     * none */
    fast->demand.current = fast->control.current;
    fast->control.voltage = frames_park(asked, fast->demand.frame.rotation);
    fast->control.limited = 0u;
    /* without a current no leg has a loss that could be compensated */
    return inverter_make(tuning, asked, none, fast->acted.leg, measured->u_dc).duty;
}
