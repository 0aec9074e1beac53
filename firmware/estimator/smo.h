/* Sliding-mode observer of the back-EMF: paper eqs. (5), (11), (12).
 *
 * The winding's current is predicted from the applied voltage and a switching voltage v that drives the
 * current error x to zero; v then is the EMF, seen through a first-order lag (lag.h). Exact for voltage and v
 * held over the period T:
 *
 *     i_hat(k) = a i_hat(k-1) + b (u(k-1) - v(k-1))         a = exp(-R T/L),  b = (1 - a)/R      (5)
 *     x(k)     = i_hat(k) - i(k)
 *     v(k)     = k_s f(x)
 *     e_hat(k) = v(k) + exp(-omega_s T) (e_hat(k-1) - v(k))                                      (11)
 *
 *     SMO_SIGN            f = sign(x)             per axis    k_f = 1/|x|, capped                (12)
 *     SMO_SIGMOID         f = tanh(a_f x/2)       per axis    k_f = f/x, a_f/2 at zero           (12)
 *     SMO_SIGMOID_VECTOR  f = tanh(a_f |x|/2) x/|x|           k_f = |f|/|x|: one gain, one lag, no harmonics
 *
 * Around a given k_f the error obeys x(k+1) = p x(k) + b e with p = a - b k_s k_f: stable for |p| < 1. With
 * the per-axis sigmoid the gain that describes both axes is the power-weighted one,
 *
 *     k_f = <v x>/(k_s <x x>)          both means low-passed at SMO_GAIN_CUTOFF
 *
 * Sample time: one step per T. The step of period k takes the current sampled at t_k and the voltage that
 * acted on [t_k-1, t_k); one period off is an angle error of omega T. The result belongs to t_k and still has
 * the lag.
 *
 * A sample that makes the error longer than SMO_ERROR_LIMIT, or a non-finite one, is passed over: state and
 * result stay. Does not handle: salient rotors (L_d != L_q), changes of R and L while running. */
#ifndef ESTIMATOR_SMO_H
#define ESTIMATOR_SMO_H

#include <stdbool.h>
#include <stdint.h>

#include "contract/refusal.h"
#include "math/frames.h"
#include "math/tanh.h"

/* Cap of the sign's equivalent gain [1/A]: an error below 1 mA is less than any sensor resolves. */
#define SMO_SIGN_GAIN_MAX 1000.0f

/* Corner of the low-pass of the power-weighted gain [rad/s]. */
#define SMO_GAIN_CUTOFF 100.0f

/* A current error as long as this is no measurement [A]. */
#define SMO_ERROR_LIMIT 1e6f

/* Largest small-signal loop gain b k_s a_f/2 [-] that smo_params_check accepts. The loop is stable up to 1 +
 * a, about 2; from 1.2 on it rings so much that the noise of the angle grows (k_s = 300 V for the paper's
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
    /* coefficients, from smo_init */
    float resistance;             /* R [ohm] */
    float inductance;             /* L [H] */
    float period;                 /* T [s] */
    float voltage_gain;           /* b = (1 - a)/R [A/V] */
    float gain;                   /* k_s [V] */
    float half_slope;             /* a_f/2 [1/A] */
    float settled_square;         /* |x|^2 up to which tanh(a_f |x|/2)/|x| is the quotient of these [A^2]: */
    float settled_p0, settled_p1; /* P0 h^-3 [A^3] and P1/h [A], tanh.h, h = a_f/2 */
    float settled_q0, settled_q1; /* P0 h^-4 [A^4] and Q1 h^-2 [A^2] */
    float emf_decay;              /* exp(-omega_s T) [-]; 0 = no filter */
    float mean_share;             /* 1 - exp(-SMO_GAIN_CUTOFF T) [-] */
    float half_period;            /* T/2 [s] */
    float loop_gain_unit;         /* b k_s [A]; b g = this times k_f */
    float current_loss;           /* b R = 1 - a [-] */
    float hold_lead;      /* what the held voltage adds to half a period of lead, over omega T/2 [-], lag.h */
    float hold_lead_rise; /* its growth over (omega T/2)^2 [-] */
    float hold_size;      /* of the vector's length over (omega T/2)^2 [-], lag.h */
    float hold_cotangent; /* 1/3 of h cot h, and what the hold adds [-], lag.h */
    float lag_resistance; /* 2/b - R [ohm], lag.h */
    float filter_even;    /* 1 + 2 c/(1 - c), c = emf_decay [-], lag.h */
    float filter_odd;     /* 2 c/(1 - c) [-] */
    uint32_t filtering;   /* [-] 1: there is a filter */
    int32_t switching;    /* smo_switching_t */
    /* state */
    ab_t current_hat;     /* i_hat at t_k [A] */
    ab_t current_err;     /* x at t_k [A] */
    ab_t switched;        /* v [V], acts from t_k on; without filter emf_hat is it */
    ab_t emf_hat;         /* e_hat at t_k [V] */
    ab_t gain_axis;       /* k_f of each axis at t_k [1/A]; the vector form leaves it alone */
    float mean_product;   /* low-passed f x, both axes [A] */
    float mean_square;    /* low-passed x x, both axes [A^2] */
    float gain_mean;      /* k_f: power-weighted; vector form: of the sample [1/A] */
    uint32_t passed_over; /* [-] 1: the last sample was no measurement */
} smo_t;

/* Whether the set can run: ranges, T <= L/(2 R), and for the sigmoids the loop gain b k_s a_f/2 <=
 * SMO_LOOP_GAIN_MAX (field "gain", with the largest k_s for this slope as limit). That k_s is larger than the
 * largest EMF is a rule of the estimator, which knows it. false: the first violated rule in `why`. */
bool smo_params_check(const smo_params_t *params, params_error_t *why);

/* Coefficients, and a start on zero current and zero EMF. The set must have passed smo_params_check. */
void smo_init(smo_t *smo, const smo_params_t *params);

/* Coefficients alone; the state goes on. A new switching function shows in the gains from the next step on.
 * Two divisions. */
void smo_retune(smo_t *smo, const smo_params_t *params);

/* As if settled on this `current` [A] at t_k and this `emf` [V], which is the estimate to continue
 * (attenuated and late, as smo_step gives it; multiply a true EMF by lag_attenuation and turn it back by
 * lag_angle). With the voltage that holds both, u = R i_hat + emf, the next steps return `emf` again. An emf
 * of 99 % of k_s and more (a length in the vector form, a component else) gives the switching voltage that
 * the error of 99 %, stretched likewise, makes. Both must be finite. 22 divisions per axis or vector; not for
 * every period. */
void smo_reset(smo_t *smo, ab_t current, ab_t emf);

/* The same where v and its filtered value differ because both turn: `switched` is the v to continue,
 * `emf_hat` the result of the filter [V]. */
void smo_preset(smo_t *smo, ab_t current, ab_t switched, ab_t emf_hat);

/* The same where the current error x [A] to continue is known and nothing filters v, which is e_hat then. */
void smo_preset_error(smo_t *smo, ab_t current, ab_t error);

/* e_hat [V] at t_k from the voltage [V] that acted on [t_k-1, t_k) and the current [A] at t_k. Finite for
 * every input. Divisions: one for the vector form, three for the others (each axis and the mean
 * gain). */
ab_t smo_step(smo_t *smo, ab_t voltage, ab_t current);

/* k_f [1/A] of the vector form for an error whose square is at most settled_square. */
static inline float smo_settled_gain(const smo_t *smo, float square)
{
    return (smo->settled_p0 + square * smo->settled_p1) /
           (smo->settled_q0 + square * (smo->settled_q1 + square));
}

/* Likewise for any error. One division. */
float smo_vector_gain(const smo_t *smo, float square);

/* The step of the vector form without filter, inline for the interrupt; v is e_hat then. false: nothing has
 * changed, take smo_step(). So it is for an error beyond the first piece of tanh, which a settled observer
 * has only close to its gain; a sample that is none is there too, whatever the slope. */
static inline bool smo_step_settled(smo_t *smo, ab_t voltage, ab_t current)
{
    ab_t hat = smo->current_hat;
    ab_t v = smo->emf_hat;

    /* a i + b (u - v), written so that u = R i + v leaves i as it is whatever b was rounded to. */
    hat.alpha += smo->voltage_gain * (voltage.alpha - v.alpha - smo->resistance * hat.alpha);
    hat.beta += smo->voltage_gain * (voltage.beta - v.beta - smo->resistance * hat.beta);
    ab_t x = {hat.alpha - current.alpha, hat.beta - current.beta};
    float square = x.alpha * x.alpha + x.beta * x.beta;
    if (!(square <= smo->settled_square)) {
        return false;
    }
    smo->current_hat = hat;
    smo->current_err = x;
    smo->gain_mean = smo_settled_gain(smo, square);
    float g = smo->gain * smo->gain_mean;
    smo->emf_hat = (ab_t){g * x.alpha, g * x.beta};
    return true;
}

/* |x|^2 [A^2] of the last step. */
static inline float smo_error_square(const smo_t *smo)
{
    ab_t x = smo->current_err;
    return x.alpha * x.alpha + x.beta * x.beta;
}

/* k_f [1/A]: power-weighted, vector form of the sample; a_f/2 (sign: the cap) while there was no error. */
float smo_equivalent_gain(const smo_t *smo);

#endif
