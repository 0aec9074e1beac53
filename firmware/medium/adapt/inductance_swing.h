/* What a cycle of the dither shows of a round rotor's L, without the rotor's own swing (inductance.h). */
#ifndef MEDIUM_ADAPT_INDUCTANCE_SWING_H
#define MEDIUM_ADAPT_INDUCTANCE_SWING_H

#include "medium/adapt/inductance.h"

#define INDUCTANCE_HALF_TURN 3.14159265f /* [rad] of the wave, whose t advances by 1 */
#define INDUCTANCE_SWING     0.02f       /* [-] of omega L: least EMF of a swing that is eliminated */
#define INDUCTANCE_SHAKEN    0.05f /* [-] of omega L: EMF of a swing from which the dither drives the shaft */

/* This frequency of the dither [rad/s] if the rotor is round and turns so fast that its swing is eliminated;
 * else 0. */
static inline float inductance_eliminated(const inductance_t *x, float omega, uint32_t which)
{
    const float wave = INDUCTANCE_HALF_TURN * x->tuning.wave[which].step / x->tuning.time;
    const bool fast = bounds_magnitude(omega) >= INDUCTANCE_APART * wave;
    return fast && x->tuning.ratio != 0.0f ? wave : 0.0f;
}

/* A voltage per ampere of i_d, from its sums with s and c: the component in step with i_d in this cycle
 * [ohm]. The low-pass that is subtracted, and the current control, shift i_d against the wave. */
static inline float inductance_per_ampere(const inductance_sums_t *sum, float with_s, float with_c)
{
    const float power = with_s * sum->answer + with_c * sum->answer_c;
    const float square = sum->answer * sum->answer + sum->answer_c * sum->answer_c;
    return power / square;
}

/* True if this EMF of the rotor's swing per ampere [ohm] exceeds this share of the voltage of L. */
static inline bool inductance_exceeds(const inductance_t *x, float p, float share)
{
    return !bounds_within(p, share * bounds_magnitude(x->omega) * x->tuning.inductance_q);
}

/* L_d,true - L_q,assumed of a round rotor [H]. The EMF of the rotor's own swing is p per ampere of i_d, in
 * step with it. With dL it makes e_q = omega dL + p in step with i_d, and e_d = W dL + omega/W p a quarter of
 * a cycle ahead. p vanishes from the difference. A p below INDUCTANCE_SWING is noise and counts as zero. The
 * same applies where omega is not INDUCTANCE_APART of W, because the difference is too small there. */
static inline float inductance_beside(const inductance_t *x, float omega)
{
    const float in_step = inductance_per_ampere(&x->sum, x->sum.emf, x->sum.emf_c);
    const float ahead = inductance_per_ampere(&x->sum, x->sum.drop_c, -x->sum.drop);
    const float w = inductance_eliminated(x, omega, x->which);
    const float beyond = (omega * in_step - w * ahead) / (omega * omega - w * w);
    return inductance_exceeds(x, in_step - omega * beyond, INDUCTANCE_SWING) ? beyond : in_step / omega;
}

/* True if the rotor swings with the dither by so much that its EMF p exceeds INDUCTANCE_SHAKEN, and the next
 * frequency eliminates the swing as well; `beyond` is dL of this cycle [H]. */
static inline bool inductance_is_shaken(const inductance_t *x, float omega, float beyond)
{
    if (x->which + 1u >= INDUCTANCE_FREQUENCIES || inductance_eliminated(x, omega, x->which + 1u) == 0.0f) {
        return false;
    }
    return inductance_exceeds(x, inductance_per_ampere(&x->sum, x->sum.emf, x->sum.emf_c) - omega * beyond,
                              INDUCTANCE_SHAKEN);
}

#endif
