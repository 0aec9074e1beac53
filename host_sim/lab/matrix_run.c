/* Runs the cells: each manoeuvre is reached once, and each fault starts from its state. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host_sim/lab/course.h"
#include "host_sim/lab/matrix.h"
#include "host_sim/lab/matrix_table.h"
#include "host_sim/lab/paper_drive.h"
#include "host_sim/rig/rig.h"
#include "settings/faults.h"

#define PI           3.14159265358979323846
#define SEED         1u
#define PATIENCE     6.0   /* [s] within which a state must be reached */
#define LOADING      2.0   /* [N m/s] slow enough for the speed control of the light rotor */
#define LOAD_STEP    25e-3 /* [s] of it */
#define FOLLOW       0.01  /* [s] 15 time constants of the encoder's speed */
#define TO_ENABLE    0.1   /* [s] from a fault in manoeuvre off to the request for the bridge */
#define AFTERWARDS   0.3   /* [s] that a latched fault is watched */
#define AT_END       50e-3 /* [s] over which the rotor's end is judged */
#define LONGEST_TURN 1.0   /* [s] of those that are waited for */
#define SLOW         2.0   /* [rad/s] below this speed the rotor is at standstill */
#define NEAR         0.05  /* [-] of the reference, or ... */
#define NEAR_RPM     10.0  /* [r/min] ... it follows */

/* ---- the rig ---- */

/* The bare motor, with the bandwidths that a rotor as light needs; h is the default. */
static const setting_t light[] = {
    {"plant.inertia", 0.003},        {"plant.friction_coulomb", 0.05},     {"params.motor_inertia", 0.003},
    {"params.pll_bandwidth", 400.0}, {"params.feedforward_cutoff", 125.0},
};

/* Errors of the sensors that remain after calibration. */
static const setting_t real[] = {
    {"plant.current_offset_a", 0.03},
    {"plant.current_offset_c", -0.03},
    {"plant.current_gain_error_b", 0.002},
};
#define COUNT(list) (sizeof(list) / sizeof(list)[0])
#define CHANGES     COUNT(matrix_faults[0].changes)

/* How the rig advances: by time alone, or also with the events of a scenario. */
typedef struct {
    rig_t *rig;
    course_t *course; /* NULL: none */
    scenario_error_t error;
    bool refused;
} turner_t;

/* Runs this number of periods, or fewer if the stop condition is met. */
static void turn(turner_t *turner, uint32_t periods)
{
    if (turner->course == NULL) {
        rig_run(turner->rig, periods);
    } else if (!turner->refused) {
        const uint32_t now = rig_period(turner->rig);
        turner->refused = course_run(turner->course, now, now + periods, &turner->error) == COURSE_NEVER;
    }
}

static double choice(const char *row, const char *name)
{
    return table_choice(rig_row_by_name(row), name);
}

static void pass(rig_t *rig, double seconds)
{
    rig_run(rig, rig_periods(seconds));
}

/* Runs until the condition is met, at most for this time [s]. false: it was not met. */
static bool until(rig_t *rig, const char *row, rig_compare_t compare, double value, double seconds)
{
    rig_stop_when(rig, rig_row_by_name(row)->id, compare, value);
    const bool stopped = rig_run(rig, rig_periods(seconds)) < rig_periods(seconds);
    rig_stop_when(rig, rig_row_by_name(row)->id, RIG_NEVER, 0.0);
    return stopped;
}

/* Injects the fault, in a scenario scaled to its motor. `before` gets the values that its rows had. */
static bool change(rig_t *rig, const matrix_fault_t *fault, bool scaled, double before[CHANGES])
{
    for (size_t n = 0; n < CHANGES && fault->changes[n].row != NULL; n++) {
        const char *row = fault->changes[n].row;
        before[n] = rig_value(rig, row);
        const double kept = fault->changes[n].factor != 0.0 ? fault->changes[n].factor * before[n] : 0.0;
        const double shift = fault->changes[n].shift;
        const double value = kept + (scaled ? matrix_scaled(rig, row, shift) : shift);
        if (!rig_put(rig, row, rig_row_by_name(row)->kind == SLOT_FLOAT ? value : floor(value + 0.5))) {
            return false;
        }
    }
    return true;
}

/* Ends the fault when its time is over; the last row first. */
static bool take_back(turner_t *turner, const matrix_fault_t *fault, const double before[CHANGES])
{
    rig_t *rig = turner->rig;
    turn(turner, rig_periods(fault->lasts));
    for (size_t n = CHANGES; n-- > 0u;) {
        const char *row = fault->changes[n].row;
        if (row != NULL && !rig_put(rig, row, before[n])) {
            return false;
        }
    }
    return true;
}

/* Power on to ready, on this shaft and with this source. */
static bool get_ready(rig_t *rig, uint32_t place)
{
    const bool is_light = (1u << place & (MATRIX_ENCODER_L | MATRIX_SENSORLESS_L)) != 0u;
    return paper_drive_put(rig, light, is_light ? COUNT(light) : 0u) &&
           rig_put(rig, "position_source", choice("position_source", matrix_source_name(place))) &&
           rig_apply(rig) && until(rig, "state", RIG_EQUAL, choice("state", "ready"), PATIENCE) &&
           paper_drive_put(rig, real, COUNT(real));
}

static bool put_load_on(rig_t *rig, double load)
{
    const double steps = ceil(load / LOADING / LOAD_STEP);
    for (double n = 1.0; n <= steps; n++) {
        if (!rig_put(rig, "load_torque", load * n / steps)) {
            return false;
        }
        pass(rig, LOAD_STEP);
    }
    return true;
}

/* Runs until the rotor is at the reference with its load. */
static bool settle(rig_t *rig, const matrix_manoeuvre_t *m)
{
    if (m->settle == 0.0) {
        return true;
    }
    if (!until(rig, "manoeuvre", RIG_EQUAL, choice("manoeuvre", "run"), PATIENCE)) {
        return false;
    }
    pass(rig, m->settle);
    if (!put_load_on(rig, m->load)) {
        return false;
    }
    pass(rig, m->settle);
    return fabs(rig_value(rig, "true_omega_m") - m->reference * RPM) <=
           fmax(NEAR * m->reference, NEAR_RPM) * RPM;
}

/* From ready into the manoeuvre. */
static bool come_to(rig_t *rig, const matrix_manoeuvre_t *m)
{
    if (!rig_put(rig, "speed_request", m->reference * RPM)) {
        return false;
    }
    if (m->enabled) {
        rig_set_motion(rig, 0.3, m->turning * RPM);
        pass(rig, FOLLOW);
        if (!rig_put(rig, "enable", choice("enable", "on")) || !settle(rig, m)) {
            return false;
        }
    }
    if (!isnan(m->then) && !rig_put(rig, "speed_request", m->then * RPM)) {
        return false;
    }
    if (m->until != NULL && !until(rig, m->until, m->choice != NULL ? RIG_EQUAL : RIG_BELOW,
                                   m->choice != NULL ? choice(m->until, m->choice) : m->below, PATIENCE)) {
        return false;
    }
    pass(rig, m->delay);
    return rig_value(rig, "fault_reason") == 0.0;
}

/* ---- watching ---- */

enum {
    STATE,
    FAULT,
    REFUSAL,
    WARNINGS,
    WARNINGS_2,
    MANOEUVRE,
    LOSSES,
    TRY,
    I_A,
    I_B,
    I_C,
    OMEGA,
    OMEGA_E,
    FRAME,
    TAPPED
};
static const char *const tapped[TAPPED] = {
    [STATE] = "state",          [FAULT] = "fault_reason",    [REFUSAL] = "refusal",
    [WARNINGS] = "warnings",    [WARNINGS_2] = "warnings_2", [MANOEUVRE] = "manoeuvre",
    [LOSSES] = "lock_losses",   [TRY] = "start_try",         [I_A] = "true_i_a",
    [I_B] = "true_i_b",         [I_C] = "true_i_c",          [OMEGA] = "true_omega_m",
    [OMEGA_E] = "true_omega_e", [FRAME] = "omega_e",
};

/* State of a cell while it runs. Times [s] count from the injection, or from the request for the bridge; NAN:
 * not yet. */
typedef struct {
    matrix_seen_t *seen;
    const matrix_promise_t *promise;
    uint32_t since;                         /* [periods] when time begins */
    double warned, lost, stopping, latched; /* [s] first time that ... */
    double off;                             /* [s] since when all legs are held off */
    bool was_on;                            /* [-] the gates were on at any time from the injection on */
    double rotor, frame;                    /* [rad] electrical, of rotor and forced frame ... */
    uint32_t turns;                         /* [periods] ... in this number, until the detection */
    uint32_t losses, try;                   /* [-] at the injection */
    int32_t state, refusal;                 /* [-] of the last period */
    bool ending;                            /* [-] the final state of the rotor is being judged */
    double speed_sum;                       /* [rad/s] meanwhile */
    uint32_t speed_count;                   /* [-] */
    int32_t in_ready, in_quick_stop;        /* [-] choices of state ... */
    int32_t relocks, runs;                  /* [-] ... and manoeuvre */
} watch_t;

static void at_first(double *time, bool is, double now)
{
    if (is && isnan(*time)) {
        *time = now;
    }
}

static void watch_edge(void *context, uint64_t tick, uint32_t what, uint32_t value)
{
    watch_t *watch = context;
    if (what == RIG_EDGE_TRIP) {
        const double now = ((double)tick - (double)watch->since * (double)RIG_PERIOD_TICKS) / 150e6;
        watch->was_on = watch->was_on || value == 0u;
        watch->off = value == 7u ? fmax(now, 0.0) : (double)NAN;
    }
}

/* True if one of these bits of the fault table belongs to a promised reason. */
static bool warns_of(const watch_t *watch, uint64_t warnings)
{
    for (uint32_t n = 0; n < (uint32_t)FAULTS && warnings != 0u; n++) {
        if ((warnings >> n & 1u) != 0u && matrix_accepts(watch->promise->reasons, fault_rows[n].reason)) {
            return true;
        }
    }
    return false;
}

/* The angle by which the currents turn until the drive reports the fault: they turn with the assumed rotor
 * frame, in which the control runs, or with a forced frame, about which the rotor swings. */
static void watch_turn(watch_t *watch, double rotor, double frame, int32_t manoeuvre)
{
    if (isnan(watch->latched) && isnan(watch->lost) && isnan(watch->stopping)) {
        watch->rotor += rotor * RIG_PERIOD_SECONDS;
        watch->frame += manoeuvre != watch->runs ? fabs(frame) * RIG_PERIOD_SECONDS : 0.0;
        watch->turns++;
    }
}

static void watch_period(void *context, uint32_t period, const uint32_t *slots, uint32_t count)
{
    watch_t *watch = context;
    matrix_seen_t *seen = watch->seen;
    const double now = period > watch->since ? (period - watch->since) * RIG_PERIOD_SECONDS : 0.0;
    float value[TAPPED];
    memcpy(value, slots, count * sizeof value[0]);
    for (uint32_t n = I_A; n <= I_C; n++) {
        seen->current = fmax(seen->current, fabs((double)value[n]));
    }
    seen->fastest = fmax(seen->fastest, fabs((double)value[OMEGA]));
    if (period > watch->since) {
        watch_turn(watch, (double)value[OMEGA_E], (double)value[FRAME], (int32_t)slots[MANOEUVRE]);
    }
    if (watch->ending) {
        watch->speed_sum += (double)value[OMEGA];
        watch->speed_count++;
    }
    watch->state = (int32_t)slots[STATE];
    watch->refusal = (int32_t)slots[REFUSAL];
    const uint64_t warnings = (uint64_t)slots[WARNINGS_2] << 32 | slots[WARNINGS];
    seen->warnings |= warnings;
    seen->reason = (int32_t)slots[FAULT];
    at_first(&watch->warned, warns_of(watch, warnings), now);
    at_first(&watch->lost,
             slots[LOSSES] > watch->losses || (slots[TRY] > watch->try && slots[TRY] > 1u) ||
                 (int32_t)slots[MANOEUVRE] == watch->relocks,
             now);
    at_first(&watch->stopping, watch->state == watch->in_quick_stop, now);
    at_first(&watch->latched, slots[FAULT] != 0u, now);
}

static bool begin_watch(rig_t *rig, watch_t *watch)
{
    uint32_t ids[TAPPED];
    for (uint32_t n = 0; n < TAPPED; n++) {
        ids[n] = rig_row_by_name(tapped[n])->id;
    }
    watch->warned = watch->lost = watch->stopping = watch->latched = watch->off = (double)NAN;
    watch->losses = (uint32_t)rig_value(rig, "lock_losses");
    watch->try = (uint32_t)rig_value(rig, "start_try");
    watch->in_ready = (int32_t)choice("state", "ready");
    watch->in_quick_stop = (int32_t)choice("state", "quick_stop");
    watch->relocks = (int32_t)choice("manoeuvre", "relock");
    watch->runs = (int32_t)choice("manoeuvre", "run");
    watch->seen->started = rig_value(rig, "true_omega_m");
    rig_watch_edges(rig, watch_edge, watch);
    return rig_tap(rig, ids, TAPPED, 1u, watch_period, watch);
}

/* ---- a cell ---- */

static void tell_reaction(watch_t *watch)
{
    matrix_seen_t *seen = watch->seen;
    seen->gates_off = watch->off;
    seen->turning = fmax(fabs(watch->rotor), watch->frame) / (fmax(watch->turns, 1.0) * RIG_PERIOD_SECONDS);
    if (seen->reason != 0) {
        seen->reaction = isnan(watch->stopping) ? MATRIX_OPENS : MATRIX_STOPS;
        seen->noticed = !isnan(watch->stopping) ? watch->stopping
                        : watch->was_on         ? watch->off
                                                : watch->latched;
    } else if (!watch->was_on && watch->state == watch->in_ready) {
        seen->reaction = MATRIX_REFUSES;
        seen->reason = watch->refusal;
        seen->noticed = 0.0;
    } else if (!isnan(watch->lost)) {
        seen->reaction = MATRIX_CATCHES;
        seen->noticed = watch->lost;
    } else if (seen->warnings != 0u) {
        seen->reaction = MATRIX_WARNS;
        seen->noticed = watch->warned;
    } else {
        seen->reaction = MATRIX_RIDES;
        seen->noticed = (double)NAN;
    }
}

static void tell_rotor(const watch_t *watch)
{
    matrix_seen_t *seen = watch->seen;
    seen->speed = watch->speed_sum / watch->speed_count;
    if (!isnan(watch->off)) {
        seen->rotor = fabs(seen->speed) < SLOW ? MATRIX_STANDS : MATRIX_COASTS;
    } else {
        const bool near =
            fabs(seen->speed - seen->reference) <= fmax(NEAR * fabs(seen->reference), NEAR_RPM * RPM);
        seen->rotor = near ? MATRIX_FOLLOWS : MATRIX_STRAYS;
    }
}

/* [s] over which the rotor's end is judged: an electrical turn of a slow one, whose speed swings in it. */
static double end_of(rig_t *rig, const watch_t *watch)
{
    const double one = 2.0 * PI / (rig_value(rig, "plant.pole_pairs") * fabs(watch->seen->reference));
    return fmax(AT_END, fmin(one, LONGEST_TURN));
}

/* Until the watch is over, or a latched fault has been watched for long enough. */
static void watch_out(turner_t *turner, watch_t *watch, double seconds)
{
    rig_t *rig = turner->rig;
    const uint32_t fault = rig_row_by_name("fault_reason")->id;
    const uint32_t end = rig_period(rig) + rig_periods(seconds - end_of(rig, watch));
    rig_stop_when(rig, fault, RIG_NOT_EQUAL, 0.0);
    turn(turner, end - rig_period(rig));
    rig_stop_when(rig, fault, RIG_NEVER, 0.0);
    if (rig_period(rig) < end) {
        turn(turner, rig_periods(AFTERWARDS) < end - rig_period(rig) ? rig_periods(AFTERWARDS)
                                                                     : end - rig_period(rig));
    }
    watch->ending = true;
    watch->seen->reference =
        turner->course != NULL ? rig_value(rig, "speed_request") : watch->seen->reference;
    turn(turner, rig_periods(end_of(rig, watch)));
}

/* Makes a rig with a request to run; its rotor is at standstill or turns as the manoeuvre requires. */
static bool come_on(rig_t *rig, const matrix_manoeuvre_t *m)
{
    pass(rig, TO_ENABLE - FOLLOW);
    rig_set_motion(rig, 0.3, m->turning * RPM);
    pass(rig, FOLLOW);
    return rig_put(rig, "enable", choice("enable", "on"));
}

/* Injects the fault into a rig in the manoeuvre; a fault that is present from the start, into a rig in the
 * state ready.
 */
static bool run_on(turner_t *turner, matrix_cell_t *cell)
{
    rig_t *rig = turner->rig;
    const matrix_fault_t *fault = &matrix_faults[cell->fault];
    const matrix_manoeuvre_t *m = &matrix_manoeuvres[cell->manoeuvre];
    const bool on = m->enabled && !fault->from_start;
    double before[CHANGES];
    watch_t watch = {.seen = &cell->seen, .promise = cell->promise, .since = rig_period(rig)};
    cell->seen.reference = cell->user != NULL ? rig_value(rig, "speed_request")
                           : isnan(m->then)   ? m->reference * RPM
                                              : m->then * RPM;
    watch.since += on ? 0u : rig_periods(TO_ENABLE);
    if (!begin_watch(rig, &watch) || !change(rig, fault, cell->user != NULL, before) ||
        (!on && !come_on(rig, m)) || (fault->lasts > 0.0 && !take_back(turner, fault, before))) {
        return false;
    }
    watch_out(turner, &watch, fault->watch - fault->lasts);
    if (turner->refused) {
        return false;
    }
    tell_reaction(&watch);
    tell_rotor(&watch);
    matrix_judge(cell);
    return true;
}

/* ---- all cells ---- */

/* A manoeuvre that was reached in a place: the saved state of the rig, from which each fault with when =
 * LATER starts. */
typedef struct {
    bool wanted;
    void *state; /* octets of rig_save; NULL: the manoeuvre was not reached */
} begin_t;

typedef struct {
    begin_t begins[MATRIX_MANOEUVRE_COUNT * MATRIX_PLACES];
    uint32_t wanted[MATRIX_MANOEUVRE_COUNT * MATRIX_PLACES]; /* [-] indices of the cells that run */
    matrix_cell_t *cells;
    size_t done, pieces;
    void (*progress)(void *context, double fraction);
    void *context;
} work_t;

static void tell_progress(void *context, size_t done)
{
    work_t *work = context;
    if (work->progress != NULL) {
        work->progress(work->context, (double)(work->done + done) / (double)work->pieces);
    }
}

static bool refused(rig_t *rig, const char *what, char why[POOL_WHY])
{
    snprintf(why, POOL_WHY, "%s: %s", what, rig == NULL ? "no memory" : rig_error(rig));
    rig_free(rig);
    return false;
}

static bool do_begin(void *context, size_t n, char why[POOL_WHY])
{
    work_t *work = context;
    begin_t *begin = &work->begins[work->wanted[n]];
    const matrix_manoeuvre_t *m = &matrix_manoeuvres[work->wanted[n] / MATRIX_PLACES];
    rig_t *rig = rig_create(SEED);
    if (rig == NULL || !get_ready(rig, work->wanted[n] % MATRIX_PLACES)) {
        return refused(rig, m->name, why);
    }
    if (come_to(rig, m)) {
        begin->state = malloc(rig_state_size());
        if (begin->state == NULL) {
            return refused(rig, m->name, why);
        }
        rig_save(rig, begin->state);
    }
    rig_free(rig);
    return true;
}

/* A rig in the manoeuvre of the cell; in the state ready for a fault that is present from the start. */
static bool stand_in(rig_t *rig, const work_t *work, matrix_cell_t *cell)
{
    const matrix_fault_t *fault = &matrix_faults[cell->fault];
    const begin_t *begin = &work->begins[cell->manoeuvre * MATRIX_PLACES + cell->place];
    if (fault->from_start) {
        cell->red = 0u;
        return get_ready(rig, cell->place) &&
               rig_put(rig, "speed_request", matrix_manoeuvres[cell->manoeuvre].reference * RPM);
    }
    cell->red = begin->state != NULL ? 0u : MATRIX_BY_PROFILE;
    return begin->state == NULL || rig_load(rig, begin->state, rig_state_size());
}

/* The scenario's rig, run until its time. */
static bool do_user(turner_t *turner, matrix_cell_t *cell)
{
    const matrix_user_t *user = cell->user;
    course_t course;
    bool good = course_init(&course, user->scenario, turner->rig);
    turner->course = &course;
    good = good && course_start(&course, &turner->error) &&
           course_run(&course, 0u, rig_periods(user->at), &turner->error) != COURSE_NEVER &&
           run_on(turner, cell);
    course_free(&course);
    return good;
}

static bool do_cell(void *context, size_t n, char why[POOL_WHY])
{
    const work_t *work = context;
    matrix_cell_t *cell = &work->cells[n];
    char name[MATRIX_NAME_SIZE];
    if (!cell->occurs) {
        return true;
    }
    rig_t *rig = rig_create(cell->user != NULL ? cell->user->scenario->seed : SEED);
    turner_t turner = {.rig = rig};
    if (cell->user != NULL && rig != NULL) {
        if (!do_user(&turner, cell)) {
            return refused(rig, matrix_cell_name(name, cell), why);
        }
    } else if (rig == NULL || !stand_in(rig, work, cell) || (cell->red == 0u && !run_on(&turner, cell))) {
        return refused(rig, matrix_cell_name(name, cell), why);
    }
    rig_free(rig);
    return true;
}

bool matrix_run(matrix_cell_t *cells, size_t count, unsigned threads,
                void (*progress)(void *context, double fraction), void *context, char why[POOL_WHY])
{
    work_t work = {.cells = cells, .progress = progress, .context = context};
    size_t wanted = 0;
    for (size_t n = 0; n < count; n++) {
        begin_t *begin = &work.begins[cells[n].manoeuvre * MATRIX_PLACES + cells[n].place];
        if (cells[n].user == NULL && cells[n].occurs && !matrix_faults[cells[n].fault].from_start &&
            !begin->wanted) {
            begin->wanted = true;
            work.wanted[wanted++] = (uint32_t)(begin - work.begins);
        }
    }
    work.pieces = wanted + count;
    const pool_t begins = {.count = wanted, .piece = do_begin, .progress = tell_progress, .work = &work};
    const pool_t all = {.count = count, .piece = do_cell, .progress = tell_progress, .work = &work};
    bool done = pool_run(&begins, threads, why);
    work.done = wanted;
    done = done && pool_run(&all, threads, why);
    for (size_t n = 0; n < wanted; n++) {
        free(work.begins[work.wanted[n]].state);
    }
    return done;
}
