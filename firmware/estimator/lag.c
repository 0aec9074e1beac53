#include "estimator/lag.h"

#include "math/angle.h"
#include "math/tanh.h"
#include "math/trig.h"

/* A vector: what the sampled observer and its filter divide by. */
typedef struct {
    float re, im;
} complex_t;

/* (z - p)(1 - c/z) with z = exp(j x), from 1 - cos x = 2 sin(x/2)^2 so that nothing cancels at low speed. */
static complex_t denominator(const smo_t *smo, float x)
{
    rotation_t half = trig_rotation(0.5f * x);
    float versine = 2.0f * half.sin * half.sin;
    float sine = 2.0f * half.sin * half.cos;

    float g = smo->gain * smo_equivalent_gain(smo);
    complex_t observer = {smo->voltage_gain * (smo->resistance + g) - versine, sine};
    complex_t filter = {smo->emf_share + smo->emf_decay * versine, smo->emf_decay * sine};
    complex_t both = {observer.re * filter.re - observer.im * filter.im,
                      observer.re * filter.im + observer.im * filter.re};
    return both;
}

static float exact_angle(const smo_t *smo, float omega_e)
{
    float x = omega_e * smo->period;
    if (!(x > -ANGLE_PI && x < ANGLE_PI)) {
        return 0.0f;
    }
    complex_t vector = denominator(smo, x);
    return trig_atan2(vector.im, vector.re) - omega_e * (smo->hold_delay + x * x * smo->hold_delay_rise);
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
    case LAG_EXACT:
        return exact_angle(smo, omega_e);
    }
    return 0.0f;
}

float lag_attenuation(const smo_t *smo, float omega_e)
{
    float x = omega_e * smo->period;
    if (!(x > -ANGLE_PI && x < ANGLE_PI)) {
        return 1.0f;
    }
    complex_t vector = denominator(smo, x);

    /* |(z - a) lambda/((1 - a)(lambda + j omega))|, the EMF's mean over the hold: a series, sin(x/2)/(x/2)
     * for d = 0. */
    float square = x * x;
    float hold = 1.0f - square * (smo->hold_curvature - square * (1.0f / 1920.0f - square * 3.1001984e-6f));
    float numerator = smo->voltage_gain * smo->gain * smo_equivalent_gain(smo) * smo->emf_share * hold;
    return numerator * inverse_root(vector.re * vector.re + vector.im * vector.im);
}
