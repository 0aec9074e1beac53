#include "math/root_q.h"

#include "math/q.h"

/* 1/sqrt(1 + n/32) in Q30. */
#define STEPS 96
static const int32_t table[STEPS + 1] = {
    1073741824, 1057347856, 1041682578, 1026693558, 1012333500, 998559613, 985333074, 972618566, 960383883,
    948599586,  937238702,  926276469,  915690104,  905458609,  895562589, 885984104, 876706528, 867714429,
    858993459,  850530263,  842312387,  834328203,  826566842,  819018128, 811672525, 804521086, 797555404,
    790767575,  784150157,  777696137,  771398898,  765252196,  759250125, 753387102, 747657839, 742057327,
    736580814,  731223792,  725981977,  720851298,  715827883,  710908045, 706088274, 701365222, 696735698,
    692196655,  687745184,  683378504,  679093957,  674889000,  670761200, 666708225, 662727842, 658817909,
    654976372,  651201261,  647490682,  643842818,  640255922,  636728315, 633258380, 629844563, 626485368,
    623179354,  619925131,  616721362,  613566757,  610460069,  607400100, 604385689, 601415717, 598489102,
    595604800,  592761802,  589959130,  587195840,  584471019,  581783781, 579133272, 576518662, 573939147,
    571393950,  568882316,  566403514,  563956835,  561541591,  559157115, 556802759, 554477894, 552181909,
    549914212,  547674226,  545461392,  543275165,  541115017,  538980433, 536870912,
};

root_q_t inverse_root_q(uint64_t square)
{
    root_q_t root;
    uint64_t at_least = square < ROOT_Q_SMALLEST ? ROOT_Q_SMALLEST : square;
    root.shift = q_clamp(q_leading_zeros(at_least) / 2, 30);
    uint32_t m = (uint32_t)((at_least << (2 * root.shift)) >> 32); /* Q30, 1..4 */

    /* 1/32 is 2^25 here. */
    uint32_t along = m > (UINT32_C(1) << 30) ? m - (UINT32_C(1) << 30) : 0u;
    uint32_t n = along >> 25;
    int32_t rest = (int32_t)(along & ((UINT32_C(1) << 25) - 1u));
    int32_t y = table[n] + q_multiply(table[n + 1u] - table[n], rest, 25);

    uint32_t y_square = (uint32_t)(((uint64_t)(uint32_t)y * (uint32_t)y) >> 30); /* Q30 */
    uint32_t near_one = (uint32_t)(((uint64_t)m * y_square) >> 30);              /* Q30 */
    uint32_t near_two = UINT32_C(0xc0000000) - near_one;
    uint64_t better = ((uint64_t)(uint32_t)y * near_two + (UINT64_C(1) << 30)) >> 31;
    root.mantissa = better < (uint64_t)Q_ONE(30) ? (int32_t)better : Q_ONE(30);
    return root;
}

uint32_t root_from_q(uint64_t square, root_q_t inverse)
{
    uint64_t m = (square << (2 * inverse.shift)) >> 32;     /* Q30, 1..4 */
    uint64_t root = (m * (uint32_t)inverse.mantissa) >> 29; /* Q31, 1..2 */
    uint64_t result = root >> inverse.shift;
    return result > UINT32_C(0xffffffff) ? UINT32_C(0xffffffff) : (uint32_t)result;
}

uint32_t root_q(uint64_t square)
{
    return root_from_q(square, inverse_root_q(square));
}
