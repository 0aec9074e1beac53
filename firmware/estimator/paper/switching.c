#include "estimator/paper/switching.h"

#include "math/bounds.h"
#include "math/filter.h"
#include "math/tanh.h"

/* Below this mean square of the error [A^2] the gain is not computed. */
#define SQUARE_FLOOR 1e-24f

void switching_prepare(switching_tuning_t *tuning, float slope, float period, bool sign)
{
    tuning->half_slope = 0.5f * slope;
    tuning->mean_share = lowpass_share(SMO_GAIN_CUTOFF, period);
    tuning->sign = sign;
}

static float sign_of(float x)
{
    return x > 0.0f ? 1.0f : (x < 0.0f ? -1.0f : 0.0f);
}

/* f(x) and k_f = f/x of one axis, eq. (12). */
static float switch_axis(const switching_tuning_t *tuning, float x, float *k_f)
{
    if (tuning->sign != 0u) {
        float length = bounds_magnitude(x);
        *k_f = length * SMO_SIGN_GAIN_MAX > 1.0f ? 1.0f / length : SMO_SIGN_GAIN_MAX;
        return sign_of(x);
    }
    float h = tuning->half_slope;
    *k_f = h * tanh_ratio(h * h * x * x);
    return *k_f * x;
}

ab_t switching_step(switching_t *switching, const switching_tuning_t *tuning, ab_t x)
{
    ab_t f;
    f.alpha = switch_axis(tuning, x.alpha, &switching->gain_axis.alpha);
    f.beta = switch_axis(tuning, x.beta, &switching->gain_axis.beta);

    float share = switching->started != 0u ? tuning->mean_share : 1.0f;
    switching->started = 1u;
    float product = f.alpha * x.alpha + f.beta * x.beta;
    float square = x.alpha * x.alpha + x.beta * x.beta;
    switching->mean_product = lowpass_step(switching->mean_product, share, product);
    switching->mean_square = lowpass_step(switching->mean_square, share, square);
    float largest = tuning->sign != 0u ? SMO_SIGN_GAIN_MAX : tuning->half_slope;
    bool known =
        switching->mean_square > SQUARE_FLOOR && switching->mean_product < largest * switching->mean_square;
    switching->gain = known ? switching->mean_product / switching->mean_square : largest;
    return f;
}

void switching_reset(switching_t *switching)
{
    switching->mean_product = 0.0f;
    switching->mean_square = 0.0f;
    switching->started = 0u;
}

ab_t switching_error(const switching_tuning_t *tuning, ab_t f)
{
    if (tuning->sign != 0u) {
        return (ab_t){0.0f, 0.0f};
    }
    float h = tuning->half_slope;
    return (ab_t){f.alpha / (h * tanh_ratio_at(f.alpha * f.alpha)),
                  f.beta / (h * tanh_ratio_at(f.beta * f.beta))};
}
