#include "estimator/pll.h"

#include "math/angle.h"
#include "math/bounds.h"
#include "math/trig.h"

void pll_reset(pll_t *pll, position_t start)
{
    bool has_feedforward = pll->tuning.feedforward_share > 0.0f;
    float omega_e = bounds_clamp(start.omega_e, pll->tuning.speed_limit);
    pll->feedforward = has_feedforward ? omega_e : 0.0f;
    pll->integral = has_feedforward ? 0.0f : omega_e;
    pll->theta_e = angle_wrap(start.theta_e);
    pll->rotation = trig_turn(pll->theta_e);
    pll->omega_e = omega_e;
    pll->omega_smooth = omega_e;
    pll->direction = 0.0f;
    if (bounds_magnitude(omega_e) < PLL_SIGN_SPEED) {
        pll->direction = omega_e < 0.0f ? -1.0f : 1.0f;
    }
    pll->detector = 0.0f;
    pll_reset_emf(pll, 0.0f);
}

void pll_reset_emf(pll_t *pll, float amplitude)
{
    pll->emf = (dq_t){0.0f, pll->omega_smooth < 0.0f ? -amplitude : amplitude};
    pll->amplitude = amplitude;
}

void pll_reset_feedforward(pll_t *pll, float speed_per_volt)
{
    if (pll->tuning.feedforward_share > 0.0f && !bounds_within(pll->omega_smooth, PLL_SIGNED_SPEED)) {
        pll->feedforward = bounds_clamp(pll->emf.q * speed_per_volt, pll->tuning.speed_limit);
        pll->integral = pll->omega_smooth - pll->feedforward;
    }
}

position_t pll_coast(pll_t *pll, float acceleration)
{
    float feedforward = pll->feedforward + pll->tuning.period * acceleration;
    if (bounds_magnitude(feedforward) <= pll->tuning.speed_limit) {
        pll->feedforward = feedforward;
        pll->omega_smooth = pll->integral + feedforward;
    }
    position_t position = {pll->theta_e, pll->omega_smooth};
    pll->detector = 0.0f;
    pll_turn(pll, position.omega_e);
    return position;
}

position_t pll_watch(pll_t *pll, ab_t emf, float acceleration)
{
    dq_t e = pll_filtered(pll, emf);
    if (pll_is_emf(e.d * e.d + e.q * e.q)) {
        pll->emf = e;
    }
    return pll_coast(pll, acceleration);
}

position_t pll_step(pll_t *pll, ab_t emf, float speed_per_volt, float acceleration)
{
    return pll_step_inline(pll, emf, (pll_motor_t){speed_per_volt, 0.0f, 1.0f, 1.0f, acceleration});
}
