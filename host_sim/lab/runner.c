#include "host_sim/lab/runner.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "host_sim/lab/units.h"

/* Statistics of one expectation. All kinds are kept: choosing costs as much as counting. */
typedef struct {
    uint32_t begin, end;  /* [periods] */
    uint32_t slot, minus; /* [-] places in the tap; minus RIG_TAP_MAX: none */
    slot_kind_t kind, minus_kind;
    uint32_t count;
    double mean, squares_about, squares, min, max, last;
} tally_t;

/* A row on its way from one value to another. */
typedef struct {
    const scenario_event_t *event;
    const scenario_setting_t *setting;
    double start;
} ramp_t;

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
    tally_t *tallies;      /* those to come, then those that count; in no order of their own */
    uint32_t tally_count;
    /* events and ramps */
    uint32_t next_event;
    ramp_t *ramps;
    uint32_t ramp_count;
    bool was_held; /* the drive's history, by a fault */
} run_t;

/* ---- statistics ---- */

static double number_in(uint32_t slot, slot_kind_t kind)
{
    float value;
    switch (kind) {
    case SLOT_UINT:
        return (double)slot;
    case SLOT_INT:
    case SLOT_ENUM:
        return (double)(int32_t)slot;
    case SLOT_FLOAT:
    case SLOT_KINDS:
        break;
    }
    memcpy(&value, &slot, sizeof value);
    return (double)value;
}

static void count_sample(tally_t *tally, double x)
{
    tally->count++;
    const double from_mean = x - tally->mean;
    tally->mean += from_mean / tally->count;
    tally->squares_about += from_mean * (x - tally->mean);
    tally->squares += x * x;
    /* the negations let a NaN in, and never out again */
    tally->min = !(x >= tally->min) && tally->min == tally->min ? x : tally->min;
    tally->max = !(x <= tally->max) && tally->max == tally->max ? x : tally->max;
    tally->last = x;
}

static void on_sample(void *context, uint32_t period, const uint32_t *slots, uint32_t count)
{
    run_t *run = context;
    (void)count;
    for (uint32_t n = 0; n < run->tally_count; n++) {
        tally_t *tally = &run->tallies[n];
        if (period - tally->begin <
            tally->end - tally->begin) { /* begin <= period < end, in one comparison */
            double x = number_in(slots[tally->slot], tally->kind);
            if (tally->minus != RIG_TAP_MAX) {
                x -= number_in(slots[tally->minus], tally->minus_kind);
            }
            count_sample(tally, x);
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

static double statistic_of(const tally_t *tally, statistic_t statistic)
{
    if (tally->count == 0u) {
        return (double)NAN;
    }
    switch (statistic) {
    case STATISTIC_MEAN:
        return tally->mean;
    case STATISTIC_MIN:
        return tally->min;
    case STATISTIC_MAX:
        return tally->max;
    case STATISTIC_PEAK:
        return fabs(tally->min) > fabs(tally->max) || tally->min != tally->min ? fabs(tally->min)
                                                                               : fabs(tally->max);
    case STATISTIC_SD:
        return sqrt(tally->squares_about / tally->count);
    case STATISTIC_RMS:
        return sqrt(tally->squares / tally->count);
    case STATISTIC_LAST:
        return tally->last;
    case STATISTICS:
        break;
    }
    return (double)NAN;
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
        return refuse(run, "record", "accepted: 1 to 64 rows");
    }
    /* The recorded rows first and as they are, so that the sink gets a piece of the tap. */
    for (uint32_t n = 0; n < options->record_count && options->sink != NULL; n++) {
        run->rows[run->row_count++] = options->record[n];
    }
    for (uint32_t n = 0; n < scenario->expect_count; n++) {
        const scenario_expect_t *expect = &scenario->expects[n];
        const uint32_t slot = tap_row(run, expect->row->id);
        const uint32_t minus = expect->minus != NULL ? tap_row(run, expect->minus->id) : RIG_TAP_MAX;
        if (slot == RIG_TAP_MAX || (expect->minus != NULL && minus == RIG_TAP_MAX)) {
            return refuse(run, "record",
                          "too many rows recorded and expected together; accepted: up to 64 different ones");
        }
        run->tallies[n] = (tally_t){
            .begin = expect->begin,
            .end = expect->end,
            .slot = slot,
            .minus = minus,
            .kind = expect->row->kind,
            .minus_kind = expect->minus != NULL ? expect->minus->kind : SLOT_FLOAT,
            .min = (double)INFINITY,
            .max = -(double)INFINITY,
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
    const scenario_t *scenario = run->scenario;
    const scenario_event_t *initial = &scenario->events[0];
    if (!scenario_set(run->rig, initial->settings, initial->count)) {
        scenario_refused(scenario, run->rig, initial->settings, initial->count, &run->result->error);
        return false;
    }
    if (scenario->has_start) {
        rig_set_motion(run->rig, scenario->start_angle, scenario->start_speed);
    }
    if (!set_up_tap(run)) {
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

/* ---- events and ramps ---- */

static bool refused(run_t *run, const scenario_setting_t *settings, uint32_t count, uint32_t period)
{
    scenario_error_t *error = &run->result->error;
    scenario_refused(run->scenario, run->rig, settings, count, error);
    const size_t used = strlen(error->message);
    snprintf(error->message + used, sizeof error->message - used, " (at %.9g s)",
             period * RIG_PERIOD_SECONDS);
    return false;
}

static void end_ramp_of(run_t *run, const table_row_t *row)
{
    for (uint32_t n = 0; n < run->ramp_count; n++) {
        if (run->ramps[n].setting->row == row) {
            run->ramp_count--;
            memmove(&run->ramps[n], &run->ramps[n + 1u], (run->ramp_count - n) * sizeof run->ramps[0]);
            return;
        }
    }
}

static bool is_ramped(const scenario_event_t *event, const scenario_setting_t *setting)
{
    return event->ramp_periods > 0u && setting->row->kind == SLOT_FLOAT;
}

/* Rows that switch, in their order; then those that ramp start from where they are. */
static bool begin_event(run_t *run, const scenario_event_t *event, uint32_t period)
{
    uint32_t first = 0;
    for (uint32_t n = 0; n <= event->count; n++) {
        if (n < event->count && !is_ramped(event, &event->settings[n])) {
            end_ramp_of(run, event->settings[n].row);
            continue;
        }
        if (n > first && !scenario_set(run->rig, &event->settings[first], n - first)) {
            return refused(run, &event->settings[first], n - first, period);
        }
        first = n + 1u;
    }
    for (uint32_t n = 0; n < event->count; n++) {
        const scenario_setting_t *setting = &event->settings[n];
        double start = 0.0;
        if (is_ramped(event, setting) && rig_get(run->rig, setting->row->id, &start)) {
            end_ramp_of(run, setting->row);
            run->ramps[run->ramp_count++] = (ramp_t){event, setting, start};
        }
    }
    return true;
}

static bool move_ramps(run_t *run, uint32_t period)
{
    const scenario_event_t *event = NULL; /* that parameters changed for */
    uint32_t kept = 0;
    for (uint32_t n = 0; n < run->ramp_count; n++) {
        const ramp_t ramp = run->ramps[n];
        const uint32_t done = period - ramp.event->period;
        const uint32_t all = ramp.event->ramp_periods;
        const double end = ramp.setting->value;
        const double value =
            done >= all ? end : ramp.start + (end - ramp.start) * ((double)done / (double)all);
        if (done > 0u && !rig_set(run->rig, ramp.setting->row->id, value)) {
            return refused(run, ramp.setting, 1u, period);
        }
        event = done > 0u && scenario_is_param(ramp.setting->row) ? ramp.event : event;
        if (done < all) {
            run->ramps[kept++] = ramp;
        }
    }
    run->ramp_count = kept;
    return event == NULL || rig_apply(run->rig) || refused(run, event->settings, event->count, period);
}

/* Everything that is due before this period. */
static bool change(run_t *run, uint32_t period)
{
    const scenario_t *scenario = run->scenario;
    while (run->next_event < scenario->event_count && scenario->events[run->next_event].period == period) {
        if (!begin_event(run, &scenario->events[run->next_event], period)) {
            return false;
        }
        run->next_event++;
    }
    return run->ramp_count == 0u || move_ramps(run, period);
}

/* ---- history of a fault ---- */

static void keep_history(rig_t *rig, runner_history_t *history)
{
    uint32_t period = 0;
    history->periods = rig_history_count(rig);
    history->fault_reason = (int32_t)rig_value(rig, "fault_reason");
    history->fault_period = (uint32_t)rig_value(rig, "fault_period");
    memcpy(history->rows, rig_history_rows(), sizeof history->rows);
    for (uint32_t n = 0; n < history->periods; n++) {
        memcpy(history->slots[n], rig_history(rig, history->periods - 1u - n, &period),
               sizeof history->slots[n]);
    }
}

static void look_for_fault(run_t *run)
{
    const bool held = rig_history_held(run->rig);
    if (held && !run->was_held) {
        keep_history(run->rig, run->options->history);
    }
    run->was_held = held;
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
            if (!change(run, period)) {
                return RUNNER_REFUSED;
            }
            if (period == progress_at) {
                options->progress(options->progress_context, (double)period / (double)scenario->periods);
                progress_at += RUNNER_PROGRESS_PERIODS;
            }
            const bool more = run->next_event < scenario->event_count;
            const uint32_t event_at = more ? scenario->events[run->next_event].period : scenario->periods;
            pause = sooner(run->ramp_count > 0u ? period + 1u : event_at, progress_at);
        }
        rig_step(run->rig);
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
        verdict->samples = run->tallies[n].count;
        verdict->value = statistic_of(&run->tallies[n], expect->statistic);
        if (result->periods < expect->end) {
            verdict->judgement = RUNNER_NOT_JUDGED;
        } else {
            const bool met = verdict->value >= expect->at_least && verdict->value <= expect->at_most;
            verdict->judgement = met ? RUNNER_MET : RUNNER_FAILED;
        }
        result->failed += verdict->judgement != RUNNER_MET;
    }
}

static double wall_seconds(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* The fault that stopped it, else what refuses it in the last period. */
static int32_t why_not_on(rig_t *rig, const runner_result_t *result)
{
    const bool wanted = (int32_t)rig_value(rig, "enable") == table_choice(rig_row_by_name("enable"), "on") &&
                        result->state != table_choice(rig_row_by_name("state"), "operation_enabled");
    return !wanted ? 0 : result->fault_reason != 0 ? result->fault_reason : result->refusal;
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
    result->manoeuvre = (int32_t)rig_value(run->rig, "manoeuvre");
    result->not_on = why_not_on(run->rig, result);
    result->hash = rig_hash(run->rig);
    judge(run);
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
        .next_event = 1u,
    };
    uint32_t settings = 0;
    for (uint32_t n = 0; n < scenario->event_count; n++) {
        settings += scenario->events[n].count;
    }
    run.rig = rig_create(result->seed);
    run.tallies = calloc(scenario->expect_count + 1u, sizeof *run.tallies);
    run.ramps = calloc(settings + 1u, sizeof *run.ramps);
    result->verdicts = calloc(scenario->expect_count + 1u, sizeof *result->verdicts);
    if (run.rig == NULL || run.tallies == NULL || run.ramps == NULL || result->verdicts == NULL) {
        (void)refuse(&run, "run", "not enough memory");
    } else {
        result->verdict_count = scenario->expect_count;
        for (uint32_t n = 0; n < scenario->expect_count; n++) {
            result->verdicts[n] =
                (runner_verdict_t){&scenario->expects[n], (double)NAN, 0u, RUNNER_NOT_JUDGED};
        }
        run_and_judge(&run);
    }
    rig_free(run.rig);
    free(run.tallies);
    free(run.ramps);
    return result->end != RUNNER_REFUSED;
}

void runner_result_free(runner_result_t *result)
{
    free(result->verdicts);
    result->verdicts = NULL;
    result->verdict_count = 0;
}

/* Appends to a text of this size; what does not fit is cut. */
static void append(char *to, size_t size, const char *before, const char *text)
{
    const size_t used = strlen(to);
    snprintf(to + used, size - used, "%s%s", before, text);
}

/* A choice by its name where the statistic picks one of the samples. */
static const char *value_text(char to[UNITS_TEXT_SIZE], double value, const scenario_expect_t *expect)
{
    const bool picks = expect->statistic == STATISTIC_MIN || expect->statistic == STATISTIC_MAX ||
                       expect->statistic == STATISTIC_LAST;
    return expect->row->kind == SLOT_ENUM && (!picks || expect->minus != NULL)
               ? units_text(to, value, "-")
               : units_row_text(to, value, expect->row);
}

const char *runner_verdict_text(const runner_verdict_t *verdict, char *to, size_t size)
{
    const scenario_expect_t *expect = verdict->expect;
    char text[UNITS_TEXT_SIZE];
    char name[128];
    to[0] = '\0';
    if (expect->name[0] != '\0') {
        append(to, size, expect->name, ": ");
    }
    scenario_row_name(expect->row, name, sizeof name);
    append(to, size, statistic_text(expect->statistic), " of ");
    append(to, size, name, "");
    if (expect->minus != NULL) {
        scenario_row_name(expect->minus, name, sizeof name);
        append(to, size, " - ", name);
    }
    append(to, size, " from ", units_text(text, expect->from, "s"));
    append(to, size, " to ", units_text(text, expect->to, "s"));
    if (verdict->samples == 0u) {
        append(to, size, ": not reached", "");
    } else {
        append(to, size, ": ", value_text(text, verdict->value, expect));
    }
    const bool exact = expect->at_least == expect->at_most;
    if (isfinite(expect->at_least)) {
        append(to, size, exact ? ", exactly " : ", at least ", value_text(text, expect->at_least, expect));
    }
    if (isfinite(expect->at_most) && !exact) {
        append(to, size, ", at most ", value_text(text, expect->at_most, expect));
    }
    return to;
}
