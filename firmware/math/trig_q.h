/* Sine, cosine and arc tangent of binary angles, 2^-32 of a turn (q.h).
 *
 * The angle is split into a quarter turn and a rest of at most an eighth either way, for which minimax
 * polynomials of degree 7 and 8 in the rest give both. No state, no table. */
#ifndef MATH_TRIG_Q_H
#define MATH_TRIG_Q_H

#include <stdint.h>

#include "math/frames_q.h"

/* Sine and cosine in Q30, each within 6e-9; exactly 0 and 1 at whole quarters. No division. */
rotation_q_t trig_rotation_q(uint32_t angle);

/* Angle of the vector (x, y), within 1.2e-7 rad; (0, 0): 0. INT32_MIN counts as -INT32_MAX. One division of
 * 64 bits: not for the interrupt. */
uint32_t trig_atan2_q(int32_t y, int32_t x);

#endif
