/* Sliding-mode observer in fixed point: the counterpart of estimator/smo.h, eqs. (5), (11), (12), in the
 * formats of formats.h. Steps and states are the same, per unit.
 *
 * A sample beyond +-SAMPLE_LARGEST is invalid and is rejected. The current error is limited to 8 I, the k_f
 * of the sign to 128/I, g to 90 U/I. No division. */
#ifndef ESTIMATOR_FIXED_SMO_Q_H
#define ESTIMATOR_FIXED_SMO_Q_H

#include <stdbool.h>
#include <stdint.h>

#include "estimator/fixed/formats.h"
#include "estimator/smo.h"
#include "math/filter_q.h"
#include "math/frames_q.h"
#include "math/tanh_q.h"

/* 90 U/I: the sum with the largest R and the terms of the hold fits the format. */
#define CONDUCTANCE_LARGEST (INT32_C(90) * (INT32_C(1) << IMPEDANCE_Q))

/* Per unit, computed from smo_params_t by fixed.c. */
typedef struct {
    int32_t resistance;   /* R, Q24, 0..25 */
    int32_t voltage_gain; /* b, Q30, 0..2 */
    int32_t gain;         /* k_s, Q30, 1/2..1 */
    int32_t half_slope;   /* a_f/2, Q26, 0..32 */
    int32_t gain_slope;   /* k_s a_f/2, Q26, 0..32 */
    int32_t emf_decay;    /* exp(-omega_s T), Q31; 0 = no filter */
    int32_t mean_share;   /* 1 - exp(-SMO_GAIN_CUTOFF T), Q31 */
    int32_t current_loss; /* b R = 1 - a, Q32, 0..1/2 */
    int32_t hold[4];      /* lag.h, Q30, within +-0.6 */
    int32_t inductance;   /* L/T, Q24, 0..50 */
    int32_t one_ohm;      /* 1 ohm, Q24, for the paper's printed formula */
    int32_t ohms;         /* R as a number of ohms, Q24, for the same formula */
    int32_t gain_largest; /* SMO_SIGN_GAIN_MAX limited by the range of Q24, and as a k_f of one axis Q20 */
    int32_t axis_gain_largest;
    int32_t filter_odd; /* 2 c/(1 - c), c = emf_decay, Q20, 0..1000 */
    int32_t switching;  /* smo_switching_t */
} smo_tuning_q_t;

typedef struct {
    smo_tuning_q_t tuning;
    /* state */
    ab_q_t current_hat;       /* i_hat at t_k */
    ab_q_t current_err;       /* x at t_k */
    ab_q_t switched;          /* v, acts from t_k on */
    ab_q_t emf_hat;           /* e_hat at t_k */
    ab_q_t gain_axis;         /* k_f of each axis, Q20 */
    lowpass_q_t mean_product; /* f x of both axes, Q26 */
    lowpass_q_t mean_square;  /* x x of both axes, Q26 */
    int32_t gain_mean;        /* k_f */
    int32_t conductance;      /* g = k_s k_f, 0..CONDUCTANCE_LARGEST */
    uint32_t rejected;        /* [-] 1: the last sample was invalid */
} smo_q_t;

/* The same as smo_take(), smo_reset(), smo_reset_error(), its error within ERROR_LARGEST, and smo_step(). */
void smo_take_q(smo_q_t *smo, const smo_tuning_q_t *tuning);
void smo_reset_q(smo_q_t *smo, ab_q_t current, ab_q_t emf);
void smo_reset_error_q(smo_q_t *smo, ab_q_t current, ab_q_t error);
ab_q_t smo_step_q(smo_q_t *smo, ab_q_t voltage, ab_q_t current);

/* true: the sample is within the range. */
static inline bool smo_measured_q(int32_t sample)
{
    return sample >= -SAMPLE_LARGEST && sample <= SAMPLE_LARGEST;
}

/* i_hat(k) of one axis minus the sample, before the limit: i_hat + b (u - v) - b R i_hat - i. It has no
 * overflow: 24 I + 16 I, and the change in a period with |u - v| <= 6 U, 22 I. */
static inline int32_t smo_error_q(const smo_q_t *smo, int32_t hat, int32_t driving, int32_t current)
{
    int64_t change = q_product(smo->tuning.voltage_gain, driving) - q_product(smo->tuning.current_loss, hat);
    return hat - current + (int32_t)q_round(change, 32);
}

/* a_f/2 times a component of the error: Q26 times Q28 is Q54. It is rounded toward zero and so an odd
 * function, because halves are frequent in it. */
static inline int32_t smo_stretched_q(const smo_q_t *smo, int32_t x)
{
    return q_word(q_product(smo->tuning.half_slope, 8 * x));
}

/* A component of v = g x. */
static inline int32_t smo_switched_q(int32_t conductance, int32_t x)
{
    return q_cut(q_product(conductance, x), IMPEDANCE_Q + CURRENT_Q - VOLTAGE_Q, SWITCHED_BITS);
}

/* k_f. */
int32_t smo_equivalent_gain_q(const smo_q_t *smo);

#endif
