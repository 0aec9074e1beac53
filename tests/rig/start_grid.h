/* Starts from standstill by the grid: one start and what it is judged by, from its angles a row of figures.
 */
#ifndef TESTS_RIG_START_GRID_H
#define TESTS_RIG_START_GRID_H

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

static inline void judge(start_end_t *end, uint32_t now, int before, const double torque[TORQUE_WINDOW])
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

static inline void add(start_grid_t *grid, const start_end_t *end)
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
static inline double handover_speed(void)
{
    const manoeuvres_limits_t *limits = &rig_state(rig)->app.drive.manoeuvres.limits;
    return (double)limits->handover_speed / POLE_PAIRS / RPM;
}

static inline void start(start_grid_t *grid, const start_case_t *what, double theta_e, uint32_t seed)
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
static inline start_grid_t starts(const start_case_t *what, uint32_t angles)
{
    start_grid_t grid = {0};
    for (uint32_t n = 0; n < angles; n += START_THINNED) {
        start(&grid, what, 2.0 * PI * n / angles, 1u + n);
    }
    return grid;
}

static inline void print(const start_case_t *what, const char *name, const start_grid_t *grid)
{
    printf("start %c, %.2f N m %s, %s: %u/%u, <= %.2f s, %.2f A, dip %.1f r/min, error %.0f mrad, torque "
           "step %.2f "
           "N m, tries %.0f, caught turning %u\n",
           START_SHAFT_NAMES[what->shaft], what->load, what->kind > 0.0 ? "active" : "passive", name,
           grid->good, grid->tried, grid->time, grid->current, grid->dip, grid->error, grid->step,
           grid->tries, grid->caught);
}

#endif
