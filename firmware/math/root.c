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

    /* The steps for y = c/sqrt(square): the c between them is the one that lets both take the same product.
     */
    float share = 0.646245922f * square;
    y *= 1.54404618f - share * y * y;
    y *= 1.63393192f - share * y * y;
    return y;
}
