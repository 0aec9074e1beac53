/* The conditions of a hand-over, each alone, and the time for which they must hold. */
#include "medium/manoeuvre/handover.h"
#include "tests/unit/compare.h"

#define T       1e-4f
#define CURRENT 10.0f  /* [A] I of a start */
#define HELD    1500u  /* [periods] 0.15 s */
#define LONGEST 10000u /* [periods] 1 s, after which the start counts as failed */
#define OMEGA   60.0f  /* [rad/s] speed of the forced frame */

static handover_t handover;

/* The state in a period; `way` reverses all signs. */
static float omega_smooth;
static lock_t lock;
static float omega_forced;
static dq_t current;
static float needed;

/* All conditions hold. */
static void make_good(float way)
{
    memset(&lock, 0, sizeof lock);
    omega_forced = way * OMEGA;
    omega_smooth = way * OMEGA;
    lock.expected = 11.0f;
    lock.projection = 11.0f;
    lock.scatter = 0.0f;
    current = (dq_t){1.0f, way * 3.0f};
    needed = 3.0f;
}

void setUp(void)
{
    const handover_params_t params = {CURRENT, false, T};
    const handover_tuning_t tuning = handover_prepare(&params);
    memset(&handover, 0x55, sizeof handover);
    handover_init(&handover, &tuning);
    make_good(1.0f);
}

static bool step(void)
{
    const handover_input_t input = {omega_smooth, omega_forced, current, needed};
    return handover_step(&handover, &input, &lock);
}

/* The number of periods until the hand-over is good, at most LONGEST. */
static uint32_t periods_until_good(void)
{
    uint32_t periods = 1u;
    handover_enter(&handover, current);
    while (!step() && periods < LONGEST) {
        periods++;
    }
    return periods;
}

static void expect_good(void)
{
    TEST_ASSERT_EQUAL_UINT32(HELD, periods_until_good());
}

static void expect_failed(void)
{
    TEST_ASSERT_EQUAL_UINT32(LONGEST, periods_until_good());
}

static void test_good_after_a_sixth_of_a_second_in_either_direction(void)
{
    expect_good();
    make_good(-1.0f);
    expect_good();
}

/* Each condition is just met and just not met, forwards and backwards. The angle between loop and frame may
 * change by pi/2 in 0.15 s: a difference of 10.47 rad/s, 0.1745 of 60 rad/s. A current of 1.6 x 3 A + 0.15 x
 * 10 A = 6.3 A of either sign is accepted. A psi_f that is configured 30 % wrong makes 1/1.3 or 1/0.7 of the
 * expected EMF, with exact voltages. */
static void test_one_condition_prevents_it(void)
{
    static const struct {
        float speed, projection, scatter, i_d; /* [-] shares of the expected values; [-]; [A] */
        bool good;
    } cases[] = {{0.82f, 1.0f, 0.0f, 1.0f, false}, {0.83f, 1.0f, 0.0f, 1.0f, true},
                 {1.17f, 1.0f, 0.0f, 1.0f, true},  {1.18f, 1.0f, 0.0f, 1.0f, false},
                 {-1.0f, 1.0f, 0.0f, 1.0f, false}, {1.0f, -1.0f, 0.0f, 1.0f, false},
                 {1.0f, 0.64f, 0.0f, 1.0f, false}, {1.0f, 0.66f, 0.0f, 1.0f, true},
                 {1.0f, 1.69f, 0.0f, 1.0f, true},  {1.0f, 0.769f, 0.0f, 1.0f, true},
                 {1.0f, 1.429f, 0.0f, 1.0f, true}, {1.0f, 1.71f, 0.0f, 1.0f, false},
                 {1.0f, 1.0f, 0.049f, 1.0f, true}, {1.0f, 1.0f, 0.051f, 1.0f, false},
                 {1.0f, 1.0f, 0.0f, 6.29f, true},  {1.0f, 1.0f, 0.0f, 6.31f, false},
                 {1.0f, 1.0f, 0.0f, -6.29f, true}, {1.0f, 1.0f, 0.0f, -6.31f, false}};
    for (size_t n = 0; n < 2u * sizeof cases / sizeof cases[0]; n++) {
        make_good(n % 2u == 0u ? 1.0f : -1.0f);
        omega_smooth = cases[n / 2u].speed * omega_forced;
        lock.projection = cases[n / 2u].projection * lock.expected;
        lock.scatter = cases[n / 2u].scatter;
        current.d = cases[n / 2u].i_d;
        cases[n / 2u].good ? expect_good() : expect_failed();
    }
}

/* A load that changes with the angle swings the speed by 0.6 of the frame's, at 60 rad/s: the angle swings by
 * 0.6 rad, and i_q between nothing and twice its mean. The rotor is in step, and the hand-over is good. */
static void test_a_rotor_that_swings_in_step_is_handed_over(void)
{
    for (int way = -1; way <= 1; way += 2) {
        make_good((float)way);
        handover_enter(&handover, current);
        for (uint32_t n = 1u; n <= HELD; n++) {
            const float swing = (float)sin(60.0 * (double)T * n);
            omega_smooth = (float)way * OMEGA * (1.0f + 0.6f * swing);
            current = (dq_t){5.0f, (float)way * (3.0f + 3.0f * swing)};
            TEST_ASSERT_EQUAL(n == HELD, step());
        }
    }
}

/* The noise of a fast loop changes the speed by 0.9 of a slow frame's from period to period. */
static void test_noise_of_the_speed_does_not_prevent_it(void)
{
    handover_enter(&handover, current);
    for (uint32_t n = 1u; n <= HELD; n++) {
        omega_smooth = (n % 2u == 0u ? 0.1f : 1.9f) * omega_forced;
        TEST_ASSERT_EQUAL(n == HELD, step());
    }
}

/* At 8 rad/s a loop that stands slips by 1.2 rad in 0.15 s, less than a quarter turn; 0.7 of the frame's
 * angle are 0.84 rad. */
static void test_a_loop_that_stands_beside_a_slow_frame_is_not_handed_over(void)
{
    omega_forced = 8.0f;
    omega_smooth = 0.0f;
    expect_failed();
    omega_smooth = 0.31f * omega_forced;
    expect_good();
    omega_smooth = 0.29f * omega_forced;
    expect_failed();
}

/* A rotor out of step slips by half a turn in 0.25 s. */
static void test_a_rotor_that_slips_is_not_handed_over(void)
{
    omega_smooth = omega_forced - 12.6f;
    expect_failed();
}

static void test_an_interruption_restarts_the_time(void)
{
    for (uint32_t n = 1u; n < HELD; n++) {
        TEST_ASSERT_FALSE(step());
    }
    lock.scatter = 1.0f;
    TEST_ASSERT_FALSE(step());
    lock.scatter = 0.0f;
    for (uint32_t n = 1u; n < HELD; n++) {
        TEST_ASSERT_FALSE(step());
    }
    TEST_ASSERT_TRUE(step());
}

/* A leg whose current passes zero takes 0.25 A from i_q for 2 ms. At 70 rad/s 0.13 of this is in the mean
 * that is handed over; meanwhile i_d may exceed its limit. */
static void test_what_is_handed_over_is_the_mean_of_the_current(void)
{
    const dq_t before = current;
    handover_enter(&handover, current);
    for (uint32_t n = 1u; n < HELD; n++) {
        const bool passes = n + 20u >= HELD;
        current = (dq_t){passes ? 7.0f : before.d, passes ? before.q - 0.25f : before.q};
        TEST_ASSERT_FALSE(step());
    }
    TEST_ASSERT_TRUE(step());
    const double share = 1.0 - exp(-70.0 * (double)T);
    const double left = 1.0 - pow(1.0 - share, 21.0);
    TEST_ASSERT_DOUBLE_WITHIN(1e-4, (double)before.q - 0.25 * left, (double)handover.mean.q);
    TEST_ASSERT_DOUBLE_WITHIN(1e-4, (double)before.d + (7.0 - (double)before.d) * left,
                              (double)handover.mean.d);
}

/* The current approaches 1.3 |i_q| plus a tenth of I, at 10 rad/s. */
static void test_current_goes_to_what_the_load_needs(void)
{
    static const double needs[] = {0.0, 3.0, -3.0, 6.5};
    for (int n = 0; n < 4; n++) {
        const double target = 1.3 * fabs(needs[n]) + 1.0;
        float now = CURRENT;
        for (int k = 1; k <= 5000; k++) {
            now = handover_current(&handover, now, CURRENT, (float)needs[n]);
            const double expected = target + ((double)CURRENT - target) * exp(-10.0 * 1e-4 * k);
            TEST_ASSERT_DOUBLE_WITHIN(2e-3, expected, (double)now);
        }
    }
}
