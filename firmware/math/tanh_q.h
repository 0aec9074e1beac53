/* Hyperbolic tangent as the ratio tanh(x)/x of x^2, in integers; see tanh.h.
 *
 *     x^2 < 2     table in steps of 1/32, parabola through three knots: error 7e-7
 *     x^2 < 64    32 steps for each doubling, likewise: relative error 4e-6
 *     64 <= x^2   1/x: what tanh lacks to 1 there is 2.3e-7
 *
 * and the rounding, 2 units of 2^-30. No state, no division. */
#ifndef MATH_TANH_Q_H
#define MATH_TANH_Q_H

#include <stdint.h>

/* Format of the square. */
#define TANH_Q_SQUARE 44

/* tanh(x)/x in Q30 for x^2 in Q44, the whole range of the type; exactly 1 at 0. */
int32_t tanh_ratio_q(uint64_t square);

#endif
