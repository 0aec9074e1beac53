/* A period with the bridge off: nothing is controlled, and the offsets of the current sensors are measured.
 */
#include "fast/fast_parts.h"

/* Measures the offsets of the current sensors while the bridge is off. Below dc_undervoltage a rotor that
 * rotates slowly may feed the link with a current that has the same effect as an offset. */
static void calibrate(fast_t *fast, fast_orders_t orders, const drive_samples_t *samples)
{
    const fast_tuning_t *tuning = orders.tuning;
    measure_t *measure = &fast->measure;
    switch ((calibrate_t)orders.setpoint->calibrate) {
    case CALIBRATE_ALL:
        if (fast->report.calibration == (int32_t)CALIBRATION_GOES_ON) {
            fast->report.calibration = (int32_t)measure_calibrate(measure, &tuning->measure, samples);
        }
        break;
    case CALIBRATE_BLOCKS:
        if (measure->measured.u_dc < tuning->limits.dc_undervoltage) {
            measure_begin_rest(measure);
        } else if (measure_rest(measure, &tuning->measure, samples, orders.setpoint->trim)) {
            fast->report.offsets = 1u;
        }
        fast->report.calibration = (int32_t)measure_found(measure);
        break;
    case CALIBRATE_NOT:
        break;
    }
}

void fast_rest(fast_t *fast, fast_orders_t orders, const drive_samples_t *samples)
{
    const dq_t none = {0.0f, 0.0f};
    const bool encoder = orders.setpoint->source == (int32_t)SOURCE_ENCODER;
    if (fast->bridge.on != 0u) {
        measure_begin_rest(&fast->measure);
    }
    fast->bridge.on = 0u;
    fast->bridge.runs = 0u;
    fast->estimating = 0u;
    reference_rest(&fast->reference, (int32_t)(encoder ? SOURCE_ENCODER : SOURCE_NONE));
    fast_update_rotor(fast, orders);
    fast->demand = (demand_t){fast->rotor, (int32_t)FRAME_GOES_ON, none, none, (int32_t)EMF_OTHER, 0.0f};
    current_control_reset(&fast->current_control, none);
    fast->control.current = frames_park(fast->measure.measured.current, fast->rotor.rotation);
    fast->control.voltage = none;
    fast->command.duty = (abc_t){0.5f, 0.5f, 0.5f};
    fast->command.gates = (int32_t)GATES_OFF;
    calibrate(fast, orders, samples);
}
