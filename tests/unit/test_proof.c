/* The proof of a lock: in several successive windows the EMF agrees with the loop, or the proof fails
 * within its time. */
#include "medium/manoeuvre/proof.h"
#include "tests/unit/compare.h"

#define T      1e-4f
#define PSI    0.183
#define WINDOW 20  /* [periods] 2 ms */
#define MOST   500 /* [periods] 50 ms */

static proof_t proof;
static estimate_t estimate;

void setUp(void)
{
    const proof_tuning_t tuning = proof_prepare(T);
    memset(&proof, 0x55, sizeof proof);
    memset(&estimate, 0, sizeof estimate);
    proof_init(&proof, &tuning);
}

/* A loop at this speed [rad/s] whose rotor is ahead by `off` [rad], with this share of psi_f omega as EMF. */
static void given(double omega, double off, double share)
{
    const double emf = share * PSI * omega;
    estimate.frame.rotation = (rotation_t){(float)sin(0.7), (float)cos(0.7)};
    estimate.omega_smooth = (float)omega;
    estimate.flux = (float)PSI;
    estimate.emf_loop = (dq_t){(float)(-emf * sin(off)), (float)(emf * cos(off))};
}

/* Runs until there is a result, for at most this number of periods; `taken` receives the number of
 * periods. */
static proof_outcome_t outcome(int most, int *taken)
{
    proof_outcome_t now = PROOF_GOES_ON;
    for (*taken = 0; *taken < most && now == PROOF_GOES_ON; (*taken)++) {
        now = proof_step(&proof, &estimate);
    }
    return now;
}

static void expect_good(int periods)
{
    int taken;
    TEST_ASSERT_EQUAL_INT(PROOF_GOOD, outcome(MOST + 1, &taken));
    TEST_ASSERT_EQUAL_INT(periods, taken);
}

static void expect_failed(int periods)
{
    int taken;
    TEST_ASSERT_EQUAL_INT(PROOF_FAILED, outcome(MOST + 1, &taken));
    TEST_ASSERT_EQUAL_INT(periods, taken);
}

/* The proof needs four windows, in both directions. The largest accepted angle error has the tangent 0.5,
 * 0.464 rad. An EMF shorter than half of psi_f omega, at any angle, ends the proof after three windows. */
static void test_a_loop_on_the_rotor_is_good_and_another_fails_in_time(void)
{
    static const struct {
        double omega, off, share;
        bool good;
    } cases[] = {{100.0, 0.0, 1.0, true},    {-100.0, 0.0, 1.0, true},       {100.0, 0.46, 1.0, true},
                 {100.0, -0.47, 1.0, false}, {100.0, 3.1415927, 1.0, false}, {-60.0, 0.0, 0.49, false},
                 {-60.0, 0.0, 0.51, true},   {-60.0, 0.0, 1.99, true},       {-60.0, 0.0, 2.01, false},
                 {-60.0, 0.0, 0.0, false},   {100.0, 1.5, 0.49, false},      {100.0, 1.5, 0.51, false}};
    for (size_t n = 0; n < sizeof cases / sizeof cases[0]; n++) {
        proof_enter(&proof);
        given(cases[n].omega, cases[n].off, cases[n].share);
        if (cases[n].good) {
            expect_good(4 * WINDOW);
        } else {
            expect_failed(cases[n].share < 0.5 ? 3 * WINDOW : MOST);
        }
    }
}

static void test_a_window_that_does_not_agree_begins_the_count_again(void)
{
    int taken;
    given(100.0, 0.0, 1.0);
    TEST_ASSERT_EQUAL_INT(PROOF_GOES_ON, outcome(3 * WINDOW, &taken));
    given(100.0, 1.0, 1.0);
    TEST_ASSERT_EQUAL_INT(PROOF_GOES_ON, outcome(WINDOW, &taken));
    given(100.0, 0.0, 1.0);
    expect_good(4 * WINDOW);
}

/* Two windows contradict the speed and one does not: the proof continues until its time is over. */
static void test_only_windows_in_succession_deny_the_speed(void)
{
    for (int n = 0; n < MOST; n++) {
        given(1000.0, 1.5, n / WINDOW % 3 == 2 ? 1.0 : 0.1);
        TEST_ASSERT_EQUAL_INT(n < MOST - 1 ? PROOF_GOES_ON : PROOF_FAILED, proof_step(&proof, &estimate));
    }
}

/* Only the mean over the window counts, so that a ripple has no effect. */
static void test_a_ripple_within_a_window_is_no_disagreement(void)
{
    for (int n = 0; n < 4 * WINDOW; n++) {
        given(100.0, n % 2 == 0 ? 0.8 : -0.8, 1.2);
        TEST_ASSERT_EQUAL_INT(n < 4 * WINDOW - 1 ? PROOF_GOES_ON : PROOF_GOOD, proof_step(&proof, &estimate));
    }
}

/* While the loop coasts, the applied voltage is uncertain, and so is the EMF of that period. */
static void test_periods_that_coast_do_not_count(void)
{
    for (int n = 0; n < 8 * WINDOW; n++) {
        estimate.coasted = n % 2 == 0 ? 1u : 0u;
        given(100.0, estimate.coasted != 0u ? 2.0 : 0.0, 1.0);
        TEST_ASSERT_EQUAL_INT(n < 8 * WINDOW - 1 ? PROOF_GOES_ON : PROOF_GOOD, proof_step(&proof, &estimate));
    }
    proof_enter(&proof);
    estimate.coasted = 1u;
    expect_failed(MOST);
}
