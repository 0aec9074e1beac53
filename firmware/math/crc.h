/* Cyclic redundancy check of memory, word by word: CRC-32 of IEEE 802.3 (polynomial 04C11DB7h, reflected;
 * initial and final value all ones), each 16-bit word as two octets, the lower first. It detects every error
 * of up to 32 neighbouring bits, and all but one in 2^32 of the others. No state, no division; 4 steps per
 * word. */
#ifndef MATH_CRC_H
#define MATH_CRC_H

#include <stdint.h>

#define CRC_BEGIN UINT32_C(0xFFFFFFFF)

/* The check of all words up to this one, from the check of the previous words. Begin with CRC_BEGIN. */
uint32_t crc_add(uint32_t crc, uint16_t word);

/* The check in its usual form, after the last word. */
static inline uint32_t crc_end(uint32_t crc)
{
    return ~crc;
}

#endif
