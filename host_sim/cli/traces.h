/* Samples of a run in memory, for `lagless run --json --traces`. */
#ifndef HOST_SIM_CLI_TRACES_H
#define HOST_SIM_CLI_TRACES_H

#include <stdbool.h>
#include <stdint.h>

#include "host_sim/rig/rig.h"

#define TRACES_OCTETS_MAX (UINT64_C(256) << 20) /* [octets] of slots: some 6 million samples of 10 rows */

/* All zero but `ids` and `count`: empty. */
typedef struct {
    const uint32_t *ids; /* rows */
    uint32_t count;      /* [-] of them */
    uint32_t *slots;     /* samples one after the other: the period, then the rows */
    uint64_t samples, room;
    bool full;       /* the memory is full: the later samples are missing */
    rig_sink_t next; /* NULL: there is no other sink */
    void *next_context;
} traces_t;

/* A rig_sink_t; context is a traces_t. */
void traces_sink(void *context, uint32_t period, const uint32_t *slots, uint32_t count);

/* Prints a JSON list of {"name", "unit", "values"}, time [s] first. A number that is read back gives the same
 * float; a value that is not finite is null, and a choice is its number. */
void traces_print(const traces_t *traces);

void traces_free(traces_t *traces);

#endif
