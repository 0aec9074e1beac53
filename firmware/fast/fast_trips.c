/* The rare parts of fast_trips.h. */
#include "fast/fast_trips.h"

#include <float.h>

#include "settings/reasons.h"

/* [-] of psi_f omega m: half of the EMF beside the encoder's angle if the rotor has followed the prediction.
 * Its share of psi_f omega m is sin(m)/m, 0.84 or more up to the largest m [rad], above which a rotor that
 * brakes cannot come: at the least jump the loop follows it. An EMF that is wrong by a third does not change
 * the result. */
#define BRAKED_EMF  0.5f
#define BRAKED_MOST 1.0f

#define FORCED_DOUBT 8.0f /* [-] four times twice the EMF, with the opposite direction */

void fast_open_bridge(fast_t *fast, uint32_t window)
{
    if (fast->bridge.open == 0u) {
        fast->bridge.open = 1u;
        fast->bridge.open_since = window;
        fast->bridge.outputs.permitted =
            0u; /* the chopper is off as well, until a setpoint has judged the reason */
    }
}

void fast_stop(fast_t *fast, int32_t reason)
{
    const measured_t *measured = &fast->measure.measured;
    fast_open_bridge(fast, fast->report.number);
    if (fast->report.window.stop.reason == (int32_t)REASON_NONE) {
        fast->report.window.stop = (drive_fault_t){
            .reason = reason,
            .period = fast->period,
            .i_a = measured->current_abc.a,
            .i_b = measured->current_abc.b,
            .u_dc = measured->u_dc,
            .theta_e = fast->rotor.theta_e,
            .omega_e = fast->rotor.omega_e,
        };
        fast->report.window.source = fast->reference.source;
    }
}

/* True if the rotor itself is behind the prediction, because a load has stopped it within the lag of the
 * encoder's loop. Either the encoder or the prediction is right, and the EMF decides. Beside the encoder's
 * angle, along its d axis, it is
 *
 *     0                    at any speed, if the rotor is where the encoder is
 *     psi_f omega sin(m)   if it has followed the prediction, from which the encoder differs by m */
static bool is_braking(const fast_t *fast, fast_orders_t orders)
{
    const encoder_t *encoder = &fast->encoder;
    const rotation_t axis = fast->shaft.frame.rotation;
    const ab_t emf = fast->estimator.estimate.emf;
    const float beside = emf.alpha * axis.cos + emf.beta * axis.sin;
    const float followed = orders.setpoint->models.flux_linkage * encoder->omega_e * encoder->missed;
    return fast->estimating != 0u && bounds_within(encoder->missed, BRAKED_MOST) &&
           beside > BRAKED_EMF * followed && encoder_may_brake(encoder, &orders.tuning->encoder);
}

/* The loop continues with the rotor's own speed, that of its motion in the last period: the prediction would
 * still be wrong for the lag of the loop, and current control would compensate an EMF that has gone. The
 * frame of the last demand is that of the encoder at t_k-1. */
static void follow_rotor(fast_t *fast, fast_orders_t orders)
{
    const float moved = angle_wrap(fast->shaft.frame.theta_e - fast->demand.frame.theta_e);
    const float omega_e = moved * (1.0f / DRIVE_PERIOD);
    encoder_follow(&fast->encoder, &orders.tuning->encoder, fast->measure.measured.encoder_count, omega_e);
    fast->shaft.position.omega_e = omega_e;
    fast->shaft.frame.omega_e = omega_e;
    fast_update_rotor(fast, orders);
}

uint32_t fast_watch_jump(fast_t *fast, fast_orders_t orders)
{
    const setpoint_t *setpoint = orders.setpoint;
    const bool watched = setpoint->jump != (int32_t)JUMP_IGNORED &&
                         (fast->measure.measured.flags & DRIVE_SAMPLE_LATE) == 0u; /* unknown rotation */
    if (!watched || !encoder_jumped(&fast->encoder, orders.tuning->limits.jump)) {
        return 0u;
    }
    if (is_braking(fast, orders)) {
        follow_rotor(fast, orders);
        return 0u;
    }
    if (setpoint->jump == (int32_t)JUMP_OPENS) {
        return ENCODER_WATCH_JUMP;
    }
    const bool to_estimate = setpoint->jump == (int32_t)JUMP_TO_ESTIMATE;
    fast->report.window.left = setpoint->jump;
    reference_leave_encoder(&fast->reference, to_estimate, fast->estimator.estimate.omega_smooth,
                            setpoint->jump_periods);
    fast_update_rotor(fast, orders);
    return 0u;
}

/* The reason of the rows that have failed. The speed of the encoder's loop follows a step of its angle, too:
 * a step that is too small to count as a jump makes an overspeed of some milliseconds. The loop then returns
 * from a speed that the rotor never had: the angle stays behind its prediction by more than any braking
 * explains. */
static int32_t reason_of(const fast_t *fast, const fast_limits_t *limits)
{
    const int32_t reason = guard_reason(fast->trips.faults);
    const float behind = fast->omega_m < 0.0f ? fast->encoder.missed : -fast->encoder.missed;
    const bool steps = fast->reference.source == (int32_t)SOURCE_ENCODER && behind > limits->settled;
    return reason == (int32_t)REASON_OVERSPEED && steps ? (int32_t)REASON_ENCODER_JUMP : reason;
}

void fast_judge_trips(fast_t *fast, fast_orders_t orders, const drive_samples_t *samples,
                      uint32_t encoder_wrong)
{
    guard_input_t input = fast_trip_input(fast, orders.setpoint, encoder_wrong);
    measured_t expected;
    if (fast->measure.measured.good == 0u) {
        const float trip = orders.tuning->guard.limit[FAULT_LIMIT_OVERCURRENT];
        expected = fast->measure.measured;
        expected.current_abc = measure_expected(&fast->measure, samples, trip);
        input.measured = &expected;
    }
    /* The medium task judges a loop that has lost the rotor, and catches the rotor again. The first speeds of
     * a catch may be twice too large. */
    const bool denied = reference_tracks(&fast->reference) && estimate_is_denied(&fast->estimator.estimate);
    const bool begins = fast->reference.source == (int32_t)SOURCE_CATCH &&
                        fast->reference.catching.periods < orders.tuning->reference.catching.settled;
    input.omega_m = denied || begins ? 0.0f : input.omega_m;
    const bool failed = fault_set_any(fast->trips.faults);
    guard_step_each(&fast->trips, &orders.tuning->guard, &input);
    if (!fault_set_any(fast->trips.faults)) {
        return;
    }
    fast->report.window.failed = fault_set_both(fast->report.window.failed, fast->trips.faults);
    if (!failed) {
        fast_stop(fast, reason_of(fast, &orders.tuning->limits));
    }
}

/* Four times the largest error of the assumed EMF, for the judgement of a constant value [V]. A tracked rotor
 * has a psi_f that is wrong by 20 %, and an angle that has some error. In a forced frame the EMF may have any
 * direction. In a catch its speed is unknown. */
static float doubt_of(const fast_t *fast, float emf)
{
    const reference_t *reference = &fast->reference;
    if (reference_tracks(reference) || reference->source == (int32_t)SOURCE_ENCODER) {
        return bounds_magnitude(emf);
    }
    return reference->source == (int32_t)SOURCE_FORCED ? FORCED_DOUBT * bounds_magnitude(emf) : FLT_MAX;
}

/* Whether the law of the winding excludes an open wire. */
static bool is_wired(const fast_t *fast, fast_orders_t orders, uint32_t found)
{
    const frame_t *rotor = &fast->rotor;
    const float emf = orders.setpoint->models.flux_linkage * rotor->omega_e;
    const still_watch_winding_t winding = {
        .current = &fast->measure.measured.current_abc,
        .before = &fast->measure.before,
        .voltage = &fast->acted.voltage,
        .emf = {-emf * rotor->rotation.sin, emf * rotor->rotation.cos},
        .doubt = doubt_of(fast, emf),
        .u_dc = fast->measure.measured.u_dc,
    };
    return still_watch_is_wired(&orders.tuning->still_watch, found, &winding);
}

/* True while pulses of commissioning test the wires, and a phase carries no current: the answers to all
 * pulses decide whether its wire is open or a sensor is stuck (medium/commission/wiring_map.h). */
static bool tests_wires(const fast_t *fast, fast_orders_t orders)
{
    return orders.setpoint->excite.kind == (int32_t)EXCITE_PULSE &&
           still_watch_is_alone(&orders.tuning->still_watch, &fast->measure.measured.current_abc);
}

/* Reacts to a value that did not change although it had to, STILL_WATCH_... bits. */
static void react_to_still(fast_t *fast, fast_orders_t orders, uint32_t found)
{
    if (tests_wires(fast, orders)) {
        still_watch_forget(&fast->still_watch);
    } else if ((found & STILL_WATCH_STUCK) != 0u || is_wired(fast, orders, found)) {
        fast_stop(fast, REASON_CURRENT_STUCK);
    }
}

void fast_judge_still(fast_t *fast, fast_orders_t orders)
{
    const still_watch_input_t input = {
        .asked = frames_inverse_park(fast->demand.current, fast->demand.frame.rotation),
        .current = &fast->measure.measured.current_abc,
        .noise = measure_noise(&fast->measure),
        .voltage = &fast->acted.voltage,
        .omega_e = fast->rotor.omega_e,
        .u_dc = fast->measure.measured.u_dc,
        .limited = fast->control.limited != 0u,
    };
    const uint32_t found = still_watch_judge(&fast->still_watch, &orders.tuning->still_watch, &input);
    if (found != 0u) {
        react_to_still(fast, orders, found);
    }
}
