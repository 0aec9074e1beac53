/* Starting without an encoder from standstill, on both shafts: every angle, every load that the current can
 * turn, wrong parameters, a load that sticks, a shaft that is held. Grids; each prints what it measured. */
#include "drive/reasons.h"
#include "host_sim/rig/rig_state.h"
#include "tests/rig/start.h"

#define ABOVE_HANDOVER 1.0  /* [r/min] asked for beyond handover_speed: below it the frame stays forced */
#define LONGEST        12.0 /* [s] that a start is watched, all its tries */
#define SETTLED        0.8  /* [s] after hand-over that it must last */
#define TORQUE_WINDOW  20u  /* [periods] before hand-over, and after it */
#define TORQUE_SKIPPED 5u   /* [periods] of those after it */

static rig_t *rig;
static start_seen_t seen;
static double asked; /* [r/min] of the start under way */

void setUp(void)
{
    rig = NULL;
}

void tearDown(void)
{
    rig_free(rig);
}

/* ---- one start ---- */

typedef struct {
    start_shaft_t shaft;
    double load;             /* [N m] */
    double kind;             /* 0 passive, 1 active */
    const start_row_t *rows; /* changed, up to the first without a name; NULL: none */
} start_case_t;

/* Largest of a grid; good: handed over and running to the end. */
typedef struct {
    uint32_t tried, good, caught, ended; /* [-] `ended`: by a fault, which leaves no current */
    double time, current, dip, error, step, tries;
} start_grid_t;

/* From the last hand-over on; a rotor that was caught turning backwards has none, there it is from the speed
 * asked for on. */
typedef struct {
    double begin;      /* [s] */
    double torque[2];  /* [N m] means before and after */
    double dip, error; /* [r/min], [rad] */
    uint32_t periods;  /* since */
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

static void add(start_grid_t *grid, const start_end_t *end)
{
    grid->good++;
    grid->caught += !end->handed_over;
    start_raise(&grid->time, end->begin);
    start_raise(&grid->dip, end->dip);
    start_raise(&grid->error, 1e3 * end->error);
    if (end->handed_over) {
        start_raise(&grid->step, fabs(end->torque[1] - end->torque[0]));
    }
}

/* What the drive has made of its parameters [r/min]. */
static double handover_speed(void)
{
    const manoeuvres_limits_t *limits = &rig_state(rig)->app.drive.manoeuvres.limits;
    return (double)limits->handover_speed / POLE_PAIRS / RPM;
}

static void start(start_grid_t *grid, const start_case_t *what, double theta_e, uint32_t seed)
{
    rig_free(rig);
    rig = start_on_desk(what->shaft, seed);
    for (const start_row_t *row = what->rows; row != NULL && row->name != NULL; row++) {
        run_put(rig, row->name, row->value);
    }
    run_put(rig, "load_kind", what->kind);
    start_ready(rig, theta_e);
    run_put(rig, "load_torque", what->load);
    start_watch(rig, &seen);
    asked = handover_speed() + ABOVE_HANDOVER;
    run_on(rig, asked);
    start_end_t end = {0};
    double torque[TORQUE_WINDOW] = {0};
    grid->tried++;
    for (uint32_t n = 0; n < rig_periods(LONGEST) && seen.fault == 0; n++) {
        const int before = seen.manoeuvre;
        rig_step(rig);
        start_raise(&grid->current, seen.current);
        start_raise(&grid->tries, seen.start_try);
        judge(&end, n, before, torque);
        torque[n % TORQUE_WINDOW] = seen.torque;
        if (end.judged && end.periods > rig_periods(SETTLED)) {
            add(grid, &end);
            return;
        }
    }
    grid->ended += seen.fault != 0;
}

/* So many angles, evenly over an electrical turn. */
static start_grid_t starts(const start_case_t *what, uint32_t angles)
{
    start_grid_t grid = {0};
    for (uint32_t n = 0; n < angles; n += START_THINNED) {
        start(&grid, what, 2.0 * PI * n / angles, 1u + n);
    }
    return grid;
}

static void print(const start_case_t *what, const char *name, const start_grid_t *grid)
{
    printf("start %c, %.2f N m %s, %s: %u/%u, <= %.2f s, %.2f A, dip %.1f r/min, error %.0f mrad, torque "
           "step %.2f "
           "N m, tries %.0f, caught turning %u\n",
           START_SHAFT_NAMES[what->shaft], what->load, what->kind > 0.0 ? "active" : "passive", name,
           grid->good, grid->tried, grid->time, grid->current, grid->dip, grid->error, grid->step,
           grid->tries, grid->caught);
}

static void expect_nominal(const start_grid_t *grid)
{
    TEST_ASSERT_EQUAL_UINT32(grid->tried, grid->good);
    TEST_ASSERT_TRUE(grid->time <= 2.0);
    TEST_ASSERT_TRUE(grid->current <= 11.0);
    TEST_ASSERT_TRUE(grid->dip <= 15.0);
    TEST_ASSERT_TRUE(grid->error <= 120.0);
    TEST_ASSERT_TRUE(grid->step <= 1.0);
}

static start_grid_t start_and_print(start_shaft_t shaft, double load, double kind)
{
    const start_case_t what = {shaft, load, kind, NULL};
    const start_grid_t grid = starts(&what, 24u);
    print(&what, "24 angles", &grid);
    return grid;
}

static void test_starts_from_every_angle_under_every_passive_load(void)
{
    static const start_shaft_t shafts[] = {HEAVY, LIGHT, BARE};
    static const double shares[] = {0.0, 0.25, 0.5, 1.0};
    start_grid_t grids[3][4];
    for (size_t s = 0; s < 3u; s++) {
        for (size_t n = 0; n < 4u; n++) {
            grids[s][n] = start_and_print(shafts[s], shares[n] * RATED_TORQUE, 0.0);
        }
    }
    for (size_t s = 0; s < 3u; s++) {
        for (size_t n = 0; n < 4u; n++) {
            expect_nominal(&grids[s][n]);
        }
    }
}

static void test_starts_against_an_active_load_of_half_the_rated_torque(void)
{
    start_grid_t grids[2][2];
    for (size_t s = 0; s < 2u; s++) {
        grids[s][0] = start_and_print((start_shaft_t)s, 0.25 * RATED_TORQUE, 1.0);
        grids[s][1] = start_and_print((start_shaft_t)s, 0.5 * RATED_TORQUE, 1.0);
    }
    for (size_t s = 0; s < 2u; s++) {
        expect_nominal(&grids[s][0]);
        expect_nominal(&grids[s][1]);
    }
}

/* A hoist without a brake is not promised to start. Whatever becomes of it: it runs, or tries again within
 * start_tries, or has stopped with a fault; and no current is beyond the trip. */
static void test_active_load_of_the_rated_torque_ends_in_run_or_fault(void)
{
    for (size_t s = 0; s < 2u; s++) {
        const start_grid_t grid = start_and_print((start_shaft_t)s, RATED_TORQUE, 1.0);
        TEST_ASSERT_EQUAL_UINT32(grid.tried, grid.good + grid.ended);
        TEST_ASSERT_TRUE(grid.current < rig_value(rig, "overcurrent_trip"));
    }
}

/* ---- wrong parameters ---- */

#define ROWS 4u

typedef struct {
    const char *name;
    start_row_t rows[ROWS]; /* factors; the last has no name */
} wrong_t;

/* The dead time's voltage as the firmware believes it, times this factor: T_e/T U_dc + V_0 with T_e the dead
 * band and the difference of the delays (docs/theory.md, 12). */
static void put_dead_time_share(start_row_t rows[ROWS], double factor)
{
    rig_t *const desk = rig_create(1u);
    const double on = rig_value(desk, "params.turn_on_delay");
    const double off = rig_value(desk, "params.turn_off_delay");
    const double missing = (1.0 - factor) * (rig_value(desk, "dead_time") + on - off);
    rows[0] = missing > 0.0 ? (start_row_t){"params.turn_off_delay", off + missing}
                            : (start_row_t){"params.turn_on_delay", on - missing};
    rows[1] = (start_row_t){"params.device_drop", factor * rig_value(desk, "params.device_drop")};
    rows[2] = (start_row_t){NULL, 0.0};
    rig_free(desk);
}

static const wrong_t wrong[] = {
    {"R +30 %", {{"motor_resistance", 1.3}}},
    {"R -30 %", {{"motor_resistance", 0.7}}},
    {"L +20 %", {{"motor_inductance_d", 1.2}, {"motor_inductance_q", 1.2}}},
    {"L -20 %", {{"motor_inductance_d", 0.8}, {"motor_inductance_q", 0.8}}},
    {"psi_f +10 %", {{"motor_flux_linkage", 1.1}}},
    {"psi_f -10 %", {{"motor_flux_linkage", 0.9}}},
    {"J x 2", {{"motor_inertia", 2.0}}},
    {"J x 0.5", {{"motor_inertia", 0.5}}},
};
#define WRONG_ROWS (sizeof wrong / sizeof wrong[0])

static const struct {
    const char *name;
    double factor;
} wrong_dead_time[] = {{"dead time +20 %", 1.2},
                       {"dead time -20 %", 0.8},
                       {"dead time +40 %", 1.4},
                       {"dead time -40 %", 0.6},
                       {"dead time unknown", 0.0}};
#define WRONG_DEAD_TIMES 5u
#define WRONG_REPORTED   3u /* of them, the last: reported only */

#define WRONG_CASES (1u + WRONG_ROWS + WRONG_DEAD_TIMES)

/* Rows of the n-th case, 0: all is right; and its name. */
static const char *wrong_rows(start_row_t rows[ROWS + 1u], start_shaft_t shaft, size_t n)
{
    rows[0] = (start_row_t){NULL, 0.0};
    if (n == 0u) {
        return "all right";
    }
    if (n > WRONG_ROWS) {
        put_dead_time_share(rows, wrong_dead_time[n - WRONG_ROWS - 1u].factor);
        return wrong_dead_time[n - WRONG_ROWS - 1u].name;
    }
    rig_t *const desk = start_on_desk(shaft, 1u);
    TEST_ASSERT_TRUE(rig_apply(desk));
    size_t used = 0;
    for (const start_row_t *row = wrong[n - 1u].rows; row->name != NULL; row++, used++) {
        rows[used] = (start_row_t){row->name, row->value * rig_value(desk, row->name)};
    }
    rows[used] = (start_row_t){NULL, 0.0};
    rig_free(desk);
    return wrong[n - 1u].name;
}

/* What the shaft holds at standstill, as a multiple of what it takes turning; 0: not held. The plant puts a
 * passive load on top of its break-away. */
static start_row_t break_away(start_shaft_t shaft, double load, double factor)
{
    return (start_row_t){"friction_breakaway",
                         factor > 0.0 ? factor * (start_shaft_data[shaft].friction + load) - load : 0.0};
}

/* Returns how many of the starts that are promised failed. */
static uint32_t start_with_wrong(const double loads[2], double sticks)
{
    uint32_t failed = 0;
    for (size_t s = 0; s < 2u; s++) {
        for (size_t l = 0; l < 2u; l++) {
            start_grid_t promised = {0};
            for (size_t n = 0; n < WRONG_CASES; n++) {
                const start_shaft_t shaft = (start_shaft_t)s;
                start_row_t rows[ROWS + 1u];
                const char *const name = wrong_rows(rows, shaft, n);
                size_t used = 0;
                while (rows[used].name != NULL) {
                    used++;
                }
                rows[used] = break_away(shaft, loads[l], sticks);
                rows[used + 1u] = (start_row_t){NULL, 0.0};
                const start_case_t what = {shaft, loads[l], 0.0, rows};
                const start_grid_t grid = starts(&what, 8u);
                print(&what, name, &grid);
                if (n < WRONG_CASES - WRONG_REPORTED) {
                    failed += grid.tried - grid.good;
                    start_raise(&promised.error, grid.error);
                    start_raise(&promised.dip, grid.dip);
                    start_raise(&promised.current, grid.current);
                }
            }
            printf(
                "start %c, %.2f N m, break-away %.1f, every promised error: <= %.2f A, dip %.1f r/min, error "
                "%.0f mrad\n",
                START_SHAFT_NAMES[s], loads[l], sticks, promised.current, promised.dip, promised.error);
        }
    }
    return failed;
}

static void test_starts_with_wrong_parameters(void)
{
    static const double loads[2] = {0.0, RATED_TORQUE};
    TEST_ASSERT_EQUAL_UINT32(0u, start_with_wrong(loads, 0.0));
}

static void test_starts_a_load_that_sticks_half_as_much_again_with_wrong_parameters_too(void)
{
    static const double loads[2] = {0.5 * RATED_TORQUE, RATED_TORQUE};
    TEST_ASSERT_EQUAL_UINT32(0u, start_with_wrong(loads, 1.5));
}

/* ---- a shaft that is held ---- */

typedef struct {
    double noticed;   /* longest from 60 r/min of the frame to the end of a try [s] */
    double energised; /* longest time with half the start's current or more [s] */
    uint32_t stopped; /* [-] with start_stalled after start_tries */
    uint32_t tried;   /* [-] */
} blocked_t;

static void start_blocked(blocked_t *blocked, start_shaft_t shaft, const start_row_t *held, double theta_e,
                          uint32_t seed)
{
    rig_free(rig);
    rig = start_on_desk(shaft, seed);
    start_ready(rig, theta_e);
    run_put(rig, held->name, held->value);
    start_watch(rig, &seen);
    run_on(rig, 500.0);
    const double current = 0.5 * rig_value(rig, "current_limit");
    uint32_t since = 0, energised = 0;
    bool judged = false;
    int last_try = 0;
    blocked->tried++;
    for (uint32_t n = 0; n < rig_periods(30.0) && seen.fault == 0; n++) {
        const int before = seen.manoeuvre;
        rig_step(rig);
        energised += seen.current > current;
        last_try = seen.start_try > last_try ? seen.start_try : last_try;
        if (seen.manoeuvre == RAMPS && seen.reference > 60.0 && !judged) {
            judged = true;
            since = n;
        }
        if (before == RAMPS && seen.manoeuvre != RAMPS) {
            start_raise(&blocked->noticed, judged ? start_time(n - since) : LONGEST);
            judged = false;
        }
    }
    start_raise(&blocked->energised, start_time(energised));
    const bool tries_used = last_try == (int)rig_value(rig, "start_tries");
    blocked->stopped += seen.fault == REASON_START_STALLED && tries_used;
    run_seconds(rig, 0.1);
    TEST_ASSERT_TRUE(seen.current < 0.1);
}

static void test_blocked_shaft_is_noticed_in_every_try_and_given_up(void)
{
    static const start_row_t held[] = {{"brake_torque", 100.0}, {"shaft_locked", 1.0}};
    for (size_t s = 0; s < 2u; s++) {
        for (size_t h = 0; h < 2u; h++) {
            blocked_t blocked = {0};
            for (uint32_t n = 0; n < 12u; n += START_THINNED) {
                start_blocked(&blocked, (start_shaft_t)s, &held[h], 2.0 * PI * n / 12.0, 1u + n);
            }
            printf(
                "start %c, %s: %u/%u given up, each try <= %.1f ms after 60 r/min, current for <= %.2f s\n",
                START_SHAFT_NAMES[s], held[h].name, blocked.stopped, blocked.tried, 1e3 * blocked.noticed,
                blocked.energised);
            TEST_ASSERT_EQUAL_UINT32(blocked.tried, blocked.stopped);
            TEST_ASSERT_TRUE(blocked.noticed <= 60e-3);
            TEST_ASSERT_TRUE(blocked.energised <= 15.0);
        }
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_starts_from_every_angle_under_every_passive_load);
    RUN_TEST(test_starts_against_an_active_load_of_half_the_rated_torque);
    RUN_TEST(test_active_load_of_the_rated_torque_ends_in_run_or_fault);
    RUN_TEST(test_starts_with_wrong_parameters);
    RUN_TEST(test_starts_a_load_that_sticks_half_as_much_again_with_wrong_parameters_too);
    RUN_TEST(test_blocked_shaft_is_noticed_in_every_try_and_given_up);
    return UNITY_END();
}
