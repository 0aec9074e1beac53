/* Current sensors and wires that fail, in the closed loop: with the encoder and without, two shafts, both
 * directions, several moments. What must hold of each: the reason, the time until the gates are off, and the
 * largest true phase current, which shall stay below 25 A. That nothing of it stops a drive that is sound, is
 * asked by test_protect_motion.c and test_lock_loss.c. */
#include "tests/rig/start.h"
#include "tests/rig/the_rig.h"

#include "settings/reasons.h"

#define CODES_PER_AMPERE 102.4

static start_seen_t seen;

/* ---- cases ---- */

typedef struct {
    bool encoder;
    start_shaft_t shaft;
    double rpm;  /* [r/min] with sign; it stands at 0 */
    double wait; /* [s] more, so that the moments differ */
} case_t;

static void begin(const case_t *c, uint32_t seed)
{
    rig_free(rig);
    rig = start_on_desk(c->shaft, seed);
    run_put(rig, "position_source", c->encoder ? 0.0 : 1.0);
    start_ready(rig, 0.3 + 7.0 * c->wait);
    const bool turns = fabs(c->rpm) >= 100.0;
    if (turns) {
        rig_set_motion(rig, 0.3 / POLE_PAIRS, c->rpm * RPM);
    }
    run_put(rig, "speed_request", (c->rpm == 0.0 ? 600.0 : c->rpm) * RPM);
    if (c->rpm != 0.0) {
        run_put(rig, "enable", 1.0);
        run_seconds(rig, turns ? 0.5 : 1.5);
        if (turns) {
            run_load(rig, 2.5, 1.0);
        }
        run_seconds(rig, 0.2 + c->wait);
        run_expect_no_fault(rig);
    }
    start_watch(rig, &seen);
}

/* From now on until the gates are off, or so many seconds; the time in ms. */
static double wait_for_fault(double seconds)
{
    uint32_t n = 0;
    for (; n < rig_periods(seconds) && seen.state != (int)DRIVE_FAULT; n++) {
        rig_step(rig);
    }
    return 1e3 * start_time(n);
}

/* 20 ms, or a third of an electrical turn [ms]. */
static double promised(const case_t *c)
{
    return c->rpm == 0.0 ? 1e3 : fmax(20.0, 1e3 * 60.0 / (3.0 * POLE_PAIRS * fabs(c->rpm)));
}

/* Shafts, directions and moments, with the encoder and without, at which this goes wrong; at 25 r/min there
 * is nothing but the forced frame. */
#define RUNNING_CASES 28u

static void over_all(const char *name, void (*fail)(const case_t *c, uint32_t number))
{
    static const struct {
        double rpm;
        bool encoder;
    } speeds[] = {{150.0, false},  {150.0, true},  {600.0, false}, {600.0, true},
                  {1500.0, false}, {1500.0, true}, {25.0, false}};
    grid_t grid = grid_of(name, RUNNING_CASES);
    for (uint32_t n; grid_next(&grid, &n);) {
        const uint32_t number = n;
        const start_shaft_t shaft = (start_shaft_t)grid_axis(&n, START_BOTH);
        const double way = grid_axis(&n, 2u) == 0u ? -1.0 : 1.0;
        const case_t c = {speeds[n].encoder, shaft, way * speeds[n].rpm, 0.0137 * (number % 7u)};
        begin(&c, number + 3u);
        fail(&c, number);
    }
}

static const char *say(const case_t *c, double time)
{
    return run_say("%s, %c, %.0f r/min: fault %d after %.2f of what is promised, %.1f A",
                   c->encoder ? "encoder" : "sensorless", START_SHAFT_NAMES[c->shaft], c->rpm, seen.fault,
                   time / promised(c), seen.peak);
}

/* ---- stuck ---- */

static uint32_t stuck, violent;

/* By its reason, or by the current that it makes, one in ten. */
static void stick(const case_t *c, uint32_t number)
{
    static const double off[] = {0.0, 3.0, -6.0}; /* [A] of what it shows at that moment */
    const char *const row = number % 2u != 0u ? "stuck_current_a" : "stuck_current_b";
    const double now = rig_value(rig, number % 2u != 0u ? "true_i_a" : "true_i_b");
    const double code = floor(2048.0 + CODES_PER_AMPERE * (now + off[number % 3u]));
    run_put(rig, row, fmin(fmax(code, 60.0), 4035.0));
    const double time = wait_for_fault(0.5);
    const char *const where = say(c, time);
    stuck++;
    violent += seen.fault == (int)REASON_OVERCURRENT ? 1u : 0u;
    TEST_ASSERT_TRUE_MESSAGE(seen.fault == (int)REASON_CURRENT_STUCK || seen.fault == (int)REASON_OVERCURRENT,
                             where);
    TEST_ASSERT_TRUE_MESSAGE(seen.peak < 19.0, where);
    TEST_ASSERT_TRUE_MESSAGE(time <= 0.58 * promised(c), where);
}

static void test_a_stuck_sensor_stops_the_drive_before_25_A_flow(void)
{
    stuck = violent = 0u;
    over_all("stuck sensor", stick);
    TEST_ASSERT_TRUE(violent <= 0.1 * stuck + 3.0 * sqrt(0.1 * stuck));
}

/* ---- a broken wire ---- */

static const char *const wires[] = {"open_phase_a", "open_phase_b", "open_phase_c"};

static void open_wire(const case_t *c, uint32_t number)
{
    run_put(rig, wires[number % 3u], 1.0);
    const double time = wait_for_fault(0.6);
    const char *const where = say(c, time);
    TEST_ASSERT_EQUAL_INT_MESSAGE(REASON_PHASE_LOSS, seen.fault, where);
    TEST_ASSERT_TRUE_MESSAGE(time <= 0.84 * promised(c), where);
    TEST_ASSERT_TRUE_MESSAGE(seen.peak < 11.5, where);
}

static void test_a_broken_wire_is_told_while_running(void)
{
    over_all("broken wire", open_wire);
}

/* Broken before the start: the rotor has turned by less than a third of an electrical turn. */
static void test_a_broken_wire_is_told_at_the_start(void)
{
    grid_t grid = grid_of("broken before the start", 12u);
    for (uint32_t n; grid_next(&grid, &n);) {
        const case_t c = {n % 2u != 0u, (start_shaft_t)(n / 2u % 2u), 0.0, 0.05 * n};
        begin(&c, n + 1u);
        const double from = rig_value(rig, "true_theta_e");
        run_put(rig, wires[n % 3u], 1.0);
        run_put(rig, "enable", 1.0);
        const double time = wait_for_fault(0.6);
        const double turned = fabs(remainder(rig_value(rig, "true_theta_e") - from, 2.0 * PI));
        const char *const where =
            run_say("at the start: %.1f ms after enable, turned by %.2f rad", time, turned);
        TEST_ASSERT_EQUAL_INT_MESSAGE(REASON_PHASE_LOSS, seen.fault, where);
        TEST_ASSERT_TRUE_MESSAGE(turned < 2.0 * PI / 3.0, where);
    }
}

/* ---- range and gain ---- */

/* Four of five are told; the catch takes the first 20 ms, with 0.3 A. */
static void test_a_wrong_gain_is_told_by_the_rise_of_the_forced_current(void)
{
    static const start_row_t rows[] = {{"current_range", 20.0 / 0.6}, {"current_range", 20.0 * 0.6},
                                       {"current_gain_error_a", 0.3}, {"current_gain_error_a", -0.3},
                                       {"current_gain_error_b", 0.3}, {"current_gain_error_b", -0.3}};
    uint32_t cases = 0u, missed = 0u;
    grid_t grid = grid_of("wrong gain", 24u);
    for (uint32_t n; grid_next(&grid, &n); cases++) {
        const case_t c = {false, (start_shaft_t)(n % 2u), 0.0, 0.04 * n};
        begin(&c, n + 1u);
        run_put(rig, rows[n / 4u].name, rows[n / 4u].value);
        run_put(rig, "enable", 1.0);
        const double time = wait_for_fault(0.04);
        const char *const where = run_say("%s %.2f: fault %d after %.1f ms, %.1f A", rows[n / 4u].name,
                                          rows[n / 4u].value, seen.fault, time, seen.peak);
        missed += seen.fault == (int)REASON_CURRENT_GAIN ? 0u : 1u;
        TEST_ASSERT_TRUE_MESSAGE(seen.fault != (int)REASON_CURRENT_GAIN || time < 20.0 + 12.0, where);
        TEST_ASSERT_TRUE_MESSAGE(seen.peak < 20.0, where);
    }
    TEST_ASSERT_TRUE(missed <= 0.2 * cases + 3.0 * sqrt(0.2 * cases));
}
