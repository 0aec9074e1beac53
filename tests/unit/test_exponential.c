/* The results are compared with exp() and expm1() in double precision. The 5e-7 of the header consist of
 * the minimax error (1.1e-7), the rounding of the reduced argument (2^-25), and that of the polynomial and
 * of its sum with 1 (2^-24 each). */
#include "math/exponential.h"
#include "tests/unit/worst.h"

#define TOLERANCE 5e-7

static void test_exponential_over_the_whole_range(void)
{
    for (int32_t k = 0; k <= 4000000; k += SWEEP) {
        float x = -2e-5f * (float)k;
        if (x >= -80.0f) {
            keep_worst((double)exponential(x) / exp((double)x) - 1.0);
        }
    }
    check("relative", TOLERANCE);
}

static void test_exponential_edges(void)
{
    TEST_ASSERT_TRUE(exponential(0.0f) == 1.0f);
    TEST_ASSERT_TRUE(exponential(-0.0f) == 1.0f);
    TEST_ASSERT_TRUE(exponential(1e-10f) == 1.0f);
    TEST_ASSERT_TRUE(exponential(INFINITY) == 1.0f);
    TEST_ASSERT_DOUBLE_WITHIN(TOLERANCE, 1.0, (double)exponential(-80.0f) / exp(-80.0));
    TEST_ASSERT_TRUE(exponential(nextafterf(-80.0f, -100.0f)) == 0.0f);
    TEST_ASSERT_TRUE(exponential(-INFINITY) == 0.0f);
    TEST_ASSERT_TRUE(exponential(NAN) == 0.0f);
}

static void test_rest_is_accurate_however_small(void)
{
    for (double x = 1e-30; x < 80.0; x *= 1.0 + 1e-4 * SWEEP) {
        float argument = (float)x;
        keep_worst((double)exponential_rest(argument) / -expm1(-(double)argument) - 1.0);
    }
    check("relative", TOLERANCE);
}

static void test_rest_edges(void)
{
    TEST_ASSERT_TRUE(exponential_rest(0.0f) == 0.0f);
    TEST_ASSERT_TRUE(exponential_rest(-1.0f) == 0.0f);
    TEST_ASSERT_TRUE(exponential_rest(NAN) == 0.0f);
    TEST_ASSERT_TRUE(exponential_rest(80.0f) == 1.0f);
    TEST_ASSERT_TRUE(exponential_rest(81.0f) == 1.0f);
    TEST_ASSERT_TRUE(exponential_rest(INFINITY) == 1.0f);
}
