/* First-order low-pass filter in fixed point; see filter.h. The output has 31 bits below its format, so that
 * no change is lost between two samples for any coefficient: the filter has no dead zone. */
#ifndef MATH_FILTER_Q_H
#define MATH_FILTER_Q_H

#include <stdint.h>

#include "math/q.h"

/* Largest input, so that the difference from the output fits. */
#define FILTER_Q_LARGEST (Q_ONE(30) - 1)
#define FILTER_Q_LONGEST (INT64_C(0x3fffffff) * (INT64_C(1) << 31))

typedef struct {
    /* coefficient */
    int32_t alpha; /* share of a new sample [-], Q31, 0 .. 2^31 - 1 */
    /* state */
    int64_t value; /* output, in the format of the input and 31 bits more */
} lowpass_q_t;

/* The output in the format of the input. */
static inline int32_t lowpass_value_q(const lowpass_q_t *filter)
{
    return (int32_t)q_round(filter->value, 31);
}

/* Sets the state of a filter whose input has always been `value`, limited to FILTER_Q_LARGEST. */
static inline void lowpass_reset_q(lowpass_q_t *filter, int32_t value)
{
    filter->value = (int64_t)q_clamp(value, FILTER_Q_LARGEST) * (INT64_C(1) << 31);
}

/* Filters one sample and returns the output; the input is limited to FILTER_Q_LARGEST. One product. */
static inline int32_t lowpass_step_q(lowpass_q_t *filter, int32_t input)
{
    int64_t value =
        filter->value + q_product(filter->alpha, q_clamp(input, FILTER_Q_LARGEST) - lowpass_value_q(filter));
    filter->value = q_clamp_long(value, FILTER_Q_LONGEST);
    return lowpass_value_q(filter);
}

#endif
