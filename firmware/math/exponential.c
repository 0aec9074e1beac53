#include "math/exponential.h"

#include <stdint.h>

#define EXPONENT_LIMIT 80.0f
#define ONE_OVER_LN_2  1.44269504f
#define LN_2           0.693147181f

/* ln 2 = HIGH + LOW. HIGH = 90852/131072 has 17 bits, the number of halvings (at most 116) has 7: exact
 * products. */
#define LN_2_HIGH 0.693145751953125f
#define LN_2_LOW  1.42860682e-6f

/* 2^-halvings, exact: a factor for each bit of the count. */
static float halved(float value, int32_t halvings)
{
    static const float factors[7] = {0.5f,           0.25f,           0.0625f,        3.90625e-3f,
                                     1.52587891e-5f, 2.32830644e-10f, 5.42101086e-20f};
    for (int32_t bit = 0; bit < 7; bit++) {
        if (((halvings >> bit) & 1) != 0) {
            value *= factors[bit];
        }
    }
    return value;
}

float exponential(float x)
{
    if (x > 0.0f) {
        return 1.0f;
    }
    if (!(x >= -EXPONENT_LIMIT)) {
        return 0.0f;
    }

    int32_t halvings = (int32_t)(0.5f - x * ONE_OVER_LN_2);
    float count = (float)halvings;
    float r = (x + count * LN_2_HIGH) + count * LN_2_LOW;

    /* Minimax on |r| <= ln(2)/2, relative error 1.1e-7. */
    float rest = 0.499992232f + r * (0.166671198f + r * (0.0418913746f + r * 8.31238811e-3f));
    return halved(1.0f + (r + r * r * rest), halvings);
}

float exponential_rest(float x)
{
    if (!(x > 0.0f)) {
        return 0.0f;
    }
    if (x > EXPONENT_LIMIT) {
        return 1.0f;
    }
    if (x > LN_2) {
        return 1.0f - exponential(-x);
    }

    /* Minimax on [0, ln 2], relative error 1.1e-8. */
    float rest =
        -0.499999336f + x * (0.166653369f + x * (-0.0415790414f + x * (8.07718202e-3f - x * 1.03824023e-3f)));
    return x + x * x * rest;
}
