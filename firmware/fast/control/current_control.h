/* Current control in a rotating frame (that of the rotor or another one): one PI controller per axis with
 * decoupling, one step per `period`.
 *
 *     u_d = kp_d (i_d_ref - i_d) + I_d - omega L_q x_q + e_d
 *     u_q = kp_q (i_q_ref - i_q) + I_q + omega L_d x_d + e_q
 *     kp = L bandwidth,   ki = R bandwidth
 *     omega T x = omega T i_ref - g (i_ref - i),   g = m omega T, at most 0.35
 *     ki of the q axis is larger if `held` demands it, but at most kp_q bandwidth/4
 *
 * Without `held`, the zero of the PI controller cancels the pole R/L of the winding. The feed-forward cancels
 * the cross-coupling and the EMF e that the caller supplies: (0, omega psi_f) in the frame of the rotor. What
 * remains is an integrator with the gain `bandwidth` and a delay of 1.5 periods (the voltage of period k acts
 * from t_k+1 to t_k+2). With K = bandwidth * period the closed loop is z^2 - z + K = 0 (docs/theory.md, 15):
 * it has no overshoot up to K = 0.25 and is unstable from K = 1. During the delay the frame turns, so that a
 * decoupling by the measured current alone (m = 1) turns the error of one axis into the other. With
 *
 *     m = z - K/2,   z: the real part of the slower root of z^2 - z + K = 0
 *
 * it does not, up to the second order of omega T. In a frame that turns faster, g stays at 0.35: more would
 * make the loop unstable if L is configured too large, and so an error of one axis moves the other one.
 *
 * The output voltage is not limited. After modulation the caller reports the voltage that was applied
 * (without the part that only compensates the dead time) with current_control_applied(), and the integrals
 * are back-calculated from this voltage. Because ki/kp = R/L, an integral at the voltage limit follows R i
 * just as the current does, and no wind-up remains afterwards.
 *
 * Does not handle: saturation of the iron, delay compensation of the rotation (the caller transforms the
 * voltage into the stationary frame at theta + 1.5 T omega), limits of the references. */
#ifndef FAST_CONTROL_CURRENT_CONTROL_H
#define FAST_CONTROL_CURRENT_CONTROL_H

#include "math/bounds.h"
#include "math/frames.h"
#include "math/pi.h"

/* [rad] largest g: at this limit and an L that is a third wrong no root exceeds 0.99 for K of 0.05 to 0.2, up
 * to a turn of 1.05 rad in a period. */
#define CURRENT_CONTROL_TURN 0.35f

typedef struct {
    float resistance;   /* R [ohm], >= 0 */
    float inductance_d; /* L_d [H], > 0 */
    float inductance_q; /* L_q [H], > 0 */
    float bandwidth; /* of the closed loop [rad/s], > 0; bandwidth * period is at most 0.25 for a loop without
                        overshoot */
    float period;    /* T [s] */
    float held;      /* least ki of the q axis, >= 0, against an EMF that changes faster than e [V/(A s)] */
} current_control_params_t;

typedef struct {
    dq_t reactance; /* L_d/T, L_q/T: the reactance per radian that the frame turns in a period [ohm] */
    float share;    /* m [-] */
    pi_tuning_t d;
    pi_tuning_t q;
} current_control_tuning_t;

typedef struct {
    dq_t reactance;   /* of the tuning, L_d/T and L_q/T [ohm] */
    float share;      /* of the tuning, m [-] */
    pi_t d;           /* output [V], error [A] */
    pi_t q;           /* output [V], error [A] */
    dq_t current_err; /* reference minus current in the last step [A] */
    dq_t voltage_ref; /* output of the last step [V] */
} current_control_t;

/* The integral gain of the q axis [V/(A s)]. */
float current_control_integral(const current_control_params_t *params);

/* Computes the coefficients. Two divisions. The bandwidth times the period is at most 0.5. */
current_control_tuning_t current_control_prepare(const current_control_params_t *params);

/* Sets these coefficients and clears the integrals. */
void current_control_init(current_control_t *control, const current_control_tuning_t *tuning);

/* Sets new coefficients; the integrals stay. */
static inline void current_control_take(current_control_t *control, const current_control_tuning_t *tuning)
{
    control->reactance = tuning->reactance;
    control->share = tuning->share;
    pi_take(&control->d, &tuning->d);
    pi_take(&control->q, &tuning->q);
}

/* Sets the integrals [V]: with currents equal to their references, the next voltage is `integral` plus the
 * feed-forward. */
void current_control_reset(current_control_t *control, dq_t integral);

/* Continues in another frame, which is rotated by `turn` from the present one. The integrals stay constant in
 * the stationary frame, so that the voltage has no step. Four multiplications. */
static inline void current_control_turn(current_control_t *control, rotation_t turn)
{
    dq_t integral = frames_park((ab_t){control->d.integral, control->q.integral}, turn);
    control->d.integral = integral.d;
    control->q.integral = integral.q;
}

/* The EMF of the feed-forward now has another origin and differs by this `change` [V]. The integrals change
 * by the opposite, so that the voltage has no step. */
static inline void current_control_shift(current_control_t *control, dq_t change)
{
    control->d.integral -= change.d;
    control->q.integral -= change.q;
}

/* Required voltage [V], not limited, from reference and current [A] at t_k, the angle by which the frame
 * turns in a period [rad] and EMF [V]. The integrals change only in current_control_applied(). Nine
 * multiplications. */
static inline dq_t current_control_step(current_control_t *control, dq_t reference, dq_t current, float turn,
                                        dq_t emf)
{
    const dq_t err = {reference.d - current.d, reference.q - current.q};
    const float g = bounds_clamp(control->share * turn, CURRENT_CONTROL_TURN);
    control->current_err = err;
    control->voltage_ref.d =
        pi_output(&control->d, err.d) - control->reactance.q * (turn * reference.q - g * err.q) + emf.d;
    control->voltage_ref.q =
        pi_output(&control->q, err.q) + control->reactance.d * (turn * reference.d - g * err.d) + emf.q;
    return control->voltage_ref;
}

/* Integrates with the voltage that was applied [V], in the same frame. The caller calls it once after every
 * step. Four multiplications. */
static inline void current_control_applied(current_control_t *control, dq_t applied)
{
    pi_update(&control->d, control->current_err.d, applied.d - control->voltage_ref.d);
    pi_update(&control->q, control->current_err.q, applied.q - control->voltage_ref.q);
}

#endif
