#include "host_sim/cli/arguments.h"

#include <argp.h>
#include <stddef.h>

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

bool arguments_json(int argc, char **argv, const char *doc, bool *json)
{
    static const struct argp_option rows[] = {{"json", 'j', NULL, 0, "one JSON object on stdout", 0}, {0}};
    const struct argp argp = {rows, parse, NULL, doc, NULL, NULL, NULL};
    *json = false;
    return argp_parse(&argp, argc, argv, 0, NULL, json) == 0;
}
