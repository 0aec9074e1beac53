#include <math.h>
#include <string.h>
#include <unity.h>

#include "control/speed_control.h"

/* The paper's gains and limit, section 2. */
static const speed_control_params_t PARAMS = {
    .kp = 0.5f, .ki = 2.5f, .weight = 1.0f, .current_limit = 10.0f, .period = 1e-4f};

static void begin_with(speed_control_t *control, const speed_control_params_t *params)
{
    const speed_control_tuning_t tuning = speed_control_prepare(params);
    speed_control_init(control, &tuning);
}

static void begin(speed_control_t *control)
{
    begin_with(control, &PARAMS);
}

/* The paper's gains with another share of the reference in the proportional part. */
static void begin_weighed(speed_control_t *control, float weight)
{
    speed_control_params_t params = PARAMS;
    params.weight = weight;
    begin_with(control, &params);
}

static void take(speed_control_t *control, const speed_control_params_t *params)
{
    const speed_control_tuning_t tuning = speed_control_prepare(params);
    speed_control_take(control, &tuning, 0.0f);
}

/* With all of the limit. */
static float step(speed_control_t *control, float omega_m_ref, float omega_m)
{
    return speed_control_step(control, omega_m_ref, omega_m, -control->current_limit, control->current_limit);
}

static void test_first_output_is_proportional(void)
{
    speed_control_t control;
    memset(&control, 0x55, sizeof control);
    begin(&control);
    TEST_ASSERT_TRUE(step(&control, 10.0f, 4.0f) == 3.0f);
    begin(&control);
    TEST_ASSERT_TRUE(step(&control, -10.0f, -4.0f) == -3.0f);
}

static void test_output_below_at_above_the_limit(void)
{
    static const float errors[] = {19.98f, 20.0f, 20.02f, 1e6f};
    static const float outputs[] = {9.99f, 10.0f, 10.0f, 10.0f};
    for (unsigned k = 0; k < sizeof errors / sizeof errors[0]; k++) {
        speed_control_t control;
        begin(&control);
        TEST_ASSERT_TRUE(step(&control, errors[k], 0.0f) == outputs[k]);
        begin(&control);
        TEST_ASSERT_TRUE(step(&control, 0.0f, errors[k]) == -outputs[k]);
    }
}

static void test_reset_is_bumpless(void)
{
    static const float currents[] = {0.0f, 4.55f, -9.9f};
    for (unsigned k = 0; k < sizeof currents / sizeof currents[0]; k++) {
        speed_control_t control;
        begin(&control);
        speed_control_reset(&control, currents[k], 157.0f);
        TEST_ASSERT_TRUE(step(&control, 157.0f, 157.0f) == currents[k]);
        TEST_ASSERT_TRUE(step(&control, 157.0f, 157.0f) == currents[k]);
    }
}

static void test_reset_beyond_the_limit_is_cut(void)
{
    speed_control_t control;
    begin(&control);
    speed_control_reset(&control, 25.0f, 1.0f);
    TEST_ASSERT_TRUE(step(&control, 1.0f, 1.0f) == 10.0f);
    speed_control_reset(&control, -25.0f, 1.0f);
    TEST_ASSERT_TRUE(step(&control, 1.0f, 1.0f) == -10.0f);
}

static void test_integral_follows_the_limit_while_it_holds(void)
{
    speed_control_t control;
    begin(&control);
    /* I = limit (1 - (1 - ki T/kp)^n) whatever the error: a time constant kp/ki = 0.2 s. kp e = 70 A rounds
     * by 4e-6 in the shortfall, remembered for 2000 steps of weight 1/2000; the sum itself rounds by 5e-7 for
     * as many. */
    for (int n = 1; n <= 10000; n++) {
        TEST_ASSERT_TRUE(step(&control, 157.0f, 17.0f) == 10.0f);
        TEST_ASSERT_DOUBLE_WITHIN(1.1e-3, 10.0 * (1.0 - pow(1.0 - 5e-4, n)), (double)control.pi.integral);
    }
    /* The braking begins as soon as the speed is beyond the reference. */
    TEST_ASSERT_TRUE(step(&control, 157.0f, 157.5f) < 10.0f);
}

static void test_new_coefficients_lower_the_limit_and_keep_the_integral(void)
{
    speed_control_t control;
    begin(&control);
    speed_control_reset(&control, 6.0f, 0.0f);
    speed_control_params_t params = PARAMS;
    params.kp = 1.0f;
    take(&control, &params);
    TEST_ASSERT_TRUE(step(&control, 1.0f, 0.0f) == 7.0f);
    params.current_limit = 4.0f;
    take(&control, &params);
    TEST_ASSERT_TRUE(step(&control, 1.0f, 0.0f) == 4.0f);
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
        omega += 1e-4 * per_ampere * (double)step(&control, 51.0f, (float)omega);
    }
}

/* kp (b ref - omega): 0.5 (b 10 - 4). */
static void test_weight_is_the_references_share_of_the_proportional_part(void)
{
    static const float weights[] = {0.0f, 0.25f, 0.5f, 1.0f};
    for (unsigned k = 0; k < sizeof weights / sizeof weights[0]; k++) {
        speed_control_t control;
        begin_weighed(&control, weights[k]);
        TEST_ASSERT_FLOAT_WITHIN(1e-6f, 0.5f * (weights[k] * 10.0f - 4.0f), step(&control, 10.0f, 4.0f));
        begin_weighed(&control, weights[k]); /* a load is answered alike */
        (void)step(&control, 0.0f, 0.0f);
        TEST_ASSERT_FLOAT_WITHIN(1e-6f, -2.0f, step(&control, 0.0f, 4.0f));
    }
}

/* Beside its reference the output stays, whatever the gain and the weight become; sums of 157 round by 2e-5.
 */
static void test_new_gains_are_bumpless_at_the_reference(void)
{
    for (unsigned k = 0; k < 8; k++) {
        speed_control_t control;
        begin_weighed(&control, k & 1u ? 1.0f : 0.0f);
        speed_control_reset(&control, 4.55f, -157.0f);
        speed_control_params_t params = PARAMS;
        params.kp = k & 2u ? 1.0f : 0.25f;
        params.weight = k & 4u ? 1.0f : 0.0f;
        const speed_control_tuning_t tuning = speed_control_prepare(&params);
        speed_control_take(&control, &tuning, -157.0f);
        TEST_ASSERT_FLOAT_WITHIN(4e-5f, 4.55f, step(&control, -157.0f, -157.0f));
    }
}

/* Whatever the weight; sums of 78 round by 8e-6. */
static void test_reset_is_bumpless_with_every_weight(void)
{
    static const float weights[] = {0.0f, 0.3f, 1.0f};
    for (unsigned k = 0; k < sizeof weights / sizeof weights[0]; k++) {
        speed_control_t control;
        begin_weighed(&control, weights[k]);
        speed_control_reset(&control, 4.55f, -157.0f);
        for (int n = 0; n < 100; n++) {
            TEST_ASSERT_FLOAT_WITHIN(2e-5f, 4.55f, step(&control, -157.0f, -157.0f));
        }
    }
}

/* Without a proportional reference the integral holds, however long, what it gains in 10 ms above the
 * limit: 2.5 x 137 x 10 ms = 3.425 A. Speeds that ask for less take that off first: 10 rad/s are 5 A. */
static void test_without_weight_the_limit_leaves_nothing_to_unwind(void)
{
    speed_control_t control;
    begin_weighed(&control, 0.0f);
    for (int n = 0; n < 5000; n++) {
        (void)step(&control, 157.0f, 20.0f);
    }
    TEST_ASSERT_FLOAT_WITHIN(1e-5f, 10.0f, step(&control, 157.0f, 20.0f));
    TEST_ASSERT_FLOAT_WITHIN(1e-3f, 10.0f + 3.425f - 5.0f, step(&control, 157.0f, 30.0f));
}

/* Damping above 0.5, as kp^2 K_t/J = 3 ki makes it (0.866): without weight a step of the reference,
 * unlimited, is passed by no more than exp(-pi zeta/sqrt(1 - zeta^2)) = 0.43 %, and the speed is the solution
 * of w'' + kp m w' + ki m w = ki m r from rest; with weight 1 it runs past by several times that. */
static void test_without_weight_a_step_hardly_passes_the_reference(void)
{
    const double per_ampere = 1.5 * 4.0 * 0.183 / 0.0636;
    speed_control_params_t params = PARAMS;
    params.ki = (float)(0.25 * per_ampere / 3.0);
    const double sigma = 0.5 * 0.5 * per_ampere;
    const double wd = sqrt((double)params.ki * per_ampere - sigma * sigma);
    double passed[2];
    for (int weighed = 0; weighed < 2; weighed++) {
        speed_control_t control;
        params.weight = (float)weighed;
        begin_with(&control, &params);
        double omega = 0.0;
        passed[weighed] = 0.0;
        for (int k = 0; k < 16000; k++) {
            const double time = k * 1e-4;
            const double way = 1.0 - exp(-sigma * time) * (cos(wd * time) + sigma / wd * sin(wd * time));
            if (weighed == 0) { /* a period late at its largest slope, about wn/2 = 2.5 1/s */
                TEST_ASSERT_DOUBLE_WITHIN(1e-3, way, omega);
            }
            passed[weighed] = fmax(passed[weighed], omega - 1.0);
            omega += 1e-4 * per_ampere * (double)step(&control, 1.0f, (float)omega);
        }
    }
    TEST_ASSERT_DOUBLE_WITHIN(1e-4, 4.33e-3, passed[0]);
    TEST_ASSERT_TRUE(passed[1] > 0.1);
}
