/* SCI-A as a stream of octets, SPRUFZ5: 8 data bits, no parity, 1 stop bit, both FIFOs,
 * the interrupt of the receiving one. */
#ifndef HAL_F28335_SERIAL_H
#define HAL_F28335_SERIAL_H

#include "hal/hal.h"

#define SERIAL_PIN_MUX 1u /* function of both pins */
#if BOARD_SERIAL_BAUD != 0 && BOARD_SERIAL_PINS == BOARD_SCIA_GPIO35
#define SERIAL_PIN_IN   36u
#define SERIAL_PIN_OUT  35u
#define SERIAL_PIN_QSEL QSEL1 /* register with the input's qualification */
#else
#define SERIAL_PIN_IN   28u
#define SERIAL_PIN_OUT  29u
#define SERIAL_PIN_QSEL QSEL2
#endif

/* Sets up the line with empty FIFOs and no errors, after pins and clock of the module. Without a line
 * (BOARD_SERIAL_BAUD 0) it does nothing. */
void serial_init(void);

#endif
