/* Stationary and rotor frame in fixed point; see frames.h. Both components of a value have one format. */
#ifndef MATH_FRAMES_Q_H
#define MATH_FRAMES_Q_H

#include <stdint.h>

#include "math/q.h"

typedef struct {
    int32_t alpha, beta;
} ab_q_t;

typedef struct {
    int32_t d, q;
} dq_q_t;

/* Format of sine and cosine. */
#define ROTATION_Q 30

/* An angle as its sine and cosine; made by trig_rotation_q(). */
typedef struct {
    int32_t sin, cos;
} rotation_q_t;

/* Stationary frame to the frame rotated by `angle`. Components up to 2^30 in size fit: |d|, |q| < 1.42
 * 2^30. */
static inline dq_q_t frames_park_q(ab_q_t stationary, rotation_q_t angle)
{
    dq_q_t rotor;
    rotor.d = (int32_t)q_round(q_product(stationary.alpha, angle.cos) + q_product(stationary.beta, angle.sin),
                               ROTATION_Q);
    rotor.q = (int32_t)q_round(q_product(stationary.beta, angle.cos) - q_product(stationary.alpha, angle.sin),
                               ROTATION_Q);
    return rotor;
}

#endif
