/* Sine, cosine and arc tangent of binary angles, 2^-32 of a turn (q.h).
 *
 * Sine and cosine: those of the nearest 64th of a turn from a table, rotated by the rest d of at most 0.05
 * rad: sin d = d - d^3/6, cos d = 1 - d^2/2 + d^4/24. No state. */
#ifndef MATH_TRIG_Q_H
#define MATH_TRIG_Q_H

#include <stdint.h>

#include "math/frames_q.h"

/* sin(2 pi n/64), Q30; the cosine is found 16 entries later. */
#define TRIG_Q_STEPS   64
#define TRIG_Q_QUARTER 16
extern const int32_t trig_q_sines[TRIG_Q_STEPS + TRIG_Q_QUARTER];

/* Sine and cosine in Q30, each within 6e-9; odd and even, exactly 0 and 1 at whole quarters. No branches;
 * nine products, inline for the interrupt. */
static inline rotation_q_t trig_rotation_q(uint32_t angle)
{
    const uint32_t half_step = UINT32_C(1) << 25;
    uint32_t turned = angle + half_step;
    const int32_t *sine = &trig_q_sines[turned >> 26];
    int32_t rest = (int32_t)(turned & (2u * half_step - 1u)) - (int32_t)half_step;

    /* Q32; 2 pi is in Q26. */
    int32_t d = q_high_near(rest * 64, INT32_C(421657428));
    int32_t square = q_high(d, d);
    int32_t share = q_high(square, INT32_C(178956971)); /* d^2/24 */
    int32_t s = d - q_high_near(d, 4 * share);
    int32_t c = q_high(square, share) - square / 2; /* cos d - 1 */

    int32_t from_sine = sine[0];
    int32_t from_cosine = sine[TRIG_Q_QUARTER];
    rotation_q_t rotation;
    rotation.sin = from_sine + q_word(q_product(from_cosine, s) + q_product(from_sine, c));
    rotation.cos = from_cosine + q_word(q_product(from_cosine, c) + q_product(from_sine, -s));
    return rotation;
}

/* Angle of the vector (x, y), within 1.2e-7 rad; (0, 0): 0. INT32_MIN counts as -INT32_MAX. No
 * division. */
uint32_t trig_atan2_q(int32_t y, int32_t x);

#endif
