/* A rotor that was lost and is caught again while it turns against the wish: it keeps its speed until its
 * lock has been judged, and after a second loss it is reversed in the forced frame. Beside a machine whose
 * currents are those that were asked for a period ago, whose EMF is observed without error, and whose loop is
 * on the rotor. */
#include <complex.h>
#include <string.h>
#include <unity.h>

#include "drive/manoeuvres.h"
#include "tests/unit/compare.h"

#define T          1e-4
#define PSI        0.183
#define POLE_PAIRS 4.0
#define KT         (1.5 * POLE_PAIRS * PSI)
#define INERTIA    0.0636
#define LINK       179.0f   /* [V] 311 V of DC link */
#define JUDGED     (int)600 /* [periods] of proving: 50 ms in which the scatter is not judged, and 10 ms */

static manoeuvres_t m;
static estimate_t estimate;
static run_wish_t wish;
static demand_t demand;
static bool lost;
static double theta, omega_m; /* [rad] electrical, [rad/s] mechanical */

void setUp(void)
{
    params_t params;
    params_defaults(&params);
    params.motor_inertia = (float)INERTIA;
    params.low_speed_current = 0.0f;
    params.inductance_adaptation = 0.0f;
    const believed_t believed = params_believed(&params);
    const manoeuvres_tuning_t tuning = manoeuvres_prepare(&params, &believed);
    memset(&m, 0x55, sizeof m);
    memset(&estimate, 0, sizeof estimate);
    manoeuvres_init(&m, &tuning);
    demand = (demand_t){{0.0f, 0.0f, {0.0f, 1.0f}}, FRAME_GOES_ON, {0.0f, 0.0f}, {0.0f, 0.0f}, 0.0f};
    lost = false;
    theta = 0.3;
    omega_m = -60.0;
    wish = (run_wish_t){RUN_SPEED, -60.0f, {0.0f, 0.0f}};
    manoeuvres_begin(&m, 0.0f);
}

void tearDown(void)
{
}

static void step(void)
{
    const double angle = (double)demand.frame.theta_e + T * (double)demand.frame.omega_e;
    const double complex current = ((double)demand.current.d + (double complex)I * (double)demand.current.q) *
                                   cexp((double complex)I * angle);
    omega_m += T * KT * cimag(current * cexp(-(double complex)I * theta)) / INERTIA;
    theta = circle(theta + T * POLE_PAIRS * omega_m);
    manoeuvres_advance(&m);
    const double complex emf =
        (double complex)I * POLE_PAIRS * omega_m * PSI * cexp((double complex)I * theta);
    const frame_t frame = {
        (float)theta, (float)(POLE_PAIRS * omega_m), {(float)sin(theta), (float)cos(theta)}};
    estimate.emf = (ab_t){(float)creal(emf), (float)cimag(emf)};
    estimate.amplitude = (float)cabs(emf);
    if (m.tracking != 0u) {
        estimate.frame = frame;
        estimate.omega_smooth = frame.omega_e;
    }
    const frame_t rotor = manoeuvres_rotor(&m, &frame, &estimate);
    const manoeuvres_input_t input = {
        .current = {(float)creal(current), (float)cimag(current)},
        .voltage_max = LINK,
        .estimate = &estimate,
        .encoder = &frame,
        .omega_m = manoeuvres_smooth(&m, &rotor, &estimate) * m.limits.pole_pairs_inverse,
        .wish = wish,
        .estimating = 1u,
        .losses = lost ? 1u : 0u,
    };
    manoeuvres_step(&m, &input, &demand);
    lost = false;
}

static void steps(int count)
{
    for (int n = 0; n < count; n++) {
        step();
    }
}

static void until(manoeuvre_t manoeuvre, int most)
{
    while (m.now != (int32_t)manoeuvre && most-- > 0) {
        step();
    }
    TEST_ASSERT_EQUAL_INT32(manoeuvre, m.now);
}

/* Runs at -60 rad/s; the wish changes to this speed in the period in which the lock is lost. */
static void lose(double wanted)
{
    if (m.now != (int32_t)MANOEUVRE_RUN) {
        until(MANOEUVRE_RUN, 210);
        steps(5000);
    }
    wish.omega_m_ref = (float)wanted;
    lost = true;
    step();
    TEST_ASSERT_EQUAL_INT32(MANOEUVRE_RELOCK, m.now);
    until(MANOEUVRE_RUN, 210);
}

static void test_a_relocked_rotor_against_the_wish_keeps_its_speed_until_it_is_judged(void)
{
    lose(60.0);
    const double caught = omega_m;
    for (int n = 1; n < JUDGED; n++) {
        step();
        TEST_ASSERT_EQUAL_INT32(MANOEUVRE_RUN, m.now);
        TEST_ASSERT_DOUBLE_WITHIN(0.5, caught, omega_m);
        TEST_ASSERT_DOUBLE_WITHIN(1.5, 0.0, (double)demand.current.q);
        TEST_ASSERT_EQUAL_UINT32(0u, m.reversing);
        /* judged all the time, but for the mask of a hand-over */
        TEST_ASSERT_EQUAL(m.periods > MANOEUVRE_MASKED_PERIODS, manoeuvres_judged(&m));
    }
    steps(200);
    TEST_ASSERT_TRUE((double)demand.current.q > 5.0); /* the reversal: 120 rad/s times k_i, 475 A/s */
    steps(7500);
    TEST_ASSERT_TRUE(omega_m > 0.0);
}

/* The scatter, which a fresh lock is not judged by for 50 ms, comes to its word before the reversal. */
static void test_a_loop_that_scatters_is_lost_before_the_reversal(void)
{
    lose(60.0);
    int n = 0;
    while (m.unlocked == 0u && n < JUDGED) {
        estimate.detector = n % 2 != 0 ? 0.5f : -0.5f;
        step();
        n++;
    }
    TEST_ASSERT_TRUE(n < JUDGED);
    TEST_ASSERT_TRUE(omega_m < -55.0);
}

static void test_a_relocked_rotor_with_the_wish_has_its_torque_at_once(void)
{
    lose(-100.0);
    steps(100);
    TEST_ASSERT_EQUAL_UINT32(0u, m.proving);
    TEST_ASSERT_TRUE((double)demand.current.q < -1.0); /* 40 rad/s times k_i, 158 A/s */
}

static void test_a_stop_waits_for_nothing(void)
{
    lose(60.0);
    steps(100);
    wish.mode = RUN_STOP;
    steps(300);
    TEST_ASSERT_EQUAL_UINT32(0u, m.proving);
    TEST_ASSERT_TRUE((double)demand.current.q > 3.0);
}

/* A current is torque, not a speed: nothing else drives the rotor meanwhile. */
static void test_a_wish_for_a_current_has_it_at_once(void)
{
    lose(60.0);
    steps(100);
    wish = (run_wish_t){RUN_CURRENT, 0.0f, {0.0f, 2.0f}};
    step();
    TEST_ASSERT_EQUAL_UINT32(0u, m.proving);
    TEST_ASSERT_EQUAL_FLOAT(2.0f, demand.current.q);
    lost = true;
    step();
    until(MANOEUVRE_RUN, 210);
    step();
    TEST_ASSERT_EQUAL_UINT32(0u, m.proving);
    TEST_ASSERT_EQUAL_FLOAT(2.0f, demand.current.q);
}

static void test_a_wish_that_turns_round_ends_it(void)
{
    lose(60.0);
    steps(100);
    wish.omega_m_ref = -100.0f;
    step();
    TEST_ASSERT_EQUAL_UINT32(0u, m.proving);
}

/* At first sight of a rotor nothing was lost: it is reversed as it is caught. */
static void test_a_first_catch_reverses_at_once(void)
{
    wish.omega_m_ref = 60.0f;
    until(MANOEUVRE_RUN, 210);
    TEST_ASSERT_EQUAL_UINT32(0u, m.proving);
    TEST_ASSERT_EQUAL_UINT32(1u, m.reversing);
}

static void test_a_rotor_that_was_lost_twice_is_reversed_in_the_forced_frame(void)
{
    lose(60.0);
    lose(60.0);
    steps(JUDGED - 1);
    TEST_ASSERT_EQUAL_INT32(MANOEUVRE_RUN, m.now);
    TEST_ASSERT_TRUE(omega_m < -55.0);
    steps(2);
    TEST_ASSERT_TRUE(manoeuvres_forces(&m));
    TEST_ASSERT_TRUE(m.forced.frame.omega_e < 0.0f); /* it begins with the rotor's speed */
    TEST_ASSERT_EQUAL_UINT32(2u, m.lock_losses);
}
