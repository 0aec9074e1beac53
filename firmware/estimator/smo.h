/* Sliding-mode observer of the back-EMF: paper eqs. (5), (11), (12).
 *
 * The current of the winding is predicted from the applied voltage and a switching voltage v that drives the
 * current error x to zero; v then is the EMF with a first-order lag (lag.h). Exact for voltage and v held
 * over the period T:
 *
 *     i_hat(k) = a i_hat(k-1) + b (u(k-1) - v(k-1))         a = exp(-R T/L),  b = (1 - a)/R      (5)
 *     x(k)     = i_hat(k) - i(k)
 *     v(k)     = k_s f(x)
 *     e_hat(k) = v(k) + exp(-omega_s T) (e_hat(k-1) - v(k))                                      (11)
 *
 *     SMO_SIGMOID_VECTOR  f = tanh(a_f |x|/2) x/|x|           k_f = |f|/|x|: one gain, one lag, no harmonics
 *     SMO_SIGMOID         f = tanh(a_f x/2)       per axis    the paper's, with their k_f (12):
 *     SMO_SIGN            f = sign(x)             per axis    paper/switching.h
 *
 * With a given k_f the error follows x(k+1) = p x(k) + b e with p = a - b k_s k_f: stable for |p| < 1.
 *
 * Sample time: one step per T. The step of period k takes the current sampled at t_k and the voltage that
 * acted on [t_k-1, t_k); a shift by one period is an angle error of omega T. The result belongs to t_k and
 * still has the lag.
 *
 * A sample that makes the error longer than SMO_ERROR_LIMIT, or a non-finite one, is rejected: state and
 * result stay. Does not handle: salient rotors (L_d != L_q), changes of R and L while running. */
#ifndef ESTIMATOR_SMO_H
#define ESTIMATOR_SMO_H

#include <stdbool.h>
#include <stdint.h>

#include "contract/refusal.h"
#include "estimator/paper/switching.h"
#include "math/frames.h"
#include "math/tanh.h"

/* A sample with a current error of this length is invalid [A]. */
#define SMO_ERROR_LIMIT 1e6f

/* Largest small-signal loop gain b k_s a_f/2 [-] that smo_params_check accepts. The loop is stable up to 1 +
 * a, about 2; above 1.2 it rings so much that the noise of the angle grows (k_s = 300 V for the paper's
 * motor). */
#define SMO_LOOP_GAIN_MAX 1.2f

typedef enum { SMO_SIGN, SMO_SIGMOID, SMO_SIGMOID_VECTOR } smo_switching_t;

typedef struct {
    float resistance; /* R [ohm], 1e-3..100 */
    float inductance; /* L [H], 1e-6..1 */
    float gain;       /* k_s [V], 0.1..1e4; rule: 1.75 times the largest EMF */
    float slope;      /* a_f [1/A], 1e-3..1e3: f(x) = tanh(a_f x/2); the paper's is 1; rule: 1.6 L/(k_s T) */
    float emf_cutoff; /* omega_s [rad/s], 0..1e5; 0 = no filter */
    float period;     /* T [s], 1e-6..1e-2, at most half of L/R */
    smo_switching_t switching; /* f */
} smo_params_t;

typedef struct {
    float resistance;   /* R [ohm] */
    float inductance;   /* L [H] */
    float period;       /* T [s] */
    float voltage_gain; /* b = (1 - a)/R [A/V] */
    float gain;         /* k_s [V] */
    float half_slope;   /* a_f/2 [1/A] */
    float emf_decay;    /* exp(-omega_s T) [-]; 0 = no filter */
    float hold[4];      /* W of a held voltage, series in j omega T from the first power on [-], lag.h */
    int32_t switching;  /* smo_switching_t */
    switching_tuning_t axes;
} smo_tuning_t;

typedef struct {
    smo_tuning_t tuning;
    /* state */
    ab_t current_hat; /* i_hat at t_k [A] */
    ab_t current_err; /* x at t_k [A] */
    ab_t switched;    /* v [V], acts from t_k on */
    ab_t emf_hat;     /* e_hat at t_k [V] */
    float gain_mean;  /* k_f [1/A]; vector form: that of the sample; per axis: a mean, weighted by power */
    switching_t axes; /* of the forms per axis; not used by the vector form */
} smo_t;

/* Checks a set: ranges; T <= L/(2 R); for the sigmoids, loop gain b k_s a_f/2 <= SMO_LOOP_GAIN_MAX. This last
 * rule names the field "gain", with the largest k_s for this slope as limit. The estimator, which knows the
 * largest EMF, checks that k_s is larger. true: the set is valid. false: `why` has the first violated
 * rule. */
bool smo_params_check(const smo_params_t *params, params_error_t *why);

/* Computes the coefficients of a set that has passed smo_params_check. It has divisions and exponentials and
 * runs in the background. */
void smo_prepare(smo_tuning_t *tuning, const smo_params_t *params);

/* Sets the coefficients; the state is kept. A new switching function changes the gains from the next step
 * on. */
static inline void smo_take(smo_t *smo, const smo_tuning_t *tuning)
{
    smo->tuning = *tuning;
}

/* Sets the coefficients and starts with zero current and zero EMF. The set must have passed
 * smo_params_check. */
void smo_init(smo_t *smo, const smo_params_t *params);

/* Sets the steady state for this `current` [A] at t_k and this `emf` [V]. `emf` is an estimate like the
 * result of smo_step, attenuated and with lag. A true EMF has to be multiplied by lag_attenuation and rotated
 * back by lag_angle. With the voltage that holds both, u = R i_hat
 * + emf, the next steps return `emf` again. For an emf of 99 % of k_s and more (a length in the vector form,
 * else a component), the switching voltage is that of the error at 99 %, extended by the same ratio. Both
 * arguments must be finite. 22 divisions per axis or vector; not for every period. */
void smo_reset(smo_t *smo, ab_t current, ab_t emf);

/* Sets the steady state for this current [A] and this current error x [A]. The caller supplies `emf_hat` [V],
 * the output of the filter for v. */
void smo_reset_error(smo_t *smo, ab_t current, ab_t error);

/* e_hat [V] at t_k from the voltage [V] that acted on [t_k-1, t_k) and the current [A] at t_k. The result is
 * finite for every input. Divisions: one for the vector form, three for the others (each axis and the mean
 * gain). */
ab_t smo_step(smo_t *smo, ab_t voltage, ab_t current);

/* k_f [1/A] of the vector form for an error with this square [A^2]. One division. */
static inline float smo_vector_gain(const smo_tuning_t *tuning, float square)
{
    float h = tuning->half_slope;
    return h * tanh_ratio(h * h * square);
}

/* Returns v [V] of the vector form and sets its k_f [1/A], for the error in the state; `square` [A^2] is that
 * of the error. */
static inline ab_t smo_switch_vector(smo_t *smo, float square)
{
    smo->gain_mean = smo_vector_gain(&smo->tuning, square);
    const float g = smo->tuning.gain * smo->gain_mean;
    const ab_t v = {g * smo->current_err.alpha, g * smo->current_err.beta};
    smo->switched = v;
    return v;
}

/* The first half of smo_step(), (5): i_hat and x, and |x|^2 [A^2] to `error_square`. false: the sample was
 * rejected. */
static inline bool smo_predict(smo_t *smo, ab_t voltage, ab_t current, float *error_square)
{
    const smo_tuning_t *tuning = &smo->tuning;
    ab_t hat = smo->current_hat;
    ab_t v = smo->switched;

    /* eq. (5): a i + b (u - v), in a form in which u = R i + v leaves i unchanged for any rounding of b. */
    hat.alpha += tuning->voltage_gain * (voltage.alpha - v.alpha - tuning->resistance * hat.alpha);
    hat.beta += tuning->voltage_gain * (voltage.beta - v.beta - tuning->resistance * hat.beta);
    ab_t x = {hat.alpha - current.alpha, hat.beta - current.beta};
    float square = x.alpha * x.alpha + x.beta * x.beta;
    *error_square = square;
    if (!(square <= SMO_ERROR_LIMIT * SMO_ERROR_LIMIT)) {
        return false;
    }
    smo->current_hat = hat;
    smo->current_err = x;
    return true;
}

/* The second half, with any switching function and the filter (11). */
void smo_answer(smo_t *smo, float error_square);

/* |x|^2 [A^2] of the last step. */
static inline float smo_error_square(const smo_t *smo)
{
    ab_t x = smo->current_err;
    return x.alpha * x.alpha + x.beta * x.beta;
}

/* k_f [1/A]: power-weighted; for the vector form that of the sample; a_f/2 (sign: the limit) without an error
 * so far. */
float smo_equivalent_gain(const smo_t *smo);

#endif
