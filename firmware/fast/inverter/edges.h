/* The signs of the loss of each leg at its two edges, from the current in its dead times.
 *
 * The switches whose zero vector is sampled (here: the upper ones) are on at both ends of a period and off
 * around its middle: leg j, with duty d_j, falls at d_j T/2 and rises at T - d_j T/2. In the dead time T_e
 * around each instant both of its switches are off, and the diodes drive its current towards zero. With the
 * sign s of the loss at an edge, the effective duty is d - e s there. With the means of three legs subtracted
 * from these duties, u' at the first and u" at the second edge, the current in the dead time is
 *
 *     i' = i_j - b_j - r_j f_j - A/4 u"_j - A/6 e + A/24 sum over x of (|y_x| + |y_x - 2 q|)
 *     i" = i_j - b_j + r_j f_j + A/4 u'_j + A/6 e - A/24 sum over x of (|y_x| + |y_x + 2 q|)
 *     f_j = (Di_j - A/2 (u'_j + u"_j))/2,   b_j = 3/16 omega T (j f)_j - 2 t/T f_j
 *     y_x = d_x - e (s'_x + s"_x)/2 - d_j,   A = T u_dc/L,   e = T_e/T,   r_j = 1 - d_j,   s = sat(i/w)
 *
 * with the mean i_j of the currents at both ends of the period, their difference Di_j, and the other two legs
 * x. f_j is the change by EMF and resistance in half a period. b_j is the effect of an EMF that turns with
 * the speed omega, and of the time t by which dead time and delays move all edges but not the samples. s' and
 * s" on the right are those of the last period. Their difference is that of a current which stays in the
 * zone: it is multiplied by 1 - |Di|^2/w^2, 0 at least. The change of the current by another leg that
 * switches in the dead time counts the less the later it occurs: half of it between the middle of the dead
 * time and 2 q, q = e z/(3 w), z = A e/3 (w: medium/adapt/leg_zone.h). Where the lower switches are sampled,
 * d is their share, 1 - duty, and currents and voltages have the opposite sign. Derivation:
 * docs/theory.md, 12.
 *
 * The state are the signs, which the caller keeps. Does not handle: b_j for other duties than 1/2, where the
 * parabola of the EMF has 1 - r_j^2 instead of 3/4. */
#ifndef FAST_INVERTER_EDGES_H
#define FAST_INVERTER_EDGES_H

#include <stdbool.h>

#include "math/bounds.h"
#include "math/frames.h"

typedef struct {
    float current_per_volt; /* T/(12 L) [A/V] */
    float whole;            /* share for which the sampled switch of a leg of duty 0 is off [-] */
    float way;              /* 1, or -1 where the lower switches are sampled [-] */
    float lag;              /* 2 t/T [-] */
    float turn;             /* 3/16 T [s] */
} edges_tuning_t;

/* Four times the signs at both edges of each leg, -4 to 4. The direction of the sampled switches is
 * positive. */
typedef struct {
    abc_t first;
    abc_t second;
} edges_t;

/* Coefficients for the period T [s], the inductance L [H], > 0, and the time t [s] by which all edges are
 * late. `upper`: the currents are sampled while the upper switches are on, else the lower ones. Two
 * divisions. */
static inline edges_tuning_t edges_prepare(float period, float inductance, float late, bool upper)
{
    return (edges_tuning_t){
        period / (12.0f * inductance), upper ? 1.0f : 0.0f, upper ? 1.0f : -1.0f,
        2.0f * late / period,          0.1875f * period,
    };
}

/* Four times the sign of a current over half the zone, which begins at -`below` and ends at 4 - `below`. */
static inline float edges_sign(float current, float below)
{
    return bounds_magnitude(current + below) - bounds_magnitude(current - (4.0f - below));
}

/* Sum of the amounts of two instants, and of both less `later`. */
static inline float edges_apart(float one, float other, float later)
{
    return bounds_magnitude(one) + bounds_magnitude(other) +
           (bounds_magnitude(one - later) + bounds_magnitude(other - later));
}

/* The signs of this period from those of the `last` one. `per_zone`: 1/w [1/A], `duty`: of the upper
 * switches, as commanded [-], `middle`: mean of the current in the period, `change`: its change [A],
 * `effective`: e [-], `omega_e`: speed at which the EMF turns [rad/s], `u_dc`: DC link [V]. No division.
 * Currents are over w/2, and duties are in the unit in which a whole period is A/12 over w, so that z/w is 4
 * `band`. */
static inline edges_t edges_signs(const edges_tuning_t *edges, const edges_t *last, float per_zone,
                                  abc_t duty, ab_t middle, ab_t change, float effective, float omega_e,
                                  float u_dc)
{
    const float way = edges->way;
    const float half_scale = way * per_zone;
    const float scale = 2.0f * half_scale;
    const ab_t moved = {half_scale * change.alpha, half_scale * change.beta};
    const float left = 1.0f - (moved.alpha * moved.alpha + moved.beta * moved.beta);
    const float stays = 0.5f * (left + bounds_magnitude(left));
    const float ampere = edges->current_per_volt * per_zone * u_dc;
    const float band = effective * ampere;
    const float later = 8.0f / 3.0f * band * band; /* 2 q */
    const float whole = edges->whole;
    const abc_t rest = {whole - way * duty.a, whole - way * duty.b, whole - way * duty.c};
    const abc_t own = {ampere * rest.a, ampere * rest.b, ampere * rest.c};
    const float eighth = 0.125f * band;
    const float apart = eighth * stays;
    const abc_t mean = {own.a + eighth * (last->first.a + last->second.a),
                        own.b + eighth * (last->first.b + last->second.b),
                        own.c + eighth * (last->first.c + last->second.c)};
    const abc_t half = {apart * (last->first.a - last->second.a), apart * (last->first.b - last->second.b),
                        apart * (last->first.c - last->second.c)};
    const abc_t fall = {mean.a + half.a, mean.b + half.b, mean.c + half.c};
    const abc_t rise = {mean.a - half.a, mean.b - half.b, mean.c - half.c};
    const float means = 4.0f * (mean.a + mean.b + mean.c);
    const float halves = 2.0f * (half.a + half.b + half.c);
    const ab_t drift = {moved.alpha + (12.0f * mean.a - means),
                        moved.beta + 4.0f * FRAMES_SQRT_3 * (mean.b - mean.c)};
    const float lag = edges->lag;
    const float turn = edges->turn * omega_e;
    const abc_t at =
        frames_inverse_clarke((ab_t){scale * middle.alpha + lag * drift.alpha + turn * drift.beta,
                                     scale * middle.beta + lag * drift.beta - turn * drift.alpha});
    const abc_t f = frames_inverse_clarke(drift);
    const abc_t swing = {rest.a * f.a, rest.b * f.b, rest.c * f.c};
    const float both = 2.0f + halves;
    const float shift = 4.0f * band + 0.5f * means; /* A/6 e, and the mean of the three legs */
    const float early = both - shift;
    const float late = both + shift;
    const abc_t ahead = {own.a - mean.b, own.b - mean.c, own.c - mean.a}; /* y */
    const abc_t behind = {own.a - mean.c, own.b - mean.a, own.c - mean.b};
    return (edges_t){
        {edges_sign(at.a - swing.a + 6.0f * rise.a + edges_apart(ahead.a, behind.a, later), early),
         edges_sign(at.b - swing.b + 6.0f * rise.b + edges_apart(ahead.b, behind.b, later), early),
         edges_sign(at.c - swing.c + 6.0f * rise.c + edges_apart(ahead.c, behind.c, later), early)},
        {edges_sign(at.a + swing.a - 6.0f * fall.a - edges_apart(ahead.a, behind.a, -later), late),
         edges_sign(at.b + swing.b - 6.0f * fall.b - edges_apart(ahead.b, behind.b, -later), late),
         edges_sign(at.c + swing.c - 6.0f * fall.c - edges_apart(ahead.c, behind.c, -later), late)},
    };
}

#endif
