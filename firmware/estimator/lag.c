#include "estimator/lag.h"

#include "estimator/paper/lag_paper.h"
#include "math/bounds.h"
#include "math/root.h"
#include "math/trig.h"

/* Largest share of k_s and number of steps in lag_error(). */
#define EMF_SHARE_MAX 0.99f

static inline ab_t times(lag_impedance_t a, ab_t b)
{
    return (ab_t){a.re * b.alpha - a.im * b.beta, a.re * b.beta + a.im * b.alpha};
}

static inline ab_t over(ab_t b, lag_impedance_t a)
{
    float size = 1.0f / (a.re * a.re + a.im * a.im);
    return times((lag_impedance_t){size * a.re, -size * a.im}, b);
}

static float square_of(lag_impedance_t a)
{
    return a.re * a.re + a.im * a.im;
}

static float speed_within(const smo_t *smo, float omega_e)
{
    return bounds_clamp(omega_e, LAG_TURN_LIMIT / smo->tuning.period);
}

/* Present g [ohm]. */
static inline float conductance_of(const smo_t *smo)
{
    return smo->tuning.gain * smo->gain_mean;
}

/* v/e_hat of the filter (11): (1 - c/z)/(1 - c) = 1 + q (1 - 1/z), q = c/(1 - c), where 1 - 1/z = 2 sin(h)
 * (sin h + j cos h), h = omega T/2. */
static lag_impedance_t filter_of(const smo_t *smo, float omega_e)
{
    rotation_t half = trig_rotation(0.5f * omega_e * smo->tuning.period);
    float c = smo->tuning.emf_decay;
    float size = 2.0f * c / (1.0f - c) * half.sin;
    return (lag_impedance_t){1.0f + size * half.sin, size * half.cos};
}

/* e/e_hat times g: Z and the filter. */
static lag_impedance_t undoing(const smo_t *smo, float omega_e)
{
    float speed = speed_within(smo, omega_e);
    lag_impedance_t z = lag_impedance(&smo->tuning, speed, conductance_of(smo));
    lag_impedance_t filter = filter_of(smo, speed);
    return (lag_impedance_t){z.re * filter.re - z.im * filter.im, z.re * filter.im + z.im * filter.re};
}

float lag_angle(const smo_t *smo, lag_mode_t mode, float omega_e)
{
    if (mode != LAG_EXACT) {
        return lag_paper_angle(smo, mode, omega_e);
    }
    lag_impedance_t vector = undoing(smo, omega_e);
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
    if (smo->tuning.switching == (int32_t)SMO_SIGMOID_VECTOR) {
        return lag_undone(smo, omega_e, smo->current_err);
    }
    const float per_g = 1.0f / conductance_of(smo);
    return lag_undone(smo, omega_e, (ab_t){per_g * smo->switched.alpha, per_g * smo->switched.beta});
}

/* Solves |e| = |Z(k_s k_f(y))| y for the length y of the error by one step of Newton's method. The step
 * begins at the y of a small signal times atanh(s)/s, s = |e|/k_s, as a series: this corrects for the tanh.
 * The slope is (R + k_s a_f/2 (1 - tanh^2)) |Z|/(g + R), if the effect of the speed is neglected. */
ab_t lag_error(const smo_t *smo, float omega_e, ab_t emf)
{
    const smo_tuning_t *tuning = &smo->tuning;
    float speed = speed_within(smo, omega_e);
    float square = emf.alpha * emf.alpha + emf.beta * emf.beta;
    float length = square * inverse_root(square);
    float longest = EMF_SHARE_MAX * tuning->gain;
    if (length > longest) {
        float cut = longest / length;
        emf = (ab_t){cut * emf.alpha, cut * emf.beta};
        length = longest;
    }

    float slope_max = tuning->gain * tuning->half_slope;
    float share = length / tuning->gain;
    float share_square = share * share;
    float y = length / (slope_max + tuning->resistance) *
              (1.0f + share_square * (1.0f / 3.0f + share_square * (1.0f / 5.0f)));
    float k_f = smo_vector_gain(tuning, y * y);
    float g = tuning->gain * k_f;
    float goal = length * inverse_root(square_of(lag_impedance(tuning, speed, g)));
    float slope = tuning->resistance + slope_max * (1.0f - k_f * k_f * y * y);
    y += (goal - y) * (g + tuning->resistance) / slope;
    return over(emf, lag_impedance(tuning, speed, tuning->gain * smo_vector_gain(tuning, y * y)));
}

ab_t lag_switched(const smo_t *smo, float omega_e, ab_t emf)
{
    float g = conductance_of(smo);
    ab_t error = over(emf, lag_impedance(&smo->tuning, speed_within(smo, omega_e), g));
    return (ab_t){g * error.alpha, g * error.beta};
}

ab_t lag_filtered(const smo_t *smo, float omega_e, ab_t switched)
{
    return over(switched, filter_of(smo, speed_within(smo, omega_e)));
}
