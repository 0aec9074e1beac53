#include "contract/tap.h"

#include <string.h>

/* The slot's 32 bits, whatever it holds: as float_bits() does it. */
static inline uint32_t slot_at(const void *base, size_t offset)
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

void tap_copy(const size_t *offsets, uint32_t count, const void *base, uint32_t *slots)
{
    for (uint32_t n = 0; n < count; n++) {
        slots[n] = slot_at(base, offsets[n]);
    }
}

bool tap_history_init(tap_history_t *history, const table_t *table, const uint32_t ids[TAP_SLOTS])
{
    size_t offsets[TAP_SLOTS];
    for (uint32_t n = 0; n < TAP_SLOTS; n++) {
        const table_row_t *row = table_by_id(table, ids[n]);
        if (row == NULL) {
            return false;
        }
        offsets[n] = row->offset;
    }
    memcpy(history->offsets, offsets, sizeof offsets);
    memcpy(history->ids, ids, sizeof history->ids);
    tap_history_clear(history);
    return true;
}

void tap_history_clear(tap_history_t *history)
{
    history->next = 0u;
}

void tap_history_keep(tap_history_t *history, const void *base)
{
    uint32_t *slots = history->slots[history->next % TAP_PERIODS];
    const size_t *offsets = history->offsets;
    /* without a loop: the interrupt's, each period */
    slots[0] = slot_at(base, offsets[0]);
    slots[1] = slot_at(base, offsets[1]);
    slots[2] = slot_at(base, offsets[2]);
    slots[3] = slot_at(base, offsets[3]);
    slots[4] = slot_at(base, offsets[4]);
    slots[5] = slot_at(base, offsets[5]);
    slots[6] = slot_at(base, offsets[6]);
    slots[7] = slot_at(base, offsets[7]);
    slots[8] = slot_at(base, offsets[8]);
    slots[9] = slot_at(base, offsets[9]);
    slots[10] = slot_at(base, offsets[10]);
    slots[11] = slot_at(base, offsets[11]);
    history->next =
        history->next + 1u != 0u ? history->next + 1u : TAP_PERIODS; /* of a whole turn, if it wraps */
}

uint32_t tap_history_count(const tap_history_t *history)
{
    return history->next < TAP_PERIODS ? history->next : TAP_PERIODS;
}

const uint32_t *tap_history_at(const tap_history_t *history, uint32_t ago)
{
    return history->slots[(history->next - 1u - ago) % TAP_PERIODS];
}
