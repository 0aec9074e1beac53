#include "estimator/fixed/estimator_q.h"

#include <stdbool.h>

#include "math/root_q.h"
#include "math/trig_q.h"

#define AMPLITUDE_RATIO_Q 24

#define ADAPTATION_DETECTOR Q_CONST(UNIT_Q, ESTIMATOR_ADAPTATION_DETECTOR)

/* Bits of `special`: why a step is not the shortest one, as estimator.c. */
#define FRESH   UINT32_C(1) /* no step yet since the reset */
#define COASTED UINT32_C(2) /* the last period was not tracked */
#define PAPER                                                                                                \
    UINT32_C(4) /* a switching function per axis, a filter ahead of the loop, a lag of the paper             \
                 */
#define ADAPTING UINT32_C(8) /* the flux adapts */

/* k_f depends on the EMF that the observer has to make, and that on k_f: a few rounds settle both. */
#define RESET_ROUNDS 8

void estimator_retune_q(estimator_q_t *est, const estimator_params_q_t *params)
{
    bool another = params->speed_per_volt != est->params.speed_per_volt || params->adaptation_share == 0;
    bool direct = params->lag == (int32_t)LAG_EXACT && params->smo.switching == (int32_t)SMO_SIGMOID_VECTOR &&
                  params->smo.filtering == 0u;
    est->params = *params;
    est->special = (est->special & (FRESH | COASTED)) | (direct ? 0u : PAPER) |
                   (params->adaptation_share != 0 ? ADAPTING : 0u);
    est->speed_per_volt.alpha = params->adaptation_share;
    est->emf_mean.alpha = params->mean_share;
    est->speed_mean.alpha = params->mean_share;
    if (another) {
        lowpass_reset_q(&est->speed_per_volt, params->speed_per_volt);
    }
    smo_retune_q(&est->smo, &params->smo);
    pll_retune_q(&est->pll, &params->pll);
}

void estimator_init_q(estimator_q_t *est, const estimator_params_q_t *params)
{
    const position_q_t origin = {0u, 0};
    const ab_q_t none = {0, 0};
    est->params.speed_per_volt = 0;
    est->special = 0u;
    estimator_retune_q(est, params);
    lowpass_reset_q(&est->speed_per_volt, params->speed_per_volt);
    smo_init_q(&est->smo, &params->smo);
    pll_init_q(&est->pll, &params->pll);
    estimator_reset_q(est, origin, none);
}

/* psi_f omega_e. */
static int32_t emf_length(const estimator_q_t *est, int32_t omega_e)
{
    root_q_t per_speed = reciprocal_q(lowpass_value_q(&est->speed_per_volt));
    return q_clamp(quotient_q(omega_e, per_speed, SPEED_PER_VOLT_Q + VOLTAGE_Q - SPEED_Q), SAMPLE_LARGEST);
}

/* The observer of the paper's forms. Returns the angle that the lag mode leaves added. */
static uint32_t preset_paper(estimator_q_t *est, int32_t omega_e, ab_q_t current, ab_q_t emf)
{
    smo_reset_q(&est->smo, current, emf);
    for (int32_t n = 0; n < RESET_ROUNDS; n++) {
        ab_q_t switched;
        ab_q_t emf_hat;
        lag_make_q(&est->smo, omega_e, emf, &switched, &emf_hat);
        smo_preset_q(&est->smo, current, switched, emf_hat);
    }
    return lag_angle_q(&est->smo, (lag_mode_t)est->params.lag, omega_e) -
           lag_angle_q(&est->smo, LAG_EXACT, omega_e);
}

void estimator_reset_q(estimator_q_t *est, position_q_t start, ab_q_t current)
{
    int32_t length = emf_length(est, start.omega_e);
    rotation_q_t rotor = trig_rotation_q(start.theta_e);
    ab_q_t emf = {q_clamp(q_multiply(-length, rotor.sin, UNIT_Q), SAMPLE_LARGEST),
                  q_clamp(q_multiply(length, rotor.cos, UNIT_Q), SAMPLE_LARGEST)};

    uint32_t added = 0u;
    if ((est->special & PAPER) != 0u) {
        added = preset_paper(est, start.omega_e, current, emf);
    } else {
        smo_preset_error_q(&est->smo, current, lag_error_q(&est->smo, start.omega_e, emf));
    }
    pll_reset_q(&est->pll, (position_q_t){start.theta_e + added, start.omega_e});
    pll_settle_q(&est->pll, q_magnitude(length));
    est->reset_angle = est->pll.theta_e;
    pll_advance_q(&est->pll);
    lowpass_reset_q(&est->emf_mean, q_magnitude(length));
    lowpass_reset_q(&est->speed_mean, q_magnitude(start.omega_e));
    est->emf = emf;
    est->reset_current = current;
    est->special = (est->special & ~COASTED) | FRESH;
    for (int32_t n = 0; n < ESTIMATOR_SIGNS; n++) {
        est->count[n] = 0u;
    }
    est->counting = 0u;
    est->invalid = 0u;
}

static inline bool is_reset_current(const estimator_q_t *est, ab_q_t current)
{
    return current.alpha == est->reset_current.alpha && current.beta == est->reset_current.beta;
}

/* Is the first sample after a reset that of the reset itself? As in estimator.c. */
static bool of_reset(const estimator_q_t *est, ab_q_t voltage, ab_q_t current)
{
    if (!is_reset_current(est, current)) {
        return false;
    }
    if (current.alpha != 0 || current.beta != 0) {
        return true;
    }
    int64_t ahead = q_product(est->emf.alpha, voltage.beta) - q_product(est->emf.beta, voltage.alpha);
    return est->pll.omega_smooth < 0 ? ahead >= 0 : ahead <= 0;
}

/* Slow: 1/psi_f = |omega_e|/|e|, both through the same low-pass; at most half of psi_f off the motor's. */
static void adapt_flux(estimator_q_t *est)
{
    int32_t speed = q_magnitude(est->pll.omega_smooth);
    int32_t emf_mean = lowpass_step_q(&est->emf_mean, est->pll.amplitude);
    int32_t speed_mean = lowpass_step_q(&est->speed_mean, speed);
    if (speed < est->params.adaptation_speed || q_magnitude(est->pll.detector) > ADAPTATION_DETECTOR) {
        return;
    }
    root_q_t per_emf = inverse_root_q(q_square(emf_mean));
    int32_t wanted = q_multiply_saturated(speed_mean, per_emf.mantissa,
                                          61 - VOLTAGE_Q - SPEED_PER_VOLT_Q + SPEED_Q - per_emf.shift);
    lowpass_q_t before = est->speed_per_volt;
    int32_t now = lowpass_step_q(&est->speed_per_volt, wanted);
    int32_t set = est->params.speed_per_volt;
    if (now > 2 * set || q_product(3, now) < q_product(2, set)) {
        est->speed_per_volt = before;
    }
}

static void count_failures(estimator_q_t *est, uint32_t signs, uint32_t periods)
{
    uint32_t invalid = est->invalid;
    est->counting = 0u;
    for (int32_t n = 0; n < ESTIMATOR_SIGNS; n++) {
        uint32_t bit = UINT32_C(1) << n;
        if ((signs & bit) != 0u) {
            est->count[n] += periods;
        } else {
            est->count[n] -= periods < est->count[n] ? periods : est->count[n];
        }
        if (est->count[n] >= est->params.debounce[n]) {
            est->count[n] = est->params.debounce[n];
            invalid |= bit;
        }
        if (est->count[n] == 0u) {
            invalid &= ~bit;
        }
        est->counting |= est->count[n];
    }
    est->invalid = invalid;
}

/* The signs that fail in this period. */
static uint32_t failing(const estimator_q_t *est)
{
    const estimator_params_q_t *params = &est->params;
    int32_t speed = q_magnitude(est->pll.omega_smooth);
    int32_t speed_of_emf = q_multiply_saturated(est->pll.amplitude, lowpass_value_q(&est->speed_per_volt),
                                                VOLTAGE_Q + SPEED_PER_VOLT_Q - SPEED_Q);
    int64_t least = q_round(q_product(speed, params->amplitude_min), UNIT_Q) - params->amplitude_allowance;
    int64_t most =
        q_round(q_product(speed, params->amplitude_max), AMPLITUDE_RATIO_Q) + params->amplitude_allowance;
    ab_q_t x = est->smo.current_err;
    return (speed_of_emf < least || speed_of_emf > most ? ESTIMATOR_AMPLITUDE : 0u) |
           (q_magnitude(est->pll.detector) > params->detector_max ? ESTIMATOR_DETECTOR : 0u) |
           (q_square_sum(x.alpha, x.beta) > q_square(params->current_max) ? ESTIMATOR_CURRENT : 0u) |
           (speed < params->speed_min || speed > params->speed_max ? ESTIMATOR_SPEED : 0u);
}

void estimator_judge_q(estimator_q_t *est, uint32_t periods)
{
    if ((est->special & (FRESH | COASTED)) != 0u) {
        return;
    }
    uint32_t signs = failing(est);
    if (est->counting != 0u || signs != 0u) {
        count_failures(est, signs, periods);
    }
}

/* The torque's share: K i_q, i_q of the rotor as the loop sees it; Q63. */
static int64_t acceleration_of(const estimator_q_t *est, ab_q_t current)
{
    return q_product(est->params.torque_feedforward, frames_park_q(current, est->pll.rotation).q);
}

/* The sample was none. */
static position_q_t pass_over(estimator_q_t *est)
{
    est->invalid |= ESTIMATOR_SAMPLE;
    est->special |= COASTED;
    return pll_coast_q(&est->pll, 0);
}

/* The EMF of t_k in every form; false: the sample is none. */
static bool observe(estimator_q_t *est, ab_q_t voltage, ab_q_t current)
{
    (void)smo_step_q(&est->smo, voltage, current);
    if (est->smo.passed_over != 0u) {
        return false;
    }
    est->emf = lag_emf_q(&est->smo, (lag_mode_t)est->params.lag, est->pll.omega_e);
    return true;
}

static inline position_q_t track(estimator_q_t *est, ab_q_t current)
{
    return pll_step_q(&est->pll, est->emf, lowpass_value_q(&est->speed_per_volt),
                      acceleration_of(est, current));
}

static position_q_t track_and_adapt(estimator_q_t *est, ab_q_t current)
{
    position_q_t position = track(est, current);
    if ((est->special & ADAPTING) != 0u) {
        adapt_flux(est);
    }
    return position;
}

/* What few periods or few parameter sets ask for: special_step() of estimator.c. */
static position_q_t special_step(estimator_q_t *est, ab_q_t voltage, ab_q_t current, bool doubtful)
{
    if ((est->special & FRESH) != 0u) {
        est->special &= ~FRESH;
        if (of_reset(est, voltage, current)) {
            est->special |= COASTED;
            return (position_q_t){est->reset_angle, est->pll.omega_smooth};
        }
        doubtful = false;
    }
    est->special &= ~COASTED;
    est->invalid &= ~ESTIMATOR_SAMPLE;
    if (!observe(est, voltage, current)) {
        return pass_over(est);
    }
    /* It is as it is: for the value analysis. */
    const ab_q_t measured = {q_clamp(current.alpha, SAMPLE_LARGEST), q_clamp(current.beta, SAMPLE_LARGEST)};
    if (doubtful) {
        est->special |= COASTED;
        return pll_watch_q(&est->pll, est->emf, acceleration_of(est, measured));
    }
    return track_and_adapt(est, measured);
}

position_q_t estimator_step_q(estimator_q_t *est, ab_q_t voltage, ab_q_t current)
{
    if ((est->special & ~ADAPTING) != 0u) {
        /* As in estimator.c: the short way does as well, but for the sample of the reset itself. */
        if ((est->special & PAPER) != 0u || is_reset_current(est, current)) {
            return special_step(est, voltage, current, false);
        }
        est->special &= ADAPTING;
        est->invalid &= ~ESTIMATOR_SAMPLE;
    }
    if (!smo_measured_q(voltage.alpha) || !smo_measured_q(voltage.beta) || !smo_measured_q(current.alpha) ||
        !smo_measured_q(current.beta) || !smo_step_settled_q(&est->smo, voltage, current)) {
        return special_step(est, voltage, current, false);
    }
    est->emf = lag_emf_exact_q(&est->smo, est->smo.current_err, est->pll.omega_e);
    return est->special == 0u ? track(est, current) : track_and_adapt(est, current);
}

position_q_t estimator_coast_q(estimator_q_t *est, ab_q_t voltage, ab_q_t current)
{
    return special_step(est, voltage, current, true);
}

uint16_t estimator_invalid_q(const estimator_q_t *est)
{
    return (uint16_t)est->invalid;
}
