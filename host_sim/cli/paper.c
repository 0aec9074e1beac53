/* `lagless paper`: measures every figure of the paper again, judges it, and writes a report. */
#include <argp.h>
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "host_sim/cli/arguments.h"
#include "host_sim/cli/cli.h"
#include "host_sim/cli/library.h"
#include "host_sim/cli/output.h"
#include "host_sim/lab/experiment.h"
#include "host_sim/lab/json.h"
#include "host_sim/lab/names.h"
#include "host_sim/lab/paper.h"
#include "host_sim/rig/rig.h"

#define SEED        1u
#define FOLDER      "report"
#define TEXT_INDENT 26   /* [columns] of a row's id */
#define TEXT_WIDTH  72u  /* [columns] of a claim */
#define LINE_WIDTH  100u /* [columns] of a reason */

typedef struct {
    bool json;
    const char *folder; /* NULL: none requested */
    bool wanted[PAPER_FIGURES];
    bool named;               /* at least one figure */
    const char *file;         /* an experiment; NULL: the paper's */
    char standard[PATH_SIZE]; /* folder if none is requested */
} options_t;

/* ---- the command line ---- */

static void want(struct argp_state *state, const char *id, options_t *options)
{
    const size_t figure = paper_figure(id);
    if (figure == PAPER_FIGURES && (strchr(id, '/') != NULL || strchr(id, '.') != NULL)) {
        if (options->named || options->file != NULL) {
            argp_error(state,
                       "%s: a file cannot be combined with another one or with figures of the paper; "
                       "accepted: one file",
                       id);
        }
        options->file = id;
        return;
    }
    if (options->file != NULL) {
        argp_error(state,
                   "%s: a file cannot be combined with another one or with figures of the paper; accepted: "
                   "one file",
                   id);
    }
    if (figure == PAPER_FIGURES) {
        char known[PAPER_FIGURES * sizeof "beyond_bandwidth "] = "";
        names_search_t search = names_search(id);
        for (size_t n = 0; n < PAPER_FIGURES; n++) {
            names_consider(&search, paper_figures[n].id);
            strcat(strcat(known, n == 0 ? "" : " "), paper_figures[n].id);
        }
        const char *near = names_found(&search);
        argp_error(state, "%s: no such figure%s%s; known are %s, or a file of yours, my.toml", id,
                   near != NULL ? "; did you mean " : "", near != NULL ? near : "", known);
    }
    options->wanted[figure] = true;
    options->named = true;
    const size_t used = strlen(options->standard);
    snprintf(options->standard + used, sizeof options->standard - used, "%s%s", used > 0u ? "_" : FOLDER "_",
             paper_figures[figure].id);
}

static error_t parse(int key, char *argument, struct argp_state *state)
{
    options_t *options = state->input;
    switch (key) {
    case 'j':
        options->json = true;
        return 0;
    case 'o':
        options->folder = argument;
        return 0;
    case ARGUMENTS_FORCE_KEY:
        return arguments_force(key);
    case ARGP_KEY_ARG:
        want(state, argument, options);
        return 0;
    case ARGP_KEY_END:
        for (size_t n = 0; n < PAPER_FIGURES; n++) {
            options->wanted[n] = options->wanted[n] || (!options->named && options->file == NULL);
        }
        if (options->folder == NULL && !options->json && options->file == NULL) {
            options->folder = options->named ? options->standard : FOLDER;
        }
        return 0;
    default:
        return ARGP_ERR_UNKNOWN;
    }
}

/* ---- rows as JSON ---- */

static void print_key(FILE *file, const char *key, const char *text)
{
    fprintf(file, ", \"%s\": ", key);
    json_text(file, text);
}

static void print_json(FILE *file, const paper_t *paper)
{
    fprintf(file, "[");
    for (size_t n = 0; n < paper_row_count(paper); n++) {
        const paper_row_t *row = paper_row(paper, n);
        char verdict[240];
        snprintf(verdict, sizeof verdict, "%s%s%s", paper_verdict_name(row->verdict),
                 row->because[0] != '\0' ? ", " : "", row->because);
        fprintf(file, "%s{\"id\": ", n == 0 ? "" : ",\n ");
        json_text(file, row->id);
        print_key(file, "claim", row->claim);
        fprintf(file, ", \"paper\": ");
        json_number(file, row->paper);
        fprintf(file, ", \"ours\": ");
        json_number(file, row->ours);
        print_key(file, "unit", row->unit);
        print_key(file, "verdict", verdict);
        print_key(file, "condition", row->condition);
        fprintf(file, "}");
    }
    fprintf(file, "]\n");
}

/* ---- the table ---- */

static void print_number(double number)
{
    if (isnan(number)) {
        printf("  %8s", "");
    } else {
        printf("  %8.*f",
               fabs(number) < 9.995   ? 3
               : fabs(number) < 999.5 ? 1
                                      : 0,
               fabs(number) < 0.0005 ? 0.0 : number);
    }
}

/* Indented and broken between words. */
static void print_reason(const char *text)
{
    while (*text != '\0') {
        size_t length = strlen(text);
        if (length > LINE_WIDTH) {
            for (length = LINE_WIDTH; length > 1u && text[length] != ' '; length--) {
            }
        }
        printf("  %*s %.*s\n", TEXT_INDENT, "", (int)length, text);
        text += length;
        text += *text == ' ';
    }
}

/* The row of the same claim in the other flavour; NULL: there is none. */
static const paper_row_t *sibling(const paper_t *paper, const paper_row_t *row, const char *flavour)
{
    char id[sizeof row->id];
    snprintf(id, sizeof id, "%.*s.%s", (int)(strrchr(row->id, '.') - row->id), row->id, flavour);
    return paper_row_by_id(paper, id);
}

/* A row, with the number of the ideal drive. `said`: the reason of the previous row; the same reason is not
 * printed twice.
 */
static const char *print_row(const paper_row_t *row, const paper_row_t *ideal, const char *said)
{
    const char *name = strchr(row->id, '.') + 1;
    printf("  %-*.*s %-*s", TEXT_INDENT, (int)(strrchr(row->id, '.') - name), name, (int)TEXT_WIDTH,
           row->claim);
    print_number(row->paper);
    print_number(row->ours);
    print_number(ideal != NULL ? ideal->ours : (double)NAN);
    printf("  %-6s %s", row->unit, paper_verdict_name(row->verdict));
    if (ideal != NULL && ideal->verdict != row->verdict) {
        printf(" (ideal: %s)", paper_verdict_name(ideal->verdict));
    }
    printf("\n");
    const char *because = row->because[0] == '\0' && ideal != NULL ? ideal->because : row->because;
    if (strcmp(because, said) != 0) {
        print_reason(because);
    }
    return because;
}

static void print_table(const paper_t *paper)
{
    size_t figure = SIZE_MAX;
    size_t verdicts[PAPER_VERDICTS] = {0};
    const char *said = "";
    printf("  %-*s %-*s  %8s  %8s  %8s  %-6s verdict\n", TEXT_INDENT, "", (int)TEXT_WIDTH, "", "paper",
           "ours", "ideal", "unit");
    for (size_t n = 0; n < paper_row_count(paper); n++) {
        const paper_row_t *row = paper_row(paper, n);
        const bool ideal = strcmp(row->flavour, "ideal") == 0;
        verdicts[row->verdict]++;
        if (ideal && sibling(paper, row, "real") != NULL) {
            continue; /* the ideal number is beside it */
        }
        if (row->figure != figure) {
            figure = row->figure;
            printf("\n%s  %s\n", paper_about(paper, figure)->id, paper_about(paper, figure)->title);
            said = "";
        }
        said = print_row(row, ideal ? NULL : sibling(paper, row, "ideal"), said);
    }
    if (figure == PAPER_OWN) {
        printf("\n--json prints the conditions of each row.\n");
    } else {
        printf(
            "\nours: inverter and sensors with their errors (2.5 us dead time, compensated, 12-bit ADC, "
            "noise "
            "10 mA, "
            "offset 30 mA, gain error 0.2 %%);\nideal: without. --json prints the conditions of each row.\n");
    }
    for (size_t n = 0; n < PAPER_VERDICTS; n++) {
        if (verdicts[n] > 0u) {
            printf("%3zu %s\n", verdicts[n], paper_verdict_name((paper_verdict_t)n));
        }
    }
}

/* ---- files ---- */

/* A report of other figures in the same folder would be lost. */
static bool replaces_nothing(const options_t *options, const char *data)
{
    for (size_t n = 0; n < PAPER_FIGURES; n++) {
        char name[40];
        char path[PATH_SIZE];
        snprintf(name, sizeof name, "%s.csv", paper_figures[n].id);
        if (!options->wanted[n] && options->file == NULL && output_path(path, data, name) &&
            access(path, F_OK) == 0) {
            fprintf(stderr,
                    "lagless paper: %s holds a report with %s, which this report does not have; give "
                    "another folder with --out\n",
                    options->folder, paper_figures[n].id);
            return false;
        }
    }
    return true;
}

/* Everything that the report will write. */
static bool is_allowed(const options_t *options, const char *data)
{
    static const char *const files[][2] = {{"rows", ".json"}, {"report", ".json"}, {"index", ".html"}};
    char pictures[PATH_SIZE];
    bool good = output_path(pictures, options->folder, "pictures");
    for (size_t n = 0; good && n < sizeof files / sizeof files[0]; n++) {
        good = output_allowed_in(options->folder, files[n][0], files[n][1]);
    }
    for (size_t n = 0; good && n < PAPER_FIGURES; n++) {
        const char *id = paper_figures[n].id;
        good = options->file != NULL || !options->wanted[n] ||
               (output_allowed_in(data, id, ".csv") && output_allowed_pictures(pictures, id, "png,svg"));
    }
    return good;
}

/* Checks that files can be written there, before minutes of simulation. */
static int prepare(const options_t *options, char data[PATH_SIZE])
{
    if (!output_claim(options->folder) || !output_path(data, options->folder, "data") ||
        !output_folder(data)) {
        return EXIT_INTERNAL;
    }
    if (access(options->folder, W_OK) != 0 || access(data, W_OK) != 0) {
        fprintf(stderr, "lagless paper: cannot write to %s: %s\n", options->folder, strerror(errno));
        return EXIT_INTERNAL;
    }
    return replaces_nothing(options, data) && is_allowed(options, data) ? EXIT_DONE : EXIT_USAGE;
}

/* data/ID.csv, and data/ID_MORE.csv for each further table. */
static bool write_data(const char *data, const paper_t *paper, size_t figure, const char *more)
{
    char name[120];
    char path[PATH_SIZE];
    snprintf(name, sizeof name, "%.80s%s%s.csv", paper_about(paper, figure)->id, more != NULL ? "_" : "",
             more != NULL ? more : "");
    FILE *file = output_open_in(path, data, name);
    if (file != NULL && more == NULL) {
        paper_write_csv(paper, figure, file);
    } else if (file != NULL) {
        paper_write_more(paper, figure, file);
    }
    return output_close(file, path);
}

static bool write_all_data(const options_t *options, const char *data, const paper_t *paper)
{
    bool done = true;
    for (size_t n = 0; n <= PAPER_OWN; n++) {
        if (n == PAPER_OWN ? options->file != NULL : options->wanted[n]) {
            done = write_data(data, paper, n, NULL) && done;
            if (n < PAPER_FIGURES && paper_figures[n].more != NULL) {
                done = write_data(data, paper, n, paper_figures[n].more) && done;
            }
        }
    }
    return done;
}

static bool write_rows(const options_t *options, const paper_t *paper)
{
    char path[PATH_SIZE];
    FILE *file = output_open_in(path, options->folder, "rows.json");
    if (file != NULL) {
        print_json(file, paper);
    }
    return output_close(file, path);
}

static bool write_manifest(const options_t *options, const paper_t *paper, double seconds)
{
    char path[PATH_SIZE];
    FILE *file = output_open_in(path, options->folder, "report.json");
    if (file != NULL) {
        paper_write_manifest(paper, LAGLESS_COMMIT, seconds, file);
    }
    return output_close(file, path);
}

/* The data are written first, so that they are kept if drawing the pictures fails. */
static bool report(const options_t *options, const char *data, const paper_t *paper, double seconds)
{
    bool written = write_all_data(options, data, paper);
    written = write_rows(options, paper) && written;
    written = write_manifest(options, paper, seconds) && written;
    if (!written) {
        return false;
    }
    if (options->file != NULL) {
        fprintf(stderr, "data: %s\n", data);
        return true;
    }
    fprintf(stderr, "drawing\n");
    if (!output_picture("plot/report.py", options->folder, NULL, NULL)) {
        return false;
    }
    fprintf(stderr, "report: %s/index.html\ndata:   %s\n", options->folder, data);
    return true;
}

/* ---- the whole command ---- */

static void show(void *progress, size_t done, size_t total)
{
    output_progress(progress, (double)done / (double)total);
}

static unsigned threads(void)
{
    const long cores = sysconf(_SC_NPROCESSORS_ONLN);
    return cores > 0 ? (unsigned)cores : 1u;
}

/* Rows and report; frees the paper. */
static int tell(const options_t *options, const char *data, paper_t *paper, const paper_error_t *why,
                output_progress_t *progress)
{
    output_progress_end(progress);
    if (paper == NULL) {
        fprintf(stderr, "lagless paper: %s\n", why->text);
        return options->file != NULL ? EXIT_USAGE : EXIT_INTERNAL; /* requested by the file */
    }
    const double seconds = output_seconds() - progress->started;
    if (options->json) {
        print_json(stdout, paper);
    } else {
        print_table(paper);
    }
    fflush(stdout);
    fprintf(stderr, "%zu rows in %.1f s\n", paper_row_count(paper), seconds);
    bool good = true;
    for (size_t n = 0; n < paper_row_count(paper); n++) {
        const paper_verdict_t verdict = paper_row(paper, n)->verdict;
        good = good && verdict != PAPER_NOT_REPRODUCED && verdict != PAPER_DOES_NOT_HOLD;
    }
    const bool done = options->folder == NULL || report(options, data, paper, seconds);
    paper_free(paper);
    return !done ? EXIT_INTERNAL : options->file != NULL && !good ? EXIT_FAILED : EXIT_DONE;
}

/* Runs an experiment of the user. */
static int judge_file(const options_t *options)
{
    char data[PATH_SIZE] = "";
    scenario_error_t error;
    paper_error_t why;
    experiment_t *experiment = experiment_read(options->file, &error);
    if (experiment == NULL) {
        library_hand_over("paper", &error, NULL, 0u);
        library_say("paper", &error);
        library_say_motor("paper", options->file);
        return EXIT_USAGE;
    }
    const int prepared = options->folder != NULL ? prepare(options, data) : EXIT_DONE;
    if (prepared != EXIT_DONE) {
        experiment_free(experiment);
        return prepared;
    }
    output_progress_t progress = output_progress_begin();
    paper_t *paper = paper_run_file(experiment, options->folder != NULL, threads(), show, &progress, &why);
    return tell(options, data, paper, &why, &progress);
}

int command_paper(int argc, char **argv)
{
    static const struct argp_option rows[] = {
        {"json", 'j', NULL, 0, "one JSON list of rows on stdout; a report only with --out", 0},
        {"out", 'o', "FOLDER", 0, "folder of the report; default: " FOLDER ", with FIG: " FOLDER "_FIG", 0},
        ARGUMENTS_FORCE,
        {0},
    };
    static const struct argp argp = {
        rows,
        parse,
        "[FIG... | FILE]",
        "Measures the paper's figures again on the real interrupt code, compares them with the paper's "
        "numbers, and writes a report with pictures, page and data. FIG selects figures: fig04 fig05 fig08 "
        "fig10 to fig17, and beyond the paper: beyond_speed beyond_bandwidth beyond_map; default: all.\vWith "
        "a FILE (its name has a . or a /) the command runs an experiment of your own: a scenario with "
        "[[sweep]], [[measure]] and [[claim]] (docs/experiments.md). Exit 0: every claim holds or is "
        "reproduced, at least in kind; 1: at least one is not. --out FOLDER writes rows.json, report.json "
        "and the data.",
        NULL,
        NULL,
        NULL};
    options_t options = {0};
    char data[PATH_SIZE];
    paper_error_t why;
    if (!arguments_parse(&argp, argc, argv, &options)) {
        return EXIT_USAGE;
    }
    if (options.file != NULL) {
        return judge_file(&options);
    }
    if (!paper_is_for(RIG_PERIOD_TICKS, &why)) {
        fprintf(stderr, "lagless paper: %s\n", why.text);
        return EXIT_USAGE;
    }
    const int prepared = options.folder != NULL ? prepare(&options, data) : EXIT_DONE;
    if (prepared != EXIT_DONE) {
        return prepared;
    }
    output_progress_t progress = output_progress_begin();
    paper_t *paper = paper_run(options.wanted, SEED, threads(), show, &progress, &why);
    return tell(&options, data, paper, &why, &progress);
}
