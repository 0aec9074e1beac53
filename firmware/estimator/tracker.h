/* Position and speed from the back-EMF: tracking loop (pll.h), speed of its feed-forward from the EMF's
 * length (3), and whether the result can be believed (validity.h).
 *
 * The torque's share of the acceleration, K (i_q - i_L) with i_q of the rotor as the loop sees it and what of
 * it carries the load, may help the loop along (K = 0: off, as in the paper).
 *
 * Sample time: one step per T; the EMF is that of t_k and so is the result. */
#ifndef ESTIMATOR_TRACKER_H
#define ESTIMATOR_TRACKER_H

#include <stdint.h>

#include "estimator/pll.h"
#include "estimator/position.h"
#include "estimator/validity.h"
#include "math/frames.h"

typedef struct {
    pll_params_t pll;
    float flux_linkage;       /* psi_f [Wb], 1e-4..10 */
    float torque_feedforward; /* K = 1.5 p^2 psi_f/J [rad/s^2 per A] */
    validity_params_t validity;
} tracker_params_t;

typedef struct {
    pll_tuning_t pll;
    validity_tuning_t validity;
    float flux_linkage;       /* psi_f [Wb] */
    float speed_per_volt;     /* 1/psi_f [rad/s/V] */
    float torque_feedforward; /* K [rad/s^2 per A] */
} tracker_tuning_t;

typedef struct {
    float flux_linkage;       /* psi_f, of the tuning or as adapted [Wb] */
    float speed_per_volt;     /* 1/psi_f [rad/s/V] */
    float torque_feedforward; /* K, of the tuning [rad/s^2 per A] */
    float load;               /* i_L [A], as told; 0: nothing is known of a load */
    pll_t pll;
    validity_t validity;
} tracker_t;

/* Coefficients of a set whose parts have passed their checks. Divisions: for the background. */
void tracker_prepare(tracker_tuning_t *tuning, const tracker_params_t *params);

/* The coefficients alone, psi_f among them; the state goes on. */
static inline void tracker_take(tracker_t *tracker, const tracker_tuning_t *tuning)
{
    pll_take(&tracker->pll, &tuning->pll);
    validity_take(&tracker->validity, &tuning->validity);
    tracker->flux_linkage = tuning->flux_linkage;
    tracker->speed_per_volt = tuning->speed_per_volt;
    tracker->torque_feedforward = tuning->torque_feedforward;
}

/* As if locked at t_k at `start` [rad], [rad/s] on an EMF of this amplitude [V]; the next step is that of
 * t_k+1. Validity starts anew. */
void tracker_reset(tracker_t *tracker, position_t start, float amplitude);

/* The torque's share: K (i_q - i_L) [rad/s^2]. */
static inline float tracker_acceleration(const tracker_t *tracker, ab_t current)
{
    return tracker->torque_feedforward * (frames_park(current, tracker->pll.rotation).q - tracker->load);
}

/* Position at t_k from the EMF [V] and the current [A]; judged with the square of the observer's current
 * error [A^2]. */
static inline position_t tracker_step(tracker_t *tracker, ab_t emf, ab_t current, float error_square)
{
    pll_t *pll = &tracker->pll;
    const position_t position =
        pll_step_inline(pll, emf, tracker->speed_per_volt, tracker_acceleration(tracker, current));
    validity_step(&tracker->validity, pll->omega_smooth, pll->amplitude * tracker->speed_per_volt,
                  pll->detector, error_square);
    return position;
}

/* A period whose EMF is in doubt: it goes into the loop's filter, the loop coasts on, nothing is judged. */
static inline position_t tracker_watch(tracker_t *tracker, ab_t emf, ab_t current)
{
    return pll_watch(&tracker->pll, emf, tracker_acceleration(tracker, current));
}

/* A period without an EMF: the loop coasts on the last speed, nothing is judged. */
static inline position_t tracker_coast(tracker_t *tracker)
{
    return pll_coast(&tracker->pll, 0.0f);
}

#endif
