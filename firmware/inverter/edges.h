/* The current of a leg at its two edges.
 *
 * Upper switches are on at both ends of a period and off around its middle: leg j, of duty d_j, falls at
 * d_j T/2 and rises at T - d_j T/2. The voltage is even about the middle, so the current runs odd about it,
 * and the edges meet it at
 *
 *     i_j - a_j (falling),   i_j + a_j (rising),   i_j = (i_j(t_k-1) + i_j(t_k))/2
 *     a_j = (1 - d_j)/2 (Di_j - T/L u_j) - T u_dc/(6 L) (sum over x of max(0, d_x - d_j) - T_e/T)
 *
 * with the change Di of the current in this period, the voltage u on the winding, and duties as they act
 * behind the dead time, d - T_e/T sign(i). The first term is what EMF and resistance do while the leg is off,
 * the second the legs that are on longer, the third half of the own dead band, in which a leg without current
 * stands half way. Derivation: docs/theory.md, 12.
 *
 * No state. Does not handle: an EMF that turns within the period, salient inductance. */
#ifndef INVERTER_EDGES_H
#define INVERTER_EDGES_H

#include "math/frames.h"

typedef struct {
    float current_per_volt; /* T/L [A/V] */
} edges_tuning_t;

/* Coefficients for the period T [s] and the inductance L [H], > 0. One division. */
static inline edges_tuning_t edges_prepare(float period, float inductance)
{
    return (edges_tuning_t){period / inductance};
}

/* `value`, but not less than nothing. */
static inline float edges_more(float value)
{
    return value > 0.0f ? value : 0.0f;
}

/* Half of the current's way from the falling to the rising edge of each leg, a_j [A]. `duty` [-] as it acts,
 * `change` of the current in the period [A], `effective`: T_e/T [-], DC link `u_dc` [V]. No division, three
 * compares. */
static inline abc_t edges_swing(const edges_tuning_t *edges, abc_t duty, ab_t change, float effective,
                                float u_dc)
{
    const float ampere = edges->current_per_volt * u_dc;
    const ab_t on = frames_clarke(duty);
    const abc_t off = frames_inverse_clarke(
        (ab_t){0.5f * (change.alpha - ampere * on.alpha), 0.5f * (change.beta - ampere * on.beta)});
    const float sixth = ampere * (1.0f / 6.0f);
    const float ab = duty.a - duty.b;
    const float bc = duty.b - duty.c;
    const float ca = duty.c - duty.a;
    const float a_longer = edges_more(ab);
    const float b_longer = edges_more(bc);
    const float c_longer = edges_more(ca);
    return (abc_t){
        (1.0f - duty.a) * off.a - sixth * (c_longer + (a_longer - ab) - effective),
        (1.0f - duty.b) * off.b - sixth * (a_longer + (b_longer - bc) - effective),
        (1.0f - duty.c) * off.c - sixth * (b_longer + (c_longer - ca) - effective),
    };
}

#endif
