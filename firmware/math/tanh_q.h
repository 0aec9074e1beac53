/* Hyperbolic tangent as the ratio tanh(x)/x of x^2, in integers; see tanh.h.
 *
 *     x^2 < 2     table in steps of 1/16, a parabola in each: error 7e-7
 *     x^2 < 64    32 steps for each doubling, a parabola in each: relative error 6e-7
 *     64 <= x^2   1/x: the difference of tanh from 1 is 2.3e-7 there
 *
 * and the rounding, 2 units of 2^-30. No state, no division. */
#ifndef MATH_TANH_Q_H
#define MATH_TANH_Q_H

#include <stdint.h>

#include "math/q.h"

/* Format of the square, and the end of the equal steps in this format. */
#define TANH_Q_SQUARE    44
#define TANH_Q_SHORT_END (INT64_C(2) << TANH_Q_SQUARE)

/* A piece of the function: value + slope p + bend p^2, p = 0..1 along the piece. */
typedef struct {
    int32_t value; /* Q30 */
    int32_t slope; /* Q31 */
    int32_t bend;  /* Q32 */
} tanh_piece_q_t;

#define TANH_Q_PIECES 192
extern const tanh_piece_q_t tanh_q_pieces[TANH_Q_PIECES];

/* `along` is p, Q31. */
static inline int32_t tanh_within_q(const tanh_piece_q_t *piece, int32_t along)
{
    return piece->value + q_high(piece->slope + q_high(piece->bend, along), along);
}

/* tanh_ratio_q() up to x^2 = 2, inline for the interrupt: `square` is in 0..TANH_Q_SHORT_END - 1. */
static inline int32_t tanh_ratio_short_q(int64_t square)
{
    uint64_t z = (uint64_t)square;
    return tanh_within_q(&tanh_q_pieces[(z >> (TANH_Q_SQUARE - 4)) & 31u],
                         (int32_t)((z >> (TANH_Q_SQUARE - 35)) & UINT32_C(0x7fffffff)));
}

/* tanh(x)/x in Q30 for x^2 in Q44, the whole range of the type; exactly 1 at 0. */
int32_t tanh_ratio_q(uint64_t square);

#endif
