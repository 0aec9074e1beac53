/* The three signs of a lost rotor and their times. LP is a low-pass of 5 ms: n periods of 0.1 ms after a
 * step it has reached 1 - exp(-0.02 n) of it. */
#include "medium/manoeuvre/lock.h"
#include "tests/unit/compare.h"

#define T     1e-4f
#define PSI   0.183f
#define SLOW  25.0f /* [rad/s] */
#define ASKED 42.0f /* [rad/s] */
#define OMEGA 200.0f

static lock_t lock;
static estimate_t estimate;

/* The estimate on a round rotor at this speed; `along` and `across` are the EMF's shares of psi_f omega
 * along the estimated axis and across it. */
static void make_estimate(float omega_e, float along, float across)
{
    const double theta = 0.7;
    memset(&estimate, 0, sizeof estimate);
    estimate.omega_smooth = omega_e;
    estimate.flux = PSI;
    estimate.frame.theta_e = (float)theta;
    estimate.frame.rotation = (rotation_t){(float)sin(theta), (float)cos(theta)};
    estimate.emf_loop = (dq_t){across * PSI * omega_e, along * PSI * omega_e};
}

void setUp(void)
{
    const lock_params_t params = {PSI, SLOW, ASKED, T};
    const lock_tuning_t tuning = lock_prepare(&params);
    memset(&lock, 0x55, sizeof lock);
    lock_init(&lock, &tuning);
}

/* The number of periods until a sign is detected, from a lock that has lasted; 0 if none is in 0.1 s. */
static uint32_t lost_after(float omega_e)
{
    lock_reset(&lock, omega_e);
    for (uint32_t n = 1u; n <= 1000u; n++) {
        lock_step(&lock, &estimate, estimate.detector * estimate.detector, 0.0f, false);
        if (lock_is_lost(&lock, true)) {
            return n;
        }
    }
    return 0u;
}

/* If the angle is wrong by half a turn, 2 exp(-0.02 n) - 1 < 0.5 from n = 15 on. 51 % along the axis are
 * enough for any part across; 49 % are not: 0.51 exp(-0.02 n) < 0.01 from n = 197 on. The scatter eps^2 (1
 * - exp(-0.02 n)) exceeds 0.12 from n = 21 on for eps = 0.6, from n = 195 on for 0.35, and never for 0.34. */
static void test_a_sign_shows_when_its_mean_has_passed_its_limit(void)
{
    static const struct {
        float omega, along, across, detector;
        uint32_t after, within; /* [periods]; 0: never */
    } cases[] = {{30.0f, 1.0f, 0.0f, 0.0f, 0u, 0u},    {OMEGA, 1.0f, 0.0f, 0.0f, 0u, 0u},
                 {-OMEGA, 1.0f, 0.0f, 0.0f, 0u, 0u},   {-3000.0f, 1.0f, 0.0f, 0.0f, 0u, 0u},
                 {OMEGA, -1.0f, 0.0f, 0.0f, 15u, 0u},  {-OMEGA, -1.0f, 0.0f, 0.0f, 15u, 0u},
                 {OMEGA, 0.51f, 2.0f, 0.0f, 0u, 0u},   {OMEGA, 0.49f, 2.0f, 0.0f, 197u, 2u},
                 {OMEGA, 1.0f, 0.0f, 0.6f, 21u, 0u},   {OMEGA, 1.0f, 0.0f, -0.6f, 21u, 0u},
                 {OMEGA, 1.0f, 0.0f, 0.35f, 195u, 2u}, {OMEGA, 1.0f, 0.0f, 0.34f, 0u, 0u}};
    for (size_t n = 0; n < sizeof cases / sizeof cases[0]; n++) {
        make_estimate(cases[n].omega, cases[n].along, cases[n].across);
        estimate.detector = cases[n].detector;
        TEST_ASSERT_UINT32_WITHIN(cases[n].within, cases[n].after, lost_after(cases[n].omega));
        TEST_ASSERT_FLOAT_WITHIN(1e-3f, PSI * fabsf(cases[n].omega), lock.expected);
    }
}

/* A period at this speed, with the EMF of a locked rotor, or with the least one that the projection expects.
 */
static void compare(float omega, float omega_ref, bool limited)
{
    make_estimate(omega, 1.0f, 0.0f);
    if (fabsf(omega) < 10.0f) {
        estimate.emf_loop.q = omega < 0.0f ? -10.0f * PSI : 10.0f * PSI;
    }
    lock_step(&lock, &estimate, 0.0f, omega_ref, limited);
}

/* The condition must hold for 20 ms of successive periods; one period below the limit of the torque
 * restarts the time, if the estimate is above the least speed, 10 rad/s. */
static void test_estimate_at_zero_for_20_ms_while_speed_is_requested_shows(void)
{
    static const struct {
        float omega, omega_ref;
        bool lost;
    } cases[] = {{24.9f, 42.1f, true},  {-24.9f, 42.1f, true}, {10.1f, -42.1f, true},
                 {24.9f, 41.9f, false}, {25.1f, 42.1f, false}, {-25.1f, -300.0f, false},
                 {0.0f, 0.0f, false},   {0.0f, -41.9f, false}};
    for (size_t n = 0; n < sizeof cases / sizeof cases[0]; n++) {
        lock_reset(&lock, cases[n].omega);
        for (int k = 0; k < 200; k++) {
            compare(cases[n].omega, cases[n].omega_ref, true);
            TEST_ASSERT_FALSE(lock_is_lost(&lock, true));
        }
        compare(cases[n].omega, cases[n].omega_ref, true);
        TEST_ASSERT_EQUAL(cases[n].lost, lock_is_lost(&lock, true));
        compare(cases[n].omega, cases[n].omega_ref, false);
        TEST_ASSERT_FALSE(lock_is_lost(&lock, true));
    }
}

/* Below the least speed of the projection, 10 rad/s, the time is 40 ms while the torque is below its limit.
 * A period at the limit counts as two. */
static void test_estimate_without_emf_for_40_ms_shows_at_any_torque(void)
{
    static const struct {
        float omega, omega_ref;
        uint32_t limited; /* [periods] of the first 200 with the torque at its limit */
        uint32_t after;   /* [periods]; 0: never */
    } cases[] = {{9.9f, 42.1f, 0u, 401u},   {-9.9f, -42.1f, 0u, 401u}, {0.0f, 300.0f, 100u, 301u},
                 {0.0f, 42.1f, 200u, 201u}, {10.1f, 42.1f, 0u, 0u},    {9.9f, 41.9f, 0u, 0u}};
    for (size_t n = 0; n < sizeof cases / sizeof cases[0]; n++) {
        lock_reset(&lock, OMEGA);
        uint32_t after = 0u;
        for (uint32_t k = 1u; k <= 1000u && after == 0u; k++) {
            compare(cases[n].omega, cases[n].omega_ref, k <= cases[n].limited);
            after = lock_is_lost(&lock, true) ? k : 0u;
        }
        TEST_ASSERT_EQUAL_UINT32(cases[n].after, after);
        compare(10.1f, cases[n].omega_ref, false);
        TEST_ASSERT_FALSE(lock_is_lost(&lock, true));
    }
}

/* A loop without EMF scatters: after 30 ms without EMF one period above the least speed takes back four, so
 * that 10.5 ms remain of the 40 ms. Several such periods are a rotor that has left this speed: after 75 of
 * them the time begins again. */
static void test_one_faster_period_does_not_end_the_time_without_emf(void)
{
    static const struct {
        int faster; /* [periods] */
        uint32_t after;
    } cases[] = {{1, 105u}, {75, 401u}, {100, 401u}};
    for (size_t n = 0; n < sizeof cases / sizeof cases[0]; n++) {
        lock_reset(&lock, OMEGA);
        for (int k = 0; k < 300; k++) {
            compare(1.0f, 300.0f, false);
        }
        for (int k = 0; k < cases[n].faster; k++) {
            compare(10.1f, 300.0f, false);
        }
        uint32_t after = 0u;
        for (uint32_t k = 1u; k <= 1000u && after == 0u; k++) {
            compare(1.0f, 300.0f, false);
            after = lock_is_lost(&lock, true) ? k : 0u;
        }
        TEST_ASSERT_EQUAL_UINT32(cases[n].after, after);
    }
}

/* Below 0.4 of the slow speed, 10 rad/s, the expected EMF does not decrease any more. */
static void test_expectation_has_a_floor(void)
{
    lock_reset(&lock, 3.0f);
    TEST_ASSERT_FLOAT_WITHIN(1e-6f, 10.0f * PSI, lock.expected);
    make_estimate(-3.0f, 1.0f, 0.0f);
    for (int n = 0; n < 2000; n++) {
        lock_step(&lock, &estimate, estimate.detector * estimate.detector, 0.0f, false);
    }
    TEST_ASSERT_FLOAT_WITHIN(1e-5f, 10.0f * PSI, lock.expected);
    TEST_ASSERT_FLOAT_WITHIN(1e-5f, 3.0f * PSI, lock.projection);
}

static void test_reset_is_a_lock_that_has_lasted(void)
{
    make_estimate(OMEGA, -1.0f, 0.0f);
    estimate.detector = 1.0f;
    TEST_ASSERT_TRUE(lost_after(OMEGA) > 0u);
    lock_reset(&lock, -2.0f * OMEGA);
    TEST_ASSERT_FALSE(lock_is_lost(&lock, true));
    TEST_ASSERT_FLOAT_WITHIN(1e-4f, 2.0f * OMEGA * PSI, lock.expected);
    TEST_ASSERT_EQUAL_FLOAT(lock.expected, lock.projection);
    TEST_ASSERT_EQUAL_FLOAT(0.0f, lock.scatter);
}

/* The angle is wrong by half a radian: the EMF is still along the axis, and only the detector shows the
 * error. */
static void test_scatter_is_no_sign_before_the_loop_has_settled(void)
{
    make_estimate(200.0f, cosf(0.5f), -sinf(0.5f));
    estimate.detector = sinf(0.5f);
    (void)lost_after(200.0f);
    TEST_ASSERT_TRUE(lock_is_lost(&lock, true));
    TEST_ASSERT_FALSE(lock_is_lost(&lock, false));
    make_estimate(200.0f, 0.0f, 0.0f);
    for (int n = 0; n < 200; n++) {
        lock_step(&lock, &estimate, estimate.detector * estimate.detector, 0.0f, false);
    }
    TEST_ASSERT_TRUE(lock_is_lost(&lock, false));
}
