/* Lag and attenuation of the back-EMF observer (smo.h), to be undone: phase self-compensation, paper eqs.
 * (13), (14), and beyond. x = omega_e T, d = R T/L, g = k_s k_f [ohm] with the k_f of the moment.
 *
 *     LAG_NONE       0
 *     LAG_PRINTED    atan(omega_e L/(g R + R))      (14) with (13) to the letter: right for R = 1 ohm only
 *     LAG_CORRECTED  atan(omega_e L/(g + R))        (14) with (13) mended, erratum 1
 *     LAG_EXACT      the sampled observer with its EMF filter, erratum 2:
 *
 *         atan2(sin x, cos x - p) - x/2 - x d/12 + atan2(c sin x, 1 - c cos x),
 *         p = a - b g,  c = exp(-omega_s T)
 *
 * The first two modes are the continuous observer without its filter, as in the paper; they count half a
 * period too much and leave +31 mrad at 1500 r/min of the paper's motor. In LAG_EXACT both arc tangents are
 * one, of the product of the two vectors. The terms in x and d come from the EMF that turns while the voltage
 * is held: its mean over a period is (z - a) lambda/((1 - a)(lambda + j omega)) of its value, z = e^jx,
 * lambda = R/L, whose phase is x/2 + x d/12 - x d (d^2 - x^2)/720 (the formula above with one more term of
 * its series) and whose length is a series in x^2 too.
 *
 * The interrupt takes lag_emf().
 *
 * No state of its own, no sample time; exact for a constant speed and the vector form, whose k_f is the same
 * at every sample. Does not handle: |omega_e| T beyond LAG_TURN_LIMIT, acceleration. */
#ifndef ESTIMATOR_LAG_H
#define ESTIMATOR_LAG_H

#include "estimator/smo.h"

typedef enum { LAG_NONE, LAG_PRINTED, LAG_CORRECTED, LAG_EXACT } lag_mode_t;

/* Largest |omega_e| T that is answered [rad], about ten samples a turn; beyond it as at it. */
#define LAG_TURN_LIMIT 0.63f

/* What to add to the angle of e_hat [rad] at this electrical speed [rad/s]; not wrapped. Odd in the speed bit
 * for bit, positive for forward. Within 1e-5 rad of the formula. Two divisions. */
float lag_angle(const smo_t *smo, lag_mode_t mode, float omega_e);

/* |e_hat|/|e| [-] of the sampled observer with its EMF filter at this electrical speed [rad/s]; even in it;
 * at standstill g/(g + R). Within 3e-5 of its value for R T/L <= 0.3, 1e-4 else. One division. */
float lag_attenuation(const smo_t *smo, float omega_e);

/* The EMF of t_k itself [V], lag and attenuation undone, from the observer's state.
 *
 * LAG_EXACT takes the switching voltage before its filter. As v = g x, what has to be undone is linear in g,
 * and neither k_f nor an angle nor a root has to be computed. With h = x/2 and the hold's h/sin h in the
 * length:
 *
 *     e = ((g + R) h cot h + j (2/b - R - g) h) e^(-j lead) (current error),   h cot h = 1 - h^2/3
 *                                                                              lead = h d/6
 *
 * Within 1.2e-5 rad and 1e-4 of its length up to |omega_e| T = 0.3 and R T/L = 0.3, 1e-3 each up to
 * LAG_TURN_LIMIT; beyond it finite. The vector form: straight line, no division. Per axis, with the
 * power-weighted k_f: one division. The other modes take the filtered e_hat, turn it by lag_angle() and
 * divide by lag_attenuation(): three divisions, a sine, a cosine and an arc tangent. */
ab_t lag_emf(const smo_t *smo, lag_mode_t mode, float omega_e);

/* EMF over current error with LAG_EXACT, for the gain g [ohm]. The length of the hold shrinks with (h d)^2/45
 * too; half of that in one component leaves a little of it to the length and a little to the angle. */
typedef struct {
    float re, im; /* [ohm] */
} lag_impedance_t;

static inline lag_impedance_t lag_impedance(const smo_t *smo, float g, float omega_e)
{
    float h = omega_e * smo->half_period;
    float along = g + smo->resistance;
    float across = smo->lag_resistance - g;
    lag_impedance_t z;
    z.re = along - h * h * (smo->hold_cotangent * along - smo->hold_lead * across);
    z.im = h * (across - smo->hold_lead * z.re);
    return z;
}

/* lag_emf() with LAG_EXACT from the `error` [A] v/g, inline for the interrupt: the vector form has it as its
 * current error. */
static inline ab_t lag_emf_exact(const smo_t *smo, ab_t error, float omega_e)
{
    lag_impedance_t z = lag_impedance(smo, smo->gain * smo->gain_mean, omega_e);
    return (ab_t){z.re * error.alpha - z.im * error.beta, z.re * error.beta + z.im * error.alpha};
}

/* The current error [A] of the vector form that has settled on the EMF `emf` [V] turning at omega_e [rad/s]:
 * lag_emf_exact() backwards, for resets. An EMF longer than 0.99 k_s is taken as that long. Nine
 * divisions. */
ab_t lag_error(const smo_t *smo, float omega_e, ab_t emf);

/* What the switching voltage v and its filtered value e_hat [V] are when the observer has settled on the EMF
 * `emf` [V] that turns at omega_e [rad/s], given the k_f of the moment. LAG_EXACT backwards: for resets. */
void lag_make(const smo_t *smo, float omega_e, ab_t emf, ab_t *switched, ab_t *emf_hat);

#endif
