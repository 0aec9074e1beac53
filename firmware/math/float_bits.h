/* The 32 bits of a float, and back. On the C28x the value changes its register and nothing else: there the
 * compiler makes a call of memcpy, into flash, even with optimisation. Elsewhere memcpy is what it makes none
 * of.
 *
 * No state; every bit pattern passes. */
#ifndef MATH_FLOAT_BITS_H
#define MATH_FLOAT_BITS_H

#include <stdint.h>
#if !defined(__TMS320C2000__)
#include <string.h>
#endif

static inline uint32_t float_bits(float value)
{
#if defined(__TMS320C2000__)
    return __f32_bits_as_u32(value);
#else
    /* As many chars in one as in the other, whatever a char is. */
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    return bits;
#endif
}

static inline float float_of_bits(uint32_t bits)
{
#if defined(__TMS320C2000__)
    return __u32_bits_as_f32(bits);
#else
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
#endif
}

#endif
