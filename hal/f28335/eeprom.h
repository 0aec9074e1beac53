/* I2C-A as the master of one memory, SPRUG03: 24xx EEPROM or FRAM with addresses of 16 bits. */
#ifndef HAL_F28335_EEPROM_H
#define HAL_F28335_EEPROM_H

#include "hal/hal.h"

#if BOARD_STORE == BOARD_STORE_I2C

#define EEPROM_PIN_DATA  32u /* SDAA */
#define EEPROM_PIN_CLOCK 33u /* SCLA */
#define EEPROM_PIN_MUX   1u  /* function of both pins */

/* Sets up the module, after pins and clock of the module. Nothing is sent. */
void eeprom_init(void);

/* Drives both lines as plain pins: clock pulses end a transfer that a reset of the chip has interrupted, then
 * a STOP follows. Connects the pins to the module. false: a line remains low. It takes at most 200 us. */
bool eeprom_free_bus(void);

#endif

#endif
