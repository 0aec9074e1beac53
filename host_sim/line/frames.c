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

/* [octets] of a frame with a packet of this length. */
static uint32_t whole(uint32_t length, bool lossless)
{
    return FRAMES_HEADER + length + (lossless ? 0u : length % 2u + 2u);
}

static uint16_t sum_of(const uint8_t *octets, uint32_t count)
{
    uint32_t sum = 0;
    for (uint32_t n = 0; n < count; n += 2u) {
        sum += word(octets + n);
    }
    return (uint16_t)sum;
}

uint32_t frames_make(uint8_t *to, bool lossless, uint16_t counter, const uint8_t *packet, uint32_t count)
{
    const uint32_t size = whole(count, lossless);
    to[0] = (uint8_t)count;
    to[1] = (uint8_t)(count >> 8);
    to[2] = (uint8_t)counter;
    to[3] = (uint8_t)(counter >> 8);
    memcpy(to + FRAMES_HEADER, packet, count);
    if (!lossless) {
        to[FRAMES_HEADER + count] = 0; /* the fill octet, or an octet that the sum overwrites */
        const uint16_t sum = sum_of(to, size - 2u);
        to[size - 2u] = (uint8_t)sum;
        to[size - 1u] = (uint8_t)(sum >> 8);
    }
    return size;
}

static bool plausible(const uint8_t *header)
{
    const uint16_t length = word(header);
    return length != 0u && length <= FRAMES_PACKET;
}

typedef enum { WHOLE, HALF, NONE } found_t;

/* The kind of frame that begins at the oldest octet. */
static found_t look(const frames_t *frames, bool silent)
{
    const uint8_t *at = frames->octets + frames->begin;
    const uint32_t count = frames->end - frames->begin;
    const found_t half = silent ? NONE : HALF;
    if (count < FRAMES_HEADER) {
        return half;
    }
    const uint32_t size = whole(word(at), frames->lossless);
    const uint16_t counter = word(at + 2);
    if (!plausible(at)) {
        return NONE;
    }
    if (count < size) {
        return half;
    }
    if (!frames->lossless && word(at + size - 2u) != sum_of(at, size - 2u)) {
        return NONE;
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
        frames->begin += whole(*length, frames->lossless);
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
