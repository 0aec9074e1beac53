/* `lagless params`, `signals`, `reference`: the tables, for reading, for programs, for the docs. */
#include <argp.h>
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>

#include "host_sim/cli/arguments.h"
#include "host_sim/cli/cli.h"
#include "host_sim/cli/fault_table.h"
#include "host_sim/cli/output.h"
#include "host_sim/lab/json.h"
#include "host_sim/lab/units.h"
#include "host_sim/rig/rig.h"
#include "settings/reasons.h"

/* For each table of the rig, in their order: true if its rows can be set. */
static bool settable(const table_t *table)
{
    return table->rows[0].access != TABLE_READ;
}

/* Selects the rows that `params` and `signals` list: those whose name, unit or text contains one of the
 * words; without words all rows. */
typedef struct {
    bool json;
    bool settable;
    char **words;
    int word_count;
} listing_t;

static bool is_listed(const listing_t *listing, const table_row_t *row)
{
    for (int n = 0; n < listing->word_count; n++) {
        const char *word = listing->words[n];
        if (strcasestr(row->name, word) != NULL || strcasestr(row->text, word) != NULL ||
            strcasecmp(row->unit, word) == 0) {
            return true;
        }
    }
    return listing->word_count == 0;
}

static uint32_t listed_in(const listing_t *listing, const table_t *table)
{
    uint32_t count = 0;
    for (uint32_t n = 0; settable(table) == listing->settable && n < table->count; n++) {
        count += is_listed(listing, &table->rows[n]) ? 1u : 0u;
    }
    return count;
}

static const char *kind_text(slot_kind_t kind)
{
    static const char *const texts[SLOT_KINDS] = {"float", "int32", "uint32", "choice"};
    return texts[kind];
}

static void print_json(const listing_t *listing)
{
    const char *separator = "";
    printf("{\"hash\": \"%08lx\", \"rows\": [", (unsigned long)rig_tables_hash());
    for (uint32_t t = 0; t < rig_table_count(); t++) {
        const table_t *table = rig_table(t);
        for (uint32_t n = 0; settable(table) == listing->settable && n < table->count; n++) {
            const table_row_t *row = &table->rows[n];
            if (!is_listed(listing, row)) {
                continue;
            }
            printf("%s\n  {\"id\": %lu, \"table\": \"%s\", \"name\": \"%s\", \"unit\": \"%s\", \"kind\": "
                   "\"%s\", \"text\": ",
                   separator, (unsigned long)row->id, table->name, row->name, row->unit,
                   kind_text(row->kind));
            json_text(stdout, row->text);
            if (listing->settable) {
                printf(", \"default\": ");
                json_number(stdout, rig_initial(row));
                printf(", \"min\": ");
                json_number(stdout, rig_min(row));
                printf(", \"max\": ");
                json_number(stdout, rig_max(row));
                printf(", \"while_running\": %s", row->access == TABLE_LIVE ? "true" : "false");
                printf(", \"writable\": %s", row->access != TABLE_READ ? "true" : "false");
            }
            if (row->kind == SLOT_ENUM) {
                printf(", \"choices\": \"%s\"", row->choices);
            }
            printf("}");
            separator = ",";
        }
    }
    printf("\n]}\n");
}

static void range_text(char text[2 * UNITS_TEXT_SIZE], const table_row_t *row)
{
    if (row->kind == SLOT_ENUM) {
        snprintf(text, 2 * UNITS_TEXT_SIZE, "%s", row->choices);
    } else if (row->access == TABLE_READ) {
        snprintf(text, 2 * UNITS_TEXT_SIZE, "shown");
    } else {
        units_range_text(text, rig_min(row), rig_max(row), units_of_row(row));
    }
}

static int wider(int width, const char *text)
{
    const int length = (int)strlen(text);
    return length > width ? length : width;
}

/* Columns of a table, as wide as their longest text. */
typedef struct {
    int name, value, range, unit;
} widths_t;

static widths_t widths_of(const table_t *table, const listing_t *listing)
{
    widths_t widths = {0};
    for (uint32_t n = 0; n < table->count; n++) {
        const table_row_t *row = &table->rows[n];
        if (!is_listed(listing, row)) {
            continue;
        }
        char value[UNITS_TEXT_SIZE];
        char range[2 * UNITS_TEXT_SIZE];
        widths.name = wider(widths.name, row->name);
        widths.unit = wider(widths.unit, row->unit);
        if (listing->settable) {
            range_text(range, row);
            widths.value = wider(widths.value, units_row_text(value, rig_initial(row), row));
            widths.range = wider(widths.range, range);
        }
    }
    return widths;
}

static void print_text(const listing_t *listing)
{
    for (uint32_t t = 0; t < rig_table_count(); t++) {
        const table_t *table = rig_table(t);
        if (listed_in(listing, table) == 0u) {
            continue;
        }
        printf("%s\n", table->name);
        const widths_t widths = widths_of(table, listing);
        for (uint32_t n = 0; n < table->count; n++) {
            const table_row_t *row = &table->rows[n];
            char value[UNITS_TEXT_SIZE];
            char range[2 * UNITS_TEXT_SIZE];
            if (!is_listed(listing, row)) {
                continue;
            }
            if (listing->settable) {
                units_row_text(value, rig_initial(row), row);
                range_text(range, row);
                printf("  %4lu  %-*s  %-*s  %-*s  %s%s\n", (unsigned long)row->id, widths.name, row->name,
                       widths.value, value, widths.range, range, row->text,
                       row->access == TABLE_OFF ? " (bridge off)" : "");
            } else {
                printf("  %4lu  %-*s  %-*s  %s%s%s\n", (unsigned long)row->id, widths.name, row->name,
                       widths.unit, row->unit, row->text, row->kind == SLOT_ENUM ? ": " : "", row->choices);
            }
        }
        printf("\n");
    }
}

static void markdown_cell(const char *text)
{
    printf(" ");
    for (; *text != '\0'; text++) {
        printf(*text == '|' ? "\\%c" : "%c", *text);
    }
    printf(" |");
}

static void print_markdown(void)
{
    printf("# Tables\n\nMade by `lagless reference`; a test compares the two. Ids are permanent.\n");
    for (uint32_t t = 0; t < rig_table_count(); t++) {
        const table_t *table = rig_table(t);
        printf("\n## %s\n\n", table->name);
        printf(settable(table) ? "| id | name | default | range | text |\n| --- | --- | --- | --- | --- |\n"
                               : "| id | name | unit | text |\n| --- | --- | --- | --- |\n");
        for (uint32_t n = 0; n < table->count; n++) {
            const table_row_t *row = &table->rows[n];
            char value[UNITS_TEXT_SIZE];
            char range[2 * UNITS_TEXT_SIZE];
            printf("| %lu |", (unsigned long)row->id);
            markdown_cell(row->name);
            if (settable(table)) {
                markdown_cell(units_row_text(value, rig_initial(row), row));
                range_text(range, row);
                markdown_cell(range);
            } else {
                markdown_cell(row->kind == SLOT_ENUM ? row->choices : row->unit);
            }
            markdown_cell(row->text);
            printf("\n");
        }
    }
    printf("\n## reasons\n\n| number | name | what happened | what to do |\n| --- | --- | --- | --- |\n");
    for (uint32_t n = 0; n < reasons_count; n++) {
        printf("| %ld |", (long)reasons[n].number);
        markdown_cell(reasons[n].name);
        markdown_cell(reasons[n].text);
        markdown_cell(reasons[n].remedy);
        printf("\n");
    }
    printf("\n## faults\n\n| bit | name | condition | by default | for | judged | reaction |\n"
           "| --- | --- | --- | --- | --- | --- | --- |\n");
    for (uint32_t n = 0; n < (uint32_t)FAULTS; n++) {
        const fault_row_t *row = &fault_rows[n];
        char text[FAULT_TABLE_TEXT_SIZE];
        printf("| %lu |", (unsigned long)n);
        markdown_cell(row->name);
        markdown_cell(fault_table_condition(text, row));
        markdown_cell(fault_table_limit(text, row));
        markdown_cell(fault_table_debounce(text, row));
        markdown_cell(fault_table_when(row));
        markdown_cell(fault_table_reaction(row));
        printf("\n");
    }
}

static error_t parse(int key, char *argument, struct argp_state *state)
{
    listing_t *listing = state->input;
    (void)argument;
    switch (key) {
    case 'j':
        listing->json = true;
        return 0;
    case ARGP_KEY_ARGS:
        listing->words = state->argv + state->next;
        listing->word_count = state->argc - state->next;
        return 0;
    default:
        return ARGP_ERR_UNKNOWN;
    }
}

static int print_tables(int argc, char **argv, const char *doc, bool with_settable)
{
    static const struct argp_option rows[] = {
        ARGUMENTS_BOARD, {"json", 'j', NULL, 0, "one JSON object on stdout", 0}, {0}};
    const struct argp argp = {rows, parse, "[WORD...]", doc, NULL, NULL, NULL};
    listing_t listing = {.settable = with_settable};
    if (!arguments_parse(&argp, argc, argv, &listing)) {
        return EXIT_USAGE;
    }
    uint32_t count = 0;
    for (uint32_t t = 0; t < rig_table_count(); t++) {
        count += listed_in(&listing, rig_table(t));
    }
    if (count == 0u) {
        fprintf(stderr, "%s: no row has %s in its name, unit or text; without a word all rows are listed\n",
                argv[0], listing.word_count == 1 ? listing.words[0] : "one of these words");
        return EXIT_USAGE;
    }
    if (listing.json) {
        print_json(&listing);
    } else {
        print_text(&listing);
    }
    return EXIT_DONE;
}

int command_params(int argc, char **argv)
{
    return print_tables(argc, argv,
                        "Lists every parameter and request that can be set, with default and range, or those "
                        "whose name, unit or text contains one of the words.",
                        true);
}

int command_signals(int argc, char **argv)
{
    return print_tables(
        argc, argv,
        "Lists every signal that can be recorded and used in expectations, or those whose name, "
        "unit or text contains one of the words.",
        false);
}

int command_reference(int argc, char **argv)
{
    if (!arguments_none(argc, argv, "Prints all tables as Markdown, for docs/reference.md.")) {
        return EXIT_USAGE;
    }
    print_markdown();
    return EXIT_DONE;
}
