/* The board that a command runs on, and `lagless boards`.
 *
 * Each board has its own program, boards/NAME/lagless in the folder of `lagless`: the same sources, linked
 * with the
 * parts that are compiled for this board. If a command is for another board, this program replaces itself by
 * the program of that board, with the same arguments. */
#ifndef HOST_SIM_CLI_BOARD_H
#define HOST_SIM_CLI_BOARD_H

#include <stdbool.h>
#include <stddef.h>

#define BOARD_WHY_SIZE 4600u

/* Stores the command line; call it before anything changes the arguments. */
void board_begin(int argc, char **argv);

/* The board of --board. Returns true in the program of this board; in another one it does not return. false:
 * `why` has the message. */
bool board_choose(const char *name, char why[BOARD_WHY_SIZE]);

/* Chooses the board that a scenario names. `text` is the scenario if it comes from stdin (NULL: from a file).
 * The call does not return if the program of another board starts. false: `why` has the reason, "" if --board
 * has chosen another board, which the reader's error reports. */
bool board_of_scenario(const char *name, const char *text, size_t octets, char why[BOARD_WHY_SIZE]);

#endif
