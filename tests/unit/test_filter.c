#include "math/filter.h"
#include "tests/unit/compare.h"

static const float CUTOFF = 2000.0f;
static const float PERIOD = 1e-4f;

/* A coefficient that is wrong by 5e-7 changes the step response by at most n alpha (1-alpha)^(n-1) 5e-7 <
 * 5e-7, because n alpha e^-(n alpha) < 0.37. The sum is rounded by 2^-25 per step, and a rounding decays
 * with 1/alpha steps. */
#define TOLERANCE(alpha) (5e-7 + 3e-8 / (alpha))

static void test_step_response_is_the_exact_exponential(void)
{
    static const float cutoffs[] = {20.0f, 600.0f, 2000.0f, 20000.0f};
    for (unsigned c = 0; c < sizeof cutoffs / sizeof cutoffs[0]; c++) {
        const float share = lowpass_share(cutoffs[c], PERIOD);
        float value = 0.0f;
        double decay = (double)cutoffs[c] * (double)PERIOD;
        for (int n = 1; n <= 200; n++) {
            value = lowpass_step(value, share, 1.0f);
            TEST_ASSERT_DOUBLE_WITHIN(TOLERANCE(1.0 - exp(-decay)), 1.0 - exp(-decay * n), (double)value);
        }
    }
}

/* The expected value is 3 + (1 - exp(-0.01)) (4 - 3). */
static void test_step_goes_on_from_any_output_and_stays_at_its_input(void)
{
    const float share = lowpass_share(100.0f, PERIOD);
    TEST_ASSERT_DOUBLE_WITHIN(5e-7, 3.0 - expm1(-0.01), (double)lowpass_step(3.0f, share, 4.0f));
    TEST_ASSERT_TRUE(lowpass_step(-7.25f, lowpass_share(CUTOFF, PERIOD), -7.25f) == -7.25f);
    TEST_ASSERT_TRUE(lowpass_step(0.0f, lowpass_share(CUTOFF, PERIOD), 0.0f) == 0.0f);
}

static void test_cutoff_zero_holds_and_a_huge_one_passes(void)
{
    TEST_ASSERT_TRUE(lowpass_step(2.0f, lowpass_share(0.0f, PERIOD), 100.0f) == 2.0f);
    TEST_ASSERT_TRUE(lowpass_step(2.0f, lowpass_share(1e7f, PERIOD), 100.0f) == 100.0f);
}
