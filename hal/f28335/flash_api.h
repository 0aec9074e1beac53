/* TI's flash API for the F2833x, version 2.10, as a block of words. TI publishes the library only in the
 * object format COFF, which does not link with the EABI of this program. Therefore tools/flash-api links it
 * separately, for the memory from the first word of L0-L3 on, with a table at its beginning
 * (linker/flash_api.asm). The program stores the words in flash, copies them to this memory, and calls the
 * functions by address. Their arguments are integers and pointers only, which both formats pass in the same
 * registers: the first integer in AL, pointers in XAR4 and XAR5, a 32-bit integer in ACC, the rest on the
 * stack. */
#ifndef HAL_F28335_FLASH_API_H
#define HAL_F28335_FLASH_API_H

#include <stdint.h>

/* Words of the table from the head of the block: four branches, two addresses. */
#define FLASH_API_ERASE    0u
#define FLASH_API_PROGRAM  2u
#define FLASH_API_VERIFY   4u
#define FLASH_API_VERSION  6u
#define FLASH_API_SCALE    8u  /* address of the scale factor of the CPU's clock */
#define FLASH_API_CALLBACK 10u /* address of the pointer to a function that is called during an operation */
#define FLASH_API_HEAD     12u

#define FLASH_API_GOOD 0u      /* result of the first three functions without an error */
#define FLASH_API_2_10 0x0210u /* result of the fourth function */

/* Place at which an operation failed. The library writes it; this program does not use it. */
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
