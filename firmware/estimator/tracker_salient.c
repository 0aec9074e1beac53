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

ab_t tracker_transient(const tracker_t *tracker, dq_t current, ab_t voltage)
{
    const pll_t *pll = &tracker->pll;
    const float taken = tracker->saliency_rate * (current.d - tracker->motor.i_d);
    const float back = 0.5f * pll->tuning.period * pll->omega_e;
    const float cosine = pll->rotation.cos + back * pll->rotation.sin;
    const float sine = pll->rotation.sin - back * pll->rotation.cos;
    voltage.alpha += taken * cosine;
    voltage.beta += taken * sine;
    if (saturation_is_on(&tracker->saturation)) {
        const float change = tracker_cross(tracker, current.q) - tracker->motor.cross;
        const float across = -tracker->frequency * change;
        voltage.alpha -= across * sine;
        voltage.beta += across * cosine;
    }
    return voltage;
}

/* Where the q axis saturates: t [-] and c [Wb]; and for f the part that the motion of the loop adds to the
 * error of the angle, and the gain of the detector, both relative to psi_t [-]. */
static void bend(const tracker_t *tracker, dq_t current, tracker_motor_t *motor)
{
    const saturation_point_t point = saturation_at(&tracker->saturation, current.q);
    const float apart = tracker->saliency + point.excess;
    const float turned =
        tracker->flux_linkage - (apart + bounds_magnitude(current.q) * point.slope) * current.d;
    const float least = TRACKER_FLUX_LEAST * tracker->flux_linkage;
    motor->cross = point.excess * current.q;
    motor->per_turned = tracker_reciprocal(turned > least ? turned : least, motor->per_turned);
    motor->lean = bounds_clamp(apart * current.q * motor->per_turned, TRACKER_LEAN_MOST);
    motor->moved = bounds_clamp(tracker->saliency * current.q * motor->per_turned, TRACKER_LEAN_MOST);
    motor->gain = bounds_between(motor->flux * motor->per_turned, (bounds_t){1.0f, TRACKER_GAIN_MOST});
}

/* f [-]. */
static float share_of(const pll_t *pll, tracker_motor_t *motor)
{
    const float magnitude = bounds_magnitude(pll->omega_smooth);
    const float speed = magnitude > PLL_SIGN_SPEED ? magnitude : PLL_SIGN_SPEED;
    motor->inverse =
        tracker_reciprocal(speed + pll->tuning.kp * bounds_magnitude(motor->moved), motor->inverse);
    return motor->moved * pll->omega_smooth < 0.0f ? speed * motor->inverse : 1.0f;
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
    motor->moved = motor->lean;
    motor->gain = 1.0f;
    if (saturation_is_on(&tracker->saturation)) {
        bend(tracker, current, motor);
    }
    const float share = share_of(pll, motor);
    const float turning = tracker_reciprocal(share, motor->turning);
    motor->turning = bounds_between(turning, (bounds_t){1.0f, TRACKER_TURNING_MOST});
    motor->pull = bounds_less(motor->turning * motor->turning * motor->turning, tracker->pull_most);
    motor->share = motor->gain * share;
}
