/* The forced frame: a current vector that rotates at a given speed and takes the rotor along, from standstill
 * up to the speed where the back-EMF can be tracked (I/f start). The angle of the rotor is unknown here.
 *
 *     current on the d axis of the frame; the rotor swings about it like a pendulum,
 *         w_n = sqrt(p K_t I/J),   K_t = 1.5 p psi_f
 *     which only this law damps:   i_q = -k (I_d/I) HP(e_q),   e_q: back-EMF across the frame
 *
 * e_q is omega psi_f cos(gamma) with gamma the load angle, and the torque of i_q is K_t i_q cos(gamma). Their
 * product is never positive, so that it takes energy out of every swing, also at standstill, where a
 * correction of the frequency has no effect. A constant e_q belongs to the steady rotation, and the high-pass
 * removes it. The back-EMF needs only the observer, without tracking. The derivation and the limits of k are
 * in docs/theory.md, 23.
 *
 * One step per T. Does not handle: whether the rotor follows (medium/manoeuvre/manoeuvres.h judges that by
 * the length of the EMF); a load that needs more torque than the current makes. */
#ifndef FAST_REFERENCE_FORCED_H
#define FAST_REFERENCE_FORCED_H

#include "math/angle.h"
#include "math/bounds.h"
#include "math/filter.h"
#include "math/frames.h"
#include "math/root.h"
#include "math/trig.h"

/* Share of the observed EMF in the feed-forward [-]. The integrals supply the rest, because the lag of the
 * observer would otherwise close a loop of its own. In a salient
 * rotor the observed EMF contains D di/dt if the current moves relative to the axes of the rotor. The
 * feed-forward returns this part with the gain D/L_d. If the q axis saturates, the current of a rotor that is
 * not aligned changes with the incremental inductance L_i, which may be below the inductance L_o of the
 * observer. The feed-forward returns a part L_o/L_i - 1 of its own voltage. Where the larger of the two gains
 * is above 1, the share is this value divided by the gain. */
#define FORCED_EMF_SHARE 0.8f

/* Cutoff of the high-pass [rad/s]: below every w_n that this law can damp. */
#define FORCED_SWING_CUTOFF 6.0f

/* Cutoff of the end of a ramp [rad/s]. */
#define FORCED_EASE_CUTOFF 12.0f

typedef struct {
    float resistance;       /* R [ohm], >= 0 */
    float inductance;       /* L [H], > 0 */
    float saliency;         /* D = L_q - L_d [H], below `inductance`; 0: a round rotor */
    float inductance_least; /* L_i [H], > 0: least incremental inductance in any direction, at current_max */
    float flux_linkage;     /* psi_f [Wb], > 0 */
    float pole_pairs;       /* p [-] */
    float inertia;          /* J [kg m^2], > 0 */
    float dead_voltage;     /* largest voltage of the dead time [V], >= 0 */
    float current;          /* I of a start [A], > 0 */
    float current_max;      /* longest current vector [A], >= I */
    float damping;          /* k [A/V]; 0: computed by forced_damping() */
    float period;           /* T [s] */
} forced_params_t;

typedef struct {
    float current;         /* I of a start [A] */
    float current_inverse; /* 1/I [1/A] */
    float square_max;      /* of the longest current vector [A^2] */
    float damping;         /* k [A/V] */
    float damping_share;   /* low-pass of the damping [-] */
    float swing_share;     /* high-pass of the EMF [-] */
    float emf_share;       /* of the observed EMF in the feed-forward [-] */
    float period;          /* T [s] */
} forced_tuning_t;

typedef struct {
    frame_t frame;  /* at t_k */
    float current;  /* on its d axis, before the limit by the damping's current [A] */
    float emf_mean; /* constant part of e_q [V] */
    float swing;    /* the rest of e_q, low-passed [V] */
} forced_t;

/* w_n of the rotor on this current [rad/s]: sqrt(p K_t I/J). It runs in the background. */
float forced_natural(const forced_params_t *params);

/* k by the rule [A/V]: half of critical damping at w_n, w_n J/(p K_t psi_f), limited by the errors of the
 * observer to 0.5/(0.3 R + 0.25 V_dead/I), because they act as an EMF of the current that k makes. It runs in
 * the background. */
float forced_damping(const forced_params_t *params);

/* Share of the observed EMF in the feed-forward [-]. It runs in the background. */
float forced_emf_share(const forced_params_t *params);

/* Computes the coefficients. The low-pass of the damping is 2.5/(k L), because an error of L by 20 % also
 * acts as an EMF. It has divisions and exponentials and runs in the background. */
forced_tuning_t forced_prepare(const forced_params_t *params);

/* Frame at angle zero and speed zero, without current. */
void forced_init(forced_t *forced);

/* Continues from this frame at t_k with this current on its d axis [A] and without a swing. */
void forced_enter(forced_t *forced, float theta_e, float omega_e, float current);

/* Advances the frame to t_k: by T at the speed of the last period. */
static inline void forced_advance(forced_t *forced, const forced_tuning_t *tuning)
{
    frame_t *frame = &forced->frame;
    frame->theta_e = angle_turn_back(frame->theta_e + tuning->period * frame->omega_e);
    frame->rotation = trig_turn(frame->theta_e);
}

/* Moves a speed [rad/s] to `target` by at most `step`, and by this share of the rest near the end, because an
 * abrupt end of a ramp makes the rotor swing. */
static inline float forced_eased(float speed, float target, float share, float step)
{
    return speed + bounds_clamp(share * (target - speed), step);
}

/* Current reference in the frame [A] from the EMF [V] in it. The damping has priority, and the d axis has the
 * rest of the longest vector. No division. */
static inline dq_t forced_step(forced_t *forced, const forced_tuning_t *tuning, dq_t emf)
{
    forced->emf_mean = lowpass_step(forced->emf_mean, tuning->swing_share, emf.q);
    forced->swing = lowpass_step(forced->swing, tuning->damping_share, emf.q - forced->emf_mean);
    const float gain = tuning->damping * forced->current * tuning->current_inverse;
    const float across = bounds_clamp(-gain * forced->swing, tuning->current);
    const float room = tuning->square_max - across * across;
    const float along = room > 0.0f ? room * inverse_root(room) : 0.0f;
    return (dq_t){forced->current < along ? forced->current : along, across};
}

#endif
