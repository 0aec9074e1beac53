/* The fixed-point estimator seen from an SI world: parameters, samples and results as in estimator.h, the
 * work in estimator_q.h. The only file that knows both.
 *
 * Per unit (formats.h): U is the power of two from k_s up to below 2 k_s; I the least power of two that is at
 * least k_s T/L, what the switching voltage moves the current by in a period, and FIXED_CURRENT_LEAST. Bases
 * that are powers of two make no rounding: what is lost is what lies below the formats' resolution.
 *
 * Samples beyond 4 U or 16 I and non-finite ones are no measurement (ESTIMATOR_SAMPLE). A motor whose
 * constants do not fit the formats is refused by fixed_params_check, which names the quantity. */
#ifndef ESTIMATOR_FIXED_FIXED_H
#define ESTIMATOR_FIXED_FIXED_H

#include <stdbool.h>
#include <stdint.h>

#include "estimator/estimator.h"
#include "estimator/fixed/estimator_q.h"
#include "estimator/position.h"
#include "math/frames.h"

/* I is not smaller: its range, 16 I, shall hold what a drive's sensors measure [A]. */
#define FIXED_CURRENT_LEAST 1.5f

/* SI of one count. */
typedef struct {
    float voltage; /* [V] */
    float current; /* [A] */
    float speed;   /* [rad/s] */
    float gain;    /* of k_f [1/A] */
} fixed_units_t;

typedef struct {
    /* coefficients */
    fixed_units_t units;
    float voltage_counts;   /* [1/V] */
    float current_counts;   /* [1/A] */
    float speed_counts;     /* [s/rad] */
    float flux_per_count;   /* psi_f times the speed per volt in counts [Wb] */
    float flux_linkage_set; /* psi_f of the parameters [Wb] */
    /* coefficients and state */
    estimator_q_t q;
    /* results of the last step, in the names and units of estimator_t */
    struct {
        ab_t emf_hat, gain_axis, current_err;
        float gain_mean;
    } smo; /* [V], [1/A], [A]; [1/A] */
    struct {
        float omega_smooth, amplitude, detector;
    } pll;              /* [rad/s], [V], [-] */
    ab_t emf;           /* [V] */
    float flux_linkage; /* [Wb] */
    uint32_t invalid;   /* [-] bits */
} fixed_t;

/* estimator_params_check(), and whether every constant fits its format. */
bool fixed_params_check(const estimator_params_t *params, params_error_t *why);

/* As estimator_init() to estimator_invalid(). After a retune that needs other bases the state is carried over
 * in them, to a float's precision. */
void fixed_init(fixed_t *fixed, const estimator_params_t *params);
void fixed_retune(fixed_t *fixed, const estimator_params_t *params);
void fixed_reset(fixed_t *fixed, position_t start, ab_t current);
position_t fixed_step(fixed_t *fixed, ab_t voltage, ab_t current);
position_t fixed_coast(fixed_t *fixed, ab_t voltage, ab_t current);
void fixed_judge(fixed_t *fixed, uint32_t periods);

/* As estimator_rotation(). */
static inline rotation_t fixed_rotation(const fixed_t *fixed)
{
    const float unit = 1.0f / 1073741824.0f; /* Q30 */
    return (rotation_t){.sin = unit * (float)fixed->q.pll.rotation.sin,
                        .cos = unit * (float)fixed->q.pll.rotation.cos};
}

uint16_t fixed_invalid(const fixed_t *fixed);

#endif
