/* The board's eQEP as position counter of a quadrature encoder, four counts a line, SPRUG05.
 *
 * Counts 0..QPOSMAX and round (PCRM 1); the index is not used. The unit timer runs in step with the carrier
 * and latches the position at its time-out, so that QPOSLAT is the position at t_k. Nothing couples the two
 * timers in hardware: qep_keep_step() compares them once a period and puts the unit timer right. */
#ifndef HAL_F28335_QEP_H
#define HAL_F28335_QEP_H

#include <stdbool.h>
#include <stdint.h>

#include "hal/board.h"

/* Which eQEP, and its pins: first of four, and their function in the multiplexer. */
#if BOARD_ENCODER == BOARD_EQEP1_GPIO20
#define QEP_MODULE  1u
#define QEP_PIN     20u
#define QEP_PIN_MUX 1u
#elif BOARD_ENCODER == BOARD_EQEP1_GPIO50
#define QEP_MODULE  1u
#define QEP_PIN     50u
#define QEP_PIN_MUX 1u
#else
#define QEP_MODULE  2u
#define QEP_PIN     24u
#define QEP_PIN_MUX 2u
#endif

/* 4 x lines - 1 for any number of lines >= 1. */
bool qep_count_max_check(uint32_t count_max);

/* Position 0, counting; the unit timer stands. */
void qep_init(uint32_t count_max);

/* The unit timer runs from zero: call next to the start of the carrier. */
void qep_start(void);

/* `elapsed` [SYSCLK cycles]: time since t_k now. If the unit timer is out by more than 0.1 us, the position
 * latched at the last t_k is of another instant by as much, and the next one will be right. */
void qep_keep_step(uint32_t elapsed);

/* Quadrature phase error (both inputs changed at once) since the last call. */
bool qep_take_error(void);

#endif
