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

/* An angle as its sine and cosine, Q30; made by trig_rotation_q(). */
typedef struct {
    int32_t sin, cos;
} rotation_q_t;

/* Stationary frame to the frame turned by `angle`, saturated. */
static inline dq_q_t frames_park_q(ab_q_t stationary, rotation_q_t angle)
{
    dq_q_t rotor;
    rotor.d = q_saturate(
        q_round(q_product(stationary.alpha, angle.cos) + q_product(stationary.beta, angle.sin), 30));
    rotor.q = q_saturate(
        q_round(q_product(stationary.beta, angle.cos) - q_product(stationary.alpha, angle.sin), 30));
    return rotor;
}

#endif
