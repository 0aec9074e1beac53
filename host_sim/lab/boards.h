/* The boards between which the program chooses: by name, and for a motor. */
#ifndef HOST_SIM_LAB_BOARDS_H
#define HOST_SIM_LAB_BOARDS_H

#include <stdbool.h>
#include <stddef.h>

#include "host_sim/lab/board_facts.h"
#include "host_sim/lab/motor.h"

#define BOARDS_TEXT_SIZE 480u
#define BOARDS_NAME_SIZE 64u

/* The board with this name. NULL: there is none; `why` has the nearest name and all names. */
const board_facts_t *boards_find(const char *name, char why[BOARDS_TEXT_SIZE]);

/* true: this program or library simulates the default board. */
bool boards_is_default(void);

/* Line `board = "NAME"` for a scenario that the program writes; "" for the default board. */
const char *boards_line(void);

/* true: the board suits the motor. Its current limit is at least 1.25 times the rated current. The link
 * voltage of the motor, or the link that its EMF needs at rated speed, is below the largest trip of the
 * board. */
bool boards_current_suits(const board_facts_t *board, const motor_t *motor);
bool boards_voltage_suits(const board_facts_t *board, const motor_t *motor);

/* The best of the boards that suit the motor: the lowest voltage, then the smallest current range, which has
 * the finest resolution. NULL: none suits. */
const board_facts_t *boards_propose(const motor_t *motor);

/* Message if the motor does not suit the board of this program, with both numbers and a suitable board; else
 * "". Returns `to`. */
const char *boards_unsuited(char to[BOARDS_TEXT_SIZE], const motor_t *motor);

/* Message if the tasks of the drive do not have enough time on this board, by their estimated cost: the
 * medium task would end later than its window, and each setpoint would act for two windows; else "". Returns
 * `to`. */
const char *boards_hurried(char to[BOARDS_TEXT_SIZE], const board_facts_t *board);

/* The board of this program; NULL: it is not in the list. */
const board_facts_t *boards_present(void);

#endif
