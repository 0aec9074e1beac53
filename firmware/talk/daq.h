/* Data acquisition: lists of slots that the interrupt copies and the background sends.
 *
 * A client allocates lists, tables of the packets of a list (ODT) and their entries, each of which is one
 * slot; then it starts the lists. A start converts a list's entries to an array of offsets, so that a sample
 * in the interrupt consists of the stamp and `*p++ = *slot`. Samples wait in a queue of cells; a sample that
 * finds the queue full is discarded as a whole, counted, and reported to the client once by an event.
 *
 * Only the interrupt writes `put`, only the background `got`; a list is changed only while it does not run.
 * Packets follow XCP: identification by absolute ODT number, stamp of 4 octets in the first ODT of a list. */
#ifndef TALK_DAQ_H
#define TALK_DAQ_H

#include <stdbool.h>
#include <stdint.h>

#include "contract/tap.h"

#define DAQ_LISTS      2u
#define DAQ_ENTRIES    16u /* in total */
#define DAQ_ODTS       16u /* in total: at most one per entry */
#define DAQ_CELLS      32u /* waiting samples: a power of two */
#define DAQ_ENTRY_SIZE 4u  /* [octets] */

typedef struct {
    uint32_t odt_first, odts; /* in odts[] */
    uint32_t selected;        /* [-] 1: selected for the next common start or stop */
    uint32_t prescaler;       /* [periods] from sample to sample, 1..255 */
    uint32_t countdown;       /* [periods] until the next sample */
    uint32_t first, entries;  /* in slots[], while the list runs */
} daq_list_t;

typedef struct {
    uint32_t first, entries; /* in offsets[] */
} daq_odt_t;

typedef struct {
    uint32_t list;
    uint32_t stamp;              /* [periods] */
    uint32_t slots[DAQ_ENTRIES]; /* of the list's ODTs, one after the other */
} daq_cell_t;

/* The allocations of a set of lists, in the order that the protocol requires. */
typedef enum { DAQ_FREE, DAQ_HAS_LISTS, DAQ_HAS_ODTS, DAQ_HAS_ENTRIES } daq_stage_t;

typedef struct {
    uint32_t stage; /* [-] daq_stage_t */
    uint32_t lists; /* [-] allocated, as are odts_used and entries_used */
    uint32_t odts_used;
    uint32_t entries_used;
    uint32_t running; /* [-] bit n: list n; one store starts and stops lists */
    daq_list_t list[DAQ_LISTS];
    daq_odt_t odt[DAQ_ODTS];
    uint32_t offsets[DAQ_ENTRIES]; /* [chars of the target] as written; DAQ_NO_OFFSET: not yet */
    uint32_t slots[DAQ_ENTRIES];   /* [chars of the target] in the order in which they are copied */
    uint32_t put, got;             /* [samples] into and out of the queue so far */
    uint32_t lost;                 /* [samples] since the start */
    uint32_t told;                 /* [samples] lost samples that were reported to the client */
    uint32_t next_odt;             /* [-] of the oldest sample, which is sent next */
    daq_cell_t cells[DAQ_CELLS];
} daq_t;

#define DAQ_NO_OFFSET UINT32_C(0xFFFFFFFF)

/* The result of a change. */
typedef enum {
    DAQ_DONE,
    DAQ_ACTIVE,       /* a list runs */
    DAQ_OUT_OF_RANGE, /* the list, ODT or entry does not exist */
    DAQ_SEQUENCE,     /* the order of allocations is wrong */
    DAQ_OVERFLOW,     /* there is not enough space */
    DAQ_INCOMPLETE    /* an entry has not been written */
} daq_result_t;

/* Removes all allocations and empties the queue; `lost` is kept. */
void daq_clear(daq_t *daq);

daq_result_t daq_alloc_lists(daq_t *daq, uint32_t count);
daq_result_t daq_alloc_odts(daq_t *daq, uint32_t list, uint32_t count);
daq_result_t daq_alloc_entries(daq_t *daq, uint32_t list, uint32_t odt, uint32_t count);

/* Assigns the slot at this offset to the entry of an ODT. */
daq_result_t daq_write(daq_t *daq, uint32_t list, uint32_t odt, uint32_t entry, uint32_t offset);
bool daq_has_entry(const daq_t *daq, uint32_t list, uint32_t odt, uint32_t entry);

daq_result_t daq_set_prescaler(daq_t *daq, uint32_t list, uint32_t prescaler);
daq_result_t daq_select(daq_t *daq, uint32_t list);

/* Starts these lists [bits], all in the same period, and clears the selection; starts none of them if one is
 * incomplete. A list that runs already continues. */
daq_result_t daq_start(daq_t *daq, uint32_t lists);
void daq_stop(daq_t *daq, uint32_t lists);
uint32_t daq_selected(const daq_t *daq); /* [bits] */

/* In the interrupt: copies the slots of all running lists that are due in this period. */
void daq_copy(daq_t *daq, const void *base, uint32_t period);

static inline void daq_sample(daq_t *daq, const void *base, uint32_t period)
{
    if (daq->running != 0u) {
        daq_copy(daq, base, period);
    }
}

/* Writes the next packet, up to 5 + 4 x DAQ_ENTRIES octets, one per word, and returns its length; 0: there is
 * none. `written`: the present value of `put`. */
uint32_t daq_next(daq_t *daq, uint32_t written, uint16_t *octets);

/* True if samples were lost that have not been reported yet; the call marks them as
 * reported. `lost`: its present value. */
bool daq_overloaded(daq_t *daq, uint32_t lost);

#endif
