/* Amount and limits of a number, in forms that every target has an instruction for: absolute value, minimum,
 * maximum. The functions of <math.h> used here are exact and inline on every compiler; no library is called.
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
    float upper = value < limit ? value : limit;
    return upper > -limit ? upper : -limit;
}

/* Is `value` inside +-`limit`, the limits excluded? */
static inline bool bounds_within(float value, float limit)
{
    return fabsf(value) < limit;
}

#endif
