/* Self-test of the processor: program in flash, its copy in RAM, end of the stack, active parameters. Each
 * has a check (CRC-32) that must not change. It runs in the background, one slice per call; the drive gets
 * the part that has changed, and its fault table defines the reaction.
 *
 * The first pass computes the reference, so nothing is compared in the first seconds after power-on. An error
 * that is present from the start is not found; tools/check-image finds a wrong image. */
#ifndef APP_SELF_WATCH_H
#define APP_SELF_WATCH_H

#include <stdint.h>

#include "hal/hal.h"
#include "settings/params.h"

/* Number of words of one memory in a call; each call checks one memory. */
#define SELF_WATCH_WORDS 20u

/* Memories: those of the board, and the parameters. Bit n of `found` is memory n. */
#define SELF_WATCH_PARAMS   ((uint32_t)HAL_REGIONS)
#define SELF_WATCH_MEMORIES ((uint32_t)HAL_REGIONS + 1u)

typedef struct {
    uint32_t next;      /* [words] included in the check of this round */
    uint32_t crc;       /* check of these words */
    uint32_t reference; /* check of the whole memory, from the first round */
    uint32_t known;     /* [-] 1: the reference is known */
} self_watch_memory_t;

typedef struct {
    self_watch_memory_t memory[SELF_WATCH_MEMORIES];
    uint32_t turn;  /* [-] memory that is checked next */
    uint32_t found; /* [-] bits of the changed memories; permanent, for parameters until a new set */
} self_watch_t;

/* The parameters are new and valid: their check restarts. */
void self_watch_accept(self_watch_t *watch, const params_t *params);

/* Checks the next slice. */
void self_watch_step(self_watch_t *watch, const params_t *params);

#endif
