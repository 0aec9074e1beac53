#include "math/trig_q.h"

#include <stdbool.h>

#include "math/q.h"

#define EIGHTH  UINT32_C(0x20000000)
#define QUARTER UINT32_C(0x40000000)
#define HALF    UINT32_C(0x80000000)

rotation_q_t trig_rotation_q(uint32_t angle)
{
    uint32_t turned = angle + EIGHTH;
    int32_t t = (int32_t)(turned & (QUARTER - 1u)) - (int32_t)EIGHTH; /* Q29: 1 is an eighth of a turn */
    int32_t z = (int32_t)(q_square(t) >> 28);                         /* Q30 */

    /* Minimax of sin(pi t/4)/t, 2.5e-9, and cos(pi t/4), 5e-11. */
    int32_t s = INT32_C(2673625) + q_multiply(INT32_C(-38606), z, 30);
    s = INT32_C(-86699750) + q_multiply(s, z, 30);
    s = INT32_C(843314854) + q_multiply(s, z, 30);
    s = q_multiply(s, t, 29);
    int32_t c = INT32_C(-349974) + q_multiply(INT32_C(3790), z, 30);
    c = INT32_C(17023452) + q_multiply(c, z, 30);
    c = INT32_C(-331168967) + q_multiply(c, z, 30);
    c = Q_ONE(30) + q_multiply(c, z, 30);

    rotation_q_t rotation = {s, c};
    if ((turned & QUARTER) != 0u) {
        rotation.sin = c;
        rotation.cos = -s;
    }
    if ((turned & HALF) != 0u) {
        rotation.sin = -rotation.sin;
        rotation.cos = -rotation.cos;
    }
    return rotation;
}

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
    int32_t r = q_clamp(q_saturate(q_product(shorter, Q_ONE(30)) / longer), Q_ONE(30));
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
