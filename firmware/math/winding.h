/* The winding's own law over a window of n periods, with nothing known of the rotor: what the voltage that
 * acted, less what the resistance takes, has moved the current by if there was no EMF,
 *
 *     (T sum(u) - R n T (i_0 + i_n)/2)/L
 *
 * The difference to i_n - i_0 is the EMF's. Noise of the samples comes into it through its two ends alone,
 * however long it is (docs/theory.md, 27). */
#ifndef MATH_WINDING_H
#define MATH_WINDING_H

#include "math/frames.h"

typedef struct {
    float per_volt;   /* T/L [A/V] */
    float per_ampere; /* R T/(2 L) [-], of the sum of a window's first and last current, for a period */
} winding_t;

/* R [ohm], L [H] > 0, T [s]. A division: for the background. */
static inline winding_t winding_prepare(float resistance, float inductance, float period)
{
    const float per_volt = period / inductance;
    return (winding_t){per_volt, 0.5f * per_volt * resistance};
}

/* The link [V] below which its whole voltage, 2/3 u_dc, moves the current of this inductance [H] by less than
 * 2 % of the range [A] in a period [s]: at the limit of the voltage a current may then stay within a code, or
 * lag behind what is asked for by tens of milliseconds. */
static inline float winding_slow_link(float inductance, float range, float period)
{
    return 0.02f * 1.5f * range * inductance / period;
}

/* [A]; `voltage`: the sum of it [V] over so many periods, between these two currents [A]. */
static inline ab_t winding_given(const winding_t *winding, ab_t voltage, float periods, ab_t first, ab_t last)
{
    const float lost = winding->per_ampere * periods;
    return (ab_t){winding->per_volt * voltage.alpha - lost * (first.alpha + last.alpha),
                  winding->per_volt * voltage.beta - lost * (first.beta + last.beta)};
}

#endif
