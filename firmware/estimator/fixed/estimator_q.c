#include "estimator/fixed/estimator_q.h"

#include <stdbool.h>

#include "math/root_q.h"
#include "math/trig_q.h"

#define AMPLITUDE_RATIO_Q 24

/* Per axis, k_f depends on the required v, and v on k_f: a few iterations converge. */
#define RESET_ROUNDS 8

void estimator_take_q(estimator_q_t *est, const estimator_tuning_q_t *tuning)
{
    est->tuning = *tuning;
    est->speed_per_volt = tuning->speed_per_volt;
    smo_take_q(&est->smo, &tuning->smo);
    pll_take_q(&est->pll, &tuning->pll);
}

/* psi_f omega_e. */
static int32_t emf_length(const estimator_q_t *est, int32_t omega_e)
{
    root_q_t per_speed = reciprocal_q(est->speed_per_volt);
    return q_clamp(quotient_q(omega_e, per_speed, SPEED_PER_VOLT_Q + VOLTAGE_Q - SPEED_Q), SAMPLE_LARGEST);
}

/* The switching functions of the paper. */
static void reset_axes(smo_q_t *smo, int32_t omega_e, ab_q_t current, ab_q_t emf)
{
    smo_reset_q(smo, current, emf);
    for (int32_t n = 0; n < RESET_ROUNDS; n++) {
        smo_reset_q(smo, current, lag_switched_q(smo, omega_e, emf));
    }
}

/* The same as observer_reset(). */
static uint32_t reset_observer(estimator_q_t *est, int32_t omega_e, ab_q_t current, ab_q_t emf)
{
    smo_q_t *smo = &est->smo;
    if (smo->tuning.switching == (int32_t)SMO_SIGMOID_VECTOR) {
        smo_reset_error_q(smo, current, lag_error_q(smo, omega_e, emf));
    } else {
        reset_axes(smo, omega_e, current, emf);
    }
    if (smo->tuning.emf_decay > 0) {
        smo->emf_hat = lag_filtered_q(smo, omega_e, smo->switched);
    }
    est->emf = emf;
    const lag_mode_t mode = (lag_mode_t)est->tuning.lag;
    return mode == LAG_EXACT ? 0u : lag_angle_q(smo, mode, omega_e) - lag_angle_q(smo, LAG_EXACT, omega_e);
}

static void reset_tracker(estimator_q_t *est, position_q_t start, int32_t amplitude)
{
    est->load = 0;
    pll_reset_q(&est->pll, start);
    pll_reset_emf_q(&est->pll, amplitude);
    (void)pll_coast_q(&est->pll, 0);
    debounce_reset(&est->debounce);
}

void estimator_lock_q(estimator_q_t *est, position_q_t start, int32_t amplitude)
{
    reset_tracker(est, start, amplitude);
    pll_reset_feedforward_q(&est->pll, est->speed_per_volt);
}

void estimator_reset_q(estimator_q_t *est, position_q_t start, ab_q_t current)
{
    int32_t length = emf_length(est, start.omega_e);
    rotation_q_t rotor = trig_rotation_q(start.theta_e);
    ab_q_t emf = {q_clamp(q_multiply(-length, rotor.sin, UNIT_Q), SAMPLE_LARGEST),
                  q_clamp(q_multiply(length, rotor.cos, UNIT_Q), SAMPLE_LARGEST)};

    uint32_t added = reset_observer(est, start.omega_e, current, emf);
    reset_tracker(est, (position_q_t){start.theta_e + added, start.omega_e}, q_magnitude(length));
    est->coasted = 0u;
}

/* The criteria that fail in this period. */
static uint32_t failing(const estimator_q_t *est)
{
    const estimator_tuning_q_t *limits = &est->tuning;
    int32_t speed = q_magnitude(est->pll.omega_smooth);
    int32_t speed_of_emf =
        q_multiply_saturated(est->pll.amplitude, est->speed_per_volt, VOLTAGE_Q + SPEED_PER_VOLT_Q - SPEED_Q);
    int64_t least = q_round(q_product(speed, limits->amplitude_min), UNIT_Q) - limits->amplitude_allowance;
    int64_t most =
        q_round(q_product(speed, limits->amplitude_max), AMPLITUDE_RATIO_Q) + limits->amplitude_allowance;
    ab_q_t x = est->smo.current_err;
    return (speed_of_emf < least || speed_of_emf > most ? ESTIMATOR_AMPLITUDE : 0u) |
           (q_magnitude(est->pll.detector) > limits->detector_max ? ESTIMATOR_DETECTOR : 0u) |
           (q_square_sum(x.alpha, x.beta) > q_square(limits->current_max) ? ESTIMATOR_CURRENT : 0u) |
           (speed < limits->speed_min || speed > limits->speed_max ? ESTIMATOR_SPEED : 0u);
}

/* Acceleration by the torque: K (i_q - i_L), i_q of the rotor in the frame of the loop; Q63. The difference
 * is limited to the range of a sample, so that the sum with the other changes of the loop's speed in a period
 * has no overflow. */
static int64_t acceleration_of(const estimator_q_t *est, ab_q_t current)
{
    const int32_t accelerating = frames_park_q(current, est->pll.rotation).q - est->load;
    return q_product(est->tuning.torque_feedforward, q_clamp(accelerating, SAMPLE_LARGEST));
}

/* The same as step() of estimator.c. */
static position_q_t one_period_q(estimator_q_t *est, ab_q_t voltage, ab_q_t current, bool doubtful)
{
    (void)smo_step_q(&est->smo, voltage, current);
    if (est->smo.rejected != 0u) {
        est->coasted = 1u;
        return pll_coast_q(&est->pll, 0);
    }
    est->emf = lag_emf_q(&est->smo, (lag_mode_t)est->tuning.lag, est->pll.omega_e);
    est->coasted = doubtful;

    /* The clamp has no effect, but the value analysis needs it to derive the range. */
    const ab_q_t measured = {q_clamp(current.alpha, SAMPLE_LARGEST), q_clamp(current.beta, SAMPLE_LARGEST)};
    const int64_t acceleration = acceleration_of(est, measured);
    if (doubtful) {
        return pll_watch_q(&est->pll, est->emf, acceleration);
    }
    const position_q_t position = pll_step_q(&est->pll, est->emf, est->speed_per_volt, acceleration);
    debounce_step(&est->debounce, &est->tuning.debounce, failing(est));
    return position;
}

position_q_t estimator_step_q(estimator_q_t *est, ab_q_t voltage, ab_q_t current)
{
    return one_period_q(est, voltage, current, false);
}

position_q_t estimator_coast_q(estimator_q_t *est, ab_q_t voltage, ab_q_t current)
{
    return one_period_q(est, voltage, current, true);
}

void estimator_observe_q(estimator_q_t *est, ab_q_t voltage, ab_q_t current, int32_t omega_e)
{
    (void)smo_step_q(&est->smo, voltage, current);
    if (est->smo.rejected == 0u) {
        est->emf = lag_emf_q(&est->smo, (lag_mode_t)est->tuning.lag, omega_e);
    }
    est->coasted = 1u;
}

uint32_t estimator_invalid_q(const estimator_q_t *est)
{
    return est->debounce.invalid | (est->smo.rejected != 0u ? ESTIMATOR_SAMPLE : 0u);
}
