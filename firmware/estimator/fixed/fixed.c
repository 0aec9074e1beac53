#include "estimator/fixed/fixed.h"

#include "math/angle.h"
#include "math/bounds.h"
#include "math/check.h"
#include "math/root.h"
#include "math/trig_q.h"

#define TWO_TO_25 33554432.0f
#define TWO_TO_27 134217728.0f
#define TWO_TO_30 1073741824.0f
#define TWO_TO_31 2147483648.0f
#define TWO_TO_32 4294967296.0f

bool fixed_params_check(const estimator_params_t *params, params_error_t *why)
{
    return estimator_params_check(params, why) && per_unit_check(params, why);
}

static void prepare_scale(fixed_scale_t *scale, const bases_t *base)
{
    scale->units.voltage = base->voltage / TWO_TO_27;
    scale->units.current = base->current / TWO_TO_25;
    scale->units.speed = 1.0f / (base->turn_per_rad * TWO_TO_31);
    scale->units.gain = 2.0f / TWO_TO_25 / base->current;
    scale->voltage_counts = TWO_TO_27 / base->voltage;
    scale->current_counts = TWO_TO_25 / base->current;
    scale->speed_counts = base->turn_per_rad * TWO_TO_31;
    scale->base = *base;
}

void fixed_prepare(fixed_tuning_t *tuning, const estimator_params_t *params)
{
    params_error_t why;
    CHECK(fixed_params_check(params, &why));

    const bases_t base = per_unit_bases(params);
    prepare_scale(&tuning->scale, &base);
    tuning->q = per_unit_of(params, &base);
    tuning->flux_linkage = params->flux_linkage;
}

/* ---- the state in other bases ---- */

static void move(int32_t *value, float ratio)
{
    *value = per_unit_counts((float)*value, ratio);
}

static void move_pair(ab_q_t *pair, float ratio)
{
    move(&pair->alpha, ratio);
    move(&pair->beta, ratio);
}

static void move_mean(lowpass_q_t *mean, float ratio)
{
    lowpass_reset_q(mean, per_unit_counts((float)lowpass_value_q(mean), ratio));
}

static void move_speed(int64_t *speed, float ratio)
{
    *speed = (int64_t)per_unit_counts((float)q_floor(*speed, LONG_SPEED_Q - SPEED_Q), ratio) *
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
    move_pair(&q->emf, voltage);
}

void fixed_take(fixed_t *fixed, const fixed_tuning_t *tuning)
{
    const fixed_units_t before = fixed->scale.units;
    const fixed_units_t now = tuning->scale.units;
    const bool moved =
        before.voltage != now.voltage || before.current != now.current || before.speed != now.speed;
    if (before.speed > 0.0f && moved) {
        rebase(&fixed->q, before.voltage / now.voltage, before.current / now.current,
               before.speed / now.speed);
    }
    fixed->scale = tuning->scale;
    fixed->flux_linkage = tuning->flux_linkage;
    estimator_take_q(&fixed->q, &tuning->q);
}

void fixed_init(fixed_t *fixed, const estimator_params_t *params)
{
    const position_t origin = {0.0f, 0.0f};
    const ab_t none = {0.0f, 0.0f};
    fixed_tuning_t tuning;
    fixed_prepare(&tuning, params);
    fixed->scale.units.speed = 0.0f; /* no state yet */
    fixed_take(fixed, &tuning);
    fixed->observed.gain_axis = none;
    fixed->q.smo.gain_axis = (ab_q_t){0, 0};
    fixed_reset(fixed, origin, none);
}

void fixed_set_flux(fixed_t *fixed, float flux_linkage, float speed_per_volt)
{
    fixed->flux_linkage = flux_linkage;
    fixed->q.speed_per_volt = per_unit_speed_per_volt(speed_per_volt, &fixed->scale.base);
}

void fixed_set_load(fixed_t *fixed, float current)
{
    fixed->q.load = q_clamp(per_unit_counts(current, fixed->scale.current_counts), SAMPLE_LARGEST);
}

/* ---- samples and results ---- */

static ab_t pair_of(ab_q_t pair, float unit)
{
    return (ab_t){(float)pair.alpha * unit, (float)pair.beta * unit};
}

static ab_q_t voltage_of(const fixed_t *fixed, ab_t voltage)
{
    return (ab_q_t){per_unit_counts(voltage.alpha, fixed->scale.voltage_counts),
                    per_unit_counts(voltage.beta, fixed->scale.voltage_counts)};
}

static ab_q_t current_of(const fixed_t *fixed, ab_t current)
{
    return (ab_q_t){per_unit_counts(current.alpha, fixed->scale.current_counts),
                    per_unit_counts(current.beta, fixed->scale.current_counts)};
}

static position_t position_of(const fixed_t *fixed, position_q_t q)
{
    position_t position;
    position.theta_e = bounds_clamp((float)q_signed(q.theta_e) * (ANGLE_TWO_PI / TWO_TO_32), ANGLE_LARGEST);
    position.omega_e = (float)q.omega_e * fixed->scale.units.speed;
    return position;
}

static rotation_t rotation_of(rotation_q_t q)
{
    return (rotation_t){.sin = (float)q.sin * (1.0f / TWO_TO_30), .cos = (float)q.cos * (1.0f / TWO_TO_30)};
}

/* Copies the integers after a step to the output, in SI units. */
static void publish(fixed_t *fixed, position_q_t position, rotation_q_t rotation)
{
    const estimator_q_t *q = &fixed->q;
    const fixed_units_t *units = &fixed->scale.units;
    const position_t at = position_of(fixed, position);
    fixed->estimate = (estimate_t){
        .frame = {at.theta_e, at.omega_e, rotation_of(rotation)},
        .omega_smooth = (float)q->pll.omega_smooth * units->speed,
        .emf = pair_of(q->emf, units->voltage),
        .emf_loop = {(float)q->pll.emf.d * units->voltage, (float)q->pll.emf.q * units->voltage},
        .amplitude = (float)q->pll.amplitude * units->voltage,
        .flux = fixed->flux_linkage,
        .detector = (float)q->pll.detector * (1.0f / TWO_TO_30),
        .invalid = estimator_invalid_q(q),
        .coasted = q->coasted,
    };
    fixed->observed = (observed_t){
        .current_err = pair_of(q->smo.current_err, units->current),
        .emf_hat = pair_of(q->smo.emf_hat, units->voltage),
        .gain_axis = pair_of(q->smo.gain_axis, 16.0f * units->gain),
        .gain = (float)q->smo.gain_mean * units->gain,
    };
}

static uint32_t angle_of(float theta_e)
{
    return (uint32_t)per_unit_counts(angle_wrap(theta_e), TWO_TO_32 / ANGLE_TWO_PI);
}

void fixed_reset(fixed_t *fixed, position_t start, ab_t current)
{
    const position_q_t from = {angle_of(start.theta_e),
                               per_unit_counts(start.omega_e, fixed->scale.speed_counts)};
    estimator_reset_q(&fixed->q, from, current_of(fixed, current));
    publish(fixed, from, trig_rotation_q(from.theta_e));
}

position_t fixed_step(fixed_t *fixed, ab_t voltage, ab_t current)
{
    const rotation_q_t rotation = fixed->q.pll.rotation;
    const position_q_t position =
        estimator_step_q(&fixed->q, voltage_of(fixed, voltage), current_of(fixed, current));
    publish(fixed, position, rotation);
    return (position_t){fixed->estimate.frame.theta_e, fixed->estimate.frame.omega_e};
}

position_t fixed_coast(fixed_t *fixed, ab_t voltage, ab_t current)
{
    const rotation_q_t rotation = fixed->q.pll.rotation;
    const position_q_t position =
        estimator_coast_q(&fixed->q, voltage_of(fixed, voltage), current_of(fixed, current));
    publish(fixed, position, rotation);
    return (position_t){fixed->estimate.frame.theta_e, fixed->estimate.frame.omega_e};
}

void fixed_observe(fixed_t *fixed, ab_t voltage, ab_t current, float omega_e)
{
    estimate_t *estimate = &fixed->estimate;
    const frame_t frame = estimate->frame;
    const position_q_t none = {0u, 0};
    estimator_observe_q(&fixed->q, voltage_of(fixed, voltage), current_of(fixed, current),
                        per_unit_counts(omega_e, fixed->scale.speed_counts));
    publish(fixed, none, fixed->q.pll.rotation);
    const float square = estimate->emf.alpha * estimate->emf.alpha + estimate->emf.beta * estimate->emf.beta;
    estimate->frame = frame;
    estimate->amplitude = square * inverse_root(square);
    estimate->detector = 0.0f;
}

void fixed_lock(fixed_t *fixed, position_t start, float amplitude)
{
    const position_q_t from = {angle_of(start.theta_e),
                               per_unit_counts(start.omega_e, fixed->scale.speed_counts)};
    estimator_lock_q(&fixed->q, from, per_unit_counts(amplitude, fixed->scale.voltage_counts));
    publish(fixed, from, trig_rotation_q(from.theta_e));
}

uint16_t fixed_invalid(const fixed_t *fixed)
{
    return (uint16_t)fixed->estimate.invalid;
}
