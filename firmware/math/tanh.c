#include "math/tanh.h"

#include <stdint.h>

#include "math/root.h"

/* x^2 up to which the second quotient is valid. */
#define LONG_END 52.0f

/* x^2 from which tanh(x) is set to 1; the difference is 1.7e-6. */
#define SATURATED 49.0f

float tanh_ratio_far(float square)
{
    float z = square;
    if (z > LONG_END) {
        return inverse_root(z);
    }
    float above = 7264.06152f + z * (819.032837f + z * 12.2323818f);
    float below = 7464.94629f + z * (3397.83374f + z * (154.141296f + z));
    return 0.0268428363f + above / below;
}

/* The largest tanh(x)^2 that is inverted. Newton's method reaches float accuracy in seven steps from the
 * worst start. */
#define INVERTED_MAX 0.98f
#define STEPS        10

/* tanh^2 is concave in z = x^2 and not above it, so Newton's method from z = square rises to the root without
 * passing it; no square root is needed. */
float tanh_ratio_at(float square)
{
    float target = square < INVERTED_MAX ? square : INVERTED_MAX;
    float z = target;
    float ratio = tanh_ratio(z);
    for (int32_t n = 0; n < STEPS; n++) {
        float reached = z * ratio * ratio;
        z += (target - reached) / (ratio * (1.0f - reached));
        ratio = tanh_ratio(z);
    }
    return ratio;
}

float tanh_value(float x)
{
    float square = x * x;
    if (square <= SATURATED) {
        return x * tanh_ratio(square);
    }
    return x > 0.0f ? 1.0f : (x < 0.0f ? -1.0f : 0.0f);
}
