#include "estimator/lag.h"

#include "math/bounds.h"
#include "math/root.h"
#include "math/trig.h"

/* A vector, or what multiplies one. */
typedef struct {
    float re, im;
} complex_t;

static complex_t product(complex_t a, complex_t b)
{
    complex_t result = {a.re * b.re - a.im * b.im, a.re * b.im + a.im * b.re};
    return result;
}

/* Polynomials for |h| <= LAG_TURN_LIMIT/2: tan h within 4e-7 of it, and (cos h)^3 h/sin h within 6e-6, its
 * first coefficient apart (smo_t has it). */
#define TAN_1  1.00000763f
#define TAN_3  0.33276332f
#define TAN_5  0.14390343f
#define SIZE_4 0.62474806f

/* For lag_error(). So many steps leave 1e-7 of an EMF of 0.7 k_s, 3e-4 of one of 0.9 k_s and 2 % of the
 * longest. */
#define ERROR_STEPS   4
#define EMF_SHARE_MAX 0.99f

static float limited(float h)
{
    return bounds_clamp(h, 0.5f * LAG_TURN_LIMIT);
}

/* The filter's share times (1 + t^2), t = tan(x/2): (1 - c/z)/(1 - c) = 1 + c/(1 - c) (1 - 1/z). */
static complex_t filter_of(const smo_t *smo, float t)
{
    complex_t vector = {1.0f + smo->filter_even * t * t, smo->filter_odd * t};
    return vector;
}

/* e/e_hat: angle and length of all that observer, hold and filter do to the EMF, backwards. With h = x/2 and
 * t = tan h, (z - p) = z^1/2 cos h ((1 - p) + j (1 + p) t); the half period in z^1/2 is that of the hold,
 * whose rest `lead` turns the vector a little; what is left of the lengths is one even series in h. */
static complex_t undoing(const smo_t *smo, float omega_e)
{
    float h = limited(omega_e * smo->half_period);
    float square = h * h;
    float t = h * (TAN_1 + square * (TAN_3 + square * TAN_5));
    float lead = h * (smo->hold_lead + square * smo->hold_lead_rise);

    float loop_gain = smo->loop_gain_unit * smo_equivalent_gain(smo); /* b g */
    float real = loop_gain + smo->current_loss;                       /* 1 - p = b (g + R) */
    float imag = (2.0f - real) * t;
    complex_t observer = {real + lead * imag, imag - lead * real};

    complex_t both = product(observer, filter_of(smo, t));
    float size = (1.0f - square * (smo->hold_size - square * SIZE_4)) / loop_gain;
    both.re *= size;
    both.im *= size;
    return both;
}

float lag_angle(const smo_t *smo, lag_mode_t mode, float omega_e)
{
    float g = smo->gain * smo_equivalent_gain(smo);
    switch (mode) {
    case LAG_NONE:
        break;
    case LAG_PRINTED:
        return trig_atan2(omega_e * smo->inductance, g * smo->resistance + smo->resistance);
    case LAG_CORRECTED:
        return trig_atan2(omega_e * smo->inductance, g + smo->resistance);
    case LAG_EXACT: {
        complex_t vector = undoing(smo, omega_e);
        return trig_atan2(vector.im, vector.re);
    }
    }
    return 0.0f;
}

float lag_attenuation(const smo_t *smo, float omega_e)
{
    complex_t vector = undoing(smo, omega_e);
    return inverse_root(vector.re * vector.re + vector.im * vector.im);
}

/* The paper's modes turn by their angle and stretch by the true attenuation. */
static complex_t undoing_of_paper(const smo_t *smo, lag_mode_t mode, float omega_e)
{
    rotation_t turned = trig_rotation(lag_angle(smo, mode, omega_e));
    float size = 1.0f / lag_attenuation(smo, omega_e);
    complex_t vector = {size * turned.cos, size * turned.sin};
    return vector;
}

ab_t lag_emf(const smo_t *smo, lag_mode_t mode, float omega_e)
{
    if (mode != LAG_EXACT) {
        complex_t emf =
            product(undoing_of_paper(smo, mode, omega_e), (complex_t){smo->emf_hat.alpha, smo->emf_hat.beta});
        return (ab_t){emf.re, emf.im};
    }
    if (smo->switching == (int32_t)SMO_SIGMOID_VECTOR) {
        return lag_emf_exact(smo, smo->current_err, omega_e);
    }
    float per_g = 1.0f / (smo->gain * smo->gain_mean);
    return lag_emf_exact(smo, (ab_t){per_g * smo->switched.alpha, per_g * smo->switched.beta}, omega_e);
}

/* |e| = |z(k_s k_f(y))| y in the length y of the error is concave, so Newton's method climbs from the y of
 * the largest gain to the root without passing it. Its slope is (R + k_s a_f/2 (1 - tanh^2)) |z|/(g + R), but
 * for what h changes in it. */
ab_t lag_error(const smo_t *smo, float omega_e, ab_t emf)
{
    float square = emf.alpha * emf.alpha + emf.beta * emf.beta;
    float length = square * inverse_root(square);
    float longest = EMF_SHARE_MAX * smo->gain;
    if (length > longest) {
        float share = longest / length;
        emf = (ab_t){share * emf.alpha, share * emf.beta};
        length = longest;
    }

    float slope_max = smo->gain * smo->half_slope;
    float y = 0.0f;
    lag_impedance_t z = lag_impedance(smo, slope_max, omega_e);
    float z_square = z.re * z.re + z.im * z.im;
    float along = slope_max + smo->resistance;
    float slope = along;
    for (int32_t n = 0; n < ERROR_STEPS; n++) {
        y += (length * inverse_root(z_square) - y) * along / slope;
        float k_f = smo_vector_gain(smo, y * y);
        z = lag_impedance(smo, smo->gain * k_f, omega_e);
        z_square = z.re * z.re + z.im * z.im;
        along = smo->gain * k_f + smo->resistance;
        slope = smo->resistance + slope_max * (1.0f - k_f * k_f * y * y);
    }
    float per_square = 1.0f / z_square; /* e/z */
    return (ab_t){per_square * (z.re * emf.alpha + z.im * emf.beta),
                  per_square * (z.re * emf.beta - z.im * emf.alpha)};
}

void lag_make(const smo_t *smo, float omega_e, ab_t emf, ab_t *switched, ab_t *emf_hat)
{
    complex_t undo = undoing(smo, omega_e);
    float size = 1.0f / (undo.re * undo.re + undo.im * undo.im);
    complex_t make = {size * undo.re, -size * undo.im};
    complex_t late = product(make, (complex_t){emf.alpha, emf.beta});

    float h = limited(omega_e * smo->half_period);
    float t = h * (TAN_1 + h * h * (TAN_3 + h * h * TAN_5));
    complex_t before = product(late, filter_of(smo, t));
    float cosine_square = 1.0f / (1.0f + t * t);
    *switched = (ab_t){before.re * cosine_square, before.im * cosine_square};
    *emf_hat = (ab_t){late.re, late.im};
}
