/* Lag and attenuation of the back-EMF observer (smo.h), to be undone: phase self-compensation, paper eqs.
 * (13), (14), and beyond.
 *
 * An EMF e that turns with omega_e moves the winding's current, R + j omega_e L being its impedance, while
 * the switching voltage v stands still for a period. With current error x and both turning alike, z = e^(j
 * omega_e T), the error's difference equation z x = a x + (z - a) e/(R + j omega_e L) - b v gives
 *
 *     e = (R + j omega_e L) x + W v,     W = b (R + j omega_e L)/(z - a) = F(d + j omega_e T)/F(d),
 *                                        F(y) = y/(e^y - 1),  d = R T/L
 *
 * W is what holding v costs: with little resistance 1 - j x/2 - x^2/12 - x^4/720, x = omega_e T;
 * smo_prepare() makes the series for any d. As v = g x with g = k_s k_f of the moment, one impedance says
 * all:
 *
 *     e = Z x,     Z = R + j omega_e L + g W,     e_hat = v = g x lags by arg Z and is shorter by |Z|/g
 *
 *     LAG_NONE       0
 *     LAG_PRINTED    the paper's (14) with (13) to the letter: paper/lag_paper.h
 *     LAG_CORRECTED  (14) with (13) mended, erratum 1: arg Z with W = 1
 *     LAG_EXACT      Z, and the filter (11) where the observer has one, erratum 2
 *
 * The paper's two count half a period too much and leave +31 mrad at 1500 r/min of its motor.
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
 * at standstill g/(g + R). Within 1e-5 of its value. No division. */
float lag_attenuation(const smo_t *smo, float omega_e);

/* The EMF of t_k itself [V], lag and attenuation undone, from the observer's state. LAG_EXACT takes the
 * current error, before the filter: e = Z x; per axis, where x has harmonics that v has not, v/g stands for
 * x, with one division. Within 1e-5 rad and 1e-5 of its length up to LAG_TURN_LIMIT; beyond it finite. The
 * other modes take the filtered e_hat, turn it by lag_angle() and divide by lag_attenuation(). */
ab_t lag_emf(const smo_t *smo, lag_mode_t mode, float omega_e);

/* Z, or what else multiplies a vector [ohm]. */
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

/* What lag_emf() does for the paper's modes: paper/lag_paper.h. */
ab_t lag_paper_emf(const smo_t *smo, lag_mode_t mode, float omega_e);

/* e = Z x [V] of this current error x [A]. */
static inline ab_t lag_undone(const smo_t *smo, float omega_e, ab_t error)
{
    lag_impedance_t z = lag_impedance(&smo->tuning, omega_e, smo->tuning.gain * smo->gain_mean);
    return (ab_t){z.re * error.alpha - z.im * error.beta, z.re * error.beta + z.im * error.alpha};
}

/* The current error [A] of the vector form that has settled on the EMF `emf` [V] turning at omega_e [rad/s]:
 * lag_emf() backwards, for resets. Right within 1e-3 of the length and 2e-4 rad up to the largest EMF by the
 * rule, 0.57 k_s; one longer than 0.99 k_s is taken as that long. Seven divisions. */
ab_t lag_error(const smo_t *smo, float omega_e, ab_t emf);

/* The switching voltage v [V] of an observer that has settled on the EMF `emf` [V] turning at omega_e
 * [rad/s], given the k_f of the moment; and what the filter (11) makes of a v that turns so. For resets. */
ab_t lag_switched(const smo_t *smo, float omega_e, ab_t emf);
ab_t lag_filtered(const smo_t *smo, float omega_e, ab_t switched);

#endif
