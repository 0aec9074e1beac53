/* The results are compared with tanh() and sqrt() in double precision. The 2e-6 of the header consist of
 * the errors of the fits and of rounding. The fits have errors of 8.4e-7, 1.1e-6 and 1.1e-6, and tanh(7)
 * is 1.7e-6 below 1. In the short quotient three roundings of 2^-24 above and below the line and one of
 * the division make at worst 4e-7; the long quotient has one more, that of its last sum. 1/sqrt has 5e-7. */
#include <float.h>

#include "math/tanh.h"
#include "tests/unit/worst.h"

#define TOLERANCE 2e-6

/* The amount by which rounding of sum, division and last sum may raise a value that should decrease. */
#define ROUNDING 3e-7

static double exact_ratio(float square)
{
    double x = sqrt((double)square);
    return x > 0.0 ? tanh(x) / x : 1.0;
}

/* Every seventh float from small values to saturation, over the whole range. */
static void test_ratio_over_the_whole_range(void)
{
    for (float square = 1e-4f; square <= 100.0f; square = floats_on(square, 7)) {
        keep_worst((double)tanh_ratio(square) / exact_ratio(square) - 1.0);
    }
    for (double z = 1e-35; z < 1e30; z *= 1.0 + 1e-4 * SWEEP) {
        keep_worst((double)tanh_ratio((float)z) / exact_ratio((float)z) - 1.0);
    }
    keep_worst((double)tanh_ratio(1e30f) * 1e15 - 1.0);
    check("tanh_ratio to 1e30", TOLERANCE);
}

static void test_ratio_falls(void)
{
    float before = tanh_ratio(0.0f);
    for (float square = 1e-9f; square <= 1e30f; square = floats_on(square, square > 1e3f ? 5003 : 503)) {
        float ratio = tanh_ratio(square);
        if (ratio > before) {
            keep_worst((double)ratio / (double)before - 1.0);
        }
        before = ratio;
    }
    check("tanh_ratio rises by", ROUNDING);
    TEST_ASSERT_TRUE(before > 0.0f);
}

static void test_ratio_is_one_at_zero_and_never_exceeds_it(void)
{
    TEST_ASSERT_TRUE(tanh_ratio(0.0f) == 1.0f);
    TEST_ASSERT_TRUE(tanh_ratio(1e-20f) == 1.0f);
    TEST_ASSERT_TRUE(tanh_ratio(1e-40f) == 1.0f);
    TEST_ASSERT_TRUE(isnan(tanh_ratio(NAN)));
    for (float square = 1e-9f; square < 1e-3f; square = floats_on(square, 11)) {
        keep_worst(fmax(0.0, (double)tanh_ratio(square) - 1.0));
    }
    check("tanh_ratio beyond 1 by", 0.0);
}

static void test_value_over_the_whole_range(void)
{
    for (int32_t k = 1; k <= 2000000; k += SWEEP) {
        float x = 1e-5f * (float)k; /* up to 20 */
        keep_worst((double)tanh_value(x) / tanh((double)x) - 1.0);
    }
    for (double x = 1e-18; x < 1e30; x *= 1.01) {
        keep_worst((double)tanh_value((float)x) / tanh((double)(float)x) - 1.0);
    }
    check("tanh_value", TOLERANCE);
}

static void test_value_is_odd_and_never_beyond_one(void)
{
    int wrong = 0;
    for (int32_t k = 0; k <= 2000000; k += SWEEP) {
        float x = 1e-5f * (float)k;
        float y = tanh_value(x);
        if (y != -tanh_value(-x) || !(y >= 0.0f && y <= 1.0f)) {
            wrong++;
        }
    }
    TEST_ASSERT_EQUAL_INT(0, wrong);
}

static void test_value_edges(void)
{
    TEST_ASSERT_TRUE(tanh_value(0.0f) == 0.0f);
    TEST_ASSERT_DOUBLE_WITHIN(TOLERANCE, tanh(7.0), (double)tanh_value(7.0f));
    TEST_ASSERT_TRUE(tanh_value(7.0f) < 1.0f);
    TEST_ASSERT_TRUE(tanh_value(nextafterf(7.0f, 8.0f)) == 1.0f);
    TEST_ASSERT_TRUE(tanh_value(-nextafterf(7.0f, 8.0f)) == -1.0f);
    TEST_ASSERT_TRUE(tanh_value(FLT_MAX) == 1.0f);
    TEST_ASSERT_TRUE(tanh_value(INFINITY) == 1.0f);
    TEST_ASSERT_TRUE(tanh_value(-INFINITY) == -1.0f);
    TEST_ASSERT_TRUE(tanh_value(NAN) == 0.0f);
}
