#include "estimator/tracker.h"

void tracker_prepare(tracker_tuning_t *tuning, const tracker_params_t *params)
{
    pll_prepare(&tuning->pll, &params->pll);
    validity_prepare(&tuning->validity, &params->validity, params->pll.period);
    tuning->flux_linkage = params->flux_linkage;
    tuning->speed_per_volt = 1.0f / params->flux_linkage;
    tuning->saliency = params->saliency;
    tuning->saliency_rate = params->saliency / params->pll.period;
    tuning->torque_feedforward = params->torque_feedforward / params->flux_linkage;
    tuning->frequency = 1.0f / params->pll.period;
    const float share = bounds_more(tuning->pll.feedforward_share, 1e-3f);
    tuning->pull_most = bounds_more(TRACKER_SHARE_MOST / share, 1.0f);
    tuning->saturation = saturation_prepare(&params->saturation);
    tuning->salient = 0u;
    if (params->saliency != 0.0f || saturation_is_on(&tuning->saturation)) {
        tuning->salient = 1u;
    }
}

void tracker_reset(tracker_t *tracker, position_t start, dq_t current, float amplitude)
{
    pll_t *pll = &tracker->pll;
    tracker->load = 0.0f;
    start.theta_e += pll->tuning.period * start.omega_e;
    pll_reset(pll, start);
    pll_reset_emf(pll, amplitude);
    validity_reset(&tracker->validity);

    tracker_motor_t *motor = &tracker->motor;
    motor->i_d = current.d;
    motor->flux = tracker_flux(tracker, current.d);
    motor->flux_emf = motor->flux;
    motor->speed_per_volt = 1.0f / motor->flux;
    motor->cross = tracker_cross(tracker, current.q);
    motor->per_turned = motor->speed_per_volt;
    motor->lean = bounds_clamp(tracker->saliency * current.q * motor->speed_per_volt, TRACKER_LEAN_MOST);
    const float magnitude = bounds_magnitude(pll->omega_smooth);
    const float speed = magnitude > PLL_SIGN_SPEED ? magnitude : PLL_SIGN_SPEED;
    motor->moved = motor->lean;
    motor->gain = 1.0f;
    motor->share = 1.0f;
    motor->turning = 1.0f;
    motor->pull = 1.0f;
    motor->inverse = 1.0f / (speed + pll->tuning.kp * bounds_magnitude(motor->lean));
}
