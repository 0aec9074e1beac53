/* The result is compared with sqrt() in double precision. After the first Newton step the error is within
 * +-6.5e-4; the second step leaves 1.5 times its square, 3.2e-7 if centred. The second step is rounded
 * five times by 2^-24: three times in a product of 1/2, once in the difference and once in the last
 * product. The sum would be 2.1e-7 if all roundings were at their worst together; the exhaustive test
 * shows that they are not. A factor of 4 in the argument is exactly one of 2 in the result, so that [1, 4)
 * is representative, down to values whose products become denormal (2.4e-38). */
#include <float.h>

#include "math/root.h"
#include "tests/unit/worst.h"

#define TOLERANCE 5e-7

static void look_at(float square)
{
    keep_worst((double)inverse_root(square) * sqrt((double)square) - 1.0);
}

static void test_every_float_from_one_to_four(void)
{
    for (uint32_t k = 0; k < UINT32_C(0x1000000); k += SWEEP) {
        look_at(ldexpf(1.0f + ldexpf((float)(k & UINT32_C(0x7FFFFF)), -23), (int)(k >> 23)));
    }
    check("relative", TOLERANCE);
}

static void test_whole_range(void)
{
    for (double square = 1e-30; square < 1e30; square *= 1.0 + 3e-5 * SWEEP) {
        look_at((float)square);
    }
    look_at(1e-30f);
    look_at(1e30f);
    check("relative", TOLERANCE);
}

static void test_ends_of_the_float_range(void)
{
    for (float square = 1e-37f; square < 1e-28f; square *= 1.0f + 3e-4f * SWEEP) {
        look_at(square);
    }
    for (float square = FLT_MAX; square > 1e28f; square /= 1.0f + 3e-4f * SWEEP) {
        look_at(square);
    }
    check("relative", TOLERANCE);
}

static void check_below_range(float square)
{
    float root = inverse_root(square);
    char text[64];
    snprintf(text, sizeof text, "inverse_root(%g) = %g", (double)square, (double)root);
    TEST_ASSERT_TRUE_MESSAGE(root >= 1e18f && root <= 3e19f, text);
}

static void test_zero_and_denormals_give_something_finite_and_positive(void)
{
    check_below_range(0.0f);
    for (float square = nextafterf(0.0f, 1.0f); square < 1e-37f; square = nextafterf(square * 1.01f, 1.0f)) {
        check_below_range(square);
    }
}
