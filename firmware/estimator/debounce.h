/* Debounce of independent criteria: a criterion that fails increments its count of periods, else decrements
 * it. The criterion is raised when the count reaches its limit, and cleared when the count is zero again.
 * Integers only, for both arithmetics. */
#ifndef ESTIMATOR_DEBOUNCE_H
#define ESTIMATOR_DEBOUNCE_H

#include <stdint.h>

#define ESTIMATOR_CRITERIA 4

typedef struct {
    uint32_t limit[ESTIMATOR_CRITERIA]; /* [periods], at least 1 */
} debounce_tuning_t;

typedef struct {
    uint32_t count[ESTIMATOR_CRITERIA]; /* [periods] */
    uint32_t counting;                  /* [-] not 0: at least one count is not 0 */
    uint32_t invalid;                   /* [-] bits of the raised criteria; bit n: criterion n */
} debounce_t;

/* Clears all counts. */
static inline void debounce_reset(debounce_t *debounce)
{
    for (int32_t n = 0; n < ESTIMATOR_CRITERIA; n++) {
        debounce->count[n] = 0u;
    }
    debounce->counting = 0u;
    debounce->invalid = 0u;
}

/* One period of criterion `n`: returns its bit if it is raised. */
static inline uint32_t debounce_one(debounce_t *debounce, const debounce_tuning_t *tuning, uint32_t failing,
                                    uint32_t n)
{
    const uint32_t bit = UINT32_C(1) << n;
    const uint32_t limit = tuning->limit[n];
    uint32_t count = debounce->count[n];
    uint32_t raised = debounce->invalid & bit;
    if ((failing & bit) != 0u) {
        count++;
        if (count >= limit) {
            count = limit;
            raised = bit;
        }
    } else if (count > 1u) {
        count--;
    } else {
        count = 0u;
        raised = 0u;
    }
    debounce->count[n] = count;
    return raised;
}

/* One period, in which the criteria of the bits `failing` fail. */
static inline void debounce_step(debounce_t *debounce, const debounce_tuning_t *tuning, uint32_t failing)
{
    if ((failing | debounce->counting) == 0u) {
        return;
    }
    debounce->invalid =
        debounce_one(debounce, tuning, failing, 0u) | debounce_one(debounce, tuning, failing, 1u) |
        debounce_one(debounce, tuning, failing, 2u) | debounce_one(debounce, tuning, failing, 3u);
    debounce->counting = debounce->count[0] | debounce->count[1] | debounce->count[2] | debounce->count[3];
}

#endif
