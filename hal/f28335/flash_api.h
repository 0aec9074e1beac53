/* TI's flash API for the F2833x, version 2.10, as a block of words. TI has published the library in the
 * object format COFF alone, which does not link with this program's EABI, so tools/flash-api links it by
 * itself, to run from the first word of L0-L3 on, with a table at its head (linker/flash_api.asm). The
 * program keeps the words in flash, copies them to where they run, and calls them by address.
 *
 * The functions have integers and pointers as arguments only, and those go the same way in both formats: the
 * first integer in AL, pointers in XAR4 and XAR5, a 32-bit integer in ACC, the rest on the stack. */
#ifndef HAL_F28335_FLASH_API_H
#define HAL_F28335_FLASH_API_H

#include <stdint.h>

/* Words of the table from the head of the block: four branches, two addresses. */
#define FLASH_API_ERASE    0u
#define FLASH_API_PROGRAM  2u
#define FLASH_API_VERIFY   4u
#define FLASH_API_VERSION  6u
#define FLASH_API_SCALE    8u  /* address of the scale factor of the CPU's clock */
#define FLASH_API_CALLBACK 10u /* address of the pointer to a function that is called meanwhile */
#define FLASH_API_HEAD     12u

#define FLASH_API_GOOD 0u      /* what the first three return, unless something failed */
#define FLASH_API_2_10 0x0210u /* what the fourth returns */

/* Where an operation failed; nothing here needs it, but the library writes it. */
typedef struct {
    uint32_t address;
    uint16_t expected;
    uint16_t actual;
} flash_api_status_t;

/* Bit 0 of the mask: sector A, to bit 7: H. */
typedef uint16_t (*flash_api_erase_t)(uint16_t sectors, flash_api_status_t *status);
/* Program and verify: words in flash, words in RAM, their number. */
typedef uint16_t (*flash_api_words_t)(uint16_t *at, uint16_t *words, uint32_t count,
                                      flash_api_status_t *status);
typedef uint16_t (*flash_api_version_t)(void);

#endif
