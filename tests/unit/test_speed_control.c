#include <math.h>
#include <string.h>
#include <unity.h>

#include "control/speed_control.h"

/* The paper's gains and limit, section 2. */
static const speed_control_params_t PARAMS = {
    .kp = 0.5f, .ki = 2.5f, .current_limit = 10.0f, .period = 1e-4f};

void setUp(void)
{
}

void tearDown(void)
{
}

static void begin(speed_control_t *control)
{
    const speed_control_tuning_t tuning = speed_control_prepare(&PARAMS);
    speed_control_init(control, &tuning);
}

static void take(speed_control_t *control, const speed_control_params_t *params)
{
    const speed_control_tuning_t tuning = speed_control_prepare(params);
    speed_control_take(control, &tuning);
}

static void test_first_output_is_proportional(void)
{
    speed_control_t control;
    memset(&control, 0x55, sizeof control);
    begin(&control);
    TEST_ASSERT_TRUE(speed_control_step(&control, 10.0f, 4.0f) == 3.0f);
    begin(&control);
    TEST_ASSERT_TRUE(speed_control_step(&control, -10.0f, -4.0f) == -3.0f);
}

static void test_output_below_at_above_the_limit(void)
{
    static const float errors[] = {19.98f, 20.0f, 20.02f, 1e6f};
    static const float outputs[] = {9.99f, 10.0f, 10.0f, 10.0f};
    for (unsigned k = 0; k < sizeof errors / sizeof errors[0]; k++) {
        speed_control_t control;
        begin(&control);
        TEST_ASSERT_TRUE(speed_control_step(&control, errors[k], 0.0f) == outputs[k]);
        begin(&control);
        TEST_ASSERT_TRUE(speed_control_step(&control, 0.0f, errors[k]) == -outputs[k]);
    }
}

static void test_reset_is_bumpless(void)
{
    static const float currents[] = {0.0f, 4.55f, -9.9f};
    for (unsigned k = 0; k < sizeof currents / sizeof currents[0]; k++) {
        speed_control_t control;
        begin(&control);
        speed_control_reset(&control, currents[k]);
        TEST_ASSERT_TRUE(speed_control_step(&control, 157.0f, 157.0f) == currents[k]);
        TEST_ASSERT_TRUE(speed_control_step(&control, 157.0f, 157.0f) == currents[k]);
    }
}

static void test_reset_beyond_the_limit_is_cut(void)
{
    speed_control_t control;
    begin(&control);
    speed_control_reset(&control, 25.0f);
    TEST_ASSERT_TRUE(speed_control_step(&control, 1.0f, 1.0f) == 10.0f);
    speed_control_reset(&control, -25.0f);
    TEST_ASSERT_TRUE(speed_control_step(&control, 1.0f, 1.0f) == -10.0f);
}

static void test_integral_follows_the_limit_while_it_holds(void)
{
    speed_control_t control;
    begin(&control);
    /* I = limit (1 - (1 - ki T/kp)^n) whatever the error: a time constant kp/ki = 0.2 s. kp e = 70 A rounds
     * by 4e-6 in the shortfall, remembered for 2000 steps of weight 1/2000; the sum itself rounds by 5e-7 for
     * as many. */
    for (int n = 1; n <= 10000; n++) {
        TEST_ASSERT_TRUE(speed_control_step(&control, 157.0f, 17.0f) == 10.0f);
        TEST_ASSERT_DOUBLE_WITHIN(1.1e-3, 10.0 * (1.0 - pow(1.0 - 5e-4, n)), (double)control.pi.integral);
    }
    /* The braking begins as soon as the speed is beyond the reference. */
    TEST_ASSERT_TRUE(speed_control_step(&control, 157.0f, 157.5f) < 10.0f);
}

static void test_new_coefficients_lower_the_limit_and_keep_the_integral(void)
{
    speed_control_t control;
    begin(&control);
    speed_control_reset(&control, 6.0f);
    speed_control_params_t params = PARAMS;
    params.kp = 1.0f;
    take(&control, &params);
    TEST_ASSERT_TRUE(speed_control_step(&control, 1.0f, 0.0f) == 7.0f);
    params.current_limit = 4.0f;
    take(&control, &params);
    TEST_ASSERT_TRUE(speed_control_step(&control, 1.0f, 0.0f) == 4.0f);
}

static void test_closed_loop_is_the_second_order_system_of_the_gains(void)
{
    /* The rig of docs/theory.md, 19: K_t = 1.5 * 4 * 0.183 N m/A, J = 0.0636 kg m^2, ideal current. With m =
     * K_t/J the error after a unit step is the solution of e'' + kp m e' + ki m e = 0, e(0) = 1, e'(0) = -kp
     * m. */
    double per_ampere = 1.5 * 4.0 * 0.183 / 0.0636;
    double sigma = 0.5 * 0.5 * per_ampere;
    double wd = sqrt(2.5 * per_ampere - sigma * sigma);
    speed_control_t control;
    begin(&control);
    double omega = 50.0;
    for (int k = 0; k < 15000; k++) {
        double time = k * 1e-4;
        double error = exp(-sigma * time) * (cos(wd * time) - sigma / wd * sin(wd * time));
        /* The held output is half a period late and the integral another half: 1e-4 s times the largest slope
         * kp m = 8.6, and the shift of the damping by wn^2 T/2 over its 0.2 s. The speed of 51 rounds by 2e-6
         * in the error. */
        TEST_ASSERT_DOUBLE_WITHIN(2e-3, error, 51.0 - omega);
        omega += 1e-4 * per_ampere * (double)speed_control_step(&control, 51.0f, (float)omega);
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_first_output_is_proportional);
    RUN_TEST(test_output_below_at_above_the_limit);
    RUN_TEST(test_reset_is_bumpless);
    RUN_TEST(test_reset_beyond_the_limit_is_cut);
    RUN_TEST(test_integral_follows_the_limit_while_it_holds);
    RUN_TEST(test_new_coefficients_lower_the_limit_and_keep_the_integral);
    RUN_TEST(test_closed_loop_is_the_second_order_system_of_the_gains);
    return UNITY_END();
}
