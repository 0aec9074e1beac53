/* The back-EMF at t_k from voltage, current and speed: observer (smo.h) and phase self-compensation (lag.h)
 * in series. The speed is an argument, so that any source can supply it: the tracking loop, an encoder, a
 * forced ramp.
 *
 * Sample time: one step per T, in the timing of smo.h. */
#ifndef ESTIMATOR_OBSERVER_H
#define ESTIMATOR_OBSERVER_H

#include <stdbool.h>
#include <stdint.h>

#include "estimator/lag.h"
#include "estimator/smo.h"

typedef struct {
    smo_params_t smo;
    lag_mode_t lag;
} observer_params_t;

typedef struct {
    smo_tuning_t smo;
    int32_t lag;    /* lag_mode_t */
    uint32_t paper; /* [-] 1: with a switching function or a lag of the paper */
} observer_tuning_t;

typedef struct {
    int32_t lag;    /* lag_mode_t, of the tuning */
    uint32_t paper; /* [-] of the tuning */
    smo_t smo;
} observer_t;

/* Computes the coefficients of a set whose `smo` has passed smo_params_check. It has divisions and runs in
 * the background. */
void observer_prepare(observer_tuning_t *tuning, const observer_params_t *params);

/* Sets the coefficients; the state is kept. */
static inline void observer_take(observer_t *observer, const observer_tuning_t *tuning)
{
    smo_take(&observer->smo, &tuning->smo);
    observer->lag = tuning->lag;
    observer->paper = tuning->paper;
}

/* Sets the state of an observer settled at t_k on this `emf` [V] rotating at omega_e [rad/s] with this
 * current [A]; the next step is that of t_k+1. The speed is limited by LAG_TURN_LIMIT. Returns the angle
 * [rad] that remains between the result of this lag mode and the EMF. Many divisions. */
float observer_reset(observer_t *observer, float omega_e, ab_t current, ab_t emf);

/* `emf` [V] at t_k and the square of the current error [A^2], from the voltage [V] that acted on [t_k-1,
 * t_k), the current [A] at t_k and the speed [rad/s] of this period. false: the sample was rejected, the
 * state is unchanged and there is no EMF. */
static inline bool observer_step(observer_t *observer, ab_t voltage, ab_t current, float omega_e, ab_t *emf,
                                 float *error_square)
{
    smo_t *smo = &observer->smo;
    if (!smo_predict(smo, voltage, current, error_square)) {
        return false;
    }
    if (observer->paper != 0u) {
        smo_answer(smo, *error_square);
        *emf = lag_emf(smo, (lag_mode_t)observer->lag, omega_e);
    } else {
        smo->emf_hat = smo_switch_vector(smo, *error_square);
        *emf = lag_undone(smo, omega_e, smo->current_err);
    }
    return true;
}

#endif
