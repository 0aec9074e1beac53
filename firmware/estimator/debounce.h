/* Debounce of criteria that do not depend on each other: one that fails counts the periods up, else down; it
 * is raised when the count reaches its limit and falls when it is back at zero. Integers only, for both
 * arithmetics. */
#ifndef ESTIMATOR_DEBOUNCE_H
#define ESTIMATOR_DEBOUNCE_H

#include <stdint.h>

#define ESTIMATOR_CRITERIA 4

typedef struct {
    uint32_t limit[ESTIMATOR_CRITERIA]; /* [periods], at least 1 */
} debounce_tuning_t;

typedef struct {
    uint32_t count[ESTIMATOR_CRITERIA]; /* [periods] */
    uint32_t invalid;                   /* [-] bits of those that are raised; bit n: criterion n */
} debounce_t;

/* Nothing failed yet. */
static inline void debounce_reset(debounce_t *debounce)
{
    for (int32_t n = 0; n < ESTIMATOR_CRITERIA; n++) {
        debounce->count[n] = 0u;
    }
    debounce->invalid = 0u;
}

/* One period, in which the criteria of the bits `failing` do not hold. */
static inline void debounce_step(debounce_t *debounce, const debounce_tuning_t *tuning, uint32_t failing)
{
    for (int32_t n = 0; n < ESTIMATOR_CRITERIA; n++) {
        const uint32_t bit = UINT32_C(1) << n;
        if ((failing & bit) != 0u) {
            debounce->count[n]++;
        } else if (debounce->count[n] > 0u) {
            debounce->count[n]--;
        }
        if (debounce->count[n] >= tuning->limit[n]) {
            debounce->count[n] = tuning->limit[n];
            debounce->invalid |= bit;
        } else if (debounce->count[n] == 0u) {
            debounce->invalid &= ~bit;
        }
    }
}

#endif
