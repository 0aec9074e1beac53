#include "host_sim/plant/phasor.h"

#include <math.h>
#include <stdint.h>

/* pi/2 in two parts: the first has 33 bits, so that a quadrant number of 20 bits times it is exact. */
#define HALF_PI_HIGH 0x1.921fb544p+0
#define HALF_PI_LOW  0x1.0b4611a626331p-34
#define LN2_HIGH     0x1.62e42fee00000p-1
#define LN2_LOW      0x1.a39ef35793c76p-33

void phasor_at(double theta, double *cosine, double *sine)
{
    double quadrant = floor(theta * (2.0 / PHASOR_PI) + 0.5);
    double r = (theta - quadrant * HALF_PI_HIGH) - quadrant * HALF_PI_LOW;
    double x = r * r;

    /* Taylor series: for |r| <= pi/4 the remainder is 5e-17 (sine, up to r^15) and 2e-18 (cosine, up to
     * r^16). */
    double s = -1.0 / 1307674368000.0;
    s = s * x + 1.0 / 6227020800.0;
    s = s * x - 1.0 / 39916800.0;
    s = s * x + 1.0 / 362880.0;
    s = s * x - 1.0 / 5040.0;
    s = s * x + 1.0 / 120.0;
    s = s * x - 1.0 / 6.0;
    s = r + r * x * s;
    double c = 1.0 / 20922789888000.0;
    c = c * x - 1.0 / 87178291200.0;
    c = c * x + 1.0 / 479001600.0;
    c = c * x - 1.0 / 3628800.0;
    c = c * x + 1.0 / 40320.0;
    c = c * x - 1.0 / 720.0;
    c = c * x + 1.0 / 24.0;
    c = c * x - 0.5;
    c = 1.0 + x * c;

    uint64_t turn = (uint64_t)(int64_t)quadrant & 3u;
    double cos_r = (turn & 1u) ? -s : c;
    double sin_r = (turn & 1u) ? c : s;
    *cosine = (turn & 2u) ? -cos_r : cos_r;
    *sine = (turn & 2u) ? -sin_r : sin_r;
}

double phasor_decay(double x)
{
    if (x > 700.0) {
        return 0.0;
    }
    double halvings = floor(x * 1.4426950408889634 + 0.5);
    double r = halvings * LN2_HIGH - x + halvings * LN2_LOW; /* |r| <= ln(2)/2 */
    double e = 1.0;
    for (int n = 14; n > 0; n--) {
        e = 1.0 +
            e * r / (double)n; /* Taylor series in Horner form; the remainder is below 0.35^15/15! = 1e-19 */
    }
    return ldexp(e, -(int)halvings);
}
