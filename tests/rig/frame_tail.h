/* The tail of an XCP frame on a serial line (SxI with CHECKSUM_WORD): a fill octet where the count is odd,
 * and the sum of the 16-bit words. */
#ifndef TESTS_RIG_FRAME_TAIL_H
#define TESTS_RIG_FRAME_TAIL_H

#include <stdint.h>

/* Appends the tail to `count` octets of a frame; returns how many octets the frame has then. */
static inline uint32_t frame_add_tail(uint8_t *frame, uint32_t count)
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

#endif
