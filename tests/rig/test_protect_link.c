/* Heat and DC link in the closed loop: braking into a link that nobody takes power from, a supply that is
 * lost for a while, a supply that ripples, and a motor that is asked for more than it stands for long. Both
 * shafts, with and without the encoder; every number is of every period. */
#include "settings/reasons.h"
#include "tests/rig/start.h"
#include "tests/rig/the_rig.h"

#define OVER       (BOARD_OVERVOLTAGE_MV / 1e3)
#define UNDER      (BOARD_UNDERVOLTAGE_MV / 1e3)
#define NOMINAL    (BOARD_DC_NOMINAL_MV / 1e3)
#define LOST       100.0 /* [V] of a supply that feeds nothing any more */
#define ENCODER    0.0
#define SENSORLESS 1.0

static const char *const sources[] = {"encoder", "sensorless"};

/* ---- every period ---- */

typedef struct {
    double u_most, u_least;  /* true link [V] */
    double current;          /* longest vector [A] */
    double braking;          /* most negative i_q [A] */
    double slowest, fastest; /* true [r/min] */
    double error;            /* largest |theta_hat - theta_e| while running without the encoder [rad] */
    uint32_t periods, off, last_wrong; /* so many; without the bridge; the last one off the wish by 1 r/min */
    double wish;                       /* [r/min] */
    int fault;
    uint32_t fault_at;
    fault_set_t warnings;
} seen_t;

static const char *const rows[] = {"true_u_dc",    "i_alpha",       "i_beta",    "i_q",
                                   "true_omega_m", "theta_hat_err", "state",     "manoeuvre",
                                   "fault_reason", "warnings",      "warnings_2"};
#define ROWS   11u
#define FLOATS 6u

static void look(void *context, uint32_t period, const uint32_t *slots, uint32_t count)
{
    seen_t *seen = context;
    float value[FLOATS];
    (void)period;
    (void)count;
    memcpy(value, slots, sizeof value);
    const double rpm = (double)value[4] / RPM;
    seen->u_most = fmax(seen->u_most, (double)value[0]);
    seen->u_least = fmin(seen->u_least, (double)value[0]);
    seen->current = fmax(seen->current, hypot((double)value[1], (double)value[2]));
    seen->braking = fmin(seen->braking, (double)value[3]);
    seen->slowest = fmin(seen->slowest, rpm);
    seen->fastest = fmax(seen->fastest, rpm);
    seen->periods++;
    seen->off += slots[6] == (uint32_t)DRIVE_READY;
    if (slots[7] == (uint32_t)RUNS) {
        seen->error = fmax(seen->error, fabs((double)value[5]));
    }
    if (fabs(rpm - seen->wish) > 1.0) {
        seen->last_wrong = seen->periods;
    }
    seen->warnings.word[0] |= slots[9];
    seen->warnings.word[1] |= slots[10];
    if (slots[8] != 0u && seen->fault == 0) {
        seen->fault = (int)slots[8];
        seen->fault_at = seen->periods;
    }
}

static void watch(seen_t *seen, double wish)
{
    *seen = (seen_t){.u_least = 1e9, .slowest = 1e9, .fastest = -1e9, .wish = wish};
    run_tap(rig, rows, ROWS, look, seen);
}

static bool warned(const seen_t *seen, fault_bit_t row)
{
    return fault_set_has(seen->warnings, row);
}

static double seconds_of(uint32_t periods)
{
    return periods * RIG_PERIOD_SECONDS;
}

/* 1 mF behind a rectifier of 1 ohm. */
static void soft_link(void)
{
    run_put(rig, "dc_resistance", 1.0);
    run_put(rig, "dc_capacitance", 1e-3);
}

static void expect_healthy(const seen_t *seen)
{
    TEST_ASSERT_EQUAL_INT(0, seen->fault);
    TEST_ASSERT_TRUE(seen->u_most < OVER);
    TEST_ASSERT_TRUE(seen->current < 1.1 * BOARD_CURRENT_LIMIT_MA / 1e3);
}

/* ---- braking ---- */

typedef enum { SLOWER, QUICK_STOP, BRAKES_BY_CURRENT, THE_OTHER_WAY } braking_t;
static const char *const brakings[] = {"slower", "quick stop", "-10 A, then quick stop", "the other way"};

static double wish_of(braking_t how)
{
    return how == SLOWER ? 300.0 : how == THE_OTHER_WAY ? -1500.0 : 0.0;
}

/* From 1500 r/min, with all of the current limit at once (the reference's whole weight). */
static seen_t braked(start_shaft_t shaft, double source, braking_t how, bool soft)
{
    rig_free(rig);
    rig = start_on_desk(shaft, 1u);
    run_put(rig, "position_source", source);
    run_put(rig, "speed_setpoint_weight", 1.0);
    if (soft) {
        soft_link();
    }
    start_running(rig, 1500.0, 0.0, 0.1);
    const double wish = wish_of(how);
    seen_t seen;
    watch(&seen, wish);
    if (how == SLOWER || how == THE_OTHER_WAY) {
        run_put(rig, "speed_request", wish * RPM);
    } else if (how == BRAKES_BY_CURRENT) {
        run_put(rig, "mode", 1.0);
        run_put(rig, "i_q_request", -10.0);
        run_seconds(rig, 0.03);
    }
    if (how == QUICK_STOP || how == BRAKES_BY_CURRENT) {
        run_put(rig, "enable", 2.0);
    }
    run_seconds(rig, 10.0);
    return seen;
}

/* It takes as long as friction and losses need for 785 J, of which the link can have 28; and what the limiter
 * holds back does not wind up: the speed runs past its reference by no more than at a stiff link. The bare
 * motor without an encoder does not follow 10 A at once (3660 rad/s^2) there either: it is caught again. */
static void brake(start_shaft_t shaft, double source, braking_t how)
{
    const double wish = wish_of(how);
    const seen_t stiff = braked(shaft, source, how, false);
    const double losses = rig_value(rig, "lock_losses");
    const seen_t seen = braked(shaft, source, how, true);
    printf("%c %-10s %-22s: up to %.1f of %.0f V, %.2f A, there after %.2f s, to %.0f r/min (stiff: %.0f)\n",
           START_SHAFT_NAMES[shaft], sources[(int)source], brakings[how], seen.u_most, OVER, -seen.braking,
           seconds_of(seen.last_wrong), seen.slowest, stiff.slowest);
    expect_healthy(&seen);
    TEST_ASSERT_TRUE(seen.braking < -9.0);
    TEST_ASSERT_TRUE(seen.u_most > 0.95 * OVER); /* it was the limiter that held it */
    TEST_ASSERT_TRUE(warned(&seen, FAULT_DC_LIMITS));
    TEST_ASSERT_EQUAL_DOUBLE(how == QUICK_STOP || how == BRAKES_BY_CURRENT ? 1.0 : 3.0,
                             rig_value(rig, "state"));
    TEST_ASSERT_DOUBLE_WITHIN(1.0, wish, rig_value(rig, "true_omega_m") / RPM);
    TEST_ASSERT_TRUE(seen.slowest > fmin(stiff.slowest, wish) - 10.0);
    TEST_ASSERT_TRUE(rig_value(rig, "lock_losses") <= losses + 1.0);
}

static void test_braking_into_a_link_without_chopper_stays_below_the_trip(void)
{
    grid_t grid = grid_of("braking into a link", 16u);
    for (uint32_t n; grid_next(&grid, &n);) {
        const start_shaft_t shaft = (start_shaft_t)grid_axis(&n, START_BOTH);
        const double source = grid_axis(&n, 2u) == 0u ? ENCODER : SENSORLESS;
        brake(shaft, source, (braking_t)n);
    }
}

/* ---- a supply that is lost ---- */

static void begin_ride(start_shaft_t shaft, double source, bool soft, double rpm, double load,
                       double ride_time)
{
    rig_free(rig);
    rig = start_on_desk(shaft, 1u);
    run_put(rig, "position_source", source);
    run_put(rig, "ride_through_time", ride_time);
    if (soft) {
        soft_link();
    }
    start_running(rig, rpm, load, 0.1);
}

/* While the rotor has energy the bridge stays on: the angle is never lost, the link never below
 * dc_undervoltage, and the speed comes back by itself. */
static void test_a_rotor_rides_through_300_ms_without_supply(void)
{
    static const double loads[] = {0.0, 2.0, 5.0, 0.0}; /* the last of the bare motor */
    grid_t grid = grid_of("rides through", 8u);
    for (uint32_t n; grid_next(&grid, &n);) {
        const uint32_t source = grid_axis(&n, 2u);
        const start_shaft_t shaft = n < 3u ? HEAVY : LIGHT;
        seen_t seen;
        begin_ride(shaft, source, true, 1500.0, loads[n], 0.5);
        watch(&seen, 1500.0);
        run_put(rig, "dc_voltage", LOST);
        run_seconds(rig, 0.3);
        run_put(rig, "dc_voltage", NOMINAL);
        run_seconds(rig, 3.0);
        const char *const where = run_say("%c %-10s %g N m: down to %.1f V, back %.2f s after the supply, up "
                                          "to %.1f r/min, angle within %.3f "
                                          "rad",
                                          START_SHAFT_NAMES[shaft], sources[source], loads[n], seen.u_least,
                                          seconds_of(seen.last_wrong) - 0.3, seen.fastest, seen.error);
        expect_healthy(&seen);
        TEST_ASSERT_EQUAL_UINT32_MESSAGE(0u, seen.off, where);
        TEST_ASSERT_TRUE_MESSAGE(seen.u_least > UNDER, where);
        TEST_ASSERT_TRUE_MESSAGE(shaft == LIGHT || warned(&seen, FAULT_DC_LIMITS), where);
        TEST_ASSERT_TRUE_MESSAGE(seen.fastest < 1501.5, where);
        TEST_ASSERT_TRUE_MESSAGE(source == 0u || seen.error < 0.076, where);
        TEST_ASSERT_DOUBLE_WITHIN(1.0, 1500.0, rig_value(rig, "true_omega_m") / RPM);
        TEST_ASSERT_EQUAL_DOUBLE(0.0, rig_value(rig, "lock_losses"));
        run_expect_no_fault(rig);
    }
}

/* Without energy the link falls: the bridge opens, and comes on again with the supply, without a command; the
 * rotor is caught turning (600 r/min, a stiff link that leaves the diodes nothing), or started anew (the bare
 * motor, which its load stops). */
static void test_a_link_that_falls_opens_the_bridge_until_it_is_back(void)
{
    grid_t grid = grid_of("falls", 4u);
    for (uint32_t n; grid_next(&grid, &n);) {
        const uint32_t source = grid_axis(&n, 2u);
        const bool stiff = n == 0u;
        const double rpm = stiff ? 600.0 : 1500.0;
        seen_t seen;
        begin_ride(stiff ? HEAVY : LIGHT, source, !stiff, rpm, stiff ? 0.0 : 5.0, 0.5);
        watch(&seen, rpm);
        run_put(rig, "dc_voltage", LOST);
        run_seconds(rig, 0.3);
        const double slowest = seen.slowest;
        run_put(rig, "dc_voltage", NOMINAL);
        run_put(rig, "load_torque", 0.0);
        run_seconds(rig, 4.0);
        const char *const where =
            run_say("%s, %-10s: bridge off for %.0f ms, down to %.0f r/min, back after %.2f s, %.1f A",
                    stiff ? "stiff link, 600 r/min" : "bare motor, 5 N m", sources[source],
                    1e3 * seconds_of(seen.off), slowest, seconds_of(seen.last_wrong) - 0.3, seen.current);
        expect_healthy(&seen);
        TEST_ASSERT_TRUE_MESSAGE(!stiff || (seen.off > DRIVE_PERIODS(0.29f) && slowest > 400.0), where);
        TEST_ASSERT_DOUBLE_WITHIN(1.0, rpm, rig_value(rig, "true_omega_m") / RPM);
        run_expect_no_fault(rig);
    }
}

/* A supply that stays away: dc_undervoltage as ever, but not before ride_through_time is over. A bridge that
 * has opened latches it then; one that the rotor still feeds stops when its energy is gone. */
static void test_a_supply_that_stays_away_is_a_fault_after_its_time(void)
{
    grid_t grid = grid_of("stays away", 4u);
    for (uint32_t n; grid_next(&grid, &n);) {
        const uint32_t source = grid_axis(&n, 2u);
        const bool stiff = n == 0u;
        seen_t seen;
        begin_ride(HEAVY, source, !stiff, stiff ? 600.0 : 1500.0, 0.0, 0.2);
        watch(&seen, 0.0);
        run_put(rig, "dc_voltage", stiff ? LOST : 0.0);
        run_seconds(rig, stiff ? 1.0 : 12.0);
        const char *const where = run_say("%s, %-10s: fault %d after %.3f s", stiff ? "stiff link" : "1 mF",
                                          sources[source], seen.fault, seconds_of(seen.fault_at));
        TEST_ASSERT_EQUAL_INT_MESSAGE(REASON_DC_UNDERVOLTAGE, seen.fault, where);
        if (stiff) {
            TEST_ASSERT_DOUBLE_WITHIN(3e-3, 0.201, seconds_of(seen.fault_at));
        } else {
            /* 785 J beside 207 W of friction at first */
            TEST_ASSERT_TRUE_MESSAGE(seconds_of(seen.fault_at) > 1.0, where);
        }
        TEST_ASSERT_EQUAL_DOUBLE((double)DRIVE_FAULT, rig_value(rig, "state"));
    }
}

/* A rectifier that has lost a phase: two pulses a period of the mains. It goes on, and says so. */
static void test_ripple_of_a_lost_phase_is_told(void)
{
    for (int n = 0; n < 2; n++) {
        seen_t seen;
        const double depth = n == 0 ? 0.15 : 0.05;
        rig_free(rig);
        rig = start_on_desk(HEAVY, 1u);
        start_running(rig, 900.0, 1.0, 0.1);
        watch(&seen, 900.0);
        for (int k = 0; k < 600; k++) {
            run_put(rig, "dc_voltage", NOMINAL * (1.0 - depth * fabs(sin(PI * k / 20.0))));
            rig_run(rig, 5u);
        }
        printf("ripple of %.0f %%: %s\n", 100.0 * depth,
               warned(&seen, FAULT_DC_RIPPLE) ? "told" : "not told");
        TEST_ASSERT_EQUAL(n == 0, warned(&seen, FAULT_DC_RIPPLE));
        run_expect_no_fault(rig);
    }
}

/* ---- heat ---- */

/* i^2 of every period in double, h exact for it. */
typedef struct {
    double heat, per_square, decay; /* [-], [1/A^2], [-] */
    double off, largest, limit;     /* [-], [-], [A] smallest */
    float last;                     /* [-] of the drive's */
} heat_t;

static void warm(void *context, uint32_t period, const uint32_t *slots, uint32_t count)
{
    heat_t *heat = context;
    float value[4];
    (void)period;
    (void)count;
    memcpy(value, slots, sizeof value);
    const double a = (double)value[0], b = (double)value[1];
    const double square = heat->per_square * (4.0 / 3.0) * (a * a + a * b + b * b);
    heat->heat = square + (heat->heat - square) * heat->decay;
    if (value[2] != heat->last) { /* the drive's is held from one step to the next */
        heat->off = fmax(heat->off, fabs((double)value[2] - heat->heat));
        heat->last = value[2];
    }
    heat->largest = fmax(heat->largest, heat->heat);
    heat->limit = fmin(heat->limit, (double)value[3]);
}

static void watch_heat(heat_t *heat, double continuous, double time)
{
    static const char *const names[] = {"true_i_a", "true_i_b", "motor_heat", "i_q_upper"};
    *heat = (heat_t){.per_square = 1.0 / (continuous * continuous),
                     .decay = exp(-RIG_PERIOD_SECONDS / time),
                     .limit = 1e9};
    run_tap(rig, names, 4u, warm, heat);
}

/* A load of 8 A for ever, of a motor that stands 5 A: the torque sags until h = 1, without a trip; the load
 * is friction, so that the shaft stands at last and the whole limit flows. Without the encoder the shaft goes
 * on at the speed where the load, proportional to the speed, fits. h is that of the true currents to 0.4 %.
 */
static void test_an_overload_is_derated_and_does_not_trip(void)
{
    grid_t grid = grid_of("overload", 2u);
    for (uint32_t source; grid_next(&grid, &source);) {
        rig_free(rig);
        rig = start_on_desk(HEAVY, 1u);
        run_put(rig, "fidelity", 1.0);
        run_put(rig, "position_source", source);
        run_put(rig, "motor_current_continuous", 5.0);
        run_put(rig, "motor_time_constant", 2.0);
        run_put(rig, "friction_viscous", (8.0 * TORQUE_PER_AMPERE - 1.32) / (1200.0 * RPM));
        run_put(rig, "friction_coulomb", 0.0);
        start_ready(rig, 0.3);
        rig_set_motion(rig, 0.3 / POLE_PAIRS, 1000.0 * RPM); /* caught turning: a start would need 10 A */
        heat_t heat;
        watch_heat(&heat, 5.0, 2.0);
        run_on(rig, 1200.0);
        run_seconds(rig, 15.0);
        printf("%-10s: h %.4f, off by %.2f %% at most, limit %.2f A, i_q %.2f A, %.0f r/min\n",
               sources[source], heat.heat, 100.0 * heat.off, heat.limit, rig_value(rig, "i_q"),
               rig_value(rig, "true_omega_m") / RPM);
        run_expect_no_fault(rig);
        TEST_ASSERT_TRUE(heat.off < 0.004 * heat.largest); /* asked: 2 % */
        TEST_ASSERT_TRUE(heat.largest < 1.02);
        TEST_ASSERT_DOUBLE_WITHIN(0.003, 1.0, heat.heat);
        TEST_ASSERT_DOUBLE_WITHIN(0.15, 5.0, rig_value(rig, "i_q_ref"));
        const fault_set_t warnings = {
            {(uint32_t)rig_value(rig, "warnings"), (uint32_t)rig_value(rig, "warnings_2")}};
        TEST_ASSERT_TRUE(fault_set_has(warnings, FAULT_DERATING));
        run_put(rig, "speed_request", 300.0 * RPM); /* it cools, and has all again */
        run_seconds(rig, 6.0);
        TEST_ASSERT_EQUAL_DOUBLE(rig_value(rig, "current_limit"), rig_value(rig, "i_q_upper"));
        run_expect_no_fault(rig);
    }
}

/* As it is shipped: 10 A for half a minute are free, -60 s ln(1 - 0.9 0.7^2) = 34.9 s, and then no more. */
static void test_defaults_give_ten_amperes_for_half_a_minute(void)
{
    rig = start_on_desk(HEAVY, 1u);
    run_put(rig, "fidelity", 1.0);
    run_put(rig, "position_source", ENCODER);
    start_ready(rig, 0.3);
    run_put(rig, "friction_viscous", 0.1); /* 9.7 N m at 920 r/min */
    run_put(rig, "mode", 1.0);
    run_put(rig, "i_q_request", 10.0);
    run_put(rig, "enable", 1.0);
    run_seconds(rig, 33.0);
    TEST_ASSERT_EQUAL_DOUBLE(10.0, rig_value(rig, "i_q_upper"));
    run_seconds(rig, 60.0);
    TEST_ASSERT_DOUBLE_WITHIN(0.7, 7.0, rig_value(rig, "i_q"));
    run_expect_no_fault(rig);
}

/* i_d is nobody's torque, and not derated: who asks for it for ever is stopped, motor and module, when h
 * is 1.1.
 */
static void test_who_does_not_heed_the_limit_is_stopped(void)
{
    for (int n = 0; n < 2; n++) {
        seen_t seen;
        rig_free(rig);
        rig = start_on_desk(HEAVY, 1u);
        run_put(rig, "position_source", ENCODER);
        run_put(rig, n == 0 ? "motor_current_continuous" : "module_current_continuous", 5.0);
        run_put(rig, n == 0 ? "motor_time_constant" : "module_time_constant", 1.0);
        start_ready(rig, 0.0);
        run_put(rig, "mode", 1.0);
        run_put(rig, "i_d_request", 8.0);
        watch(&seen, 0.0);
        run_put(rig, "enable", 1.0);
        run_seconds(rig, 5.0);
        const double expected = -log(1.0 - 1.1 * 25.0 / 64.0);
        printf("%s: fault %d after %.3f s, %.3f s by the formula\n", n == 0 ? "motor" : "module", seen.fault,
               seconds_of(seen.fault_at), expected);
        TEST_ASSERT_EQUAL_INT(n == 0 ? REASON_MOTOR_OVERLOAD : REASON_MODULE_OVERLOAD, seen.fault);
        /* the current flows when the request acts: three windows to switch on, two until the setpoint of the
         * operation acts, and it is reached at the end of that */
        const double begun = 5.5 * DRIVE_WINDOW * RIG_PERIOD_SECONDS;
        TEST_ASSERT_DOUBLE_WITHIN(0.01 * expected, expected + begun, seconds_of(seen.fault_at));
    }
}
