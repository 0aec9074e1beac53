/* Six times an angle: the sixth power of a direction, with which the harmonics of three phases are measured
 * in a rotating frame. Values only. */
#ifndef MATH_SIXTH_H
#define MATH_SIXTH_H

#include "math/frames.h"

/* The sixth power of a direction of length 1: cosine and sine of six times its angle [-]. */
static inline ab_t sixth_power(ab_t unit)
{
    const float square_re = unit.alpha * unit.alpha - unit.beta * unit.beta;
    const float square_im = 2.0f * unit.alpha * unit.beta;
    const float cube_re = square_re * unit.alpha - square_im * unit.beta;
    const float cube_im = square_re * unit.beta + square_im * unit.alpha;
    return (ab_t){cube_re * cube_re - cube_im * cube_im, 2.0f * cube_re * cube_im};
}

#endif
