#include "app/self_watch.h"

#include "contract/tap.h"
#include "math/crc.h"

/* The slots of a set, two words each. */
static uint16_t params_word(const params_t *params, uint32_t n)
{
    const uint32_t slot = tap_slot_at(params, params_table.rows[n / 2u].offset);
    return (uint16_t)(n % 2u == 0u ? slot & 0xFFFFu : slot >> 16);
}

static uint32_t params_words(void)
{
    return 2u * params_table.count;
}

void self_watch_accept(self_watch_t *watch, const params_t *params)
{
    self_watch_memory_t *memory = &watch->memory[SELF_WATCH_PARAMS];
    uint32_t crc = CRC_BEGIN;
    for (uint32_t n = 0; n < params_words(); n++) {
        crc = crc_add(crc, params_word(params, n));
    }
    *memory = (self_watch_memory_t){.crc = CRC_BEGIN, .reference = crc_end(crc), .known = 1u};
    watch->found &= ~(UINT32_C(1) << SELF_WATCH_PARAMS);
}

/* All words are included in the checksum: it is compared with that of the first round. */
static bool round_done(self_watch_memory_t *memory)
{
    const uint32_t crc = crc_end(memory->crc);
    const bool changed = memory->known != 0u && crc != memory->reference;
    if (memory->known == 0u) {
        memory->reference = crc;
        memory->known = 1u;
    }
    memory->next = 0u;
    return changed;
}

void self_watch_step(self_watch_t *watch, const params_t *params)
{
    const uint32_t turn = watch->turn;
    self_watch_memory_t *memory = &watch->memory[turn];
    hal_memory_t region = {NULL, params_words()};
    if (turn != SELF_WATCH_PARAMS) {
        region = hal_memory((hal_region_t)turn);
    }
    if (memory->next == 0u) {
        memory->crc = CRC_BEGIN;
    }
    for (uint32_t n = 0; n < SELF_WATCH_WORDS && memory->next < region.count; n++) {
        const uint32_t at = memory->next;
        memory->crc =
            crc_add(memory->crc, turn != SELF_WATCH_PARAMS ? region.words[at] : params_word(params, at));
        memory->next++;
    }
    if (memory->next >= region.count && round_done(memory)) {
        watch->found |= UINT32_C(1) << turn;
    }
    watch->turn = (turn + 1u) % SELF_WATCH_MEMORIES;
}
