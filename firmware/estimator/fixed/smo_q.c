#include "estimator/fixed/smo_q.h"

#include <stdbool.h>

#include "math/root_q.h"

/* Bits that the means keep for their quotient; below 2^MEAN_BITS counts of 2^-57 the quotient is not
 * computed. */
#define MEAN_BITS 24
#define MEAN_Q    26

/* Largest (|emf|/k_s)^2 for which a reset inverts the switching function, and its Newton steps: as in
 * smo.c. */
#define RESET_SQUARE_MAX Q_CONST(UNIT_Q, 0.98f)
#define RESET_STEPS      10
#define RESET_Q          27 /* of tanh's argument, squared: up to 16 */

void smo_take_q(smo_q_t *smo, const smo_tuning_q_t *tuning)
{
    smo->tuning = *tuning;
    smo->mean_product.alpha = tuning->mean_share;
    smo->mean_square.alpha = tuning->mean_share;
}

static int32_t sign_of(int32_t x)
{
    return (x > 0) - (x < 0);
}

/* 1/|x| as a k_f of one axis, limited. Below 2^-11 it does not fit. */
static int32_t sign_gain(const smo_q_t *smo, int32_t x)
{
    int32_t length = q_magnitude(x);
    if (length < Q_ONE(CURRENT_Q - 11)) {
        return smo->tuning.axis_gain_largest;
    }
    int32_t gain = quotient_q(Q_ONE(20), reciprocal_q(length), CURRENT_Q + AXIS_GAIN_Q - 20);
    return q_clamp(gain, smo->tuning.axis_gain_largest);
}

/* a_f/2 tanh(y)/y as k_f: Q26 times Q30. */
static int32_t gain_of(const smo_q_t *smo, int32_t ratio)
{
    return q_high(smo->tuning.half_slope, ratio);
}

static ab_q_t switch_vector(smo_q_t *smo, ab_q_t x)
{
    int32_t ratio = tanh_ratio_q(q_square_sum(smo_stretched_q(smo, x.alpha), smo_stretched_q(smo, x.beta)));
    smo->gain_mean = gain_of(smo, ratio);
    smo->conductance = q_high(smo->tuning.gain_slope, ratio);
    return (ab_q_t){smo_switched_q(smo->conductance, x.alpha), smo_switched_q(smo->conductance, x.beta)};
}

/* One axis: f in Q30, and its k_f. */
static int32_t switch_axis(const smo_q_t *smo, int32_t x, int32_t *k_f)
{
    if (smo->tuning.switching == (int32_t)SMO_SIGN) {
        *k_f = sign_gain(smo, x);
        return sign_of(x) * Q_ONE(UNIT_Q);
    }
    int32_t y = smo_stretched_q(smo, x);
    int32_t ratio = tanh_ratio_q(q_square(y));
    *k_f = gain_of(smo, ratio) >> (IMPEDANCE_Q - AXIS_GAIN_Q);
    return q_clamp(q_multiply_saturated(ratio, y, STRETCHED_Q), Q_ONE(UNIT_Q));
}

/* product/square of the two means as a k_f, at most `largest`. */
static int32_t weighted(int64_t product, int64_t square, int32_t largest)
{
    if (square < (INT64_C(1) << MEAN_BITS)) {
        return largest;
    }
    int32_t spare = 64 - MEAN_BITS - q_leading_zeros((uint64_t)square);
    int32_t denominator = q_saturate(spare > 0 ? q_floor(square, spare) : square);
    int64_t numerator = spare > 0 ? q_floor(product, spare) : product;
    if (numerator <= 0 || numerator >= q_round(q_product(largest, denominator), IMPEDANCE_Q)) {
        return largest;
    }
    return quotient_q(q_saturate(numerator), reciprocal_q(denominator), IMPEDANCE_Q);
}

static int32_t within_filter(int64_t value)
{
    return (int32_t)q_clamp_long(value, FILTER_Q_LARGEST);
}

/* v and k_f of the forms that act on each axis; the flag is true where the means begin with this sample. */
static ab_q_t switch_axes(smo_q_t *smo, ab_q_t x, bool anew)
{
    int32_t alpha = switch_axis(smo, x.alpha, &smo->gain_axis.alpha);
    int32_t beta = switch_axis(smo, x.beta, &smo->gain_axis.beta);
    int64_t power = q_product(alpha, x.alpha) + q_product(beta, x.beta);
    int64_t length_square = q_product(x.alpha, x.alpha) + q_product(x.beta, x.beta);
    int32_t product = within_filter(q_round(power, UNIT_Q + CURRENT_Q - MEAN_Q));
    int32_t square = within_filter(q_round(length_square, 2 * CURRENT_Q - MEAN_Q));
    if (anew) {
        lowpass_reset_q(&smo->mean_product, product);
        lowpass_reset_q(&smo->mean_square, square);
    } else {
        (void)lowpass_step_q(&smo->mean_product, product);
        (void)lowpass_step_q(&smo->mean_square, square);
    }
    int32_t largest =
        smo->tuning.switching == (int32_t)SMO_SIGN ? smo->tuning.gain_largest : gain_of(smo, Q_ONE(UNIT_Q));
    smo->gain_mean = weighted(smo->mean_product.value, smo->mean_square.value, largest);
    smo->conductance = q_clamp(q_multiply(smo->tuning.gain, smo->gain_mean, GAIN_Q), CONDUCTANCE_LARGEST);
    return (ab_q_t){q_multiply(smo->tuning.gain, alpha, GAIN_Q + UNIT_Q - VOLTAGE_Q),
                    q_multiply(smo->tuning.gain, beta, GAIN_Q + UNIT_Q - VOLTAGE_Q)};
}

/* The selection of the form: v of the error x, and its k_f. */
static ab_q_t switched_by(smo_q_t *smo, ab_q_t x, bool anew)
{
    return smo->tuning.switching == (int32_t)SMO_SIGMOID_VECTOR ? switch_vector(smo, x)
                                                                : switch_axes(smo, x, anew);
}

/* tanh(y)/y, Q30, at the y where tanh(y)^2 = `square`; Newton's method as in smo.c. */
static int32_t ratio_at(int32_t square)
{
    int32_t target = q_clamp(square, RESET_SQUARE_MAX);
    int32_t z = target >> (UNIT_Q - RESET_Q);
    int32_t ratio = tanh_ratio_q((uint64_t)z << (TANH_Q_SQUARE - RESET_Q));
    for (int32_t n = 0; n < RESET_STEPS; n++) {
        int32_t ratio_square = q_multiply(ratio, ratio, UNIT_Q);
        int32_t reached = q_clamp(q_multiply_saturated(z, ratio_square, RESET_Q), RESET_SQUARE_MAX);
        int32_t slope = q_multiply(ratio, Q_ONE(UNIT_Q) - reached, UNIT_Q);
        int32_t to = q_add(z, quotient_q(target - reached, reciprocal_q(slope), RESET_Q));
        z = to < 0 ? 0 : to;
        ratio = tanh_ratio_q((uint64_t)z << (TANH_Q_SQUARE - RESET_Q));
    }
    return ratio;
}

/* f/(a_f/2 ratio), within the range of the error. */
static int32_t error_for(const smo_q_t *smo, int32_t f, int32_t ratio)
{
    int32_t slope = q_multiply(smo->tuning.half_slope, ratio, UNIT_Q);
    return q_clamp(quotient_q(f, reciprocal_q(slope), SLOPE_Q + CURRENT_Q - UNIT_Q), ERROR_LARGEST);
}

/* v/k_s, Q30. */
static int32_t share_of_gain(int32_t v, root_q_t per_gain)
{
    int32_t within = q_clamp(v, SWITCHED_LARGEST - 1) * Q_ONE(UNIT_Q - VOLTAGE_Q);
    return q_clamp(quotient_q(within, per_gain, GAIN_Q), Q_ONE(UNIT_Q));
}

static int32_t to_unit(uint64_t square)
{
    uint64_t unit = square >> UNIT_Q;
    return unit > (uint64_t)Q_ONE(UNIT_Q) ? Q_ONE(UNIT_Q) : (int32_t)unit;
}

static ab_q_t within(ab_q_t voltage)
{
    return (ab_q_t){q_clamp(voltage.alpha, SWITCHED_LARGEST), q_clamp(voltage.beta, SWITCHED_LARGEST)};
}

void smo_reset_error_q(smo_q_t *smo, ab_q_t current, ab_q_t error)
{
    smo->current_err = error;
    smo->current_hat.alpha = q_clamp(current.alpha, SAMPLE_LARGEST) + error.alpha;
    smo->current_hat.beta = q_clamp(current.beta, SAMPLE_LARGEST) + error.beta;
    smo->switched = switched_by(smo, error, true);
    smo->emf_hat = smo->switched;
    smo->rejected = 0u;
}

void smo_reset_q(smo_q_t *smo, ab_q_t current, ab_q_t emf)
{
    root_q_t per_gain = reciprocal_q(smo->tuning.gain);
    ab_q_t f = {share_of_gain(emf.alpha, per_gain), share_of_gain(emf.beta, per_gain)};
    ab_q_t x = {0, 0};
    switch ((smo_switching_t)smo->tuning.switching) {
    case SMO_SIGN:
        break;
    case SMO_SIGMOID:
        x.alpha = error_for(smo, f.alpha, ratio_at(to_unit(q_square(f.alpha))));
        x.beta = error_for(smo, f.beta, ratio_at(to_unit(q_square(f.beta))));
        break;
    case SMO_SIGMOID_VECTOR: {
        int32_t ratio = ratio_at(to_unit(q_square_sum(f.alpha, f.beta)));
        x.alpha = error_for(smo, f.alpha, ratio);
        x.beta = error_for(smo, f.beta, ratio);
        break;
    }
    }

    smo_reset_error_q(smo, current, x);
    if (smo->tuning.switching == (int32_t)SMO_SIGN) {
        smo->switched = within(emf);
        smo->emf_hat = smo->switched;
    }
}

static int32_t filtered(const smo_q_t *smo, int32_t v, int32_t emf_hat)
{
    return q_clamp(v + q_multiply(smo->tuning.emf_decay, emf_hat - v, SHARE_Q), SWITCHED_LARGEST);
}

ab_q_t smo_step_q(smo_q_t *smo, ab_q_t voltage, ab_q_t current)
{
    if (!smo_measured_q(voltage.alpha) || !smo_measured_q(voltage.beta) || !smo_measured_q(current.alpha) ||
        !smo_measured_q(current.beta)) {
        smo->rejected = 1u;
        return smo->emf_hat;
    }

    ab_q_t hat = smo->current_hat;
    ab_q_t v = smo->switched;
    ab_q_t x = {q_clamp(smo_error_q(smo, hat.alpha, voltage.alpha - v.alpha, current.alpha), ERROR_LARGEST),
                q_clamp(smo_error_q(smo, hat.beta, voltage.beta - v.beta, current.beta), ERROR_LARGEST)};
    smo->rejected = 0u;
    smo->current_hat = (ab_q_t){current.alpha + x.alpha, current.beta + x.beta};
    smo->current_err = x;
    v = switched_by(smo, x, false);
    smo->switched = v;
    smo->emf_hat.alpha = filtered(smo, v.alpha, smo->emf_hat.alpha);
    smo->emf_hat.beta = filtered(smo, v.beta, smo->emf_hat.beta);
    return smo->emf_hat;
}

int32_t smo_equivalent_gain_q(const smo_q_t *smo)
{
    return smo->gain_mean;
}
