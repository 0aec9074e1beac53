/* The steps of the tracker that only a salient rotor needs: the active flux and the values derived from
 * it. */
#include "estimator/tracker.h"

/* 1/`value`, from the reciprocal of a similar value: a step of Newton's method, which converges for ratios
 * from a half to two. */
static inline float tracker_reciprocal(float value, float last)
{
    const float product = value * last;
    return last * (2.0f - (product < 1.5f ? product : 1.5f));
}

void tracker_transient(const tracker_t *tracker, float i_d, ab_t *voltage)
{
    const pll_t *pll = &tracker->pll;
    const float taken = tracker->saliency_rate * (i_d - tracker->motor.i_d);
    const float back = 0.5f * pll->tuning.period * pll->omega_e;
    voltage->alpha += taken * (pll->rotation.cos + back * pll->rotation.sin);
    voltage->beta += taken * (pll->rotation.sin - back * pll->rotation.cos);
}

/* f [-]. */
static float share_of(const pll_t *pll, tracker_motor_t *motor)
{
    const float magnitude = bounds_magnitude(pll->omega_smooth);
    const float speed = magnitude > PLL_SIGN_SPEED ? magnitude : PLL_SIGN_SPEED;
    motor->inverse =
        tracker_reciprocal(speed + pll->tuning.kp * bounds_magnitude(motor->lean), motor->inverse);
    return motor->lean * pll->omega_smooth < 0.0f ? speed * motor->inverse : 1.0f;
}

void tracker_follow(tracker_t *tracker, dq_t current)
{
    const pll_t *pll = &tracker->pll;
    tracker_motor_t *motor = &tracker->motor;
    motor->i_d = current.d;
    motor->flux = tracker_flux(tracker, current.d);
    motor->flux_emf = motor->flux + pll->tuning.emf_decay * (motor->flux_emf - motor->flux);
    motor->speed_per_volt = tracker_reciprocal(motor->flux_emf, motor->speed_per_volt);
    motor->lean = bounds_clamp(tracker->saliency * current.q * motor->speed_per_volt, TRACKER_LEAN_MOST);
    motor->share = share_of(pll, motor);
}
