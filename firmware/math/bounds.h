/* Amount and limits of numbers, without branches: each choice between two is one instruction of a C28x, and
 * three or four elsewhere. The functions of <math.h> used here are exact and inline on every compiler; no
 * library function is called.
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

/* The smaller of two: MINF32 of a C28x. NaN in `value`: `limit`. */
static inline float bounds_less(float value, float limit)
{
#if defined(__TMS320C2000__)
    return __fmin(value, limit);
#else
    return value < limit ? value : limit;
#endif
}

/* The larger of two: MAXF32. NaN in `value`: `limit`. */
static inline float bounds_more(float value, float limit)
{
#if defined(__TMS320C2000__)
    return __fmax(value, limit);
#else
    return value > limit ? value : limit;
#endif
}

/* `value`, limited to +-`limit`. */
static inline float bounds_clamp(float value, float limit)
{
    return bounds_more(bounds_less(value, limit), -limit);
}

typedef struct {
    float lower, upper; /* lower <= upper */
} bounds_t;

/* `value`, limited to the bounds. */
static inline float bounds_between(float value, bounds_t bounds)
{
    return bounds_more(bounds_less(value, bounds.upper), bounds.lower);
}

/* true: `value` is inside +-`limit`, the limits excluded. */
static inline bool bounds_within(float value, float limit)
{
    return fabsf(value) < limit;
}

typedef struct {
    float largest, smallest;
} bounds_span_t;

/* The largest and the smallest of three numbers. */
static inline bounds_span_t bounds_span(float a, float b, float c)
{
#if defined(__TMS320C2000__)
    return (bounds_span_t){bounds_more(c, bounds_more(a, b)), bounds_less(c, bounds_less(a, b))};
#else
    const float more = a > b ? a : b; /* one compare for both */
    const float less = a > b ? b : a;
    return (bounds_span_t){c > more ? c : more, c < less ? c : less};
#endif
}

#endif
