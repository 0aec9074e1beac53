#include "estimator/smo.h"

#include "math/check.h"
#include "math/exponential.h"

/* Below this mean square of the error [A^2] there is nothing to weight with. */
#define SQUARE_FLOOR 1e-24f

/* Largest (|emf|/k_s)^2 that smo_reset inverts the switching function for. */
#define RESET_SQUARE_MAX 0.98f

/* Newton's method on tanh^2: seven steps reach float accuracy from the worst start. */
#define RESET_STEPS 10

bool smo_params_check(const smo_params_t *params, params_error_t *why)
{
    if (!params_within(why, "resistance", PARAMS_RANGE, params->resistance, 1e-3f, 100.0f) ||
        !params_within(why, "inductance", PARAMS_RANGE, params->inductance, 1e-6f, 1.0f) ||
        !params_within(why, "gain", PARAMS_RANGE, params->gain, 0.1f, 1e4f) ||
        !params_within(why, "slope", PARAMS_RANGE, params->slope, 1e-3f, 1e3f) ||
        !params_within(why, "emf_cutoff", PARAMS_RANGE, params->emf_cutoff, 0.0f, 1e5f) ||
        !params_within(why, "period", PARAMS_RANGE, params->period, 1e-6f, 1e-2f) ||
        !params_within(why, "switching", PARAMS_RANGE, (float)params->switching, (float)SMO_SIGN,
                       (float)SMO_SIGMOID_VECTOR)) {
        return false;
    }

    float period_max = 0.5f * params->inductance / params->resistance;
    if (params->period > period_max) {
        return params_refuse(why, "period", "period <= inductance / (2 resistance)", params->period, 1e-6f,
                             period_max);
    }

    if (params->switching != SMO_SIGN) {
        float voltage_gain =
            exponential_rest(params->resistance * params->period / params->inductance) / params->resistance;
        float gain_max = 2.0f * SMO_LOOP_GAIN_MAX / (voltage_gain * params->slope);
        if (params->gain > gain_max) {
            return params_refuse(why, "gain", "loop gain per sample: b gain slope / 2 <= 1.2", params->gain,
                                 0.1f, gain_max);
        }
    }
    return true;
}

void smo_retune(smo_t *smo, const smo_params_t *params)
{
    float decay = params->resistance * params->period / params->inductance;
    float rest = exponential_rest(decay);
    smo->resistance = params->resistance;
    smo->inductance = params->inductance;
    smo->period = params->period;
    smo->voltage_gain = rest / params->resistance;
    smo->gain = params->gain;
    smo->half_slope = 0.5f * params->slope;
    float unit = 1.0f / smo->half_slope; /* the error at which a_f |x|/2 is 1 [A] */
    smo->settled_square = TANH_SHORT_END * unit * unit;
    smo->settled_p0 = TANH_P0 * unit * unit * unit;
    smo->settled_p1 = TANH_P1 * unit;
    smo->settled_q0 = TANH_P0 * unit * unit * unit * unit;
    smo->settled_q1 = TANH_Q1 * unit * unit;
    smo->emf_decay = params->emf_cutoff > 0.0f ? exponential(-params->emf_cutoff * params->period) : 0.0f;
    if (smo->filtering == 0u && params->emf_cutoff > 0.0f) {
        smo->switched = smo->emf_hat;
    }
    smo->filtering = params->emf_cutoff > 0.0f;
    smo->mean_share = exponential_rest(SMO_GAIN_CUTOFF * params->period);
    smo->half_period = 0.5f * params->period;
    smo->loop_gain_unit = smo->voltage_gain * params->gain;
    smo->current_loss = rest;
    smo->hold_lead = decay * (1.0f / 6.0f - decay * decay * (1.0f / 360.0f));
    smo->hold_lead_rise = decay * (1.0f / 90.0f);
    smo->hold_size = 1.33269238f + decay * decay * (1.0f / 120.0f + 1.0f / 72.0f);
    smo->hold_cotangent = 1.0f / 3.0f + decay * decay * (1.0f / 90.0f);
    smo->lag_resistance = 2.0f / smo->voltage_gain - params->resistance;
    smo->filter_odd = 2.0f * smo->emf_decay / (1.0f - smo->emf_decay);
    smo->filter_even = 1.0f + smo->filter_odd;
    smo->switching = (int32_t)params->switching;
}

static float sign_of(float x)
{
    return x > 0.0f ? 1.0f : (x < 0.0f ? -1.0f : 0.0f);
}

static float sign_gain(float x)
{
    float length = x < 0.0f ? -x : x;
    return length * SMO_SIGN_GAIN_MAX > 1.0f ? 1.0f / length : SMO_SIGN_GAIN_MAX;
}

float smo_vector_gain(const smo_t *smo, float square)
{
    return square <= smo->settled_square
               ? smo_settled_gain(smo, square)
               : smo->half_slope * tanh_ratio_far(smo->half_slope * smo->half_slope * square);
}

static ab_t switch_vector(smo_t *smo, ab_t x, float square)
{
    float k_f = smo_vector_gain(smo, square);
    float g = smo->gain * k_f;
    smo->gain_mean = k_f;
    return (ab_t){g * x.alpha, g * x.beta};
}

static ab_t switch_sign(smo_t *smo, ab_t x)
{
    smo->gain_axis = (ab_t){sign_gain(x.alpha), sign_gain(x.beta)};
    return (ab_t){smo->gain * sign_of(x.alpha), smo->gain * sign_of(x.beta)};
}

static ab_t switch_sigmoid(smo_t *smo, ab_t x)
{
    float h = smo->half_slope;
    float alpha = h * x.alpha;
    float beta = h * x.beta;
    smo->gain_axis = (ab_t){h * tanh_ratio(alpha * alpha), h * tanh_ratio(beta * beta)};
    return (ab_t){smo->gain * smo->gain_axis.alpha * x.alpha, smo->gain * smo->gain_axis.beta * x.beta};
}

/* The power-weighted gain of both axes; `share` of the present sample goes into the means. */
static void weight_gain(smo_t *smo, float share)
{
    ab_t x = smo->current_err;
    bool sign = smo->switching == (int32_t)SMO_SIGN;
    float product = sign ? sign_of(x.alpha) * x.alpha + sign_of(x.beta) * x.beta
                         : smo->gain_axis.alpha * x.alpha * x.alpha + smo->gain_axis.beta * x.beta * x.beta;
    smo->mean_product += share * (product - smo->mean_product);
    smo->mean_square += share * (smo_error_square(smo) - smo->mean_square);
    float largest = sign ? SMO_SIGN_GAIN_MAX : smo->half_slope;
    bool known = smo->mean_square > SQUARE_FLOOR && smo->mean_product < largest * smo->mean_square;
    smo->gain_mean = known ? smo->mean_product / smo->mean_square : largest;
}

/* v and k_f of the forms that act on each axis; `share` as in weight_gain. */
static ab_t switch_axes(smo_t *smo, ab_t x, float share)
{
    ab_t v = smo->switching == (int32_t)SMO_SIGN ? switch_sign(smo, x) : switch_sigmoid(smo, x);
    weight_gain(smo, share);
    return v;
}

void smo_init(smo_t *smo, const smo_params_t *params)
{
    params_error_t why;
    CHECK(smo_params_check(params, &why));
    smo->filtering = 1u;
    smo_retune(smo, params);
    smo_reset(smo, (ab_t){0.0f, 0.0f}, (ab_t){0.0f, 0.0f});
}

/* tanh(sqrt z)/sqrt z at the z where tanh(sqrt z)^2 = `square`. tanh^2 is concave in z and not above it, so
 * Newton's method from z = square climbs to the root without passing it; no square root is needed. */
static float settled_ratio(float square)
{
    float target = square < RESET_SQUARE_MAX ? square : RESET_SQUARE_MAX;
    float z = target;
    float ratio = tanh_ratio(z);
    for (int32_t n = 0; n < RESET_STEPS; n++) {
        float reached = z * ratio * ratio;
        z += (target - reached) / (ratio * (1.0f - reached));
        ratio = tanh_ratio(z);
    }
    return ratio;
}

void smo_preset_error(smo_t *smo, ab_t current, ab_t error)
{
    smo->current_err = error;
    smo->current_hat.alpha = current.alpha + error.alpha;
    smo->current_hat.beta = current.beta + error.beta;
    smo->mean_product = 0.0f;
    smo->mean_square = 0.0f;
    if (smo->switching == (int32_t)SMO_SIGMOID_VECTOR) {
        smo->switched = switch_vector(smo, error, smo_error_square(smo));
    } else {
        smo->switched = switch_axes(smo, error, 1.0f);
    }
    smo->emf_hat = smo->switched;
    smo->passed_over = 0u;
}

void smo_preset(smo_t *smo, ab_t current, ab_t switched, ab_t emf_hat)
{
    float per_volt = 1.0f / smo->gain;
    ab_t f = {switched.alpha * per_volt, switched.beta * per_volt};
    ab_t x = {0.0f, 0.0f};
    switch ((smo_switching_t)smo->switching) {
    case SMO_SIGN:
        break;
    case SMO_SIGMOID:
        x.alpha = f.alpha / (smo->half_slope * settled_ratio(f.alpha * f.alpha));
        x.beta = f.beta / (smo->half_slope * settled_ratio(f.beta * f.beta));
        break;
    case SMO_SIGMOID_VECTOR: {
        float per_unit = 1.0f / (smo->half_slope * settled_ratio(f.alpha * f.alpha + f.beta * f.beta));
        x.alpha = per_unit * f.alpha;
        x.beta = per_unit * f.beta;
        break;
    }
    }

    smo_preset_error(smo, current, x);
    if (smo->switching == (int32_t)SMO_SIGN) {
        smo->switched = switched;
    }
    smo->emf_hat = emf_hat;
}

void smo_reset(smo_t *smo, ab_t current, ab_t emf)
{
    smo_preset(smo, current, emf, emf);
    smo->emf_hat = smo->switched;
}

ab_t smo_step(smo_t *smo, ab_t voltage, ab_t current)
{
    ab_t hat = smo->current_hat;
    ab_t v = smo->filtering != 0u ? smo->switched : smo->emf_hat;
    hat.alpha += smo->voltage_gain * (voltage.alpha - v.alpha - smo->resistance * hat.alpha);
    hat.beta += smo->voltage_gain * (voltage.beta - v.beta - smo->resistance * hat.beta);
    ab_t x = {hat.alpha - current.alpha, hat.beta - current.beta};
    float square = x.alpha * x.alpha + x.beta * x.beta;
    if (!(square <= SMO_ERROR_LIMIT * SMO_ERROR_LIMIT)) {
        smo->passed_over = 1u;
        return smo->emf_hat;
    }

    smo->passed_over = 0u;
    smo->current_hat = hat;
    smo->current_err = x;
    if (smo->switching == (int32_t)SMO_SIGMOID_VECTOR) {
        v = switch_vector(smo, x, square);
    } else {
        v = switch_axes(smo, x, smo->mean_share);
    }
    smo->switched = v;
    if (smo->filtering != 0u) {
        v.alpha += smo->emf_decay * (smo->emf_hat.alpha - v.alpha);
        v.beta += smo->emf_decay * (smo->emf_hat.beta - v.beta);
    }
    smo->emf_hat = v;
    return v;
}

float smo_equivalent_gain(const smo_t *smo)
{
    return smo->gain_mean;
}
