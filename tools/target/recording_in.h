/* Reads a recording (recording.h); take() supplies the next word. */
#ifndef TESTS_TARGET_RECORDING_IN_H
#define TESTS_TARGET_RECORDING_IN_H

#include <stdbool.h>
#include <stdio.h>
#include <string.h>

#include "tools/target/recording.h"
#include "tools/target/words_in.h"

static inline void take_table(const table_t *table, void *base)
{
    for (uint32_t n = 0; n < table->count; n++) {
        const uint32_t word = take();
        memcpy((char *)base + table->rows[n].offset, &word, 4);
    }
}

/* True if it is a recording with this estimator and these tables. */
static inline bool take_head(void)
{
    return take() == RECORDING_MAGIC && take() == recording_tables();
}

/* Number of parts, and the periods of each; with more than RECORDING_PARTS parts no periods are read. */
static inline uint32_t take_parts(uint32_t periods[RECORDING_PARTS])
{
    const uint32_t parts = take();
    for (uint32_t part = 0; part < parts && parts <= RECORDING_PARTS; part++) {
        for (uint32_t word = 0; word < RECORDING_NAME; word++) {
            (void)take();
        }
        periods[part] = take();
        (void)take(); /* whether it must fit */
    }
    return parts;
}

#endif
