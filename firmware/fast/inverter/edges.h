/* The current of a leg at its two edges, from which the sign of its loss follows.
 *
 * The switches whose zero vector is sampled (here: the upper ones) are on at both ends of a period and off
 * around its middle: leg j, with duty d_j, falls at d_j T/2 and rises at T - d_j T/2, each time within the
 * dead time T_e around this instant. In the dead time both of its switches are off. The diodes drive a
 * current towards zero and then hold it there, so that the current after the dead time decides where the edge
 * is. With the edge in the middle this current would be
 *
 *     i_j - b_j - r_j f_j + A/6 sum over x of max(0, y_x - e)          first edge
 *     i_j - b_j + r_j f_j - A/6 sum over x of max(y_x, -e)             second edge
 *     f_j = (Di_j + A/3 sum over x of y_x)/2,   b_j = omega T/4 (j f)_j (1 - r_j^2),   r_j = 1 - d_j
 *     y_x = d_x - e sat(i_x/w) - d_j,   A = T u_dc/L,   e = T_e/T
 *
 * and the sign of the loss is sat() of this current over the zone w (medium/adapt/leg_zone.h). i_j is the
 * mean of the currents at both ends of the period, Di_j their difference, f_j the effect of EMF and
 * resistance in half a period, b_j that of an EMF which turns with the speed omega. The sums are the effect
 * of the other two legs x, whose edges are where their mean currents put them: a leg whose own sign is not
 * certain has others whose signs are, unless all currents are small. Where the lower switches are sampled, d
 * is their share, 1 - duty, and currents and voltages have the opposite sign. Derivation: docs/theory.md, 12.
 *
 * No state. Does not handle: two edges of a leg that lose different shares, of which each shifts the current
 * at the other one by up to T_e u_dc/(12 L); the effect of the signs on b_j. */
#ifndef FAST_INVERTER_EDGES_H
#define FAST_INVERTER_EDGES_H

#include <stdbool.h>

#include "math/bounds.h"
#include "math/frames.h"

typedef struct {
    float current_per_volt; /* T/(24 L) [A/V] */
    float whole;            /* twice the share for which the sampled switch of a leg of duty 0 is off [-] */
    float way;              /* 1, or -1 where the lower switches are sampled [-] */
    float turn;             /* T/(8 sqrt(3)) [s] */
} edges_tuning_t;

/* Of each leg, over the zone [-]; positive in the direction of the sampled switches. */
typedef struct {
    abc_t first, second;
} edges_t;

/* What the other two legs do to the current of one. */
typedef struct {
    float sum, first, second;
} edges_others_t;

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

/* `one`, `other`: y - e of both, `band`: 2 e, in the same unit. max(0, x) is half of x + |x|. */
static inline edges_others_t edges_others(float one, float other, float band)
{
    return (edges_others_t){
        one + other,
        bounds_magnitude(one) + bounds_magnitude(other),
        bounds_magnitude(one + band) + bounds_magnitude(other + band),
    };
}

/* The late end of the dead time of another leg with this current over the zone: its edge is in the middle of
 * a quarter, `band`, times 2 (1 + sign). The sign is half of |i + 1| - |i - 1|. */
static inline float edges_late(float own, float current, float quarter)
{
    return own + quarter * (bounds_magnitude(current + 1.0f) - bounds_magnitude(current - 1.0f) + 2.0f);
}

/* Currents over the zone at the edges. `per_zone`: 1/zone [1/A], `duty`: of the upper switches, as commanded
 * [-], `middle`: mean of the current in the period, `change`: its change [A], `effective`: e [-], `omega_e`:
 * speed at which the EMF turns [rad/s], `u_dc`: DC link [V]. No division. Duties are in the unit in which a
 * whole period is A/12 over the zone; `rest` is 2 r_j. */
static inline edges_t edges_currents(const edges_tuning_t *edges, float per_zone, abc_t duty, ab_t middle,
                                     ab_t change, float effective, float omega_e, float u_dc)
{
    const float way = edges->way * per_zone;
    const float quarter = 0.25f * way;
    const float ampere = edges->current_per_volt * per_zone * u_dc;
    const float whole = edges->whole;
    const float both = edges->way + edges->way;
    const float band = 4.0f * effective * ampere;
    const abc_t current = frames_inverse_clarke((ab_t){way * middle.alpha, way * middle.beta});
    const abc_t part = frames_inverse_clarke((ab_t){quarter * change.alpha, quarter * change.beta});
    const abc_t rest = {whole - both * duty.a, whole - both * duty.b, whole - both * duty.c};
    const abc_t own = {ampere * rest.a, ampere * rest.b, ampere * rest.c};
    const float part_band = 0.25f * band;
    const abc_t late = {edges_late(own.a, current.a, part_band), edges_late(own.b, current.b, part_band),
                        edges_late(own.c, current.c, part_band)};
    const edges_others_t a = edges_others(own.a - late.b, own.a - late.c, band);
    const edges_others_t b = edges_others(own.b - late.c, own.b - late.a, band);
    const edges_others_t c = edges_others(own.c - late.a, own.c - late.b, band);
    const abc_t half_f = {part.a + (band + a.sum), part.b + (band + b.sum), part.c + (band + c.sum)};
    const float turn = edges->turn * omega_e;
    const abc_t at = {current.a - turn * (half_f.c - half_f.b) * (4.0f - rest.a * rest.a),
                      current.b - turn * (half_f.a - half_f.c) * (4.0f - rest.b * rest.b),
                      current.c - turn * (half_f.b - half_f.a) * (4.0f - rest.c * rest.c)};
    const abc_t swing = {a.sum - rest.a * half_f.a, b.sum - rest.b * half_f.b, c.sum - rest.c * half_f.c};
    return (edges_t){
        {at.a + swing.a + a.first, at.b + swing.b + b.first, at.c + swing.c + c.first},
        {at.a - swing.a - a.second, at.b - swing.b - b.second, at.c - swing.c - c.second},
    };
}

#endif
