/* Lag and attenuation of the observer in fixed point: the twin of estimator/lag.h, eqs. (13), (14). Angles
 * are binary, speeds are turns per period (Q31), both of formats.h.
 *
 * Beyond the formats: the vector that undoes the observer is cut to +-128 (Q24), the EMF to +-SAMPLE_LARGEST,
 * in lag_emf_exact_q() the speed to an eighth of a turn per period. The modes of the paper turn by a unit
 * vector and need no angle. */
#ifndef ESTIMATOR_FIXED_LAG_Q_H
#define ESTIMATOR_FIXED_LAG_Q_H

#include <stdint.h>

#include "estimator/fixed/smo_q.h"
#include "estimator/lag.h"

/* What to add to the angle of e_hat, modulo a turn. For resets. */
uint32_t lag_angle_q(const smo_q_t *smo, lag_mode_t mode, int32_t omega_e);

/* |e_hat|/|e|, Q24. */
int32_t lag_attenuation_q(const smo_q_t *smo, int32_t omega_e);

/* The EMF of t_k, lag and attenuation undone; no division. */
ab_q_t lag_emf_q(const smo_q_t *smo, lag_mode_t mode, int32_t omega_e);

/* EMF over current error with LAG_EXACT, for the gain g, Q24, 0..CONDUCTANCE_LARGEST: lag_impedance() of
 * lag.h. */
typedef struct {
    int32_t re, im; /* Q24 */
} lag_impedance_q_t;

static inline lag_impedance_q_t lag_impedance_q(const smo_q_t *smo, int32_t g, int32_t omega_e)
{
    /* h = omega T/2 in Q32; pi is in Q29. */
    int32_t limit = Q_ONE(SPEED_Q - 3);
    int32_t omega = omega_e >= -limit && omega_e < limit ? omega_e : (omega_e < 0 ? -limit : limit - 1);
    int32_t h = 2 * q_high_near(8 * omega, INT32_C(1686629713));
    int32_t along = g + smo->params.resistance;
    int32_t across = smo->params.lag_resistance - g;
    int64_t bend = q_product(smo->params.hold_cotangent, along) - q_product(smo->params.hold_lead, across);
    lag_impedance_q_t z;
    z.re = along - q_high(q_high(h, h), (int32_t)q_floor(bend, SMALL_Q));
    z.im = q_high_near(h, across - q_high(smo->params.hold_lead, z.re));
    return z;
}

/* lag_emf_q() with LAG_EXACT from the `error` v/g, inline for the interrupt: lag_emf_exact() of lag.h. */
static inline ab_q_t lag_emf_exact_q(const smo_q_t *smo, ab_q_t error, int32_t omega_e)
{
    lag_impedance_q_t z = lag_impedance_q(smo, smo->conductance, omega_e);
    return (ab_q_t){q_cut(q_product(z.re, error.alpha) - q_product(z.im, error.beta),
                          IMPEDANCE_Q + CURRENT_Q - VOLTAGE_Q, SAMPLE_BITS),
                    q_cut(q_product(z.re, error.beta) + q_product(z.im, error.alpha),
                          IMPEDANCE_Q + CURRENT_Q - VOLTAGE_Q, SAMPLE_BITS)};
}

/* The current error of the vector form that has settled on this EMF: lag_error() of lag.h, within
 * ERROR_LARGEST. */
ab_q_t lag_error_q(const smo_q_t *smo, int32_t omega_e, ab_q_t emf);

/* LAG_EXACT backwards, for resets. */
void lag_make_q(const smo_q_t *smo, int32_t omega_e, ab_q_t emf, ab_q_t *switched, ab_q_t *emf_hat);

#endif
