/* The current of a leg at its two edges.
 *
 * The switches whose zero vector is sampled (here: the upper ones) are on at both ends of a period and off
 * around its middle: leg j, with duty d_j, falls at d_j T/2 and rises at T - d_j T/2. The voltage of the legs
 * is an even function about the middle, so its current is an odd one, and the currents at the edges are
 *
 *     i_j - b_j - a_j (falling),   i_j - b_j + a_j (rising),   i_j = (i_j(t_k-1) + i_j(t_k))/2
 *     f = (Di - T/L u)/2
 *     a_j = (1 - d_j) f_j - T u_dc/(6 L) (sum over x of max(0, d_x - d_j) - T_e/T)
 *     b_j = omega T/4 (j f)_j (1 - (1 - d_j)^2)
 *
 * with the change Di of the current in this period, the voltage u on the winding, and duties that act after
 * the dead time, d - T_e/T sign(i). f is the effect of EMF and resistance in half a period, the first term of
 * a_j that while the leg is off. The second is the effect of the legs that are on longer. T_e accounts for
 * the dead time of the leg itself, in which a leg without current has half of the link voltage. b_j is the
 * effect of an EMF that turns with the speed omega: the current of f is a parabola. It is small, but at a
 * turn of 0.3 rad in a period it changes the signs of both edges where i_j is almost zero. Where the lower
 * switches are sampled, d is their share, 1 - duty, and currents and voltages have the opposite sign.
 * Derivation: docs/theory.md, 12.
 *
 * No state. */
#ifndef FAST_INVERTER_EDGES_H
#define FAST_INVERTER_EDGES_H

#include <stdbool.h>

#include "math/bounds.h"
#include "math/frames.h"

typedef struct {
    float current_per_volt; /* T/L [A/V] */
    float whole;   /* share of the period for which the sampled switch of a leg of duty 0 is off [-] */
    float way;     /* 1, or -1 where the lower switches are sampled [-] */
    float quarter; /* `way` times T/4 [s] */
} edges_tuning_t;

/* Of each leg [A]. */
typedef struct {
    abc_t bend;  /* b_j, mean of the currents at the ends of the period minus that at the edges */
    abc_t swing; /* +-a_j, half of the change from one edge to the other */
} edges_t;

/* Coefficients for the period T [s] and the inductance L [H], > 0. `upper`: the currents are sampled while
 * the upper switches are on, else the lower ones. One division. */
static inline edges_tuning_t edges_prepare(float period, float inductance, bool upper)
{
    const float way = upper ? 1.0f : -1.0f;
    return (edges_tuning_t){period / inductance, upper ? 1.0f : 0.0f, way, way * 0.25f * period};
}

/* Currents at the edges of each leg. `duty` of the upper switches that acts [-], `change` of the current in
 * the period [A], `effective`: T_e/T [-], speed `omega_e` at which the EMF turns [rad/s], DC link `u_dc` [V].
 * No division. The sum of the differences max(0, x) is half of that of |x| + x. */
static inline edges_t edges_currents(const edges_tuning_t *edges, abc_t duty, ab_t change, float effective,
                                     float omega_e, float u_dc)
{
    const float way = edges->way;
    const ab_t made = frames_clarke(duty); /* a share that all legs have makes no voltage */
    const float ampere = edges->current_per_volt * u_dc;
    const float half_way = 0.5f * way;
    const ab_t half = {half_way * (change.alpha - ampere * made.alpha),
                       half_way * (change.beta - ampere * made.beta)};
    const float turn = edges->quarter * omega_e;
    const abc_t off = frames_inverse_clarke(half);
    const abc_t bent = frames_inverse_clarke((ab_t){-turn * half.beta, turn * half.alpha});
    const float whole = edges->whole;
    const abc_t rest = {whole - way * duty.a, whole - way * duty.b, whole - way * duty.c};
    const float ab = bounds_magnitude(rest.b - rest.a);
    const float bc = bounds_magnitude(rest.c - rest.b);
    const float ca = bounds_magnitude(rest.a - rest.c);
    const float quarter = 0.25f * ampere;
    const float twelfth = ampere * (1.0f / 12.0f);
    const float common = rest.a + rest.b + rest.c + 2.0f * effective;
    return (edges_t){
        {bent.a * (1.0f - rest.a * rest.a), bent.b * (1.0f - rest.b * rest.b),
         bent.c * (1.0f - rest.c * rest.c)},
        {rest.a * (off.a - quarter) - twelfth * (ab + ca - common),
         rest.b * (off.b - quarter) - twelfth * (ab + bc - common),
         rest.c * (off.c - quarter) - twelfth * (bc + ca - common)},
    };
}

#endif
