/* `lagless run SCENARIO`. */
#include <argp.h>
#include <inttypes.h>
#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "drive/reasons.h"
#include "host_sim/cli/arguments.h"
#include "host_sim/cli/cli.h"
#include "host_sim/cli/library.h"
#include "host_sim/cli/output.h"
#include "host_sim/lab/json.h"
#include "host_sim/lab/names.h"
#include "host_sim/lab/recorder.h"
#include "host_sim/lab/runner.h"
#include "host_sim/lab/scenario.h"
#include "host_sim/lab/times.h"
#include "host_sim/lab/units.h"

#define OVERRIDES_MAX 64
#define ISR_TICKS     600u /* [1/150 MHz] 4 us: how long VCD shows the interrupt to take */
#define PATIENCE      2.0  /* [s] runs beyond this show their progress on a terminal */
#define SETTINGS_MAX  256u

/* Recorded when neither scenario nor command line says what. */
static const char *const default_rows[] = {"omega_m_ref", "true_omega_m", "i_d", "i_q", "theta_err", "u_dc"};

typedef struct {
    const char *scenario;
    const char *overrides[OVERRIDES_MAX];
    size_t override_count;
    const char *seed;
    const char *record;
    const char *every;
    const char *folder;
    const char *formats;
    bool json, quiet;
} options_t;

static volatile sig_atomic_t stop;

static void on_interrupt(int number)
{
    (void)number;
    stop = 1;
}

static error_t parse(int key, char *argument, struct argp_state *state)
{
    options_t *options = state->input;
    switch (key) {
    case 's':
        if (options->override_count == OVERRIDES_MAX) {
            argp_error(state, "--set: at most %d of them", OVERRIDES_MAX);
        }
        options->overrides[options->override_count++] = argument;
        return 0;
    case 'S':
        options->seed = argument;
        return 0;
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
    case 'j':
        options->json = true;
        return 0;
    case 'q':
        options->quiet = true;
        return 0;
    case ARGP_KEY_ARG:
        if (options->scenario != NULL) {
            argp_error(state, "%s: one scenario at a time", argument);
        }
        options->scenario = argument;
        return 0;
    case ARGP_KEY_NO_ARGS:
        argp_error(state, "which scenario? a file, or a name of `lagless scenarios`");
        return 0;
    default:
        return ARGP_ERR_UNKNOWN;
    }
}

/* ---- what the command line changes ---- */

static bool complain(const char *what, const char *value, const char *accepted)
{
    fprintf(stderr, "lagless run: %s %s: accepted %s\n", what, value, accepted);
    return false;
}

static bool read_whole(const char *what, const char *text, uint64_t min, uint64_t max, uint64_t *value)
{
    char accepted[80];
    char *end = NULL;
    const bool digits = text[0] >= '0' && text[0] <= '9';
    *value = digits ? strtoull(text, &end, 10) : 0u;
    if (digits && *end == '\0' && *value >= min && *value <= max && strlen(text) < 20) {
        return true;
    }
    snprintf(accepted, sizeof accepted, "whole numbers %" PRIu64 " to %" PRIu64, min, max);
    return complain(what, text, accepted);
}

static bool read_formats(const char *text, uint32_t *formats)
{
    char copy[64];
    snprintf(copy, sizeof copy, "%s", text);
    *formats = 0;
    for (char *word = strtok(copy, ","); word != NULL; word = strtok(NULL, ",")) {
        if (strcmp(word, "csv") == 0) {
            *formats |= RECORDER_CSV;
        } else if (strcmp(word, "mat") == 0) {
            *formats |= RECORDER_MAT;
        } else if (strcmp(word, "vcd") == 0) {
            *formats |= RECORDER_VCD;
        } else {
            return complain("--format", text, "csv, mat, vcd, separated by commas");
        }
    }
    return *formats != 0u || complain("--format", text, "csv, mat, vcd, separated by commas");
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
            fprintf(stderr, "lagless run: --record %s: it is there twice\n", name);
            return false;
        }
    }
    if (*count == RIG_TAP_MAX) {
        fprintf(stderr, "lagless run: --record: at most %u rows\n", RIG_TAP_MAX);
        return false;
    }
    ids[(*count)++] = row->id;
    return true;
}

/* Which rows: the command line's, else the scenario's, else the usual ones. */
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
    for (size_t n = 0;
         *count == 0u && scenario->record_count == 0u && n < sizeof default_rows / sizeof default_rows[0];
         n++) {
        ids[n] = rig_row_by_name(default_rows[n])->id;
    }
    if (*count == 0u) {
        *count = sizeof default_rows / sizeof default_rows[0];
    }
    return true;
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

/* Every row that decided the run's course, as it was at t = 0. */
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

static const char *base_name(char name[256], const char *path)
{
    const char *slash = strrchr(path, '/');
    snprintf(name, 256, "%s", slash != NULL ? slash + 1 : path);
    const size_t length = strlen(name);
    if (length > 5 && strcmp(name + length - 5, ".toml") == 0) {
        name[length - 5] = '\0';
    }
    return name;
}

typedef struct {
    recorder_t *recorder;
    const char *folder;
    char name[256];
    uint32_t formats;
    uint32_t ids[RIG_TAP_MAX];
    uint32_t count;
    uint64_t every;
    recorder_options_t how; /* points into this and into the scenario */
    /* of a fault */
    runner_history_t history;
    char history_name[272];
} recording_t;

static bool open_recording(const options_t *options, const scenario_t *scenario, uint64_t seed,
                           recording_t *recording)
{
    static settings_t settings;
    recorder_error_t error;
    uint64_t every = scenario->decimation;
    if (!read_formats(options->formats != NULL ? options->formats : "csv", &recording->formats) ||
        (options->every != NULL &&
         !read_whole("--every", options->every, 1u, SCENARIO_DECIMATION_MAX, &every)) ||
        !choose_rows(options, scenario, recording->ids, &recording->count)) {
        return false;
    }
    if ((recording->formats & RECORDER_VCD) != 0u && !stays_switched(scenario)) {
        fprintf(
            stderr,
            "lagless run: --format vcd: the scenario uses the averaged fidelity, which has no gate edges; "
            "accepted with fidelity = \"switched\"\n");
        return false;
    }
    if (!output_folder(options->folder)) {
        return false;
    }
    recording->every = every;
    list_settings(scenario, &settings);
    recording->how = (recorder_options_t){
        .folder = options->folder,
        .name = base_name(recording->name, scenario->path),
        .formats = recording->formats,
        .ids = recording->ids,
        .count = recording->count,
        .every = (uint32_t)every,
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
    return recording->recorder != NULL;
}

/* NAME_fault.csv: what the drive kept of its last periods up to the run's last fault, as a recording of its
 * own. A run without one leaves none behind from an earlier run. */
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

    uint32_t ids[1u + TAP_SLOTS] = {rig_row_by_name("period")->id};
    memcpy(&ids[1], history->rows, sizeof history->rows);
    recorder_options_t how = recording->how;
    how.name = recording->history_name;
    how.formats = RECORDER_CSV;
    how.ids = ids;
    how.count = 1u + TAP_SLOTS;
    how.every = 1u;
    how.periods = history->periods;
    recorder_t *recorder = recorder_open(&how, error);
    if (recorder == NULL) {
        return false;
    }
    for (uint32_t n = 0; n < history->periods; n++) {
        /* the step that the drive counts as its first is that of period 0 */
        uint32_t slots[1u + TAP_SLOTS] = {history->fault_period - (history->periods - 1u - n)};
        memcpy(&slots[1], history->slots[n], sizeof history->slots[n]);
        recorder_sink(recorder, slots[0] - 1u, slots, 1u + TAP_SLOTS);
    }
    return recorder_close(recorder, "fault", error);
}

/* ---- progress ---- */

typedef struct {
    double started; /* [s] */
    bool shown;
} progress_t;

static void show_progress(void *context, double fraction)
{
    progress_t *progress = context;
    const double elapsed = output_seconds() - progress->started;
    /* Shown when the whole run will take longer than one cares to wait without a sign. */
    if (!progress->shown && (elapsed < 0.2 || elapsed < PATIENCE * fraction)) {
        return;
    }
    char bar[41];
    memset(bar, '.', sizeof bar - 1);
    memset(bar, '#', (size_t)(fraction * (double)(sizeof bar - 1)));
    bar[sizeof bar - 1] = '\0';
    fprintf(stderr, "\r[%s] %3.0f %%  %.0f s", bar, 100.0 * fraction, elapsed);
    progress->shown = true;
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

/* The end state, and what keeps the drive from what was asked of it. */
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
        printf("not on: %s; %s\n", why->text, why->remedy);
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
        static const char *const words[] = {"met", "FAILED", "not judged"};
        if (quiet && verdict->judgement == RUNNER_MET) {
            continue;
        }
        printf("%s%-10s%s  %s\n",
               !colours                           ? ""
               : verdict->judgement == RUNNER_MET ? "\033[32m"
                                                  : "\033[31m",
               words[verdict->judgement], colours ? "\033[0m" : "",
               runner_verdict_text(verdict, text, sizeof text));
    }
}

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

static void print_json(const scenario_t *scenario, const runner_result_t *result,
                       const recording_t *recording)
{
    static const char *const words[] = {"met", "failed", "not_judged"};
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
    printf(", \"state_hash\": \"%016" PRIx64 "\", \"failed\": %" PRIu32 ", \"expectations\": [", result->hash,
           result->failed);
    for (uint32_t n = 0; n < result->verdict_count; n++) {
        const runner_verdict_t *verdict = &result->verdicts[n];
        const scenario_expect_t *expect = verdict->expect;
        printf("%s\n  {\"name\": ", n == 0 ? "" : ",");
        json_text(stdout, expect->name);
        printf(", \"signal\": \"%s\", \"minus\": ", expect->row->name);
        json_text(stdout, expect->minus != NULL ? expect->minus->name : NULL);
        printf(", \"statistic\": \"%s\", \"unit\": ", statistic_text(expect->statistic));
        json_text(stdout, expect->row->unit);
        printf(", \"from_s\": %.9g, \"to_s\": %.9g, \"value\": ", expect->begin * RIG_PERIOD_SECONDS,
               expect->end * RIG_PERIOD_SECONDS);
        json_number(stdout, verdict->value);
        print_limit("at_least", expect->at_least);
        print_limit("at_most", expect->at_most);
        printf(", \"verdict\": \"%s\"}", words[verdict->judgement]);
    }
    printf("], \"files\": [");
    const char *separator = "";
    char path[PATH_SIZE];
    for (uint32_t n = 0; n < 3u; n++) {
        static const char *const endings[] = {"csv", "mat", "vcd"};
        if ((recording->formats >> n & 1u) != 0u) {
            snprintf(path, sizeof path, "%.3800s/%.200s.%s", recording->folder, recording->name, endings[n]);
            printf("%s", separator);
            json_text(stdout, path);
            separator = ", ";
        }
    }
    if (recording->history.periods > 0u) {
        snprintf(path, sizeof path, "%.3800s/%.260s.csv", recording->folder, recording->history_name);
        printf("%s", separator);
        json_text(stdout, path);
    }
    printf("], \"manoeuvre\": \"%s\", \"not_on\": ", choice_name("manoeuvre", result->manoeuvre).text);
    print_not_on(result->not_on);
    printf("}\n");
}

/* ---- the command ---- */

static bool prepare(const options_t *options, scenario_t *scenario)
{
    scenario_error_t error;
    for (size_t n = 0; n < options->override_count; n++) {
        if (!scenario_override(scenario, options->overrides[n], &error)) {
            fprintf(stderr, "lagless run: --set %s: %s\n", options->overrides[n], error.message);
            return false;
        }
    }
    if (options->override_count > 0u && !scenario_check(scenario, &error)) {
        char text[1200];
        fprintf(stderr, "lagless run: with --set: %s\n", scenario_error_text(&error, text, sizeof text));
        return false;
    }
    return true;
}

/* Writes everything out and says where it is. */
static int close_recording(const options_t *options, const runner_result_t *result, recording_t *recording)
{
    recorder_error_t error;
    char when[TIMES_TEXT_SIZE];
    int exit_code = EXIT_DONE;
    const uint64_t samples = recorder_samples(recording->recorder);
    if (!recorder_close(recording->recorder, result->end == RUNNER_COMPLETE ? "complete" : "interrupted",
                        &error)) {
        fprintf(stderr, "lagless run: %s\n", error.text);
        exit_code = EXIT_INTERNAL;
    } else if (result->end == RUNNER_INTERRUPTED) {
        fprintf(stderr,
                "lagless run: stopped at %s s; the %" PRIu64 " samples until then are kept in %s/%s.*\n",
                times_text(when, result->periods), samples, options->folder, recording->name);
    } else if (!options->quiet) {
        fprintf(stderr, "%" PRIu64 " samples in %s/%s.*\n", samples, options->folder, recording->name);
    }

    const runner_history_t *history = &recording->history;
    if (!write_history(recording, &error)) {
        fprintf(stderr, "lagless run: %s\n", error.text);
        exit_code = EXIT_INTERNAL;
    } else if (history->periods > 0u && !options->quiet) {
        fprintf(stderr, "the last %" PRIu32 " periods up to fault %s at %s s in %s/%s.csv\n",
                history->periods, reason_name(history->fault_reason), times_text(when, history->fault_period),
                options->folder, recording->history_name);
    }
    return exit_code;
}

static int run(const options_t *options, scenario_t *scenario)
{
    static recording_t recording;
    recording = (recording_t){.folder = options->folder != NULL ? options->folder : ""};
    runner_options_t how = {.stop = &stop};
    progress_t progress = {output_seconds(), false};
    runner_result_t result;
    char when[TIMES_TEXT_SIZE];
    uint64_t seed = scenario->seed;
    uint64_t stop_period = 0;

    if (options->seed != NULL && !read_whole("--seed", options->seed, 0u, INT64_MAX, &seed)) {
        return EXIT_USAGE;
    }
    const char *stop_text = getenv("LAGLESS_STOP");
    if (stop_text != NULL && !read_whole("LAGLESS_STOP", stop_text, 0u, UINT32_MAX, &stop_period)) {
        return EXIT_USAGE;
    }
    if (options->folder == NULL &&
        (options->record != NULL || options->formats != NULL || options->every != NULL)) {
        fprintf(stderr, "lagless run: a recording needs --out FOLDER\n");
        return EXIT_USAGE;
    }
    if (options->folder != NULL && !open_recording(options, scenario, seed, &recording)) {
        return EXIT_USAGE;
    }

    how.has_seed = true;
    how.seed = seed;
    how.has_stop_period = stop_text != NULL;
    how.stop_period = (uint32_t)stop_period;
    if (recording.recorder != NULL) {
        how.record = recording.ids;
        how.record_count = recording.count;
        how.record_every = (uint32_t)recording.every;
        how.sink = recorder_sink;
        how.sink_context = recording.recorder;
        how.edge_sink = (recording.formats & RECORDER_VCD) != 0u ? recorder_edge : NULL;
        how.edge_context = recording.recorder;
        how.history = &recording.history;
    }
    if (!options->quiet && isatty(STDERR_FILENO)) {
        how.progress = show_progress;
        how.progress_context = &progress;
    }

    const struct sigaction action = {.sa_handler = on_interrupt, .sa_flags = (int)SA_RESETHAND};
    sigaction(SIGINT, &action, NULL);
    const bool ran = runner_run(scenario, &how, &result);
    if (progress.shown) {
        fprintf(stderr, "\r%60s\r", "");
    }
    if (!ran) {
        char text[1200];
        fprintf(stderr, "%s\n", scenario_error_text(&result.error, text, sizeof text));
        recorder_abandon(recording.recorder);
        runner_result_free(&result);
        return EXIT_USAGE;
    }

    int exit_code = result.failed == 0u ? EXIT_DONE : EXIT_FAILED;
    if (recording.recorder != NULL) {
        const int written = close_recording(options, &result, &recording);
        exit_code = written != EXIT_DONE ? written : exit_code;
    } else if (result.end == RUNNER_INTERRUPTED) {
        fprintf(stderr, "lagless run: stopped at %s s\n", times_text(when, result.periods));
    }
    if (result.end == RUNNER_INTERRUPTED && exit_code == EXIT_DONE) {
        exit_code = EXIT_FAILED;
    }
    if (options->json) {
        print_json(scenario, &result, &recording);
    } else {
        print_text(scenario, &result, options->quiet);
    }
    runner_result_free(&result);
    return exit_code;
}

int command_run(int argc, char **argv)
{
    static const struct argp_option rows[] = {
        {"set", 's', "NAME=VALUE", 0,
         "a row before t = 0, \"inertia=0.003\", \"speed_request=500 r/min\"; repeatable", 0},
        {"seed", 'S', "N", 0, "of all noise, instead of the scenario's", 0},
        {"record", 'r', "NAMES", 0, "rows to record, separated by commas, instead of the scenario's", 0},
        {"every", 'e', "N", 0, "record every N-th period", 0},
        {"out", 'o', "FOLDER", 0, "write the recording there", 0},
        {"format", 'f', "FORMATS", 0, "csv (default), mat, vcd, separated by commas", 0},
        {"json", 'j', NULL, 0, "one JSON object on stdout", 0},
        {"quiet", 'q', NULL, 0, "print only what went wrong", 0},
        {0},
    };
    static const struct argp argp = {
        rows,       parse,
        "SCENARIO", "Runs a scenario (a TOML file, or a name of `lagless scenarios`) and judges it.",
        NULL,       NULL,
        NULL};
    options_t options = {0};
    if (argp_parse(&argp, argc, argv, 0, NULL, &options) != 0) {
        return EXIT_USAGE;
    }
    scenario_t *scenario = library_read(options.scenario);
    if (scenario == NULL) {
        return EXIT_USAGE;
    }
    const int exit_code = prepare(&options, scenario) ? run(&options, scenario) : EXIT_USAGE;
    scenario_free(scenario);
    return exit_code;
}
