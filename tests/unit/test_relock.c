/* A rotor that was lost and is caught again while it turns against the request: it keeps its speed until its
 * lock has been judged, and after a second loss it is reversed in the forced frame. */
#include "tests/unit/manoeuvres_bench.h"

#define JUDGED 76u /* [windows] of proving: 50 ms in which the scatter is not judged, 63, and 10 ms, 13 */

static void given_rotor_backwards(double wanted)
{
    make_heavy();
    machine.friction = 0.0;
    machine.theta = 0.3;
    machine.omega_m = -60.0;
    wish.omega_m_ref = (float)wanted;
    begin();
    (void)steps_until(MANOEUVRE_RUN, 0.021);
}

static void lose_and_catch(void)
{
    lose();
    (void)steps_until(MANOEUVRE_RUN, 0.021);
}

/* Runs at -60 rad/s; the request changes to this speed in the period in which the lock is lost. */
static void given_relocked(double wanted)
{
    given_rotor_backwards(-60.0);
    steps(0.5);
    wish.omega_m_ref = (float)wanted;
    lose_and_catch();
}

static void test_a_relocked_rotor_against_the_request_keeps_its_speed_until_it_is_judged(void)
{
    given_relocked(60.0);
    const double caught = machine.omega_m;
    for (uint32_t n = 1; n < JUDGED; n++) {
        windows(1u);
        TEST_ASSERT_EQUAL_INT32(MANOEUVRE_RUN, m.now);
        TEST_ASSERT_DOUBLE_WITHIN(0.5, caught, machine.omega_m);
        TEST_ASSERT_DOUBLE_WITHIN(1.5, 0.0, (double)demand.current.q);
        TEST_ASSERT_EQUAL_UINT32(0u, m.reversing);
        /* judged all the time, but for the mask of a hand-over */
        TEST_ASSERT_EQUAL(m.windows > MANOEUVRE_MASKED, manoeuvres_judged(&m));
    }
    steps(0.02);
    TEST_ASSERT_TRUE((double)demand.current.q > 5.0); /* the reversal: 120 rad/s times k_i, 475 A/s */
    steps(0.75);
    TEST_ASSERT_TRUE(machine.omega_m > 0.0);
}

/* The scatter, by which a new lock is not judged for 50 ms, is evaluated before the reversal. */
static void test_a_loop_that_scatters_is_lost_before_the_reversal(void)
{
    given_relocked(60.0);
    uint32_t n = 0;
    while (m.unlocked == 0u && n < JUDGED) {
        machine.detector = n % 2 != 0 ? 0.5 : -0.5;
        windows(1u);
        n++;
    }
    TEST_ASSERT_TRUE(n < JUDGED);
    TEST_ASSERT_TRUE(machine.omega_m < -55.0);
}

/* The drive does not wait if the request has the rotor's direction, 40 rad/s times k_i, 158 A/s; with a stop;
 * with a current, which is a torque and not a speed; nor after the request has been reversed. */
static void test_another_request_has_its_torque_at_once(void)
{
    static const struct {
        double relocked_with; /* [rad/s] */
        run_wish_t wish;
        double seconds, least, most; /* then i_q is within these [A] */
    } cases[] = {{-100.0, {RUN_SPEED, -100.0f, {0.0f, 0.0f}, 0.0f}, 0.0, -10.0, -1.0},
                 {60.0, {RUN_STOP, 60.0f, {0.0f, 0.0f}, 0.0f}, 0.03, 3.0, 10.0},
                 {60.0, {RUN_CURRENT, 0.0f, {0.0f, 2.0f}, 0.0f}, 3.0 * W * T, 2.0, 2.0},
                 {60.0, {RUN_SPEED, -100.0f, {0.0f, 0.0f}, 0.0f}, W * T, -10.0, 10.0}};
    for (size_t n = 0; n < sizeof cases / sizeof cases[0]; n++) {
        setUp();
        given_relocked(cases[n].relocked_with);
        steps(0.01);
        wish = cases[n].wish;
        steps(cases[n].seconds);
        TEST_ASSERT_EQUAL_UINT32(0u, m.proving);
        TEST_ASSERT_TRUE((double)demand.current.q >= cases[n].least &&
                         (double)demand.current.q <= cases[n].most);
        if (wish.mode == RUN_CURRENT) { /* nor after another loss */
            lose_and_catch();
            TEST_ASSERT_EQUAL_UINT32(0u, m.proving);
            TEST_ASSERT_EQUAL_FLOAT(2.0f, made.current.q);
        }
    }
}

/* At the first catch no rotor was lost: it is reversed at once. */
static void test_a_first_catch_reverses_at_once(void)
{
    given_rotor_backwards(60.0);
    TEST_ASSERT_EQUAL_UINT32(0u, m.proving);
    TEST_ASSERT_EQUAL_UINT32(1u, m.reversing);
}

static void test_a_rotor_that_was_lost_twice_is_reversed_in_the_forced_frame(void)
{
    given_relocked(60.0);
    lose_and_catch();
    windows(JUDGED - 1u);
    TEST_ASSERT_EQUAL_INT32(MANOEUVRE_RUN, m.now);
    TEST_ASSERT_TRUE(machine.omega_m < -55.0);
    windows(2u);
    TEST_ASSERT_TRUE(manoeuvres_forces(&m));
    TEST_ASSERT_TRUE(m.forced.speed < 0.0f); /* it begins with the rotor's speed */
    TEST_ASSERT_EQUAL_UINT32(2u, m.losses.count);
}

/* 11 rad/s are 44 rad/s electrical, below the hand-over: the frame of the same torque goes on from there. */
static void test_a_relocked_rotor_slower_than_at_a_handover_goes_on_in_the_forced_frame(void)
{
    given_rotor_backwards(-60.0);
    machine.omega_m = -11.0;
    wish.omega_m_ref = -60.0f;
    lose();
    (void)steps_until(MANOEUVRE_FORCED, 0.1);
    TEST_ASSERT_DOUBLE_WITHIN(0.3 * 44.0, -44.0, (double)m.forced.speed);
}

/* A requested torque has no speed to which the forced frame could bring the rotor. */
static void test_a_relocked_slow_rotor_with_a_requested_torque_runs_on(void)
{
    for (int way = -1; way <= 1; way += 2) {
        given_rotor_backwards(-60.0);
        machine.omega_m = -11.0;
        wish.mode = RUN_TORQUE;
        wish.torque = (float)way;
        lose();
        (void)steps_until(MANOEUVRE_RUN, 0.1);
    }
}

/* The encoder has failed in the fast task: the medium task follows, with the loop that tracks, or by a catch.
 */
static void test_an_encoder_that_fails_leads_to_run_on_the_estimate_or_to_a_relock(void)
{
    given_rotor_backwards(-60.0);
    estimate_t unlocked = {.omega_smooth = -240.0f, .flux = 0.183f};
    const manoeuvres_input_t input = {.estimate = &unlocked, .current = {1.0f, 2.0f}, .setpoint = 7u};
    setpoint_t ordered = {.source = (int32_t)SOURCE_ENCODER};
    manoeuvres_left_encoder(&m, &input, true, &ordered);
    TEST_ASSERT_EQUAL_INT32(MANOEUVRE_RUN, m.now);
    TEST_ASSERT_TRUE(m.encoder_lost != 0u && m.sensorless != 0u && m.windows == MANOEUVRE_MASKED);
    manoeuvres_leave_encoder(&m, &input, &ordered);
    TEST_ASSERT_EQUAL_INT32(MANOEUVRE_RELOCK, m.now);
    TEST_ASSERT_EQUAL_INT32(SOURCE_CATCH, ordered.source);
    TEST_ASSERT_EQUAL_FLOAT(0.0f, ordered.current.q);
}
