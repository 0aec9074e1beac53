/* Standard output and error of every command: output that cannot be written is an error, and with --json
 * messages are printed as JSON too. */
#ifndef HOST_SIM_CLI_STREAMS_H
#define HOST_SIM_CLI_STREAMS_H

#include <stdint.h>

/* To be called before anything is written. From here on, when the program ends:
 *
 * - what stdout was given and could not take (a full disk, a closed one) makes the exit code 3, whatever it
 * was;
 * - with --json among the arguments, an exit code of 2 or 3 without any output prints
 *
 *       {"error": {"exit_code": 2, "message": "...", "file": "a.toml", "line": 5, "column": 1, "name":
 * "inertai"}}
 *
 *   on stdout, `message` what was said on stderr; the other four are null where no place in a file is at
 * fault.
 *
 * A standard stream that the caller has closed stays unusable: no file that is opened later takes its number.
 */
void streams_begin(int argc, char **argv);

/* What is wrong stands in a file: the place for the above. Line and column from 1; 0: the file as a whole. */
void streams_at(const char *file, uint32_t line, uint32_t column, const char *name);

#endif
