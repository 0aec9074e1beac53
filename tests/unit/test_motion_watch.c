/* Shafts whose motion follows from algebra: J domega/dt = K_t (i - i_L). T_j, the time between two
 * judgements, is 0.8 ms; the current limit is 10 A. */
#include "medium/protect/motion_watch.h"
#include "tests/unit/compare.h"

#define LOOK       0.8e-3 /* [s] T_j */
#define PER_AMPERE 17.0   /* K_t/J [rad/s^2 per A] */
#define LIMIT      10.0
/* [rad/s] tau is 5 x 0.25/170 = 7.4 ms, and the smallest progress that counts 0.5 rad/s. */
#define NOISE 0.25

static motion_watch_t watch;
static motion_watch_params_t params;
static double omega; /* [rad/s] */
static uint32_t running;

static void begin(double assumed_per_ampere)
{
    params = (motion_watch_params_t){
        .per_ampere = (float)assumed_per_ampere,
        .current_limit = (float)LIMIT,
        .noise = (float)NOISE,
        .standing = 2.0f,
        .stall_time = 0.8f,
        .speed_error_time = 1.6f,
        .period = 1e-4f,
        .every = 8u,
    };
    const motion_watch_tuning_t tuning = motion_watch_prepare(&params);
    memset(&watch, 0x55, sizeof watch);
    motion_watch_init(&watch, &tuning);
    motion_watch_rest(&watch);
    omega = 0.0;
    running = 63u; /* more than 50 ms before: 62.5 judgements */
}

void setUp(void)
{
    begin(PER_AMPERE);
}

static motion_watch_input_t input_of(double i, double reference)
{
    return (motion_watch_input_t){.i_q = (float)i,
                                  .i_q_ref = (float)i,
                                  .limit = (float)LIMIT,
                                  .omega_m = (float)omega,
                                  .omega_m_ref = (float)reference,
                                  .measured = true,
                                  .running = running++,
                                  .asked = true};
}

/* A judgement with this speed and current. */
static uint32_t judged(double speed, double i, double reference)
{
    omega = speed;
    const motion_watch_input_t input = input_of(i, reference);
    return motion_watch_step(&watch, &input);
}

/* A judgement with this current, which turns the shaft by `sign` of its torque, against this load. */
static uint32_t turn(double i, double sign, double load, double reference)
{
    return judged(omega + LOOK * PER_AMPERE * (sign * i - load), i, reference);
}

/* The number of judgements until one of the bits is set; 0 if none is within `most` judgements. */
static uint32_t until(uint32_t bits, uint32_t most, double i, double sign, double load, double reference)
{
    for (uint32_t n = 1; n <= most; n++) {
        if ((turn(i, sign, load, reference) & bits) != 0u) {
            return n;
        }
    }
    return 0u;
}

/* A steady acceleration is measured exactly: i_L is the current that the acceleration lacks. */
static void test_the_load_is_what_the_motion_lacks(void)
{
    static const double cases[][2] = {{10.0, 0.0}, {10.0, 4.0}, {-7.0, 2.5}, {3.0, -9.0}, {0.0, 5.0}};
    for (int n = 0; n < 5; n++) {
        setUp();
        for (int m = 0; m < 200; m++) {
            (void)turn(cases[n][0], 1.0, cases[n][1], 1e4);
        }
        TEST_ASSERT_FLOAT_WITHIN(2e-3f, (float)cases[n][1], watch.load);
    }
}

/* The torque has the wrong sign. i_L approaches 20 A as 1 - (1 - s)^n with s = 1 - exp(-0.8/7.4): it
 * exceeds 13 A after 10 judgements, and i_q exceeds 6 A after 9. The condition must hold for 2.2 tau, 16.2
 * ms, which are twenty judgements. */
static void test_torque_of_the_wrong_sign_is_a_runaway(void)
{
    const double share = 1.0 - exp(-LOOK / (5.0 * NOISE / (PER_AMPERE * LIMIT)));
    const double first = ceil(log(1.0 - 13.0 / 20.0) / log(1.0 - share));
    for (int way = -1; way <= 1; way += 2) {
        setUp();
        (void)turn(0.0, -1.0, 0.0, way * 60.0); /* both low-passes begin with zero motion */
        const uint32_t n = until(MOTION_RUNAWAY, 100u, way * LIMIT, -1.0, 0.0, way * 60.0);
        TEST_ASSERT_EQUAL_UINT32((uint32_t)first + 19u, n);
        TEST_ASSERT_TRUE(way * omega < 0.0);
    }
}

/* A hoist whose load exceeds the limit by 15 %, with a J that is assumed twice too large: 1 + 2 x 0.15 =
 * 1.3. */
static void test_loads_up_to_what_the_motor_can_are_no_runaway(void)
{
    static const double loads[] = {-9.0, 5.0, 9.9, 11.4};
    for (int n = 0; n < 4; n++) {
        for (int way = -1; way <= 1; way += 2) {
            begin(0.5 * PER_AMPERE);
            TEST_ASSERT_EQUAL_UINT32(
                0u, until(MOTION_RUNAWAY, 500u, way * LIMIT, 1.0, way * loads[n], way * 60.0));
            begin(0.5 * PER_AMPERE);
            TEST_ASSERT_EQUAL_UINT32(0u,
                                     until(MOTION_RUNAWAY, 500u, way * 2.0, 1.0, way * loads[n], way * 60.0));
        }
    }
}

/* The shaft stops from 150 rad/s within 8 ms. This would be a load of 110 times the limit, but it is no
 * runaway. */
static void test_a_jam_is_no_runaway(void)
{
    omega = 150.0;
    for (int n = 0; n < 50; n++) {
        (void)turn(1.0, 1.0, 1.0, 150.0);
    }
    for (int n = 0; n < 500; n++) {
        const double speed = n < 10 ? 150.0 - 15.0 * (n + 1) : 0.0;
        TEST_ASSERT_EQUAL_HEX32(0u, judged(speed, LIMIT, 150.0) & MOTION_RUNAWAY);
    }
}

/* The speed changes from 20 to 60 rad/s at once, against the full current: 40 rad/s in 8 ms would need 295
 * A, which no torque can cause. */
static void test_a_shaft_that_is_hit_is_no_runaway(void)
{
    for (int way = -1; way <= 1; way += 2) {
        setUp();
        for (int n = 0; n < 200; n++) {
            const double speed = way * (n < 100 ? 20.0 : 60.0);
            TEST_ASSERT_EQUAL_HEX32(0u, judged(speed, -way * LIMIT, way * 10.0) & MOTION_RUNAWAY);
        }
    }
}

/* In this case the estimate runs away and not the rotor; the check of the lock detects this. */
static void test_only_a_sensor_sees_a_runaway(void)
{
    for (int n = 0; n < 100; n++) {
        omega -= LOOK * PER_AMPERE * LIMIT;
        motion_watch_input_t input = input_of(LIMIT, 60.0);
        input.measured = false;
        TEST_ASSERT_EQUAL_HEX32(0u, motion_watch_step(&watch, &input) & MOTION_RUNAWAY);
    }
}

/* An elastic shaft accelerates the rotor against its current. While the EMF agrees with the encoder, the
 * torque has the right sign. A runaway that begins afterwards must last for its whole time. */
static void test_a_shaft_whose_emf_confirms_the_encoder_does_not_run_away(void)
{
    motion_watch_input_t input = input_of(LIMIT, 60.0);
    for (int n = 0; n < 100; n++) {
        omega -= LOOK * PER_AMPERE * LIMIT;
        input = input_of(LIMIT, 60.0);
        input.confirmed = true;
        TEST_ASSERT_EQUAL_HEX32(0u, motion_watch_step(&watch, &input) & MOTION_RUNAWAY);
    }
    TEST_ASSERT_EQUAL_UINT32(20u, until(MOTION_RUNAWAY, 100u, LIMIT, -1.0, 0.0, 60.0));
}

static uint32_t held_at(double speed, double i, double limit, double reference, bool asked, uint32_t bits,
                        uint32_t most)
{
    for (uint32_t n = 1; n <= most; n++) {
        omega = speed;
        motion_watch_input_t input = input_of(i, reference);
        input.limit = (float)limit;
        input.asked = asked;
        if ((motion_watch_step(&watch, &input) & bits) != 0u) {
            return n;
        }
    }
    return 0u;
}

/* 0.8 s are 1000 judgements, 1.6 s are 2000; the same holds at a limit that has been lowered. */
static void test_a_rotor_that_stands_at_the_limit_is_stalled_after_its_time(void)
{
    for (int way = -1; way <= 1; way += 2) {
        setUp();
        TEST_ASSERT_EQUAL_UINT32(1000u,
                                 held_at(0.0, way * 9.9, LIMIT, way * 60.0, true, MOTION_STALLED, 1100u));
        setUp();
        TEST_ASSERT_EQUAL_UINT32(1000u,
                                 held_at(0.0, way * 4.9, 5.0, way * 60.0, true, MOTION_STALLED, 1100u));
        setUp();
        TEST_ASSERT_EQUAL_UINT32(
            2000u, held_at(way * 30.0, way * 9.9, LIMIT, way * 60.0, true, ~UINT32_C(0), 2100u));
        TEST_ASSERT_EQUAL_HEX32(MOTION_SPEED_ERROR, judged(way * 30.0, way * 9.9, way * 60.0));
    }
}

static void test_a_requested_standstill_or_one_that_is_not_judged_is_not_a_stall(void)
{
    /* a current is requested, not a speed. */
    TEST_ASSERT_EQUAL_UINT32(0u, held_at(0.0, 9.9, LIMIT, 60.0, false, ~UINT32_C(0), 5000u));
    /* The reference is standstill. */
    TEST_ASSERT_EQUAL_UINT32(0u, held_at(0.0, 9.9, LIMIT, 0.4, true, ~UINT32_C(0), 5000u));
    /* The current is not at its limit. */
    TEST_ASSERT_EQUAL_UINT32(0u, held_at(0.0, 8.9, LIMIT, 60.0, true, ~UINT32_C(0), 5000u));
    /* The speed is only 5 % too low. */
    TEST_ASSERT_EQUAL_UINT32(0u, held_at(58.0, 9.9, LIMIT, 60.0, true, ~UINT32_C(0), 5000u));
    params.stall_time = 0.0f; /* a time of zero switches the check off */
    params.speed_error_time = 0.0f;
    const motion_watch_tuning_t tuning = motion_watch_prepare(&params);
    motion_watch_take(&watch, &tuning);
    TEST_ASSERT_EQUAL_UINT32(0u, held_at(0.0, 9.9, LIMIT, 60.0, true, ~UINT32_C(0), 20000u));
}

/* A heavy shaft gains 0.5 rad/s in 0.7 s, accelerating or braking, and is not reported. A shaft that gains
 * it in 0.9 s counts as standing still while it is slow, and is no speed error. */
static void test_a_shaft_that_comes_nearer_is_not_stuck(void)
{
    for (int way = -1; way <= 1; way += 2) {
        setUp();
        const double gain = 0.5 * LOOK / 0.7;
        for (int n = 0; n < 20000; n++) {
            TEST_ASSERT_EQUAL_HEX32(0u, judged(omega + way * gain, way * 9.9, way * 60.0));
        }
        setUp();
        uint32_t seen = 0u;
        for (int n = 0; n < 3000; n++) {
            seen |= judged(omega + way * 0.5 * LOOK / 0.9, way * 9.9, way * 60.0);
        }
        TEST_ASSERT_EQUAL_HEX32(MOTION_STALLED, seen);
    }
}

/* The time below the limit is subtracted: after as long below the limit as at it, the count is zero again. */
static void test_time_below_the_limit_counts_back(void)
{
    TEST_ASSERT_EQUAL_UINT32(0u, held_at(0.0, 9.9, LIMIT, 60.0, true, ~UINT32_C(0), 900u));
    TEST_ASSERT_EQUAL_UINT32(0u, held_at(0.0, 5.0, LIMIT, 60.0, true, ~UINT32_C(0), 400u));
    TEST_ASSERT_EQUAL_UINT32(500u, held_at(0.0, 9.9, LIMIT, 60.0, true, ~UINT32_C(0), 1000u));
}

/* The load exceeds the braking torque: 10 A brake the shaft at 100 rad/s against a load of 13 A, which
 * accelerates it by 51 rad/s^2. It passes 110.5 rad/s after 0.21 s; then it is reported within 100 ms,
 * long before speed_error_time. */
static void test_a_load_that_overruns_the_brake_is_reported_at_once(void)
{
    omega = 100.0;
    double passed = 0.0;
    double told = 0.0;
    for (int n = 1; n < 1000 && told == 0.0; n++) {
        const uint32_t bits = turn(-10.0, 1.0, -13.0, 100.0);
        passed = passed == 0.0 && omega > 110.0 ? n * LOOK : passed;
        told = (bits & MOTION_SPEED_ERROR) != 0u ? n * LOOK : 0.0;
    }
    TEST_ASSERT_TRUE(passed > 0.0 && told > passed);
    TEST_ASSERT_DOUBLE_WITHIN(0.04, passed + 0.06, told);
}

/* A shaft that its brake slows down is not reported, however far it is from the reference; nor is one that
 * coasts, nor one whose brake has torque in reserve. */
static void test_a_shaft_that_is_braked_or_coasts_overruns_nothing(void)
{
    static const struct {
        double i, load;
    } cases[] = {{-10.0, -9.9}, {-10.0, -10.0}, {-8.0, -10.0}};
    for (size_t n = 0; n < sizeof cases / sizeof cases[0]; n++) {
        begin(PER_AMPERE);
        omega = 120.0;
        for (int k = 0; k < 1000; k++) {
            TEST_ASSERT_EQUAL_UINT32(0u, turn(cases[n].i, 1.0, cases[n].load, 60.0) & MOTION_SPEED_ERROR);
        }
    }
}

/* A loop settles after a catch: its speed is 4 exp(-t/25 ms) below that of a shaft that is braked by 17
 * rad/s^2. In the first 50 ms the estimated speed grows by 3.5 - 0.9 rad/s, and 0.5 rad/s count. Of the
 * remaining 0.54 rad/s the braking leaves at most 0.02. A load that accelerates the shaft by 51 rad/s^2 is
 * reported. */
static void test_a_speed_that_settles_after_a_catch_overruns_nothing(void)
{
    for (int drives = 0; drives < 2; drives++) {
        begin(PER_AMPERE);
        running = 0u;
        uint32_t seen = 0u;
        for (int n = 0; n < 200; n++) {
            const double t = n * LOOK;
            const double shaft = 150.0 + (drives != 0 ? 51.0 : -17.0) * t;
            seen |= judged(shaft - 4.0 * exp(-t / 0.025), -10.0, 100.0);
        }
        TEST_ASSERT_EQUAL_HEX32(drives != 0 ? MOTION_SPEED_ERROR : 0u, seen & MOTION_SPEED_ERROR);
    }
}
