#include "math/angle.h"

#include <stdint.h>

#define TURNS_PER_RADIAN 0.159154943f

/* 2 pi = HIGH + LOW. HIGH = 6434/1024 has 13 bits, a number of turns below ANGLE_WRAP_LIMIT has 11: their
 * product is exact, and so is its difference from the angle. */
#define TWO_PI_HIGH 6.283203125f
#define TWO_PI_LOW  -1.78178204e-5f

float angle_wrap_far(float angle)
{
    if (!(angle >= -ANGLE_WRAP_LIMIT && angle <= ANGLE_WRAP_LIMIT)) {
        return 0.0f;
    }

    float nearest = angle * TURNS_PER_RADIAN + (angle < 0.0f ? -0.5f : 0.5f);
    float turns = (float)(int32_t)nearest;
    float wrapped = (angle - turns * TWO_PI_HIGH) - turns * TWO_PI_LOW;

    /* Near half a turn the rounding of `nearest` may have chosen the neighbouring turn, and rounding of the
     * difference may have ended on the float beyond pi. A whole turn back from there always ends inside. */
    if (wrapped > ANGLE_LARGEST) {
        wrapped = (wrapped - TWO_PI_HIGH) - TWO_PI_LOW;
    } else if (wrapped < -ANGLE_LARGEST) {
        wrapped = (wrapped + TWO_PI_HIGH) + TWO_PI_LOW;
    }
    return wrapped;
}
