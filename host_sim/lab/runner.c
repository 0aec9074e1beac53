#include "host_sim/lab/runner.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "host_sim/lab/course.h"
#include "host_sim/lab/tally.h"

/* One expectation. */
typedef struct {
    uint32_t begin, end;  /* [periods] */
    uint32_t slot, minus; /* [-] places in the tap; minus RIG_TAP_MAX: none */
    slot_kind_t kind, minus_kind;
    tally_t of;
} window_t;

typedef struct {
    const scenario_t *scenario;
    const runner_options_t *options;
    rig_t *rig;
    runner_result_t *result;
    /* the tap */
    uint32_t rows[RIG_TAP_MAX];
    uint32_t row_count;
    uint32_t every;        /* [periods] of the recording */
    uint32_t until_sample; /* [periods] to its next sample */
    window_t *tallies;     /* first the future ones, then the active ones; otherwise unordered */
    uint32_t tally_count;
    course_t course;
    bool was_held;     /* the drive's history, by a fault */
    bool was_recorded; /* its record for a replay */
    /* until the bridge has been on */
    bool was_on, was_asked;
    uint32_t state, enable; /* [-] ids */
    double on_state, on_request;
    int32_t why_not; /* [-] reason in the last period in which the drive was commanded on */
    uint32_t obeyed; /* [periods] since then the bridge is off although `enable` is on; judged every
                        OBEYED_EVERY */
} run_t;

#define OBEYED_EVERY 16u /* [periods] */

/* ---- statistics ---- */

static void on_sample(void *context, uint32_t period, const uint32_t *slots, uint32_t count)
{
    run_t *run = context;
    (void)count;
    for (uint32_t n = 0; n < run->tally_count; n++) {
        window_t *tally = &run->tallies[n];
        if (period - tally->begin <
            tally->end - tally->begin) { /* begin <= period < end, in one comparison */
            double x = tally_number(slots[tally->slot], tally->kind);
            if (tally->minus != RIG_TAP_MAX) {
                x -= tally_number(slots[tally->minus], tally->minus_kind);
            }
            tally_count(&tally->of, x);
        }
    }
    if (run->options->sink != NULL) {
        if (run->until_sample == 0u) {
            run->options->sink(run->options->sink_context, period, slots, run->options->record_count);
            run->until_sample = run->every;
        }
        run->until_sample--;
    }
}

/* ---- set-up ---- */

/* Place of a row in the tap; RIG_TAP_MAX: it is full. */
static uint32_t tap_row(run_t *run, uint32_t id)
{
    for (uint32_t n = 0; n < run->row_count; n++) {
        if (run->rows[n] == id) {
            return n;
        }
    }
    if (run->row_count < RIG_TAP_MAX) {
        run->rows[run->row_count] = id;
        return run->row_count++;
    }
    return RIG_TAP_MAX;
}

static bool refuse(run_t *run, const char *name, const char *message)
{
    scenario_error_t *error = &run->result->error;
    memset(error, 0, sizeof *error);
    snprintf(error->file, sizeof error->file, "%s", run->scenario->path);
    snprintf(error->name, sizeof error->name, "%s", name);
    snprintf(error->message, sizeof error->message, "%s", message);
    return false;
}

static bool set_up_tap(run_t *run)
{
    const runner_options_t *options = run->options;
    const scenario_t *scenario = run->scenario;
    if (options->sink != NULL && (options->record_count == 0u || options->record_count > RIG_TAP_MAX)) {
        return refuse(run, "record", "accepted: 1 to 160 rows");
    }
    /* The recorded rows first and unchanged, so that the sink receives a part of the tap. */
    for (uint32_t n = 0; n < options->record_count && options->sink != NULL; n++) {
        run->rows[run->row_count++] = options->record[n];
    }
    for (uint32_t n = 0; n < scenario->expect_count; n++) {
        const scenario_expect_t *expect = &scenario->expects[n];
        const uint32_t slot = tap_row(run, expect->row->id);
        const uint32_t minus = expect->minus != NULL ? tap_row(run, expect->minus->id) : RIG_TAP_MAX;
        if (slot == RIG_TAP_MAX || (expect->minus != NULL && minus == RIG_TAP_MAX)) {
            return refuse(run, "record",
                          "too many rows recorded and expected together; accepted: up to 128 different ones");
        }
        run->tallies[n] = (window_t){
            .begin = expect->begin,
            .end = expect->end,
            .slot = slot,
            .minus = minus,
            .kind = expect->row->kind,
            .minus_kind = expect->minus != NULL ? expect->minus->kind : SLOT_FLOAT,
            .of = tally_empty(),
        };
    }
    run->tally_count = scenario->expect_count;
    if (run->row_count == 0u) {
        return true;
    }
    const bool tapped =
        run->tally_count > 0u
            ? rig_tap(run->rig, run->rows, run->row_count, 1u, on_sample, run)
            : rig_tap(run->rig, run->rows, run->row_count, run->every, options->sink, options->sink_context);
    return tapped || refuse(run, "record", rig_error(run->rig));
}

static bool set_up(run_t *run)
{
    if (!course_start(&run->course, &run->result->error) || !set_up_tap(run)) {
        return false;
    }
    if (run->options->edge_sink != NULL) {
        rig_watch_edges(run->rig, run->options->edge_sink, run->options->edge_context);
    }
    if (run->options->has_stop_period) {
        rig_stop_before(run->rig, run->options->stop_period);
    }
    return true;
}

/* ---- history of a fault ---- */

static void keep_history(rig_t *rig, runner_history_t *history)
{
    const uint32_t columns = rig_history_columns(rig);
    history->columns = columns;
    history->periods = rig_history_count(rig);
    history->fault_reason = (int32_t)rig_value(rig, "fault_reason");
    history->fault_period = (uint32_t)rig_value(rig, "fault_period");
    memcpy(history->rows, rig_history_rows(rig), columns * sizeof history->rows[0]);
    for (uint32_t n = 0; n < history->periods; n++) {
        memcpy(&history->slots[columns * n],
               rig_history(rig, history->periods - 1u - n, &history->last_period),
               columns * sizeof history->slots[0]);
    }
}

/* The record for a replay is held some periods after the fault. */
static void keep_record(rig_t *rig, runner_history_t *history)
{
    history->record_count = rig_record_count(rig);
    rig_record(rig, history->record, history->record_count);
}

static void look_for_fault(run_t *run)
{
    const bool recorded = rig_record_count(run->rig) != 0u;
    if (recorded && !run->was_recorded) {
        keep_record(run->rig, run->options->history);
    }
    run->was_recorded = recorded;
    const bool held = rig_history_held(run->rig);
    if (held && !run->was_held) {
        keep_history(run->rig, run->options->history);
    }
    run->was_held = held;
}

/* ---- whether the drive was ever on ---- */

/* The fault that stopped the drive, or else the reason of the present refusal. */
static int32_t why_off(rig_t *rig)
{
    const int32_t fault = (int32_t)rig_value(rig, "fault_reason");
    return fault != 0 ? fault : (int32_t)rig_value(rig, "refusal");
}

static void look_whether_on(run_t *run)
{
    double state = 0.0;
    double request = 0.0;
    run->was_on = rig_get(run->rig, run->state, &state) && state == run->on_state;
    if (!run->was_on && rig_get(run->rig, run->enable, &request) && request == run->on_request) {
        run->was_asked = true;
        run->why_not = why_off(run->rig);
    }
}

/* ---- whether the drive follows `enable` ---- */

/* The bridge is off although `enable` is on. */
static bool disobeys(const run_t *run)
{
    double state = 0.0;
    double request = 0.0;
    return rig_get(run->rig, run->enable, &request) && request == run->on_request &&
           rig_get(run->rig, run->state, &state) && state != run->on_state;
}

static void look_whether_it_obeys(run_t *run, uint32_t period)
{
    if (period % OBEYED_EVERY == 0u && !disobeys(run)) {
        run->obeyed = period;
    }
}

/* ---- the loop ---- */

static uint32_t sooner(uint32_t a, uint32_t b)
{
    return a < b ? a : b;
}

static runner_end_t turn(run_t *run)
{
    const scenario_t *scenario = run->scenario;
    const runner_options_t *options = run->options;
    uint32_t progress_at = options->progress != NULL ? 0u : scenario->periods;
    uint32_t pause = 0; /* next period with something to do besides the step */
    for (uint32_t period = 0; period < scenario->periods; period++) {
        if (period == pause) {
            if (!course_change(&run->course, period, &run->result->error)) {
                return RUNNER_REFUSED;
            }
            if (period == progress_at) {
                options->progress(options->progress_context, (double)period / (double)scenario->periods);
                progress_at += RUNNER_PROGRESS_PERIODS;
            }
            pause = sooner(course_next(&run->course, period), progress_at);
        }
        rig_step(run->rig);
        if (!run->was_on) {
            look_whether_on(run);
        }
        look_whether_it_obeys(run, period);
        if (options->history != NULL) {
            look_for_fault(run);
        }
        if (options->stop != NULL && *options->stop != 0) {
            return period + 1u < scenario->periods ? RUNNER_INTERRUPTED : RUNNER_COMPLETE;
        }
    }
    return RUNNER_COMPLETE;
}

/* ---- verdicts ---- */

static void judge(run_t *run)
{
    runner_result_t *result = run->result;
    for (uint32_t n = 0; n < result->verdict_count; n++) {
        runner_verdict_t *verdict = &result->verdicts[n];
        const scenario_expect_t *expect = verdict->expect;
        verdict->samples = run->tallies[n].of.count;
        verdict->value = tally_value(&run->tallies[n].of, expect->statistic);
        if (result->periods < expect->end) {
            verdict->judgement = RUNNER_NOT_JUDGED;
        } else if (expect->measure) {
            verdict->judgement = RUNNER_MEASURED;
        } else {
            const bool met = verdict->value >= expect->at_least && verdict->value <= expect->at_most;
            verdict->never_on = result->never_on && expect->needs_drive;
            verdict->judgement = met && !verdict->never_on ? RUNNER_MET : RUNNER_FAILED;
        }
        result->failed += verdict->judgement == RUNNER_FAILED || verdict->judgement == RUNNER_NOT_JUDGED;
    }
}

/* True if the limits of an expectation include the first value and exclude the second. */
static bool names(const scenario_expect_t *expect, double value, double other)
{
    return !expect->measure && expect->minus == NULL && value >= expect->at_least &&
           value <= expect->at_most && (other < expect->at_least || other > expect->at_most);
}

/* True if an expectation names the fault that is latched at the end, or the refusal that lasts to the end. */
static bool names_end(const run_t *run, const scenario_expect_t *expect)
{
    const runner_result_t *result = run->result;
    const bool fault = result->fault_reason != 0;
    const uint32_t moment = fault ? result->fault_period : result->periods;
    if (result->never_on && expect->needs_none) {
        return true;
    }
    if (expect->end < moment) {
        return false;
    }
    if (expect->row == rig_row_by_name("state")) {
        return names(expect, result->state, run->on_state);
    }
    return expect->row == rig_row_by_name(fault ? "fault_reason" : "refusal") &&
           names(expect, fault ? result->fault_reason : result->refusal, 0.0);
}

/* The rule for an unexpected end, as described in runner.h. */
static bool ends_unexpectedly(const run_t *run)
{
    const runner_result_t *result = run->result;
    const bool refused = disobeys(run) && result->periods - run->obeyed >= rig_periods(RUNNER_LASTING);
    if (result->end != RUNNER_COMPLETE || (result->fault_reason == 0 && !refused)) {
        return false;
    }
    for (uint32_t n = 0; n < run->scenario->expect_count; n++) {
        if (names_end(run, &run->scenario->expects[n])) {
            return false;
        }
    }
    return true;
}

static double wall_seconds(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* True if an expectation names this end, or a fault at any time. */
static int32_t why_not_on(const run_t *run)
{
    const bool now =
        rig_value(run->rig, "enable") == run->on_request && rig_value(run->rig, "state") != run->on_state;
    return now ? why_off(run->rig) : run->result->never_on ? run->why_not : 0;
}

static void run_and_judge(run_t *run)
{
    runner_result_t *result = run->result;
    if (!set_up(run)) {
        return;
    }
    const double start = wall_seconds();
    result->end = turn(run);
    result->seconds = wall_seconds() - start;
    if (run->options->progress != NULL && result->end == RUNNER_COMPLETE) {
        run->options->progress(run->options->progress_context, 1.0);
    }
    result->periods = rig_period(run->rig);
    result->state = (int32_t)rig_value(run->rig, "state");
    result->fault_reason = (int32_t)rig_value(run->rig, "fault_reason");
    result->fault_period = (uint32_t)rig_value(run->rig, "fault_period");
    result->refusal = (int32_t)rig_value(run->rig, "refusal");
    result->warnings =
        (uint64_t)rig_value(run->rig, "warnings_2") << 32 | (uint64_t)rig_value(run->rig, "warnings");
    result->manoeuvre = (int32_t)rig_value(run->rig, "manoeuvre");
    result->never_on = run->was_asked && !run->was_on;
    result->not_on = why_not_on(run);
    result->hash = rig_hash(run->rig);
    judge(run);
    result->unexpected = ends_unexpectedly(run);
    result->failed += result->unexpected ? 1u : 0u;
}

bool runner_run(scenario_t *scenario, const runner_options_t *options, runner_result_t *result)
{
    memset(result, 0, sizeof *result);
    if (options->history != NULL) {
        memset(options->history, 0, sizeof *options->history);
    }
    result->end = RUNNER_REFUSED;
    result->seed = options->has_seed ? options->seed : scenario->seed;
    if (!scenario_check(scenario, &result->error)) {
        return false;
    }
    run_t run = {
        .scenario = scenario,
        .options = options,
        .result = result,
        .every = options->record_every > 0u ? options->record_every : 1u,
        .state = rig_row_by_name("state")->id,
        .enable = rig_row_by_name("enable")->id,
        .on_state = table_choice(rig_row_by_name("state"), "operation_enabled"),
        .on_request = table_choice(rig_row_by_name("enable"), "on"),
    };
    run.rig = rig_create(result->seed);
    run.tallies = calloc(scenario->expect_count + 1u, sizeof *run.tallies);
    result->verdicts = calloc(scenario->expect_count + 1u, sizeof *result->verdicts);
    if (run.rig == NULL || run.tallies == NULL || result->verdicts == NULL ||
        !course_init(&run.course, scenario, run.rig)) {
        (void)refuse(&run, "run", "not enough memory");
    } else {
        result->verdict_count = scenario->expect_count;
        for (uint32_t n = 0; n < scenario->expect_count; n++) {
            result->verdicts[n] = (runner_verdict_t){
                .expect = &scenario->expects[n], .value = (double)NAN, .judgement = RUNNER_NOT_JUDGED};
        }
        run_and_judge(&run);
    }
    rig_free(run.rig);
    free(run.tallies);
    course_free(&run.course);
    return result->end != RUNNER_REFUSED;
}

void runner_result_free(runner_result_t *result)
{
    free(result->verdicts);
    result->verdicts = NULL;
    result->verdict_count = 0;
}
