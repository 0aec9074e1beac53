/* `lagless replay FILE`: the drive's two tasks run again on the samples that a drive recorded before a fault.
 */
#include <argp.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host_sim/cli/arguments.h"
#include "host_sim/cli/board.h"
#include "host_sim/cli/cli.h"
#include "host_sim/cli/output.h"
#include "host_sim/lab/json.h"
#include "host_sim/lab/recorder.h"
#include "host_sim/lab/replay_file.h"
#include "host_sim/lab/scenario.h"
#include "host_sim/lab/times.h"
#include "settings/reasons.h"

typedef struct {
    arguments_output_t output;
    const char *formats;
    const char *path;
} options_t;

static error_t parse(int key, char *argument, struct argp_state *state)
{
    options_t *options = state->input;
    switch (key) {
    case 'f':
        options->formats = argument;
        return 0;
    case ARGP_KEY_ARG:
        if (options->path != NULL) {
            argp_error(state, "%s: a second file; accepted: one", argument);
        }
        options->path = argument;
        return 0;
    case ARGP_KEY_NO_ARGS:
        argp_error(state, "no file is given; accepted: one of `capture save` in lagless connect, or of "
                          "`lagless run --out`");
        return 0;
    case ARGP_KEY_END:
        if (options->formats != NULL && options->output.folder == NULL) {
            argp_error(state, "--format needs --out FOLDER, where the recording goes");
        }
        return 0;
    default:
        return arguments_output(key, argument, &options->output);
    }
}

/* ---- the recording ---- */

typedef struct {
    uint32_t ids[RIG_TAP_MAX];
    uint32_t count;
    uint32_t formats;
    char name[256];
    recorder_t *recorder; /* NULL: none is requested */
} recording_t;

/* All signals of the drive, as many as a tap takes. */
static void choose_rows(recording_t *recording)
{
    for (uint32_t t = 0; t < rig_table_count(); t++) {
        const table_t *table = rig_table(t);
        const bool wanted = strcmp(table->name, "signals") == 0;
        for (uint32_t n = 0; wanted && n < table->count && recording->count < RIG_TAP_MAX; n++) {
            recording->ids[recording->count++] = table->rows[n].id;
        }
    }
}

#define ENDING ".replay"

static bool ends_in_replay(const char *name)
{
    const size_t length = strlen(name);
    return length > strlen(ENDING) && strcmp(name + length - strlen(ENDING), ENDING) == 0;
}

/* NAME_replay of a file NAME.replay. */
static int open_recording(const options_t *options, const replay_file_t *file, recording_t *recording)
{
    static recorder_value_t values[RIG_TAP_MAX];
    uint32_t value_count = 0;
    char title[320];
    char name[240];
    recorder_error_t error;
    recording->formats = recorder_formats(options->formats != NULL ? options->formats : "csv");
    if (recording->formats == 0u || (recording->formats & ~RECORDER_SAMPLED) != 0u) {
        fprintf(stderr, "lagless replay: --format %s: accepted: csv, mat, mdf, separated by commas\n",
                options->formats);
        return EXIT_USAGE;
    }
    scenario_file_name(options->path, name, sizeof name);
    snprintf(recording->name, sizeof recording->name, "%.*s_replay",
             (int)(strlen(name) - (ends_in_replay(name) ? strlen(ENDING) : 0u)), name);
    if (!output_folder(options->output.folder)) {
        return EXIT_INTERNAL;
    }
    if (!output_allowed_recording(options->output.folder, recording->name, recording->formats)) {
        return EXIT_USAGE;
    }
    choose_rows(recording);
    const table_t *params = rig_table(0);
    for (uint32_t n = 0; n < params->count && value_count < RIG_TAP_MAX; n++) {
        const table_row_t *row = &params->rows[n];
        values[value_count] = (recorder_value_t){.name = row->name, .unit = row->unit};
        value_count += rig_record_value(file->slots, file->count, row, &values[value_count].value) ? 1u : 0u;
    }
    snprintf(title, sizeof title, "replay of %.250s", options->path);
    const recorder_options_t how = {
        .folder = options->output.folder,
        .name = recording->name,
        .formats = recording->formats,
        .ids = recording->ids,
        .count = recording->count,
        .every = 1u,
        .meta = {.program = CLI_VERSION,
                 .commit = LAGLESS_COMMIT,
                 .scenario = "",
                 .scenario_text = "",
                 .title = title,
                 .values = values,
                 .value_count = value_count},
    };
    recording->recorder = recorder_open(&how, &error);
    if (recording->recorder == NULL) {
        fprintf(stderr, "lagless replay: %s\n", error.text);
        return error.io ? EXIT_INTERNAL : EXIT_USAGE;
    }
    return EXIT_DONE;
}

/* ---- results ---- */

static const char *name_of(int32_t reason)
{
    const reason_row_t *row = reason_by_number(reason);
    return row == NULL ? "?" : reason == REASON_NONE ? "no fault" : row->name;
}

/* The same fault in the same period, or none in both. */
static bool is_same_fault(const rig_record_t *record, const rig_replayed_t *seen)
{
    return seen->reason == record->reason &&
           (record->reason == REASON_NONE || seen->fault_period == record->fault_period);
}

/* A period by the drive's count, which begins with 1, and its time. */
static const char *when(char to[64], uint32_t period)
{
    char time[TIMES_TEXT_SIZE];
    snprintf(to, 64, "period %" PRIu32 ", %s s", period, times_text(time, period - 1u));
    return to;
}

static void print_text(const replay_file_t *file, const rig_replayed_t *seen)
{
    const rig_record_t *record = &file->record;
    char at[64];
    printf("record      firmware %" PRIu32 ".%" PRIu32 ".%" PRIu32 ", %s, board %s\n", record->version >> 16,
           record->version >> 8 & 0xFFu, record->version & 0xFFu, file->tables, record->board);
    printf("replayed    %" PRIu32 " periods from %s, %" PRIu32 " windows, %" PRIu32 " requests and %" PRIu32
           " new tunings during this time\n",
           seen->periods, when(at, seen->begin + 1u), seen->windows, seen->requests, seen->tunings);
    if (seen->differs) {
        printf("DIFFERENT   duties or gates from %s on\n", when(at, seen->wrong));
    } else {
        printf("same        duties and gates, bit for bit, in all %" PRIu32 " periods\n", seen->periods);
    }
    if (record->reason == REASON_NONE && seen->reason == REASON_NONE) {
        printf("trigger     %s, without a fault\n", when(at, record->at));
        return;
    }
    printf("%s %s in %s\n", is_same_fault(record, seen) ? "same       " : "DIFFERENT  ",
           name_of(seen->reason), when(at, seen->fault_period));
    if (!is_same_fault(record, seen)) {
        printf("            recorded was %s in %s\n", name_of(record->reason),
               when(at, record->fault_period));
    }
    if (record->reason != REASON_NONE) {
        explain_reason(record->reason);
    }
}

static void print_json(const options_t *options, const replay_file_t *file, const rig_replayed_t *seen)
{
    const rig_record_t *record = &file->record;
    printf("{\"file\": ");
    json_text(stdout, options->path);
    printf(", \"board\": ");
    json_text(stdout, record->board);
    printf(", \"begin\": %" PRIu32 ", \"periods\": %" PRIu32 ", \"windows\": %" PRIu32
           ", \"requests\": %" PRIu32 ", \"tunings\": %" PRIu32 ", \"differs_from\": ",
           seen->begin, seen->periods, seen->windows, seen->requests, seen->tunings);
    printf(seen->differs ? "%" PRIu32 : "null", seen->wrong);
    printf(", \"trigger\": %" PRIu32 ", \"recorded\": {\"reason\": \"%s\", \"period\": %" PRIu32
           "}, \"replayed\": {\"reason\": \"%s\", \"period\": %" PRIu32 "}, \"same\": %s}\n",
           record->at, name_of(record->reason), record->fault_period, name_of(seen->reason),
           seen->fault_period, !seen->differs && is_same_fault(record, seen) ? "true" : "false");
}

/* ---- the command ---- */

static int end(const options_t *options, const replay_file_t *file, const rig_replayed_t *seen,
               recording_t *recording)
{
    recorder_error_t error;
    int exit_code = !seen->differs && is_same_fault(&file->record, seen) ? EXIT_DONE : EXIT_FAILED;
    if (recording->recorder != NULL) {
        const uint64_t samples = recorder_samples(recording->recorder);
        if (!recorder_close(recording->recorder, "complete", &error)) {
            fprintf(stderr, "lagless replay: %s\n", error.text);
            exit_code = EXIT_INTERNAL;
        } else {
            fprintf(stderr, "%" PRIu64 " samples in %s/%s.*\n", samples, options->output.folder,
                    recording->name);
        }
    }
    if (options->output.json) {
        print_json(options, file, seen);
    } else {
        print_text(file, seen);
    }
    return exit_code;
}

static int replay(const options_t *options, const replay_file_t *file, rig_t *rig)
{
    static recording_t recording;
    uint64_t stop = 0;
    const char *stop_text = getenv("LAGLESS_STOP");
    recording = (recording_t){.count = 0u};
    if (!arguments_number("replay", "LAGLESS_STOP", stop_text, 0u, UINT32_MAX, &stop)) {
        return EXIT_USAGE;
    }
    if (!rig_replay_begin(rig, file->slots, file->count)) {
        fprintf(stderr, "lagless replay: %s: %s\n", options->path, rig_error(rig));
        return EXIT_USAGE;
    }
    const int opened = options->output.folder != NULL ? open_recording(options, file, &recording) : EXIT_DONE;
    if (opened != EXIT_DONE) {
        return opened;
    }
    if (stop_text != NULL) {
        rig_stop_before(rig, (uint32_t)stop);
    }
    if (recording.recorder != NULL) {
        (void)rig_tap(rig, recording.ids, recording.count, 1u, recorder_sink, recording.recorder);
    }
    while (rig_replay_step(rig)) {
    }
    const rig_replayed_t seen = rig_replayed(rig);
    return end(options, file, &seen, &recording);
}

int command_replay(int argc, char **argv)
{
    static const struct argp_option rows[] = {
        ARGUMENTS_BOARD,
        ARGUMENTS_OUTPUT("one JSON object on stdout", "folder for a recording of all signals"),
        {"format", 'f', "FORMATS", 0, "csv (default), mat, mdf, separated by commas", 0},
        {0}};
    static const struct argp argp = {rows,
                                     parse,
                                     "FILE",
                                     "Runs the tasks of the drive on the samples that a drive recorded "
                                     "before a fault, compares duties and "
                                     "gates of each period with those of the drive, and explains the fault.\v"
                                     "The exit code is 0 if all is the same, 1 if not.",
                                     NULL,
                                     NULL,
                                     NULL};
    options_t options = {.path = NULL};
    replay_file_t file;
    char why[REPLAY_FILE_WHY];
    char board_why[BOARD_WHY_SIZE] = "";
    if (!arguments_parse(&argp, argc, argv, &options)) {
        return EXIT_USAGE;
    }
    if (!replay_file_read(options.path, &file, why)) {
        fprintf(stderr, "lagless replay: %s: %s\n", options.path, why);
        return EXIT_USAGE;
    }
    if (strcmp(file.record.board, rig_board) != 0 &&
        !board_of_scenario(file.record.board, NULL, 0u, board_why) && board_why[0] != '\0') {
        fprintf(stderr, "lagless replay: %s: board %s: %s\n", options.path, file.record.board, board_why);
        replay_file_free(&file);
        return EXIT_INTERNAL;
    }
    rig_t *rig = rig_create(0u);
    const int exit_code = rig != NULL ? replay(&options, &file, rig) : EXIT_INTERNAL;
    rig_free(rig);
    replay_file_free(&file);
    return exit_code;
}
