/* A set of rows of the fault table (faults.h), one bit each: row n is bit n mod 32 of word n/32. */
#ifndef GUARD_FAULT_SET_H
#define GUARD_FAULT_SET_H

#include <stdbool.h>
#include <stdint.h>

#include "settings/faults.h"

#define FAULT_WORDS 2u

typedef struct {
    uint32_t word[FAULT_WORDS]; /* [-] bits */
} fault_set_t;

/* Word and bit of a row. The check below ensures that every row has a bit. */
#define FAULT_WORD(row) ((uint32_t)(row) / 32u)
#define FAULT_BIT(row)  (UINT32_C(1) << (uint32_t)(row) % 32u)
extern const char fault_set_holds_all_rows[(uint32_t)FAULTS <= 32u * FAULT_WORDS ? 1 : -1];

static inline fault_set_t fault_set_none(void)
{
    return (fault_set_t){{0u, 0u}};
}

static inline fault_set_t fault_set_of(fault_bit_t row)
{
    fault_set_t set = fault_set_none();
    set.word[FAULT_WORD(row)] = FAULT_BIT(row);
    return set;
}

static inline bool fault_set_has(fault_set_t set, fault_bit_t row)
{
    return (set.word[FAULT_WORD(row)] & FAULT_BIT(row)) != 0u;
}

static inline bool fault_set_any(fault_set_t set)
{
    return (set.word[0] | set.word[1]) != 0u;
}

static inline fault_set_t fault_set_both(fault_set_t one, fault_set_t other)
{
    return (fault_set_t){{one.word[0] | other.word[0], one.word[1] | other.word[1]}};
}

static inline fault_set_t fault_set_common(fault_set_t one, fault_set_t other)
{
    return (fault_set_t){{one.word[0] & other.word[0], one.word[1] & other.word[1]}};
}

static inline fault_set_t fault_set_without(fault_set_t set, fault_set_t others)
{
    return (fault_set_t){{set.word[0] & ~others.word[0], set.word[1] & ~others.word[1]}};
}

#endif
