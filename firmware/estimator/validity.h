/* Validity of the estimate: four independent criteria, each with its own limits and debounce. The state of
 * the loop after a tracked period is judged; a period in which the loop coasted is not judged.
 *
 *     amplitude   |e| agrees with psi_f |omega_e|; else voltage, flux or speed is wrong
 *     detector    the EMF is on the q axis; else the loop is not locked
 *     current     the observer's current is near the measured one; else the observer has left its sliding
 *                 mode
 *     speed       high enough for a measurable EMF, and not above the limit of the observer
 *
 * No sample time of its own except for the debounce: one step per T. */
#ifndef ESTIMATOR_VALIDITY_H
#define ESTIMATOR_VALIDITY_H

#include <stdbool.h>
#include <stdint.h>

#include "contract/refusal.h"
#include "estimator/debounce.h"
#include "math/bounds.h"

/* Allowance for an EMF near zero speed, as a speed [rad/s]: the voltage error of an inverter. */
#define ESTIMATOR_AMPLITUDE_ALLOWANCE 10.0f

/* Bits of estimator_invalid(), the criteria in the order of debounce_t. */
#define ESTIMATOR_AMPLITUDE UINT32_C(1)  /* |e| does not agree with psi_f |omega_e| */
#define ESTIMATOR_DETECTOR  UINT32_C(2)  /* the EMF is not on the q axis */
#define ESTIMATOR_CURRENT   UINT32_C(4)  /* the observer's current is far from the measured one */
#define ESTIMATOR_SPEED     UINT32_C(8)  /* too slow for a measurable EMF, or too fast for the observer */
#define ESTIMATOR_SAMPLE    UINT32_C(16) /* the last sample was not finite: coasting; no debounce */

typedef struct {
    float amplitude_min;  /* of |e|/(psi_f |omega_e|) [-], 0..1; 0 = not judged */
    float amplitude_max;  /* of the same ratio [-], above 1; 0 = not judged */
    float amplitude_time; /* debounce [s], 0..10 */
    float detector_max;   /* of |eps|, the sine of the EMF's angle to the q axis [-], 0..1; 0 = not judged */
    float detector_time;  /* debounce [s], 0..10 */
    float current_max;    /* of |i_hat - i| [A]; 0 = not judged */
    float current_time;   /* debounce [s], 0..10 */
    float speed_min;      /* of |omega_e| [rad/s]; 0 = not judged */
    float speed_max;      /* of |omega_e| [rad/s], the largest EMF is psi_f times this; 0 = not judged */
    float speed_time;     /* debounce [s], 0..10 */
} validity_params_t;

typedef struct {
    float amplitude_min;    /* [-] */
    float amplitude_max;    /* [-] */
    float detector_max;     /* [-] */
    float error_square_max; /* current_max^2 [A^2] */
    float speed_min;        /* [rad/s] */
    float speed_max;        /* [rad/s] */
    debounce_tuning_t debounce;
} validity_tuning_t;

typedef struct {
    validity_tuning_t tuning;
    debounce_t debounce;
} validity_t;

/* true: the set is valid: ranges, and speed_min < speed_max. false: `why` has the first violated rule. */
bool validity_params_check(const validity_params_t *params, params_error_t *why);

/* Computes the coefficients of a set that has passed the check, for this period T [s]. It has divisions and
 * runs in the background. */
void validity_prepare(validity_tuning_t *tuning, const validity_params_t *params, float period);

/* Debounces [periods], at least 1, in the order of the bits: for both arithmetics. */
void validity_prepare_debounce(debounce_tuning_t *tuning, const validity_params_t *params, float period);

/* Sets the coefficients; the counts are kept. */
static inline void validity_take(validity_t *validity, const validity_tuning_t *tuning)
{
    validity->tuning = *tuning;
}

/* Clears the counts: all criteria hold. */
static inline void validity_reset(validity_t *validity)
{
    debounce_reset(&validity->debounce);
}

/* One tracked period: smooth speed [rad/s], the EMF's amplitude as a speed |e|/psi_f [rad/s], the detector
 * [-] and the square of the observer's current error [A^2]. */
static inline void validity_step(validity_t *validity, float omega_smooth, float speed_of_emf, float detector,
                                 float error_square)
{
    const validity_tuning_t *limits = &validity->tuning;
    const float speed = bounds_magnitude(omega_smooth);
    const float least = limits->amplitude_min * speed - ESTIMATOR_AMPLITUDE_ALLOWANCE;
    const float most = limits->amplitude_max * speed + ESTIMATOR_AMPLITUDE_ALLOWANCE;
    uint32_t failing = 0u;
    if (speed_of_emf < least || speed_of_emf > most) {
        failing |= ESTIMATOR_AMPLITUDE;
    }
    if (bounds_magnitude(detector) > limits->detector_max) {
        failing |= ESTIMATOR_DETECTOR;
    }
    if (error_square > limits->error_square_max) {
        failing |= ESTIMATOR_CURRENT;
    }
    if (speed < limits->speed_min || speed > limits->speed_max) {
        failing |= ESTIMATOR_SPEED;
    }
    debounce_step(&validity->debounce, &limits->debounce, failing);
}

#endif
