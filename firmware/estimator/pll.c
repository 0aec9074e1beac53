#include "estimator/pll.h"

#include <assert.h>

#include "math/angle.h"
#include "math/trig.h"

/* What has a reciprocal and squares that stay in range [V]. */
#define EMF_SMALLEST 1.0e-30f
#define EMF_LARGEST  1.0e30f

#define DESIGN_ITERATIONS 24

static float clamp(float value, float limit)
{
    if (value > limit) {
        return limit;
    }
    return value < -limit ? -limit : value;
}

static float magnitude(float value)
{
    return value < 0.0f ? -value : value;
}

/* 1/sqrt(1 + x) for x in [0, 1]: relative error within 2.2e-6, exactly 1 at 0. */
static float inverse_root(float x)
{
    float p = 0.0204282453f;
    p = p * x - 0.0929059831f;
    p = p * x + 0.198966138f;
    p = p * x - 0.291646407f;
    p = p * x + 0.372129648f;
    p = p * x - 0.49986338f;
    return p * x + 1.0f;
}

static bool refuse(params_error_t *why, const char *field, const char *rule, float value, float min,
                   float max)
{
    why->field = field;
    why->rule = rule;
    why->value = value;
    why->min = min;
    why->max = max;
    why->id = UINT32_C(0);
    why->reason = INT32_C(0);
    return false;
}

/* True if min <= value <= max, never for a NaN; else the refusal. */
static bool within(params_error_t *why, const char *field, const char *rule, float value, float min,
                   float max)
{
    return (value >= min && value <= max) || refuse(why, field, rule, value, min, max);
}

/* The same with both ends excluded. */
static bool inside(params_error_t *why, const char *field, const char *rule, float value, float min,
                   float max)
{
    return (value > min && value < max) || refuse(why, field, rule, value, min, max);
}

static bool loop_check(const pll_params_t *params, params_error_t *why)
{
    if (!within(why, "period", "1e-6 <= period <= 1e-2", params->period, 1.0e-6f, 1.0e-2f)) {
        return false;
    }

    float rate = 1.0f / params->period;
    float ki_period = params->ki * params->period;
    return within(why, "feedforward_cutoff", "0 <= feedforward_cutoff <= 1/period",
                  params->feedforward_cutoff, 0.0f, rate) &&
           inside(why, "ki", "0 < ki < 4/period^2", params->ki, 0.0f, 4.0f * rate * rate) &&
           inside(why, "kp", "ki period < kp < 2/period + ki period/2", params->kp, ki_period,
                  2.0f * rate + 0.5f * ki_period);
}

bool pll_params_check(const pll_params_t *params, params_error_t *why)
{
    return loop_check(params, why) && within(why, "amplitude_floor", "1e-3 <= amplitude_floor <= 1e4",
                                             params->amplitude_floor, 1.0e-3f, 1.0e4f);
}

void pll_init(pll_t *pll, const pll_params_t *params)
{
    const position_t origin = {0.0f, 0.0f};
    pll_retune(pll, params);
    pll_reset(pll, origin);
}

void pll_retune(pll_t *pll, const pll_params_t *params)
{
    params_error_t why;
    bool good = pll_params_check(params, &why);
    assert(good);
    (void)good;

    pll->kp = params->kp;
    pll->ki_period = params->ki * params->period;
    pll->amplitude_floor = params->amplitude_floor;
    pll->inverse_floor = 1.0f / params->amplitude_floor;
    pll->speed_limit = PLL_TURN_LIMIT / params->period;
    pll->period = params->period;
    lowpass_retune(&pll->feedforward, params->feedforward_cutoff, params->period);
}

void pll_reset(pll_t *pll, position_t start)
{
    bool has_feedforward = pll->feedforward.alpha > 0.0f;
    float omega_e = clamp(start.omega_e, pll->speed_limit);
    lowpass_reset(&pll->feedforward, has_feedforward ? omega_e : 0.0f);
    pll->integral = has_feedforward ? 0.0f : omega_e;
    pll->theta_e = angle_wrap(start.theta_e);
    pll->omega_smooth = omega_e;
    pll->direction = omega_e < 0.0f ? -1.0f : 1.0f;
    pll->detector = 0.0f;
    pll->amplitude = 0.0f;
    if (magnitude(omega_e) >= PLL_SIGN_SPEED) {
        pll->direction = 0.0f;
    }
}

position_t pll_step(pll_t *pll, ab_t emf, float speed_per_volt, float acceleration)
{
    dq_t e = frames_park(emf, trig_rotation(pll->theta_e));
    float length_d = magnitude(e.d);
    float length_q = magnitude(e.q);
    bool usable = length_d <= EMF_LARGEST && length_q <= EMF_LARGEST;

    float longer = length_d > length_q ? length_d : length_q;
    float shorter = length_d > length_q ? length_q : length_d;
    float amplitude = 0.0f;
    float inverse = pll->inverse_floor;
    if (usable && longer > EMF_SMALLEST) {
        float reciprocal = 1.0f / longer;
        float ratio = shorter * reciprocal;
        float square = ratio * ratio;
        float root = inverse_root(square);
        amplitude = longer * (1.0f + square) * root;
        if (amplitude > pll->amplitude_floor) {
            inverse = reciprocal * root;
        }
    }

    float omega_smooth = pll->omega_smooth;
    float sign = pll->direction;
    if (sign == 0.0f) {
        sign = clamp(omega_smooth * (1.0f / PLL_SIGN_SPEED), 1.0f);
    }
    float detector = usable ? clamp(-e.d * inverse, 1.0f) * sign : 0.0f;

    /* A comparison that fails for a NaN keeps it out of the state. */
    float signed_emf = e.q;
    if (magnitude(omega_smooth) >= PLL_SIGNED_SPEED) {
        signed_emf = omega_smooth < 0.0f ? -amplitude : amplitude;
    }
    float omega_emf = signed_emf * speed_per_volt;
    if (!(usable && magnitude(omega_emf) <= pll->speed_limit)) {
        omega_emf = pll->feedforward.value;
    }
    float gain = pll->period * acceleration;
    if (!(magnitude(gain) <= pll->speed_limit)) {
        gain = 0.0f;
    }
    float feedforward = clamp(lowpass_step(&pll->feedforward, omega_emf) + gain, pll->speed_limit);
    lowpass_reset(&pll->feedforward, feedforward);

    position_t position;
    position.theta_e = pll->theta_e;
    position.omega_e = pll->integral + pll->kp * detector + feedforward;

    pll->theta_e = angle_wrap(position.theta_e + pll->period * position.omega_e);
    pll->integral = clamp(pll->integral + pll->ki_period * detector, 2.0f * pll->speed_limit);
    pll->omega_smooth = pll->integral + feedforward;
    if (magnitude(pll->omega_smooth) >= PLL_SIGN_SPEED) {
        pll->direction = 0.0f;
    }
    pll->detector = detector;
    pll->amplitude = amplitude;
    return position;
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

    /* Rising and convex for u > 0 and positive at 1: Newton's iteration falls monotonically to the root. */
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
