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
    uint32_t counting;                  /* [-] not 0: a count is not 0 */
    uint32_t invalid;                   /* [-] bits of those that are raised; bit n: criterion n */
} debounce_t;

/* Nothing failed yet. */
static inline void debounce_reset(debounce_t *debounce)
{
    for (int32_t n = 0; n < ESTIMATOR_CRITERIA; n++) {
        debounce->count[n] = 0u;
    }
    debounce->counting = 0u;
    debounce->invalid = 0u;
}

/* A period of one criterion, and its bit of `invalid`. */
static inline uint32_t debounce_one(uint32_t *count, uint32_t limit, uint32_t failing, uint32_t invalid)
{
    if (failing != 0u) {
        *count += *count < limit;
        return *count >= limit ? failing : invalid;
    }
    *count -= *count > 0u;
    return *count == 0u ? 0u : invalid;
}

/* One period, in which the criteria of the bits `failing` do not hold. */
static inline void debounce_step(debounce_t *debounce, const debounce_tuning_t *tuning, uint32_t failing)
{
    if ((failing | debounce->counting) == 0u) {
        return;
    }
    uint32_t counting = 0u;
    uint32_t invalid = 0u;
    for (int32_t n = 0; n < ESTIMATOR_CRITERIA; n++) {
        const uint32_t bit = UINT32_C(1) << n;
        uint32_t *count = &debounce->count[n];
        invalid |= debounce_one(count, tuning->limit[n], failing & bit, debounce->invalid & bit);
        counting |= *count;
    }
    debounce->counting = counting;
    debounce->invalid = invalid;
}

#endif
