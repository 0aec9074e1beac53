/* The interface of the fixed-point estimator in SI units: parameters, samples and results as in estimator.h,
 * the computation in estimator_q.h, the coefficients by per_unit.h.
 *
 * Samples beyond 4 U or 16 I and non-finite ones are invalid (ESTIMATOR_SAMPLE). fixed_params_check rejects a
 * motor whose constants do not fit the formats, and names the quantity. */
#ifndef ESTIMATOR_FIXED_FIXED_H
#define ESTIMATOR_FIXED_FIXED_H

#include <stdbool.h>
#include <stdint.h>

#include "estimator/estimator.h"
#include "estimator/fixed/estimator_q.h"
#include "estimator/fixed/per_unit.h"
#include "estimator/position.h"
#include "math/frames.h"

/* SI value of one count. */
typedef struct {
    float voltage; /* [V] */
    float current; /* [A] */
    float speed;   /* [rad/s] */
    float gain;    /* of k_f [1/A] */
} fixed_units_t;

typedef struct {
    fixed_units_t units;
    float voltage_counts; /* [1/V] */
    float current_counts; /* [1/A] */
    float speed_counts;   /* [s/rad] */
    bases_t base;
} fixed_scale_t;

typedef struct {
    fixed_scale_t scale;
    estimator_tuning_q_t q;
    float flux_linkage; /* psi_f [Wb] */
} fixed_tuning_t;

typedef struct {
    fixed_scale_t scale; /* of the tuning */
    estimator_q_t q;
    float flux_linkage;  /* psi_f, of the tuning or adapted [Wb] */
    estimate_t estimate; /* after the last step or reset, in SI */
    observed_t observed; /* after the last step or reset, in SI */
} fixed_t;

/* true: estimator_params_check() is true and every constant fits its format. */
bool fixed_params_check(const estimator_params_t *params, params_error_t *why);

/* The same as estimator_prepare() to estimator_invalid(). With a tuning that has other bases, the state is
 * converted to them with the precision of a float. */
void fixed_prepare(fixed_tuning_t *tuning, const estimator_params_t *params);
void fixed_take(fixed_t *fixed, const fixed_tuning_t *tuning);
void fixed_init(fixed_t *fixed, const estimator_params_t *params);
void fixed_set_flux(fixed_t *fixed, float flux_linkage, float speed_per_volt);
void fixed_set_load(fixed_t *fixed, float current);

/* No effect: this version has no lean. */
static inline void fixed_set_lean(fixed_t *fixed, float lean)
{
    (void)fixed;
    (void)lean;
}

void fixed_reset(fixed_t *fixed, position_t start, ab_t current);
position_t fixed_step(fixed_t *fixed, ab_t voltage, ab_t current);
position_t fixed_coast(fixed_t *fixed, ab_t voltage, ab_t current);
void fixed_observe(fixed_t *fixed, ab_t voltage, ab_t current, float omega_e);
void fixed_lock(fixed_t *fixed, position_t start, float amplitude);
uint16_t fixed_invalid(const fixed_t *fixed);

#endif
