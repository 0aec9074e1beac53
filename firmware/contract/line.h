/* Constants for the master of a serial link, and the description that the drive gives of itself. */
#ifndef CONTRACT_LINE_H
#define CONTRACT_LINE_H

#include <stdbool.h>
#include <stdint.h>

#include "contract/table.h"

#define LINE_PORT   5555 /* of TCP, default of the simulated drive */
#define LINE_ANSWER 1000 /* [ms] for which a master waits for an answer; erasing flash takes longer */
#define LINE_RETRY  1    /* [ms] from the answer "busy" to the next try */

/* Named values of requests and services, which act at once, have codes on the link: any two of them, of one
 * row or of two, differ in at least eight bits, so that a disturbance of a few bits cannot change one into
 * another. Everywhere else a named value is its number. */
#define LINE_CODES_FROM UINT32_C(1000) /* first id of such a row; those below are staged */
#define LINE_CHOICES    UINT32_C(15)   /* number of choices that have a code */
#define LINE_STEP       UINT32_C(0x11111111)
#define LINE_ROW        UINT32_C(0x9E3779B1)

static inline bool line_has_codes(const table_row_t *row)
{
    return row->kind == SLOT_ENUM && row->access != TABLE_READ && row->id >= LINE_CODES_FROM;
}

/* Converts the bits of a slot to the code that is sent. */
static inline uint32_t line_bits(const table_row_t *row, uint32_t bits)
{
    if (!line_has_codes(row)) {
        return bits;
    }
    return ((bits & UINT32_C(0xF)) * LINE_STEP ^ row->id * LINE_ROW) & UINT32_C(0xFFFFFFFF);
}

/* Converts a received code to the bits of the slot. false: it is not a code. */
static inline bool line_bits_back(const table_row_t *row, uint32_t on_line, uint32_t *bits)
{
    *bits = on_line;
    if (!line_has_codes(row)) {
        return true;
    }
    *bits = (on_line ^ row->id * LINE_ROW) & UINT32_C(0xF);
    return *bits < LINE_CHOICES && line_bits(row, *bits) == on_line;
}

/* The answer of a master to the seed of the drive: a mixture of both that shows neither the key nor another
 * answer. It keeps stray clients from writing; it is no cryptography. */
static inline uint32_t line_unlocks(uint32_t seed, uint32_t key)
{
    uint32_t mixed = (seed ^ key * LINE_ROW) & UINT32_C(0xFFFFFFFF);
    for (uint32_t n = 0; n < 4u; n++) {
        mixed ^= mixed >> 15;
        mixed = mixed * UINT32_C(0x2C1B3C6D) & UINT32_C(0xFFFFFFFF);
        mixed ^= mixed >> 12;
        mixed = (mixed + key) & UINT32_C(0xFFFFFFFF);
    }
    return mixed;
}

#endif
