/* Commands that take --json and nothing else. */
#ifndef HOST_SIM_CLI_ARGUMENTS_H
#define HOST_SIM_CLI_ARGUMENTS_H

#include <stdbool.h>

/* Reads the command line; `doc` is what --help says. false: wrong use, said on stderr. */
bool arguments_json(int argc, char **argv, const char *doc, bool *json);

#endif
