/* Standard output and error of every command: output that cannot be written is an error, and with --json
 * messages are printed as JSON too. */
#ifndef HOST_SIM_CLI_STREAMS_H
#define HOST_SIM_CLI_STREAMS_H

#include <stdint.h>

/* Call it before anything is written. It acts when the program ends:
 *
 * - if stdout could not accept all output (full disk, closed stream), the exit code becomes 3;
 * - with --json among the arguments, an exit code of 2 or 3 without any output prints
 *
 *     {"error": {"exit_code": 2, "message": "...", "file": "a.toml", "line": 5, "column": 1, "name": ".."}}
 *
 *   on stdout. `message` is the text of stderr; the other four are null if the error has no place in a file.
 *
 * A standard stream that the caller has closed remains unusable: no file that is opened later gets its
 * number.
 */
void streams_begin(int argc, char **argv);

/* Sets the place of an error in a file for this output. Line and column count from 1; 0: the file as a whole.
 */
void streams_at(const char *file, uint32_t line, uint32_t column, const char *name);

#endif
