/* Commands of `lagless connect` that take long: wait, watch, record, capture. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host_sim/cli/arguments.h"
#include "host_sim/cli/cli.h"
#include "host_sim/cli/connect.h"
#include "host_sim/cli/output.h"
#include "host_sim/lab/json.h"
#include "host_sim/lab/recorder.h"
#include "host_sim/lab/replay_file.h"
#include "host_sim/lab/scenario_parts.h"
#include "host_sim/lab/times.h"
#include "host_sim/lab/units.h"
#include "host_sim/rig/rig.h"
#include "settings/reasons.h"

#define WAIT_TIMEOUT   10.0 /* [s] of `wait until`, if none is given */
#define WATCH_EVERY    0.5  /* [s] */
#define NO_SAMPLES     5.0  /* [s] of real time without a sample, after which no more are expected */
#define SETTINGS_MAX   256u
#define CAPTURE_PERIOD 1u /* an additional column before those of the buffer */

/* ---- wait ---- */

typedef enum { BELOW, AT_MOST, ABOVE, AT_LEAST, EQUAL, NOT_EQUAL, COMPARISONS } comparison_t;
static const char *const comparison_texts[COMPARISONS] = {"<", "<=", ">", ">=", "==", "!="};

typedef struct {
    const table_row_t *row;
    comparison_t comparison;
    double limit; /* [unit of the row] */
    double last;
} condition_t;

static bool holds(const condition_t *condition)
{
    const double value = condition->last;
    const double limit = condition->limit;
    switch (condition->comparison) {
    case BELOW:
        return value < limit;
    case AT_MOST:
        return value <= limit;
    case ABOVE:
        return value > limit;
    case AT_LEAST:
        return value >= limit;
    case EQUAL:
        return value == limit;
    case NOT_EQUAL:
        return value != limit;
    case COMPARISONS:
        break;
    }
    return false;
}

static bool look_condition(session_t *session, void *context, bool *met)
{
    condition_t *condition = context;
    if (!connect_get_row(session, condition->row, &condition->last)) {
        return false;
    }
    *met = holds(condition);
    return true;
}

static bool read_condition(session_t *session, uint32_t count, char **words, condition_t *condition)
{
    char text[CONNECT_LINE];
    if (count < 3u) {
        return connect_fail(
            session, "wait: the condition after until is missing; accepted: NAME < <= > >= == != VALUE");
    }
    condition->row = connect_row(session, words[0]);
    if (condition->row == NULL) {
        return false;
    }
    uint32_t n = 0;
    while (n < COMPARISONS && strcmp(words[1], comparison_texts[n]) != 0) {
        n++;
    }
    if (n == COMPARISONS) {
        return connect_fail(session, "%s: not a comparison; accepted: < <= > >= == !=", words[1]);
    }
    condition->comparison = (comparison_t)n;
    connect_joined(text, count - 2u, words + 2);
    const scenario_place_t nowhere = {0, 0};
    scenario_error_t error;
    units_error_t ignored;
    const bool pure = condition->row->kind != SLOT_ENUM && units_read(text, "-", &condition->limit, &ignored);
    return pure || scenario_row_text_value(condition->row, text, &condition->limit, nowhere, &error) ||
           connect_fail(session, "%s: %s", condition->row->name, error.message);
}

static bool wait_until(session_t *session, uint32_t count, char **words)
{
    condition_t condition;
    connect_clause_t timeout = {.key = "timeout"};
    double seconds = WAIT_TIMEOUT;
    bool met;
    if (!connect_clauses(session, &count, words, &timeout, 1u) ||
        !read_condition(session, count, words, &condition) ||
        (timeout.given && !connect_time(session, timeout.value, &seconds)) ||
        !connect_wait_for(session, seconds, look_condition, &condition, &met)) {
        return false;
    }
    char limit[UNITS_TEXT_SIZE];
    char last[UNITS_TEXT_SIZE];
    units_row_text(last, condition.last, condition.row);
    if (!met) {
        return connect_fail(session, "%s %s %s: not within %g s; it is %s", condition.row->name,
                            comparison_texts[condition.comparison],
                            units_row_text(limit, condition.limit, condition.row), seconds, last);
    }
    if (session->json) {
        connect_json(condition.row, condition.last);
    } else {
        printf("%-22s %s\n", condition.row->name, last);
    }
    return true;
}

bool connect_wait(session_t *session, uint32_t count, char **words)
{
    char text[CONNECT_LINE];
    double seconds;
    bool met;
    if (count != 0u && strcmp(words[0], "until") == 0) {
        return wait_until(session, count - 1u, words + 1);
    }
    if (count == 0u) {
        return connect_fail(
            session,
            "wait: a time or a condition is missing; accepted: wait 2 s, or wait until NAME > VALUE");
    }
    return connect_time(session, connect_joined(text, count, words), &seconds) &&
           connect_wait_for(session, seconds, NULL, NULL, &met);
}

/* ---- watch ---- */

static bool watch_line(session_t *session, const table_row_t *const *rows, uint32_t count, bool first)
{
    if (session->json) {
        printf("%s{\"n\": 0", first ? "" : ", ");
    }
    for (uint32_t n = 0; n < count; n++) {
        char text[UNITS_TEXT_SIZE];
        double value;
        if (!connect_get_row(session, rows[n], &value)) {
            printf(session->json ? "}" : "");
            return false;
        }
        if (session->json) {
            connect_json(rows[n], value);
        } else {
            printf("%s%s %s", n != 0u ? "  " : "", rows[n]->name, units_row_text(text, value, rows[n]));
        }
    }
    printf(session->json ? "}" : "\n");
    fflush(stdout);
    return true;
}

bool connect_watch(session_t *session, uint32_t count, char **words)
{
    connect_clause_t clauses[] = {{.key = "for"}, {.key = "every"}};
    const table_row_t *rows[CONNECT_WORDS];
    double every = WATCH_EVERY;
    double left = 0.0;
    bool met;
    if (!connect_clauses(session, &count, words, clauses, 2u) ||
        (clauses[0].given && !connect_time(session, clauses[0].value, &left)) ||
        (clauses[1].given && !connect_time(session, clauses[1].value, &every))) {
        return false;
    }
    const uint32_t found = connect_rows(session, count, words, rows, CONNECT_WORDS);
    if (found == 0u) {
        return false;
    }
    if (!session->terminal && !clauses[0].given) {
        return connect_fail(session, "watch: a script needs a duration; write: watch %s for 2 s",
                            rows[0]->name);
    }
    printf(session->json ? ", \"samples\": [" : "");
    bool good = watch_line(session, rows, found, true);
    for (; good && (!clauses[0].given || left > 0.5 * every) && !connect_stopped(); left -= every) {
        /* Without an end, Ctrl-C ends it, and that is no failure. */
        good = connect_wait_for(session, every, NULL, NULL, &met) && watch_line(session, rows, found, false);
        if (!good && !clauses[0].given && strcmp(session->error.text, "interrupted") == 0) {
            good = true;
            break;
        }
    }
    printf(session->json ? "]" : "");
    return good;
}

/* ---- what recordings share ---- */

typedef struct {
    recorder_value_t values[SETTINGS_MAX];
    uint32_t count;
} settings_t;

/* The present parameters and requests of the drive. */
static bool read_settings(session_t *session, settings_t *settings)
{
    settings->count = 0;
    for (uint32_t t = 0; t < rig_table_count(); t++) {
        const table_t *table = rig_table(t);
        master_extension_t extension;
        uint32_t address;
        const bool wanted = master_place(&table->rows[0], &extension, &address) &&
                            (extension == MASTER_PARAMS || extension == MASTER_REQUESTS);
        for (uint32_t n = 0; wanted && n < table->count && settings->count < SETTINGS_MAX; n++) {
            const table_row_t *row = &table->rows[n];
            recorder_value_t *value = &settings->values[settings->count++];
            *value = (recorder_value_t){.name = row->name, .unit = row->unit};
            if (!connect_get_row(session, row, &value->value)) {
                return false;
            }
        }
    }
    return true;
}

static bool read_formats(session_t *session, const char *text, uint32_t *formats)
{
    *formats = recorder_formats(text);
    return (*formats != 0u && (*formats & ~RECORDER_SAMPLED) == 0u) ||
           connect_fail(session, "--format %s: accepted: csv, mat, mdf, separated by commas", text);
}

typedef struct {
    connect_clause_t *out, *name, *format;
    uint32_t every, periods;
    const char *standard; /* name without one */
} place_t;

static recorder_t *open_recorder(session_t *session, const place_t *place, const table_row_t *const *rows,
                                 uint32_t count)
{
    static settings_t settings;
    char title[320];
    uint32_t ids[RIG_TAP_MAX];
    uint32_t formats = RECORDER_CSV | RECORDER_MAT;
    recorder_error_t error;
    const char *name = place->name->given ? place->name->value : place->standard;
    if (strchr(name, '/') != NULL) {
        connect_fail(session, "--name %s: a name without slashes; the folder is --out's", name);
        return NULL;
    }
    if ((place->format->given && !read_formats(session, place->format->value, &formats)) ||
        !read_settings(session, &settings)) {
        return NULL;
    }
    if (!output_folder(place->out->value)) {
        connect_fail(session, "--out %s: this folder cannot be made; give another one", place->out->value);
        return NULL;
    }
    if (!output_allowed_recording(place->out->value, name, formats)) {
        connect_fail(session, "%s/%s.*: give another --name, or start lagless connect with --force",
                     place->out->value, name);
        return NULL;
    }
    for (uint32_t n = 0; n < count; n++) {
        ids[n] = rows[n]->id;
    }
    snprintf(title, sizeof title, "%s of %s", place->standard, master_name(session->master));
    const recorder_options_t options = {
        .folder = place->out->value,
        .name = name,
        .formats = formats,
        .ids = ids,
        .count = count,
        .every = place->every,
        .periods = place->periods,
        .meta = {.program = CLI_VERSION,
                 .commit = LAGLESS_COMMIT,
                 .scenario = "",
                 .scenario_text = "",
                 .title = title,
                 .values = settings.values,
                 .value_count = settings.count},
    };
    recorder_t *recorder = recorder_open(&options, &error);
    if (recorder == NULL) {
        connect_fail(session, "%s", error.text);
    }
    return recorder;
}

/* Prints the position in the script before an error. */
static bool close_recorder(session_t *session, recorder_t *recorder, const place_t *place, const char *ended)
{
    recorder_error_t error;
    const char *name = place->name->given ? place->name->value : place->standard;
    const unsigned long long samples = recorder_samples(recorder);
    if (!recorder_close(recorder, ended, &error)) {
        return connect_fail(session, "%s", error.text);
    }
    if (session->json) {
        printf(", \"samples\": %llu", samples);
        connect_json_text("folder", place->out->value);
        connect_json_text("name", name);
    } else {
        printf("%llu samples in %s/%s\n", samples, place->out->value, name);
    }
    return true;
}

/* ---- record ---- */

typedef struct {
    recorder_t *recorder;
    uint32_t first;   /* [periods] of the first sample */
    uint32_t periods; /* [periods] wanted */
    uint64_t count;   /* [-] samples so far */
    bool done;
} recording_t;

static void take_sample(void *context, uint32_t period, const uint32_t *slots, uint32_t count)
{
    recording_t *recording = context;
    recording->first = recording->count == 0u ? period : recording->first;
    recording->done = recording->done || period - recording->first >= recording->periods;
    if (!recording->done) {
        recording->count++;
        /* the step that the drive counts as its first is that of period 0 */
        recorder_sink(recording->recorder, period - 1u, slots, count);
    }
}

/* false: no samples arrived, or the link was lost. */
static bool await_samples(session_t *session, recording_t *recording)
{
    uint64_t before = 0;
    double still = 0.0;
    while (!recording->done && !connect_stopped()) {
        const double pause = 0.02;
        if (!master_wait(session->master, pause)) {
            return connect_fail(session, "%s: %s", master_name(session->master),
                                master_lost(session->master));
        }
        still = recording->count == before ? still + pause : 0.0;
        before = recording->count;
        if (still > NO_SAMPLES) {
            return connect_fail(session, "the drive sends no more samples; check the link and record again");
        }
    }
    return true;
}

static bool run_recording(session_t *session, const place_t *place, const table_row_t *const *rows,
                          uint32_t count)
{
    recording_t recording = {.periods = place->periods};
    master_error_t ignored;
    recording.recorder = open_recorder(session, place, rows, count);
    if (recording.recorder == NULL) {
        return false;
    }
    if (!master_daq_start(session->master, rows, count, place->every, take_sample, &recording,
                          &session->error)) {
        recorder_abandon(recording.recorder);
        return false;
    }
    const bool came = await_samples(session, &recording);
    const char *ended = came && recording.done ? "complete" : "interrupted";
    recording.done = true; /* later samples are not used */
    (void)master_daq_stop(session->master, &ignored);
    const master_daq_t sum = master_daq(session->master);
    if (!close_recorder(session, recording.recorder, place, ended) || !came) {
        return false;
    }
    const uint64_t share = sum.samples != 0u ? (sum.samples + sum.missing) / sum.samples + 1u : 255u;
    return sum.gaps == 0u ||
           connect_fail(
               session,
               "%llu samples are missing at %u places: the line is too slow; fewer names, or every %llu",
               (unsigned long long)sum.missing, (unsigned)sum.gaps,
               (unsigned long long)(share * place->every < 255u ? share * place->every : 255u));
}

static bool record_rows(session_t *session, uint32_t count, char **words, const table_row_t **rows,
                        uint32_t *found)
{
    *found = connect_rows(session, count, words, rows, MASTER_DAQ_MAX);
    for (uint32_t n = 0; n < *found; n++) {
        master_extension_t extension;
        uint32_t address;
        if (!master_place(rows[n], &extension, &address) || extension != MASTER_SIGNALS) {
            return connect_fail(session, "%s: only signals are recorded; `signals` lists them",
                                rows[n]->name);
        }
    }
    return *found != 0u;
}

bool connect_record(session_t *session, uint32_t count, char **words)
{
    static connect_clause_t clauses[5];
    const table_row_t *rows[MASTER_DAQ_MAX];
    uint32_t found;
    double seconds;
    uint64_t every = 1;
    memset(clauses, 0, sizeof clauses);
    static const char *const keys[] = {"for", "every", "--out", "--name", "--format"};
    for (uint32_t n = 0; n < 5u; n++) {
        clauses[n].key = keys[n];
    }
    if (!connect_clauses(session, &count, words, clauses, 5u) ||
        !record_rows(session, count, words, rows, &found)) {
        return false;
    }
    if (!clauses[0].given || !clauses[2].given) {
        return connect_fail(
            session, "record: duration or folder is missing; write: record NAME... for 2 s --out FOLDER");
    }
    if (!connect_time(session, clauses[0].value, &seconds)) {
        return false;
    }
    if (clauses[1].given && !arguments_whole(clauses[1].value, 1u, 255u, &every)) {
        return connect_fail(session, "every %s: accepted: whole numbers of periods, 1 to 255",
                            clauses[1].value);
    }
    const place_t place = {.out = &clauses[2],
                           .name = &clauses[3],
                           .format = &clauses[4],
                           .every = (uint32_t)every,
                           .periods = rig_periods(seconds),
                           .standard = "recording"};
    return run_recording(session, &place, rows, found);
}

/* ---- capture ---- */

static bool capture_order(session_t *session, const char *order)
{
    master_refusal_t refusal;
    return master_order(session->master, order, &refusal, &session->error);
}

static bool capture_show(session_t *session)
{
    static const char *const names[] = {"capture_state", "capture_on",      "capture_source", "capture_level",
                                        "capture_after", "capture_periods", "capture_at"};
    double columns;
    if (!connect_get_named(session, "capture_signals", &columns)) {
        return false;
    }
    for (uint32_t n = 0; n < sizeof names / sizeof names[0] + (uint32_t)columns; n++) {
        char name[24];
        char text[UNITS_TEXT_SIZE];
        double value;
        const uint32_t fixed = sizeof names / sizeof names[0];
        if (n < fixed) {
            snprintf(name, sizeof name, "%s", names[n]);
        } else {
            snprintf(name, sizeof name, "capture_%u", (unsigned)(n - fixed + 1u));
        }
        const table_row_t *row = connect_row(session, name);
        if (row == NULL || !connect_get_row(session, row, &value)) {
            return false;
        }
        const bool is_id = n >= fixed || strcmp(name, "capture_source") == 0;
        const table_row_t *signal = is_id ? rig_row((uint32_t)value) : NULL;
        if (signal != NULL && session->json) {
            connect_json_text(name, signal->name);
        } else if (session->json) {
            connect_json(row, value);
        } else {
            printf("%-22s %s\n", name, signal != NULL ? signal->name : units_row_text(text, value, row));
        }
    }
    return true;
}

/* on fault | on command | on SIGNAL above|below VALUE */
static bool capture_on(session_t *session, uint32_t count, char **words)
{
    char text[CONNECT_LINE];
    if (count == 1u && (strcmp(words[0], "fault") == 0 || strcmp(words[0], "command") == 0)) {
        return connect_set_choice(session, "capture_on", words[0]);
    }
    if (count < 3u || (strcmp(words[1], "above") != 0 && strcmp(words[1], "below") != 0)) {
        return connect_fail(session, "capture on: the trigger is missing; accepted: fault, command, SIGNAL "
                                     "above VALUE, SIGNAL below VALUE");
    }
    const table_row_t *row = connect_row(session, words[0]);
    double level;
    if (row == NULL) {
        return false;
    }
    const scenario_place_t nowhere = {0, 0};
    scenario_error_t error;
    units_error_t ignored;
    connect_joined(text, count - 2u, words + 2);
    if (!units_read(text, "-", &level, &ignored) &&
        !scenario_row_text_value(row, text, &level, nowhere, &error)) {
        return connect_fail(session, "%s: %s", row->name, error.message);
    }
    return connect_set_named(session, "capture_source", (double)row->id) &&
           connect_set_named(session, "capture_level", level) &&
           connect_set_choice(session, "capture_on", words[1]);
}

static bool capture_signals(session_t *session, uint32_t count, char **words)
{
    const table_row_t *rows[MASTER_CAPTURE_MAX];
    uint32_t found;
    found = connect_rows(session, count, words, rows, MASTER_CAPTURE_MAX);
    for (uint32_t n = 0; n < found; n++) {
        char name[24];
        snprintf(name, sizeof name, "capture_%u", (unsigned)(n + 1u));
        if (!connect_set_named(session, name, (double)rows[n]->id)) {
            return false;
        }
    }
    return found != 0u && connect_set_named(session, "capture_signals", (double)found);
}

static bool capture_after(session_t *session, uint32_t count, char **words)
{
    char text[CONNECT_LINE];
    uint64_t periods;
    double seconds;
    connect_joined(text, count, words);
    if (!arguments_whole(text, 0u, UINT32_MAX, &periods)) {
        if (!connect_time(session, text, &seconds)) {
            return false;
        }
        periods = rig_periods(seconds);
    }
    return connect_set_named(session, "capture_after", (double)periods);
}

static bool is_held(session_t *session, void *context, bool *met)
{
    double state;
    (void)context;
    if (!connect_get_named(session, "capture_state", &state)) {
        return false;
    }
    *met = connect_is("capture_state", state, "held");
    return true;
}

static bool capture_wait(session_t *session, uint32_t count, char **words)
{
    char text[CONNECT_LINE];
    double seconds = WAIT_TIMEOUT;
    bool met;
    if ((count != 0u && !connect_time(session, connect_joined(text, count, words), &seconds)) ||
        !connect_wait_for(session, seconds, is_held, NULL, &met)) {
        return false;
    }
    return met || connect_fail(session, "the capture buffer was not triggered within %g s", seconds);
}

/* The newest period is `after` ones past the trigger. */
static bool write_capture(session_t *session, const place_t *place, const master_capture_t *capture)
{
    const table_row_t *rows[CAPTURE_PERIOD + MASTER_CAPTURE_MAX] = {connect_row(session, "period")};
    memcpy(rows + CAPTURE_PERIOD, capture->rows, sizeof capture->rows);
    recorder_t *recorder = open_recorder(session, place, rows, CAPTURE_PERIOD + capture->count);
    if (recorder == NULL) {
        return false;
    }
    const uint32_t oldest = capture->at + capture->after - (capture->periods - 1u);
    for (uint32_t n = 0; n < capture->periods; n++) {
        uint32_t slots[CAPTURE_PERIOD + MASTER_CAPTURE_MAX] = {oldest + n};
        memcpy(slots + CAPTURE_PERIOD, capture->slots + n * capture->count, capture->count * sizeof *slots);
        recorder_sink(recorder, slots[0] - 1u, slots, CAPTURE_PERIOD + capture->count);
    }
    return close_recorder(session, recorder, place, "capture");
}

static bool capture_read(session_t *session, uint32_t count, char **words)
{
    static connect_clause_t clauses[3];
    static const char *const keys[] = {"--out", "--name", "--format"};
    master_capture_t capture;
    memset(clauses, 0, sizeof clauses);
    for (uint32_t n = 0; n < 3u; n++) {
        clauses[n].key = keys[n];
    }
    if (!connect_clauses(session, &count, words, clauses, 3u)) {
        return false;
    }
    if (!clauses[0].given || count != 0u) {
        return connect_fail(session,
                            "capture: the folder of read is missing; write: capture read --out FOLDER");
    }
    if (!master_capture(session->master, &capture, &session->error)) {
        return false;
    }
    const place_t place = {.out = &clauses[0],
                           .name = &clauses[1],
                           .format = &clauses[2],
                           .every = 1u,
                           .periods = capture.periods,
                           .standard = "capture"};
    const bool good = write_capture(session, &place, &capture);
    free(capture.slots);
    return good;
}

/* The record for `lagless replay`. */
static bool capture_save(session_t *session, uint32_t count, char **words)
{
    uint32_t slot_count;
    if (count != 1u) {
        return connect_fail(session, "capture save: accepted: one file name; write: capture save FILE");
    }
    if (!output_allowed(words[0])) {
        return connect_fail(session, "%s: give another name, or start lagless connect with --force",
                            words[0]);
    }
    uint32_t *slots = master_record(session->master, &slot_count, &session->error);
    if (slots == NULL) {
        return false;
    }
    FILE *file = output_open(words[0]);
    if (file != NULL) {
        replay_file_write(file, master_epk(session->master), slots, slot_count);
    }
    rig_record_t record;
    rig_record_head(slots, &record);
    free(slots);
    if (!output_close(file, words[0])) {
        return connect_fail(session, "%s: the record was not written; the drive still holds it", words[0]);
    }
    if (session->json) {
        connect_json_text("file", words[0]);
        printf(", \"periods\": %u, \"period\": %u", (unsigned)record.rows, (unsigned)record.at);
    } else {
        const reason_row_t *reason = reason_by_number(record.reason);
        printf("%u periods up to %s in period %u in %s\n", (unsigned)record.rows,
               record.reason != REASON_NONE && reason != NULL ? reason->name : "the trigger",
               (unsigned)record.at, words[0]);
    }
    return true;
}

bool connect_capture(session_t *session, uint32_t count, char **words)
{
    static const struct {
        const char *name;
        bool (*run)(session_t *session, uint32_t count, char **words);
        const char *order;
    } parts[] = {{"on", capture_on, NULL},
                 {"signals", capture_signals, NULL},
                 {"after", capture_after, NULL},
                 {"wait", capture_wait, NULL},
                 {"read", capture_read, NULL},
                 {"save", capture_save, NULL},
                 {"arm", NULL, "capture_arm"},
                 {"trigger", NULL, "capture_trigger"},
                 {"release", NULL, "capture_release"}};
    for (uint32_t n = 0; count != 0u && n < sizeof parts / sizeof parts[0]; n++) {
        if (strcmp(words[0], parts[n].name) != 0) {
            continue;
        }
        if (parts[n].run != NULL) {
            return parts[n].run(session, count - 1u, words + 1);
        }
        return count == 1u ? capture_order(session, parts[n].order)
                           : connect_fail(session, "%s: no argument is accepted", words[1]);
    }
    return count == 0u
               ? capture_show(session)
               : connect_fail(session,
                              "capture %s: accepted: on, signals, after, arm, trigger, wait, read, save, "
                              "release; "
                              "alone it shows the buffer",
                              words[0]);
}
