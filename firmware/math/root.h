/* Reciprocal square root, for lengths of vectors: r = 1/sqrt(x), sqrt(x) = x r.
 *
 * Halving and negating the exponent of the float, done on its bits, gives an initial r within 3.5 %; two
 * Newton steps, the first with minimax coefficients for this initial value, the second centred, leave 3.2e-7
 * and the rounding. No branches, no state, no division, no libm. Source: the method on the bits is public
 * domain; the constants are an own minimax fit. */
#ifndef MATH_ROOT_H
#define MATH_ROOT_H

#include <stdint.h>

#include "math/float_bits.h"

#define ROOT_GUESS UINT32_C(0x5f200000)

/* 1/sqrt(square): relative error <= 5e-7 for every `square` from 1e-37 to the largest float; the error
 * repeats with every factor of 4. For smaller values, denormal floats and zero included, the result is
 * between 1e18 and 3e19, so that 0 inverse_root(0) is 0. Does not handle: negative or non-finite input. Nine
 * multiplications and subtractions. */
static inline float inverse_root(float square)
{
    float y = float_of_bits(ROOT_GUESS - (float_bits(square) >> 1));

    /* The steps for y = c/sqrt(square): with this c both steps use the same product. */
    float share = 0.646245922f * square;
    y *= 1.54404618f - share * y * y;
    y *= 1.63393192f - share * y * y;
    return y;
}

/* sqrt(square), and 0 for a `square` of at most 0. Accuracy and range of inverse_root(). */
static inline float root_or_none(float square)
{
    return square > 0.0f ? square * inverse_root(square) : 0.0f;
}

#endif
