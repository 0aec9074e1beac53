/* Lag and attenuation of the back-EMF observer (smo.h) for their compensation: phase self-compensation, paper
 * eqs. (13), (14), and its exact form.
 *
 * An EMF e that rotates with omega_e acts on the winding with the impedance R + j omega_e L, while the
 * switching voltage v is constant for a period. With the current error x and both rotating alike, z = e^(j
 * omega_e T), the difference equation of the error, z x = a x + (z - a) e/(R + j omega_e L) - b v, gives
 *
 *     e = (R + j omega_e L) x + W v,     W = b (R + j omega_e L)/(z - a) = F(d + j omega_e T)/F(d),
 *                                        F(y) = y/(e^y - 1),  d = R T/L
 *
 * W is the effect of holding v: with a small resistance 1 - j x/2 - x^2/12 - x^4/720, x = omega_e T;
 * smo_prepare() computes the series for any d. As v = g x with the present g = k_s k_f, one impedance
 * contains all effects:
 *
 *     e = Z x,     Z = R + j omega_e L + g W,     e_hat = v = g x lags by arg Z and is shorter by |Z|/g
 *
 *     LAG_NONE       0
 *     LAG_PRINTED    the paper's (14) with (13) as printed: paper/lag_paper.h
 *     LAG_CORRECTED  (14) with (13) corrected, erratum 1: arg Z with W = 1
 *     LAG_EXACT      Z, and the filter (11) where the observer has one, erratum 2
 *
 * The two modes of the paper add half a period too much and leave +31 mrad at 1500 r/min of its motor.
 *
 * No state of its own, no sample time; exact for a constant speed and the vector form, whose k_f is the same
 * at every sample. Does not handle: |omega_e| T beyond LAG_TURN_LIMIT, acceleration. */
#ifndef ESTIMATOR_LAG_H
#define ESTIMATOR_LAG_H

#include "estimator/smo.h"

typedef enum { LAG_NONE, LAG_PRINTED, LAG_CORRECTED, LAG_EXACT } lag_mode_t;

/* Largest |omega_e| T that is evaluated [rad], less than six samples per turn; beyond it the result is that
 * of this limit. The errors below are those up to 0.63 rad, ten samples per turn; at the limit they are 2e-4.
 */
#define LAG_TURN_LIMIT 1.15f

/* Correction of the angle of e_hat [rad] at this electrical speed [rad/s]; not wrapped. Odd in the speed in
 * every bit, positive for forward. Within 1e-5 rad of the formula. Two divisions. */
float lag_angle(const smo_t *smo, lag_mode_t mode, float omega_e);

/* |e_hat|/|e| [-] of the sampled observer with its EMF filter at this electrical speed [rad/s]; even in it;
 * at standstill g/(g + R). Within 1e-5 of its value. No division. */
float lag_attenuation(const smo_t *smo, float omega_e);

/* The EMF at t_k [V] without lag and attenuation, from the observer's state. LAG_EXACT uses the current error
 * before the filter: e = Z x. Per axis, where x has harmonics that v does not have, v/g replaces x, with one
 * division. Within 1e-5 rad and 1e-5 of its length up to LAG_TURN_LIMIT; beyond it finite. The other modes
 * rotate the filtered e_hat by lag_angle() and divide it by lag_attenuation(). */
ab_t lag_emf(const smo_t *smo, lag_mode_t mode, float omega_e);

/* Z, or another factor of a vector [ohm]. */
typedef struct {
    float re, im;
} lag_impedance_t;

/* Z [ohm] at this speed [rad/s] and g [ohm]. */
static inline lag_impedance_t lag_impedance(const smo_tuning_t *tuning, float omega_e, float g)
{
    float x = omega_e * tuning->period;
    float square = x * x;
    float w_re = 1.0f - square * (tuning->hold[1] - square * tuning->hold[3]);
    float w_im = x * (tuning->hold[0] - square * tuning->hold[2]);
    return (lag_impedance_t){tuning->resistance + g * w_re, omega_e * tuning->inductance + g * w_im};
}

/* lag_emf() for the paper's modes: paper/lag_paper.h. */
ab_t lag_paper_emf(const smo_t *smo, lag_mode_t mode, float omega_e);

/* e = Z x [V] of this current error x [A]. */
static inline ab_t lag_undone(const smo_t *smo, float omega_e, ab_t error)
{
    lag_impedance_t z = lag_impedance(&smo->tuning, omega_e, smo->tuning.gain * smo->gain_mean);
    return (ab_t){z.re * error.alpha - z.im * error.beta, z.re * error.beta + z.im * error.alpha};
}

/* The current error [A] of a vector form that is settled on the EMF `emf` [V] rotating at omega_e [rad/s]:
 * the inverse of lag_emf(), for resets. Its error is within 1e-3 of the length and 2e-4 rad up to the largest
 * EMF by the rule, 0.57 k_s; a length above 0.99 k_s is limited to this. Seven divisions. */
ab_t lag_error(const smo_t *smo, float omega_e, ab_t emf);

/* The switching voltage v [V] of an observer that is settled on the EMF `emf` [V] rotating at omega_e
 * [rad/s], for the present k_f; and the output of the filter (11) for such a v. For resets. */
ab_t lag_switched(const smo_t *smo, float omega_e, ab_t emf);
ab_t lag_filtered(const smo_t *smo, float omega_e, ab_t switched);

#endif
