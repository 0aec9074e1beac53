/* Sine, cosine and arc tangent by polynomials, for the interrupt.
 *
 *     h = theta/2,   sin theta = 2 sin h cos h,   cos theta = 1 - 2 (sin h)^2
 *
 * with minimax polynomials of degree 9 for sin h and 10 for cos h on |h| <= 2: a wrapped angle and what it
 * moves in a period and a half need no reduction and no quadrants. atan2 divides the shorter component by the
 * longer, so that one odd polynomial of degree 11 on [0, 1] covers the plane.
 *
 * No state, no libm, no loop. Does not handle angles beyond TRIG_LIMIT: wrap first. */
#ifndef MATH_TRIG_H
#define MATH_TRIG_H

#include "math/frames.h"

/* The widest angle [rad]. */
#define TRIG_LIMIT 4.0f

/* Sine and cosine of `theta` [rad], |theta| <= TRIG_LIMIT: within 4e-7 each. Beyond that and for a non-finite
 * angle both are 0, a rotation that turns every vector into none: no voltage on an unknown angle. Straight
 * line, no division. */
rotation_t trig_rotation(float theta);

/* One of the two [-], at the price of both; same range, accuracy and edges. */
float trig_sin(float theta);
float trig_cos(float theta);

/* Angle of the vector (x, y) [rad], within +-ANGLE_LARGEST as angle_wrap() and within 3e-6 of the exact
 * angle, in all quadrants, for |x| + |y| between 1e-37 and 1e38. A shorter vector, (0, 0) included, a longer
 * one and a non-finite one give 0. One division. */
float trig_atan2(float y, float x);

#endif
