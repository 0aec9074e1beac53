/* I2C-A as the master of one memory, SPRUG03: 24xx EEPROM or FRAM with addresses of 16 bits. */
#ifndef HAL_F28335_EEPROM_H
#define HAL_F28335_EEPROM_H

#include "hal/hal.h"

#if BOARD_STORE == BOARD_STORE_I2C

#define EEPROM_PIN_DATA  32u /* SDAA */
#define EEPROM_PIN_CLOCK 33u /* SCLA */
#define EEPROM_PIN_MUX   1u  /* function of both pins */

/* The module as it runs; pins and the module's clock come first. Nothing is sent. */
void eeprom_init(void);

/* Both lines by hand: clocks a memory out of a transfer that a reset of the chip has cut, sends a STOP, and
 * connects the pins to the module. false: a line stays low. Takes 200 us at most. */
bool eeprom_free_bus(void);

#endif

#endif
