#include "talk/mirror.h"

#define ERASED 0xFFFFu
#define TRIES  3u

#define PHASE_IDLE    0u
#define PHASE_FILL    1u
#define PHASE_ERASE   2u
#define PHASE_PROGRAM 3u

/* Transfers of one group: reading its content, writing, and reading it back. */
#define ACT_LOOK  0u
#define ACT_WRITE 1u
#define ACT_PROVE 2u

void mirror_begin(mirror_t *mirror)
{
    *mirror = (mirror_t){.phase = PHASE_FILL, .count = MIRROR_GROUP, .act = ACT_LOOK};
}

bool mirror_busy(const mirror_t *mirror)
{
    return mirror->error == (uint32_t)MIRROR_GOOD && mirror->phase != PHASE_IDLE;
}

static uint32_t smaller(uint32_t a, uint32_t b)
{
    return a < b ? a : b;
}

/* The next words to be programmed: up to the end of their group. The last word of a record is programmed
 * alone. */
static uint32_t count_to_program(const mirror_t *mirror, uint32_t at)
{
    const uint32_t group = MIRROR_GROUP - at % MIRROR_GROUP;
    return at + 1u == mirror->to ? 1u : smaller(group, mirror->to - 1u - at);
}

/* Begins the next phase with its first group. */
static void next_phase(mirror_t *mirror, const mirror_bus_t *bus)
{
    mirror->tries = 0u;
    if (mirror->erases > 0u) {
        mirror->phase = PHASE_ERASE;
        mirror->at = mirror->erase[0] * bus->words;
        mirror->count = MIRROR_GROUP;
        mirror->act = ACT_LOOK;
    } else if (mirror->to > mirror->from) {
        mirror->phase = PHASE_PROGRAM;
        mirror->at = mirror->from;
        mirror->act = ACT_WRITE;
    } else {
        mirror->phase = PHASE_IDLE;
    }
}

static void next_group(mirror_t *mirror, const mirror_bus_t *bus)
{
    mirror->tries = 0u;
    mirror->at += mirror->count;
    switch (mirror->phase) {
    case PHASE_FILL:
        if (mirror->at == STORE_PAGES * bus->words) {
            next_phase(mirror, bus);
        }
        break;
    case PHASE_ERASE:
        mirror->act = ACT_LOOK;
        if (mirror->at == (mirror->erase[0] + 1u) * bus->words) {
            mirror->erase[0] = mirror->erase[1];
            mirror->erases--;
            next_phase(mirror, bus);
        }
        break;
    default:
        mirror->act = ACT_WRITE;
        if (mirror->at == mirror->to) {
            mirror->from = mirror->to;
            next_phase(mirror, bus);
        }
        break;
    }
}

/* The value that a word of the present group must have. */
static uint16_t wanted(const mirror_t *mirror, const uint16_t *pages, uint32_t at)
{
    return mirror->phase == PHASE_ERASE ? ERASED : pages[at];
}

/* True if the words of the group that was read have these values. A read begins with a group of the memory.
 */
static bool agrees(const mirror_t *mirror, const uint16_t *pages, const uint16_t read[MIRROR_GROUP])
{
    for (uint32_t n = 0; n < mirror->count; n++) {
        const uint32_t at = mirror->at + n;
        if (read[at % MIRROR_GROUP] != wanted(mirror, pages, at)) {
            return false;
        }
    }
    return true;
}

/* A transfer has ended without an error. */
static void take(mirror_t *mirror, const mirror_bus_t *bus, uint16_t *pages,
                 const uint16_t read[MIRROR_GROUP])
{
    if (mirror->phase == PHASE_FILL) {
        for (uint32_t n = 0; n < MIRROR_GROUP; n++) {
            pages[mirror->at + n] = read[n];
        }
        next_group(mirror, bus);
    } else if (mirror->act == ACT_WRITE) {
        mirror->act = ACT_PROVE;
    } else if (agrees(mirror, pages, read)) {
        next_group(mirror, bus);
    } else if (mirror->tries < TRIES) {
        mirror->act = ACT_WRITE;
    } else {
        mirror->error = (uint32_t)MIRROR_NOT_TAKEN;
    }
}

static void start(mirror_t *mirror, const mirror_bus_t *bus, const uint16_t *pages)
{
    const uint32_t page = mirror->at / bus->words;
    const uint32_t place = page * bus->stride + (mirror->at - page * bus->words);
    mirror->begun = bus->time();
    mirror->asked = mirror->refused != 0u ? mirror->asked : mirror->begun;
    mirror->flying = 1u;
    if (mirror->act != ACT_WRITE) {
        bus->read(place - place % MIRROR_GROUP);
        return;
    }
    if (mirror->phase == PHASE_PROGRAM) {
        mirror->count = count_to_program(mirror, mirror->at);
    }
    uint16_t words[MIRROR_GROUP];
    for (uint32_t n = 0; n < mirror->count; n++) {
        words[n] = wanted(mirror, pages, mirror->at + n);
    }
    mirror->tries++;
    bus->write(place, words, mirror->count);
}

/* A transfer has failed: it is repeated, unless the repetitions have lasted too long. */
static void again(mirror_t *mirror, const mirror_bus_t *bus, mirror_error_t error)
{
    mirror->refused = 1u;
    mirror->tries -= mirror->act == ACT_WRITE ? 1u : 0u; /* nothing was written */
    if (bus->time() - mirror->asked > bus->refusals_last) {
        mirror->error = (uint32_t)error;
    }
}

bool mirror_step(mirror_t *mirror, const mirror_bus_t *bus, uint16_t *pages)
{
    uint16_t read[MIRROR_GROUP];
    if (!mirror_busy(mirror)) {
        return false;
    }
    if (mirror->flying == 0u) {
        start(mirror, bus, pages);
        return true;
    }
    const mirror_reply_t reply = bus->poll(read);
    if (reply == MIRROR_BUSY && bus->time() - mirror->begun <= bus->transfer_last) {
        return true;
    }
    mirror->flying = 0u;
    if (reply == MIRROR_DONE) {
        mirror->refused = 0u;
        take(mirror, bus, pages, read);
    } else if (reply == MIRROR_REFUSED) {
        again(mirror, bus, MIRROR_NO_ANSWER);
    } else {
        bus->give_up();
        again(mirror, bus, MIRROR_BUS_STUCK);
    }
    return mirror_busy(mirror);
}

/* Selects the next phase for mirror_step() if there is none. */
static void wake(mirror_t *mirror, const mirror_bus_t *bus)
{
    if (mirror->phase == PHASE_IDLE) {
        next_phase(mirror, bus);
    }
}

bool mirror_erase(mirror_t *mirror, const mirror_bus_t *bus, uint16_t *pages, uint32_t page)
{
    if (mirror->error != (uint32_t)MIRROR_GOOD || mirror->erases == STORE_PAGES) {
        return false;
    }
    for (uint32_t n = 0; n < bus->words; n++) {
        pages[page * bus->words + n] = ERASED;
    }
    mirror->erase[mirror->erases] = page;
    mirror->erases++;
    wake(mirror, bus);
    return true;
}

bool mirror_program(mirror_t *mirror, const mirror_bus_t *bus, uint16_t *pages, uint32_t page, uint32_t at,
                    const uint16_t *words, uint32_t count)
{
    const uint32_t first = page * bus->words + at;
    if (mirror->error != (uint32_t)MIRROR_GOOD) {
        return false;
    }
    for (uint32_t n = 0; n < count; n++) {
        pages[first + n] = words[n];
    }
    mirror->from = mirror->to > mirror->from ? mirror->from : first;
    mirror->to = first + count;
    wake(mirror, bus);
    return true;
}
