/* Sine, cosine and arc tangent by polynomials, for the interrupt.
 *
 *     h = theta/2,   sin theta = 2 sin h cos h,   cos theta = 2 (cos h)^2 - 1
 *
 * with minimax polynomials of degree 9 for sin h and 10 for cos h on |h| <= 2: a wrapped angle plus its
 * change in a period and a half needs neither range reduction nor quadrants. atan2 divides the shorter
 * component by the longer, so that one odd polynomial of degree 11 on [0, 1] covers the plane.
 *
 * trig_turn() is faster and less accurate, for the tracking loop, which needs it in every period.
 *
 * No state, no libm, no loop. Does not handle: angles beyond TRIG_LIMIT, which the caller has to wrap
 * first. */
#ifndef MATH_TRIG_H
#define MATH_TRIG_H

#include "math/frames.h"

/* The largest angle [rad]. */
#define TRIG_LIMIT 4.0f

/* Sine and cosine of `theta` [rad]: each within 4e-7 for |theta| <= pi and within 5e-7 up to TRIG_LIMIT;
 * sin^2 + cos^2 within 8e-7 of 1, and the relative error of the sine within 3e-7 for |theta| <= 1. Exactly 0
 * and 1 at 0; exactly odd and even. Beyond the limit and for a non-finite angle both are 0, a rotation that
 * turns every vector into zero, so that an unknown angle gives no voltage. One compare, no other branch, no
 * division. */
rotation_t trig_rotation(float theta);

/* The same for a wrapped angle in fewer steps: angle and length of the rotation within 1.4e-6 of the exact
 * ones and the rounding, 6e-7. Exactly 0 and 1 at 0; exactly odd and even. Requires |theta| <= pi. With S =
 * sqrt 2 sin(theta/2), C = sqrt 2 cos(theta/2): sin theta = S C, cos theta = 1 - S^2. 19 multiplications,
 * additions and subtractions. */
static inline rotation_t trig_turn(float theta)
{
    float z = theta * theta;
    float s = theta * (0.707102309f + z * (-0.0294582966f + z * (3.66876518e-4f - z * 2.01757679e-6f)));
    float c =
        1.41422007f + z * (-0.176781206f + z * (3.68393215e-3f + z * (-3.07711755e-5f + z * 1.34300054e-7f)));
    rotation_t rotation = {s * c, 1.0f - s * s};
    return rotation;
}

/* Largest angle of trig_advance() [rad]. */
#define TRIG_ADVANCE_LIMIT 0.95f

/* A rotation advanced by `angle` [rad], |angle| <= TRIG_ADVANCE_LIMIT: the error of the added angle is within
 * 1.2e-6 rad, that of the length within 1.5e-6, and the rounding; at 1.6 rad within 2e-4. No branches; 21
 * multiplications, additions and subtractions. */
static inline rotation_t trig_advance(rotation_t from, float angle)
{
    float z = angle * angle;
    float s = angle * (1.0f + z * (-0.166666667f + z * (8.33333333e-3f - z * 1.98412698e-4f)));
    float c = 1.0f + z * (-0.5f + z * (0.0416666667f - z * (1.38888889e-3f - z * 2.48015873e-5f)));
    rotation_t rotation = {from.sin * c + from.cos * s, from.cos * c - from.sin * s};
    return rotation;
}

/* Angle of the vector (x, y) [rad], within +-ANGLE_LARGEST like angle_wrap() and within 3e-6 of the exact
 * angle, in all quadrants, for |x| + |y| between 1e-37 and 1e38. A shorter vector, (0, 0) included, a longer
 * one and a non-finite one give 0. One division. */
float trig_atan2(float y, float x);

/* Angle of a rotation [rad], within +-ANGLE_LARGEST. The error is at most 2e-6, or 6e-6 if the length differs
 * from 1 by up to 1e-3. Method: a series of the arc sine of the smaller component, with an error of 3e-3, and
 * one Newton step. (0, 0) gives 0. No division. */
float trig_angle(rotation_t rotation);

#endif
