/* The paper's phase self-compensation, eq. (14) with the resistance of eq. (13): a continuous first-order lag
 * without hold and filter,
 *
 *     LAG_PRINTED    atan(omega_e L/(k_s k_f R + R))    to the letter: right for R = 1 ohm only
 *     LAG_CORRECTED  atan(omega_e L/(k_s k_f + R))      the slip mended, erratum 1
 *
 * To read the paper by; what the drive uses is LAG_EXACT of lag.h. */
#ifndef ESTIMATOR_PAPER_LAG_PAPER_H
#define ESTIMATOR_PAPER_LAG_PAPER_H

#include "estimator/lag.h"

/* What to add to the angle of e_hat [rad] at this electrical speed [rad/s], eq. (14); 0 with LAG_NONE. Two
 * divisions. */
float lag_paper_angle(const smo_t *smo, lag_mode_t mode, float omega_e);

/* lag_paper_emf(), declared in lag.h: e_hat [V] turned on by that angle and stretched by its true
 * attenuation. */

#endif
