#include "estimator/estimator.h"

#include "math/angle.h"
#include "math/bounds.h"
#include "math/check.h"
#include "math/root.h"
#include "math/trig.h"

/* Limits that nothing reaches: the sign is not judged. */
#define UNLIMITED           1e30f
#define AMPLITUDE_UNLIMITED 1e4f /* [-] */
#define TURN_UNLIMITED      4.0f /* [rad] in a period */

/* The flux may move this far from the parameter, either way [-]. */
#define ADAPTATION_RANGE 0.5f

/* k_f depends on the EMF that the observer has to make, and that on k_f: a few rounds settle both. */
#define RESET_ROUNDS 8

/* Bits of `special`: why a step is not the shortest one. The first two are of a period, the others of the
 * parameters. */
#define FRESH    UINT32_C(1) /* no step yet since the reset */
#define COASTED  UINT32_C(2) /* the last period was not tracked */
#define PAPER    UINT32_C(4) /* a switching function per axis, or a lag of the paper */
#define ADAPTING UINT32_C(8) /* the flux adapts */

static bool validity_check(const validity_params_t *limits, params_error_t *why)
{
    if (!params_within(why, "amplitude_min", PARAMS_RANGE, limits->amplitude_min, 0.0f, 1.0f) ||
        !params_within(why, "detector_max", PARAMS_RANGE, limits->detector_max, 0.0f, 1.0f) ||
        !params_within(why, "current_max", PARAMS_RANGE, limits->current_max, 0.0f, 1e3f) ||
        !params_within(why, "speed_max", PARAMS_RANGE, limits->speed_max, 0.0f, 1e6f) ||
        !params_within(why, "speed_min", PARAMS_RANGE, limits->speed_min, 0.0f, 1e6f) ||
        !params_within(why, "amplitude_time", PARAMS_RANGE, limits->amplitude_time, 0.0f, 10.0f) ||
        !params_within(why, "detector_time", PARAMS_RANGE, limits->detector_time, 0.0f, 10.0f) ||
        !params_within(why, "current_time", PARAMS_RANGE, limits->current_time, 0.0f, 10.0f) ||
        !params_within(why, "speed_time", PARAMS_RANGE, limits->speed_time, 0.0f, 10.0f)) {
        return false;
    }
    if (limits->amplitude_max != 0.0f && !(limits->amplitude_max > 1.0f && limits->amplitude_max <= 100.0f)) {
        return params_refuse(why, "amplitude_max", "0 (not judged), or 1 < amplitude_max <= 100",
                             limits->amplitude_max, 1.0f, 100.0f);
    }
    return limits->speed_max == 0.0f || limits->speed_min < limits->speed_max ||
           params_refuse(why, "speed_min", "speed_min < speed_max", limits->speed_min, 0.0f,
                         limits->speed_max);
}

estimator_parts_t estimator_parts(const estimator_params_t *params)
{
    estimator_parts_t parts = {params->smo, params->pll};
    if (params->lag == LAG_EXACT) {
        parts.pll.emf_cutoff = params->smo.emf_cutoff;
        parts.smo.emf_cutoff = 0.0f;
    }
    return parts;
}

bool estimator_params_check(const estimator_params_t *params, params_error_t *why)
{
    const estimator_parts_t parts = estimator_parts(params);
    if (!smo_params_check(&params->smo, why) || !pll_params_check(&parts.pll, why) ||
        !params_within(why, "lag", PARAMS_RANGE, (float)params->lag, (float)LAG_NONE, (float)LAG_EXACT) ||
        !params_within(why, "flux_linkage", PARAMS_RANGE, params->flux_linkage, 1e-4f, 10.0f) ||
        !params_within(why, "flux_adaptation", PARAMS_RANGE, params->flux_adaptation, 0.0f, 100.0f) ||
        !params_within(why, "torque_feedforward", PARAMS_RANGE, params->torque_feedforward, 0.0f,
                       ESTIMATOR_TORQUE_FEEDFORWARD_MAX) ||
        !validity_check(&params->validity, why)) {
        return false;
    }

    float period = params->smo.period;
    if (params->pll.period != period) {
        return params_refuse(why, "period", "pll.period = smo.period", params->pll.period, period, period);
    }
    float gain_min = ESTIMATOR_GAIN_MARGIN * params->flux_linkage * params->validity.speed_max;
    if (params->smo.gain < gain_min) {
        return params_refuse(why, "gain", "gain >= 1.1 times the largest EMF, flux_linkage speed_max",
                             params->smo.gain, gain_min, 1e4f);
    }
    if (params->torque_feedforward > 0.0f && params->pll.feedforward_cutoff == 0.0f) {
        return params_refuse(why, "torque_feedforward",
                             "0 with feedforward_cutoff = 0, else nothing forgets its error",
                             params->torque_feedforward, 0.0f, 0.0f);
    }
    return true;
}

static float limit_of(float value, float unlimited)
{
    return value > 0.0f ? value : unlimited;
}

static band_t band_of(float min, float max)
{
    band_t band = {0.5f * (max + min), 0.5f * (max - min)};
    return band;
}

static uint32_t periods_of(float time, float period)
{
    return (uint32_t)(time / period) + 1u;
}

static void set_flux(estimator_t *est, float flux_linkage)
{
    est->flux_linkage = flux_linkage;
    est->speed_per_volt = 1.0f / flux_linkage;
}

void estimator_retune(estimator_t *est, const estimator_params_t *params)
{
    params_error_t why;
    CHECK(estimator_params_check(params, &why));

    const validity_params_t *limits = &params->validity;
    const estimator_parts_t parts = estimator_parts(params);
    float period = params->smo.period;
    est->amplitude = band_of(limits->amplitude_min, limit_of(limits->amplitude_max, AMPLITUDE_UNLIMITED));
    est->detector_max = limit_of(limits->detector_max, UNLIMITED);
    est->error_square_max = limit_of(limits->current_max * limits->current_max, UNLIMITED);
    est->speed = band_of(limits->speed_min, limit_of(limits->speed_max, TURN_UNLIMITED / period));
    est->debounce[0] = periods_of(limits->amplitude_time, period);
    est->debounce[1] = periods_of(limits->detector_time, period);
    est->debounce[2] = periods_of(limits->current_time, period);
    est->debounce[3] = periods_of(limits->speed_time, period);
    est->lag = (int32_t)params->lag;
    est->torque_feedforward = params->torque_feedforward;
    est->adaptation_share = params->flux_adaptation * period;
    bool direct = params->lag == LAG_EXACT && params->smo.switching == SMO_SIGMOID_VECTOR;
    est->special = (est->special & (FRESH | COASTED)) | (direct ? 0u : PAPER) |
                   (params->flux_adaptation > 0.0f ? ADAPTING : 0u);
    lowpass_retune(&est->emf_mean, ESTIMATOR_ADAPTATION_CUTOFF, period);
    lowpass_retune(&est->speed_mean, ESTIMATOR_ADAPTATION_CUTOFF, period);
    if (params->flux_linkage != est->flux_linkage_set || params->flux_adaptation == 0.0f) {
        est->flux_linkage_set = params->flux_linkage;
        set_flux(est, params->flux_linkage);
    }
    smo_retune(&est->smo, &parts.smo);
    pll_retune(&est->pll, &parts.pll);
}

void estimator_init(estimator_t *est, const estimator_params_t *params)
{
    const position_t origin = {0.0f, 0.0f};
    const ab_t none = {0.0f, 0.0f};
    const estimator_parts_t parts = estimator_parts(params);
    est->flux_linkage_set = 0.0f;
    est->special = 0u;
    estimator_retune(est, params);
    set_flux(est, params->flux_linkage);
    smo_init(&est->smo, &parts.smo);
    pll_init(&est->pll, &parts.pll);
    estimator_reset(est, origin, none);
}

/* The observer of the paper's forms. Returns the angle that the lag mode leaves added [rad]. */
static float preset_paper(estimator_t *est, float omega_e, ab_t current, ab_t emf)
{
    smo_reset(&est->smo, current, emf);
    for (int32_t n = 0; n < RESET_ROUNDS; n++) {
        ab_t switched;
        ab_t emf_hat;
        lag_make(&est->smo, omega_e, emf, &switched, &emf_hat);
        smo_preset(&est->smo, current, switched, emf_hat);
    }
    return lag_angle(&est->smo, (lag_mode_t)est->lag, omega_e) - lag_angle(&est->smo, LAG_EXACT, omega_e);
}

void estimator_reset(estimator_t *est, position_t start, ab_t current)
{
    float length = est->flux_linkage * start.omega_e;
    rotation_t rotor = trig_rotation(angle_wrap(start.theta_e));
    ab_t emf = {-length * rotor.sin, length * rotor.cos};

    float added = 0.0f;
    if ((est->special & PAPER) != 0u) {
        added = preset_paper(est, start.omega_e, current, emf);
    } else {
        smo_preset_error(&est->smo, current, lag_error(&est->smo, start.omega_e, emf));
    }
    pll_reset(&est->pll, (position_t){start.theta_e + added, start.omega_e});
    pll_settle(&est->pll, bounds_magnitude(length));
    est->reset_angle = est->pll.theta_e;
    pll_advance(&est->pll);
    lowpass_reset(&est->emf_mean, bounds_magnitude(length));
    lowpass_reset(&est->speed_mean, bounds_magnitude(start.omega_e));
    est->emf = emf;
    est->reset_current = current;
    est->special = (est->special & ~COASTED) | FRESH;
    for (int32_t n = 0; n < ESTIMATOR_SIGNS; n++) {
        est->count[n] = 0u;
    }
    est->counting = 0u;
    est->invalid = 0u;
}

static inline bool is_reset_current(const estimator_t *est, ab_t current)
{
    return current.alpha == est->reset_current.alpha && current.beta == est->reset_current.beta;
}

/* Is the first sample after a reset that of the reset itself? Its current is then the same. Only a machine
 * without current has the same one a period later too; there the voltage is the EMF, of the period before t_k
 * or of that after it. */
static bool of_reset(const estimator_t *est, ab_t voltage, ab_t current)
{
    if (!is_reset_current(est, current)) {
        return false;
    }
    if (current.alpha != 0.0f || current.beta != 0.0f) {
        return true;
    }
    float ahead = est->emf.alpha * voltage.beta - est->emf.beta * voltage.alpha;
    return est->pll.omega_smooth < 0.0f ? ahead >= 0.0f : ahead <= 0.0f;
}

/* Slow: psi_f = |e|/|omega_e|, both through the same low-pass, so that a ramp of the speed leaves no trace.
 */
static void adapt_flux(estimator_t *est)
{
    float speed = bounds_magnitude(est->pll.omega_smooth);
    float emf_mean = lowpass_step(&est->emf_mean, est->pll.amplitude);
    float speed_mean = lowpass_step(&est->speed_mean, speed);
    if (speed < ESTIMATOR_ADAPTATION_SPEED ||
        bounds_magnitude(est->pll.detector) > ESTIMATOR_ADAPTATION_DETECTOR) {
        return;
    }
    float wanted = speed_mean * inverse_root(emf_mean * emf_mean);
    float change = est->adaptation_share * (wanted - est->speed_per_volt);
    float flux_linkage = est->flux_linkage * (1.0f - est->flux_linkage * change);
    if (bounds_magnitude(flux_linkage - est->flux_linkage_set) > ADAPTATION_RANGE * est->flux_linkage_set) {
        return;
    }
    est->speed_per_volt += change;
    /* One Newton step towards 1/speed_per_volt per period follows a change as slow as this. */
    est->flux_linkage = flux_linkage * (2.0f - flux_linkage * est->speed_per_volt);
}

static void count_failures(estimator_t *est, uint32_t signs, uint32_t periods)
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
        if (est->count[n] >= est->debounce[n]) {
            est->count[n] = est->debounce[n];
            invalid |= bit;
        }
        if (est->count[n] == 0u) {
            invalid &= ~bit;
        }
        est->counting |= est->count[n];
    }
    est->invalid = invalid;
}

static bool outside(float value, band_t band)
{
    return !(bounds_magnitude(value - band.middle) <= band.half);
}

/* The signs that fail in this period. */
static uint32_t failing(const estimator_t *est, float speed, float speed_of_emf, band_t fitting)
{
    return (outside(speed_of_emf, fitting) ? ESTIMATOR_AMPLITUDE : 0u) |
           (bounds_magnitude(est->pll.detector) > est->detector_max ? ESTIMATOR_DETECTOR : 0u) |
           (smo_error_square(&est->smo) > est->error_square_max ? ESTIMATOR_CURRENT : 0u) |
           (outside(speed, est->speed) ? ESTIMATOR_SPEED : 0u);
}

void estimator_judge(estimator_t *est, uint32_t periods)
{
    if ((est->special & (FRESH | COASTED)) != 0u) {
        return;
    }
    float speed = bounds_magnitude(est->pll.omega_smooth);
    float speed_of_emf = est->pll.amplitude * est->speed_per_volt;
    band_t fitting = {est->amplitude.middle * speed,
                      est->amplitude.half * speed + ESTIMATOR_AMPLITUDE_ALLOWANCE};
    if (est->counting != 0u || outside(speed_of_emf, fitting) ||
        bounds_magnitude(est->pll.detector) > est->detector_max ||
        smo_error_square(&est->smo) > est->error_square_max || outside(speed, est->speed)) {
        count_failures(est, failing(est, speed, speed_of_emf, fitting), periods);
    }
}

/* The torque's share: K i_q, i_q of the rotor as the loop sees it. */
static float acceleration_of(const estimator_t *est, ab_t current)
{
    return est->torque_feedforward * frames_park(current, est->pll.rotation).q;
}

/* The sample was none. */
static position_t pass_over(estimator_t *est)
{
    est->invalid |= ESTIMATOR_SAMPLE;
    est->special |= COASTED;
    return pll_coast(&est->pll, 0.0f);
}

/* The EMF of t_k in every form; false: the sample is none. */
static bool observe(estimator_t *est, ab_t voltage, ab_t current)
{
    if ((est->special & PAPER) == 0u && smo_step_settled(&est->smo, voltage, current)) {
        est->emf = lag_emf_exact(&est->smo, est->smo.current_err, est->pll.omega_e);
        return true;
    }
    (void)smo_step(&est->smo, voltage, current);
    if (est->smo.passed_over != 0u) {
        return false;
    }
    est->emf = lag_emf(&est->smo, (lag_mode_t)est->lag, est->pll.omega_e);
    return true;
}

static position_t track_and_adapt(estimator_t *est, float acceleration)
{
    position_t position = pll_step(&est->pll, est->emf, est->speed_per_volt, acceleration);
    if ((est->special & ADAPTING) != 0u) {
        adapt_flux(est);
    }
    return position;
}

/* What few periods or few parameter sets ask for. Single floats, because pairs that are passed on twice make
 * the compiler put them into memory, on the short way as well. */
static position_t special_step(estimator_t *est, float u_alpha, float u_beta, float i_alpha, float i_beta,
                               bool doubtful)
{
    const ab_t voltage = {u_alpha, u_beta};
    const ab_t current = {i_alpha, i_beta};
    if ((est->special & FRESH) != 0u) {
        est->special &= ~FRESH;
        if (of_reset(est, voltage, current)) {
            est->special |= COASTED;
            return (position_t){est->reset_angle, est->pll.omega_smooth};
        }
        doubtful = false;
    }
    est->special &= ~COASTED;
    est->invalid &= ~ESTIMATOR_SAMPLE;
    if (!observe(est, voltage, current)) {
        return pass_over(est);
    }
    float acceleration = acceleration_of(est, current);
    if (doubtful) {
        est->special |= COASTED;
        return pll_watch(&est->pll, est->emf, acceleration);
    }
    return track_and_adapt(est, acceleration);
}

position_t estimator_step(estimator_t *est, ab_t voltage, ab_t current)
{
    if (est->special != 0u) {
        /* After a coast or a reset the short way does as well, but for the sample of the reset itself. */
        if ((est->special & ~(FRESH | COASTED)) != 0u || is_reset_current(est, current)) {
            return special_step(est, voltage.alpha, voltage.beta, current.alpha, current.beta, false);
        }
        est->special = 0u;
        est->invalid &= ~ESTIMATOR_SAMPLE;
    }
    if (!smo_step_settled(&est->smo, voltage, current)) {
        return special_step(est, voltage.alpha, voltage.beta, current.alpha, current.beta, false);
    }
    est->emf = lag_emf_exact(&est->smo, est->smo.current_err, est->pll.omega_e);
    float acceleration = acceleration_of(est, current);
    position_t position;
    return pll_track(&est->pll, est->emf, est->speed_per_volt, acceleration, &position)
               ? position
               : pll_step_closely(&est->pll, est->emf, est->speed_per_volt, acceleration);
}

position_t estimator_coast(estimator_t *est, ab_t voltage, ab_t current)
{
    return special_step(est, voltage.alpha, voltage.beta, current.alpha, current.beta, true);
}

uint16_t estimator_invalid(const estimator_t *est)
{
    return (uint16_t)est->invalid;
}
