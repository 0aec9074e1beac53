#include "estimator/fixed/per_unit.h"

#include "math/angle.h"

#define TWO_TO_31 2147483648.0f
#define TWO_TO_32 4294967296.0f

/* Ranges of the formats, per unit. */
#define PERIOD_LEAST         5e-6f   /* [s] 1/PLL_SIGN_SPEED in Q14 */
#define INDUCTANCE_LARGEST   50.0f   /* L/T [U/I]: 2/b in Q24 */
#define SLOPE_LARGEST        31.9f   /* a_f/2 [1/I]: Q26 */
#define SPEED_PER_VOLT_LEAST 1e-5f   /* [turn/(T U)]: 1e-4 of this is a count of Q30 */
#define SPEED_PER_VOLT_MOST  0.49f   /* twice this while it adapts */
#define FLOOR_LEAST          3.1e-5f /* [U] 1/amplitude_floor in Q15 */
#define FLOOR_MOST           4.0f    /* [U] */
#define TORQUE_LARGEST       0.0078f /* K [turn/(T^2 I)] */
#define KI_LARGEST           0.12f   /* ki [turn/T^2] */
#define FILTER_TURNS_LEAST   2.1e-3f /* omega_s T [-] of the filter ahead of the loop: 2 c/(1 - c) < 1000 */

static float power_of_two(float least)
{
    float power = 1.0f;
    while (power < least) {
        power *= 2.0f;
    }
    while (0.5f * power >= least) {
        power *= 0.5f;
    }
    return power;
}

bases_t per_unit_bases(const estimator_params_t *params)
{
    const smo_params_t *smo = &params->smo;
    const float swing = smo->gain * smo->period / smo->inductance;
    bases_t bases;
    bases.voltage = power_of_two(smo->gain);
    bases.current = power_of_two(swing > FIXED_CURRENT_LEAST ? swing : FIXED_CURRENT_LEAST);
    bases.period = smo->period;
    bases.turn_per_rad = smo->period * (1.0f / ANGLE_TWO_PI);
    return bases;
}

bool per_unit_check(const estimator_params_t *params, params_error_t *why)
{
    const bases_t base = per_unit_bases(params);
    const float emf_cutoff = estimator_parts(params).observer.smo.emf_cutoff;
    const float flux_unit = base.voltage * base.turn_per_rad; /* U T/2 pi [Wb] */
    const float turns = base.turn_per_rad * base.period;      /* T^2/2 pi */
    return params_within(why, "period", "the fixed-point estimator must resolve speeds of 20 rad/s",
                         base.period, PERIOD_LEAST, 1e-2f) &&
           params_within(why, "inductance", "fixed point: L/T within 50 U/I", params->smo.inductance, 1e-6f,
                         INDUCTANCE_LARGEST * base.period * base.voltage / base.current) &&
           params_within(why, "slope", "fixed point: a_f/2 within 32/I", params->smo.slope, 1e-3f,
                         2.0f * SLOPE_LARGEST / base.current) &&
           (emf_cutoff == 0.0f || params_within(why, "emf_cutoff", "fixed point: 0, or omega_s T >= 0.0021",
                                                emf_cutoff, FILTER_TURNS_LEAST / base.period, 1e5f)) &&
           params_within(why, "flux_linkage", "fixed point: T U/(2 pi psi_f) within 1e-5..0.49",
                         params->flux_linkage, flux_unit / SPEED_PER_VOLT_MOST,
                         flux_unit / SPEED_PER_VOLT_LEAST) &&
           params_within(why, "amplitude_floor", "fixed point: within 3.1e-5..4 U",
                         params->pll.amplitude_floor, FLOOR_LEAST * base.voltage,
                         FLOOR_MOST * base.voltage) &&
           params_within(why, "ki", "fixed point: ki T^2/(2 pi) <= 0.12", params->pll.ki, 0.0f,
                         KI_LARGEST / turns) &&
           params_within(why, "torque_feedforward", "fixed point: K T^2 I/(2 pi) <= 0.0078",
                         params->torque_feedforward, 0.0f, TORQUE_LARGEST / (turns * base.current));
}

/* Converts to counts, rounded, within the range of the type. */
int32_t per_unit_counts(float value, float per_unit)
{
    float counts = value * per_unit;
    if (!(counts < TWO_TO_31)) {
        return Q_LARGEST;
    }
    if (counts <= -TWO_TO_31) {
        return -Q_LARGEST;
    }
    return (int32_t)(counts + (counts < 0.0f ? -0.5f : 0.5f));
}

static int32_t in_q(float value, int32_t n)
{
    return per_unit_counts(value, (float)(UINT32_C(1) << n));
}

/* A small number in Q32, below 1/2. */
static int32_t in_q32(float value)
{
    return per_unit_counts(value, TWO_TO_32);
}

/* value = mantissa step / 2^32, below 2^30. */
static q_scale_t scale_of(float value)
{
    q_scale_t scale = {0, 1};
    if (value > 0.0f) {
        float least = power_of_two(2.0f * value);
        float step = least > 1.0f ? least : 1.0f;
        scale.mantissa = per_unit_counts(value / step, TWO_TO_32);
        scale.step = per_unit_counts(step, 1.0f);
    }
    return scale;
}

static smo_tuning_q_t smo_of(const smo_params_t *params, const bases_t *base)
{
    smo_tuning_t tuning; /* of the float observer, in SI */
    smo_prepare(&tuning, params);
    const float impedance = base->voltage / base->current; /* [ohm] */
    const float emf_decay = tuning.emf_decay;
    const float gain = params->gain / base->voltage;
    smo_tuning_q_t q;
    q.resistance = in_q(params->resistance / impedance, IMPEDANCE_Q);
    q.voltage_gain = in_q(tuning.voltage_gain * impedance, GAIN_Q);
    q.gain = in_q(gain, GAIN_Q);
    q.half_slope = in_q(0.5f * params->slope * base->current, SLOPE_Q);
    q.gain_slope = in_q(0.5f * params->slope * base->current * gain, SLOPE_Q);
    q.emf_decay = in_q(emf_decay, SHARE_Q);
    q.mean_share = in_q(tuning.axes.mean_share, SHARE_Q);
    q.current_loss = in_q32(tuning.voltage_gain * params->resistance);
    for (int32_t n = 0; n < 4; n++) {
        q.hold[n] = in_q(tuning.hold[n], UNIT_Q);
    }
    q.inductance = in_q(params->inductance / (params->period * impedance), IMPEDANCE_Q);
    q.one_ohm = in_q(1.0f / impedance, IMPEDANCE_Q);
    q.ohms = in_q(params->resistance, IMPEDANCE_Q);
    q.gain_largest = in_q(SMO_SIGN_GAIN_MAX * base->current, IMPEDANCE_Q);
    q.axis_gain_largest = in_q(SMO_SIGN_GAIN_MAX * base->current, AXIS_GAIN_Q);
    q.filter_odd = in_q(2.0f * emf_decay / (1.0f - emf_decay), 20);
    q.switching = (int32_t)params->switching;
    return q;
}

static pll_tuning_q_t pll_of(const pll_params_t *params, const bases_t *base)
{
    pll_tuning_t tuning; /* of the float loop, in SI */
    pll_prepare(&tuning, params);
    const float turn = base->turn_per_rad;
    const float floor = params->amplitude_floor / base->voltage;
    pll_tuning_q_t q;
    q.kp_rest = in_q((params->kp - params->ki * params->period) * turn, SHARE_Q);
    q.ki_period = scale_of(params->ki * turn * params->period * 2.0f * TWO_TO_32);
    q.feedforward_share = in_q(tuning.feedforward_share, SHARE_Q);
    q.amplitude_floor = in_q(floor, VOLTAGE_Q);
    q.inverse_floor = in_q(1.0f / floor, 15);
    q.emf_decay = in_q(tuning.emf_decay, UNIT_Q);
    q.sign_speed = per_unit_counts(PLL_SIGN_SPEED * turn, TWO_TO_31);
    q.inverse_sign_speed = in_q(1.0f / (PLL_SIGN_SPEED * turn), 14);
    q.signed_speed = per_unit_counts(PLL_SIGNED_SPEED * turn, TWO_TO_31);
    return q;
}

/* A limit of 0 means that the criterion is not judged. */
static float limit_of(float value)
{
    return value > 0.0f ? value : TWO_TO_32;
}

int32_t per_unit_speed_per_volt(float speed_per_volt, const bases_t *base)
{
    return in_q(base->voltage * base->turn_per_rad * speed_per_volt, SPEED_PER_VOLT_Q);
}

estimator_tuning_q_t per_unit_of(const estimator_params_t *params, const bases_t *base)
{
    const validity_params_t *limits = &params->validity;
    const estimator_parts_t parts = estimator_parts(params);
    const float period = base->period;
    const float turn = base->turn_per_rad;
    estimator_tuning_q_t q;
    q.smo = smo_of(&parts.observer.smo, base);
    q.pll = pll_of(&parts.tracker.pll, base);
    q.lag = (int32_t)params->lag;
    q.speed_per_volt = per_unit_speed_per_volt(1.0f / params->flux_linkage, base);
    q.torque_feedforward =
        per_unit_counts(params->torque_feedforward * turn * period * base->current, 64.0f * TWO_TO_32);
    q.amplitude_min = in_q(limits->amplitude_min, UNIT_Q);
    q.amplitude_max = in_q(limit_of(limits->amplitude_max), 24);
    q.amplitude_allowance = per_unit_counts(ESTIMATOR_AMPLITUDE_ALLOWANCE * turn, TWO_TO_31);
    q.detector_max = in_q(limit_of(limits->detector_max), UNIT_Q);
    q.current_max = in_q(limit_of(limits->current_max) / base->current, CURRENT_Q);
    q.speed_min = per_unit_counts(limits->speed_min * turn, TWO_TO_31);
    q.speed_max = per_unit_counts(limit_of(limits->speed_max) * turn, TWO_TO_31);
    validity_prepare_debounce(&q.debounce, limits, period);
    return q;
}
