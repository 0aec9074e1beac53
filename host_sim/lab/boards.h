/* The boards between which the program chooses: by name, and for a motor. */
#ifndef HOST_SIM_LAB_BOARDS_H
#define HOST_SIM_LAB_BOARDS_H

#include <stdbool.h>
#include <stddef.h>

#include "host_sim/lab/board_facts.h"
#include "host_sim/lab/motor.h"

#define BOARDS_TEXT_SIZE 480u
#define BOARDS_NAME_SIZE 64u

/* NULL: no board is called so, and `why` has the nearest name and all of them. */
const board_facts_t *boards_find(const char *name, char why[BOARDS_TEXT_SIZE]);

/* Does this program or library simulate the board that acts if none is chosen? */
bool boards_is_default(void);

/* For the head of a scenario that the program writes: `board = "NAME"` and the end of the line; "" for the
 * board that acts if none is chosen. */
const char *boards_line(void);

/* Does the motor get 1.25 times its rated current, and does the link that it is made for, or that its EMF at
 * the rated speed needs, stay below the board's largest trip? */
bool boards_current_suits(const board_facts_t *board, const motor_t *motor);
bool boards_voltage_suits(const board_facts_t *board, const motor_t *motor);

/* Of the boards that suit the motor the one with the lowest voltage, and of those the one with the smallest
 * range of currents: it sees the motor in the finest steps. NULL: none suits. */
const board_facts_t *boards_propose(const motor_t *motor);

/* Why the motor does not suit this program's board, with both numbers, and which board suits; "" if it does.
 * Returns `to`. */
const char *boards_unsuited(char to[BOARDS_TEXT_SIZE], const motor_t *motor);

#endif
