/* Reciprocal square root in integers, for lengths, unit vectors and reciprocals (of the square): no division.
 *
 * The square is shifted by an even number of bits until it is in [2^62, 2^64); a table of 1/sqrt on [1, 4) in
 * steps of 1/32 with linear interpolation is within 9.2e-5, and one Newton step y (3 - m y^2)/2 leaves 1.3e-8
 * and the rounding. No state, no division. */
#ifndef MATH_ROOT_Q_H
#define MATH_ROOT_Q_H

#include <stdint.h>

#include "math/q.h"

/* A smaller square is replaced by this. */
#define ROOT_Q_SMALLEST UINT64_C(4)

/* 1/sqrt(square) = mantissa 2^(shift - 61). A number x not longer than sqrt(square), times 2^shift, is below
 * 2^32. */
typedef struct {
    int32_t mantissa; /* Q30: 2^29..2^30 [-] */
    int32_t shift;    /* 0..30 [-] */
} root_q_t;

/* Relative error within 2e-8. One table look-up, four products. */
root_q_t inverse_root_q(uint64_t square);

/* 1/value with the same error, for a value of at least 2. */
static inline root_q_t reciprocal_q(int32_t value)
{
    return inverse_root_q(q_square(value));
}

/* x 2^n over the root or value from which `inverse` was computed, saturated; n in 0..30. One product: no
 * division. */
static inline int32_t quotient_q(int32_t x, root_q_t inverse, int32_t n)
{
    return q_multiply_saturated(x, inverse.mantissa, 61 - n - inverse.shift);
}

/* sqrt(square), rounded down to a whole number; error at most 1 + 2e-8 of the result. Six products. */
uint32_t root_q(uint64_t square);

/* 1/sqrt(1 + n/32) in Q32. */
#define ROOT_Q_STEPS 96
extern const uint32_t root_q_table[ROOT_Q_STEPS + 1];

/* Number of bits by which a number is shifted up, from its first six bits, until it is in 32..63; for 0: one
 * more. */
extern const uint16_t root_q_ups[64];

#define ROOT_Q_ONE UINT32_C(0x10000000) /* Q28 */

/* 1/sqrt(m) in Q31 for m in Q28, below 4; below 1 the result is that of 1. */
static inline uint32_t root_inverse_q(uint32_t m)
{
    uint32_t within = m < ROOT_Q_ONE ? ROOT_Q_ONE : m;
    uint32_t n = (within >> 23) - 32u;
    uint32_t y = root_q_table[n] - q_high_unsigned(root_q_table[n] - root_q_table[n + 1u], within << 9);
    uint32_t near_one = q_high_unsigned(within, q_high_unsigned(y, y)); /* m y^2, Q28 */
    return q_high_unsigned(y, 4u * (3u * ROOT_Q_ONE - near_one));
}

/* Length of the vector (x, y) and x over it. */
typedef struct {
    int32_t length; /* in the format of x and y */
    int32_t cosine; /* Q30: -2^30..2^30 [-] */
} direction_q_t;

/* For components below 2^30 in size and a vector not shorter than 64, each result is within 2e-8 of the
 * length and one unit. For a shorter vector the length is not above its own, and the cosine is undefined. Six
 * products; the vector is shifted to full size by 32-bit shifts, not its square. */
static inline direction_q_t direction_q(int32_t x, int32_t y)
{
    uint32_t width = (uint32_t)(x < 0 ? -x : x);
    uint32_t height = (uint32_t)(y < 0 ? -y : y);
    uint32_t longest = width | height;
    uint32_t up = 0u;
    if (longest < (UINT32_C(1) << 18)) {
        longest <<= 12;
        up = 12u;
    }
    if (longest < (UINT32_C(1) << 24)) {
        longest <<= 6;
        up += 6u;
    }
    up += root_q_ups[(longest >> 24) & 63u];

    /* The longer component is in 2^30..2^31, so the square is in 2^60..2^63; then below 2^62. */
    width <<= up;
    height <<= up;
    uint32_t m = (uint32_t)(((uint64_t)width * width + (uint64_t)height * height) >> 32);
    if (m >= 4u * ROOT_Q_ONE) {
        m >>= 2;
        width >>= 1;
        up -= 1u;
    }
    uint32_t inverse = root_inverse_q(m);
    uint32_t length = ((8u * q_high_unsigned(m, inverse)) & UINT32_C(0x7fffffff)) >> up;
    uint32_t share = 2u * q_high_unsigned(width, inverse);
    uint32_t cosine = share < (uint32_t)Q_ONE(30) ? share : (uint32_t)Q_ONE(30);
    direction_q_t direction;
    direction.length = (int32_t)length;
    direction.cosine = x < 0 ? -(int32_t)cosine : (int32_t)cosine;
    return direction;
}

#endif
