/* The voltage equation of the winding over a window of n periods, independent of the rotor: the change of the
 * current by the voltage that was applied, minus the resistive drop, without an EMF,
 *
 *     (T sum(u) - R n T (i_0 + i_n)/2)/L
 *
 * The difference from i_n - i_0 is the effect of the EMF. Only the noise of the first and the last sample
 * enters, for any length of the window (docs/theory.md, 27). */
#ifndef MATH_WINDING_H
#define MATH_WINDING_H

#include <stdbool.h>

#include "math/bounds.h"
#include "math/frames.h"
#include "math/root.h"

#define WINDING_SOUND                                                                                        \
    0.5f /* [-] of the least error of a sensor that is judged: largest sum of right currents */

/* Largest turn of a rotor in a window for which the mean of a vector that turns with it shows its direction
 * [rad]: the mean has 0.56 of its length there, and none at a whole turn. */
#define WINDING_TURN_MOST 3.5f

typedef struct {
    float per_volt;   /* T/L [A/V] */
    float per_ampere; /* R T/(2 L) [-], factor per period of the sum of the first and the last current of a
                         window */
} winding_t;

/* R [ohm], L [H] > 0, T [s]. It has a division and runs in the background. */
static inline winding_t winding_prepare(float resistance, float inductance, float period)
{
    const float per_volt = period / inductance;
    return (winding_t){per_volt, 0.5f * per_volt * resistance};
}

/* A limit of the link voltage [V] for this inductance [H], range of the current [A] and period [s]. Below it
 * the largest voltage, 2/3 u_dc, changes the current by less than 2 % of the range in a period. At the
 * voltage limit the current may then stay within one code of the ADC, or lag its reference by tens of
 * milliseconds. */
static inline float winding_slow_link(float inductance, float range, float period)
{
    return 0.02f * 1.5f * range * inductance / period;
}

/* The curve of a q axis that saturates: psi_q/(L_0 i_q) at this (i_q/I_s)^2 [-], 1/sqrt(1 + (i_q/I_s)^2). No
 * division (docs/theory.md, 30). */
static inline float winding_saturation(float square)
{
    return inverse_root(1.0f + square);
}

/* True if three measured currents add up to zero, compared with the least error of a sensor that is judged,
 * `error` [A]. Then no sensor is stuck, because a stuck value would make the sum different by its error. One
 * of the values may not change because a switch or a wire does not conduct. */
static inline bool winding_adds_up(const abc_t *current, float error)
{
    return bounds_within(current->a + current->b + current->c, WINDING_SOUND * error);
}

/* [A]; `voltage` is the sum [V] over `periods`, between these two currents [A]. */
static inline ab_t winding_given(const winding_t *winding, ab_t voltage, float periods, ab_t first, ab_t last)
{
    const float lost = winding->per_ampere * periods;
    return (ab_t){winding->per_volt * voltage.alpha - lost * (first.alpha + last.alpha),
                  winding->per_volt * voltage.beta - lost * (first.beta + last.beta)};
}

#endif
