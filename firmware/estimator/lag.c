#include "estimator/lag.h"

#include "estimator/paper/lag_paper.h"
#include "math/bounds.h"
#include "math/root.h"
#include "math/trig.h"

/* For lag_error(). So many steps leave 1e-7 of an EMF of 0.7 k_s, 3e-4 of one of 0.9 k_s and 2 % of the
 * longest. */
#define ERROR_STEPS   4
#define EMF_SHARE_MAX 0.99f

/* What multiplies a vector. */
typedef struct {
    float re, im;
} complex_t;

static inline ab_t times(complex_t a, ab_t b)
{
    return (ab_t){a.re * b.alpha - a.im * b.beta, a.re * b.beta + a.im * b.alpha};
}

static inline ab_t over(ab_t b, complex_t a)
{
    float size = 1.0f / (a.re * a.re + a.im * a.im);
    return times((complex_t){size * a.re, -size * a.im}, b);
}

static float square_of(complex_t a)
{
    return a.re * a.re + a.im * a.im;
}

/* W at this omega T [rad]. */
static inline complex_t hold_of(const smo_tuning_t *tuning, float x)
{
    float square = x * x;
    return (complex_t){1.0f - square * (tuning->hold[1] - square * tuning->hold[3]),
                       x * (tuning->hold[0] - square * tuning->hold[2])};
}

/* Z [ohm] at this speed [rad/s] and g [ohm]. */
static inline complex_t impedance_of(const smo_tuning_t *tuning, float omega_e, float g)
{
    complex_t hold = hold_of(tuning, omega_e * tuning->period);
    return (complex_t){tuning->resistance + g * hold.re, omega_e * tuning->inductance + g * hold.im};
}

static float speed_within(const smo_t *smo, float omega_e)
{
    return bounds_clamp(omega_e, LAG_TURN_LIMIT / smo->tuning.period);
}

/* g [ohm] of the moment. */
static inline float conductance_of(const smo_t *smo)
{
    return smo->tuning.gain * smo->gain_mean;
}

/* v/e_hat of the filter (11): (1 - c/z)/(1 - c) = 1 + q (1 - 1/z), q = c/(1 - c), where 1 - 1/z = 2 sin(h)
 * (sin h + j cos h), h = omega T/2. */
static complex_t filter_of(const smo_t *smo, float omega_e)
{
    rotation_t half = trig_rotation(0.5f * omega_e * smo->tuning.period);
    float c = smo->tuning.emf_decay;
    float size = 2.0f * c / (1.0f - c) * half.sin;
    return (complex_t){1.0f + size * half.sin, size * half.cos};
}

/* e/e_hat times g: Z and the filter. */
static complex_t undoing(const smo_t *smo, float omega_e)
{
    float speed = speed_within(smo, omega_e);
    complex_t z = impedance_of(&smo->tuning, speed, conductance_of(smo));
    complex_t filter = filter_of(smo, speed);
    return (complex_t){z.re * filter.re - z.im * filter.im, z.re * filter.im + z.im * filter.re};
}

float lag_angle(const smo_t *smo, lag_mode_t mode, float omega_e)
{
    if (mode != LAG_EXACT) {
        return lag_paper_angle(smo, mode, omega_e);
    }
    complex_t vector = undoing(smo, omega_e);
    return trig_atan2(vector.im, vector.re);
}

float lag_attenuation(const smo_t *smo, float omega_e)
{
    return conductance_of(smo) * inverse_root(square_of(undoing(smo, omega_e)));
}

ab_t lag_emf(const smo_t *smo, lag_mode_t mode, float omega_e)
{
    if (mode != LAG_EXACT) {
        return lag_paper_emf(smo, mode, omega_e);
    }
    float g = conductance_of(smo);
    ab_t error = smo->current_err;
    if (smo->tuning.switching != (int32_t)SMO_SIGMOID_VECTOR) {
        float per_g = 1.0f / g;
        error = (ab_t){per_g * smo->switched.alpha, per_g * smo->switched.beta};
    }
    return times(impedance_of(&smo->tuning, omega_e, g), error);
}

/* |e| = |Z(k_s k_f(y))| y in the length y of the error is concave, so Newton's method climbs from the y of
 * the largest gain to the root without passing it. Its slope is (R + k_s a_f/2 (1 - tanh^2)) |Z|/(g + R), but
 * for what the speed changes in it. */
ab_t lag_error(const smo_t *smo, float omega_e, ab_t emf)
{
    const smo_tuning_t *tuning = &smo->tuning;
    float speed = speed_within(smo, omega_e);
    float square = emf.alpha * emf.alpha + emf.beta * emf.beta;
    float length = square * inverse_root(square);
    float longest = EMF_SHARE_MAX * tuning->gain;
    if (length > longest) {
        float share = longest / length;
        emf = (ab_t){share * emf.alpha, share * emf.beta};
        length = longest;
    }

    float slope_max = tuning->gain * tuning->half_slope;
    float y = 0.0f;
    float g = slope_max;
    float slope = slope_max + tuning->resistance;
    for (int32_t n = 0; n < ERROR_STEPS; n++) {
        float goal = length * inverse_root(square_of(impedance_of(tuning, speed, g)));
        y += (goal - y) * (g + tuning->resistance) / slope;
        float k_f = smo_vector_gain(smo, y * y);
        g = tuning->gain * k_f;
        slope = tuning->resistance + slope_max * (1.0f - k_f * k_f * y * y);
    }
    return over(emf, impedance_of(tuning, speed, g));
}

ab_t lag_switched(const smo_t *smo, float omega_e, ab_t emf)
{
    float g = conductance_of(smo);
    ab_t error = over(emf, impedance_of(&smo->tuning, speed_within(smo, omega_e), g));
    return (ab_t){g * error.alpha, g * error.beta};
}

ab_t lag_filtered(const smo_t *smo, float omega_e, ab_t switched)
{
    return over(switched, filter_of(smo, speed_within(smo, omega_e)));
}
