/* Angles in radians, kept in [-pi, pi).
 *
 *     wrap(x) = x - 2 pi round(x / 2 pi)
 *
 * 2 pi is subtracted in two parts, the first with so few bits that its multiples are exact: the result is the
 * wrapped angle of exactly the float given. No state, no loop.
 *
 * Does not handle: the loss of resolution of a large float itself (at 1e4 rad one step of x is 1 mrad). */
#ifndef MATH_ANGLE_H
#define MATH_ANGLE_H

#include "math/bounds.h"

#define ANGLE_PI     3.14159265f
#define ANGLE_TWO_PI 6.28318531f

/* The largest input of angle_wrap() [rad]. */
#define ANGLE_WRAP_LIMIT 1.0e4f

/* The largest result [rad]: the float next below pi. The float nearest to pi, ANGLE_PI, is larger than pi. */
#define ANGLE_LARGEST 3.14159250f

/* 2 pi = HIGH + LOW. HIGH = 6434/1024 has 13 bits, a number of turns below ANGLE_WRAP_LIMIT has 11: their
 * product is exact, and so is its difference from the angle. */
#define ANGLE_TURN_HIGH 6.283203125f
#define ANGLE_TURN_LOW  -1.78178204e-5f

/* angle_wrap() for an angle that is at most a turn outside: |angle| <= 3 pi. */
static inline float angle_turn_back(float angle)
{
    if (bounds_magnitude(angle) <= ANGLE_LARGEST) {
        return angle;
    }
    return angle > 0.0f ? (angle - ANGLE_TURN_HIGH) - ANGLE_TURN_LOW
                        : (angle + ANGLE_TURN_HIGH) + ANGLE_TURN_LOW;
}

/* The part of angle_wrap() for an angle that is outside. */
float angle_wrap_far(float angle);

/* `angle` [rad] plus the multiple of 2 pi that brings it into [-pi, pi); within 4e-7 rad of the exact value
 * for |angle| <= 1e4 rad (distance on the circle: for an input within rounding of +-pi the result may be at
 * either end). The result is always within +-ANGLE_LARGEST, hence inside [-pi, pi) also for the exact pi. An
 * input that is already inside is returned unchanged. Beyond 1e4 rad and for a non-finite angle: 0. One
 * multiplication by 1/(2 pi), one compare for an input inside, no division. */
static inline float angle_wrap(float angle)
{
    return bounds_magnitude(angle) <= ANGLE_LARGEST ? angle : angle_wrap_far(angle);
}

#endif
