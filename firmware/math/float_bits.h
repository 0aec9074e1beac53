/* The 32 bits of a float, and the inverse. On the C28x the value only changes its register. Its compiler
 * would call memcpy, in flash, even with optimisation. Elsewhere memcpy is inlined.
 *
 * No state; every bit pattern is preserved. */
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
    /* Both types have the same number of chars, for any size of a char. */
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
