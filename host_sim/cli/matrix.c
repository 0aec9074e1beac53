/* `lagless matrix`: every fault in every manoeuvre, and whether the drive keeps its promise. */
#include <argp.h>
#include <inttypes.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "host_sim/cli/arguments.h"
#include "host_sim/cli/cli.h"
#include "host_sim/cli/library.h"
#include "host_sim/cli/output.h"
#include "host_sim/lab/boards.h"
#include "host_sim/lab/json.h"
#include "host_sim/lab/matrix.h"
#include "host_sim/lab/names.h"
#include "host_sim/lab/units.h"
#include "settings/faults.h"
#include "settings/reasons.h"

#define RPM       (2.0 * 3.14159265358979323846 / 60.0) /* [rad/s] */
#define MS        1e-3                                  /* [s] */
#define TIME_TEXT 32u                                   /* [chars] */
#define TEXT_MAX  400u

typedef struct {
    arguments_output_t output;
    bool has_share, has_seed;
    matrix_choice_t choice;
    const char *scenario; /* NULL: the matrix's own manoeuvres */
    bool has_at;
    matrix_user_t user;
} options_t;

/* ---- the command line ---- */

/* true: a fault has this name. Otherwise prints a message with the most similar name. */
static bool knows_fault(const char *name)
{
    names_search_t search = names_search(name);
    for (size_t n = 0; n < matrix_fault_count; n++) {
        names_consider(&search, matrix_faults[n].name);
        if (strcmp(matrix_faults[n].name, name) == 0) {
            return true;
        }
    }
    fprintf(stderr, "lagless matrix: %s: no such fault", name);
    output_suggest(stderr, names_found(&search));
    for (size_t n = 0; names_found(&search) == NULL && n < matrix_fault_count; n++) {
        fprintf(stderr, "%s%s", n == 0u ? "; accepted: " : ", ", matrix_faults[n].name);
    }
    fprintf(stderr, "\n");
    return false;
}

static void read_share(struct argp_state *state, const char *text, options_t *options)
{
    char *end = NULL;
    const double percent = strtod(text, &end);
    if (end == text || *end != '\0' || !(percent > 0.0 && percent <= 100.0)) {
        argp_error(state, "--share %s: accepted: above 0 to 100, in percent of the cells", text);
    }
    options->choice.share = percent / 100.0;
    options->has_share = true;
}

static void read_seed(struct argp_state *state, const char *text, options_t *options)
{
    uint64_t seed = 0;
    if (!arguments_whole(text, 0u, INT64_MAX, &seed)) {
        argp_error(state, "--seed %s: accepted: whole numbers from 0", text);
    }
    options->choice.seed = seed;
    options->has_seed = true;
}

static void read_at(struct argp_state *state, const char *text, options_t *options)
{
    units_error_t why;
    if (!units_read(text, "s", &options->user.at, &why) && !units_read(text, "-", &options->user.at, &why)) {
        argp_error(state, "--at %s: accepted: a time in the scenario, such as \"1.5 s\"", text);
    }
    options->has_at = true;
}

static void check_line(struct argp_state *state, const options_t *options)
{
    const bool chosen = options->has_share || options->choice.cell != NULL;
    if (options->has_seed && !options->has_share) {
        argp_error(
            state,
            "--seed needs --share: it selects the cells of the share; each cell itself has no random part");
    }
    if ((options->scenario != NULL) != options->has_at) {
        argp_error(state, "--scenario and --at must be given together: the run, and the time at which the "
                          "faults are injected");
    }
    if (options->scenario != NULL && chosen) {
        argp_error(state, "--scenario has one cell for each fault; accepted beside it: --at, --only");
    }
}

static error_t parse(int key, char *argument, struct argp_state *state)
{
    options_t *options = state->input;
    switch (key) {
    case 'f':
        options->choice.only = argument;
        return 0;
    case 'C':
        options->scenario = argument;
        return 0;
    case 'a':
        read_at(state, argument, options);
        return 0;
    case 'c':
        options->choice.cell = argument;
        return 0;
    case 's':
        read_share(state, argument, options);
        return 0;
    case 'e':
        read_seed(state, argument, options);
        return 0;
    case ARGP_KEY_ARG:
        argp_error(state, "%s: no argument is expected", argument);
        return 0;
    case ARGP_KEY_END:
        check_line(state, options);
        return 0;
    default:
        return arguments_output(key, argument, &options->output);
    }
}

/* ---- the output for a cell ---- */

static const char *reason_name(int32_t reason)
{
    const reason_row_t *row = reason_by_number(reason);
    return row != NULL ? row->name : "?";
}

/* Names of the faults that warned, blanks between. */
static const char *warned(char to[TEXT_MAX], uint64_t warnings)
{
    size_t length = 0;
    to[0] = '\0';
    for (uint32_t n = 0; n < (uint32_t)FAULTS && length < TEXT_MAX; n++) {
        if ((warnings >> n & 1u) != 0u) {
            length += (size_t)snprintf(to + length, TEXT_MAX - length, "%s%s", length > 0u ? " " : "",
                                       fault_rows[n].name);
        }
    }
    return to;
}

static void add(char to[TEXT_MAX], const char *format, ...) __attribute__((format(printf, 2, 3)));
static void add(char to[TEXT_MAX], const char *format, ...)
{
    const size_t length = strlen(to);
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(to + length, TEXT_MAX - length, format, arguments);
    va_end(arguments);
}

/* "2.012 s" or "100.8 ms" */
static const char *time_text(char to[TIME_TEXT], double seconds)
{
    snprintf(to, TIME_TEXT, "%.4g %s", seconds < 1.0 ? seconds / MS : seconds, seconds < 1.0 ? "ms" : "s");
    return to;
}

/* The reaction as text; JSON has its name. */
static const char *reaction_text(uint32_t reaction)
{
    static const char *const texts[MATRIX_REACTIONS] = {
        "runs on", "warns", "catches the rotor", "does not switch on", "stops", "opens the bridge"};
    for (uint32_t n = 0; n < MATRIX_REACTIONS; n++) {
        if (reaction == UINT32_C(1) << n) {
            return texts[n];
        }
    }
    return "?";
}

/* Rounded, without the sign of a negative zero. */
static double in_rpm(double speed)
{
    return round(speed / RPM) + 0.0;
}

/* "opens the bridge (overcurrent), gates off after 3.1 ms, 15.2 A, rotor coasts at 1190 r/min" */
static const char *seen_text(char to[TEXT_MAX], const matrix_cell_t *cell)
{
    const matrix_seen_t *seen = &cell->seen;
    char list[TEXT_MAX];
    char time[TIME_TEXT];
    to[0] = '\0';
    if (cell->red == MATRIX_BY_PROFILE) {
        add(to, "the drive did not reach this manoeuvre");
        return to;
    }
    add(to, "%s", reaction_text(seen->reaction));
    if (seen->reason != 0) {
        add(to, " (%s)", reason_name(seen->reason));
    } else if (seen->warnings != 0u) {
        add(to, " (%s)", warned(list, seen->warnings));
    }
    if (!isnan(seen->noticed)) {
        add(to, " after %s", time_text(time, seen->noticed));
    }
    if (!isnan(seen->gates_off) && seen->gates_off != seen->noticed) {
        add(to, ", gates off after %s", time_text(time, seen->gates_off));
    }
    add(to, ", %.1f A, rotor %s at %.0f r/min", seen->current, matrix_rotor_name(seen->rotor),
        in_rpm(seen->speed));
    if (seen->fastest > 1.05 * fmax(fabs(seen->started), fabs(seen->reference))) {
        add(to, ", at most %.0f r/min", in_rpm(seen->fastest));
    }
    return to;
}

/* "opens the bridge (overcurrent) within 20 ms, at most 25 A, rotor coasts or stands" */
static const char *promise_text(char to[TEXT_MAX], const matrix_cell_t *cell)
{
    const matrix_promise_t *promise = cell->promise;
    char set[MATRIX_NAME_SIZE];
    to[0] = '\0';
    add(to, "%s", matrix_set_text(set, promise->reactions, reaction_text));
    if (promise->reasons[0] != '\0') {
        add(to, " (%s)", promise->reasons);
    }
    if (!isnan(cell->within)) {
        char time[TIME_TEXT];
        add(to, " within %s", time_text(time, cell->within));
    }
    add(to, ", at most %.4g A, rotor %s", matrix_current(cell),
        matrix_set_text(set, promise->rotor, matrix_rotor_name));
    return to;
}

/* ---- as JSON ---- */

static void print_key(FILE *file, const char *key, double value)
{
    fprintf(file, ", \"%s\": ", key);
    json_number(file, value);
}

static void print_text(FILE *file, const char *key, const char *text)
{
    fprintf(file, ", \"%s\": ", key);
    json_text(file, text);
}

static void print_promise(FILE *file, const matrix_cell_t *cell)
{
    const matrix_promise_t *promise = cell->promise;
    char text[TEXT_MAX];
    char set[MATRIX_NAME_SIZE];
    fprintf(file, ",\n  \"promised\": {\"text\": ");
    json_text(file, promise_text(text, cell));
    print_text(file, "reaction", matrix_set_text(set, promise->reactions, matrix_reaction_name));
    print_text(file, "reasons", promise->reasons);
    print_key(file, "within_ms", cell->within / MS);
    print_key(file, "current_a", matrix_current(cell));
    print_text(file, "rotor", matrix_set_text(set, promise->rotor, matrix_rotor_name));
    print_text(file, "because", promise->because);
    fprintf(file, "}");
}

static void print_seen(FILE *file, const matrix_cell_t *cell)
{
    const matrix_seen_t *seen = &cell->seen;
    char text[TEXT_MAX];
    fprintf(file, ",\n  \"seen\": {\"text\": ");
    json_text(file, seen_text(text, cell));
    print_text(file, "reaction", matrix_reaction_name(seen->reaction));
    print_text(file, "reason", reason_name(seen->reason));
    print_text(file, "warnings", warned(text, seen->warnings));
    print_key(file, "noticed_ms", seen->noticed / MS);
    print_key(file, "gates_off_ms", seen->gates_off / MS);
    print_key(file, "current_a", seen->current);
    print_text(file, "rotor", matrix_rotor_name(seen->rotor));
    print_key(file, "speed_rpm", seen->speed / RPM);
    print_key(file, "reference_rpm", seen->reference / RPM);
    print_key(file, "fastest_rpm", seen->fastest / RPM);
    fprintf(file, "}");
}

static const char *verdict(const matrix_cell_t *cell)
{
    return !cell->occurs ? "never" : cell->red != 0u ? "red" : "green";
}

static void print_cell(FILE *file, const matrix_cell_t *cell)
{
    char text[MATRIX_NAME_SIZE];
    fprintf(file, "{\"cell\": ");
    json_text(file, matrix_cell_name(text, cell));
    print_text(file, "fault", matrix_faults[cell->fault].name);
    print_text(file, "manoeuvre",
               cell->user != NULL ? matrix_scenario : matrix_manoeuvres[cell->manoeuvre].name);
    print_text(file, "source", matrix_source_name(cell->place));
    if (cell->user == NULL) {
        print_text(file, "shaft", matrix_shaft_name(cell->place));
    } else {
        print_text(file, "promised_as", matrix_manoeuvres[cell->manoeuvre].name);
    }
    print_text(file, "verdict", verdict(cell));
    if (!cell->occurs) {
        print_text(file, "because", matrix_never(cell));
    } else {
        print_text(file, "red_by", matrix_set_text(text, cell->red, matrix_kind_name));
        print_text(file, "not_yet", cell->not_yet != NULL ? cell->not_yet : "");
        print_promise(file, cell);
        print_seen(file, cell);
    }
    fprintf(file, "}");
}

typedef struct {
    size_t green, red, never, surprises;
} tally_t;

static tally_t tally(const matrix_cell_t *cells, size_t count)
{
    tally_t all = {0};
    for (size_t n = 0; n < count; n++) {
        *(!cells[n].occurs ? &all.never : cells[n].red != 0u ? &all.red : &all.green) += 1u;
        all.surprises += matrix_surprises(&cells[n]) ? 1u : 0u;
    }
    return all;
}

static void print_list(FILE *file, const char *key, size_t count, const char *(*name)(size_t),
                       const char *(*text)(size_t))
{
    fprintf(file, ",\n\"%s\": [", key);
    for (size_t n = 0; n < count; n++) {
        fprintf(file, "%s{\"name\": ", n == 0 ? "" : ",\n ");
        json_text(file, name(n));
        print_text(file, "text", text(n));
        fprintf(file, "}");
    }
    fprintf(file, "]");
}

static const char *fault_name(size_t n)
{
    return matrix_faults[n].name;
}

static const char *fault_text(size_t n)
{
    return matrix_faults[n].text;
}

static const char *manoeuvre_name(size_t n)
{
    return matrix_manoeuvres[n].name;
}

static const char *manoeuvre_text(size_t n)
{
    return matrix_manoeuvres[n].text;
}

/* The run of the user is the only column. Its text: "Rated load, faults at 1.5 s; promised as in run_fast,
 * sensorless". */
static void scenario_text(char to[TEXT_MAX], const options_t *options, const matrix_cell_t *cell)
{
    snprintf(to, TEXT_MAX, "%s, faults at %g s; promised as in %s, %s", options->user.scenario->title,
             options->user.at, matrix_manoeuvres[cell->manoeuvre].name, matrix_source_name(cell->place));
}

static void print_scenario(FILE *file, const options_t *options, const matrix_cell_t *cells)
{
    char text[TEXT_MAX];
    scenario_text(text, options, &cells[0]);
    fprintf(file, ",\n\"manoeuvres\": [{\"name\": \"%s\"", matrix_scenario);
    print_text(file, "text", text);
    fprintf(file, "}]");
}

static void print_json(FILE *file, const options_t *options, const matrix_cell_t *cells, size_t count)
{
    const tally_t all = tally(cells, count);
    fprintf(file, "{\"green\": %zu, \"red\": %zu, \"never\": %zu", all.green, all.red, all.never);
    if (options->has_share) {
        print_key(file, "share_percent", 100.0 * options->choice.share);
        fprintf(file, ", \"seed\": %" PRIu64, options->choice.seed);
    }
    print_list(file, "faults", matrix_fault_count, fault_name, fault_text);
    if (options->scenario != NULL) {
        print_scenario(file, options, cells);
    } else {
        print_list(file, "manoeuvres", matrix_manoeuvre_count, manoeuvre_name, manoeuvre_text);
    }
    fprintf(file, ",\n\"cells\": [");
    for (size_t n = 0; n < count; n++) {
        fprintf(file, n == 0 ? "\n" : ",\n");
        print_cell(file, &cells[n]);
    }
    fprintf(file, "\n]}\n");
}

/* ---- as a table ---- */

/* A small letter if the promise is kept, a large one if not; blank: not run; '.': cannot occur. */
static char letter(const matrix_cell_t *cell)
{
    static const char *const names = "rwcnso"; /* rides .. opens */
    if (cell == NULL) {
        return ' ';
    }
    if (!cell->occurs) {
        return '.';
    }
    for (uint32_t n = 0; n < MATRIX_REACTIONS; n++) {
        if (cell->seen.reaction == 1u << n) {
            return (char)(names[n] - (cell->red != 0u ? 'a' - 'A' : 0));
        }
    }
    return '?';
}

static void print_letter(const matrix_cell_t *cell, bool colours)
{
    const bool told = cell != NULL && cell->occurs && colours;
    printf("%s%c%s",
           !told             ? ""
           : cell->red != 0u ? "\033[1;31m"
                             : "\033[32m",
           letter(cell), told ? "\033[0m" : "");
}

static const matrix_cell_t *find(const matrix_cell_t *cells, size_t count, uint32_t fault, uint32_t manoeuvre,
                                 uint32_t place)
{
    for (size_t n = 0; n < count; n++) {
        if (cells[n].fault == fault && cells[n].manoeuvre == manoeuvre && cells[n].place == place) {
            return &cells[n];
        }
    }
    return NULL;
}

static void print_row(const matrix_cell_t *cells, size_t count, uint32_t fault, bool colours)
{
    bool any = false;
    for (size_t n = 0; n < count; n++) {
        any = any || cells[n].fault == fault;
    }
    if (!any) {
        return;
    }
    printf("%-18s", matrix_faults[fault].name);
    for (uint32_t m = 0; m < matrix_manoeuvre_count; m++) {
        for (uint32_t place = 0; place < MATRIX_PLACES; place++) {
            print_letter(find(cells, count, fault, m, place), colours);
        }
        printf("%*s", 9 - (int)MATRIX_PLACES, "");
    }
    printf("\n");
}

/* A line a fault. */
static void print_user_table(const options_t *options, const matrix_cell_t *cells, size_t count)
{
    char seen[TEXT_MAX];
    char promised[TEXT_MAX];
    const bool colours = output_colours(stdout);
    scenario_text(seen, options, &cells[0]);
    printf("%s\n\n", seen);
    for (size_t n = 0; n < count; n++) {
        const matrix_cell_t *cell = &cells[n];
        printf("%-18s", matrix_faults[cell->fault].name);
        print_letter(cell, colours);
        printf("  %s\n", cell->occurs ? seen_text(seen, cell) : matrix_never(cell));
        if (cell->red != 0u) {
            char by[MATRIX_NAME_SIZE];
            printf("%20s RED by %s; promised: %s\n", "", matrix_set_text(by, cell->red, matrix_kind_name),
                   promise_text(promised, cell));
        }
    }
}

static void print_table(const matrix_cell_t *cells, size_t count)
{
    char seen[TEXT_MAX];
    char promised[TEXT_MAX];
    char name[MATRIX_NAME_SIZE];
    const bool colours = output_colours(stdout);
    printf(
        "r: runs on, w: warns, c: catches the rotor, n: refuses to switch on, s: stops, o: opens the bridge; "
        "capital letter: not as promised; '.': cannot occur\n"
        "four letters: encoder with shaft h, encoder with l, sensorless with h, sensorless with l\n\n%-18s",
        "");
    for (size_t m = 0; m < matrix_manoeuvre_count; m++) {
        printf("%-9s", matrix_manoeuvres[m].name);
    }
    printf("\n");
    for (uint32_t fault = 0; fault < matrix_fault_count; fault++) {
        print_row(cells, count, fault, colours);
    }
    printf("\n");
    for (size_t n = 0; n < count; n++) {
        if (cells[n].red != 0u) {
            char by[MATRIX_NAME_SIZE];
            printf("RED %s by %s\n    promised: %s\n    seen:     %s\n", matrix_cell_name(name, &cells[n]),
                   matrix_set_text(by, cells[n].red, matrix_kind_name), promise_text(promised, &cells[n]),
                   seen_text(seen, &cells[n]));
        }
        if (cells[n].not_yet != NULL) {
            printf("%s%s: known failure: %s\n", cells[n].red != 0u ? "    " : "GREEN, although listed: ",
                   matrix_cell_name(name, &cells[n]), cells[n].not_yet);
        }
    }
}

/* ---- the whole command ---- */

static int tell(const options_t *options, const matrix_cell_t *cells, size_t count, double seconds)
{
    const tally_t all = tally(cells, count);
    if (options->output.json) {
        print_json(stdout, options, cells, count);
    } else if (options->scenario != NULL) {
        print_user_table(options, cells, count);
    } else {
        print_table(cells, count);
    }
    fflush(stdout);
    fprintf(stderr, "cells: %zu pass, %zu fail, %zu cannot occur; %zu unexpected; %.1f s", all.green, all.red,
            all.never, all.surprises, seconds);
    if (options->has_share) {
        fprintf(stderr, "; %g %% of the cells, seed %" PRIu64, 100.0 * options->choice.share,
                options->choice.seed);
    }
    fprintf(stderr, "\n");
    return all.surprises == 0u ? EXIT_DONE : EXIT_FAILED;
}

static int run(const options_t *options, matrix_cell_t *cells, size_t count, FILE *data,
               const char *data_path)
{
    const long cores = sysconf(_SC_NPROCESSORS_ONLN);
    output_progress_t progress = output_progress_begin();
    char why[POOL_WHY];
    int exit_code = EXIT_INTERNAL;
    const bool ran =
        matrix_run(cells, count, cores > 0 ? (unsigned)cores : 1u, output_progress, &progress, why);
    output_progress_end(&progress);
    if (!ran) {
        fprintf(stderr, "lagless matrix: %s\n", why);
    } else {
        if (data != NULL) {
            print_json(data, options, cells, count);
        }
        exit_code = tell(options, cells, count, output_seconds() - progress.started);
    }
    if (exit_code > EXIT_FAILED) {
        output_abandon(data, data_path);
        return exit_code;
    }
    return data == NULL || output_close(data, data_path) ? exit_code : EXIT_INTERNAL;
}

static int run_into(const options_t *options, matrix_cell_t *cells, size_t count)
{
    char data_path[PATH_SIZE];
    char page_path[PATH_SIZE];
    if (options->output.folder == NULL) {
        return run(options, cells, count, NULL, NULL);
    }
    if (!output_claim(options->output.folder) ||
        !output_path(page_path, options->output.folder, "matrix.html")) {
        return EXIT_INTERNAL;
    }
    if (!output_allowed_in(options->output.folder, "matrix", ".json") || !output_allowed(page_path)) {
        return EXIT_USAGE;
    }
    FILE *data = output_open_in(data_path, options->output.folder, "matrix.json");
    if (data == NULL) {
        return EXIT_INTERNAL;
    }
    const int exit_code = run(options, cells, count, data, data_path);
    if (exit_code > EXIT_FAILED) {
        return exit_code;
    }
    if (!output_picture("plot/matrix.py", data_path, page_path, "Fault matrix of the drive")) {
        return EXIT_INTERNAL;
    }
    fprintf(stderr, "page: %s\ndata: %s\n", page_path, data_path);
    return exit_code;
}

/* false in *good: the reason has been printed. */
static size_t lay_out_user(options_t *options, matrix_cell_t *cells, bool *good)
{
    scenario_error_t error = {.message = ""};
    size_t count = 0;
    scenario_t *scenario;
    if (options->scenario != NULL) {
        scenario = library_read("matrix", &(arguments_scenario_t){.scenario = options->scenario});
    } else {
        scenario = matrix_of_board(&options->user.at, &error);
        if (scenario == NULL) {
            fprintf(stderr, "lagless matrix: %s\n", error.message);
        }
        options->scenario = rig_board;
    }
    options->user.scenario = scenario;
    *good = scenario != NULL;
    if (scenario != NULL && !(options->user.at >= 0.0 && options->user.at < scenario->duration)) {
        fprintf(stderr, "lagless matrix: --at %g s: accepted: 0 s to less than the duration, %g s\n",
                options->user.at, scenario->duration);
        *good = false;
    } else if (scenario != NULL) {
        count = matrix_around(&options->user, options->choice.only, cells, good, &error);
        if (!*good) {
            fprintf(stderr, "lagless matrix: --at %g s of %s: %s\n", options->user.at, scenario->path,
                    error.message);
        }
    }
    return count;
}

int command_matrix(int argc, char **argv)
{
    static const struct argp_option rows[] = {
        {"scenario", 'C', "SCENARIO", 0,
         "inject the faults into this run, at the time --at, instead of the manoeuvres", 0},
        {"at", 'a', "TIME", 0, "time in the scenario, \"1.5 s\"; its drive must be running then", 0},
        {"only", 'f', "FAULT", 0, "run one fault only", 0},
        {"cell", 'c', "NAME", 0, "FAULT/MANOEUVRE/SOURCE/SHAFT, or the beginning of such a name", 0},
        {"share", 's', "PERCENT", 0, "run this share of the cells, selected by --seed", 0},
        {"seed", 'e', "N", 0, "seed of the selection; default 0", 0},
        ARGUMENTS_BOARD,
        ARGUMENTS_OUTPUT("one JSON object on stdout", "write matrix.json and the page matrix.html there"),
        {0},
    };
    static const struct argp argp = {
        rows,
        parse,
        NULL,
        "Injects every fault in every manoeuvre, with and without the encoder, on the paper's rig "
        "(shaft h) and the bare motor (l), and compares the reaction of the drive with its promise. "
        "Exit 0: exactly the cells that are listed as known failures fail; 1: another cell "
        "fails, or a listed one passes.\vWith --scenario (a TOML file, "
        "or a name of `lagless scenarios`) each fault that can occur during operation is "
        "injected into this run at the time --at, while the run continues. The promise is that of "
        "the paper's rig at such a speed, with the current scaled by the ratio of overcurrent_trip. On a "
        "board that is not the default, and without --scenario, this is a run of the library's motor with "
        "the "
        "largest current for which the board is proposed.",
        NULL,
        NULL,
        NULL};
    options_t options = {0};
    if (!arguments_parse(&argp, argc, argv, &options)) {
        return EXIT_USAGE;
    }
    if (options.choice.only != NULL && !knows_fault(options.choice.only)) {
        return EXIT_USAGE;
    }
    const bool user = options.scenario != NULL || !boards_is_default();
    if (user && (options.has_share || options.choice.cell != NULL)) {
        fprintf(stderr,
                "lagless matrix: --share and --cell select cells of the paper's rig on board %s; accepted on "
                "%s: --only FAULT, and --scenario SCENARIO --at TIME\n",
                board_facts[0]->name, rig_board);
        return EXIT_USAGE;
    }
    matrix_cell_t *cells = calloc(matrix_size(), sizeof *cells);
    if (cells == NULL) {
        fprintf(stderr, "lagless matrix: no memory\n");
        return EXIT_INTERNAL;
    }
    bool good = true;
    const size_t count = user ? lay_out_user(&options, cells, &good) : matrix_lay_out(&options.choice, cells);
    int exit_code = EXIT_USAGE;
    if (!good) {
        exit_code = EXIT_USAGE;
    } else if (count == 0u && user) {
        fprintf(stderr,
                "lagless matrix: %s is present from the beginning of a run: set its row in the scenario and "
                "use `lagless run`\n",
                options.choice.only);
    } else if (count == 0u) {
        fprintf(stderr, "lagless matrix: no cell is selected; a cell has a name such as "
                        "stuck_a_rail/run_fast/sensorless/h\n");
    } else {
        exit_code = run_into(&options, cells, count);
    }
    scenario_free(options.user.scenario);
    free(cells);
    return exit_code;
}
