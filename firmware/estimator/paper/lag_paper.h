/* The paper's phase self-compensation, eq. (14) with the resistance of eq. (13): a continuous first-order lag
 * without hold and filter,
 *
 *     LAG_PRINTED    atan(omega_e L/(k_s k_f R + R))    as printed: correct for R = 1 ohm only
 *     LAG_CORRECTED  atan(omega_e L/(k_s k_f + R))      with the correction, erratum 1
 *
 * It is for the reproduction of the paper; the drive uses LAG_EXACT of lag.h. */
#ifndef ESTIMATOR_PAPER_LAG_PAPER_H
#define ESTIMATOR_PAPER_LAG_PAPER_H

#include "estimator/lag.h"

/* Correction of the angle of e_hat [rad] at this electrical speed [rad/s], eq. (14); 0 with LAG_NONE. Two
 * divisions. */
float lag_paper_angle(const smo_t *smo, lag_mode_t mode, float omega_e);

/* lag_paper_emf(), declared in lag.h: e_hat [V] rotated by that angle and divided by its exact
 * attenuation. */

#endif
