/* Scenarios by name or file. */
#ifndef HOST_SIM_CLI_LIBRARY_H
#define HOST_SIM_CLI_LIBRARY_H

#include "host_sim/cli/arguments.h"
#include "host_sim/lab/scenario.h"

/* The scenario of this command: a file, `-` for stdin, or the name of one that comes with the program; with
 * the values of --set, judged as a whole. A value of the file that --set replaces may be wrong. NULL: the
 * reason is on stderr. */
scenario_t *library_read(const char *command, const arguments_scenario_t *of);

/* Prints the error on stderr: "lagless COMMAND: FILE:LINE:COLUMN: name: message". */
void library_say(const char *command, const scenario_error_t *error);

/* Call it after such an error. If the file is for another board, and --board is not given, this program
 * replaces itself by the program of that board. `text` is the text from stdin; NULL: the scenario is a file.
 */
void library_hand_over(const char *command, const scenario_error_t *error, const char *text, size_t octets);

/* Call it after such an error. If the file describes a motor, prints the command that writes a scenario for
 * it. */
void library_say_motor(const char *command, const char *path);

#endif
