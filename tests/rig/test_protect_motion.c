/* Encoder and motion watched in the closed loop, on both shafts: every fault that plant and rig have of the
 * encoder and of the shaft, at a start, slow and fast, both ways: the reason, when it is noticed, the largest
 * true phase current. And nothing of it in healthy runs.
 *
 * "Noticed within" is 20 ms or a third of an electrical turn of the rotor, whichever is longer, from when the
 * fault shows: an angle that has gone by 0.64 rad, or a shaft that has begun to move. Below the hand-over's
 * speed the EMF does not tell: there a torque that is gone is a stall, after its time. */
#include "settings/reasons.h"
#include "tests/rig/no_rig.h"
#include "tests/rig/start.h"

#define CURRENT_MOST 25.0 /* [A] */
#define UNLOADED     0.15 /* [s] until the current of a wrong angle lets the least EMF be judged */

/* ---- the faults ---- */

typedef enum {
    HALF_TURN,
    QUARTER_TURN,
    THIRD_TURN,
    SLIPS_A_LITTLE,
    SLIPS_BY_HALF,
    STANDS,
    REVERSED,
    SWAPPED,
    FAULTS_OF_ENCODER
} fault_t;

static const char *const names[] = {"half a turn", "quarter turn", "third of a turn", "loses 10 %",
                                    "loses half",  "stands",       "tracks swapped",  "phases swapped"};

static void inject(rig_t *rig, fault_t fault)
{
    static const double turns[] = {0.5, 0.25, 1.0 / 3.0};
    switch (fault) {
    case HALF_TURN:
    case QUARTER_TURN:
    case THIRD_TURN:
        run_put(rig, "plant.encoder_offset", 2.0 * PI * turns[fault] / POLE_PAIRS);
        break;
    case SLIPS_A_LITTLE:
        run_put(rig, "encoder_slip", 0.1);
        break;
    case SLIPS_BY_HALF:
        run_put(rig, "encoder_slip", 0.5);
        break;
    case STANDS:
        run_put(rig, "encoder_slip", 1.0);
        break;
    case REVERSED:
        run_put(rig, "encoder_reversed", 1.0);
        break;
    case SWAPPED:
        run_put(rig, "swap_phases", 1.0);
        break;
    case FAULTS_OF_ENCODER:
        break;
    }
}

/* With the encoder, ready at this angle. */
static rig_t *ready(start_shaft_t shaft, uint32_t seed, double reaction)
{
    rig_t *rig = start_on_desk(shaft, seed);
    run_put(rig, "position_source", 0.0);
    run_put(rig, "encoder_fault_reaction", reaction);
    start_ready(rig, 0.3);
    return rig;
}

/* ---- noticed in time, with the right reason ---- */

typedef struct {
    double time, current, bad; /* [s], [A], [s] */
    int stalled;
} worst_t;

static bool is_of_encoder(int reason)
{
    return reason == REASON_ENCODER_JUMP || reason == REASON_ENCODER_DIRECTION ||
           reason == REASON_ENCODER_MISMATCH || reason == REASON_RUNAWAY;
}

/* What a wrong frame does to the currents may be an overcurrent, or resemble a broken wire, first: one in
 * twenty. Of so many runs that is, with three standard deviations of a count, at most so many. */
static bool one_in_twenty(uint32_t count, uint32_t runs)
{
    const double expected = runs / 20.0;
    return count <= expected + 3.0 * sqrt(expected);
}

static uint32_t by_currents;

static bool told_by_currents(int fault)
{
    const bool of_currents = fault == REASON_PHASE_LOSS || fault == REASON_OVERCURRENT;
    by_currents += of_currents ? 1u : 0u;
    return of_currents;
}

/* From when the angle in use is wrong by 0.64 rad: seconds until it is noticed. */
static void under_way(start_shaft_t shaft, fault_t fault, double rpm, double load, worst_t *worst)
{
    rig_t *rig = ready(shaft, 7u + (uint32_t)fault, 0.0);
    start_seen_t seen;
    run_on(rig, rpm);
    run_seconds(rig, 1.2);
    if (load > 0.0) {
        run_load(rig, load, 0.5 * load);
        run_seconds(rig, 0.3);
    }
    run_expect_no_fault(rig);
    start_watch(rig, &seen);
    inject(rig, fault);
    uint32_t shows = 0u;
    for (uint32_t n = 0; n < 35000u && seen.noticed == 0u; n++) {
        rig_run(rig, 1u);
        if (shows == 0u && (fabs(seen.err) > 0.64)) {
            shows = seen.period;
        }
    }
    char where[96];
    (void)snprintf(where, sizeof where, "%s, %c, %.0f r/min, %.0f N m: %d", names[fault],
                   START_SHAFT_NAMES[shaft], rpm, load, seen.fault);
    const double time = start_time(seen.noticed - (shows != 0u ? shows : seen.noticed));
    const double third = 2.0 * PI / 3.0 / (POLE_PAIRS * fabs(rpm) * RPM);
    /* at the edge of what the EMF tells the rotor stops before the angle has gone: it stands */
    if (seen.fault == REASON_STALLED && fabs(rpm) < 200.0) {
        TEST_ASSERT_TRUE_MESSAGE(time < 3.0, where);
        worst->stalled++;
    } else {
        TEST_ASSERT_TRUE_MESSAGE(is_of_encoder(seen.fault) || told_by_currents(seen.fault), where);
        /* Without a load hardly a current flows, and only twice the least EMF is judged: below its speed the
         * sign comes with the current that the wrong angle makes, 115 +- 6 ms later over 16 runs. */
        const double most = load == 0.0 && fabs(rpm) < 300.0 ? UNLOADED : fmax(20e-3, third);
        TEST_ASSERT_TRUE_MESSAGE(time <= most, where);
        start_raise(&worst->time, time);
    }
    TEST_ASSERT_TRUE_MESSAGE(seen.peak <= CURRENT_MOST, where);
    start_raise(&worst->current, seen.peak);
    rig_free(rig);
}

static void test_a_wrong_encoder_is_noticed_under_way(void)
{
    static const double speeds[] = {150.0, -150.0, 600.0, -600.0, 1500.0, -1500.0};
    uint32_t runs = 0u;
    by_currents = 0u;
    for (fault_t fault = HALF_TURN; fault < FAULTS_OF_ENCODER; fault++) {
        if (fault == SWAPPED || fault == REVERSED) {
            continue; /* nobody swaps wires under way */
        }
        worst_t worst = {0};
        grid_t grid = grid_of(names[fault], 24u);
        for (uint32_t n; grid_next(&grid, &n); runs++) {
            under_way(n < 12u ? HEAVY : LIGHT, fault, speeds[n % 6u], n % 12u < 6u ? 0.0 : 5.0, &worst);
        }
        printf("%-16s under way: noticed after %4.1f ms at most, %4.1f A; %d stand and stall\n", names[fault],
               1e3 * worst.time, worst.current, worst.stalled);
    }
    printf("told as a wire first: %u of %u\n", (unsigned)by_currents, (unsigned)runs);
    TEST_ASSERT_TRUE(one_in_twenty(by_currents, runs));
}

/* Wrong from the start: what cannot turn the rotor stalls; else it is noticed before the rotor has got to
 * twice the hand-over's speed, and after no more than a third of an electrical turn or 20 ms where the EMF
 * tells or the torque pushes the wrong way. */
static void test_a_wrong_encoder_is_noticed_at_a_start(void)
{
    grid_t grid = grid_of("wrong at a start", 4u * FAULTS_OF_ENCODER);
    for (uint32_t n; grid_next(&grid, &n);) {
        const uint32_t number = n;
        const start_shaft_t shaft = (start_shaft_t)grid_axis(&n, START_BOTH);
        const double rpm = grid_axis(&n, 2u) == 0u ? 600.0 : -600.0;
        rig_t *rig = ready(shaft, 70u + number, 0.0);
        start_seen_t seen;
        inject(rig, (fault_t)n);
        run_seconds(rig, 0.03);
        start_watch(rig, &seen);
        run_on(rig, rpm);
        const uint32_t begun = (uint32_t)rig_value(rig, "period");
        uint32_t fast = 0u;
        for (uint32_t m = 0; m < 40000u && seen.noticed == 0u; m++) {
            rig_run(rig, 1u);
            fast = fast == 0u && fabs(seen.speed) > 143.0 && fabs(seen.err) > 0.64 ? seen.period : fast;
        }
        const double time = fast != 0u ? start_time(seen.noticed - fast) : 0.0;
        const char *const where =
            run_say("%s at a start, %c, %.0f r/min: fault %d, %.1f ms after its EMF tells, %.1f A", names[n],
                    START_SHAFT_NAMES[shaft], rpm, seen.fault, 1e3 * time, seen.peak);
        TEST_ASSERT_TRUE_MESSAGE(is_of_encoder(seen.fault) || seen.fault == REASON_STALLED, where);
        TEST_ASSERT_TRUE_MESSAGE(seen.peak <= CURRENT_MOST, where);
        if (seen.fault == REASON_STALLED) {
            TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(0.4, 2.2, start_time(seen.noticed - begun), where);
        } else {
            TEST_ASSERT_TRUE_MESSAGE(time <= 20e-3, where);
        }
        rig_free(rig);
    }
}

/* ---- on without the encoder ---- */

static void test_a_motor_whose_encoder_fails_goes_on_without(void)
{
    static const double speeds[] = {300.0, -300.0, 600.0, -600.0, 1500.0, -1500.0};
    worst_t worst = {0};
    double off = 0.0;
    uint32_t runs = 0u;
    uint32_t wires = 0u; /* stopped by what the wrong frame does to the currents */
    for (fault_t fault = HALF_TURN; fault <= STANDS; fault++) {
        char name[40];
        (void)snprintf(name, sizeof name, "on without: %s", names[fault]);
        grid_t grid = grid_of(name, 24u);
        for (uint32_t n; grid_next(&grid, &n);) {
            const double rpm = speeds[n % 6u];
            rig_t *rig = ready(n < 12u ? HEAVY : LIGHT, 7u + n, 1.0);
            start_seen_t seen;
            run_on(rig, rpm);
            run_seconds(rig, 1.2);
            if (n % 12u >= 6u) {
                run_load(rig, 3.0, 1.5);
                run_seconds(rig, 0.3);
            }
            start_watch(rig, &seen);
            inject(rig, fault);
            run_seconds(rig, 1.5);
            char where[96];
            (void)snprintf(where, sizeof where, "%s, %u, %.0f r/min: fault %d, %.0f r/min", names[fault],
                           (unsigned)n, rpm, seen.fault, seen.speed);
            runs++;
            if (seen.fault == REASON_PHASE_LOSS || seen.fault == REASON_OVERCURRENT) {
                wires++;
                rig_free(rig);
                continue;
            }
            TEST_ASSERT_EQUAL_INT_MESSAGE(0, seen.fault, where);
            TEST_ASSERT_TRUE_MESSAGE(seen.noticed != 0u, where);
            TEST_ASSERT_EQUAL_INT_MESSAGE(RUNS, seen.manoeuvre, where);
            TEST_ASSERT_TRUE_MESSAGE(fabs(seen.speed - rpm) < 3.0, where);
            TEST_ASSERT_TRUE_MESSAGE(fabs(seen.err) < 0.1, where);
            TEST_ASSERT_TRUE_MESSAGE(seen.bad_most < 38e-3, where);
            TEST_ASSERT_TRUE_MESSAGE(seen.peak <= CURRENT_MOST, where);
            TEST_ASSERT_TRUE_MESSAGE(rig_value(rig, "warnings") != 0.0, where);
            start_raise(&worst.current, seen.peak);
            start_raise(&worst.bad, seen.bad_most);
            start_raise(&off, fabs(seen.speed - rpm));
            /* a quick stop still stops it, and off forgets the encoder's fault */
            run_put(rig, "load_torque", 0.0);
            run_put(rig, "enable", 2.0);
            run_seconds(rig, 2.0);
            TEST_ASSERT_EQUAL_DOUBLE(1.0, rig_value(rig, "state"));
            TEST_ASSERT_TRUE_MESSAGE(fabs(seen.speed) < 60.0, where);
            TEST_ASSERT_EQUAL_DOUBLE(0.0, rig_value(rig, "warnings"));
            rig_free(rig);
        }
    }
    printf(
        "on without the encoder: %u of %u, %4.1f A, angle wrong by 0.8 rad for %4.1f ms, %3.1f r/min off\n",
        (unsigned)(runs - wires), (unsigned)runs, worst.current, 1e3 * worst.bad, off);
    TEST_ASSERT_TRUE(one_in_twenty(wires, runs));
}

/* ---- stall and overload, by their times ---- */

/* A passive load that holds either shaft; and a hoist that is pulled down by more than the motor holds. */
static void test_a_held_or_overloaded_shaft_stops_the_drive_after_its_time(void)
{
    grid_t grid = grid_of("held or overloaded", 6u);
    for (uint32_t n; grid_next(&grid, &n);) {
        const double way = grid_axis(&n, 2u) == 0u ? 1.0 : -1.0;
        const bool hoist = n == 2u;
        rig_t *rig = ready(n == 1u ? LIGHT : HEAVY, 5u, 0.0);
        start_seen_t seen;
        run_put(rig, "stall_time", hoist ? 2.0 : 0.5);
        run_put(rig, "fault_stop_time", hoist ? 0.3 : 5.0);
        run_parameter(rig, "speed_error_time", hoist ? 0.5 : 1.0);
        run_on(rig, way * 600.0);
        run_seconds(rig, 1.2);
        start_watch(rig, &seen);
        run_put(rig, "load_kind", hoist ? 1.0 : 0.0);
        run_put(rig, "load_torque", hoist ? way * 12.5 : 30.0);
        run_seconds(rig, 2.0);
        TEST_ASSERT_EQUAL_INT(hoist ? REASON_SPEED_ERROR : REASON_STALLED, seen.first_fault);
        TEST_ASSERT_TRUE(seen.peak <= CURRENT_MOST);
        rig_free(rig);
    }
}

/* In current mode a rotor that stands is what was asked for; and the quick stop out of it stops. */
static void test_current_mode_may_hold_a_standing_rotor(void)
{
    rig_t *rig = ready(HEAVY, 5u, 0.0);
    run_put(rig, "load_torque", 30.0);
    run_put(rig, "mode", 1.0);
    run_put(rig, "i_q_request", 10.0);
    run_put(rig, "enable", 1.0);
    run_seconds(rig, 8.0);
    run_expect_no_fault(rig);
    run_put(rig, "load_torque", 0.0);
    run_seconds(rig, 0.5);
    run_put(rig, "enable", 2.0);
    run_seconds(rig, 1.0);
    TEST_ASSERT_EQUAL_DOUBLE(1.0, rig_value(rig, "state"));
    TEST_ASSERT_TRUE(fabs(rig_value(rig, "true_omega_m")) < 3.0);
    rig_free(rig);
}

/* ---- a load step that stalls the light rotor, without encoder ---- */

static void test_a_rotor_stalled_by_a_load_step_is_caught(void)
{
    static const double loads[] = {3.0, 6.0, 9.0};
    static const double speeds[] = {70.0, 100.0, 150.0};
    double bad = 0.0, current = 0.0;
    grid_t grid = grid_of("stalled by a load step", 36u);
    for (uint32_t n; grid_next(&grid, &n);) {
        const double way = n % 2u == 0u ? 1.0 : -1.0;
        rig_t *rig = start_on_desk(LIGHT, 1u + n);
        start_seen_t seen;
        start_ready(rig, 0.35 * n);
        run_on(rig, way * 300.0);
        run_seconds(rig, 1.5);
        run_put(rig, "speed_request", way * speeds[n % 3u] * RPM);
        run_seconds(rig, 1.0);
        TEST_ASSERT_EQUAL_DOUBLE(RUNS, rig_value(rig, "manoeuvre"));
        start_watch(rig, &seen);
        run_put(rig, "load_torque", loads[n / 12u]);
        double lost = 0.0;
        for (int m = 0; m < 5000; m++) {
            rig_run(rig, 1u);
            lost = seen.manoeuvre == RUNS && fabs(seen.err) > 0.8 ? lost + RIG_PERIOD_SECONDS : 0.0;
            bad = fmax(bad, lost);
        }
        TEST_ASSERT_TRUE(seen.losses >= 1 || fabs(seen.speed) > 20.0);
        current = fmax(current, seen.peak);
        rig_free(rig);
    }
    printf("stalled by a load step: angle wrong by 0.8 rad for %.1f ms without a reaction, %.1f A\n",
           1e3 * bad, current);
    TEST_ASSERT_TRUE(bad < 5e-3);
    TEST_ASSERT_TRUE(current <= 13.5);
}

/* ---- nothing of it in healthy runs ---- */

static uint32_t dice;

static double throw(void)
{
    dice = dice * UINT32_C(1664525) + UINT32_C(1013904223);
    return (double)(dice >> 8) / 16777216.0;
}

static const char *const own[] = {"encoder", "sensorless"};

/* Something happens to the drive: another speed, a load that comes or goes, a current for a while, a quick
 * stop, off and on. What turns a shaft that nobody drives is taken off first. */
static void something(rig_t *rig, bool active)
{
    const double what = throw();
    if (what < 0.4) {
        run_put(rig, "speed_request", (throw() - 0.5) * (throw() < 0.5 ? 3000.0 : 600.0) * RPM);
    } else if (what < 0.75) {
        run_put(rig, "load_torque", 5.0 * (active && throw() < 0.5 ? -throw() : throw()));
    } else if (what < 0.85) {
        run_put(rig, "load_torque", 0.0);
        run_put(rig, "enable", 2.0);
        run_seconds(rig, 0.7);
        run_put(rig, "enable", 0.0);
        run_seconds(rig, 0.1);
        run_put(rig, "enable", 1.0);
    } else {
        run_put(rig, "load_torque", 0.0);
        run_put(rig, "enable", 0.0);
        run_seconds(rig, 0.02 + 0.05 * throw());
        run_put(rig, "enable", 1.0); /* the rotor turns: caught without encoder */
    }
    run_seconds(rig, 0.1 + 0.6 * throw());
}

static void test_healthy_runs_raise_nothing(void)
{
    static const double beliefs[] = {1.0, 1.0, 0.5, 2.0}; /* of J */
    for (int source = 0; source < 2; source++) {
        int runs = 0;
        grid_t grid = grid_of(own[source], 264u);
        for (uint32_t n; grid_next(&grid, &n);) {
            const start_shaft_t shaft = (start_shaft_t)(n % 3u);
            const bool active = source == 0 && n % 2u == 1u;
            dice = 7919u * n + 17u;
            rig_t *rig = start_on_desk(shaft, n + 1u);
            start_seen_t seen;
            run_put(rig, "position_source", source);
            if (source == 0) {
                run_put(rig, "motor_inertia", beliefs[n / 3u % 4u] * start_shaft_data[shaft].inertia);
            }
            start_ready(rig, 6.0 * throw());
            run_put(rig, "load_kind", active ? 1.0 : 0.0);
            start_watch(rig, &seen);
            run_on(rig, (throw() - 0.5) * 3000.0);
            run_seconds(rig, 1.0);
            for (int m = 0; m < 8 && seen.noticed == 0u; m++) {
                something(rig, active);
            }
            char where[96];
            (void)snprintf(where, sizeof where, "%s %u: fault %d, warnings %x", own[source], n, seen.fault,
                           (unsigned)seen.warnings);
            const bool of_start =
                source == 1 && (seen.fault == REASON_START_STALLED || seen.fault == REASON_START_UNLOCKED ||
                                seen.fault == REASON_LOCK_LOST);
            const bool true_one = seen.fault == REASON_OVERSPEED; /* the load drives it there */
            TEST_ASSERT_TRUE_MESSAGE(seen.noticed == 0u || of_start || true_one, where);
            runs++;
            rig_free(rig);
        }
        printf("%s: %d healthy runs, no alarm\n", own[source], runs);
    }
}
