/* Against tanh() and sqrt() in double precision. The header's 1e-6 holds the rational's error (1.6e-7) or
 * what tanh(8) lacks to 1 (2.3e-7) and about ten roundings of 2^-24 (6e-7). */
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <unity.h>

#include "math/tanh.h"

#define TOLERANCE 1e-6

static double worst;

static void keep_worst(double error)
{
    if (!(fabs(error) <= worst)) {
        worst = fabs(error);
    }
}

void setUp(void)
{
    worst = 0.0;
}

void tearDown(void)
{
}

static void test_value_over_the_whole_range(void)
{
    for (int k = 1; k <= 2000000; k++) {
        float x = 1e-5f * (float)k; /* to 20 */
        keep_worst((double)tanh_value(x) / tanh((double)x) - 1.0);
    }
    for (double x = 1e-18; x < 1e30; x *= 1.01) {
        keep_worst((double)tanh_value((float)x) / tanh((double)(float)x) - 1.0);
    }
    printf("tanh_value: %.2e\n", worst);
    TEST_ASSERT_DOUBLE_WITHIN(TOLERANCE, 0.0, worst);
}

static void test_value_is_odd_and_never_beyond_one(void)
{
    for (int k = 0; k <= 200000; k++) {
        float x = 1e-4f * (float)k;
        float y = tanh_value(x);
        TEST_ASSERT_TRUE(y == -tanh_value(-x));
        TEST_ASSERT_TRUE(y >= 0.0f && y <= 1.0f);
    }
}

static void test_value_edges(void)
{
    TEST_ASSERT_TRUE(tanh_value(0.0f) == 0.0f);
    TEST_ASSERT_DOUBLE_WITHIN(TOLERANCE, tanh(8.0), (double)tanh_value(8.0f));
    TEST_ASSERT_TRUE(tanh_value(nextafterf(8.0f, 9.0f)) == 1.0f);
    TEST_ASSERT_TRUE(tanh_value(FLT_MAX) == 1.0f);
    TEST_ASSERT_TRUE(tanh_value(INFINITY) == 1.0f);
    TEST_ASSERT_TRUE(tanh_value(-INFINITY) == -1.0f);
    TEST_ASSERT_TRUE(tanh_value(NAN) == 0.0f);
}

static void test_ratio_over_the_whole_range(void)
{
    for (double z = 1e-35; z < 1e30; z *= 1.0001) {
        double x = sqrt((double)(float)z);
        keep_worst((double)tanh_ratio((float)z) * x / tanh(x) - 1.0);
    }
    printf("tanh_ratio: %.2e\n", worst);
    TEST_ASSERT_DOUBLE_WITHIN(TOLERANCE, 0.0, worst);
}

static void test_ratio_edges(void)
{
    TEST_ASSERT_TRUE(tanh_ratio(0.0f) == 1.0f);
    TEST_ASSERT_TRUE(tanh_ratio(-1.0f) == 1.0f);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, tanh(8.0) / 8.0 * 8.0, (double)tanh_ratio(64.0f) * 8.0);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 1.0, (double)tanh_ratio(nextafterf(64.0f, 65.0f)) * 8.0);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 1.0, (double)tanh_ratio(INFINITY) * 1e15);
}

/* Two Newton steps leave 1e-8, three roundings in the last of them and one by the scale (exact) below 3e-7.
 */
static void test_inverse_root_over_the_whole_range(void)
{
    for (double z = 1e-30; z < 1e30; z *= 1.00003) {
        keep_worst((double)inverse_root((float)z) * sqrt((double)(float)z) - 1.0);
    }
    printf("inverse_root: %.2e\n", worst);
    TEST_ASSERT_DOUBLE_WITHIN(3e-7, 0.0, worst);
}

static void test_inverse_root_edges(void)
{
    TEST_ASSERT_DOUBLE_WITHIN(3e-7, 1.0, (double)inverse_root(1.0f));
    TEST_ASSERT_DOUBLE_WITHIN(3e-7, 0.5, (double)inverse_root(4.0f));
    TEST_ASSERT_DOUBLE_WITHIN(3e-7, 1.0, (double)inverse_root(INFINITY) * 1e15);
    TEST_ASSERT_DOUBLE_WITHIN(3e-7, 1.0, (double)inverse_root(FLT_MAX) * 1e15);
    TEST_ASSERT_DOUBLE_WITHIN(3e-7, 1.0, (double)inverse_root(0.0f) * 1e-15);
    TEST_ASSERT_DOUBLE_WITHIN(3e-7, 1.0, (double)inverse_root(-1.0f) * 1e-15);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_value_over_the_whole_range);
    RUN_TEST(test_value_is_odd_and_never_beyond_one);
    RUN_TEST(test_value_edges);
    RUN_TEST(test_ratio_over_the_whole_range);
    RUN_TEST(test_ratio_edges);
    RUN_TEST(test_inverse_root_over_the_whole_range);
    RUN_TEST(test_inverse_root_edges);
    return UNITY_END();
}
