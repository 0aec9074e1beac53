#include "math/tanh.h"

#include "math/root.h"

/* x^2 up to which the short quotient holds, and the long one. */
#define SHORT_END 2.0f
#define LONG_END  52.0f

/* x^2 from which tanh(x) counts as 1; it lacks 1.7e-6. */
#define SATURATED 49.0f

static float beyond_short(float z)
{
    if (z > LONG_END) {
        return inverse_root(z);
    }
    float above = 7264.06152f + z * (819.032837f + z * 12.2323818f);
    float below = 7464.94629f + z * (3397.83374f + z * (154.141296f + z));
    return 0.0268428363f + above / below;
}

float tanh_ratio(float square)
{
    if (square > SHORT_END) {
        return beyond_short(square);
    }
    return (111.209503f + square * 10.4015303f) / (111.209503f + square * (47.4701691f + square));
}

float tanh_value(float x)
{
    float square = x * x;
    if (square <= SATURATED) {
        return x * tanh_ratio(square);
    }
    return x > 0.0f ? 1.0f : (x < 0.0f ? -1.0f : 0.0f);
}
