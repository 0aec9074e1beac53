/* The board's eQEP as position counter of a quadrature encoder, four counts a line, SPRUG05.
 *
 * It counts from 0 to QPOSMAX and then from 0 again (PCRM 1); the index is not used. The unit timer has the
 * period of the carrier and latches the position at its time-out, so that QPOSLAT is the position at t_k. The
 * hardware does not couple the two timers. Therefore qep_keep_step() compares them once a period and corrects
 * the unit timer. */
#ifndef HAL_F28335_QEP_H
#define HAL_F28335_QEP_H

#include <stdbool.h>
#include <stdint.h>

#include "hal/board.h"

/* The number of the eQEP, the first of its four pins, and the function of these pins in the multiplexer. */
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

/* True if count_max is 4 x lines - 1 for a number of lines >= 1. */
bool qep_count_max_check(uint32_t count_max);

/* Starts counting at position 0; the unit timer does not run yet. */
void qep_init(uint32_t count_max);

/* Starts the unit timer at zero: call it immediately before or after the start of the carrier. */
void qep_start(void);

/* `elapsed` [SYSCLK cycles] is the time since t_k. If the unit timer differs from it by more than 0.1 us, the
 * last position was latched too early or too late by the difference. The call corrects the timer for the next
 * position. */
void qep_keep_step(uint32_t elapsed);

/* Quadrature phase error (both inputs changed at once) since the last call. */
bool qep_take_error(void);

#endif
