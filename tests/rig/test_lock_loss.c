/* Is the rotor lost? Never told so in what is normal, soon where it is; caught again, or given up. */
#include "settings/reasons.h"
#include "tests/rig/start.h"
#include "tests/rig/the_rig.h"

#define SEEDS 4u /* of normal running, and of a load that stops the rotor */

static start_seen_t seen;

/* ---- normal ---- */

static void steady(double rpm, double load)
{
    start_running(rig, rpm, load, 1.0);
    start_watch(rig, &seen);
    run_seconds(rig, 1.0);
}

/* The speed control's rule makes s^2 + w s + w^2/3 of a shaft, w = pll_bandwidth/14: a load step T takes
 * 0.40 T/(J w/sqrt 3), of the bare motor 8.2 rad/s or 78 r/min for 1 N m. The rated torque takes 390 r/min:
 * at 300 r/min a stop, no normal running. There it gets half of what stops it. */
#define SPEED_PER_TORQUE 78.0 /* [r/min per N m] of the light shaft */

static double step_torque(start_shaft_t shaft, double rpm)
{
    const bool stops = shaft != HEAVY && rpm < SPEED_PER_TORQUE * RATED_TORQUE;
    return stops ? 0.5 * rpm / SPEED_PER_TORQUE : RATED_TORQUE;
}

static void load_step(start_shaft_t shaft, double rpm)
{
    start_running(rig, rpm, 0.0, 1.0);
    start_watch(rig, &seen);
    run_put(rig, "load_torque", step_torque(shaft, rpm));
    run_seconds(rig, 1.0);
    run_put(rig, "load_torque", 0.0);
    run_seconds(rig, 1.0);
}

static void speed_step(double from, double ramp)
{
    run_put(rig, "speed_ramp", ramp * RPM);
    start_running(rig, from, 0.0, 1.0);
    start_watch(rig, &seen);
    run_put(rig, "speed_request", 1500.0 * RPM);
    run_seconds(rig, 2.0);
    run_put(rig, "speed_request", 400.0 * RPM);
    run_seconds(rig, 2.0);
}

static void prepare(start_shaft_t shaft, uint32_t seed)
{
    rig_free(rig);
    rig = start_on_desk(shaft, seed);
}

/* Wrong by so much: a row of the firmware's parameters times this, or its dead time's voltage, 2.3 us of T.
 */
static void put_wrong(size_t n)
{
    static const start_row_t rows[] = {{"motor_resistance", 1.3},    {"motor_resistance", 0.7},
                                       {"motor_flux_linkage", 1.15}, {"motor_flux_linkage", 0.85},
                                       {"motor_inductance_q", 1.2},  {"motor_inductance_q", 0.8}};
    switch (n) {
    case 6:
        run_put(rig, "params.turn_on_delay", rig_value(rig, "params.turn_on_delay") + 0.2 * 2.3e-6);
        break;
    case 7:
        run_put(rig, "params.turn_off_delay", rig_value(rig, "params.turn_off_delay") + 0.2 * 2.3e-6);
        break;
    default:
        run_times(rig, rows[n].name, rows[n].value);
        break;
    }
    run_put(rig, "overspeed_trip", 190.0); /* so that k_s reaches for 15 % more flux too */
    run_put(rig, "motor_inductance_d", 12.5e-3 * (n == 4u ? 1.2 : n == 5u ? 0.8 : 1.0));
}
#define WRONG 8u

typedef enum { STEADY, LOADED, LOAD_STEP, SPEED_STEP, LOAD_STEP_WRONG, SPEED_STEP_WRONG } normal_t;

/* What is normal, and how many there are of each: speeds, ramps or wrong parameters. A load step with a wrong
 * parameter is taken at 300 r/min, of the light shaft, of which a step leaves little at 500, at 1000; a speed
 * step from 200 r/min: slower ones are taken for standing with some of these. */
static const struct {
    const char *name;
    uint32_t values;
    double value[7];
} normal[] = {
    [STEADY] = {"steady without load, r/min", 7u, {100.0, 200.0, 300.0, 500.0, 700.0, 1000.0, 1500.0}},
    [LOADED] = {"steady under load, r/min", 7u, {100.0, 200.0, 300.0, 500.0, 700.0, 1000.0, 1500.0}},
    [LOAD_STEP] = {"load step, r/min", 3u, {300.0, 500.0, 1500.0}},
    [SPEED_STEP] = {"speed step or ramp, r/min/s", 3u, {0.0, 1000.0, 3000.0}},
    [LOAD_STEP_WRONG] = {"load step, wrong parameter", WRONG, {0.0}},
    [SPEED_STEP_WRONG] = {"speed step, wrong parameter", WRONG, {0.0}},
};

static void run_normally(normal_t kind, start_shaft_t shaft, uint32_t n)
{
    if (kind == LOAD_STEP_WRONG || kind == SPEED_STEP_WRONG) {
        put_wrong(n);
    }
    switch (kind) {
    case STEADY:
    case LOADED:
        steady(normal[kind].value[n], kind == STEADY ? 0.0 : RATED_TORQUE);
        break;
    case LOAD_STEP:
        load_step(shaft, normal[kind].value[n]);
        break;
    case SPEED_STEP:
        speed_step(100.0, normal[kind].value[n]);
        break;
    case LOAD_STEP_WRONG:
        load_step(shaft, shaft == HEAVY ? 300.0 : 1000.0);
        break;
    case SPEED_STEP_WRONG:
        speed_step(200.0, 0.0);
        break;
    }
}

static void test_normal_running_raises_no_alarm(void)
{
    for (uint32_t kind = STEADY; kind <= SPEED_STEP_WRONG; kind++) {
        grid_t grid = grid_of(normal[kind].name, START_BOTH * SEEDS * normal[kind].values);
        for (uint32_t n; grid_next(&grid, &n);) {
            const start_shaft_t shaft = (start_shaft_t)grid_axis(&n, START_BOTH);
            const uint32_t seed = 1u + grid_axis(&n, SEEDS);
            prepare(shaft, seed);
            run_normally((normal_t)kind, shaft, n);
            char where[120];
            (void)snprintf(where, sizeof where, "%c, %s %g (%u): losses %d, fault %d, manoeuvre %d",
                           START_SHAFT_NAMES[shaft], normal[kind].name, normal[kind].value[n % 7u],
                           (unsigned)n, seen.losses, seen.fault, seen.manoeuvre);
            TEST_ASSERT_TRUE_MESSAGE(seen.losses == 0 && seen.fault == 0 && seen.manoeuvre == RUNS, where);
        }
    }
}

/* ---- lost ---- */

/* The trips out of the way: a wrong angle of pi at full EMF draws what R and L leave it. */
static void prepare_to_lose(start_shaft_t shaft, double rpm, double load)
{
    prepare(shaft, 3u);
    run_put(rig, "overcurrent_trip", 19.0);
    run_put(rig, "short_circuit_current", 1000.0);
    start_running(rig, rpm, load, 1.5);
    start_watch(rig, &seen);
}

/* What the rotor has left of its speed [r/min] when the catch has found it: the loop's wrong torque acts till
 * it is noticed, nothing but the load for the 20 ms of the catch. A rotor slower than 100 r/min is not caught
 * but started. */
static double speed_left(start_shaft_t shaft, double rpm, double load, double noticed)
{
    const start_shaft_data_t *data = &start_shaft_data[shaft];
    const double braking = (load + data->friction) / data->inertia;
    return rpm - (2.0 * noticed + 20e-3) * braking / RPM;
}

/* Asked: noticed within 30 ms, locked within 100. */
static void expect_caught_again(start_shaft_t shaft, double rpm, double load)
{
    double noticed = 9.0, locked = 9.0, slowest = rpm;
    uint32_t small = 0;
    prepare_to_lose(shaft, rpm, load);
    run_put(rig, "estimate_jump", PI);
    for (uint32_t k = 0; k < rig_periods(2.5); k++) {
        rig_step(rig);
        slowest = fmin(slowest, seen.speed);
        if (seen.losses > 0) {
            noticed = fmin(noticed, start_time(k + 1u));
        }
        small = seen.manoeuvre == RUNS && fabs(seen.error) < 0.1 ? small + 1u : 0u;
        if (small == rig_periods(10e-3)) {
            locked = fmin(locked, start_time(k + 1u) - 10e-3);
        }
    }
    const bool stops = speed_left(shaft, rpm, load, noticed < 1.0 ? noticed : 30e-3) < 100.0;
    const char *const where =
        run_say("lock %c, jump of pi at %.0f r/min, %.0f N m: noticed after %.1f ms, locked after %.1f ms%s, "
                "slowest %.0f r/min, losses %d, fault %d",
                START_SHAFT_NAMES[shaft], rpm, load, 1e3 * noticed, 1e3 * locked, stops ? " (stops)" : "",
                slowest, seen.losses, seen.fault);
    TEST_ASSERT_TRUE_MESSAGE(seen.fault == 0 && seen.manoeuvre == RUNS, where);
    TEST_ASSERT_TRUE_MESSAGE(noticed <= 9e-3, where);
    TEST_ASSERT_TRUE_MESSAGE(locked <= (stops ? 1.1 : 55e-3), where);
    TEST_ASSERT_TRUE_MESSAGE(fabs(seen.error) < 0.1, where);
}

/* Noticed 50 ms after standstill was asked for; or noticed and given up before that. */
static void expect_given_up(start_shaft_t shaft, double rpm, double load)
{
    double standstill = -1.0, noticed = -1.0;
    uint32_t k = 0;
    prepare_to_lose(shaft, rpm, load);
    run_put(rig, "brake_torque", 60.0);
    for (; k < rig_periods(15.0) && seen.fault == 0; k++) {
        rig_step(rig);
        if (standstill < 0.0 && fabs(seen.speed) < 0.1) {
            standstill = start_time(k);
        }
        if (noticed < 0.0 && seen.manoeuvre != RUNS) {
            noticed = start_time(k);
        }
    }
    const char *const where =
        run_say("lock %c, blocked at %.0f r/min, %.0f N m: standstill after %.1f ms, noticed %+.1f ms later, "
                "fault %d after %.2f s",
                START_SHAFT_NAMES[shaft], rpm, load, 1e3 * standstill, 1e3 * (noticed - standstill),
                seen.fault, start_time(k));
    TEST_ASSERT_TRUE_MESSAGE(seen.fault == REASON_START_STALLED || seen.fault == REASON_LOCK_LOST, where);
    TEST_ASSERT_TRUE_MESSAGE(standstill < 0.0 || (noticed >= 0.0 && noticed - standstill <= 11.5e-3), where);
    TEST_ASSERT_TRUE_MESSAGE(start_time(k) <= 4.6, where);
}

/* Both shafts, three speeds, without load and under the rated one. */
static void each_loss(const char *name, void (*expect)(start_shaft_t shaft, double rpm, double load))
{
    static const double speeds[] = {155.0, 500.0, 1500.0};
    grid_t grid = grid_of(name, 12u);
    for (uint32_t n; grid_next(&grid, &n);) {
        const start_shaft_t shaft = (start_shaft_t)grid_axis(&n, START_BOTH);
        const double rpm = speeds[grid_axis(&n, 3u)];
        expect(shaft, rpm, n == 0u ? 0.0 : RATED_TORQUE);
    }
}

static void test_angle_that_jumps_by_pi_is_noticed_and_caught(void)
{
    each_loss("jump", expect_caught_again);
}

static void test_shaft_that_is_blocked_while_running_is_noticed_and_given_up(void)
{
    each_loss("blocked while running", expect_given_up);
}

static void test_rotor_that_a_load_step_stops_starts_again_by_itself(void)
{
    grid_t grid = grid_of("stopped by a load", SEEDS);
    for (uint32_t n; grid_next(&grid, &n);) {
        double slowest = 300.0;
        prepare(LIGHT, 1u + n);
        start_running(rig, 300.0, 0.0, 1.0);
        start_watch(rig, &seen);
        run_put(rig, "load_torque", RATED_TORQUE);
        uint32_t k = 0;
        bool stopped = false;
        for (; k < rig_periods(3.0) && !(stopped && seen.manoeuvre == RUNS && seen.speed > 295.0); k++) {
            rig_step(rig);
            stopped = stopped || seen.manoeuvre != RUNS;
            slowest = fmin(slowest, seen.speed);
        }
        printf("lock L, 5 N m step at 300 r/min: slowest %.0f r/min, back at 300 r/min after %.2f s\n",
               slowest, start_time(k));
        TEST_ASSERT_EQUAL_INT(0, seen.fault);
        TEST_ASSERT_TRUE(slowest < 0.0);
        TEST_ASSERT_TRUE(start_time(k) <= 1.5);
    }
}

/* A loss each 0.5 s: the third within 2 s stops the drive; one each 1.2 s may go on. */
static void test_third_loss_within_two_seconds_stops_the_drive(void)
{
    grid_t grid = grid_of("third loss", START_BOTH * SEED_PHASES);
    for (uint32_t point; grid_next(&grid, &point);) {
        prepare_to_lose((start_shaft_t)grid_axis(&point, START_BOTH), 500.0, 0.0);
        void *const running = run_kept(rig);
        for (int n = 1; n <= 3; n++) {
            TEST_ASSERT_EQUAL_INT(0, seen.fault);
            run_put(rig, "estimate_jump", PI);
            run_seconds(rig, 0.5);
            TEST_ASSERT_EQUAL_INT(n, seen.losses);
        }
        TEST_ASSERT_EQUAL_INT(REASON_LOCK_LOST, seen.fault);
        run_back_to(rig, running);
        free(running);
        for (int n = 1; n <= 4; n++) {
            run_put(rig, "estimate_jump", PI);
            run_seconds(rig, 1.2);
            TEST_ASSERT_EQUAL_INT(n, seen.losses);
        }
        TEST_ASSERT_EQUAL_INT(0, seen.fault);
        TEST_ASSERT_EQUAL_INT(RUNS, seen.manoeuvre);
    }
}
