/* The two pages of the store (store.h) in a memory on a slow bus, with a copy in RAM, the mirror. At the
 * start the mirror is filled from the memory. Then the store reads, erases and programs only the mirror,
 * without waiting. mirror_step() makes the same changes in the memory, in the same order, in short steps.
 *
 * After a loss of power the memory contains the old set or the new one, as with flash. The order ensures
 * this: a page is erased from its beginning; words are written in ascending groups that never cross a group
 * of the memory; the last word, which commits a record, is written alone; and every group is read back before
 * the next one is written. If the memory does not acknowledge, the transfer is repeated for several times its
 * writing time. If a group differs when it is read back, it is written again, at most twice. After that the
 * mirror stops with an error, and nothing more is written until the next start.
 *
 * Erased words are 0xFFFF. */
#ifndef TALK_MIRROR_H
#define TALK_MIRROR_H

#include <stdbool.h>
#include <stdint.h>

#include "talk/store.h"

#define MIRROR_GROUP 4u /* [words] of a transfer; a page of the store is a multiple of it */

/* The bus; each call is like that of hal.h, and returns at once. */
typedef enum { MIRROR_BUSY, MIRROR_DONE, MIRROR_REFUSED, MIRROR_LOST } mirror_reply_t;
typedef struct {
    void (*write)(uint32_t at, const uint16_t *words, uint32_t count);
    void (*read)(uint32_t at);
    mirror_reply_t (*poll)(uint16_t words[MIRROR_GROUP]);
    void (*give_up)(void);  /* the transfer in progress */
    uint32_t (*time)(void); /* [ticks] wraps */
    uint32_t refusals_last; /* [ticks] time for which a memory may refuse, several times its writing time */
    uint32_t transfer_last; /* [ticks] longest duration of a transfer */
    uint32_t words;         /* [16-bit words] of a page of the store, in the mirror */
    uint32_t stride;        /* [16-bit words] from one page to the next in the memory */
} mirror_bus_t;

typedef enum {
    MIRROR_GOOD,
    MIRROR_NO_ANSWER, /* no memory acknowledges at the address */
    MIRROR_BUS_STUCK, /* the bus is not free, or a transfer does not end */
    MIRROR_NOT_TAKEN  /* the memory differs from the written words */
} mirror_error_t;
#define MIRROR_ERROR_NAMES "none|no_answer|bus_stuck|not_taken"

typedef struct {
    uint32_t phase;              /* [-] what mirror_step() does: mirror.c */
    uint32_t error;              /* [-] mirror_error_t; after an error nothing more is transferred */
    uint32_t at;                 /* [words] next group of `phase`, from the beginning of the mirror */
    uint32_t count;              /* [words] of that group */
    uint32_t act;                /* [-] transfer that is in progress, or the next one: mirror.c */
    uint32_t flying;             /* [-] 1: a transfer is in progress */
    uint32_t tries;              /* [-] times that this group was written */
    uint32_t begun;              /* [ticks] when the transfer began */
    uint32_t asked;              /* [ticks] time of the first try of this transfer */
    uint32_t refused;            /* [-] 1: it has refused since `asked` */
    uint32_t erases;             /* [-] pages that wait to be erased, */
    uint32_t erase[STORE_PAGES]; /* [-] and these */
    uint32_t from;               /* [words] programmed in the mirror, not yet in the memory: from here */
    uint32_t to;                 /* [words] to here, both from the beginning of the mirror */
} mirror_t;

/* Begins to fill the mirror: call mirror_step() until it is no longer busy. */
void mirror_begin(mirror_t *mirror);

/* One short step: begins a transfer, or evaluates its reply. `pages`: STORE_PAGES x bus->words words. True
 * while there is work; false: everything is done, or mirror->error is set. */
bool mirror_step(mirror_t *mirror, const mirror_bus_t *bus, uint16_t *pages);

/* The store's calls. After an error erasing and programming are refused. */
bool mirror_erase(mirror_t *mirror, const mirror_bus_t *bus, uint16_t *pages, uint32_t page);
bool mirror_program(mirror_t *mirror, const mirror_bus_t *bus, uint16_t *pages, uint32_t page, uint32_t at,
                    const uint16_t *words, uint32_t count);

/* True while mirror_step() has something to do. */
bool mirror_busy(const mirror_t *mirror);

#endif
