#include "estimator/fixed/fixed.h"

#include "math/angle.h"
#include "math/bounds.h"
#include "math/check.h"
#include "math/exponential.h"

#define TWO_TO_25 33554432.0f
#define TWO_TO_27 134217728.0f
#define TWO_TO_30 1073741824.0f
#define TWO_TO_31 2147483648.0f
#define TWO_TO_32 4294967296.0f

/* What the formats hold, per unit. */
#define PERIOD_LEAST         5e-6f   /* [s] 1/PLL_SIGN_SPEED in Q14 */
#define INDUCTANCE_LARGEST   50.0f   /* L/T [U/I]: 2/b in Q24 */
#define SLOPE_LARGEST        31.9f   /* a_f/2 [1/I]: Q26 */
#define SPEED_PER_VOLT_LEAST 1e-5f   /* [turn/(T U)]: 1e-4 of it is a count of Q30 */
#define SPEED_PER_VOLT_MOST  0.49f   /* twice this while it adapts */
#define FLOOR_LEAST          3.1e-5f /* [U] 1/amplitude_floor in Q15 */
#define FLOOR_MOST           4.0f    /* [U] */
#define TORQUE_LARGEST       0.0078f /* K [turn/(T^2 I)] */
#define KI_LARGEST           0.12f   /* ki [turn/T^2] */
#define FILTER_TURNS_LEAST                                                                                   \
    2.1e-3f /* omega_s T [-] of the filter ahead of the loop: 2 c/(1 - c) below 1000                         \
             */

typedef struct {
    float voltage, current; /* U [V], I [A] */
    float period;           /* T [s] */
    float turn_per_rad;     /* of a speed: T/2 pi [turn/T per rad/s] */
} bases_t;

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

static bases_t bases_of(const estimator_params_t *params)
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

bool fixed_params_check(const estimator_params_t *params, params_error_t *why)
{
    if (!estimator_params_check(params, why)) {
        return false;
    }
    const bases_t base = bases_of(params);
    const float emf_cutoff = estimator_parts(params).smo.emf_cutoff;
    const float flux_unit = base.voltage * base.turn_per_rad; /* U T/2 pi [Wb] */
    const float turns = base.turn_per_rad * base.period;      /* T^2/2 pi */
    return params_within(why, "period", "fixed point: speeds of 20 rad/s resolved", base.period, PERIOD_LEAST,
                         1e-2f) &&
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

/* To counts, rounded, within the type. */
static int32_t counts_of(float value, float per_unit)
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
    return counts_of(value, (float)(UINT32_C(1) << n));
}

/* A small number in Q32, below 1/2. */
static int32_t in_q32(float value)
{
    return counts_of(value, TWO_TO_32);
}

/* value = mantissa step / 2^32, below 2^30. */
static q_scale_t scale_of(float value)
{
    q_scale_t scale = {0, 1};
    if (value > 0.0f) {
        float least = power_of_two(2.0f * value);
        float step = least > 1.0f ? least : 1.0f;
        scale.mantissa = counts_of(value / step, TWO_TO_32);
        scale.step = counts_of(step, 1.0f);
    }
    return scale;
}

static smo_params_q_t smo_of(const smo_params_t *params, const bases_t *base)
{
    const float impedance = base->voltage / base->current; /* [ohm] */
    const float decay = params->resistance * params->period / params->inductance;
    const float rest = exponential_rest(decay);
    const float voltage_gain = rest / params->resistance;
    const bool filtering = params->emf_cutoff > 0.0f;
    const float emf_decay = filtering ? exponential(-params->emf_cutoff * params->period) : 0.0f;
    const float gain = params->gain / base->voltage;
    smo_params_q_t q;
    q.resistance = in_q(params->resistance / impedance, IMPEDANCE_Q);
    q.voltage_gain = in_q(voltage_gain * impedance, GAIN_Q);
    q.gain = in_q(gain, GAIN_Q);
    q.half_slope = in_q(0.5f * params->slope * base->current, SLOPE_Q);
    q.gain_slope = in_q(0.5f * params->slope * base->current * gain, SLOPE_Q);
    q.emf_decay = in_q(emf_decay, SHARE_Q);
    q.mean_share = in_q(exponential_rest(SMO_GAIN_CUTOFF * params->period), SHARE_Q);
    q.loop_gain_unit = in_q(voltage_gain * impedance * gain, GAIN_Q);
    q.current_loss = in_q32(rest);
    q.hold_lead = in_q32(decay * (1.0f / 6.0f - decay * decay * (1.0f / 360.0f)));
    q.hold_lead_rise = in_q(decay * (1.0f / 90.0f), UNIT_Q);
    q.hold_size = in_q(1.33269238f + decay * decay * (1.0f / 120.0f + 1.0f / 72.0f), UNIT_Q);
    q.hold_cotangent = in_q32(1.0f / 3.0f + decay * decay * (1.0f / 90.0f));
    q.lag_resistance = in_q((2.0f / voltage_gain - params->resistance) / impedance, IMPEDANCE_Q);
    q.inductance = in_q(params->inductance / (params->period * impedance), IMPEDANCE_Q);
    q.one_ohm = in_q(1.0f / impedance, IMPEDANCE_Q);
    q.ohms = in_q(params->resistance, IMPEDANCE_Q);
    q.gain_largest = in_q(SMO_SIGN_GAIN_MAX * base->current, IMPEDANCE_Q);
    q.axis_gain_largest = in_q(SMO_SIGN_GAIN_MAX * base->current, AXIS_GAIN_Q);
    q.filter_odd = in_q(2.0f * emf_decay / (1.0f - emf_decay), 20);
    q.filtering = filtering;
    q.switching = (int32_t)params->switching;
    return q;
}

static pll_params_q_t pll_of(const pll_params_t *params, const bases_t *base)
{
    const float turn = base->turn_per_rad;
    const float floor = params->amplitude_floor / base->voltage;
    pll_params_q_t q;
    q.kp_rest = in_q((params->kp - params->ki * params->period) * turn, SHARE_Q);
    q.ki_period = scale_of(params->ki * turn * params->period * 2.0f * TWO_TO_32);
    q.feedforward_share = in_q(exponential_rest(params->feedforward_cutoff * params->period), SHARE_Q);
    q.amplitude_floor = in_q(floor, VOLTAGE_Q);
    q.inverse_floor = in_q(1.0f / floor, 15);
    q.emf_decay =
        params->emf_cutoff > 0.0f ? in_q(exponential(-params->emf_cutoff * params->period), UNIT_Q) : 0;
    q.sign_speed = counts_of(PLL_SIGN_SPEED * turn, TWO_TO_31);
    q.inverse_sign_speed = in_q(1.0f / (PLL_SIGN_SPEED * turn), 14);
    q.signed_speed = counts_of(PLL_SIGNED_SPEED * turn, TWO_TO_31);
    return q;
}

static uint32_t periods_of(float time, float period)
{
    return (uint32_t)(time / period) + 1u;
}

/* A limit of 0 is none. */
static float limit_of(float value)
{
    return value > 0.0f ? value : TWO_TO_32;
}

static estimator_params_q_t per_unit(const estimator_params_t *params, const bases_t *base)
{
    const validity_params_t *limits = &params->validity;
    const estimator_parts_t parts = estimator_parts(params);
    const float period = base->period;
    const float turn = base->turn_per_rad;
    estimator_params_q_t q;
    q.smo = smo_of(&parts.smo, base);
    q.pll = pll_of(&parts.pll, base);
    q.lag = (int32_t)params->lag;
    q.speed_per_volt = in_q(base->voltage * turn / params->flux_linkage, SPEED_PER_VOLT_Q);
    q.adaptation_share = in_q(params->flux_adaptation * period, SHARE_Q);
    q.mean_share = in_q(exponential_rest(ESTIMATOR_ADAPTATION_CUTOFF * period), SHARE_Q);
    q.adaptation_speed = counts_of(ESTIMATOR_ADAPTATION_SPEED * turn, TWO_TO_31);
    q.torque_feedforward =
        counts_of(params->torque_feedforward * turn * period * base->current, 64.0f * TWO_TO_32);
    q.amplitude_min = in_q(limits->amplitude_min, UNIT_Q);
    q.amplitude_max = in_q(limit_of(limits->amplitude_max), 24);
    q.amplitude_allowance = counts_of(ESTIMATOR_AMPLITUDE_ALLOWANCE * turn, TWO_TO_31);
    q.detector_max = in_q(limit_of(limits->detector_max), UNIT_Q);
    q.current_max = in_q(limit_of(limits->current_max) / base->current, CURRENT_Q);
    q.speed_min = counts_of(limits->speed_min * turn, TWO_TO_31);
    q.speed_max = counts_of(limit_of(limits->speed_max) * turn, TWO_TO_31);
    q.debounce[0] = periods_of(limits->amplitude_time, period);
    q.debounce[1] = periods_of(limits->detector_time, period);
    q.debounce[2] = periods_of(limits->current_time, period);
    q.debounce[3] = periods_of(limits->speed_time, period);
    return q;
}

static void set_units(fixed_t *fixed, const bases_t *base)
{
    fixed->units.voltage = base->voltage / TWO_TO_27;
    fixed->units.current = base->current / TWO_TO_25;
    fixed->units.speed = 1.0f / (base->turn_per_rad * TWO_TO_31);
    fixed->units.gain = 2.0f / TWO_TO_25 / base->current;
    fixed->voltage_counts = TWO_TO_27 / base->voltage;
    fixed->current_counts = TWO_TO_25 / base->current;
    fixed->speed_counts = base->turn_per_rad * TWO_TO_31;
    fixed->flux_per_count = base->voltage * base->turn_per_rad * TWO_TO_30;
}

/* ---- the state in other bases ---- */

static void move(int32_t *value, float ratio)
{
    *value = counts_of((float)*value, ratio);
}

static void move_pair(ab_q_t *pair, float ratio)
{
    move(&pair->alpha, ratio);
    move(&pair->beta, ratio);
}

static void move_mean(lowpass_q_t *mean, float ratio)
{
    lowpass_reset_q(mean, counts_of((float)lowpass_value_q(mean), ratio));
}

static void move_speed(int64_t *speed, float ratio)
{
    *speed = (int64_t)counts_of((float)q_floor(*speed, LONG_SPEED_Q - SPEED_Q), ratio) *
             (INT64_C(1) << (LONG_SPEED_Q - SPEED_Q));
}

static void rebase(estimator_q_t *q, float voltage, float current, float speed)
{
    move_pair(&q->smo.current_hat, current);
    move_pair(&q->smo.current_err, current);
    move_pair(&q->smo.switched, voltage);
    move_pair(&q->smo.emf_hat, voltage);
    move_pair(&q->smo.gain_axis, 1.0f / current);
    move_mean(&q->smo.mean_product, current);
    move_mean(&q->smo.mean_square, current * current);
    move(&q->smo.gain_mean, 1.0f / current);
    move(&q->smo.conductance, voltage / current);
    move_speed(&q->pll.integral, speed);
    move_speed(&q->pll.feedforward, speed);
    move(&q->pll.emf.d, voltage);
    move(&q->pll.emf.q, voltage);
    move(&q->pll.omega_e, speed);
    move(&q->pll.omega_smooth, speed);
    move(&q->pll.amplitude, voltage);
    move_mean(&q->speed_per_volt, speed / voltage);
    move_mean(&q->emf_mean, voltage);
    move_mean(&q->speed_mean, speed);
    move_pair(&q->emf, voltage);
    move_pair(&q->reset_current, current);
}

/* ---- samples and results ---- */

static ab_t pair_of(ab_q_t pair, float unit)
{
    return (ab_t){(float)pair.alpha * unit, (float)pair.beta * unit};
}

static ab_q_t voltage_of(const fixed_t *fixed, ab_t voltage)
{
    return (ab_q_t){counts_of(voltage.alpha, fixed->voltage_counts),
                    counts_of(voltage.beta, fixed->voltage_counts)};
}

static ab_q_t current_of(const fixed_t *fixed, ab_t current)
{
    return (ab_q_t){counts_of(current.alpha, fixed->current_counts),
                    counts_of(current.beta, fixed->current_counts)};
}

/* What a debugger, a recorder and the drive look at. */
static void show(fixed_t *fixed)
{
    const estimator_q_t *q = &fixed->q;
    fixed->smo.emf_hat = pair_of(q->smo.emf_hat, fixed->units.voltage);
    fixed->smo.gain_axis = pair_of(q->smo.gain_axis, 16.0f * fixed->units.gain);
    fixed->smo.gain_mean = (float)q->smo.gain_mean * fixed->units.gain;
    fixed->smo.current_err = pair_of(q->smo.current_err, fixed->units.current);
    fixed->pll.omega_smooth = (float)q->pll.omega_smooth * fixed->units.speed;
    fixed->pll.amplitude = (float)q->pll.amplitude * fixed->units.voltage;
    fixed->pll.detector = (float)q->pll.detector / TWO_TO_30;
    fixed->emf = pair_of(q->emf, fixed->units.voltage);
    fixed->flux_linkage = fixed->flux_per_count / (float)lowpass_value_q(&q->speed_per_volt);
    fixed->invalid = q->invalid;
}

static position_t position_of(const fixed_t *fixed, position_q_t q)
{
    position_t position;
    position.theta_e = bounds_clamp((float)q_signed(q.theta_e) * (ANGLE_TWO_PI / TWO_TO_32), ANGLE_LARGEST);
    position.omega_e = (float)q.omega_e * fixed->units.speed;
    return position;
}

static uint32_t angle_of(float theta_e)
{
    return (uint32_t)counts_of(angle_wrap(theta_e), TWO_TO_32 / ANGLE_TWO_PI);
}

void fixed_retune(fixed_t *fixed, const estimator_params_t *params)
{
    params_error_t why;
    CHECK(fixed_params_check(params, &why));

    const bases_t base = bases_of(params);
    const fixed_units_t before = fixed->units;
    set_units(fixed, &base);
    const bool moved = before.voltage != fixed->units.voltage || before.current != fixed->units.current ||
                       before.speed != fixed->units.speed;
    if (before.speed > 0.0f && moved) {
        rebase(&fixed->q, before.voltage / fixed->units.voltage, before.current / fixed->units.current,
               before.speed / fixed->units.speed);
    }
    const estimator_params_q_t q = per_unit(params, &base);
    if (params->flux_linkage == fixed->flux_linkage_set) {
        fixed->q.params.speed_per_volt = q.speed_per_volt; /* in other bases the same */
    }
    fixed->flux_linkage_set = params->flux_linkage;
    estimator_retune_q(&fixed->q, &q);
    show(fixed);
}

void fixed_init(fixed_t *fixed, const estimator_params_t *params)
{
    params_error_t why;
    CHECK(fixed_params_check(params, &why));

    const bases_t base = bases_of(params);
    const estimator_params_q_t q = per_unit(params, &base);
    set_units(fixed, &base);
    fixed->flux_linkage_set = params->flux_linkage;
    estimator_init_q(&fixed->q, &q);
    show(fixed);
}

void fixed_reset(fixed_t *fixed, position_t start, ab_t current)
{
    const position_q_t from = {angle_of(start.theta_e), counts_of(start.omega_e, fixed->speed_counts)};
    estimator_reset_q(&fixed->q, from, current_of(fixed, current));
    show(fixed);
}

position_t fixed_step(fixed_t *fixed, ab_t voltage, ab_t current)
{
    const position_q_t position =
        estimator_step_q(&fixed->q, voltage_of(fixed, voltage), current_of(fixed, current));
    show(fixed);
    return position_of(fixed, position);
}

position_t fixed_coast(fixed_t *fixed, ab_t voltage, ab_t current)
{
    const position_q_t position =
        estimator_coast_q(&fixed->q, voltage_of(fixed, voltage), current_of(fixed, current));
    show(fixed);
    return position_of(fixed, position);
}

void fixed_judge(fixed_t *fixed, uint32_t periods)
{
    estimator_judge_q(&fixed->q, periods);
    fixed->invalid = fixed->q.invalid;
}

uint16_t fixed_invalid(const fixed_t *fixed)
{
    return estimator_invalid_q(&fixed->q);
}
