/* Number of periods of a time. It has divisions and runs in the background. */
#ifndef MATH_PERIODS_H
#define MATH_PERIODS_H

#include <stdint.h>

/* The nearest whole number of periods; both [s], time/period in [0, 2^31). */
static inline uint32_t periods_of(float time, float period)
{
    return (uint32_t)(time / period + 0.5f);
}

/* The least number of periods that is longer than this time; same limits. */
static inline uint32_t periods_beyond(float time, float period)
{
    return (uint32_t)(time / period) + 1u;
}

#endif
