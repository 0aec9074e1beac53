/* A lost rotor is caught again while it turns against the requested direction. It keeps its speed until
 * its lock has been judged; after a second loss the forced frame reverses it from the hand-over speed on. */
#include "tests/unit/manoeuvres_bench.h"

/* [windows] of the judgement: 63 for the 50 ms in which the scatter is not judged, and 13 for 10 ms. */
#define JUDGED 76u

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

/* A run at -60 rad/s; in the period in which the lock is lost the request changes to this speed. */
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
        /* The lock is judged all the time, except while a hand-over masks it. */
        TEST_ASSERT_EQUAL(m.windows > MANOEUVRE_MASKED, manoeuvres_judged(&m));
    }
    steps(0.02);
    /* The reversal has begun: the error of 120 rad/s increases i_q by 475 A/s through k_i. */
    TEST_ASSERT_TRUE((double)demand.current.q > 5.0);
    steps(0.75);
    TEST_ASSERT_TRUE(machine.omega_m > 0.0);
}

/* The scatter, which is not judged in the first 50 ms of a new lock, is evaluated before the reversal. */
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

/* The drive does not wait in these cases: the request has the direction of the rotor (40 rad/s times k_i,
 * 158 A/s); a stop is requested; a current is requested, which is a torque and not a speed; the request
 * has changed back. */
static void test_another_request_has_its_torque_at_once(void)
{
    static const struct {
        double relocked_with; /* [rad/s] */
        run_wish_t wish;
        double seconds, least, most; /* [A] range of i_q after this time */
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
        if (wish.mode == RUN_CURRENT) { /* another loss does not begin a proof either */
            lose_and_catch();
            TEST_ASSERT_EQUAL_UINT32(0u, m.proving);
            TEST_ASSERT_EQUAL_FLOAT(2.0f, made.current.q);
        }
    }
}

/* At the first catch no rotor has been lost: the reversal begins at once. */
static void test_a_first_catch_reverses_at_once(void)
{
    given_rotor_backwards(60.0);
    TEST_ASSERT_EQUAL_UINT32(0u, m.proving);
    TEST_ASSERT_EQUAL_UINT32(1u, m.reversing);
}

/* 11 rad/s are 44 rad/s electrical, below the hand-over speed. In this direction [1, -1]. */
static void given_slow_catch(int way)
{
    make_heavy();
    machine.friction = 0.0;
    machine.theta = 0.3;
    machine.omega_m = 11.0 * way;
    wish.omega_m_ref = 60.0f * (float)way;
    begin();
    while (m.tracking == 0u) {
        step();
    }
}

/* The load may have turned a slow rotor round during the catch: four windows of 2 ms must agree before there
 * is torque. */
static void test_a_first_catch_below_the_handover_speed_is_proved_before_there_is_torque(void)
{
    for (int way = -1; way <= 1; way += 2) {
        setUp();
        given_slow_catch(way);
        uint32_t took = 0;
        for (; m.now == (int32_t)MANOEUVRE_CATCH && took < 1000u; took++) {
            TEST_ASSERT_EQUAL_FLOAT(0.0f, demand.current.q);
            step();
        }
        TEST_ASSERT_EQUAL_INT32(MANOEUVRE_RUN, m.now);
        TEST_ASSERT_TRUE(took >= PROOF_WINDOWS * m.proof.tuning.window * W);
        steps(0.02);
        TEST_ASSERT_TRUE(way * (double)demand.current.q > 1.0);
    }
}

/* A loop at 200 rad/s beside this rotor: its EMF is a quarter of that of the loop. */
static void test_a_slow_rotor_whose_first_lock_is_not_proved_is_caught_again(void)
{
    given_slow_catch(1);
    machine.astray = 200.0;
    const uint32_t from = period;
    while (m.tracking != 0u && (period - from) * T < 0.05) {
        step();
        TEST_ASSERT_EQUAL_INT32(MANOEUVRE_CATCH, m.now);
    }
    TEST_ASSERT_EQUAL_UINT32(0u, m.tracking);
    machine.astray = 0.0;
    (void)steps_until(MANOEUVRE_RUN, 0.05);
    TEST_ASSERT_EQUAL_UINT32(0u, m.losses.count);
    TEST_ASSERT_EQUAL_HEX32(0u, m.failed);
    TEST_ASSERT_DOUBLE_WITHIN(1.0, 44.0, (double)estimate.omega_smooth);
}

/* At a high speed the step of the frame's angle would disturb the observer: the closed loop brakes the rotor
 * to the hand-over speed, and the forced frame begins with it. */
static void test_a_rotor_that_was_lost_twice_is_reversed_in_the_forced_frame_after_braking(void)
{
    given_relocked(60.0);
    lose_and_catch();
    windows(JUDGED - 1u);
    TEST_ASSERT_EQUAL_INT32(MANOEUVRE_RUN, m.now);
    TEST_ASSERT_TRUE(machine.omega_m < -55.0);
    uint32_t braked = 0u;
    for (; !manoeuvres_forces(&m) && braked < 2000u; braked++) {
        TEST_ASSERT_EQUAL_INT32(MANOEUVRE_RUN, m.now);
        TEST_ASSERT_TRUE(braked < 2u || -estimate.omega_smooth > 0.9f * m.limits.handover_speed);
        windows(1u);
    }
    TEST_ASSERT_TRUE(braked > 2u && braked < 2000u);
    TEST_ASSERT_TRUE(m.forced.speed < 0.0f && -m.forced.speed <= m.limits.handover_speed);
    TEST_ASSERT_EQUAL_UINT32(2u, m.losses.count);
    steps(1.0);
    TEST_ASSERT_TRUE(machine.omega_m > 0.0);
}

/* 11 rad/s are 44 rad/s electrical, below the hand-over speed: the forced frame continues from there with
 * the same torque. */
static void test_a_relocked_rotor_slower_than_at_a_handover_goes_on_in_the_forced_frame(void)
{
    given_rotor_backwards(-60.0);
    machine.omega_m = -11.0;
    wish.omega_m_ref = -60.0f;
    lose();
    (void)steps_until(MANOEUVRE_FORCED, 0.1);
    TEST_ASSERT_DOUBLE_WITHIN(0.3 * 44.0, -44.0, (double)m.forced.speed);
}

/* A requested torque defines no speed to which the forced frame could bring the rotor. */
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

/* The fast task has detected that the encoder has failed; the medium task follows with the tracking loop
 * or with a catch. */
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
