/* Data acquisition: lists of slots that are copied in the interrupt and sent by the background.
 *
 * A client makes lists, tables of the packets of a list (ODT) and their entries, each of them one slot; then
 * starts them. A start turns a list's entries into a plain row of offsets, so that in the interrupt a sample
 * is the stamp and `*p++ = *slot`. Samples stand in a queue of cells; a sample that finds it full is lost as
 * a whole, counted, and told to the client once by an event.
 *
 * Only the interrupt writes `put`, only the background `got`; a list is changed only while it does not run.
 * Packets by XCP: identification by absolute ODT number, stamp of 4 octets in the first ODT of a list. */
#ifndef TALK_DAQ_H
#define TALK_DAQ_H

#include <stdbool.h>
#include <stdint.h>

#include "contract/tap.h"

#define DAQ_LISTS      2u
#define DAQ_ENTRIES    16u /* in all */
#define DAQ_ODTS       16u /* in all: none need be empty */
#define DAQ_CELLS      32u /* samples that wait: a power of two */
#define DAQ_ENTRY_SIZE 4u  /* [octets] */

typedef struct {
    uint32_t odt_first, odts; /* in odts[] */
    uint32_t selected;        /* [-] 1: for the next common start or stop */
    uint32_t prescaler;       /* [periods] from sample to sample, 1..255 */
    uint32_t countdown;       /* [periods] to the next one */
    uint32_t first, entries;  /* in slots[], while it runs */
} daq_list_t;

typedef struct {
    uint32_t first, entries; /* in offsets[] */
} daq_odt_t;

typedef struct {
    uint32_t list;
    uint32_t stamp;              /* [periods] */
    uint32_t slots[DAQ_ENTRIES]; /* of the list's ODTs, one after the other */
} daq_cell_t;

/* What has been allocated of a set of lists, in the order that the protocol asks for. */
typedef enum { DAQ_FREE, DAQ_HAS_LISTS, DAQ_HAS_ODTS, DAQ_HAS_ENTRIES } daq_stage_t;

typedef struct {
    uint32_t stage; /* [-] daq_stage_t */
    uint32_t lists; /* [-] allocated, as are odts_used and entries_used */
    uint32_t odts_used;
    uint32_t entries_used;
    uint32_t running; /* [-] bit n: list n; one store starts and stops */
    daq_list_t list[DAQ_LISTS];
    daq_odt_t odt[DAQ_ODTS];
    uint32_t offsets[DAQ_ENTRIES]; /* [chars of the target] as written; DAQ_NO_OFFSET: not yet */
    uint32_t slots[DAQ_ENTRIES];   /* [chars of the target] in the order of copying */
    uint32_t put, got;             /* [samples] into and out of the queue so far */
    uint32_t lost;                 /* [samples] since the start */
    uint32_t told;                 /* [samples] of them that the client knows of */
    uint32_t next_odt;             /* [-] of the oldest sample, to be sent next */
    daq_cell_t cells[DAQ_CELLS];
} daq_t;

#define DAQ_NO_OFFSET UINT32_C(0xFFFFFFFF)

/* How a change ended. */
typedef enum {
    DAQ_DONE,
    DAQ_ACTIVE,       /* a list runs */
    DAQ_OUT_OF_RANGE, /* there is no such list, ODT or entry */
    DAQ_SEQUENCE,     /* out of the order of allocations */
    DAQ_OVERFLOW,     /* more than there is room for */
    DAQ_INCOMPLETE    /* an entry has not been written */
} daq_result_t;

/* Nothing allocated, nothing in the queue; `lost` stays. */
void daq_clear(daq_t *daq);

daq_result_t daq_alloc_lists(daq_t *daq, uint32_t count);
daq_result_t daq_alloc_odts(daq_t *daq, uint32_t list, uint32_t count);
daq_result_t daq_alloc_entries(daq_t *daq, uint32_t list, uint32_t odt, uint32_t count);

/* The entry of an ODT gets the slot at this offset. */
daq_result_t daq_write(daq_t *daq, uint32_t list, uint32_t odt, uint32_t entry, uint32_t offset);
bool daq_has_entry(const daq_t *daq, uint32_t list, uint32_t odt, uint32_t entry);

daq_result_t daq_set_prescaler(daq_t *daq, uint32_t list, uint32_t prescaler);
daq_result_t daq_select(daq_t *daq, uint32_t list);

/* These lists [bits], all in the same period, with nothing selected afterwards; none of them, if one is not
 * complete. A list that runs already goes on as it does. */
daq_result_t daq_start(daq_t *daq, uint32_t lists);
void daq_stop(daq_t *daq, uint32_t lists);
uint32_t daq_selected(const daq_t *daq); /* [bits] */

/* In the interrupt: copies the slots of all lists that run and are due in this period. */
void daq_copy(daq_t *daq, const void *base, uint32_t period);

static inline void daq_sample(daq_t *daq, const void *base, uint32_t period)
{
    if (daq->running != 0u) {
        daq_copy(daq, base, period);
    }
}

/* The next packet, up to 5 + 4 x DAQ_ENTRIES octets, one per word; 0: there is none. `written`: `put`, as it
 * stands now. */
uint32_t daq_next(daq_t *daq, uint32_t written, uint16_t *octets);

/* Has a sample been lost that was not told yet? Each call tells those so far. `lost`: as it stands now. */
bool daq_overloaded(daq_t *daq, uint32_t lost);

#endif
