#include "estimator/estimator.h"

#include "math/angle.h"
#include "math/bounds.h"
#include "math/root.h"
#include "math/trig.h"

/* Copies the state of the observer after a step to the output. The forms per axis belong to the paper's
 * modes. */
static inline void show_observer(estimator_t *est)
{
    const smo_t *smo = &est->observer.smo;
    observed_t *observed = &est->observed;
    observed->current_err = (ab_t){smo->current_err.alpha, smo->current_err.beta};
    observed->emf_hat = (ab_t){smo->emf_hat.alpha, smo->emf_hat.beta};
    observed->gain = smo->gain_mean;
    if (est->observer.paper != 0u) {
        observed->gain_axis = smo->axes.gain_axis;
    }
}

/* Copies the state of the tracker; its rotation is already that of the next step. */
static inline void show_tracker(estimator_t *est, position_t position)
{
    const pll_t *pll = &est->tracker.pll;
    estimate_t *estimate = &est->estimate;
    estimate->frame.theta_e = position.theta_e;
    estimate->frame.omega_e = position.omega_e;
    estimate->omega_smooth = pll->omega_smooth;
    estimate->emf_loop = (dq_t){pll->emf.d, pll->emf.q};
    estimate->amplitude = pll->amplitude;
    estimate->detector = pll->detector;
    estimate->flux = est->tracker.motor.flux_emf;
    estimate->cross = est->tracker.motor.cross;
    estimate->invalid = est->tracker.validity.debounce.invalid;
}

void estimator_reset(estimator_t *est, position_t start, ab_t current)
{
    const position_t rotor = {angle_wrap(start.theta_e), start.omega_e};
    const rotation_t rotation = trig_turn(rotor.theta_e);
    const dq_t current_rotor = frames_park(current, rotation);
    const float length = tracker_flux(&est->tracker, current_rotor.d) * start.omega_e;
    const float bent = tracker_cross(&est->tracker, current_rotor.q) * start.omega_e;
    const ab_t emf = {-length * rotation.sin - bent * rotation.cos,
                      length * rotation.cos - bent * rotation.sin};
    const float added = observer_reset(&est->observer, start.omega_e, current, emf);
    tracker_reset(&est->tracker, (position_t){rotor.theta_e + added, start.omega_e}, current_rotor,
                  bounds_magnitude(length));
    est->current = current;
    show_observer(est);
    show_tracker(est, rotor);
    est->observed.gain_axis = est->observer.smo.axes.gain_axis;
    est->estimate.frame.rotation = rotation;
    est->estimate.emf = emf;
    est->estimate.coasted = 0u;
    est->rested = 0u;
}

/* Action of the tracker in a period. */
typedef enum {
    TRACK,
    COAST, /* the voltage is not suitable for tracking */
    REST   /* no action: only the observer runs */
} tracking_t;

/* The end of a period in which the loop rests: length of the observed EMF, if there is one. */
static inline void rested(estimator_t *est, bool good, ab_t emf)
{
    estimate_t *estimate = &est->estimate;
    est->rested = 1u;
    if (good) {
        const float square = emf.alpha * emf.alpha + emf.beta * emf.beta;
        estimate->amplitude = square * inverse_root(square);
        estimate->detector = 0.0f;
        estimate->invalid = est->tracker.validity.debounce.invalid;
    }
    estimate->coasted = 1u;
}

/* The voltage [V] with which the winding with L_q acts like one with L_d in every direction. */
static inline ab_t at_rest(const estimator_t *est, ab_t current, ab_t voltage)
{
    const float rate = est->tracker.saliency_rate;
    return (ab_t){voltage.alpha + rate * (current.alpha - est->current.alpha),
                  voltage.beta + rate * (current.beta - est->current.beta)};
}

/* One period, with the lag of this speed [rad/s]. */
static void one_period(estimator_t *est, ab_t voltage, ab_t current, float omega_e, tracking_t tracking)
{
    tracker_t *tracker = &est->tracker;
    estimate_t *estimate = &est->estimate;
    const bool salient = tracker_is_salient(tracker);
    const dq_t current_loop = frames_park(current, tracker->pll.rotation);
    if (salient) {
        voltage = tracking == REST ? at_rest(est, current, voltage)
                                   : tracker_transient(tracker, current_loop, voltage);
    }
    ab_t emf;
    float error_square;
    const bool good = observer_step(&est->observer, voltage, current, omega_e, &emf, &error_square);
    if (good) {
        est->current = (ab_t){current.alpha, current.beta};
        show_observer(est);
        estimate->emf = emf;
    }
    if (tracking == REST) {
        rested(est, good, emf);
        return;
    }
    if (salient && good) {
        tracker_follow(tracker, current_loop);
        if (saturation_is_on(&tracker->saturation)) {
            emf = tracker_straighten(tracker, emf);
        }
    }
    /* the last step has turned it to t_k */
    estimate->frame.rotation = (rotation_t){tracker->pll.rotation.sin, tracker->pll.rotation.cos};
    if (good && tracking == TRACK) {
        show_tracker(est, tracker_step(tracker, emf, current_loop.q));
        estimate->coasted = 0u;
        return;
    }
    const position_t position = good ? tracker_watch(tracker, emf, current_loop.q) : tracker_coast(tracker);
    show_tracker(est, position);
    estimate->invalid |= good ? 0u : ESTIMATOR_SAMPLE;
    estimate->coasted = 1u;
}

/* The result of a step. */
static inline position_t shown(const estimator_t *est)
{
    return (position_t){est->estimate.frame.theta_e, est->estimate.frame.omega_e};
}

void estimator_track(estimator_t *est, ab_t voltage, ab_t current)
{
    one_period(est, voltage, current, est->tracker.pll.omega_e, TRACK);
}

position_t estimator_step(estimator_t *est, ab_t voltage, ab_t current)
{
    estimator_track(est, voltage, current);
    if (est->estimate.coasted == 0u) {
        tracker_judge(&est->tracker, smo_error_square(&est->observer.smo));
        est->estimate.invalid = est->tracker.validity.debounce.invalid;
    }
    return shown(est);
}

position_t estimator_coast(estimator_t *est, ab_t voltage, ab_t current)
{
    one_period(est, voltage, current, est->tracker.pll.omega_e, COAST);
    return shown(est);
}

void estimator_observe(estimator_t *est, ab_t voltage, ab_t current, float omega_e)
{
    one_period(est, voltage, current, omega_e, REST);
}

void estimator_lock(estimator_t *est, position_t start, float amplitude)
{
    estimate_t *estimate = &est->estimate;
    estimate->frame.rotation = trig_turn(start.theta_e);
    const dq_t current = frames_park(est->current, estimate->frame.rotation);
    float length = amplitude;
    if (est->rested != 0u) { /* the EMF of a winding with L_d; that of L_q has psi_a in place of psi_f */
        const float flux = tracker_flux(&est->tracker, current.d) - est->tracker.flux_linkage;
        length += flux * bounds_magnitude(start.omega_e);
        est->rested = 0u;
    }
    tracker_reset(&est->tracker, start, current, length);
    pll_reset_feedforward(&est->tracker.pll, est->tracker.motor.speed_per_volt);
    show_tracker(est, start);
}

uint16_t estimator_invalid(const estimator_t *est)
{
    return (uint16_t)est->estimate.invalid;
}
