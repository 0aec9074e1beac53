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
    float current_per_volt; /* T/(24 L) [A/V] */
    float
        whole;  /* twice the share of the period for which the sampled switch of a leg of duty 0 is off [-] */
    float way;  /* 1, or -1 where the lower switches are sampled [-] */
    float turn; /* T/(8 sqrt 3) [s] */
} edges_tuning_t;

/* Of each leg, in the unit of the call. */
typedef struct {
    abc_t first, second; /* current at its edges */
} edges_t;

/* Coefficients for the period T [s] and the inductance L [H], > 0. `upper`: the currents are sampled while
 * the upper switches are on, else the lower ones. One division. */
static inline edges_tuning_t edges_prepare(float period, float inductance, bool upper)
{
    return (edges_tuning_t){
        period / (24.0f * inductance),
        upper ? 2.0f : 0.0f,
        upper ? 1.0f : -1.0f,
        0.125f * FRAMES_ONE_OVER_SQRT_3 * period,
    };
}

/* What the other two legs do to the current of one. */
typedef struct {
    float pull, first, second;
} edges_others_t;

static inline edges_others_t edges_others(float one, float other, float band)
{
    const float sum = one + other;
    return (edges_others_t){
        sum,
        sum + (bounds_magnitude(one) + bounds_magnitude(other)),
        sum + (bounds_magnitude(one + band) + bounds_magnitude(other + band)),
    };
}

static inline edges_t edges_currents(const edges_tuning_t *edges, float unit, abc_t duty, ab_t middle,
                                     ab_t change, float effective, float omega_e, float u_dc)
{
    const float way = edges->way * unit;
    const float quarter = 0.25f * way;
    const float ampere = edges->current_per_volt * unit * u_dc;
    const float whole = edges->whole;
    const float both = edges->way + edges->way;
    const float band = 4.0f * effective * ampere;
    const abc_t current = frames_inverse_clarke((ab_t){way * middle.alpha, way * middle.beta});
    const abc_t part = frames_inverse_clarke((ab_t){quarter * change.alpha, quarter * change.beta});
    const abc_t rest = {whole - both * duty.a, whole - both * duty.b, whole - both * duty.c};
    const abc_t own = {ampere * rest.a, ampere * rest.b, ampere * rest.c};
    const abc_t later = {current.a > 0.0f ? own.a + band : own.a, current.b > 0.0f ? own.b + band : own.b,
                         current.c > 0.0f ? own.c + band : own.c};
    const edges_others_t a = edges_others(own.a - later.b, own.a - later.c, band);
    const edges_others_t b = edges_others(own.b - later.c, own.b - later.a, band);
    const edges_others_t c = edges_others(own.c - later.a, own.c - later.b, band);
    const abc_t f = {part.a + (band + a.pull), part.b + (band + b.pull), part.c + (band + c.pull)};
    const float turn = edges->turn * omega_e;
    const abc_t at = {current.a - turn * (f.c - f.b) * (4.0f - rest.a * rest.a),
                      current.b - turn * (f.a - f.c) * (4.0f - rest.b * rest.b),
                      current.c - turn * (f.b - f.a) * (4.0f - rest.c * rest.c)};
    const abc_t off = {rest.a * f.a, rest.b * f.b, rest.c * f.c};
    return (edges_t){
        {at.a - off.a + a.first, at.b - off.b + b.first, at.c - off.c + c.first},
        {at.a + off.a - a.second, at.b + off.b - b.second, at.c + off.c - c.second},
    };
}

#endif
