/* The board that a command runs on, and `lagless boards`.
 *
 * Each board has a program of its own, boards/NAME/lagless beside `lagless`: the same desk on the same core,
 * linked with what is compiled for this board. A command that is for another board than that of the program
 * is handed to that board's program, with the same arguments, in the same process. */
#ifndef HOST_SIM_CLI_BOARD_H
#define HOST_SIM_CLI_BOARD_H

#include <stdbool.h>
#include <stddef.h>

#define BOARD_WHY_SIZE 4600u

/* The command line as it was given; to be called before anything changes it. */
void board_begin(int argc, char **argv);

/* The board of --board. Returns true in the program of this board; in another one it does not return. false:
 * `why` has the message. */
bool board_choose(const char *name, char why[BOARD_WHY_SIZE]);

/* The board that a scenario names, and its text where that came from stdin (NULL: from a file). It does not
 * return if that board's program starts. false: `why` has the reason, "" if --board has chosen another board,
 * which the reader's error reports. */
bool board_of_scenario(const char *name, const char *text, size_t octets, char why[BOARD_WHY_SIZE]);

#endif
