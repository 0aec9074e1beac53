#include "math/pi.h"
#include "tests/unit/compare.h"

static const float PERIOD = 1e-4f;

static void begin(pi_t *pi, float kp, float ki)
{
    const pi_tuning_t tuning = pi_prepare(kp, ki, PERIOD);
    pi_init(pi, &tuning);
}

static double draw(double least, double most)
{
    static uint32_t seed = 1u;
    seed = seed * UINT32_C(1664525) + UINT32_C(1013904223);
    return least + (most - least) * (double)(seed >> 8) / 16777216.0;
}

/* The law is y = kp e + I. The output is limited by the controller or by a later stage, and the missing
 * part is taken from the integral with ki T/kp: I' = I + ki T e + (ki T/kp) (limited y - y). Numbers up to
 * 100 are rounded by 4e-6 three times per step. */
static void test_runs_as_its_law_in_double_precision(void)
{
    for (int n = 0; n < 100; n++) {
        const double kp = draw(0.5, 10.0), ki = draw(1.0, 2000.0);
        double integral = draw(-5.0, 5.0);
        int cut = 0;
        pi_t pi;
        begin(&pi, (float)kp, (float)ki);
        pi_reset(&pi, (float)integral);
        for (int k = 0; k < 200; k++) {
            const double error = draw(-5.0, 5.0), least = draw(-30.0, 1.0), most = least + draw(0.0, 40.0);
            const double wanted = kp * error + integral;
            const double made = fmax(least, fmin(most, wanted));
            float output = 0.0f;
            if (k % 2 == 0) {
                output = pi_step(&pi, (float)error, (float)least, (float)most);
            } else {
                const float asked = pi_output(&pi, (float)error);
                output = (float)made;
                pi_update(&pi, (float)error, output - asked);
            }
            integral += ki * 1e-4 * error + ki * 1e-4 / kp * (made - wanted);
            cut += made < wanted || made > wanted ? 1 : 0;
            TEST_ASSERT_DOUBLE_WITHIN(3e-3, made, (double)output);
            TEST_ASSERT_DOUBLE_WITHIN(3e-3, integral, (double)pi.integral);
        }
        TEST_ASSERT_TRUE(cut > 20 && cut < 180);
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
    /* The products ki T/kp are 0.99, 1 and 3. */
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
