/* The forced frame: a current vector that turns at a given speed and takes the rotor along, from standstill
 * up to where the back-EMF can be tracked (I/f start). Nothing of the rotor's angle is known here.
 *
 *     current on the d axis of the frame; the rotor hangs on it like a pendulum,
 *         w_n = sqrt(p K_t I/J),   K_t = 1.5 p psi_f
 *     which nothing damps but this:   i_q = -k (I_d/I) HP(e_q),   e_q: back-EMF across the frame
 *
 * e_q is omega psi_f cos(gamma) with gamma the load angle, and the torque of i_q is K_t i_q cos(gamma): their
 * product is never positive, so that it takes energy out of every swing, at standstill too, where a frequency
 * that is corrected could do nothing. What turns along for good is no swing: a high-pass takes it off. The
 * back-EMF needs the observer alone, no tracking. Derivation, and what bounds k: docs/theory.md, 23.
 *
 * One step per T. Does not handle: whether the rotor follows (that is judged by the EMF's length,
 * medium/manoeuvre/manoeuvres.h); a load that needs more than the current gives. */
#ifndef FAST_REFERENCE_FORCED_H
#define FAST_REFERENCE_FORCED_H

#include "math/angle.h"
#include "math/bounds.h"
#include "math/filter.h"
#include "math/frames.h"
#include "math/root.h"
#include "math/trig.h"

/* Share of the observed EMF that is fed forward: the rest is left to the integrals, for the observer's lag
 * would else close a loop of its own [-]. */
#define FORCED_EMF_SHARE 0.8f

/* Of the high-pass [rad/s]: below every w_n that this can damp. */
#define FORCED_SWING_CUTOFF 6.0f

/* Of the end of a ramp [rad/s]. */
#define FORCED_EASE_CUTOFF 12.0f

typedef struct {
    float resistance;   /* R [ohm], >= 0 */
    float inductance;   /* L [H], > 0 */
    float flux_linkage; /* psi_f [Wb], > 0 */
    float pole_pairs;   /* p [-] */
    float inertia;      /* J [kg m^2], > 0 */
    float dead_voltage; /* what the dead time takes at most [V], >= 0 */
    float current;      /* I of a start [A], > 0 */
    float current_max;  /* longest current vector [A], >= I */
    float damping;      /* k [A/V]; 0: by the rule, forced_damping() */
    float period;       /* T [s] */
} forced_params_t;

typedef struct {
    float current;         /* I of a start [A] */
    float current_inverse; /* 1/I [1/A] */
    float square_max;      /* of the longest current vector [A^2] */
    float damping;         /* k [A/V] */
    float damping_share;   /* low-pass of the damping [-] */
    float swing_share;     /* high-pass of the EMF [-] */
    float period;          /* T [s] */
} forced_tuning_t;

typedef struct {
    frame_t frame;  /* at t_k */
    float current;  /* on its d axis, before the damping needs some of it [A] */
    float emf_mean; /* what of e_q turns along [V] */
    float swing;    /* what of it does not, low-passed [V] */
} forced_t;

/* w_n of the rotor on this current [rad/s]: sqrt(p K_t I/J). For the background. */
float forced_natural(const forced_params_t *params);

/* k by the rule [A/V]: half of critical damping at w_n, w_n J/(p K_t psi_f), but no more than the observer's
 * own errors allow, 0.5/(0.3 R + 0.25 V_dead/I): they come back as EMF of the very current that k makes. For
 * the background. */
float forced_damping(const forced_params_t *params);

/* Coefficients; the damping's low-pass is 2.5/(k L), for 20 % of L wrong looks like EMF too. Divisions and
 * exponentials: for the background. */
forced_tuning_t forced_prepare(const forced_params_t *params);

/* Frame at angle zero, standing, no current. */
void forced_init(forced_t *forced);

/* On from this frame at t_k with this current on its d axis [A]; no swing is known. */
void forced_enter(forced_t *forced, float theta_e, float omega_e, float current);

/* The frame to t_k: its speed of the last period for T. */
static inline void forced_advance(forced_t *forced, const forced_tuning_t *tuning)
{
    frame_t *frame = &forced->frame;
    frame->theta_e = angle_turn_back(frame->theta_e + tuning->period * frame->omega_e);
    frame->rotation = trig_turn(frame->theta_e);
}

/* A speed [rad/s] on its way to `target` by at most `step`, and at the end by this share of the rest: a ramp
 * that ends at once sets the rotor swinging. */
static inline float forced_eased(float speed, float target, float share, float step)
{
    return speed + bounds_clamp(share * (target - speed), step);
}

/* Current reference in the frame [A] from the EMF [V] in it: the damping first, the d axis what the longest
 * vector leaves. No division. */
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
