#include <math.h>
#include <stdint.h>
#include <unity.h>

#include "math/pi.h"

static const float PERIOD = 1e-4f;

static void begin(pi_t *pi, float kp, float ki)
{
    const pi_tuning_t tuning = pi_prepare(kp, ki, PERIOD);
    pi_init(pi, &tuning);
}

static void test_first_output_is_proportional_only(void)
{
    pi_t pi;
    begin(&pi, 12.5f, 950.0f);
    TEST_ASSERT_TRUE(pi_output(&pi, 2.0f) == 25.0f);
}

static void test_constant_error_integrates_with_ki(void)
{
    pi_t pi;
    begin(&pi, 0.5f, 2.5f);
    for (int n = 0; n < 1000; n++) {
        pi_update(&pi, 4.0f, 0.0f);
    }
    /* 1000 periods of 0.1 ms, error 4, ki 2.5: 1. A thousand sums below 1 round by 2^-25 each. */
    TEST_ASSERT_DOUBLE_WITHIN(3.1e-5, 1.0, (double)pi.integral);
    TEST_ASSERT_DOUBLE_WITHIN(3.1e-5, 1.0 + 0.5 * 3.0, (double)pi_output(&pi, 3.0f));
}

static void test_back_calculation_integrates_the_error_that_would_have_fitted(void)
{
    pi_t pi;
    begin(&pi, 2.0f, 300.0f);
    pi_reset(&pi, 5.0f);
    /* Wanted 2*10 + 5 = 25, applied 9: the error 2 would have given 9 (2*2 + 5), so the integral gets ki T 2
     * = 0.06. */
    float wanted = pi_output(&pi, 10.0f);
    pi_update(&pi, 10.0f, 9.0f - wanted);
    TEST_ASSERT_DOUBLE_WITHIN(2e-6, 5.06, (double)pi.integral);
}

static void test_clamp_cuts_both_ways_and_says_so_to_the_integral(void)
{
    pi_t up;
    pi_t down;
    begin(&up, 2.0f, 300.0f);
    begin(&down, 2.0f, 300.0f);
    TEST_ASSERT_TRUE(pi_step(&up, 100.0f, -10.0f, 10.0f) == 10.0f);
    TEST_ASSERT_TRUE(pi_step(&down, -100.0f, -10.0f, 10.0f) == -10.0f);
    /* ki T e' with e' = 10/2. */
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 0.15, (double)up.integral);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, -0.15, (double)down.integral);
}

static void test_clamp_below_at_above_the_limit(void)
{
    float outputs[3];
    float integrals[3];
    for (int k = 0; k < 3; k++) {
        pi_t pi;
        begin(&pi, 2.0f, 300.0f);
        outputs[k] = pi_step(&pi, 4.5f + 0.5f * (float)k, -10.0f, 10.0f);
        integrals[k] = pi.integral;
    }
    TEST_ASSERT_TRUE(outputs[0] == 9.0f);
    TEST_ASSERT_TRUE(outputs[1] == 10.0f);
    TEST_ASSERT_TRUE(outputs[2] == 10.0f);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 0.135, (double)integrals[0]);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 0.150, (double)integrals[1]);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 0.150, (double)integrals[2]);
}

static void test_integral_settles_at_the_limit_while_saturated(void)
{
    pi_t pi;
    begin(&pi, 2.0f, 300.0f);
    /* I(n) = limit (1 - (1 - g)^n), g = ki T/kp = 0.015, whatever the error. */
    for (int n = 1; n <= 1000; n++) {
        float output = pi_step(&pi, 500.0f + (float)n, -10.0f, 10.0f);
        TEST_ASSERT_TRUE(output == 10.0f);
        /* kp e up to 3000 rounds by 1.2e-4 in the shortfall; g of it each step, remembered for 1/g steps. */
        TEST_ASSERT_DOUBLE_WITHIN(1.3e-4, 10.0 * (1.0 - pow(1.0 - 0.015, n)), (double)pi.integral);
    }
}

static void test_no_integral_part_stays_without(void)
{
    pi_t pi;
    begin(&pi, 3.0f, 0.0f);
    for (int n = 0; n < 100; n++) {
        pi_step(&pi, 50.0f, -2.0f, 2.0f);
    }
    TEST_ASSERT_TRUE(pi.integral == 0.0f);
    begin(&pi, 0.0f, 0.0f);
    pi_reset(&pi, 50.0f);
    pi_step(&pi, 1.0f, -2.0f, 2.0f);
    TEST_ASSERT_TRUE(pi.integral == 50.0f);
}

static void test_back_calculation_gain_is_capped_at_one(void)
{
    pi_t pi;
    /* ki T/kp = 0.99, 1, 3. */
    begin(&pi, 1.0f, 9900.0f);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 0.99, (double)pi.tuning.back_gain);
    begin(&pi, 1.0f, 10000.0f);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 1.0, (double)pi.tuning.back_gain);
    begin(&pi, 1.0f, 30000.0f);
    TEST_ASSERT_TRUE(pi.tuning.back_gain == 1.0f);
}

static void test_reset_is_bumpless_and_new_coefficients_keep_the_integral(void)
{
    pi_t pi;
    begin(&pi, 2.0f, 300.0f);
    pi_reset(&pi, -3.5f);
    TEST_ASSERT_TRUE(pi_output(&pi, 0.0f) == -3.5f);
    const pi_tuning_t other = pi_prepare(4.0f, 100.0f, PERIOD);
    pi_take(&pi, &other);
    TEST_ASSERT_TRUE(pi_output(&pi, 0.0f) == -3.5f);
    TEST_ASSERT_TRUE(pi_output(&pi, 1.0f) == 0.5f);
    begin(&pi, 2.0f, 300.0f);
    TEST_ASSERT_TRUE(pi_output(&pi, 0.0f) == 0.0f);
}
