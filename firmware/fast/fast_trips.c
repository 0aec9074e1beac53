/* Reactions that do not wait for a setpoint: the rows of the fault table with the rate EACH, a step of the
 * encoder's angle, a current sensor whose value does not change. */
#include "fast/fast_parts.h"

#include "guard/guard_quantities.h"
#include "settings/reasons.h"

void fast_open_bridge(fast_t *fast, uint32_t window)
{
    if (fast->bridge.open == 0u) {
        fast->bridge.open = 1u;
        fast->bridge.open_since = window;
    }
}

void fast_stop(fast_t *fast, int32_t reason)
{
    const measured_t *measured = &fast->measure.measured;
    fast_open_bridge(fast, fast->report.number);
    if (fast->report.stop.reason == (int32_t)REASON_NONE) {
        fast->report.stop = (drive_fault_t){
            .reason = reason,
            .period = fast->period,
            .i_a = measured->current_abc.a,
            .i_b = measured->current_abc.b,
            .u_dc = measured->u_dc,
            .theta_e = fast->rotor.theta_e,
            .omega_e = fast->rotor.omega_e,
        };
    }
}

/* The encoder's angle has moved faster than any rotor: its row opens the bridge, or control leaves the
 * encoder in this period. */
static uint32_t watch_jump(fast_t *fast, fast_orders_t orders)
{
    const setpoint_t *setpoint = orders.setpoint;
    const bool watched = fast->reference.source == (int32_t)SOURCE_ENCODER &&
                         setpoint->jump != (int32_t)JUMP_IGNORED &&
                         (fast->measure.measured.flags & DRIVE_SAMPLE_LATE) == 0u; /* unknown rotation */
    if (!watched || !encoder_jumped(&fast->encoder, orders.tuning->limits.jump)) {
        return 0u;
    }
    if (setpoint->jump == (int32_t)JUMP_OPENS) {
        return ENCODER_WATCH_JUMP;
    }
    const bool to_estimate = setpoint->jump == (int32_t)JUMP_TO_ESTIMATE;
    fast->report.left = setpoint->jump;
    reference_leave_encoder(&fast->reference, to_estimate, fast->estimator.estimate.omega_smooth,
                            setpoint->jump_periods);
    fast_update_rotor(fast, orders.tuning);
    return 0u;
}

/* Finds whether a sample shows that the gates are on and the charging has ended. */
static void find_gates_on(fast_bridge_t *bridge, uint32_t flags)
{
    if (bridge->runs == 0u && bridge->on >= FAST_ON && bridge->charging == 0u &&
        (flags & DRIVE_SAMPLE_TRIPPED) == 0u) {
        bridge->runs = 1u;
    }
}

/* The moments in which the fast rows count. Those of a bridge that is on begin with the first sample that
 * shows the gates on, independent of the medium task. The sequence detects gates that never come on. */
static inline uint32_t moments(const fast_bridge_t *bridge, const setpoint_t *setpoint)
{
    return bridge->runs == 0u || bridge->open != 0u ? GUARD_ALWAYS : setpoint->moments;
}

static inline guard_input_t trip_input(const fast_t *fast, const setpoint_t *setpoint, uint32_t encoder_wrong)
{
    return (guard_input_t){
        .measured = &fast->measure.measured,
        .omega_m = fast->omega_m,
        .encoder_wrong = encoder_wrong,
        .medium_late = fast->given.late >= FAST_LATE_WINDOWS ? 1u : 0u,
        .now = moments(&fast->bridge, setpoint),
        .found = NULL,
    };
}

static void judge_trips(fast_t *fast, fast_orders_t orders, uint32_t encoder_wrong)
{
    guard_input_t input = trip_input(fast, orders.setpoint, encoder_wrong);
    measured_t expected;
    if (fast->measure.measured.good == 0u) {
        expected = fast->measure.measured;
        expected.current_abc = measure_expected(&fast->measure);
        input.measured = &expected;
    }
    /* a loop that has lost the rotor is for the medium task to judge, which catches the rotor again */
    const bool denied = reference_tracks(&fast->reference) && estimate_is_denied(&fast->estimator.estimate);
    input.omega_m = denied ? 0.0f : input.omega_m;
    const bool failed = fault_set_any(fast->trips.faults);
    guard_step_each(&fast->trips, &orders.tuning->guard, &input);
    fast->report.failed = fault_set_both(fast->report.failed, fast->trips.faults);
    if (!failed && fault_set_any(fast->trips.faults)) {
        fast_stop(fast, guard_reason(fast->trips.faults));
    }
}

/* A current sensor whose value does not change while control requires another current. The medium task would
 * detect it too late. */
static void watch_still(fast_t *fast, fast_orders_t orders)
{
    const still_watch_tuning_t *tuning = &orders.tuning->still_watch;
    const abc_t *current = &fast->measure.measured.current_abc;
    if (still_watch_count(&fast->still_watch, tuning, current) &&
        (moments(&fast->bridge, orders.setpoint) & GUARD_RUNNING) != 0u) {
        const dq_t asked = fast->demand.current;
        const still_watch_input_t input = {
            .asked = frames_inverse_clarke(frames_inverse_park(asked, fast->demand.frame.rotation)),
            .current = *current,
            .voltage = fast->acted.voltage,
            .omega_e = fast->rotor.omega_e,
            .u_dc = fast->measure.measured.u_dc,
            .limited = fast->control.limited != 0u,
        };
        if (still_watch_judge(&fast->still_watch, tuning, &input)) {
            fast_stop(fast, REASON_CURRENT_STUCK);
        }
    }
    still_watch_remember(&fast->still_watch, &fast->acted.voltage);
}

/* Evaluates the rows of the fault table of each period. true: control has left the encoder. */
bool fast_trip(fast_t *fast, fast_orders_t orders)
{
    const int32_t left = fast->report.left;
    const uint32_t encoder_wrong = watch_jump(fast, orders);
    find_gates_on(&fast->bridge, fast->measure.measured.flags);
    const guard_input_t input = trip_input(fast, orders.setpoint, encoder_wrong);
    if (!guard_is_calm(&fast->trips, &orders.tuning->guard, &input, FAULT_EACH)) {
        judge_trips(fast, orders,
                    encoder_wrong); /* builds the input again: a kept one would be stored in each period */
    }
    watch_still(fast, orders);
    return fast->report.left != left;
}
