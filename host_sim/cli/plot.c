/* `lagless plot RECORDING`, `lagless compare A B`: run tools/plot/look.py with the data of the tables that it
 * needs. */
#include "host_sim/cli/plot.h"

#include <argp.h>
#include <stdio.h>
#include <string.h>

#include "host_sim/cli/arguments.h"
#include "host_sim/cli/cli.h"
#include "host_sim/cli/fault_table.h"
#include "host_sim/cli/output.h"
#include "host_sim/lab/inputs.h"
#include "host_sim/lab/json.h"
#include "host_sim/rig/rig.h"
#include "settings/reasons.h"

#define SCRIPT "plot/look.py"

bool plot_formats(const char *command, const char *formats)
{
    bool good = formats[0] != '\0';
    for (const char *word = formats; good && *word != '\0';) {
        const size_t length = strcspn(word, ",");
        good = (length == 4u && strncmp(word, "html", 4) == 0) ||
               (length == 3u && (strncmp(word, "png", 3) == 0 || strncmp(word, "svg", 3) == 0));
        word += length;
        word += *word == ',' ? 1 : 0;
    }
    if (!good) {
        fprintf(stderr, "lagless %s: pictures as %s: accepted: html, png, svg, separated by commas\n",
                command, formats);
    }
    return good;
}

/* ---- data that a recording does not contain ---- */

static void write_rows(FILE *file)
{
    const char *separator = "";
    fprintf(file, "\"rows\": [");
    for (uint32_t t = 0; t < rig_table_count(); t++) {
        const table_t *table = rig_table(t);
        for (uint32_t n = 0; n < table->count; n++) {
            static const char *const kinds[SLOT_KINDS] = {"float", "int", "uint", "choice"};
            const table_row_t *row = &table->rows[n];
            fprintf(file, "%s\n{\"table\": \"%s\", \"name\": \"%s\", \"kind\": \"%s\", \"text\": ", separator,
                    table->name, row->name, kinds[row->kind]);
            json_text(file, row->text);
            if (row->access != TABLE_READ) {
                fprintf(file, ", \"default\": ");
                json_number(file, rig_initial(row));
            }
            if (row->kind == SLOT_ENUM) {
                fprintf(file, ", \"choices\": \"%s\"", row->choices);
            }
            fprintf(file, "}");
            separator = ",";
        }
    }
    fprintf(file, "]");
}

/* Rows, reasons by number, faults by bit: as one JSON object. */
static void write_tables(FILE *file, const char *command)
{
    fprintf(file, "{\"command\": \"%s\", ", command);
    write_rows(file);
    fprintf(file, ", \"reasons\": {");
    for (uint32_t n = 0; n < reasons_count; n++) {
        fprintf(file, "%s\"%ld\": {\"name\": \"%s\", \"text\": ", n == 0u ? "" : ",\n",
                (long)reasons[n].number, reasons[n].name);
        json_text(file, reasons[n].text);
        fprintf(file, ", \"remedy\": ");
        json_text(file, reasons[n].remedy);
        fprintf(file, "}");
    }
    fprintf(file, "}, \"faults\": [");
    for (uint32_t n = 0; n < FAULTS; n++) {
        fprintf(file, "%s\"%s\"", n == 0u ? "" : ", ", fault_rows[n].name);
    }
    fprintf(file, "]}\n");
}

static int look(const char *command, const char *const *arguments)
{
    FILE *tables = tmpfile();
    if (tables == NULL) {
        fprintf(stderr, "lagless %s: no temporary file can be made\n", command);
        return EXIT_INTERNAL;
    }
    write_tables(tables, command);
    const int exit_code = output_script(SCRIPT, arguments, tables);
    fclose(tables);
    return exit_code;
}

int plot_draw(const char *command, const char *recording, const char *folder, const char *formats, bool quiet)
{
    const char *arguments[] = {
        "plot", recording, "--format", formats, quiet ? "--quiet" : "--tell", folder != NULL ? "--out" : NULL,
        folder, NULL};
    return look(command, arguments);
}

/* ---- the commands ---- */

typedef struct {
    const char *command;
    const char *recordings[2];
    int wanted, given;
    const char *folder;
    const char *formats;
    bool plot;
} options_t;

static error_t parse(int key, char *argument, struct argp_state *state)
{
    options_t *options = state->input;
    switch (key) {
    case 'o':
        options->folder = argument;
        return 0;
    case 'f':
        options->formats = argument;
        return 0;
    case 'p':
        options->plot = true;
        return 0;
    case ARGUMENTS_FORCE_KEY:
        return arguments_force(key);
    case ARGP_KEY_ARG:
        if (options->given == options->wanted) {
            argp_error(state,
                       options->wanted == 1 ? "%s: a second recording; accepted: one"
                                            : "%s: a third recording; accepted: two",
                       argument);
        }
        options->recordings[options->given++] = argument;
        return 0;
    case ARGP_KEY_END:
        if (options->given < options->wanted) {
            argp_error(state, options->wanted == 1 ? "no recording is given; accepted: a CSV or MAT file "
                                                     "that `lagless run` or `lagless connect` wrote"
                                                   : "two recordings are needed; accepted: CSV or MAT files "
                                                     "that `lagless run` or `lagless connect` wrote");
        }
        return 0;
    default:
        return ARGP_ERR_UNKNOWN;
    }
}

/* Pictures of a recording in `folder`; NULL: in the folder of the recording. The history of its fault is
 * drawn as well if there is one. */
static bool plot_allowed(const options_t *options)
{
    char folder[PATH_SIZE];
    char name[256];
    char fault[272];
    const char *recording = options->recordings[0];
    const char *slash = strrchr(recording, '/');
    const char *base = slash != NULL ? slash + 1 : recording;
    const char *point = strrchr(base, '.');
    snprintf(folder, sizeof folder, "%.*s", slash != NULL ? (int)(slash - recording) : 1,
             slash != NULL ? recording : ".");
    snprintf(name, sizeof name, "%.*s", point != NULL ? (int)(point - base) : (int)strlen(base), base);
    snprintf(fault, sizeof fault, "%s_fault", name);
    const char *to = options->folder != NULL ? options->folder : folder;
    return output_allowed_pictures(to, name, options->formats) &&
           output_allowed_pictures(to, fault, options->formats);
}

#define FORMAT_TEXT "html (default), png, svg, separated by commas"

int command_plot(int argc, char **argv)
{
    static const struct argp_option rows[] = {
        {"out", 'o', "FOLDER", 0, "folder for the output; default: beside the recording", 0},
        {"format", 'f', "FORMATS", 0, FORMAT_TEXT, 0},
        ARGUMENTS_FORCE,
        {0},
    };
    static const struct argp argp = {
        rows,
        parse,
        "RECORDING",
        "Plots a recording (CSV or MAT) of `lagless run` or `lagless connect` as a page with zoom, "
        "verdicts and settings, or as pictures. The history of its fault, NAME_fault.csv, is included.",
        NULL,
        NULL,
        NULL};
    options_t options = {.wanted = 1, .formats = "html"};
    if (!arguments_parse(&argp, argc, argv, &options) || !plot_formats("plot", options.formats)) {
        return EXIT_USAGE;
    }
    inputs_note(options.recordings[0]);
    if (!plot_allowed(&options)) {
        return EXIT_USAGE;
    }
    return plot_draw("plot", options.recordings[0], options.folder, options.formats, false);
}

int command_compare(int argc, char **argv)
{
    static const struct argp_option rows[] = {
        {"plot", 'p', NULL, 0, "also plot both, into a new folder below runs", 0},
        {"out", 'o', "FOLDER", 0, "also plot both, into this folder", 0},
        {"format", 'f', "FORMATS", 0, FORMAT_TEXT, 0},
        ARGUMENTS_FORCE,
        {0},
    };
    static const struct argp argp = {
        rows,
        parse,
        "A B",
        "Compares two recordings (CSV or MAT) bit for bit: the first difference, the difference of each "
        "signal, "
        "and different settings. Exit 0: all samples are equal; 1: they are not.",
        NULL,
        NULL,
        NULL};
    options_t options = {.wanted = 2, .formats = "html"};
    char fresh[PATH_SIZE];
    if (!arguments_parse(&argp, argc, argv, &options) || !plot_formats("compare", options.formats)) {
        return EXIT_USAGE;
    }
    if (options.plot && options.folder == NULL) {
        if (!output_fresh_folder(fresh, "runs", "compare")) {
            return EXIT_INTERNAL;
        }
        options.folder = fresh;
    }
    inputs_note(options.recordings[0]);
    inputs_note(options.recordings[1]);
    if (options.folder != NULL && !output_allowed_pictures(options.folder, "compare", options.formats)) {
        return EXIT_USAGE;
    }
    const char *arguments[] = {"compare",
                               options.recordings[0],
                               options.recordings[1],
                               "--format",
                               options.formats,
                               options.folder != NULL ? "--out" : NULL,
                               options.folder,
                               NULL};
    return look("compare", arguments);
}
