#include "math/trig_q.h"

#include <stdbool.h>

#include "math/q.h"
#include "math/root_q.h"

#define QUARTER UINT32_C(0x40000000)
#define HALF    UINT32_C(0x80000000)

const int32_t trig_q_sines[TRIG_Q_STEPS + TRIG_Q_QUARTER] = {
    0,           105245103,   209476638,   311690799,   410903207,  506158392,   596538995,   681174602,
    759250125,   830013654,   892783698,   946955747,   992008094,  1027506862,  1053110176,  1068571464,
    1073741824,  1068571464,  1053110176,  1027506862,  992008094,  946955747,   892783698,   830013654,
    759250125,   681174602,   596538995,   506158392,   410903207,  311690799,   209476638,   105245103,
    0,           -105245103,  -209476638,  -311690799,  -410903207, -506158392,  -596538995,  -681174602,
    -759250125,  -830013654,  -892783698,  -946955747,  -992008094, -1027506862, -1053110176, -1068571464,
    -1073741824, -1068571464, -1053110176, -1027506862, -992008094, -946955747,  -892783698,  -830013654,
    -759250125,  -681174602,  -596538995,  -506158392,  -410903207, -311690799,  -209476638,  -105245103,
    0,           105245103,   209476638,   311690799,   410903207,  506158392,   596538995,   681174602,
    759250125,   830013654,   892783698,   946955747,   992008094,  1027506862,  1053110176,  1068571464,
};

uint32_t trig_atan2_q(int32_t y, int32_t x)
{
    int32_t width = q_magnitude(x);
    int32_t height = q_magnitude(y);
    bool steep = height > width;
    int32_t longer = steep ? height : width;
    int32_t shorter = steep ? width : height;
    if (longer == 0) {
        return 0u;
    }
    if (longer == 1) {
        longer = 2; /* the smallest value that has a reciprocal */
        shorter = q_add(shorter, shorter);
    }
    int32_t r = q_clamp(quotient_q(shorter, reciprocal_q(longer), 30), Q_ONE(30));
    int32_t z = q_multiply(r, r, 30);

    /* Minimax of atan(r)/r on [0, 1], 9e-8; 2^32 is a turn. */
    int32_t a = INT32_C(16786399) + q_multiply(INT32_C(-3267754), z, 30);
    a = INT32_C(-40948785) + q_multiply(a, z, 30);
    a = INT32_C(67965249) + q_multiply(a, z, 30);
    a = INT32_C(-95900242) + q_multiply(a, z, 30);
    a = INT32_C(136517386) + q_multiply(a, z, 30);
    a = INT32_C(-227846617) + q_multiply(a, z, 30);
    a = INT32_C(683565215) + q_multiply(a, z, 30);
    uint32_t angle = (uint32_t)q_multiply(a, r, 30);
    if (steep) {
        angle = QUARTER - angle;
    }
    if (x < 0) {
        angle = HALF - angle;
    }
    return y < 0 ? 0u - angle : angle;
}
