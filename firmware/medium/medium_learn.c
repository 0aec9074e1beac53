/* The learning of values of motor, inverter and sensors, from the sums of a window. */
#include "medium/medium_parts.h"

#include "math/bounds.h"
#include "math/trig.h"
#include "math/winding.h"

/* From the middle of the periods of a mean to their end [s]. */
#define TO_MIDDLE (0.5f * (float)(DRIVE_WINDOW - 1u) * DRIVE_PERIOD)

/* From the end of a window to the middle of the time in which the voltage of its setpoint acts [windows]. */
#define TO_ACTING 1.5f

/* Judges whether the estimate is valid, by the criteria of estimator/validity.h: once per window, at its last
 * period, if the loop tracked in that period. The judgement restarts with the loop,
 * and when control takes over its estimate. */
static void judge_estimate(medium_t *medium, const window_t *window)
{
    const estimate_t *estimate = &window->estimate;
    const ab_t error = window->current_err;
    if (window->tracking == 0u || manoeuvres_begins_run(&medium->manoeuvres)) {
        validity_reset(&medium->trust.validity);
    } else if (estimate->coasted == 0u) {
        validity_step(&medium->trust.validity, estimate->omega_smooth, estimate->amplitude / estimate->flux,
                      estimate->detector, error.alpha * error.alpha + error.beta * error.beta);
    }
}

/* true: the rotor turns so little in a window that its mean shows the vectors in the rotor's frame. */
static inline bool turns_little(float omega_e)
{
    return bounds_within(DRIVE_WINDOW_PERIOD * omega_e, WINDING_TURN_MOST);
}

/* The means of the window, in the stationary frame and in the rotor's; medium->estimate: the estimate at the
 * end of the window. In the frame of a fast rotor the values are those of the last period, and no value is
 * learnt from them. */
static void average(medium_t *medium, const window_t *window)
{
    const estimate_t *estimate = &window->estimate;
    const bool slow = turns_little(estimate->omega_smooth);
    const sums_t sums = {
        .emf = window->sum.emf,
        .current = window->sum.current,
        .unsound = window->sum.unsound | medium->trust.validity.debounce.invalid | (slow ? 0u : 1u),
    };
    sums_mean(&sums, 1.0f / (float)DRIVE_WINDOW, estimate->frame.rotation, estimate->omega_smooth, TO_MIDDLE,
              &medium->means);
    if (!slow) {
        medium->means.emf_rotor = frames_park(estimate->emf, estimate->frame.rotation);
        medium->means.current_rotor = frames_park(window->measured.current, estimate->frame.rotation);
    }
    medium->means.theta = estimate->frame.theta_e;
    medium->means.even = manoeuvres_even(&medium->manoeuvres) ? 1u : 0u;
    medium->estimate = *estimate;
    medium->estimate.invalid =
        medium->trust.validity.debounce.invalid | (estimate->invalid & ESTIMATOR_SAMPLE);
    medium->estimate.coasted = window->sum.tracked < window->sum.periods ? UINT32_C(1) : UINT32_C(0);
}

/* Learns the offsets of the current sensors and psi_f, only while the loop tracks. */
static void learn_slowly(medium_t *medium, const window_t *window)
{
    const estimate_t *estimate = &window->estimate;
    const float share = 1.0f / (float)DRIVE_WINDOW;
    if (window->tracking == 0u) {
        return;
    }
    if (medium->flux.tuning.share > 0.0f && medium->estimate.coasted == 0u) {
        flux_step(&medium->flux, estimate->amplitude, estimate->omega_smooth, estimate->detector);
    }
    const offset_trim_input_t input = {
        .emf_hat = {share * window->sum.emf_hat.alpha, share * window->sum.emf_hat.beta},
        .current = window->measured.current,
        .rotor = estimate->frame.rotation,
        .theta_e = estimate->frame.theta_e,
        .omega_e = estimate->omega_smooth,
        .cross = estimate->cross,
    };
    (void)offset_trim_step(&medium->offset_trim, &input);
}

/* Learns the inertia from the change of the speed, and which part of the current carries the load: the
 * tracking loop does not get this part as a torque. */
static void learn_inertia(medium_t *medium, const window_t *window)
{
    inertia_t *inertia = &medium->inertia;
    if (medium->inertia.tuning.on == 0u) {
        return;
    }
    if (medium->manoeuvres.tracking == 0u) {
        inertia_rest(inertia);
        return;
    }
    const inertia_input_t input = {
        .omega_ref = medium->manoeuvres.limits.pole_pairs * window->omega_m_ref,
        .omega = medium->means.omega,
        .i_q = (medium->means.current_rotor.q * window->estimate.flux -
                medium->means.current_rotor.d * window->estimate.cross) *
               medium->flux.speed_per_volt,
    };
    if (medium->means.unsound != 0u || !manoeuvres_steady(&medium->manoeuvres)) {
        inertia_spoil(inertia);
    }
    inertia_step(inertia, &input);
}

/* Learns the dead time from the EMF, for the next duties and for the voltage that is applied from now on. The
 * only requirement is a frame that turns evenly with the rotor, forced or tracked: not a catch. */
static void learn_dead_time(medium_t *medium, const window_t *window)
{
    if (!(medium->dead_time_learn.tuning.rate > 0.0f)) {
        return;
    }
    if (medium->means.even == 0u) {
        dead_time_learn_pause(&medium->dead_time_learn);
        return;
    }
    const float pole_pairs = medium->manoeuvres.limits.pole_pairs;
    const dead_time_learn_input_t input = {
        .emf = medium->means.emf,
        .current = medium->means.current,
        .omega_e = pole_pairs * window->omega_m,
        .omega_e_ref = pole_pairs * window->omega_m_ref,
        .link = window->link.mean,
        .noise = window->sensors.noise,
        .model = window->tracking,
        .forced = manoeuvres_forces(&medium->manoeuvres),
    };
    dead_time_learn_step(&medium->dead_time_learn, &input);
}

/* Learns the shape of the EMF, once the dead time is nearly known, and the differences of the legs, once it
 * is known, both from the EMF of the dead time. Computes their part that is subtracted for the estimator.
 * These voltages turn little in a window, so the mean of each window is sufficient. */
static void learn_ripple(medium_t *medium, const window_t *window)
{
    const dead_time_learn_t *learn = &medium->dead_time_learn;
    const bool tracking = window->tracking != 0u;
    const float omega = tracking ? medium->means.omega : window->frame.omega_e;
    const float share = tracking ? emf_shape_share(omega) : 0.0f;
    const float legs_share = unequal_legs_share(omega);
    if (learn->seen > 0.0f && dead_time_learn_is_near(learn)) {
        const emf_shape_input_t shape = {
            .emf_mean = learn->emf_mean,
            .rest = learn->rest,
            .omega_e = medium->manoeuvres.limits.pole_pairs * window->omega_m_ref,
            .time = learn->seen,
            .taken = share,
        };
        const unequal_legs_input_t legs = {
            .rest = learn->rest,
            .current = medium->means.current,
            .time = learn->seen,
            .taken = legs_share,
        };
        emf_shape_step(&medium->ripple.emf_shape, &shape);
        if (dead_time_learn_is_settled(learn)) {
            unequal_legs_step(&medium->ripple.unequal_legs, &legs);
        }
    }
    const float period = DRIVE_WINDOW_PERIOD;
    const float ahead = TO_ACTING * period;
    const float within = bounds_clamp(omega, EMF_SHAPE_SPEED_MOST); /* nothing is subtracted above it */
    const rotation_t rotor = trig_advance(window->estimate.frame.rotation, ahead * within);
    const ab_t shape = emf_shape_voltage(&medium->ripple.emf_shape, share * omega, rotor);
    const float turns = (TO_MIDDLE + ahead) * bounds_clamp(omega, UNEQUAL_LEGS_SPEED_MOST);
    const ab_t current = frames_inverse_park((dq_t){medium->means.current.alpha, medium->means.current.beta},
                                             trig_turn(turns));
    const ab_t legs = unequal_legs_voltage(&medium->ripple.unequal_legs, legs_share, current);
    medium->ripple.spared = (ab_t){shape.alpha + legs.alpha, shape.beta + legs.beta};
}

/* Learns L from the response of a locked loop without encoder to the dither, and computes the next dither. */
static void learn_inductance(medium_t *medium, const window_t *window)
{
    if (!(medium->inductance.tuning.rate > 0.0f)) {
        return;
    }
    if (!manoeuvres_dithers(&medium->manoeuvres) || !turns_little(medium->means.omega)) {
        inductance_rest(&medium->inductance);
        return;
    }
    const inductance_input_t input = {
        .emf = medium->means.emf_rotor,
        .current = medium->means.current_rotor,
        .detector = window->estimate.detector,
        .omega_smooth = medium->means.omega,
        .theta = medium->means.theta,
        .flux = window->estimate.flux,
        .sound = medium->means.unsound == 0u,
        .voltage_known = dead_time_learn_is_settled(&medium->dead_time_learn),
    };
    inductance_step(&medium->inductance, &input);
}

/* The voltage that was applied is not known. */
static void pause(medium_t *medium)
{
    const ab_t none = {0.0f, 0.0f};
    inductance_rest(&medium->inductance);
    dead_time_learn_pause(&medium->dead_time_learn);
    medium->ripple.spared = none;
    medium->means = (means_t){none, none, {0.0f, 0.0f}, {0.0f, 0.0f}, 0.0f, 0.0f, 0u, 0u};
}

/* The uncertainty of the angle that the drive uses. */
static void judge_angle(medium_t *medium, const medium_tuning_t *tuning, const window_t *window)
{
    const dead_time_learn_t *legs = &medium->dead_time_learn;
    const inductance_t *inductance = &medium->inductance;
    const bool encoder = medium->manoeuvres.sensorless == 0u;
    if (encoder || window->tracking == 0u || window->estimating == 0u) {
        angle_sigma_reset(&medium->trust.sigma, encoder ? tuning->angle_sigma.encoder : ANGLE_SIGMA_UNKNOWN);
        return;
    }
    const angle_sigma_input_t input = {
        .amplitude = window->estimate.amplitude,
        .omega_e = medium->means.omega,
        .current = medium->means.current_rotor,
        .emf = medium->means.emf_rotor,
        .scatter = 1.0f / (float)DRIVE_WINDOW * window->sum.scatter,
        .noise = turns_little(medium->means.omega) ? 1.0f / (float)DRIVE_WINDOW : 1.0f,
        .link = window->link.mean,
        .leg_rate = legs->rate,
        .inductance_rate = inductance->rate,
        .resistance_rate = inductance->resistance_rate,
        .coasted = medium->estimate.coasted,
    };
    angle_sigma_step(&medium->trust.sigma, &tuning->angle_sigma, &input);
}

void medium_learn(medium_t *medium, const medium_tuning_t *tuning, const window_t *window)
{
    const ab_t none = {0.0f, 0.0f};
    if (medium->sequence.state == (int32_t)DRIVE_NOT_READY || window->sensors.offsets != 0u) {
        offset_trim_reset(&medium->offset_trim, none);
    }
    if (window->estimating == 0u) {
        pause(medium);
        judge_angle(medium, tuning, window);
        return;
    }
    judge_estimate(medium, window);
    average(medium, window);
    learn_slowly(medium, window);
    learn_inertia(medium, window);
    learn_dead_time(medium, window);
    learn_ripple(medium, window);
    learn_inductance(medium, window);
    judge_angle(medium, tuning, window);
}

learnt_t medium_learnt(const medium_t *medium, float noise_square)
{
    const bool calibrated = medium->sequence.state > (int32_t)DRIVE_NOT_READY;
    return (learnt_t){
        .resistance = medium->inductance.resistance,
        .inductance_q = medium->inductance.learnt,
        .inertia = medium->inertia.learnt,
        .noise_square = calibrated ? noise_square : 0.0f,
    };
}
