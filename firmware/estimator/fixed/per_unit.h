/* Coefficients of the fixed-point estimator, in the formats of formats.h, from parameters in SI; float, for
 * the background.
 *
 * U is the power of two from k_s up to below 2 k_s. I is the smallest power of two that is at least k_s T/L,
 * the change of the current by the switching voltage in a period, and FIXED_CURRENT_LEAST. Bases that are
 * powers of two cause no rounding: only what is below the resolution of the formats is lost. */
#ifndef ESTIMATOR_FIXED_PER_UNIT_H
#define ESTIMATOR_FIXED_PER_UNIT_H

#include <stdbool.h>
#include <stdint.h>

#include "estimator/estimator.h"
#include "estimator/fixed/estimator_q.h"

/* Least I, so that its range, 16 I, includes the range of a drive's current sensors [A]. */
#define FIXED_CURRENT_LEAST 1.5f

typedef struct {
    float voltage, current; /* U [V], I [A] */
    float period;           /* T [s] */
    float turn_per_rad;     /* of a speed: T/2 pi [turn/T per rad/s] */
} bases_t;

bases_t per_unit_bases(const estimator_params_t *params);

/* true: every constant fits its format; the set has passed estimator_params_check(). */
bool per_unit_check(const estimator_params_t *params, params_error_t *why);

/* Coefficients of a set that has passed both checks. */
estimator_tuning_q_t per_unit_of(const estimator_params_t *params, const bases_t *base);

/* 1/psi_f [rad/s/V] in its format. One conversion, no division. */
int32_t per_unit_speed_per_volt(float speed_per_volt, const bases_t *base);

/* `value` times `per_unit` as counts, rounded, within the range of the type. */
int32_t per_unit_counts(float value, float per_unit);

#endif
