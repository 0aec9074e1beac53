/* Scenarios by what a user calls them. */
#ifndef HOST_SIM_CLI_LIBRARY_H
#define HOST_SIM_CLI_LIBRARY_H

#include "host_sim/cli/arguments.h"
#include "host_sim/lab/scenario.h"

/* The scenario of this command: a file, `-` for stdin, or the name of one that comes with the program; with
 * what
 * --set gives, judged as a whole. A value of the file that --set replaces may be wrong. NULL: said why on
 * stderr. */
scenario_t *library_read(const char *command, const arguments_scenario_t *of);

/* Says it on stderr, and where it is. */
void library_say(const scenario_error_t *error);

#endif
