#include "estimator/tracker.h"

void tracker_prepare(tracker_tuning_t *tuning, const tracker_params_t *params)
{
    pll_prepare(&tuning->pll, &params->pll);
    validity_prepare(&tuning->validity, &params->validity, params->pll.period);
    tuning->flux_linkage = params->flux_linkage;
    tuning->speed_per_volt = 1.0f / params->flux_linkage;
    tuning->torque_feedforward = params->torque_feedforward;
}

void tracker_reset(tracker_t *tracker, position_t start, float amplitude)
{
    tracker->load = 0.0f;
    start.theta_e += tracker->pll.tuning.period * start.omega_e;
    pll_reset(&tracker->pll, start);
    pll_reset_emf(&tracker->pll, amplitude);
    validity_reset(&tracker->validity);
}
