/* `lagless paper`: every figure of the paper measured again, and judged. */
#include <argp.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "host_sim/cli/cli.h"
#include "host_sim/cli/output.h"
#include "host_sim/lab/names.h"
#include "host_sim/lab/paper.h"

#define SEED 1u

typedef struct {
    bool json;
    const char *folder;
    bool wanted[PAPER_FIGURES];
    bool named; /* at least one figure */
} options_t;

/* ---- the command line ---- */

static void want(struct argp_state *state, const char *id, options_t *options)
{
    const size_t figure = paper_figure(id);
    if (figure == PAPER_FIGURES) {
        char known[PAPER_FIGURES * 8u] = "";
        names_search_t search = names_search(id);
        for (size_t n = 0; n < PAPER_FIGURES; n++) {
            names_consider(&search, paper_figures[n].id);
            strcat(strcat(known, n == 0 ? "" : " "), paper_figures[n].id);
        }
        const char *near = names_found(&search);
        argp_error(state, "%s: no such figure%s%s; known are %s", id, near != NULL ? "; did you mean " : "",
                   near != NULL ? near : "", known);
    }
    options->wanted[figure] = true;
    options->named = true;
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
    case ARGP_KEY_ARG:
        want(state, argument, options);
        return 0;
    case ARGP_KEY_END:
        for (size_t n = 0; n < PAPER_FIGURES; n++) {
            options->wanted[n] = options->wanted[n] || !options->named;
        }
        return 0;
    default:
        return ARGP_ERR_UNKNOWN;
    }
}

/* ---- rows ---- */

static void print_key(FILE *file, const char *key, const char *text)
{
    fprintf(file, ", \"%s\": ", key);
    output_json_text(file, text);
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
        output_json_text(file, row->id);
        print_key(file, "claim", row->claim);
        fprintf(file, ", \"paper\": ");
        output_json_number(file, row->paper);
        fprintf(file, ", \"ours\": ");
        output_json_number(file, row->ours);
        print_key(file, "unit", row->unit);
        print_key(file, "verdict", verdict);
        print_key(file, "condition", row->condition);
        fprintf(file, "}");
    }
    fprintf(file, "]\n");
}

static void print_number(double number)
{
    if (isnan(number)) {
        printf("  %8s", "-");
    } else {
        printf("  %8.*f",
               fabs(number) < 9.995   ? 3
               : fabs(number) < 999.5 ? 1
                                      : 0,
               fabs(number) < 0.0005 ? 0.0 : number);
    }
}

static void print_table(const paper_t *paper)
{
    size_t figure = PAPER_FIGURES;
    size_t verdicts[3] = {0};
    printf("%-36s %-70s  %8s  %8s  %-6s verdict\n", "", "", "paper", "ours", "unit");
    for (size_t n = 0; n < paper_row_count(paper); n++) {
        const paper_row_t *row = paper_row(paper, n);
        if (row->figure != figure) {
            figure = row->figure;
            printf("\n%s  %s\n", paper_figures[figure].id, paper_figures[figure].title);
        }
        printf("%-36s %-70s", row->id, row->claim);
        print_number(row->paper);
        print_number(row->ours);
        printf("  %-6s %s%s%s\n", row->unit, paper_verdict_name(row->verdict),
               row->because[0] != '\0' ? ", " : "", row->because);
        verdicts[row->verdict]++;
    }
    printf("\n%zu reproduced, %zu in kind, %zu not; ideal: inverter and sensors without error; real: 2.5 us "
           "dead "
           "time,\ncompensated, 12-bit ADC, noise 10 mA, offset 30 mA, gain error 0.2 %%. --json tells each "
           "row's "
           "conditions.\n",
           verdicts[PAPER_REPRODUCED], verdicts[PAPER_IN_KIND], verdicts[PAPER_NOT_REPRODUCED]);
}

/* ---- files ---- */

static bool figure_path(char path[PATH_SIZE], const char *folder, size_t figure)
{
    char name[32];
    snprintf(name, sizeof name, "%s.csv", paper_figures[figure].id);
    return output_path(path, folder, name);
}

/* Before a minute of simulation, not after it: can all files be written? */
static bool prepare(const options_t *options)
{
    char path[PATH_SIZE];
    if (!output_folder(options->folder) || !output_path(path, options->folder, "rows.json")) {
        return false;
    }
    FILE *file = output_open(path);
    return file != NULL && output_close(file, path);
}

static bool write_files(const options_t *options, const paper_t *paper)
{
    char path[PATH_SIZE];
    bool done = true;
    for (size_t n = 0; n < PAPER_FIGURES; n++) {
        if (!options->wanted[n]) {
            continue;
        }
        FILE *file = figure_path(path, options->folder, n) ? output_open(path) : NULL;
        if (file != NULL) {
            paper_write_csv(paper, n, file);
        }
        done = file != NULL && output_close(file, path) && done;
    }
    FILE *file = output_path(path, options->folder, "rows.json") ? output_open(path) : NULL;
    if (file != NULL) {
        print_json(file, paper);
    }
    return file != NULL && output_close(file, path) && done;
}

/* ---- all of it ---- */

static void progress(void *context, size_t done, size_t total)
{
    (void)context;
    fprintf(stderr, "\r%zu of %zu runs%s", done, total, done == total ? "\n" : "");
}

int command_paper(int argc, char **argv)
{
    static const struct argp_option rows[] = {
        {"json", 'j', NULL, 0, "one JSON list of rows on stdout", 0},
        {"out", 'o', "FOLDER", 0, "write rows.json and the traces, FIG.csv, there", 0},
        {0},
    };
    static const struct argp argp = {
        rows,
        parse,
        "[FIG...]",
        "The paper's figures (all of them, or fig04 fig05 fig08 fig10 to fig17), "
        "measured again on the real interrupt code and judged against the paper's "
        "numbers.",
        NULL,
        NULL,
        NULL};
    options_t options = {0};
    paper_error_t why;
    if (argp_parse(&argp, argc, argv, 0, NULL, &options) != 0) {
        return EXIT_USAGE;
    }
    if (options.folder != NULL && !prepare(&options)) {
        return EXIT_INTERNAL;
    }
    const double started = output_seconds();
    const long cores = sysconf(_SC_NPROCESSORS_ONLN);
    paper_t *paper = paper_run(options.wanted, SEED, cores > 0 ? (unsigned)cores : 1u,
                               isatty(fileno(stderr)) ? progress : NULL, NULL, &why);
    if (paper == NULL) {
        fprintf(stderr, "lagless paper: %s\n", why.text);
        return EXIT_INTERNAL;
    }
    if (options.json) {
        print_json(stdout, paper);
    } else {
        print_table(paper);
    }
    fflush(stdout);
    fprintf(stderr, "%zu rows in %.1f s\n", paper_row_count(paper), output_seconds() - started);
    const bool written = options.folder == NULL || write_files(&options, paper);
    paper_free(paper);
    if (!written) {
        return EXIT_INTERNAL;
    }
    if (options.folder != NULL) {
        fprintf(stderr, "data: %s\n", options.folder);
    }
    return EXIT_DONE;
}
