#include "estimator/observer.h"

/* Per axis, k_f depends on the required v, and v on k_f: a few iterations converge. */
#define RESET_ROUNDS 8

void observer_prepare(observer_tuning_t *tuning, const observer_params_t *params)
{
    smo_prepare(&tuning->smo, &params->smo);
    tuning->lag = (int32_t)params->lag;
    tuning->paper = params->lag != LAG_EXACT || params->smo.switching != SMO_SIGMOID_VECTOR;
}

/* The switching functions of the paper. */
static void reset_axes(smo_t *smo, float omega_e, ab_t current, ab_t emf)
{
    smo_reset(smo, current, emf);
    for (int32_t n = 0; n < RESET_ROUNDS; n++) {
        smo_reset(smo, current, lag_switched(smo, omega_e, emf));
    }
}

float observer_reset(observer_t *observer, float omega_e, ab_t current, ab_t emf)
{
    smo_t *smo = &observer->smo;
    if (smo->tuning.switching == (int32_t)SMO_SIGMOID_VECTOR) {
        smo_reset_error(smo, current, lag_error(smo, omega_e, emf));
    } else {
        reset_axes(smo, omega_e, current, emf);
    }
    if (smo->tuning.emf_decay > 0.0f) {
        smo->emf_hat = lag_filtered(smo, omega_e, smo->switched);
    }
    const lag_mode_t mode = (lag_mode_t)observer->lag;
    return mode == LAG_EXACT ? 0.0f : lag_angle(smo, mode, omega_e) - lag_angle(smo, LAG_EXACT, omega_e);
}
