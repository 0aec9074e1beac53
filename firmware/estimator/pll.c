#include "estimator/pll.h"

#include "math/check.h"
#include "math/exponential.h"
#include "math/root.h"

/* What has a square that stays in range [V]. */
#define EMF_LARGEST 1.0e15f

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

/* Is the short way one for the next step? pll->inverse has any sign. */
static inline void look_ahead(pll_t *pll)
{
    float speed = bounds_magnitude(pll->omega_smooth);
    bool slow = speed < PLL_SIGNED_SPEED;
    float lower = slow ? PLL_SIGN_SPEED : PLL_SIGNED_SPEED;
    float upper = slow ? PLL_SIGNED_SPEED : pll->turn_limit;
    float inverse = bounds_magnitude(pll->inverse);
    bool one = speed >= lower && speed <= upper && inverse <= pll->inverse_floor && pll->direction == 0.0f;
    float sign = pll->omega_smooth < 0.0f ? -1.0f : 1.0f;
    pll->slow = slow;
    pll->half = 0.5f * (upper - lower);
    pll->middle = sign * (lower + pll->half);
    pll->inverse = one ? sign * inverse : 0.0f;
}

void pll_init(pll_t *pll, const pll_params_t *params)
{
    const position_t origin = {0.0f, 0.0f};
    pll->omega_smooth = 0.0f;
    pll->amplitude = 0.0f;
    pll->inverse = 0.0f;
    pll->direction = 0.0f;
    pll_retune(pll, params);
    pll_reset(pll, origin);
}

void pll_retune(pll_t *pll, const pll_params_t *params)
{
    params_error_t why;
    CHECK(pll_params_check(params, &why));

    pll->kp = params->kp;
    pll->ki_period = params->ki * params->period;
    pll->amplitude_floor = params->amplitude_floor;
    pll->inverse_floor = 1.0f / params->amplitude_floor;
    pll->speed_limit = PLL_TURN_LIMIT / params->period;
    pll->period = params->period;
    pll->emf_decay = params->emf_cutoff > 0.0f ? exponential(-params->emf_cutoff * params->period) : 0.0f;
    pll->turn_limit = TRIG_ADVANCE_LIMIT / params->period - params->kp;
    lowpass_retune(&pll->feedforward, params->feedforward_cutoff, params->period);
    look_ahead(pll);
}

static inline void place(pll_t *pll, float theta_e)
{
    pll->theta_e = theta_e;
    pll->rotation = trig_turn(theta_e);
}

/* To the angle of the next result, at this speed. I + F + kp eps turn by less than a turn in a period. */
static inline void move(pll_t *pll, float omega_e)
{
    pll->omega_e = omega_e;
    place(pll, angle_turn_back(pll->theta_e + pll->period * omega_e));
}

void pll_reset(pll_t *pll, position_t start)
{
    bool has_feedforward = pll->feedforward.alpha > 0.0f;
    float omega_e = bounds_clamp(start.omega_e, pll->speed_limit);
    lowpass_reset(&pll->feedforward, has_feedforward ? omega_e : 0.0f);
    pll->integral = has_feedforward ? 0.0f : omega_e;
    place(pll, angle_wrap(start.theta_e));
    pll->omega_e = omega_e;
    pll->omega_smooth = omega_e;
    pll->direction = omega_e < 0.0f ? -1.0f : 1.0f;
    pll->detector = 0.0f;
    pll->amplitude = 0.0f;
    pll->inverse = 0.0f;
    pll->emf = (dq_t){0.0f, 0.0f};
    if (bounds_magnitude(omega_e) >= PLL_SIGN_SPEED) {
        pll->direction = 0.0f;
    }
}

void pll_settle(pll_t *pll, float amplitude)
{
    pll->emf = (dq_t){0.0f, pll->omega_smooth < 0.0f ? -amplitude : amplitude};
    pll->amplitude = amplitude;
    pll->inverse = amplitude >= pll->amplitude_floor ? 1.0f / amplitude : 0.0f;
    look_ahead(pll);
}

void pll_advance(pll_t *pll)
{
    move(pll, pll->omega_smooth);
}

position_t pll_coast(pll_t *pll, float acceleration)
{
    float feedforward = pll->feedforward.value + pll->period * acceleration;
    if (bounds_magnitude(feedforward) <= pll->speed_limit) {
        lowpass_reset(&pll->feedforward, feedforward);
        pll->omega_smooth = pll->integral + feedforward;
    }
    position_t position = {pll->theta_e, pll->omega_smooth};
    pll->detector = 0.0f;
    if (pll->inverse != 0.0f && pll_goes_on(pll, pll->omega_smooth)) {
        pll_turn(pll, position.omega_e);
    } else {
        move(pll, position.omega_e);
        look_ahead(pll);
    }
    return position;
}

static float square_of(dq_t e)
{
    return e.d * e.d + e.q * e.q;
}

position_t pll_watch(pll_t *pll, ab_t emf, float acceleration)
{
    dq_t e = pll_filtered(pll, emf);
    if (square_of(e) <= EMF_LARGEST * EMF_LARGEST) {
        pll->emf = e;
    }
    return pll_coast(pll, acceleration);
}

/* The detector's sign at low speed; once the loop is faster, a start's direction is no longer needed. */
static float soft_sign(pll_t *pll)
{
    if (bounds_magnitude(pll->omega_smooth) >= PLL_SIGN_SPEED) {
        pll->direction = 0.0f;
    }
    if (pll->direction != 0.0f) {
        return pll->direction;
    }
    return bounds_clamp(pll->omega_smooth * (1.0f / PLL_SIGN_SPEED), 1.0f);
}

position_t pll_take(pll_t *pll, float feedforward, float integral)
{
    float new_feedforward = feedforward;
    float new_integral = integral;
    if (!(bounds_magnitude(feedforward) + bounds_magnitude(integral) <= pll->speed_limit)) {
        if (!(bounds_magnitude(feedforward) <= pll->speed_limit)) { /* or no number */
            new_feedforward = pll->feedforward.value;
        }
        new_integral = bounds_clamp(integral, 2.0f * pll->speed_limit);
    }
    position_t position = {pll->theta_e, pll->integral + pll->kp * pll->detector + new_feedforward};
    move(pll, position.omega_e);
    lowpass_reset(&pll->feedforward, new_feedforward);
    pll->integral = new_integral;
    pll->omega_smooth = new_integral + new_feedforward;
    look_ahead(pll);
    return position;
}

position_t pll_step_closely(pll_t *pll, ab_t emf, float speed_per_volt, float acceleration)
{
    dq_t e = pll_filtered(pll, emf);
    float square = square_of(e);
    if (!(square <= EMF_LARGEST * EMF_LARGEST)) {
        pll->amplitude = 0.0f;
        return pll_coast(pll, acceleration);
    }

    float inverse = inverse_root(square);
    float amplitude = square * inverse;
    float sign = soft_sign(pll);
    float signed_emf = bounds_magnitude(pll->omega_smooth) < PLL_SIGNED_SPEED ? e.q : sign * amplitude;
    float detector = -(sign * e.d) * (amplitude < pll->amplitude_floor ? pll->inverse_floor : inverse);
    pll->emf = e;
    pll->amplitude = amplitude;
    pll->inverse = inverse;
    pll->detector = detector;

    float feedforward = pll->feedforward.value;
    feedforward += pll->feedforward.alpha * (signed_emf * speed_per_volt - feedforward);
    feedforward += pll->period * acceleration;
    return pll_take(pll, feedforward, pll->integral + pll->ki_period * detector);
}

position_t pll_step(pll_t *pll, ab_t emf, float speed_per_volt, float acceleration)
{
    position_t position;
    return pll_track(pll, emf, speed_per_volt, acceleration, &position)
               ? position
               : pll_step_closely(pll, emf, speed_per_volt, acceleration);
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
