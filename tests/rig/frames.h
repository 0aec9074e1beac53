/* Frames of XCP as a master writes them (docs/serial.md): a head of length and counter, the packet, and on
 * a serial line (SxI with CHECKSUM_WORD) a tail. The tail is a fill octet if the number of octets is odd,
 * and the sum of the 16-bit words. */
#ifndef TESTS_RIG_FRAMES_H
#define TESTS_RIG_FRAMES_H

#include <stdbool.h>
#include <stdint.h>
#include <string.h>

#include "math/float_bits.h"

#define FRAMES_MOST (4u + 64u + 3u) /* [octets] */

/* Appends the tail to the `count` octets of a frame; returns the new number of octets. */
static inline uint32_t frames_tail(uint8_t *frame, uint32_t count)
{
    const uint32_t end = count + count % 2u;
    uint32_t sum = 0u;
    frame[count] = 0u;
    for (uint32_t n = 0; n < end; n++) {
        sum += (uint32_t)frame[n] << 8u * (n % 2u);
    }
    frame[end] = (uint8_t)sum;
    frame[end + 1u] = (uint8_t)(sum >> 8);
    return end + 2u;
}

/* Makes the frame of a packet, with or without a tail; returns the number of octets. */
static inline uint32_t frames_make(uint8_t *frame, const uint8_t *packet, uint32_t count, uint32_t counter,
                                   bool tail)
{
    frame[0] = (uint8_t)count;
    frame[1] = 0u;
    frame[2] = (uint8_t)counter;
    frame[3] = (uint8_t)(counter >> 8);
    memcpy(frame + 4, packet, count);
    return tail ? frames_tail(frame, 4u + count) : 4u + count;
}

/* The code that represents a named value on the line, if the value takes effect at once. */
static inline uint32_t frames_code(uint32_t id, uint32_t choice)
{
    return choice * UINT32_C(0x11111111) ^ id * UINT32_C(0x9E3779B1);
}

static inline void frames_put_long(uint8_t *octets, uint32_t value)
{
    for (uint32_t n = 0; n < 4u; n++) {
        octets[n] = (uint8_t)(value >> 8u * n);
    }
}

static inline uint32_t frames_long_at(const uint8_t *octets)
{
    return (uint32_t)octets[0] | (uint32_t)octets[1] << 8 | (uint32_t)octets[2] << 16 |
           (uint32_t)octets[3] << 24;
}

#endif
