/* Starts without an encoder from standstill: from every angle, on three shafts, under every load that the
 * current can turn, under a load with static friction, and with parameters that are wrong as they are
 * after a data sheet, with a warm winding or with an unknown load. Each case is a row of a table, and its
 * points are a grid. The fault matrix contains a shaft that is held (jam). */
#include "host_sim/rig/rig_state.h"
#include "tests/rig/start.h"
#include "tests/rig/the_rig.h"

#define ABOVE_HANDOVER 1.0  /* [r/min] request above handover_speed, below which the frame stays forced */
#define LONGEST        12.0 /* [s] for which a start is observed, with all its tries */
#define SETTLED        0.8  /* [s] for which the motor must run after the hand-over */
#define TORQUE_WINDOW  20u  /* [periods] of the mean before the hand-over and after it */
#define TORQUE_SKIPPED 5u   /* [periods] after the hand-over that are left out */

static start_seen_t seen;
static double asked; /* [r/min] requested speed of the present start */

/* ---- the cases ---- */

/* NOMINAL: the motor runs, within the limits of expect_nominal(). STARTS: the motor runs. ENDS: the start
 * is not guaranteed, for example that of a hoist without a brake; the motor runs, or it has stopped with a
 * fault after start_tries, and no current exceeds the trip. */
typedef enum { NOMINAL, STARTS, ENDS } promise_t;

typedef struct {
    const char *name;
    uint32_t shafts, angles; /* [-] number of angles over an electrical turn */
    uint32_t loads;
    double shares[4]; /* loads as shares of the rated torque */
    double kind;      /* 0 passive, 1 active */
    double sticks;    /* torque at standstill divided by the torque while turning; 0: the shaft creeps */
    bool wrong;       /* all parameters of `wrongs` are wrong */
    promise_t promise;
} start_case_t;

static const start_case_t cases[] = {
    {"test_starts_loads_that_stick", START_ALL, 24u, 4u, {0.0, 0.25, 0.5, 1.0}, 0.0, 1.0, false, NOMINAL},
    {"test_starts_loads_that_creep", START_ALL, 24u, 4u, {0.0, 0.25, 0.5, 1.0}, 0.0, 0.0, false, NOMINAL},
    {"test_starts_active_loads", START_BOTH, 24u, 2u, {0.25, 0.5}, 1.0, 0.0, false, NOMINAL},
    {"test_active_rated_load_runs_or_ends_in_fault", START_BOTH, 24u, 1u, {1.0}, 1.0, 0.0, false, ENDS},
    {"test_starts_with_wrong_parameters", START_BOTH, 8u, 2u, {0.0, 1.0}, 0.0, 0.0, true, STARTS},
    {"test_starts_wrong_and_sticking", START_BOTH, 8u, 2u, {0.5, 1.0}, 0.0, 1.5, true, STARTS},
};

/* The assumed values are the true ones times these factors. For the voltage of the dead time this is a
 * share of T_e/T U_dc + V_0, where T_e is the dead band and the difference of the delays (docs/theory.md,
 * 12). */
static const struct {
    const char *name;
    start_row_t rows[2];
    double dead_time;
    bool promised;
} wrongs[] = {
    {"all right", {{NULL, 0.0}}, 1.0, true},
    {"R +30 %", {{"motor_resistance", 1.3}}, 1.0, true},
    {"R -30 %", {{"motor_resistance", 0.7}}, 1.0, true},
    {"L +20 %", {{"motor_inductance_d", 1.2}, {"motor_inductance_q", 1.2}}, 1.0, true},
    {"L -20 %", {{"motor_inductance_d", 0.8}, {"motor_inductance_q", 0.8}}, 1.0, true},
    {"psi_f +10 %", {{"motor_flux_linkage", 1.1}}, 1.0, true},
    {"psi_f -10 %", {{"motor_flux_linkage", 0.9}}, 1.0, true},
    {"J x 2", {{"motor_inertia", 2.0}}, 1.0, true},
    {"J x 0.5", {{"motor_inertia", 0.5}}, 1.0, true},
    {"dead time +20 %", {{NULL, 0.0}}, 1.2, true},
    {"dead time -20 %", {{NULL, 0.0}}, 0.8, true},
    {"dead time -40 %", {{NULL, 0.0}}, 0.6, true},
    {"dead time +40 %", {{NULL, 0.0}}, 1.4, false},
    {"dead time unknown", {{NULL, 0.0}}, 0.0, false},
};
#define WRONGS (sizeof wrongs / sizeof wrongs[0])

static void put_wrong(uint32_t n)
{
    TEST_ASSERT_TRUE(rig_apply(rig));
    for (uint32_t r = 0; r < 2u && wrongs[n].rows[r].name != NULL; r++) {
        run_times(rig, wrongs[n].rows[r].name, wrongs[n].rows[r].value);
    }
    const double on = rig_value(rig, "params.turn_on_delay"), off = rig_value(rig, "params.turn_off_delay");
    const double missing = (1.0 - wrongs[n].dead_time) * (rig_value(rig, "dead_time") + on - off);
    run_put(rig, "params.turn_off_delay", off + fmax(missing, 0.0));
    run_put(rig, "params.turn_on_delay", on - fmin(missing, 0.0));
    run_times(rig, "params.device_drop", wrongs[n].dead_time);
}

/* ---- one start ---- */

/* Values from the last hand-over on. A rotor that was caught turning backwards has no hand-over; its
 * values begin when it has reached the requested speed. */
typedef struct {
    double begin;      /* [s] time of the hand-over */
    double torque[2];  /* [N m] means before and after the hand-over */
    double dip, error; /* [r/min] largest lack of speed, [rad] largest angle error */
    uint32_t periods;  /* number of periods since then */
    bool handed_over;
    bool judged;
} start_end_t;

static void judge(start_end_t *end, uint32_t now, int before, const double torque[TORQUE_WINDOW])
{
    if (seen.manoeuvre != RUNS) {
        end->judged = false;
        return;
    }
    const bool handed_over = before == HANDS_OVER;
    if (!end->judged && (handed_over || seen.speed > 0.95 * asked)) {
        *end = (start_end_t){.begin = start_time(now), .judged = true, .handed_over = handed_over};
        for (uint32_t n = 0; n < TORQUE_WINDOW; n++) {
            end->torque[0] += torque[n] / TORQUE_WINDOW;
        }
    }
    if (end->judged) {
        end->periods++;
        if (end->periods > TORQUE_SKIPPED && end->periods <= TORQUE_WINDOW) {
            end->torque[1] += seen.torque / (TORQUE_WINDOW - TORQUE_SKIPPED);
        }
        start_raise(&end->dip, asked - seen.speed);
        start_raise(&end->error, fabs(seen.error));
    }
}

/* Runs until the motor has run for long enough or has stopped; returns the largest current [A]. */
static double watch_start(start_end_t *end)
{
    double torque[TORQUE_WINDOW] = {0}, current = 0.0;
    for (uint32_t n = 0; n < rig_periods(LONGEST) && seen.fault == 0; n++) {
        const int before = seen.manoeuvre;
        rig_step(rig);
        start_raise(&current, seen.current);
        judge(end, n, before, torque);
        torque[n % TORQUE_WINDOW] = seen.torque;
        if (end->judged && end->periods > rig_periods(SETTLED)) {
            break;
        }
    }
    return current;
}

/* The value that the drive derives from its parameters [r/min]. */
static double handover_speed(void)
{
    const manoeuvres_limits_t *limits = &rig_state(rig)->app.drive.medium.manoeuvres.limits;
    return (double)limits->handover_speed / POLE_PAIRS / RPM;
}

/* The requirements are 2 s until the hand-over, 11 A, 15 r/min, an angle error of 120 mrad and a torque
 * step of 1 N m. The largest measured angle error in the grid is 43 mrad, the largest torque step 0.5 N m. */
static void expect_nominal(const start_end_t *end, double current, const char *where)
{
    TEST_ASSERT_TRUE_MESSAGE(end->begin <= 2.0, where);
    TEST_ASSERT_TRUE_MESSAGE(current <= 11.0, where);
    TEST_ASSERT_TRUE_MESSAGE(end->dip <= 15.0, where);
    TEST_ASSERT_TRUE_MESSAGE(end->error <= 56e-3, where);
    TEST_ASSERT_TRUE_MESSAGE(!end->handed_over || fabs(end->torque[1] - end->torque[0]) <= 0.65, where);
}

static void expect_start(const start_case_t *of, start_shaft_t shaft, double load, uint32_t wrong,
                         double theta_e)
{
    const start_shaft_data_t *const data = &start_shaft_data[shaft];
    rig_free(rig);
    rig = start_on_desk(shaft, 1u);
    put_wrong(wrong);
    /* The plant adds a passive load to its break-away torque. */
    run_put(rig, "friction_breakaway", of->sticks > 0.0 ? of->sticks * (data->friction + load) - load : 0.0);
    run_put(rig, "load_kind", of->kind);
    start_ready(rig, theta_e);
    run_put(rig, "load_torque", load);
    start_watch(rig, &seen);
    asked = handover_speed() + ABOVE_HANDOVER;
    run_on(rig, asked);
    start_end_t end = {0};
    const double current = watch_start(&end);
    const char *const where =
        run_say("start %c, %.2f N m, %s, %.0f deg: %.2f s, %.2f A, dip %.1f r/min, error %.0f mrad, torque "
                "step %.2f N m, try %d, fault %d",
                START_SHAFT_NAMES[shaft], load, wrongs[wrong].name, theta_e * 180.0 / PI, end.begin, current,
                end.dip, 1e3 * end.error, fabs(end.torque[1] - end.torque[0]), seen.start_try, seen.fault);
    const bool runs = end.judged && end.periods > rig_periods(SETTLED);
    if (of->promise == ENDS || !wrongs[wrong].promised) {
        TEST_ASSERT_TRUE_MESSAGE(runs || seen.fault != 0, where);
        TEST_ASSERT_TRUE_MESSAGE(current < rig_value(rig, "overcurrent_trip"), where);
        return;
    }
    TEST_ASSERT_TRUE_MESSAGE(runs, where);
    if (of->promise == NOMINAL) {
        expect_nominal(&end, current, where);
    }
}

static const start_case_t *under_test;

static void starts(void)
{
    const start_case_t *const of = under_test;
    const uint32_t wrong_rows = of->wrong ? WRONGS : 1u;
    grid_t grid = grid_of(of->name, of->shafts * of->loads * wrong_rows * of->angles);
    for (uint32_t n; grid_next(&grid, &n);) {
        const start_shaft_t shaft = (start_shaft_t)grid_axis(&n, of->shafts);
        const double load = of->shares[grid_axis(&n, of->loads)] * RATED_TORQUE;
        const uint32_t wrong = grid_axis(&n, wrong_rows);
        expect_start(of, shaft, load, wrong, 2.0 * PI * n / of->angles);
    }
}

int main(void)
{
    UNITY_BEGIN();
    for (size_t n = 0; n < sizeof cases / sizeof cases[0]; n++) {
        under_test = &cases[n];
        seed_run(starts, under_test->name, __LINE__, 1u);
    }
    return UNITY_END();
}
