#include "math/tanh.h"

#include <stdint.h>

/* x^2 from which tanh(x) counts as 1. */
#define SATURATED 64.0f

float tanh_ratio(float square)
{
    if (square > SATURATED) {
        return inverse_root(square);
    }
    float z = square > 0.0f ? square : 0.0f;
    float above = 1.0f + z * (0.129303581f + z * (2.95581133e-3f + z * 1.14751527e-5f));
    float below = 1.0f + z * (0.462636123f + z * (0.0238358002f + z * (2.39315438e-4f + z * 2.47324508e-7f)));
    return above / below;
}

float tanh_value(float x)
{
    float square = x * x;
    if (square <= SATURATED) {
        return x * tanh_ratio(square);
    }
    return x > 0.0f ? 1.0f : (x < 0.0f ? -1.0f : 0.0f);
}

float inverse_root(float square)
{
    /* 4^32, 4^16, ... and the roots of their inverses. */
    static const float powers[6] = {1.84467441e19f, 4294967296.0f, 65536.0f, 256.0f, 16.0f, 4.0f};
    static const float inverses[6] = {5.42101086e-20f, 2.32830644e-10f, 1.52587891e-5f,
                                      3.90625e-3f,     0.0625f,         0.25f};
    static const float roots[6] = {4294967296.0f, 65536.0f, 256.0f, 16.0f, 4.0f, 2.0f};
    static const float inverse_roots[6] = {2.32830644e-10f, 1.52587891e-5f, 3.90625e-3f,
                                           0.0625f,         0.25f,          0.5f};

    float z = square;
    float scale = 1.0f;
    if (z > INVERSE_ROOT_LARGEST) {
        z = INVERSE_ROOT_LARGEST;
    }
    if (!(z >= INVERSE_ROOT_SMALLEST)) {
        z = INVERSE_ROOT_SMALLEST;
    }
    if (z >= 4.0f) {
        for (int32_t n = 0; n < 6; n++) {
            if (z >= powers[n]) {
                z *= inverses[n];
                scale *= inverse_roots[n];
            }
        }
    } else if (z < 1.0f) {
        /* Up to [1, 4): as often as the result stays below 4. */
        for (int32_t n = 0; n < 6; n++) {
            if (z * powers[n] < 4.0f) {
                z *= powers[n];
                scale *= roots[n];
            }
        }
    }

    float y = 1.55621313f + z * (-0.7388926f + z * (0.19469588f - z * 0.01905149f));
    float half = 0.5f * z;
    y = y * (1.5f - half * y * y);
    y = y * (1.5f - half * y * y);
    return y * scale;
}
