/* Sliding-mode observer in fixed point: the twin of estimator/smo.h, eqs. (5), (11), (12), in the formats of
 * formats.h. Same steps, same states, per unit.
 *
 * A sample beyond +-SAMPLE_LARGEST is no measurement and is passed over. The current error is cut to 8 I, the
 * k_f of the sign to 128/I, g to 90 U/I. No division. */
#ifndef ESTIMATOR_FIXED_SMO_Q_H
#define ESTIMATOR_FIXED_SMO_Q_H

#include <stdbool.h>
#include <stdint.h>

#include "estimator/fixed/formats.h"
#include "estimator/smo.h"
#include "math/filter_q.h"
#include "math/frames_q.h"
#include "math/tanh_q.h"

/* 90 U/I: with the largest R and what the hold adds it fits. */
#define CONDUCTANCE_LARGEST (INT32_C(90) * (INT32_C(1) << IMPEDANCE_Q))

/* Per unit, made from smo_params_t by fixed.c. */
typedef struct {
    int32_t resistance;     /* R, Q24, 0..25 */
    int32_t voltage_gain;   /* b, Q30, 0..2 */
    int32_t gain;           /* k_s, Q30, 1/2..1 */
    int32_t half_slope;     /* a_f/2, Q26, 0..32 */
    int32_t gain_slope;     /* k_s a_f/2, Q26, 0..32 */
    int32_t emf_decay;      /* exp(-omega_s T), Q31; 0 = no filter */
    int32_t mean_share;     /* 1 - exp(-SMO_GAIN_CUTOFF T), Q31 */
    int32_t loop_gain_unit; /* b k_s, Q30, 0..2 */
    int32_t current_loss;   /* b R = 1 - a, Q32, 0..1/2 */
    int32_t hold_lead;      /* lag.h, Q32 */
    int32_t hold_lead_rise; /* Q30 */
    int32_t hold_size;      /* Q30 */
    int32_t hold_cotangent; /* Q32 */
    int32_t lag_resistance; /* 2/b - R, Q24, 0..104 */
    int32_t inductance;     /* L/T, Q24, 0..50 */
    int32_t one_ohm;        /* Q24, for the paper's printed formula */
    int32_t ohms;           /* R as a number of ohms, Q24, likewise */
    int32_t gain_largest;   /* SMO_SIGN_GAIN_MAX as far as Q24 goes, and as a k_f of one axis Q20 */
    int32_t axis_gain_largest;
    int32_t filter_odd; /* 2 c/(1 - c), c = emf_decay, Q20, 0..1000 */
    uint32_t filtering; /* [-] 1: there is a filter */
    int32_t switching;  /* smo_switching_t */
} smo_params_q_t;

typedef struct {
    smo_params_q_t params;
    /* state */
    ab_q_t current_hat;       /* i_hat at t_k */
    ab_q_t current_err;       /* x at t_k */
    ab_q_t switched;          /* v, acts from t_k on; without filter emf_hat is it */
    ab_q_t emf_hat;           /* e_hat at t_k */
    ab_q_t gain_axis;         /* k_f of each axis, Q20 */
    lowpass_q_t mean_product; /* f x of both axes, Q26 */
    lowpass_q_t mean_square;  /* x x of both axes, Q26 */
    int32_t gain_mean;        /* k_f */
    int32_t conductance;      /* g = k_s k_f, 0..CONDUCTANCE_LARGEST */
    uint32_t passed_over;     /* [-] 1: the last sample was no measurement */
} smo_q_t;

/* As smo_init(), smo_retune(), smo_reset(), smo_preset(), smo_preset_error(), its error within ERROR_LARGEST,
 * and smo_step(). */
void smo_init_q(smo_q_t *smo, const smo_params_q_t *params);
void smo_retune_q(smo_q_t *smo, const smo_params_q_t *params);
void smo_reset_q(smo_q_t *smo, ab_q_t current, ab_q_t emf);
void smo_preset_q(smo_q_t *smo, ab_q_t current, ab_q_t switched, ab_q_t emf_hat);
void smo_preset_error_q(smo_q_t *smo, ab_q_t current, ab_q_t error);
ab_q_t smo_step_q(smo_q_t *smo, ab_q_t voltage, ab_q_t current);

/* A sample within the range. */
static inline bool smo_measured_q(int32_t sample)
{
    return sample >= -SAMPLE_LARGEST && sample <= SAMPLE_LARGEST;
}

/* i_hat(k) of one axis less the sample, not cut yet: i_hat + b (u - v) - b R i_hat - i. It fits: 24 I + 16 I,
 * and what a period adds with |u - v| <= 6 U, 22 I. */
static inline int32_t smo_error_q(const smo_q_t *smo, int32_t hat, int32_t driving, int32_t current)
{
    int64_t change = q_product(smo->params.voltage_gain, driving) - q_product(smo->params.current_loss, hat);
    return hat - current + (int32_t)q_round(change, 32);
}

/* An error within the range. */
static inline bool smo_small_q(int32_t error)
{
    return error >= -ERROR_LARGEST && error <= ERROR_LARGEST;
}

/* a_f/2 times a component of the error: Q26 times Q28 is Q54; odd, as halves are frequent in it. */
static inline int32_t smo_stretched_q(const smo_q_t *smo, int32_t x)
{
    return q_word(q_product(smo->params.half_slope, 8 * x));
}

/* A component of v = g x. */
static inline int32_t smo_switched_q(int32_t conductance, int32_t x)
{
    return q_cut(q_product(conductance, x), IMPEDANCE_Q + CURRENT_Q - VOLTAGE_Q, SWITCHED_BITS);
}

/* The step of the vector form without filter, inline for the interrupt, as smo_step_settled(); v is e_hat
 * then. The samples must be measurements. false: nothing has changed, take smo_step_q(). */
static inline bool smo_step_settled_q(smo_q_t *smo, ab_q_t voltage, ab_q_t current)
{
    ab_q_t hat = smo->current_hat;
    ab_q_t v = smo->emf_hat;
    ab_q_t x = {smo_error_q(smo, hat.alpha, voltage.alpha - v.alpha, current.alpha),
                smo_error_q(smo, hat.beta, voltage.beta - v.beta, current.beta)};
    if (!smo_small_q(x.alpha) || !smo_small_q(x.beta)) {
        return false;
    }
    int32_t y_alpha = smo_stretched_q(smo, x.alpha);
    int32_t y_beta = smo_stretched_q(smo, x.beta);
    int64_t square = q_product(y_alpha, y_alpha) + q_product(y_beta, y_beta);
    if (square >= TANH_Q_SHORT_END) {
        return false;
    }
    int32_t ratio = tanh_ratio_short_q(square);
    int32_t g = q_high(smo->params.gain_slope, ratio);
    smo->current_hat = (ab_q_t){current.alpha + x.alpha, current.beta + x.beta};
    smo->current_err = x;
    smo->gain_mean = q_high(smo->params.half_slope, ratio);
    smo->conductance = g;
    smo->emf_hat = (ab_q_t){smo_switched_q(g, x.alpha), smo_switched_q(g, x.beta)};
    return true;
}

/* k_f. */
int32_t smo_equivalent_gain_q(const smo_q_t *smo);

#endif
