#include "host_sim/line/frames.h"

#include <string.h>

void frames_init(frames_t *frames, bool lossless)
{
    *frames = (frames_t){.lossless = lossless};
}

uint8_t *frames_room(frames_t *frames, uint32_t *room)
{
    memmove(frames->octets, frames->octets + frames->begin, frames->end - frames->begin);
    frames->end -= frames->begin;
    frames->begin = 0;
    *room = FRAMES_ROOM - frames->end;
    return frames->octets + frames->end;
}

void frames_received(frames_t *frames, uint32_t count, double now)
{
    frames->end += count;
    frames->last = now;
}

static uint16_t word(const uint8_t *at)
{
    return (uint16_t)(at[0] | at[1] << 8);
}

static bool plausible(const uint8_t *header)
{
    const uint16_t length = word(header);
    return length != 0u && length <= FRAMES_PACKET;
}

typedef enum { WHOLE, HALF, NONE } found_t;

/* What begins at the oldest octet. */
static found_t look(const frames_t *frames, bool silent)
{
    const uint8_t *at = frames->octets + frames->begin;
    const uint32_t count = frames->end - frames->begin;
    const found_t half = silent ? NONE : HALF;
    if (count < FRAMES_HEADER) {
        return half;
    }
    const uint32_t size = FRAMES_HEADER + word(at);
    const uint16_t counter = word(at + 2);
    if (!plausible(at)) {
        return NONE;
    }
    if (count < size) {
        return half;
    }
    if (frames->lossless || (frames->counted && counter == frames->counter) ||
        (!frames->counted && count == size)) {
        return WHOLE;
    }
    if (count < size + FRAMES_HEADER) {
        return silent && count == size ? WHOLE : half;
    }
    return plausible(at + size) && word(at + size + 2u) == (uint16_t)(counter + 1u) ? WHOLE : NONE;
}

const uint8_t *frames_next(frames_t *frames, double now, uint32_t *length)
{
    const bool silent = !frames->lossless && now - frames->last >= FRAMES_SILENCE;
    while (frames->begin != frames->end && !frames->broken) {
        const found_t found = look(frames, silent);
        if (found == HALF) {
            break;
        }
        if (found == NONE) {
            frames->broken = frames->lossless;
            frames->begin++;
            frames->dropped++;
            continue;
        }
        const uint8_t *at = frames->octets + frames->begin;
        const uint16_t counter = word(at + 2);
        frames->missing += frames->counted ? (uint16_t)(counter - frames->counter) : 0u;
        frames->counted = true;
        frames->counter = (uint16_t)(counter + 1u);
        *length = word(at);
        frames->begin += FRAMES_HEADER + *length;
        return at + FRAMES_HEADER;
    }
    return NULL;
}

double frames_patience(const frames_t *frames, double now)
{
    if (frames->lossless || frames->begin == frames->end) {
        return 1e9;
    }
    const double left = frames->last + FRAMES_SILENCE - now;
    return left > 0.0 ? left : 0.0;
}
