/* Scenarios by what a user calls them. */
#ifndef HOST_SIM_CLI_LIBRARY_H
#define HOST_SIM_CLI_LIBRARY_H

#include "host_sim/cli/arguments.h"
#include "host_sim/lab/scenario.h"

/* The scenario of this command: a file, `-` for stdin, or the name of one that comes with the program; with
 * the values of --set, judged as a whole. A value of the file that --set replaces may be wrong. NULL: the
 * reason is on stderr. */
scenario_t *library_read(const char *command, const arguments_scenario_t *of);

/* Prints the error on stderr, with its place. */
void library_say(const scenario_error_t *error);

/* After such an error: if the file is for another board, that board's program takes over and this does not
 * return, unless --board has chosen otherwise. The text is that of stdin; NULL: it is a file. */
void library_hand_over(const scenario_error_t *error, const char *text, size_t octets);

/* After such an error: if the file describes a motor, prints the command that writes a scenario for it. */
void library_say_motor(const char *path);

#endif
