/* Erases and programs flash by TI's flash API (flash_api.h). From flash_begin to flash_end the API runs in
 * the memory of the interrupt's code, with interrupts and watchdog off. Call flash_end after any result of
 * flash_begin. */
#ifndef HAL_F28335_FLASH_H
#define HAL_F28335_FLASH_H

#include <stdbool.h>
#include <stdint.h>

/* Copies the API to its place in RAM and sets it up. False: the build has no API, or another version. */
bool flash_begin(void);

/* Erases sectors. Bit 0: sector A, to bit 7: H. False: not erased. */
bool flash_erase(uint16_t sectors);

/* Changes ones to zeros. False: the word differs when it is read back. */
bool flash_program(uint32_t address, uint16_t word);

/* Restores the interrupt's code. */
void flash_end(void);

#endif
