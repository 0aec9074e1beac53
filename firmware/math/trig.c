#include "math/trig.h"

#include <stdbool.h>

#include "math/angle.h"

#define HALF_PI 1.57079633f

/* Outside these |x| + |y| the quotient of the two is not to be trusted (denormal or infinite). */
#define ATAN2_SHORTEST 1e-37f
#define ATAN2_LONGEST  1e38f

rotation_t trig_rotation(float theta)
{
    rotation_t rotation = {0.0f, 0.0f};
    if (!(theta >= -TRIG_LIMIT && theta <= TRIG_LIMIT)) {
        return rotation;
    }

    float half = 0.5f * theta;
    float z = half * half;
    float sine =
        half * (0.999999746f +
                z * (-0.16666539f + z * (8.33153559e-3f + z * (-1.97376511e-4f + z * 2.49249290e-6f))));
    float cosine =
        1.0f + z * (-0.49999993f +
                    z * (0.0416664622f + z * (-1.38866962e-3f + z * (2.46950458e-5f - z * 2.51549356e-7f))));
    float twice = 2.0f * sine;
    rotation.sin = twice * cosine;
    rotation.cos = 1.0f - twice * sine;
    return rotation;
}

float trig_sin(float theta)
{
    return trig_rotation(theta).sin;
}

float trig_cos(float theta)
{
    return trig_rotation(theta).cos;
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
