/* Windows of a commissioning, for a replay of its state machine on another machine. A file of 32-bit words,
 * lowest octet first:
 *
 *     head         WINDOWS_MAGIC, number of words of the state
 *     each record  WINDOWS_INIT: the state begins anew
 *                  WINDOWS_NEXT: requested step; 1 and the limits, or 0 if they are those of the window
 *                  before; the inputs; the hash of the state after the window
 *                  WINDOWS_END */
#ifndef TOOLS_TARGET_RECORDING_WINDOWS_H
#define TOOLS_TARGET_RECORDING_WINDOWS_H

#include <stdint.h>
#include <string.h>

#include "medium/commission/commission.h"

#define WINDOWS_MAGIC UINT32_C(0x314D434C)

enum { WINDOWS_END, WINDOWS_INIT, WINDOWS_NEXT };

#define WINDOWS_WORDS(type) ((uint32_t)(sizeof(type) / sizeof(uint32_t)))

/* FNV-1a over the words of the state, which has slots of 32 bits only. */
static inline uint32_t windows_hash(const commission_t *commission)
{
    uint32_t hash = UINT32_C(2166136261);
    for (uint32_t n = 0u; n < WINDOWS_WORDS(commission_t); n++) {
        uint32_t word;
        memcpy(&word, (const char *)commission + n * sizeof word, sizeof word);
        hash = (hash ^ word) * UINT32_C(16777619);
    }
    return hash;
}

_Static_assert(sizeof(commission_t) % sizeof(uint32_t) == 0u &&
                   sizeof(commission_tuning_t) % sizeof(uint32_t) == 0u &&
                   sizeof(excite_seen_t) % sizeof(uint32_t) == 0u &&
                   sizeof(turning_input_t) % sizeof(uint32_t) == 0u,
               "a slot is not of 32 bits");

#endif
