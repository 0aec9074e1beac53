#include "host_sim/cli/arguments.h"

#include <argp.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host_sim/cli/board.h"
#include "host_sim/cli/cli.h"
#include "host_sim/cli/output.h"
#include "host_sim/rig/rig.h"

static struct {
    arguments_show_t show; /* NULL: the command is run */
    void *context;
} asked;

/* The options that all commands have in common, then those of the command. */
static argp_parser_t own_parser;
static error_t parse_any(int key, char *argument, struct argp_state *state)
{
    if (key == ARGUMENTS_BOARD_KEY) {
        char why[BOARD_WHY_SIZE];
        if (!board_choose(argument, why)) {
            argp_error(state, "--board %s: %s", argument, why);
        }
        return 0;
    }
    return own_parser != NULL ? own_parser(key, argument, state) : ARGP_ERR_UNKNOWN;
}

bool arguments_parse(const struct argp *argp, int argc, char **argv, void *input)
{
    struct argp whole = *argp;
    if (asked.show != NULL) {
        asked.show(argp, asked.context);
        return false;
    }
    if (argc == 2 && strcmp(argv[1], "--version") == 0) {
        printf("%s\n", CLI_VERSION);
        exit(EXIT_DONE);
    }
    own_parser = argp->parser;
    whole.parser = parse_any;
    return argp_parse(&whole, argc, argv, 0, NULL, input) == 0;
}

void arguments_show(int (*run)(int argc, char **argv), arguments_show_t show, void *context)
{
    char *none[] = {NULL};
    asked.show = show;
    asked.context = context;
    (void)run(0, none);
    asked.show = NULL;
}

static error_t parse(int key, char *argument, struct argp_state *state)
{
    if (key == 'j') {
        *(bool *)state->input = true;
        return 0;
    }
    if (key == ARGP_KEY_ARG) {
        argp_error(state, "%s: no argument is expected", argument);
        return 0;
    }
    return ARGP_ERR_UNKNOWN;
}

bool arguments_none(int argc, char **argv, const char *doc)
{
    const struct argp argp = {NULL, parse, NULL, doc, NULL, NULL, NULL};
    return arguments_parse(&argp, argc, argv, NULL);
}

bool arguments_json(int argc, char **argv, const char *doc, bool *json)
{
    static const struct argp_option rows[] = {{"json", 'j', NULL, 0, "one JSON object on stdout", 0}, {0}};
    const struct argp argp = {rows, parse, NULL, doc, NULL, NULL, NULL};
    *json = false;
    return arguments_parse(&argp, argc, argv, json);
}

int arguments_force(int key)
{
    if (key != ARGUMENTS_FORCE_KEY) {
        return ARGP_ERR_UNKNOWN;
    }
    output_force();
    return 0;
}

int arguments_output(int key, const char *argument, arguments_output_t *output)
{
    switch (key) {
    case 'j':
        output->json = true;
        return 0;
    case 'o':
        output->folder = argument;
        return 0;
    default:
        return arguments_force(key);
    }
}

int arguments_scenario(int key, char *argument, struct argp_state *state, arguments_scenario_t *of)
{
    switch (key) {
    case 's':
        if (of->set_count == ARGUMENTS_SETS) {
            argp_error(state,
                       "--set %s: more than %u of them; accepted: at most this number; write the others into "
                       "the scenario",
                       argument, ARGUMENTS_SETS);
        }
        of->sets[of->set_count++] = argument;
        return 0;
    case 'S':
        of->seed = argument;
        return 0;
    case ARGP_KEY_ARG:
        if (of->scenario != NULL) {
            argp_error(state, "%s: a second scenario; accepted: one", argument);
        }
        of->scenario = argument;
        return 0;
    case ARGP_KEY_NO_ARGS:
        argp_error(
            state,
            "no scenario is given; accepted: a TOML file, `-` for stdin, or a name of `lagless scenarios`");
        return 0;
    default:
        return ARGP_ERR_UNKNOWN;
    }
}

uint32_t arguments_key(const char *text, struct argp_state *state)
{
    char *end = NULL;
    const unsigned long key = strtoul(text, &end, 10);
    if (text[0] < '0' || text[0] > '9' || *end != '\0' || key == 0u ||
        key > (unsigned long)table_whole_max(rig_row_by_name("line_key"))) {
        argp_error(state,
                   "--key %s: accepted: the drive's parameter line_key, a whole number from 1 to 999999",
                   text);
    }
    return (uint32_t)key;
}

bool arguments_whole(const char *text, uint64_t min, uint64_t max, uint64_t *value)
{
    char *end = NULL;
    const bool digits = text[0] >= '0' && text[0] <= '9';
    *value = digits ? strtoull(text, &end, 10) : 0u;
    return digits && *end == '\0' && *value >= min && *value <= max && strlen(text) < 20;
}

bool arguments_number(const char *command, const char *option, const char *text, uint64_t min, uint64_t max,
                      uint64_t *value)
{
    uint64_t number = 0;
    if (text != NULL && !arguments_whole(text, min, max, &number)) {
        fprintf(stderr, "lagless %s: %s %s: accepted: whole numbers %" PRIu64 " to %" PRIu64 "\n", command,
                option, text, min, max);
        return false;
    }
    *value = text != NULL ? number : *value;
    return true;
}
