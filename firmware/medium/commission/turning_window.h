/* EMF, current and torque of a window of the running drive, whose motor is commissioned.
 *
 * The current is taken in the frame of the EMF and not in that of the loop: with the lag of the loop in an
 * acceleration, i_d would count as torque.
 *
 *     T = 1.5 p (psi + (L_d - psi_q/i_q) i_d) (i_q - D |e|/L_q)
 *
 * D: the edges of the legs are late by this time, and so is the middle of the zero vector, in which the
 * current is equal to its mean. The sample is earlier, and in the zero vector the current changes by -|e|/L_q
 * per second.
 */
#ifndef MEDIUM_COMMISSION_TURNING_WINDOW_H
#define MEDIUM_COMMISSION_TURNING_WINDOW_H

#include "medium/commission/commission_types.h"

/* A window of the running drive. */
typedef struct {
    uint32_t runs; /* [-] 1: run on the estimate, which is judged as good */
    float theta_e; /* of the estimate [rad] */
    float omega_e; /* the same, mean of the window [rad/s] */
    dq_t emf;      /* summed over the window in the stationary frame, as a mean in the frame of its end [V] */
    dq_t current;  /* the same of the current [A] */
    float speed;   /* requested largest speed, mechanical [rad/s] */
    float least;   /* speed of the hand-over, mechanical [rad/s] */
} turning_input_t;

/* Length of the mean of n unit vectors, `turn` [rad] apart: sin(n turn/2)/(n sin(turn/2)), within 1e-3
 * for n turn up to 2.4. */
float turning_mean_length(float n, float turn);

/* Factor by which the mean of a turning vector over a window is too short, inverted. */
float turning_lengthening(const commission_tuning_t *tuning, const turning_input_t *input);

/* Length of the EMF [V]. */
float turning_emf(const turning_input_t *input);

/* Current in the frame of the EMF [A], of which q is the direction of the EMF. */
dq_t turning_current(const turning_input_t *input);

/* The same window with the EMF of a rotor whose q axis saturates. The observer assumes a constant L_q, so
 * that c = psi_q - L_q i_q adds -omega c along the magnet to its EMF; this part is removed. */
turning_input_t turning_straightened(const commission_tuning_t *tuning, const turning_input_t *input);

/* Torque [N m] at the flux linkage psi [Wb]. */
float turning_torque(const commission_tuning_t *tuning, const turning_input_t *input, float psi);

#endif
