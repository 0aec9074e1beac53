#include "math/tanh.h"

#include "math/root.h"

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
