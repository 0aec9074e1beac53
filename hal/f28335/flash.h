/* Erasing and programming of flash by TI's flash API (flash_api.h), which runs in the place of the
 * interrupt's code meanwhile: with interrupts and watchdog off, from flash_begin to flash_end, whatever that
 * returned. */
#ifndef HAL_F28335_FLASH_H
#define HAL_F28335_FLASH_H

#include <stdbool.h>
#include <stdint.h>

/* Copies the API to where it runs and sets it up. False: the build has none, or it is another version. */
bool flash_begin(void);

/* Bit 0: sector A, to bit 7: H. False: not erased. */
bool flash_erase(uint16_t sectors);

/* Turns ones into zeros. False: the word does not read like that. */
bool flash_program(uint32_t address, uint16_t word);

/* The interrupt's code is back. */
void flash_end(void);

#endif
