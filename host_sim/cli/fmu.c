/* `lagless fmu SCENARIO`: the simulation as a functional mock-up unit, one archive. */
#include <argp.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host_sim/cli/arguments.h"
#include "host_sim/cli/cli.h"
#include "host_sim/cli/library.h"
#include "host_sim/cli/output.h"
#include "host_sim/lab/boards.h"
#include "host_sim/lab/fmu_model.h"
#include "host_sim/lab/json.h"
#include "host_sim/lab/scenario_write.h"
#include "host_sim/lab/zip.h"
#include "host_sim/rig/rig.h"

#define LIBRARY_MAX (UINT32_C(256) << 20) /* [octets] */

typedef struct {
    arguments_scenario_t of;
    arguments_output_t output;
    rig_part_t part;
} options_t;

static error_t parse(int key, char *argument, struct argp_state *state)
{
    options_t *options = state->input;
    if (key == 'p') {
        if (!fmu_part_of(argument, &options->part)) {
            argp_error(state, "--part %s: accepted: ring, drive and plant", argument);
        }
        return 0;
    }
    return arguments_output(key, argument, &options->output) == 0
               ? 0
               : arguments_scenario(key, argument, state, &options->of);
}

/* A file of the archive, in memory. */
typedef struct {
    char *octets;
    size_t count;
} content_t;

/* The library of this build. false: the reason has been printed on stderr. */
static bool read_library(content_t *content)
{
    const char *set = getenv("LAGLESS_FMU");
    char own[PATH_SIZE];
    snprintf(own, sizeof own, "%s%s%s/lagless.so", LAGLESS_FMU, boards_is_default() ? "" : "/boards/",
             boards_is_default() ? "" : rig_board);
    const char *path = set != NULL && set[0] != '\0' ? set : own;
    FILE *file = fopen(path, "rb");
    if (file == NULL) {
        fprintf(stderr,
                "lagless fmu: %s is missing, the library that an FMU contains: run tools/get-fmi, configure "
                "again and build the target lagless_fmu\n",
                path);
        return false;
    }
    content->octets = malloc(LIBRARY_MAX);
    content->count = content->octets != NULL ? fread(content->octets, 1, LIBRARY_MAX, file) : 0u;
    const bool whole = content->count > 0u && content->count < LIBRARY_MAX && ferror(file) == 0;
    fclose(file);
    if (!whole) {
        fprintf(stderr, "lagless fmu: %s cannot be read completely\n", path);
    }
    return whole;
}

/* Description and scenario; returns the number of variables, 0 without memory. */
static uint32_t make_texts(rig_part_t part, const scenario_t *scenario, uint64_t seed, content_t *description,
                           content_t *text)
{
    FILE *first = open_memstream(&description->octets, &description->count);
    FILE *second = open_memstream(&text->octets, &text->count);
    uint32_t variables = 0;
    bool good = first != NULL && second != NULL;
    if (good) {
        variables = fmu_describe(first, part, scenario, LAGLESS_COMMIT);
        scenario_write(second, scenario, seed);
    }
    good = first != NULL && fclose(first) == 0 && good;
    good = second != NULL && fclose(second) == 0 && good;
    return good ? variables : 0u;
}

static int write_archive(const char *path, const content_t *description, const content_t *library,
                         const content_t *text)
{
    FILE *file = output_open(path);
    if (file == NULL) {
        return EXIT_INTERNAL;
    }
    zip_t zip = {.file = file};
    const bool fits =
        zip_add(&zip, "modelDescription.xml", description->octets, description->count) &&
        zip_add(&zip, "binaries/linux64/" FMU_IDENTIFIER ".so", library->octets, library->count) &&
        zip_add(&zip, "resources/scenario.toml", text->octets, text->count);
    if (!fits) {
        fprintf(stderr, "lagless fmu: %s: the files are too large for an archive\n", path);
        output_abandon(file, path);
        return EXIT_INTERNAL;
    }
    zip_end(&zip);
    return output_close(file, path) ? EXIT_DONE : EXIT_INTERNAL;
}

static void tell(const options_t *options, const char *path, uint32_t variables, const scenario_t *scenario)
{
    if (options->output.json) {
        printf("{\"file\": ");
        json_text(stdout, path);
        printf(", \"variables\": %" PRIu32 ", \"period_s\": %.9g, \"duration_s\": %.9g}\n", variables,
               RIG_PERIOD_SECONDS, scenario->duration);
    } else {
        printf("%s: %" PRIu32 " variables, step %.9g s, stop time %.9g s\n", path, variables,
               RIG_PERIOD_SECONDS, scenario->duration);
    }
}

static int make(const options_t *options, scenario_t *scenario)
{
    char name[256];
    char file[272];
    char path[PATH_SIZE];
    scenario_error_t error;
    uint64_t seed = scenario->seed;
    const char *folder = options->output.folder != NULL ? options->output.folder : ".";
    if (!arguments_number("fmu", "--seed", options->of.seed, 0u, INT64_MAX, &seed)) {
        return EXIT_USAGE;
    }
    if (!scenario_check(scenario, &error)) {
        library_say("fmu", &error);
        return EXIT_USAGE;
    }
    scenario_file_name(scenario->path, name, sizeof name);
    snprintf(file, sizeof file, options->part == RIG_RING ? "%s.fmu" : "%s_%s.fmu", name,
             fmu_part_name(options->part));
    if (!output_folder(folder)) {
        return EXIT_INTERNAL;
    }
    if (!output_path(path, folder, file) || !output_allowed(path)) {
        return EXIT_USAGE;
    }
    content_t description = {0}, library = {0}, text = {0};
    uint32_t variables = 0;
    int exit_code = EXIT_INTERNAL;
    if (read_library(&library)) {
        variables = make_texts(options->part, scenario, seed, &description, &text);
        exit_code = variables > 0u ? write_archive(path, &description, &library, &text) : EXIT_INTERNAL;
    }
    free(description.octets);
    free(library.octets);
    free(text.octets);
    if (exit_code == EXIT_DONE) {
        tell(options, path, variables, scenario);
    }
    return exit_code;
}

int command_fmu(int argc, char **argv)
{
    static const struct argp_option rows[] = {
        ARGUMENTS_SCENARIO,
        ARGUMENTS_BOARD,
        {"part", 'p', "PART", 0,
         "ring: drive and motor in one unit (default); drive, plant: one of the two, to connect it to the "
         "other or to "
         "a model of another program",
         0},
        ARGUMENTS_OUTPUT("one JSON object on stdout",
                         "write NAME.fmu there, or NAME_PART.fmu (default: the present folder)"),
        {0},
    };
    static const struct argp argp = {
        rows,
        parse,
        "SCENARIO",
        "Writes a functional mock-up unit (FMI 2.0, co-simulation) of drive and motor, or of one of the two: "
        "a "
        "simulation program runs the scenario with its "
        "events, sets requests, parameters, plant and rig, and reads all signals and true values.",
        NULL,
        NULL,
        NULL};
    options_t options = {0};
    if (!arguments_parse(&argp, argc, argv, &options)) {
        return EXIT_USAGE;
    }
    scenario_t *scenario = library_read("fmu", &options.of);
    if (scenario == NULL) {
        return EXIT_USAGE;
    }
    const int exit_code = make(&options, scenario);
    scenario_free(scenario);
    return exit_code;
}
