#include "estimator/tracker.h"

void tracker_prepare(tracker_tuning_t *tuning, const tracker_params_t *params)
{
    pll_prepare(&tuning->pll, &params->pll);
    validity_prepare(&tuning->validity, &params->validity, params->pll.period);
    tuning->flux_linkage = params->flux_linkage;
    tuning->speed_per_volt = 1.0f / params->flux_linkage;
    tuning->torque_feedforward = params->torque_feedforward;
}

void tracker_take(tracker_t *tracker, const tracker_tuning_t *tuning)
{
    pll_take(&tracker->pll, &tuning->pll);
    validity_take(&tracker->validity, &tuning->validity);
    tracker->flux_linkage = tuning->flux_linkage;
    tracker->speed_per_volt = tuning->speed_per_volt;
    tracker->torque_feedforward = tuning->torque_feedforward;
}

void tracker_init(tracker_t *tracker, const tracker_params_t *params)
{
    const position_t origin = {0.0f, 0.0f};
    tracker_tuning_t tuning;
    tracker_prepare(&tuning, params);
    tracker_take(tracker, &tuning);
    tracker_reset(tracker, origin, 0.0f);
}

void tracker_reset(tracker_t *tracker, position_t start, float amplitude)
{
    pll_reset(&tracker->pll, start);
    pll_reset_emf(&tracker->pll, amplitude);
    (void)pll_coast(&tracker->pll, 0.0f);
    validity_reset(&tracker->validity);
}

/* The torque's share: K i_q. */
static inline float acceleration_of(const tracker_t *tracker, ab_t current)
{
    return tracker->torque_feedforward * frames_park(current, tracker->pll.rotation).q;
}

position_t tracker_step(tracker_t *tracker, ab_t emf, ab_t current, float error_square)
{
    pll_t *pll = &tracker->pll;
    const float acceleration = acceleration_of(tracker, current);
    const position_t position = pll_step(pll, emf, tracker->speed_per_volt, acceleration);
    validity_step(&tracker->validity, pll->omega_smooth, pll->amplitude * tracker->speed_per_volt,
                  pll->detector, error_square);
    return position;
}

position_t tracker_watch(tracker_t *tracker, ab_t emf, ab_t current)
{
    return pll_watch(&tracker->pll, emf, acceleration_of(tracker, current));
}

position_t tracker_coast(tracker_t *tracker)
{
    return pll_coast(&tracker->pll, 0.0f);
}
