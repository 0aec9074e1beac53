#include "math/angle.h"

#include <stdint.h>

#define TURNS_PER_RADIAN 0.159154943f

float angle_wrap_far(float angle)
{
    if (!(angle >= -ANGLE_WRAP_LIMIT && angle <= ANGLE_WRAP_LIMIT)) {
        return 0.0f;
    }

    float nearest = angle * TURNS_PER_RADIAN + (angle < 0.0f ? -0.5f : 0.5f);
    float turns = (float)(int32_t)nearest;
    float wrapped = (angle - turns * ANGLE_TURN_HIGH) - turns * ANGLE_TURN_LOW;

    /* Near half a turn the rounding of `nearest` may have selected the adjacent turn, and the rounding of
     * the difference may have given the float beyond pi. A step back by a whole turn always gives a value
     * inside. */
    return angle_turn_back(wrapped);
}
