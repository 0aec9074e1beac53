#include "math/trig.h"

#include <stdbool.h>

#include "math/angle.h"

#define HALF_PI 1.57079633f

/* (theta/2)^2 at the limit; the squares of the adjacent floats differ from it. */
#define WIDEST (0.25f * TRIG_LIMIT * TRIG_LIMIT)

/* If |x| + |y| is outside these limits, the quotient is not reliable (denormal or infinite). */
#define ATAN2_SHORTEST 1e-37f
#define ATAN2_LONGEST  1e38f

rotation_t trig_rotation(float theta)
{
    rotation_t rotation = {0.0f, 0.0f};
    float half = 0.5f * theta;
    float z = half * half;
    if (!(z <= WIDEST)) {
        return rotation;
    }

    /* Minimax of both results together, 3.4e-8; the last digits of the coefficients are those with the best
     * rounding among the adjacent floats. */
    float sine =
        half * (0.99999994f +
                z * (-0.166665792f + z * (8.33178405e-3f + z * (-1.9743343e-4f + z * 2.49662503e-6f))));
    float cosine =
        1.0f +
        z * (-0.5f + z * (0.0416667573f + z * (-1.38888578e-3f + z * (2.4752082e-5f - z * 2.56654999e-7f))));
    float twice = 2.0f * cosine;
    rotation.sin = twice * sine;
    rotation.cos = twice * cosine - 1.0f;
    return rotation;
}

float trig_atan2(float y, float x)
{
    float width = x < 0.0f ? -x : x;
    float height = y < 0.0f ? -y : y;
    float sum = width + height;
    if (!(sum >= ATAN2_SHORTEST && sum <= ATAN2_LONGEST)) {
        return 0.0f;
    }

    bool steep = height > width;
    float ratio = steep ? width / height : height / width;
    float square = ratio * ratio;

    /* Minimax of atan(r)/r on [0, 1], error 1.7e-6 of the angle. */
    float angle =
        ratio *
        (0.999977219f +
         square * (-0.332622829f +
                   square * (0.193540379f +
                             square * (-0.116426487f + square * (0.0526473551f - square * 0.0117191366f)))));
    if (steep) {
        angle = HALF_PI - angle;
    }
    if (x < 0.0f) {
        angle = ANGLE_LARGEST - angle;
    }
    return y < 0.0f ? -angle : angle;
}

float trig_angle(rotation_t rotation)
{
    const float width = bounds_magnitude(rotation.cos);
    const float height = bounds_magnitude(rotation.sin);
    const bool steep = height > width;
    const float less = steep ? width : height;
    const float z = less * less;
    float angle = less * (1.0f + z * (0.166666667f + z * (0.075f + z * 0.0446428571f)));
    if (steep) {
        angle = HALF_PI - angle;
    }
    if (rotation.cos < 0.0f) {
        angle = ANGLE_LARGEST - angle;
    }
    if (rotation.sin < 0.0f) {
        angle = -angle;
    }
    const rotation_t found = trig_turn(angle);
    return angle_turn_back(angle + rotation.sin * found.cos - rotation.cos * found.sin);
}
