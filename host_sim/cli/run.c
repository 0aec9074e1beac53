/* `lagless run SCENARIO`. */
#include <argp.h>
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "host_sim/cli/arguments.h"
#include "host_sim/cli/cli.h"
#include "host_sim/cli/library.h"
#include "host_sim/cli/output.h"
#include "host_sim/cli/plot.h"
#include "host_sim/cli/stop.h"
#include "host_sim/cli/traces.h"
#include "host_sim/lab/json.h"
#include "host_sim/lab/names.h"
#include "host_sim/lab/recorder.h"
#include "host_sim/lab/replay_file.h"
#include "host_sim/lab/runner.h"
#include "host_sim/lab/scenario.h"
#include "host_sim/lab/times.h"
#include "host_sim/lab/units.h"
#include "settings/reasons.h"

#define ISR_TICKS    600u /* [1/150 MHz] 4 us: duration of the interrupt that VCD shows */
#define SETTINGS_MAX 256u

/* Recorded signals, if neither scenario nor command line names any. */
static const char *const default_rows[] = {"omega_m_ref", "true_omega_m", "i_d", "i_q", "theta_err", "u_dc"};

/* The signals of the panels of --plot, which are recorded in addition to those of the scenario. */
static const char *const plot_rows[] = {
    "state",     "manoeuvre",   "fault_reason",  "warnings",   "warnings_2", "omega_m_ref", "true_omega_m",
    "omega_m",   "true_torque", "load_torque",   "i_d_ref",    "i_d",        "i_q_ref",     "i_q",
    "i_q_lower", "i_q_upper",   "true_i_a",      "true_i_b",   "true_i_c",   "u_d",         "u_q",
    "u_dc",      "theta_err",   "theta_hat_err", "theta_sigma"};

typedef struct {
    arguments_scenario_t of;
    const char *record;
    const char *every;
    const char *folder;
    const char *formats;
    const char *plot; /* formats of the pictures; NULL: none */
    bool json, traces, quiet;
} options_t;

static bool is_picture(const char *word)
{
    return strncmp(word, "html", 4) == 0 || strncmp(word, "png", 3) == 0 || strncmp(word, "svg", 3) == 0
               ? strspn(word, "htmlpngsv,") == strlen(word)
               : false;
}

static error_t parse(int key, char *argument, struct argp_state *state)
{
    options_t *options = state->input;
    switch (key) {
    case 'r':
        options->record = argument;
        return 0;
    case 'e':
        options->every = argument;
        return 0;
    case 'o':
        options->folder = argument;
        return 0;
    case 'f':
        options->formats = argument;
        return 0;
    case 'p':
        options->plot = argument != NULL ? argument : "html";
        return 0;
    case 'j':
        options->json = true;
        return 0;
    case 't':
        options->traces = true;
        return 0;
    case 'q':
        options->quiet = true;
        return 0;
    case ARGP_KEY_ARG:
        /* `--plot png`: the formats of an option with an optional argument follow a = */
        if (options->plot != NULL &&
            (is_picture(argument) || (options->of.scenario != NULL && is_picture(options->of.scenario)))) {
            const char *formats = is_picture(argument) ? argument : options->of.scenario;
            argp_error(state, "%s: write --plot=%s", formats, formats);
        }
        return arguments_scenario(key, argument, state, &options->of);
    case ARGP_KEY_END:
        if (options->traces && !options->json) {
            argp_error(state, "--traces needs --json: the samples are part of its object");
        }
        return 0;
    case ARGUMENTS_FORCE_KEY:
        return arguments_force(key);
    default:
        return arguments_scenario(key, argument, state, &options->of);
    }
}

/* ---- what the command line changes ---- */

static bool complain(const char *what, const char *value, const char *accepted)
{
    fprintf(stderr, "lagless run: %s %s: accepted: %s\n", what, value, accepted);
    return false;
}

static bool read_formats(const char *text, uint32_t *formats)
{
    *formats = recorder_formats(text);
    return *formats != 0u || complain("--format", text, "csv, mat, vcd, mdf, separated by commas");
}

static bool add_row(uint32_t ids[RIG_TAP_MAX], uint32_t *count, const char *name)
{
    scenario_error_t error;
    const table_row_t *row = scenario_row(name, &error);
    if (row == NULL) {
        fprintf(stderr, "lagless run: --record %s: %s\n", error.name, error.message);
        return false;
    }
    for (uint32_t n = 0; n < *count; n++) {
        if (ids[n] == row->id) {
            fprintf(stderr, "lagless run: --record %s: the name is given twice; accepted: once\n", name);
            return false;
        }
    }
    if (*count == RIG_TAP_MAX) {
        fprintf(stderr, "lagless run: --record: more than %u names; accepted: at most that many\n",
                RIG_TAP_MAX);
        return false;
    }
    ids[(*count)++] = row->id;
    return true;
}

static void add_named(uint32_t ids[RIG_TAP_MAX], uint32_t *count, const char *name)
{
    const uint32_t id = rig_row_by_name(name)->id;
    uint32_t n = 0;
    while (n < *count && ids[n] != id) {
        n++;
    }
    if (n == *count && *count < RIG_TAP_MAX) {
        ids[(*count)++] = id;
    }
}

/* Selects the rows: those of the command line; else those of the scenario and of the panels of --plot; else
 * the usual ones. */
static bool choose_rows(const options_t *options, const scenario_t *scenario, uint32_t ids[RIG_TAP_MAX],
                        uint32_t *count)
{
    *count = 0;
    if (options->record != NULL) {
        char *copy = strdup(options->record);
        bool good = copy != NULL;
        for (char *name = good ? strtok(copy, ",") : NULL; good && name != NULL; name = strtok(NULL, ",")) {
            good = add_row(ids, count, name);
        }
        free(copy);
        return good && (*count > 0u || complain("--record", "\"\"", "names of rows, separated by commas"));
    }
    for (uint32_t n = 0; n < scenario->record_count; n++) {
        ids[(*count)++] = scenario->record[n];
    }
    for (size_t n = 0; options->plot != NULL && n < sizeof plot_rows / sizeof plot_rows[0]; n++) {
        add_named(ids, count, plot_rows[n]);
    }
    const bool none = *count == 0u;
    for (size_t n = 0; none && n < sizeof default_rows / sizeof default_rows[0]; n++) {
        add_named(ids, count, default_rows[n]);
    }
    return true;
}

/* The recorded or printed signals, and the interval between samples. */
static bool choose(const options_t *options, const scenario_t *scenario, uint32_t ids[RIG_TAP_MAX],
                   uint32_t *count, uint64_t *every)
{
    *every = scenario->every;
    return arguments_number("run", "--every", options->every, 1u, SCENARIO_EVERY_MAX, every) &&
           choose_rows(options, scenario, ids, count);
}

/* VCD shows gate edges, which the averaged fidelity does not have. */
static bool stays_switched(const scenario_t *scenario)
{
    const table_row_t *fidelity = rig_row_by_name("fidelity");
    bool switched = scenario_initial(scenario, fidelity) == 0.0;
    for (uint32_t e = 0; e < scenario->event_count; e++) {
        for (uint32_t n = 0; n < scenario->events[e].count; n++) {
            const scenario_setting_t *setting = &scenario->events[e].settings[n];
            switched = switched && (setting->row != fidelity || setting->value == 0.0);
        }
    }
    return switched;
}

/* ---- the recording ---- */

typedef struct {
    recorder_value_t values[SETTINGS_MAX];
    char names[SETTINGS_MAX][64];
    uint32_t count;
} settings_t;

/* Every row that determines the run, with its value at t = 0. */
static void list_settings(const scenario_t *scenario, settings_t *settings)
{
    settings->count = 0;
    for (uint32_t t = 0; t < rig_table_count(); t++) {
        const table_t *table = rig_table(t);
        for (uint32_t n = 0; n < table->count && settings->count < SETTINGS_MAX; n++) {
            const table_row_t *row = &table->rows[n];
            if (row->access != TABLE_READ) {
                char *name = settings->names[settings->count];
                scenario_row_name(row, name, sizeof settings->names[0]);
                settings->values[settings->count++] =
                    (recorder_value_t){name, scenario_initial(scenario, row), row->unit};
            }
        }
    }
}

/* The events of the recording, with their times. */
static bool note_events(recorder_t *recorder, const scenario_t *scenario)
{
    bool good = true;
    for (uint32_t e = 1; good && e < scenario->event_count; e++) {
        const scenario_event_t *event = &scenario->events[e];
        char when[32];
        char text[512] = "";
        size_t used = 0;
        for (uint32_t n = 0; n < event->count && used < sizeof text; n++) {
            char value[UNITS_TEXT_SIZE];
            const scenario_setting_t *setting = &event->settings[n];
            used += (size_t)snprintf(text + used, sizeof text - used, "%s%s = %s", n > 0u ? ", " : "",
                                     setting->row->name, units_row_text(value, setting->value, setting->row));
        }
        if (event->ramp_periods > 0u && used < sizeof text) {
            snprintf(text + used, sizeof text - used, " within %.9g s", event->ramp);
        }
        snprintf(when, sizeof when, "%.9g s", event->time);
        good = recorder_note(recorder, RECORDER_EVENT, when, text);
    }
    return good;
}

typedef struct {
    recorder_t *recorder;
    const char *folder;
    char name[256];
    uint32_t formats;
    uint32_t ids[RIG_TAP_MAX];
    uint32_t count;
    uint64_t every;
    recorder_options_t how; /* its pointers refer to this struct and to the scenario */
    const char *pictures;   /* formats of those drawn; NULL: none */
    traces_t traces;
    /* of a fault */
    runner_history_t history;
    char history_name[272];
} recording_t;

/* The folder of --out, or with --plot alone a new one. */
static bool make_folder(const options_t *options, const scenario_t *scenario, recording_t *recording)
{
    static char fresh[PATH_SIZE];
    if (options->folder != NULL) {
        recording->folder = options->folder;
        return output_folder(options->folder);
    }
    recording->folder = fresh;
    scenario_file_name(scenario->path, recording->name, sizeof recording->name);
    return output_fresh_folder(fresh, "runs", recording->name);
}

/* All that the run may write: the recording, the history of a fault, pictures. */
static bool is_allowed(const options_t *options, const recording_t *recording)
{
    char fault[272];
    bool good = output_allowed_recording(recording->folder, recording->name, recording->formats);
    snprintf(fault, sizeof fault, "%s_fault", recording->name);
    good = good && output_allowed_in(recording->folder, fault, ".csv") &&
           output_allowed_in(recording->folder, recording->name, ".replay");
    return good && (options->plot == NULL ||
                    (output_allowed_pictures(recording->folder, recording->name, options->plot) &&
                     output_allowed_pictures(recording->folder, fault, options->plot)));
}

static int open_recording(const options_t *options, const scenario_t *scenario, uint64_t seed,
                          recording_t *recording)
{
    static settings_t settings;
    recorder_error_t error;
    if (!read_formats(options->formats != NULL ? options->formats : "csv", &recording->formats)) {
        return EXIT_USAGE;
    }
    if ((recording->formats & RECORDER_VCD) != 0u && !stays_switched(scenario)) {
        fprintf(
            stderr,
            "lagless run: --format vcd: the scenario uses the averaged fidelity, which has no gate edges; "
            "accepted with fidelity = \"switched\"\n");
        return EXIT_USAGE;
    }
    if (options->plot != NULL && (recording->formats & (RECORDER_CSV | RECORDER_MAT)) == 0u) {
        fprintf(stderr,
                "lagless run: --plot draws a CSV or MAT file: accepted with csv or mat in --format\n");
        return EXIT_USAGE;
    }
    if (!make_folder(options, scenario, recording)) {
        return EXIT_INTERNAL;
    }
    scenario_file_name(scenario->path, recording->name, sizeof recording->name);
    if (!is_allowed(options, recording)) {
        return EXIT_USAGE;
    }
    list_settings(scenario, &settings);
    recording->how = (recorder_options_t){
        .folder = recording->folder,
        .name = recording->name,
        .formats = recording->formats,
        .ids = recording->ids,
        .count = recording->count,
        .every = (uint32_t)recording->every,
        .periods = scenario->periods,
        .isr_ticks = ISR_TICKS,
        .meta = {.program = CLI_VERSION,
                 .commit = LAGLESS_COMMIT,
                 .scenario = recording->name,
                 .scenario_text = scenario->source,
                 .title = scenario->title,
                 .seed = seed,
                 .values = settings.values,
                 .value_count = settings.count},
    };
    recording->recorder = recorder_open(&recording->how, &error);
    if (recording->recorder == NULL) {
        fprintf(stderr, "lagless run: %s\n", error.text);
    }
    if (recording->recorder == NULL) {
        return error.io ? EXIT_INTERNAL : EXIT_USAGE;
    }
    return note_events(recording->recorder, scenario) ? EXIT_DONE : EXIT_INTERNAL;
}

/* NAME_fault.csv: a recording of the last periods before the last fault, from the drive's history. A run
 * without a fault deletes such a file of an earlier run. */
static bool write_history(recording_t *recording, recorder_error_t *error)
{
    const runner_history_t *history = &recording->history;
    snprintf(recording->history_name, sizeof recording->history_name, "%s_fault", recording->name);
    if (history->periods == 0u) {
        char file[300];
        char path[PATH_SIZE];
        snprintf(file, sizeof file, "%s.csv", recording->history_name);
        if (output_path(path, recording->folder, file)) {
            (void)remove(path);
        }
        return true;
    }

    const uint32_t columns = history->columns;
    uint32_t ids[1u + CAPTURE_COLUMNS] = {rig_row_by_name("period")->id};
    memcpy(&ids[1], history->rows, columns * sizeof ids[0]);
    recorder_options_t how = recording->how;
    how.name = recording->history_name;
    how.formats = RECORDER_CSV;
    how.ids = ids;
    how.count = 1u + columns;
    how.every = 1u;
    how.periods = history->periods;
    recorder_t *recorder = recorder_open(&how, error);
    if (recorder == NULL) {
        return false;
    }
    for (uint32_t n = 0; n < history->periods; n++) {
        /* the step that the drive counts as its first is that of period 0 */
        uint32_t slots[1u + CAPTURE_COLUMNS] = {history->last_period - (history->periods - 1u - n)};
        memcpy(&slots[1], &history->slots[columns * n], columns * sizeof slots[0]);
        recorder_sink(recorder, slots[0] - 1u, slots, 1u + columns);
    }
    return recorder_close(recorder, "fault", error);
}

/* NAME.replay: the record of the run's last fault, for `lagless replay`. */
static bool write_record(const recording_t *recording)
{
    const runner_history_t *history = &recording->history;
    char file[300];
    char path[PATH_SIZE];
    char tables[24];
    snprintf(file, sizeof file, "%s.replay", recording->name);
    if (!output_path(path, recording->folder, file)) {
        return false;
    }
    if (history->record_count == 0u) {
        (void)remove(path);
        return true;
    }
    FILE *to = output_open(path);
    if (to != NULL) {
        replay_file_write(to, replay_file_tables(tables), history->record, history->record_count);
    }
    return output_close(to, path);
}

/* ---- results ---- */

typedef struct {
    char text[32];
} choice_name_t;

static choice_name_t choice_name(const char *row, int32_t value)
{
    choice_name_t name;
    const char *choice = rig_row_by_name(row)->choices;
    for (int32_t n = 0; n < value && choice != NULL; n++) {
        choice = strchr(choice, '|');
        choice = choice != NULL ? choice + 1 : NULL;
    }
    snprintf(name.text, sizeof name.text, "%.*s", choice != NULL ? (int)strcspn(choice, "|") : 1,
             choice != NULL ? choice : "?");
    return name;
}

static bool is_choice(const char *row, int32_t value, const char *name)
{
    return value == table_choice(rig_row_by_name(row), name);
}

static const char *reason_name(int32_t number)
{
    const reason_row_t *row = reason_by_number(number);
    return row != NULL ? row->name : "?";
}

/* Prints the end state, and the reason why the drive does not follow its requests. */
static void print_end(const runner_result_t *result)
{
    char when[TIMES_TEXT_SIZE];
    const reason_row_t *why = result->not_on != REASON_NONE ? reason_by_number(result->not_on) : NULL;
    printf(", end state %s", choice_name("state", result->state).text);
    if (!is_choice("manoeuvre", result->manoeuvre, "off") &&
        !is_choice("manoeuvre", result->manoeuvre, "run")) {
        printf(", manoeuvre %s", choice_name("manoeuvre", result->manoeuvre).text);
    }
    if (result->fault_reason != REASON_NONE) {
        printf(", fault %s at %s s (`lagless explain %s`)", reason_name(result->fault_reason),
               times_text(when, result->fault_period), reason_name(result->fault_reason));
    } else if (why != NULL) {
        printf(", refused: %s", why->name);
    }
    printf("\n");
    if (why != NULL) {
        printf("%s: %s; %s\n", result->never_on ? "never on" : "not on", why->text, why->remedy);
    }
    for (uint32_t n = 0; n < (uint32_t)FAULTS; n++) {
        const reason_row_t *row =
            (result->warnings >> n & 1u) != 0u ? reason_by_number(fault_rows[n].reason) : NULL;
        if (row != NULL) {
            printf("warning %s: %s; %s\n", row->name, row->text, row->remedy);
        }
    }
}

static void print_text(const scenario_t *scenario, const runner_result_t *result, bool quiet)
{
    const bool colours = output_colours(stdout);
    char text[512];
    char when[TIMES_TEXT_SIZE];
    if (!quiet) {
        printf("%s\n%s s simulated in %.2f s (%.0f x real time), seed %" PRIu64, scenario->title,
               times_text(when, result->periods), result->seconds,
               result->seconds > 0.0 ? result->periods * RIG_PERIOD_SECONDS / result->seconds : 0.0,
               result->seed);
        print_end(result);
    }
    for (uint32_t n = 0; n < result->verdict_count; n++) {
        const runner_verdict_t *verdict = &result->verdicts[n];
        static const char *const words[] = {"met", "FAILED", "not judged", "measured"};
        const bool wrong = verdict->judgement == RUNNER_FAILED || verdict->judgement == RUNNER_NOT_JUDGED;
        if (quiet && !wrong) {
            continue;
        }
        printf("%s%-10s%s  %s\n",
               !colours                                ? ""
               : verdict->judgement == RUNNER_MEASURED ? "\033[36m"
               : wrong                                 ? "\033[31m"
                                                       : "\033[32m",
               words[verdict->judgement], colours ? "\033[0m" : "",
               runner_verdict_text(verdict, text, sizeof text));
    }
    if (result->unexpected) {
        printf("%sFAILED    %s  end of the run: %s\n", colours ? "\033[31m" : "", colours ? "\033[0m" : "",
               runner_unexpected_text(result, text, sizeof text));
    }
}

static const char *const judgements[] = {"met", "failed", "not_judged", "measured"};

static void print_limit(const char *key, double limit)
{
    printf(", \"%s\": ", key);
    json_number(stdout, limit);
}

static void print_not_on(int32_t number)
{
    const reason_row_t *why = number != REASON_NONE ? reason_by_number(number) : NULL;
    if (why == NULL) {
        printf("null");
        return;
    }
    printf("{\"reason\": \"%s\", \"text\": ", why->name);
    json_text(stdout, why->text);
    printf(", \"remedy\": ");
    json_text(stdout, why->remedy);
    printf("}");
}

/* The list of expectations, or that of measures. Only expectations have verdicts. */
static void print_verdicts(const runner_result_t *result, bool measures)
{
    const char *separator = "";
    for (uint32_t n = 0; n < result->verdict_count; n++) {
        const runner_verdict_t *verdict = &result->verdicts[n];
        const scenario_expect_t *expect = verdict->expect;
        if (expect->measure != measures) {
            continue;
        }
        printf("%s\n  {\"name\": ", separator);
        separator = ",";
        json_text(stdout, expect->name);
        printf(", \"signal\": \"%s\", \"minus\": ", expect->row->name);
        json_text(stdout, expect->minus != NULL ? expect->minus->name : NULL);
        printf(", \"statistic\": \"%s\", \"unit\": ", statistic_text(expect->statistic));
        json_text(stdout, expect->row->unit);
        printf(", \"from_s\": %.9g, \"to_s\": %.9g, \"value\": ", expect->begin * RIG_PERIOD_SECONDS,
               expect->end * RIG_PERIOD_SECONDS);
        json_number(stdout, verdict->value);
        if (!measures) {
            print_limit("at_least", expect->at_least);
            print_limit("at_most", expect->at_most);
        }
        printf(", \"verdict\": \"%s\"", judgements[verdict->judgement]);
        if (!measures) {
            printf(", \"because\": %s", verdict->never_on ? "\"the drive never came on\"" : "null");
        }
        printf("}");
    }
}

static void print_json(const scenario_t *scenario, const runner_result_t *result,
                       const recording_t *recording)
{
    printf("{\"scenario\": ");
    json_text(stdout, scenario->path);
    printf(", \"title\": ");
    json_text(stdout, scenario->title);
    printf(", \"end\": \"%s\", \"seed\": %" PRIu64 ", \"periods\": %" PRIu32 ", \"seconds\": %.9g",
           result->end == RUNNER_COMPLETE ? "complete" : "interrupted", result->seed, result->periods,
           result->periods * RIG_PERIOD_SECONDS);
    printf(", \"seconds_per_second\": ");
    json_number(stdout, result->periods * RIG_PERIOD_SECONDS / result->seconds);
    printf(", \"state\": \"%s\", \"fault_reason\": \"%s\", \"fault_period\": %" PRIu32
           ", \"refusal\": \"%s\"",
           choice_name("state", result->state).text, reason_name(result->fault_reason), result->fault_period,
           reason_name(result->refusal));
    char unexpected[200];
    printf(", \"state_hash\": \"%016" PRIx64 "\", \"failed\": %" PRIu32 ", \"unexpected_end\": ",
           result->hash, result->failed);
    json_text(stdout,
              result->unexpected ? runner_unexpected_text(result, unexpected, sizeof unexpected) : NULL);
    printf(", \"expectations\": [");
    print_verdicts(result, false);
    printf("], \"files\": [");
    const char *separator = "";
    char path[PATH_SIZE];
    for (uint32_t n = 0; n < RECORDER_FORMATS; n++) {
        if ((recording->formats >> n & 1u) != 0u) {
            snprintf(path, sizeof path, "%.3800s/%.200s.%s", recording->folder, recording->name,
                     recorder_ending(n));
            printf("%s", separator);
            json_text(stdout, path);
            separator = ", ";
        }
    }
    if (recording->history.periods > 0u) {
        snprintf(path, sizeof path, "%.3800s/%.260s.csv", recording->folder, recording->history_name);
        printf("%s", separator);
        json_text(stdout, path);
        separator = ", ";
    }
    if (recording->history.record_count > 0u) {
        snprintf(path, sizeof path, "%.3800s/%.200s.replay", recording->folder, recording->name);
        printf("%s", separator);
        json_text(stdout, path);
        separator = ", ";
    }
    for (const char *word = recording->pictures; word != NULL && *word != '\0'; word += strspn(word, ",")) {
        const int length = (int)strcspn(word, ",");
        snprintf(path, sizeof path, "%.3800s/%.200s.%.*s", recording->folder, recording->name, length, word);
        printf("%s", separator);
        json_text(stdout, path);
        separator = ", ";
        word += length;
    }
    printf("], \"manoeuvre\": \"%s\", \"not_on\": ", choice_name("manoeuvre", result->manoeuvre).text);
    print_not_on(result->not_on);
    printf(", \"measures\": [");
    print_verdicts(result, true);
    printf("]");
    if (recording->traces.ids != NULL) {
        printf(", \"traces\": ");
        traces_print(&recording->traces);
    }
    printf("}\n");
}

/* ---- the command ---- */

static bool note_verdicts(recorder_t *recorder, const runner_result_t *result)
{
    bool good = true;
    for (uint32_t n = 0; good && n < result->verdict_count; n++) {
        char text[512];
        const runner_verdict_t *verdict = &result->verdicts[n];
        good = recorder_note(recorder, RECORDER_VERDICT, judgements[verdict->judgement],
                             runner_verdict_text(verdict, text, sizeof text));
    }
    if (good && result->unexpected) {
        char text[200];
        good = recorder_note(recorder, RECORDER_VERDICT, judgements[RUNNER_FAILED],
                             runner_unexpected_text(result, text, sizeof text));
    }
    return good;
}

/* Pictures of the recording, from its CSV file or, without one, from its MAT file. */
static int draw(const options_t *options, recording_t *recording)
{
    char file[300];
    char path[PATH_SIZE];
    snprintf(file, sizeof file, "%s.%s", recording->name,
             (recording->formats & RECORDER_CSV) != 0u ? "csv" : "mat");
    if (!output_path(path, recording->folder, file)) {
        return EXIT_INTERNAL;
    }
    const int drawn = plot_draw("run", path, NULL, options->plot, options->quiet);
    recording->pictures = drawn == EXIT_DONE ? options->plot : NULL;
    return drawn == EXIT_DONE ? EXIT_DONE : EXIT_INTERNAL;
}

/* Writes all files and prints their names. The history is written first, because no other run uses these
 * names until the recording is closed. */
static int close_recording(const options_t *options, const runner_result_t *result, recording_t *recording)
{
    recorder_error_t error;
    char when[TIMES_TEXT_SIZE];
    int exit_code = EXIT_DONE;
    const runner_history_t *history = &recording->history;
    const bool kept = write_history(recording, &error);
    if (!kept) {
        fprintf(stderr, "lagless run: %s\n", error.text);
        exit_code = EXIT_INTERNAL;
    }
    const bool recorded = write_record(recording);
    exit_code = recorded ? exit_code : EXIT_INTERNAL;

    const uint64_t samples = recorder_samples(recording->recorder);
    (void)note_verdicts(recording->recorder, result);
    if (!recorder_close(recording->recorder, result->end == RUNNER_COMPLETE ? "complete" : "interrupted",
                        &error)) {
        fprintf(stderr, "lagless run: %s\n", error.text);
        exit_code = EXIT_INTERNAL;
    } else if (result->end == RUNNER_INTERRUPTED) {
        fprintf(stderr,
                "lagless run: stopped at %s s; the %" PRIu64 " samples until then are kept in %s/%s.*\n",
                times_text(when, result->periods), samples, recording->folder, recording->name);
    } else if (!options->quiet) {
        fprintf(stderr, "%" PRIu64 " samples in %s/%s.*\n", samples, recording->folder, recording->name);
    }
    if (recorded && history->record_count > 0u && !options->quiet) {
        fprintf(stderr, "the record of the fault for `lagless replay` in %s/%s.replay\n", recording->folder,
                recording->name);
    }
    if (kept && history->periods > 0u && !options->quiet) {
        fprintf(stderr, "the last %" PRIu32 " periods up to fault %s at %s s in %s/%s.csv\n",
                history->periods, reason_name(history->fault_reason), times_text(when, history->fault_period),
                recording->folder, recording->history_name);
    }
    return exit_code;
}

/* The sink that receives samples and edges. */
static void set_sinks(const options_t *options, recording_t *recording, runner_options_t *how)
{
    if (recording->recorder != NULL) {
        how->sink = recorder_sink;
        how->sink_context = recording->recorder;
        how->edge_sink = (recording->formats & RECORDER_VCD) != 0u ? recorder_edge : NULL;
        how->edge_context = recording->recorder;
        how->history = &recording->history;
    }
    if (options->traces) {
        recording->traces = (traces_t){.ids = recording->ids,
                                       .count = recording->count,
                                       .next = how->sink,
                                       .next_context = how->sink_context};
        how->sink = traces_sink;
        how->sink_context = &recording->traces;
    }
    if (how->sink != NULL) {
        how->record = recording->ids;
        how->record_count = recording->count;
        how->record_every = (uint32_t)recording->every;
    }
}

/* Writes and prints the results; returns the exit code. */
static int tell(const options_t *options, const scenario_t *scenario, const runner_result_t *result,
                recording_t *recording)
{
    const bool good = result->failed == 0u && result->end == RUNNER_COMPLETE;
    int exit_code = good ? EXIT_DONE : EXIT_FAILED;
    if (recording->recorder != NULL) {
        const int written = close_recording(options, result, recording);
        exit_code = written != EXIT_DONE ? written : exit_code;
    } else if (result->end == RUNNER_INTERRUPTED) {
        char when[TIMES_TEXT_SIZE];
        fprintf(stderr, "lagless run: stopped at %s s\n", times_text(when, result->periods));
    }
    /* The pictures are printed last, because the user opens them next. JSON lists them as well. */
    if (!options->json) {
        print_text(scenario, result, options->quiet);
    }
    if (options->plot != NULL && exit_code != EXIT_INTERNAL) {
        const int drawn = draw(options, recording);
        exit_code = drawn != EXIT_DONE ? drawn : exit_code;
    }
    if (options->json) {
        print_json(scenario, result, recording);
    }
    if (recording->traces.full) {
        fprintf(stderr,
                "lagless run: --traces: more than %" PRIu64
                " samples do not fit; record fewer with a larger --every\n",
                recording->traces.samples);
        exit_code = EXIT_INTERNAL;
    }
    return exit_code;
}

static int run(const options_t *options, scenario_t *scenario)
{
    static recording_t recording;
    recording = (recording_t){.folder = ""};
    runner_options_t how = {0};
    output_progress_t progress = output_progress_begin();
    runner_result_t result;
    uint64_t seed = scenario->seed;
    uint64_t stop_period = 0;

    if (!arguments_number("run", "--seed", options->of.seed, 0u, INT64_MAX, &seed)) {
        return EXIT_USAGE;
    }
    const char *stop_text = getenv("LAGLESS_STOP");
    if (!arguments_number("run", "LAGLESS_STOP", stop_text, 0u, UINT32_MAX, &stop_period)) {
        return EXIT_USAGE;
    }
    if (options->plot != NULL && !plot_formats("run", options->plot)) {
        return EXIT_USAGE;
    }
    const bool wanted = options->folder != NULL || options->plot != NULL;
    if (!wanted && (options->formats != NULL ||
                    (!options->traces && (options->record != NULL || options->every != NULL)))) {
        fprintf(stderr, "lagless run: --record and --format need --out FOLDER, where the recording goes\n");
        return EXIT_USAGE;
    }
    if (!choose(options, scenario, recording.ids, &recording.count, &recording.every)) {
        return EXIT_USAGE;
    }
    const int opened = wanted ? open_recording(options, scenario, seed, &recording) : EXIT_DONE;
    if (opened != EXIT_DONE) {
        return opened;
    }

    how.has_seed = true;
    how.seed = seed;
    how.has_stop_period = stop_text != NULL;
    how.stop_period = (uint32_t)stop_period;
    set_sinks(options, &recording, &how);
    if (!options->quiet && progress.wanted) {
        how.progress = output_progress;
        how.progress_context = &progress;
    }
    how.stop = stop_on_signal();
    const bool ran = runner_run(scenario, &how, &result);
    output_progress_end(&progress);
    if (!ran) {
        library_say("run", &result.error);
        recorder_abandon(recording.recorder);
        traces_free(&recording.traces);
        runner_result_free(&result);
        return EXIT_USAGE;
    }

    const int exit_code = tell(options, scenario, &result, &recording);
    traces_free(&recording.traces);
    runner_result_free(&result);
    return exit_code;
}

int command_run(int argc, char **argv)
{
    static const struct argp_option rows[] = {
        ARGUMENTS_SCENARIO,
        ARGUMENTS_BOARD,
        {"record", 'r', "NAMES", 0, "signals to record, separated by commas, instead of the scenario's", 0},
        {"every", 'e', "N", 0, "record every N-th period", 0},
        {"out", 'o', "FOLDER", 0, "folder for the recording", 0},
        {"format", 'f', "FORMATS", 0, "csv (default), mat, vcd, mdf, separated by commas", 0},
        {"plot", 'p', "FORMATS", OPTION_ARG_OPTIONAL,
         "plot the recording: html (default, a page with zoom), png, svg, separated by commas; without --out "
         "into a new folder below runs",
         0},
        ARGUMENTS_FORCE,
        {"json", 'j', NULL, 0, "one JSON object on stdout", 0},
        {"traces", 't', NULL, 0, "add the recorded samples to the JSON object", 0},
        {"quiet", 'q', NULL, 0, "print only errors", 0},
        {0},
    };
    static const struct argp argp = {
        rows,
        parse,
        "SCENARIO",
        "Runs a scenario (a TOML file, `-` for stdin, or a name of `lagless scenarios`) and judges it.",
        NULL,
        NULL,
        NULL};
    options_t options = {0};
    if (!arguments_parse(&argp, argc, argv, &options)) {
        return EXIT_USAGE;
    }
    scenario_t *scenario = library_read("run", &options.of);
    if (scenario == NULL) {
        return EXIT_USAGE;
    }
    const int exit_code = run(&options, scenario);
    scenario_free(scenario);
    return exit_code;
}
