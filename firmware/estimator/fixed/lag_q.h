/* Lag and attenuation of the observer in fixed point: the counterpart of estimator/lag.h, eqs. (13), (14).
 * Angles are binary, speeds are turns per period (Q31), both of formats.h.
 *
 * Limits beyond the formats: the compensation vector of the observer is limited to +-128 (Q24), the EMF to
 * +-SAMPLE_LARGEST, in lag_emf_q() the speed to an eighth of a turn per period. The modes of the paper rotate
 * by a unit vector and need no angle. */
#ifndef ESTIMATOR_FIXED_LAG_Q_H
#define ESTIMATOR_FIXED_LAG_Q_H

#include <stdint.h>

#include "estimator/fixed/smo_q.h"
#include "estimator/lag.h"

/* Largest |omega_e| T that is evaluated [rad], as LAG_TURN_LIMIT of the version in float. */
#define LAG_TURN_LIMIT_FIXED 0.63f

/* Correction of the angle of e_hat, modulo a turn. For resets. */
uint32_t lag_angle_q(const smo_q_t *smo, lag_mode_t mode, int32_t omega_e);

/* |e_hat|/|e|, Q24. */
int32_t lag_attenuation_q(const smo_q_t *smo, int32_t omega_e);

/* The EMF at t_k without lag and attenuation; no division. */
ab_q_t lag_emf_q(const smo_q_t *smo, lag_mode_t mode, int32_t omega_e);

/* The current error of a vector form that is settled on this EMF: lag_error() of lag.h, within
 * ERROR_LARGEST. */
ab_q_t lag_error_q(const smo_q_t *smo, int32_t omega_e, ab_q_t emf);

/* The same as lag_switched() and lag_filtered(). For resets. */
ab_q_t lag_switched_q(const smo_q_t *smo, int32_t omega_e, ab_q_t emf);
ab_q_t lag_filtered_q(const smo_q_t *smo, int32_t omega_e, ab_q_t switched);

#endif
