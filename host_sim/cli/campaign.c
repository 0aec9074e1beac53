/* `lagless campaign`: thousands of random runs, and the violated promises. */
#include <argp.h>
#include <dirent.h>
#include <errno.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "host_sim/cli/arguments.h"
#include "host_sim/cli/cli.h"
#include "host_sim/cli/library.h"
#include "host_sim/cli/output.h"
#include "host_sim/cli/stop.h"
#include "host_sim/lab/campaign.h"

#define RESULTS     "campaign.csv"
#define FOLDERS_MAX 256u
#define SHARDS_MAX  10000u
#define TEXTS_MAX   1000u /* scenarios that are kept in memory where no folder is */

typedef struct {
    campaign_t campaign;
    const char *arguments[FOLDERS_MAX + 1u];
    size_t argument_count;
    arguments_output_t output;
    bool resume, runs_given;
    bool seconds_given, count_given;
    const char *scenario; /* NULL: none */
} options_t;

#define RUNS_AROUND 200u /* runs of a scenario without --runs */

/* ---- the command line ---- */

static uint64_t whole(struct argp_state *state, const char *name, const char *text, uint64_t min,
                      uint64_t max)
{
    uint64_t value = 0;
    if (!arguments_whole(text, min, max, &value)) {
        argp_error(state, "--%s %s: accepted: whole numbers %" PRIu64 " to %" PRIu64, name, text, min, max);
    }
    return value;
}

static double seconds(struct argp_state *state, const char *text)
{
    char *end = NULL;
    const double value = strtod(text, &end);
    if (end == text || *end != '\0' || !(value >= CAMPAIGN_SECONDS_MIN && value <= CAMPAIGN_SECONDS_MAX)) {
        argp_error(state, "--seconds %s: accepted: %g to %g", text, CAMPAIGN_SECONDS_MIN,
                   CAMPAIGN_SECONDS_MAX);
    }
    return value;
}

/* "I/N" */
static void read_shard(struct argp_state *state, const char *text, campaign_t *campaign)
{
    char part[16];
    const size_t length = strcspn(text, "/");
    uint64_t shard = 0;
    uint64_t shards = 0;
    snprintf(part, sizeof part, "%.*s", (int)(length < sizeof part ? length : sizeof part), text);
    if (text[length] != '/' || !arguments_whole(text + length + 1u, 1u, SHARDS_MAX, &shards) ||
        !arguments_whole(part, 1u, shards, &shard)) {
        argp_error(state, "--shard %s: accepted: I/N, 1 <= I <= N <= %u", text, SHARDS_MAX);
    }
    campaign->shard = (uint32_t)shard;
    campaign->shards = (uint32_t)shards;
}

static void check_line(struct argp_state *state, const options_t *options)
{
    const bool merge = options->argument_count > 0u;
    if (merge && strcmp(options->arguments[0], "merge") != 0) {
        argp_error(state, "%s: no such argument; accepted: `merge FOLDER...`, or none",
                   options->arguments[0]);
    }
    if (merge && options->argument_count == 1u) {
        argp_error(state,
                   "merge: no folder is given; accepted: folders that `lagless campaign --out FOLDER` wrote");
    }
    if (merge && (options->output.folder != NULL || options->resume || options->runs_given)) {
        argp_error(state, "merge: --out, --resume and --runs have no meaning here; accepted: folders and "
                          "--json, because the folders contain the settings of their runs");
    }
    if (options->scenario != NULL && options->seconds_given) {
        argp_error(state,
                   "--seconds cannot be used with --scenario; its duration is run.duration of the scenario");
    }
    if (options->resume && options->output.folder == NULL) {
        argp_error(state, "--resume needs --out FOLDER, the folder of the campaign that it continues");
    }
    if (options->campaign.shards > options->campaign.runs) {
        argp_error(state, "--shard: more shards than runs; accepted: N up to %" PRIu32,
                   options->campaign.runs);
    }
}

static error_t parse(int key, char *argument, struct argp_state *state)
{
    options_t *options = state->input;
    campaign_t *campaign = &options->campaign;
    switch (key) {
    case 'n':
        campaign->runs = (uint32_t)whole(state, "runs", argument, 1u, CAMPAIGN_RUNS_MAX);
        options->count_given = true;
        options->runs_given = true;
        return 0;
    case 'S':
        campaign->seed = whole(state, "seed", argument, 0u, INT64_MAX);
        options->runs_given = true;
        return 0;
    case 't':
        campaign->seconds = seconds(state, argument);
        options->seconds_given = true;
        options->runs_given = true;
        return 0;
    case 'i':
        read_shard(state, argument, campaign);
        options->runs_given = true;
        return 0;
    case 'c':
        options->scenario = argument;
        return 0;
    case 'a':
        campaign->as_drawn = true;
        options->runs_given = true;
        return 0;
    case 'r':
        options->resume = true;
        output_force(); /* the scenario of a run whose line was not written is written again */
        return 0;
    case ARGP_KEY_ARG:
        if (options->argument_count > FOLDERS_MAX) {
            argp_error(state, "merge: at most %u folders", FOLDERS_MAX);
        }
        options->arguments[options->argument_count++] = argument;
        return 0;
    case ARGP_KEY_END:
        campaign->runs = options->scenario != NULL && !options->count_given ? RUNS_AROUND : campaign->runs;
        check_line(state, options);
        return 0;
    default:
        return arguments_output(key, argument, &options->output);
    }
}

/* ---- results in a folder ---- */

/* Why a results file could not be read. */
typedef struct {
    int exit_code;
    long good; /* [octets] up to the last complete line */
} reading_t;

static reading_t bad_file(const char *path, uint32_t line, const char *why)
{
    fprintf(stderr, "lagless campaign: %s:%" PRIu32 ": %s\n", path, line, why);
    return (reading_t){.exit_code = EXIT_USAGE};
}

#define COLUMNS_BEGIN "run,end," /* of the names of the columns, in each version of the program */

/* Reads the finished runs into `results`, which is made when the first head is known (campaign->runs 0). A
 * last line without its end was being written when the campaign was stopped, and is left out. */
static reading_t read_results(FILE *file, const char *path, campaign_t *campaign, campaign_result_t **results)
{
    char text[CAMPAIGN_LINE_SIZE];
    campaign_t head = {.scenario = campaign->scenario};
    reading_t reading = {0};
    if (fgets(text, sizeof text, file) == NULL || !campaign_read_head(text, &head)) {
        return bad_file(path, 1u,
                        "no campaign of this program: it has other tables, or another --scenario; give its "
                        "own program and scenario");
    }
    if (*results == NULL) {
        campaign->seed = head.seed;
        campaign->runs = head.runs;
        campaign->seconds = head.seconds;
        *results = calloc(head.runs, sizeof **results);
    }
    if (*results == NULL) {
        return bad_file(path, 1u, "no memory for this number of runs");
    }
    if (head.seed != campaign->seed || head.runs != campaign->runs || head.seconds != campaign->seconds) {
        return bad_file(path, 1u, "another campaign: seed, runs and seconds must be the same");
    }
    reading.good = ftell(file);
    for (uint32_t line = 2u; fgets(text, sizeof text, file) != NULL; line++) {
        uint32_t run;
        campaign_result_t result = {0};
        if (strchr(text, '\n') == NULL && feof(file)) {
            break;
        }
        if (line == 2u && strcmp(text, CAMPAIGN_COLUMNS) == 0) {
            reading.good = ftell(file);
            continue;
        }
        if (line == 2u && strncmp(text, COLUMNS_BEGIN, strlen(COLUMNS_BEGIN)) == 0) {
            return bad_file(
                path, line,
                "the columns are not those of this program; merge the results with the program that "
                "made them, or run the campaign again");
        }
        if (!campaign_read_line(text, campaign->runs, &run, &result)) {
            return bad_file(path, line, "no result of a run");
        }
        if ((*results)[run].end != CAMPAIGN_NOT_DONE &&
            memcmp(&(*results)[run], &result, sizeof result) != 0) {
            return bad_file(path, line,
                            "an earlier line or folder has another result of this run; give each shard once");
        }
        (*results)[run] = result;
        reading.good = ftell(file);
    }
    return reading;
}

/* ---- while it runs ---- */

typedef struct {
    const options_t *options;
    FILE *file; /* NULL: there is no folder */
    char path[PATH_SIZE];
    char **texts; /* [runs] of violations, if there is no folder */
    uint32_t text_count;
    output_progress_t progress;
} keeper_t;

/* The scenario is written first, so that each result in the list has its file. */
static bool keep(void *context, uint32_t run, const campaign_result_t *result, const char *scenario)
{
    keeper_t *keeper = context;
    char line[CAMPAIGN_LINE_SIZE];
    char name[32];
    char path[PATH_SIZE];
    if (keeper->file == NULL) {
        if (scenario != NULL && keeper->text_count < TEXTS_MAX) {
            keeper->texts[run] = strdup(scenario);
            keeper->text_count++;
        }
        return true;
    }
    campaign_file_name(run, name);
    if (scenario != NULL) {
        FILE *file = output_open_in(path, keeper->options->output.folder, name);
        if (file != NULL) {
            fputs(scenario, file);
        }
        if (!output_close(file, path)) {
            return false;
        }
    }
    campaign_line(run, result, line);
    return fputs(line, keeper->file) >= 0 && fflush(keeper->file) == 0;
}

static void show(void *context, uint32_t done, uint32_t of)
{
    keeper_t *keeper = context;
    output_progress(&keeper->progress, (double)done / (double)of);
}

static int is_violation(const struct dirent *entry)
{
    unsigned run;
    int length = 0;
    return sscanf(entry->d_name, "run-%6u.toml%n", &run, &length) == 1 && entry->d_name[length] == '\0' &&
           length > 0;
}

/* Scenarios of an earlier campaign, which would be confused with those of this one. false: there are some, or
 * an input is among them; a message has been printed. */
static bool clear_scenarios(const char *folder)
{
    struct dirent **entries = NULL;
    const int count = scandir(folder, &entries, is_violation, alphasort);
    bool good = true;
    for (int n = 0; n < count; n++) {
        char path[PATH_SIZE];
        good = good && output_path(path, folder, entries[n]->d_name) && output_allowed(path) &&
               remove(path) == 0;
        free(entries[n]);
    }
    free(entries);
    return good;
}

/* Opens the results file for appending; `results` gets the runs that it contains. A new file gets its
 * header. */
static int open_results(const options_t *options, keeper_t *keeper, campaign_result_t *results)
{
    struct stat found;
    campaign_t campaign = options->campaign;
    char head[CAMPAIGN_LINE_SIZE];
    if (!output_claim(options->output.folder) ||
        !output_path(keeper->path, options->output.folder, RESULTS)) {
        return EXIT_INTERNAL;
    }
    const bool there = stat(keeper->path, &found) == 0 && found.st_size > 0;
    if (there && !options->resume && !output_forced()) {
        fprintf(stderr, "lagless campaign: %s exists: --resume continues it, --force starts again\n",
                keeper->path);
        return EXIT_USAGE;
    }
    if (!there || !options->resume) {
        if (!clear_scenarios(options->output.folder)) {
            return EXIT_USAGE;
        }
        keeper->file =
            fopen(keeper->path,
                  "w"); /* opened under its final name, because every complete line is a valid result */
        campaign_head(&options->campaign, head);
        const bool begun = keeper->file != NULL && fputs(head, keeper->file) >= 0 &&
                           fputs(CAMPAIGN_COLUMNS, keeper->file) >= 0 && fflush(keeper->file) == 0;
        if (!begun) {
            fprintf(stderr, "lagless campaign: cannot write %s: %s\n", keeper->path, strerror(errno));
        }
        return begun ? EXIT_DONE : EXIT_INTERNAL;
    }
    keeper->file = fopen(keeper->path, "r+");
    if (keeper->file == NULL) {
        fprintf(stderr, "lagless campaign: cannot write %s: %s\n", keeper->path, strerror(errno));
        return EXIT_INTERNAL;
    }
    const reading_t reading = read_results(keeper->file, keeper->path, &campaign, &results);
    if (reading.exit_code != EXIT_DONE) {
        return reading.exit_code;
    }
    if (fseek(keeper->file, reading.good, SEEK_SET) != 0 ||
        ftruncate(fileno(keeper->file), reading.good) != 0) {
        fprintf(stderr, "lagless campaign: cannot write %s: %s\n", keeper->path, strerror(errno));
        return EXIT_INTERNAL;
    }
    return EXIT_DONE;
}

/* ---- afterwards ---- */

static uint32_t undone(const campaign_t *campaign, const campaign_result_t *results)
{
    uint32_t count = 0;
    for (uint32_t run = campaign->shard - 1u; run < campaign->runs; run += campaign->shards) {
        count += results[run].end == CAMPAIGN_NOT_DONE;
    }
    return count;
}

static void say_scenarios(const keeper_t *keeper)
{
    for (uint32_t run = 0; run < keeper->options->campaign.runs && keeper->text_count > 0u; run++) {
        if (keeper->texts[run] != NULL) {
            char name[32];
            campaign_file_name(run, name);
            printf("\n# ---- %s\n%s", name, keeper->texts[run]);
        }
    }
}

static int say(const options_t *options, const campaign_result_t *results, const keeper_t *keeper)
{
    const campaign_t *campaign = &options->campaign;
    const uint32_t violated = campaign_summary(stdout, campaign, results, options->output.json);
    if (keeper != NULL && keeper->texts != NULL && !options->output.json) {
        say_scenarios(keeper);
    }
    fflush(stdout);
    if (keeper != NULL && keeper->text_count > 0u && options->output.json) {
        fprintf(stderr, "lagless campaign: --out FOLDER keeps the scenarios of the violations\n");
    }
    const uint32_t missing = undone(campaign, results);
    if (missing > 0u) {
        fprintf(stderr,
                "lagless campaign: %" PRIu32 " of %" PRIu32
                " runs are not done: continue them with --resume, or merge all shards\n",
                missing, campaign->runs);
    }
    return violated > 0u || missing > 0u ? EXIT_FAILED : EXIT_DONE;
}

static int run_with(options_t *options, keeper_t *keeper, campaign_result_t *results)
{
    char why[POOL_WHY] = "";
    campaign_t *campaign = &options->campaign;
    const long cores = sysconf(_SC_NPROCESSORS_ONLN);
    const double started = output_seconds();
    keeper->progress = output_progress_begin();
    campaign->threads = cores > 0 ? (unsigned)cores : 1u;
    campaign->stop = stop_on_signal();
    campaign->keep = keep;
    campaign->context = keeper;
    campaign->progress = show;
    const uint32_t before = undone(campaign, results);
    const bool good = campaign_all(campaign, results, why);
    output_progress_end(&keeper->progress);
    if (!good) {
        fprintf(stderr, "lagless campaign: %s\n", why);
        return EXIT_INTERNAL;
    }
    const int exit_code = say(options, results, keeper);
    const double elapsed = output_seconds() - started;
    const uint32_t made = before - undone(campaign, results);
    fprintf(stderr, "%" PRIu32 " runs in %.1f s, %.0f x real time on %u cores\n", made, elapsed,
            elapsed > 0.0 ? made * campaign->seconds / elapsed : 0.0, campaign->threads);
    return exit_code;
}

static int run(options_t *options)
{
    static keeper_t keeper;
    keeper.options = options;
    campaign_result_t *results = calloc(options->campaign.runs, sizeof *results);
    keeper.texts =
        options->output.folder == NULL ? calloc(options->campaign.runs, sizeof *keeper.texts) : NULL;
    int exit_code = EXIT_INTERNAL;
    if (results == NULL || (options->output.folder == NULL && keeper.texts == NULL)) {
        fprintf(stderr, "lagless campaign: there is not enough memory for this number of runs; divide them "
                        "with --shard\n");
    } else {
        exit_code = options->output.folder != NULL ? open_results(options, &keeper, results) : EXIT_DONE;
        exit_code = exit_code == EXIT_DONE ? run_with(options, &keeper, results) : exit_code;
    }
    if (keeper.file != NULL && fclose(keeper.file) != 0) {
        fprintf(stderr, "lagless campaign: %s is not complete: %s\n", keeper.path, strerror(errno));
        exit_code = EXIT_INTERNAL;
    }
    for (uint32_t n = 0; keeper.texts != NULL && n < options->campaign.runs; n++) {
        free(keeper.texts[n]);
    }
    free(keeper.texts);
    free(results);
    return exit_code;
}

static int merge(options_t *options)
{
    campaign_result_t *results = NULL;
    int exit_code = EXIT_DONE;
    for (size_t n = 1; n < options->argument_count && exit_code == EXIT_DONE; n++) {
        char path[PATH_SIZE];
        if (!output_path(path, options->arguments[n], RESULTS)) {
            exit_code = EXIT_USAGE;
            break;
        }
        FILE *file = fopen(path, "r");
        if (file == NULL) {
            fprintf(stderr, "lagless campaign: cannot read %s: %s\n", path, strerror(errno));
            exit_code = EXIT_USAGE;
            break;
        }
        exit_code = read_results(file, path, &options->campaign, &results).exit_code;
        fclose(file);
    }
    exit_code = exit_code == EXIT_DONE ? say(options, results, NULL) : exit_code;
    free(results);
    return exit_code;
}

int command_campaign(int argc, char **argv)
{
    static const struct argp_option rows[] = {
        {"scenario", 'c', "SCENARIO", 0, "repeat this scenario with random errors of its plant", 0},
        {"runs", 'n', "N", 0, "number of runs (default 10000, with --scenario 200)", 0},
        {"seed", 'S', "S", 0, "seed of all random values (default 1)", 0},
        {"seconds", 't', "T", 0, "simulated seconds of each run (default 2)", 0},
        {"shard", 'i', "I/N", 0, "do only every N-th run, beginning with the I-th", 0},
        {"as-drawn", 'a', NULL, 0, "write the scenarios of violations as drawn, without minimising them", 0},
        {"resume", 'r', NULL, 0, "continue the campaign in FOLDER", 0},
        ARGUMENTS_BOARD,
        ARGUMENTS_OUTPUT("one JSON object on stdout", "write results and the scenarios of violations there"),
        {0},
    };
    static const char doc[] =
        "Does runs with random motors, loads, wrong motor data, sensor errors, profiles and faults. Every "
        "period of every run is judged by rules that must always hold. Each violation is minimised and "
        "written as a scenario with which `lagless run` reproduces it.\vRun n of a seed does not depend on "
        "the number of runs, shards and cores. `lagless campaign merge FOLDER...` combines shards into the "
        "result of one run; shards of a --scenario also need --scenario here.\n\nWith --scenario (a TOML "
        "file, or a name of `lagless scenarios`) every run is this scenario, and its expectations are judged "
        "too. Motor, shaft, inverter and sensors differ from the drive's parameters by random errors: R up "
        "to 30 %, L 20 %, psi_f 10 %, J by a factor up to 1.4, friction up to 2, link -10 to +5 %, delays "
        "and drops 20 %, offsets 0.5 % of the range, gains 1 %, noise up to threefold, any angle of the "
        "rotor.";
    static const struct argp argp = {rows, parse, "[merge FOLDER...]", doc, NULL, NULL, NULL};
    options_t options = {.campaign = {.runs = 10000u, .seed = 1u, .seconds = 2.0, .shard = 1u, .shards = 1u}};
    if (!arguments_parse(&argp, argc, argv, &options)) {
        return EXIT_USAGE;
    }
    scenario_t *scenario = NULL;
    if (options.scenario != NULL) {
        scenario = library_read("campaign", &(arguments_scenario_t){.scenario = options.scenario});
        if (scenario == NULL) {
            return EXIT_USAGE;
        }
        options.campaign.scenario = scenario;
        options.campaign.seconds = scenario->duration;
    }
    const int exit_code = options.argument_count > 0u ? merge(&options) : run(&options);
    scenario_free(scenario);
    return exit_code;
}
