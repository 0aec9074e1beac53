/* The tap: selected slots of a struct, copied unchanged once per period.
 *
 * Recorder, capture and every other reader outside the drive read only the copy: all values of one row belong
 * to the same period. */
#ifndef CONTRACT_TAP_H
#define CONTRACT_TAP_H

#include <stddef.h>
#include <stdint.h>
#include <string.h>

/* The 32 bits of the slot, for any content; see float_bits(). */
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

/* The slot with this number, of a struct that consists of slots. */
static inline uint32_t tap_slot(const void *base, uint32_t number)
{
    const uint32_t *slots = base;
    return tap_slot_at(&slots[number], 0u);
}

/* Copies the 32-bit slots at these offsets [chars of the target] of `base`, in their order. */
static inline void tap_copy(const size_t *offsets, uint32_t count, const void *base, uint32_t *slots)
{
    for (uint32_t n = 0; n < count; n++) {
        slots[n] = tap_slot_at(base, offsets[n]);
    }
}

#endif
