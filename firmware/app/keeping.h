/* The memory of the stored parameters: the chip's flash or a memory on the I2C bus, as selected by the board
 * file. */
#ifndef APP_KEEPING_H
#define APP_KEEPING_H

#include "hal/board.h"
#include "settings/params.h"
#include "talk/mirror.h"
#include "talk/store.h"

extern const store_flash_t keeping_memory;

/* Call it before any use of keeping_memory and before hal_init. With a memory on the I2C bus it reads this
 * memory, which takes 40 ms at 400 kHz. After an error, which keeping_error() returns, the memory counts as
 * empty and accepts no write. */
void keeping_open(void);

/* mirror_error_t; always MIRROR_GOOD with flash. */
uint32_t keeping_error(void);

/* True while changes of the memory are in progress; never with flash, whose changes are complete at once. */
bool keeping_busy(void);

#if BOARD_STORE == BOARD_STORE_I2C

/* Length reserved for a set in each page. The pages begin at fixed places of the memory, so that a later
 * program with more rows finds them. */
#define KEEPING_ROWS   (sizeof(params_t) / sizeof(uint32_t))
#define KEEPING_RECORD (STORE_HEADER + STORE_PAIR * KEEPING_ROWS + STORE_END)
#define KEEPING_WORDS  ((KEEPING_RECORD + MIRROR_GROUP - 1u) / MIRROR_GROUP * MIRROR_GROUP)
#define KEEPING_STRIDE UINT32_C(1024)

typedef struct {
    mirror_t mirror;
    uint16_t pages[STORE_PAGES * KEEPING_WORDS];
} keeping_t;

/* From the background list: one short step of the changes in progress. */
void keeping_step(void);

#endif

#endif
