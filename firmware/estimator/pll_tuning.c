/* The coefficients of the loop, their checks and their design, for the background. */
#include "estimator/pll.h"

#include "math/check.h"
#include "math/exponential.h"
#include "math/filter.h"

#define DESIGN_ITERATIONS 24

static bool loop_check(const pll_params_t *params, params_error_t *why)
{
    if (!params_within(why, "period", "1e-6 <= period <= 1e-2", params->period, 1.0e-6f, 1.0e-2f)) {
        return false;
    }

    float rate = 1.0f / params->period;
    float ki_period = params->ki * params->period;
    return params_within(why, "feedforward_cutoff", "0 <= feedforward_cutoff <= 1/period",
                         params->feedforward_cutoff, 0.0f, rate) &&
           params_inside(why, "ki", "0 < ki < 4/period^2", params->ki, 0.0f, 4.0f * rate * rate) &&
           params_inside(why, "kp", "ki period < kp < 2/period + ki period/2", params->kp, ki_period,
                         2.0f * rate + 0.5f * ki_period) &&
           (params->emf_cutoff == 0.0f || params_within(why, "emf_cutoff", "0, or kp <= emf_cutoff <= 1e5",
                                                        params->emf_cutoff, params->kp, 1e5f));
}

bool pll_params_check(const pll_params_t *params, params_error_t *why)
{
    return loop_check(params, why) && params_within(why, "amplitude_floor", "1e-3 <= amplitude_floor <= 1e4",
                                                    params->amplitude_floor, 1.0e-3f, 1.0e4f);
}

void pll_prepare(pll_tuning_t *tuning, const pll_params_t *params)
{
    params_error_t why;
    CHECK(pll_params_check(params, &why));

    tuning->kp = params->kp;
    tuning->ki_period = params->ki * params->period;
    tuning->feedforward_share = lowpass_share(params->feedforward_cutoff, params->period);
    tuning->inverse_floor = 1.0f / params->amplitude_floor;
    tuning->speed_limit = PLL_TURN_LIMIT / params->period;
    tuning->period = params->period;
    tuning->emf_decay = params->emf_cutoff > 0.0f ? exponential(-params->emf_cutoff * params->period) : 0.0f;
}

void pll_init(pll_t *pll, const pll_params_t *params)
{
    const position_t origin = {0.0f, 0.0f};
    pll_tuning_t tuning;
    pll_prepare(&tuning, params);
    pll_take(pll, &tuning);
    pll_reset(pll, origin);
}

bool pll_design(pll_params_t *params, float bandwidth, float damping, float feedforward_cutoff, float period)
{
    params_error_t why;
    float c = feedforward_cutoff / bandwidth;
    if (!(bandwidth > 0.0f && c >= 0.0f && c < 1.0f && damping >= 0.5f && damping <= 5.0f)) {
        return false;
    }

    float z2 = 4.0f * damping * damping;
    float u4 = 1.0f + c * c;
    float u2 = z2 + 2.0f + c * c * (z2 - 2.0f);
    float u1 = 8.0f * damping * c;
    float rest = (1.0f - c) * (1.0f + c);

    /* The function rises and is convex for u > 0 and positive at 1, so that Newton's iteration falls
     * monotonically to the root. */
    float u = 1.0f;
    for (int n = 0; n < DESIGN_ITERATIONS; n++) {
        float square = u * u;
        float value = (u4 * square + u2) * square + u1 * u - rest;
        float slope = (4.0f * u4 * square + 2.0f * u2) * u + u1;
        u -= value / slope;
    }

    pll_params_t wanted = *params;
    float omega_n = u * bandwidth;
    wanted.kp = 2.0f * damping * omega_n;
    wanted.ki = omega_n * omega_n;
    wanted.feedforward_cutoff = feedforward_cutoff;
    wanted.period = period;
    if (!loop_check(&wanted, &why)) {
        return false;
    }
    *params = wanted;
    return true;
}
