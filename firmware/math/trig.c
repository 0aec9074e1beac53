#include "math/trig.h"

#include <stdbool.h>
#include <stdint.h>

#include "math/angle.h"

#define QUARTERS_PER_RADIAN 0.636619772f
#define HALF_PI             1.57079633f

/* pi/2 = HIGH + LOW. HIGH = 102944/65536 has 17 bits, a number of quarters below TRIG_LIMIT has 7: exact
 * products. */
#define HALF_PI_HIGH 1.57080078125f
#define HALF_PI_LOW  -4.45445510e-6f

/* Outside these |x| + |y| the quotient of the two is not to be trusted (denormal or infinite). */
#define ATAN2_SHORTEST 1e-37f
#define ATAN2_LONGEST  1e38f

/* Minimax on |r| <= pi/4, error 2e-9. */
static float sine_near_zero(float r)
{
    float square = r * r;
    return r + r * square * (-0.166666494f + square * (8.33190875e-3f - square * 1.94868531e-4f));
}

/* Minimax on |r| <= pi/4, error 1e-10. */
static float cosine_near_zero(float r)
{
    float square = r * r;
    float rest = 0.0416666453f + square * (-1.38872889e-3f + square * 2.44292130e-5f);
    return 1.0f - 0.5f * square + square * square * rest;
}

rotation_t trig_rotation(float theta)
{
    rotation_t rotation = {0.0f, 0.0f};
    if (!(theta >= -TRIG_LIMIT && theta <= TRIG_LIMIT)) {
        return rotation;
    }

    int32_t quarters = (int32_t)(theta * QUARTERS_PER_RADIAN + (theta < 0.0f ? -0.5f : 0.5f));
    float turned = (float)quarters;
    float r = (theta - turned * HALF_PI_HIGH) - turned * HALF_PI_LOW;
    float sine = sine_near_zero(r);
    float cosine = cosine_near_zero(r);

    uint32_t quadrant = (uint32_t)quarters & UINT32_C(3);
    bool swapped = (quadrant & UINT32_C(1)) != 0;
    rotation.sin = swapped ? cosine : sine;
    rotation.cos = swapped ? sine : cosine;
    if ((quadrant & UINT32_C(2)) != 0) {
        rotation.sin = -rotation.sin;
    }
    if (quadrant == 1 || quadrant == 2) {
        rotation.cos = -rotation.cos;
    }
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
