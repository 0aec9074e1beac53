/* One run of an experiment on a separate rig. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host_sim/lab/course.h"
#include "host_sim/lab/dynamometer.h"
#include "host_sim/lab/experiment_parts.h"
#include "host_sim/lab/paper_theory.h"

/* The place of a row in the tap. */
typedef struct {
    uint32_t slot;
    slot_kind_t kind;
} tapped_t;

typedef struct {
    tapped_t row, minus; /* minus.slot RIG_TAP_MAX: none */
    const look_t *look;
} eye_t;

typedef struct {
    eye_t eye;
    tapped_t progress; /* slot RIG_TAP_MAX: none */
    bool over;
    tally_t *tally;
    const measure_t *measure;
} meter_t;

typedef struct {
    const experiment_t *experiment;
    experiment_run_t *run;
    uint32_t ids[RIG_TAP_MAX];
    uint32_t id_count;
    meter_t *meters;
    eye_t columns[COLUMNS_MAX];
    eye_t *expects;
    tally_t *expect_tallies;
    look_t *expect_looks;
    uint32_t count; /* [periods] so far */
    bool full;      /* the tap has no room */
} watch_t;

/* ---- the tap ---- */

static tapped_t tap_row(watch_t *w, const table_row_t *row)
{
    tapped_t tapped = {RIG_TAP_MAX, SLOT_FLOAT};
    if (row == NULL) {
        return tapped;
    }
    tapped.kind = row->kind;
    for (tapped.slot = 0; tapped.slot < w->id_count && w->ids[tapped.slot] != row->id; tapped.slot++) {
    }
    if (tapped.slot == w->id_count) {
        if (w->id_count == RIG_TAP_MAX) {
            w->full = true;
            tapped.slot = 0;
        } else {
            w->ids[w->id_count++] = row->id;
        }
    }
    return tapped;
}

static eye_t open_eye(watch_t *w, const look_t *look)
{
    return (eye_t){tap_row(w, look->row), tap_row(w, look->minus), look};
}

static double number_at(tapped_t at, const uint32_t *slots)
{
    return tally_number(slots[at.slot], at.kind);
}

static double see(const eye_t *eye, const uint32_t *slots, const experiment_run_t *run)
{
    double x = number_at(eye->row, slots);
    if (eye->minus.slot != RIG_TAP_MAX) {
        x -= number_at(eye->minus, slots);
    }
    if (eye->look->through != NULL) {
        x = eye->look->through->of(x, run);
    }
    return x / eye->look->scale;
}

static void measure(meter_t *meter, uint32_t k, const uint32_t *slots, const experiment_run_t *run)
{
    const measure_t *of = meter->measure;
    if (k < of->begin || k >= of->end) {
        return;
    }
    if (meter->progress.slot != RIG_TAP_MAX) {
        const double share = (number_at(meter->progress, slots) - of->past) / (of->until - of->past);
        meter->over = meter->over || share >= 1.0;
        if (!(share > 0.0) || meter->over) {
            return;
        }
    }
    tally_count(meter->tally, see(&meter->eye, slots, run));
}

static void watch(void *context, uint32_t period, const uint32_t *slots, uint32_t count)
{
    watch_t *w = context;
    experiment_run_t *run = w->run;
    const experiment_t *experiment = w->experiment;
    const uint32_t k = w->count++;
    (void)period;
    (void)count;
    for (uint32_t n = 0; n < experiment->measure_count; n++) {
        measure(&w->meters[n], k, slots, run);
    }
    for (uint32_t n = 0; n < run->scenario->expect_count; n++) {
        const scenario_expect_t *expect = &run->scenario->expects[n];
        if (k >= expect->begin && k < expect->end) {
            tally_count(&w->expect_tallies[n], see(&w->expects[n], slots, run));
        }
    }
    if (run->rows < run->rows_max && k % experiment->every == 0u) {
        for (uint32_t n = 0; n < experiment->column_count; n++) {
            run->trace[run->rows * experiment->column_count + n] = (float)see(&w->columns[n], slots, run);
        }
        run->rows++;
    }
}

static bool prepare_watch(watch_t *w)
{
    const experiment_t *experiment = w->experiment;
    const scenario_t *scenario = w->run->scenario;
    const size_t expects = scenario->expect_count + 1u;
    w->meters = calloc(experiment->measure_count + 1u, sizeof *w->meters);
    w->expects = calloc(expects, sizeof *w->expects);
    w->expect_tallies = calloc(expects, sizeof *w->expect_tallies);
    w->expect_looks = calloc(expects, sizeof *w->expect_looks);
    if (w->meters == NULL || w->expects == NULL || w->expect_tallies == NULL || w->expect_looks == NULL) {
        return false;
    }
    for (uint32_t n = 0; n < experiment->measure_count; n++) {
        const measure_t *of = &experiment->measures[n];
        w->meters[n] = (meter_t){.eye = open_eye(w, &of->look),
                                 .progress = tap_row(w, of->progress),
                                 .tally = &w->run->tallies[n],
                                 .measure = of};
    }
    for (uint32_t n = 0; n < experiment->column_count; n++) {
        w->columns[n] = open_eye(w, &experiment->columns[n]);
    }
    for (uint32_t n = 0; n < scenario->expect_count; n++) {
        const scenario_expect_t *expect = &scenario->expects[n];
        w->expect_looks[n] = (look_t){.row = expect->row, .minus = expect->minus, .scale = 1.0};
        w->expects[n] = open_eye(w, &w->expect_looks[n]);
        w->expect_tallies[n] = tally_empty();
    }
    return true;
}

static void free_watch(watch_t *w)
{
    free(w->meters);
    free(w->expects);
    free(w->expect_tallies);
    free(w->expect_looks);
}

/* ---- the rig ---- */

static double initial(const experiment_run_t *run, const char *row)
{
    return experiment_initial(run, rig_row_by_name(row));
}

/* Rows that the start by the dynamometer sets itself. */
static bool is_held(const table_row_t *row)
{
    static const char *const names[] = {"params.position_source", "plant.load_torque", "plant.shaft_locked",
                                        "plant.shaft_locked_speed"};
    bool held = table_by_id(scenario_table("requests"), row->id) == row;
    for (size_t n = 0; n < sizeof names / sizeof names[0]; n++) {
        held = held || rig_row_by_name(names[n]) == row;
    }
    return held;
}

static bool refused(const experiment_run_t *run, rig_t *rig, const scenario_setting_t *settings,
                    uint32_t count, scenario_error_t *error)
{
    scenario_refused(run->scenario, rig, settings, count, error);
    return false;
}

/* All settings at t = 0 except those that are held. */
static bool configure(const experiment_run_t *run, rig_t *rig, scenario_error_t *error)
{
    const scenario_event_t *all = &run->scenario->events[0];
    scenario_setting_t *settings = calloc(all->count + 1u, sizeof *settings);
    uint32_t count = 0;
    if (settings == NULL) {
        return scenario_no_memory(error);
    }
    for (uint32_t n = 0; n < all->count; n++) {
        if (!is_held(all->settings[n].row)) {
            settings[count++] = all->settings[n];
        }
    }
    const bool good =
        rig_put(rig, "params.position_source", 0.0) && scenario_set(rig, settings, count) && rig_apply(rig);
    if (!good) {
        (void)refused(run, rig, settings, count, error);
    }
    free(settings);
    return good;
}

static bool begin_dynamometer(experiment_run_t *run, rig_t *rig, scenario_error_t *error)
{
    const double speed = initial(run, "speed_request");
    const double load = initial(run, "plant.load_torque");
    const double friction =
        initial(run, "plant.friction_coulomb") + initial(run, "plant.friction_viscous") * fabs(speed);
    const double torque_per_ampere =
        1.5 * initial(run, "plant.pole_pairs") * initial(run, "plant.flux_linkage");
    const dynamometer_t to = {
        .speed = speed,
        .load = load,
        .current = dynamometer_current(load, friction, torque_per_ampere,
                                       initial(run, "params.current_limit"), speed),
        .estimate = initial(run, "params.position_source") != 0.0,
    };
    if (!configure(run, rig, error)) {
        return false;
    }
    if (!dynamometer_wait(rig) || !scenario_set(rig, run->ready.settings, run->ready.count) ||
        !dynamometer_begin(rig, &to)) {
        return scenario_fail(error, run->scenario->duration_place, "begin", "%s", rig_error(rig));
    }
    rig_run(rig, rig_periods(run->settle));
    return true;
}

static bool begin_power_on(experiment_run_t *run, rig_t *rig, course_t *course, scenario_error_t *error)
{
    if (!course_start(course, error)) {
        return false;
    }
    if (run->ready.count > 0u &&
        (!dynamometer_wait(rig) || !scenario_set(rig, run->ready.settings, run->ready.count))) {
        return refused(run, rig, run->ready.settings, run->ready.count, error);
    }
    rig_run(rig, rig_periods(run->settle));
    return true;
}

/* The course; `load` follows. */
static bool turn(experiment_run_t *run, course_t *course, scenario_error_t *error)
{
    const uint32_t load = rig_row_by_name("plant.load_torque")->id;
    for (uint32_t period = 0; period < run->scenario->periods;) {
        if (!course_change(course, period, error)) {
            return false;
        }
        (void)rig_get(course->rig, load, &run->load);
        const uint32_t due = course_next(course, period);
        const uint32_t until = due < run->scenario->periods ? due : run->scenario->periods;
        rig_run(course->rig, until - period);
        period = until;
    }
    return true;
}

/* A fault, a bridge that is off although `enable` is on, or an expectation that is not met. */
static bool is_lost(const watch_t *w, rig_t *rig)
{
    const scenario_t *scenario = w->run->scenario;
    bool lost = w->run->fault != 0 ||
                (rig_value(rig, "enable") == table_choice(rig_row_by_name("enable"), "on") &&
                 rig_value(rig, "state") != table_choice(rig_row_by_name("state"), "operation_enabled"));
    for (uint32_t n = 0; n < scenario->expect_count; n++) {
        const scenario_expect_t *expect = &scenario->expects[n];
        const double value = tally_value(&w->expect_tallies[n], expect->statistic);
        lost = lost || !(value >= expect->at_least && value <= expect->at_most);
    }
    return lost;
}

static bool measure_on(watch_t *w, rig_t *rig, scenario_error_t *error)
{
    experiment_run_t *run = w->run;
    course_t course = {0};
    if (!prepare_watch(w) || !course_init(&course, run->scenario, rig)) {
        return scenario_no_memory(error);
    }
    if (w->full) {
        course_free(&course);
        return scenario_fail(
            error, run->scenario->duration_place, "measure",
            "too many rows in [[measure]], [trace] and [[expect]]; accepted: %u different ones", RIG_TAP_MAX);
    }
    bool good = w->experiment->dynamometer ? begin_dynamometer(run, rig, error)
                                           : begin_power_on(run, rig, &course, error);
    if (good && w->id_count > 0u) {
        good = rig_tap(rig, w->ids, w->id_count, 1u, watch, w) ||
               scenario_fail(error, run->scenario->duration_place, "measure", "%s", rig_error(rig));
    }
    good = good && turn(run, &course, error);
    course_free(&course);
    run->fault = (int32_t)rig_value(rig, "fault_reason");
    run->lost = good && is_lost(w, rig);
    return good;
}

bool experiment_measure(experiment_t *experiment, size_t n, uint64_t seed, bool traced, char why[POOL_WHY])
{
    experiment_run_t *run = &experiment->runs[n];
    watch_t w = {.experiment = experiment, .run = run};
    scenario_error_t error = {.message = "no memory"};
    double kp = 0.0;
    run->ki = (double)NAN;
    (void)paper_loop(initial(run, "params.pll_bandwidth"), initial(run, "params.feedforward_cutoff"), &kp,
                     &run->ki);
    if (traced && experiment->column_count > 0u) {
        run->rows_max = (run->scenario->periods + experiment->every - 1u) / experiment->every;
        run->trace = calloc(run->rows_max * experiment->column_count, sizeof run->trace[0]);
    }
    rig_t *rig = rig_create(seed + run->reseed);
    const bool good =
        rig != NULL && (run->rows_max == 0u || run->trace != NULL) && measure_on(&w, rig, &error);
    if (!good) {
        char text[1200];
        snprintf(error.file, sizeof error.file, "%s", experiment->base->path);
        snprintf(why, POOL_WHY, "%.220s (run %.60s %.20s)", scenario_error_text(&error, text, sizeof text),
                 run->name, run->flavour);
    }
    rig_free(rig);
    free_watch(&w);
    return good;
}
