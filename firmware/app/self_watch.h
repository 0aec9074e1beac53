/* The processor looks at itself: program in flash, its copy in RAM, end of the stack, active parameters. Each
 * has a check (CRC-32) that must not change. In the background, a slice a call; the drive gets
 * the part that has changed, and its fault table has the reaction.
 *
 * The first pass computes the reference, so nothing is compared in the first seconds after power-on. An error
 * that is there from the start is not found; tools/check-image finds a wrong image. */
#ifndef APP_SELF_WATCH_H
#define APP_SELF_WATCH_H

#include <stdint.h>

#include "hal/hal.h"
#include "settings/params.h"

/* A look at one memory takes so many of its words; each call is one of one memory. */
#define SELF_WATCH_WORDS 16u

/* Memories: those of the board, and the parameters. Bit n of what is found is memory n. */
#define SELF_WATCH_PARAMS   ((uint32_t)HAL_REGIONS)
#define SELF_WATCH_MEMORIES ((uint32_t)HAL_REGIONS + 1u)

typedef struct {
    uint32_t next;      /* [words] already in this round's check */
    uint32_t crc;       /* of them */
    uint32_t reference; /* check of the whole, of the first round */
    uint32_t known;     /* [-] 1: there is one */
} self_watch_memory_t;

typedef struct {
    self_watch_memory_t memory[SELF_WATCH_MEMORIES];
    uint32_t turn;  /* [-] the memory that is looked at next */
    uint32_t found; /* [-] bits of those that have changed; they stay, those of the parameters until new ones
                       are taken over */
} self_watch_t;

/* The parameters are new, and right: their check begins anew. */
void self_watch_accept(self_watch_t *watch, const params_t *params);

/* The next slice. */
void self_watch_step(self_watch_t *watch, const params_t *params);

#endif
