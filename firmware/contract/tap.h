/* The tap: chosen slots of a struct, copied once per period as they stand, and the history of the last ones.
 *
 * Recorder, history and whoever else looks in from outside read only what was copied: all values of one row
 * of the history belong to the same period. */
#ifndef CONTRACT_TAP_H
#define CONTRACT_TAP_H

#include <stddef.h>
#include <stdint.h>
#include <string.h>

/* The slot's 32 bits, whatever it holds: as float_bits() does it. */
static inline uint32_t tap_slot_at(const void *base, size_t offset)
{
    const void *slot = (const char *)base + offset;
#if defined(__TMS320C2000__)
    return *(const volatile uint32_t *)slot;
#else
    uint32_t bits;
    memcpy(&bits, slot, sizeof bits);
    return bits;
#endif
}

/* Copies the 32-bit slots at these offsets [chars of the target] of `base`, in their order. */
static inline void tap_copy(const size_t *offsets, uint32_t count, const void *base, uint32_t *slots)
{
    for (uint32_t n = 0; n < count; n++) {
        slots[n] = tap_slot_at(base, offsets[n]);
    }
}

#define TAP_PERIODS UINT32_C(256) /* of the history: a power of two */
#define TAP_SLOTS   UINT32_C(12)  /* in each of them */

typedef struct {
    uint32_t next; /* [periods] kept so far; modulo TAP_PERIODS the place of the next */
    uint32_t slots[TAP_PERIODS][TAP_SLOTS];
} tap_history_t;

/* Nothing is kept, or no longer. */
void tap_history_clear(tap_history_t *history);

/* The slots of one period more, to be written at once; the oldest are forgotten. */
static inline uint32_t *tap_history_next(tap_history_t *history)
{
    const uint32_t next = history->next;
    history->next = next + 1u != 0u ? next + 1u : TAP_PERIODS; /* of a whole turn, if it wraps */
    return history->slots[next % TAP_PERIODS];
}

/* How many periods are kept: TAP_PERIODS, or fewer after a start. */
uint32_t tap_history_count(const tap_history_t *history);

/* The slots of the period that is so many periods older than the newest; `ago` below the count. */
const uint32_t *tap_history_at(const tap_history_t *history, uint32_t ago);

#endif
