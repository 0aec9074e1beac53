#include "math/root.h"

#include <stdint.h>
#include <string.h>

#define GUESS UINT32_C(0x5f200000)

float inverse_root(float square)
{
    /* As many chars in one as in the other, whatever a char is: the bits of the float. */
    uint32_t bits;
    float y;
    memcpy(&bits, &square, sizeof bits);
    bits = GUESS - (bits >> 1);
    memcpy(&y, &bits, sizeof y);

    y *= 1.68191035f - 0.703947667f * square * y * y;
    y *= 1.50000048f - 0.500000158f * square * y * y;
    return y;
}
