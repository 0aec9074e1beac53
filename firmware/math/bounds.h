/* Amount and limits of numbers, in as few comparisons as can be. The functions of <math.h> used here are
 * exact and inline on every compiler; no library is called.
 *
 * No state. NaN: bounds_clamp() gives the upper limit, bounds_within() false. */
#ifndef MATH_BOUNDS_H
#define MATH_BOUNDS_H

#include <math.h>
#include <stdbool.h>

/* |value|. */
static inline float bounds_magnitude(float value)
{
    return fabsf(value);
}

/* `value`, but not beyond +-`limit`. */
static inline float bounds_clamp(float value, float limit)
{
    if (!(value < limit)) {
        return limit;
    }
    return value > -limit ? value : -limit;
}

/* Is `value` inside +-`limit`, the limits excluded? */
static inline bool bounds_within(float value, float limit)
{
    return fabsf(value) < limit;
}

/* `value`, but not below `lower` or above `upper`, lower <= upper. */
static inline float bounds_between(float value, float lower, float upper)
{
    if (value >= lower && value <= upper) {
        return value;
    }
    return value < lower ? lower : upper;
}

typedef struct {
    float largest, smallest;
} bounds_span_t;

/* The largest and the smallest of three numbers. */
static inline bounds_span_t bounds_span(float a, float b, float c)
{
    bounds_span_t span = {a, b};
    if (b > a) {
        span = (bounds_span_t){b, a};
    }
    if (c > span.largest) {
        span.largest = c;
    } else if (c < span.smallest) {
        span.smallest = c;
    }
    return span;
}

#endif
