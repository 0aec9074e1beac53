/* `lagless explain REASON`: a fault, warning or refusal by number or name. */
#include <argp.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host_sim/cli/arguments.h"
#include "host_sim/cli/cli.h"
#include "host_sim/cli/fault_table.h"
#include "host_sim/cli/output.h"
#include "host_sim/lab/json.h"
#include "host_sim/lab/names.h"
#include "settings/reasons.h"

typedef struct {
    bool json;
    const char *reason;
} options_t;

static error_t parse(int key, char *argument, struct argp_state *state)
{
    options_t *options = state->input;
    switch (key) {
    case 'j':
        options->json = true;
        return 0;
    case ARGP_KEY_ARG:
        if (options->reason != NULL) {
            argp_error(state, "%s: a second reason; accepted: one", argument);
        }
        options->reason = argument;
        return 0;
    default:
        return ARGP_ERR_UNKNOWN;
    }
}

static const reason_row_t *find(const char *reason, names_search_t *search)
{
    char *end = NULL;
    const long number = strtol(reason, &end, 10);
    for (uint32_t n = 0; n < reasons_count; n++) {
        names_consider(search, reasons[n].name);
        if (strcmp(reasons[n].name, reason) == 0 ||
            (end != reason && *end == '\0' && reasons[n].number == number)) {
            return &reasons[n];
        }
    }
    return NULL;
}

static void print_text(const reason_row_t *row, const fault_row_t *fault)
{
    char text[FAULT_TABLE_TEXT_SIZE];
    printf("%ld  %s\n  what happened: %s\n  what to do:    %s\n", (long)row->number, row->name, row->text,
           row->remedy);
    if (fault == NULL) {
        return;
    }
    printf("  condition:     %s", fault_table_condition(text, fault));
    if (fault_table_limit(text, fault)[0] != '\0') {
        printf(", by default %s", text);
    }
    printf("\n  must hold for: %s\n", fault_table_debounce(text, fault));
    printf("  judged:        %s\n  reaction:      %s\n", fault_table_when(fault),
           fault_table_reaction(fault));
}

void explain_reason(int number)
{
    const reason_row_t *row = reason_by_number(number);
    if (row != NULL) {
        print_text(row, fault_table_row(row->number));
    }
}

static void print(const reason_row_t *row, bool json)
{
    const fault_row_t *fault = fault_table_row(row->number);
    if (!json) {
        print_text(row, fault);
        return;
    }
    printf("{\"number\": %ld, \"name\": \"%s\", \"text\": ", (long)row->number, row->name);
    json_text(stdout, row->text);
    printf(", \"remedy\": ");
    json_text(stdout, row->remedy);
    printf(", \"fault\": ");
    fault_table_print_json(fault);
    printf("}");
}

int command_explain(int argc, char **argv)
{
    static const struct argp_option rows[] = {
        ARGUMENTS_BOARD, {"json", 'j', NULL, 0, "one JSON object on stdout", 0}, {0}};
    static const struct argp argp = {
        rows,       parse,
        "[REASON]", "Explains a fault, warning or refusal and its remedy; without REASON lists all.",
        NULL,       NULL,
        NULL};
    options_t options = {false, NULL};
    if (!arguments_parse(&argp, argc, argv, &options)) {
        return EXIT_USAGE;
    }
    if (options.reason != NULL) {
        names_search_t search = names_search(options.reason);
        const reason_row_t *row = find(options.reason, &search);
        if (row == NULL) {
            fprintf(stderr, "lagless explain: %s: no such reason", options.reason);
            output_suggest(stderr, names_found(&search));
            fprintf(stderr, "\n`lagless explain` lists them.\n");
            return EXIT_USAGE;
        }
        print(row, options.json);
        printf(options.json ? "\n" : "");
        return EXIT_DONE;
    }
    int width = 0;
    for (uint32_t n = 0; n < reasons_count; n++) {
        const int length = (int)strlen(reasons[n].name);
        width = length > width ? length : width;
    }
    printf(options.json ? "{\"reasons\": [" : "");
    for (uint32_t n = 0; n < reasons_count; n++) {
        if (options.json) {
            printf(n == 0 ? "\n" : ",\n");
            print(&reasons[n], true);
        } else {
            printf("%3ld  %-*s  %s\n", (long)reasons[n].number, width, reasons[n].name, reasons[n].text);
        }
    }
    printf(options.json ? "\n]}\n" : "");
    return EXIT_DONE;
}
