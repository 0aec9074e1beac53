/* Reciprocal square root in integers, for lengths, unit vectors and reciprocals (of the square): no division.
 *
 * The square is moved by an even number of bits until it lies in [2^62, 2^64); a table of 1/sqrt on [1, 4) in
 * steps of 1/32, read linearly, is within 9.2e-5, one Newton step y (3 - m y^2)/2 leaves 1.3e-8 and the
 * rounding. No state, no division. */
#ifndef MATH_ROOT_Q_H
#define MATH_ROOT_Q_H

#include <stdint.h>

/* A smaller square counts as this. */
#define ROOT_Q_SMALLEST UINT64_C(4)

/* 1/sqrt(square) = mantissa 2^(shift - 61). A number x not longer than sqrt(square), times 2^shift, is below
 * 2^32. */
typedef struct {
    int32_t mantissa; /* Q30: 2^29..2^30 [-] */
    int32_t shift;    /* 0..30 [-] */
} root_q_t;

/* Relative error within 2e-8. One table look-up, four products. */
root_q_t inverse_root_q(uint64_t square);

/* sqrt(square), down to a whole number; within 2e-8 of it and one. From its reciprocal, if that is known: two
 * products. */
uint32_t root_from_q(uint64_t square, root_q_t inverse);
uint32_t root_q(uint64_t square);

#endif
