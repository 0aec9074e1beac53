/* Current control in a turning frame, the rotor's or another: one PI per axis, decoupled, one step per
 * `period`.
 *
 *     u_d = kp_d (i_d_ref - i_d) + I_d - omega L_q i_q + e_d
 *     u_q = kp_q (i_q_ref - i_q) + I_q + omega L_d i_d + e_q
 *     kp = L bandwidth,   ki = R bandwidth
 *
 * The PI's zero cancels the winding's pole R/L, the feed-forward its cross-coupling and the EMF e that the
 * caller knows of: (0, omega psi_f) in the rotor's frame. What remains is an integrator with the gain
 * `bandwidth` behind the delay of 1.5 periods (the voltage of period k acts from t_k+1 to t_k+2). With K =
 * bandwidth * period the loop is z^2 - z + K = 0 (docs/theory.md, 15): no overshoot up to K = 0.25, unstable
 * from K = 1.
 *
 * The voltage that comes out is the wanted one and may be too long. After modulation
 * current_control_applied() says what was really applied (without what only compensates dead time), and the
 * integrals are back-calculated from that. As ki/kp = R/L, an integral at the limit follows R i just as the
 * current does: there is nothing to unwind afterwards.
 *
 * Does not handle: saturation of the iron, delay compensation of the rotation (the caller turns the voltage
 * into the stationary frame at theta + 1.5 T omega), limits of the references. */
#ifndef FAST_CONTROL_CURRENT_CONTROL_H
#define FAST_CONTROL_CURRENT_CONTROL_H

#include "math/frames.h"
#include "math/pi.h"

typedef struct {
    float resistance;   /* R [ohm], >= 0 */
    float inductance_d; /* L_d [H], > 0 */
    float inductance_q; /* L_q [H], > 0 */
    float bandwidth;    /* of the closed loop [rad/s], > 0; times period at most 0.25 for a loop without
                           overshoot */
    float period;       /* T [s] */
} current_control_params_t;

typedef struct {
    float inductance_d; /* L_d [H] */
    float inductance_q; /* L_q [H] */
    pi_tuning_t d;
    pi_tuning_t q;
} current_control_tuning_t;

typedef struct {
    float inductance_d; /* of the tuning, L_d [H] */
    float inductance_q; /* likewise, L_q [H] */
    pi_t d;             /* output [V], error [A] */
    pi_t q;             /* output [V], error [A] */
    dq_t current_err;   /* reference - current of the last step [A] */
    dq_t voltage_ref;   /* what the last step wanted [V] */
} current_control_t;

/* Coefficients. Two divisions. */
current_control_tuning_t current_control_prepare(const current_control_params_t *params);

/* These coefficients; integrals 0. */
void current_control_init(current_control_t *control, const current_control_tuning_t *tuning);

/* New coefficients; integrals stay. */
static inline void current_control_take(current_control_t *control, const current_control_tuning_t *tuning)
{
    control->inductance_d = tuning->inductance_d;
    control->inductance_q = tuning->inductance_q;
    pi_take(&control->d, &tuning->d);
    pi_take(&control->q, &tuning->q);
}

/* Integrals [V]: with the currents on their references the next voltage is `integral` plus the feed-forward.
 */
void current_control_reset(current_control_t *control, dq_t integral);

/* On in another frame, which is turned by `turn` from the present one: the integrals stay where they are in
 * the stationary frame, so that the voltage does not jump. Four multiplications. */
static inline void current_control_turn(current_control_t *control, rotation_t turn)
{
    dq_t integral = frames_park((ab_t){control->d.integral, control->q.integral}, turn);
    control->d.integral = integral.d;
    control->q.integral = integral.q;
}

/* Wanted voltage [V] from reference and current [A] at t_k, electrical speed of the frame [rad/s] and EMF
 * [V]; not limited. The integrals wait for current_control_applied(). Six multiplications. */
static inline dq_t current_control_step(current_control_t *control, dq_t reference, dq_t current,
                                        float omega_e, dq_t emf)
{
    control->current_err.d = reference.d - current.d;
    control->current_err.q = reference.q - current.q;
    control->voltage_ref.d =
        pi_output(&control->d, control->current_err.d) - omega_e * control->inductance_q * current.q + emf.d;
    control->voltage_ref.q =
        pi_output(&control->q, control->current_err.q) + omega_e * control->inductance_d * current.d + emf.q;
    return control->voltage_ref;
}

/* What became of it [V], in the same frame. Once after every step; integrates. Four multiplications. */
static inline void current_control_applied(current_control_t *control, dq_t applied)
{
    pi_update(&control->d, control->current_err.d, applied.d - control->voltage_ref.d);
    pi_update(&control->q, control->current_err.q, applied.q - control->voltage_ref.q);
}

#endif
