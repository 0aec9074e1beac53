/* Sliding-mode observer in fixed point: the twin of estimator/smo.h, eqs. (5), (11), (12), in the formats of
 * formats.h. Same steps, same states, per unit.
 *
 * A sample beyond +-SAMPLE_LARGEST is no measurement and is passed over. The current error is cut to
 * +-SAMPLE_LARGEST, the k_f of the sign to 128/I. No division in the step. */
#ifndef ESTIMATOR_FIXED_SMO_Q_H
#define ESTIMATOR_FIXED_SMO_Q_H

#include <stdint.h>

#include "estimator/fixed/formats.h"
#include "estimator/smo.h"
#include "math/filter_q.h"
#include "math/frames_q.h"

/* Per unit, made from smo_params_t by fixed.c. */
typedef struct {
    int32_t resistance;     /* R, Q24, 0..128 */
    int32_t voltage_gain;   /* b, Q30, 0..2 */
    int32_t gain;           /* k_s, Q30, 1/2..1 */
    int32_t half_slope;     /* a_f/2, Q26, 0..32 */
    int32_t emf_decay;      /* exp(-omega_s T), Q31; 0 = no filter */
    int32_t mean_share;     /* 1 - exp(-SMO_GAIN_CUTOFF T), Q31 */
    int32_t loop_gain_unit; /* b k_s, Q30, 0..2 */
    int32_t current_loss;   /* b R = 1 - a, Q30, 0..1/2 */
    int32_t hold_lead;      /* lag.h, Q30 */
    int32_t hold_lead_rise; /* Q30 */
    int32_t hold_size;      /* Q30 */
    int32_t hold_cotangent; /* Q30 */
    int32_t lag_resistance; /* 2/b - R, Q24, 0..128 */
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
    uint64_t error_square;    /* |x|^2, Q52 */
    ab_q_t switched;          /* v */
    ab_q_t emf_hat;           /* e_hat at t_k */
    ab_q_t gain_axis;         /* k_f of each axis, Q20 */
    lowpass_q_t mean_product; /* f x of both axes, in the format of currents */
    lowpass_q_t mean_square;  /* x x of both axes, likewise */
    int32_t gain_mean;        /* k_f */
    uint32_t passed_over;     /* [-] 1: the last sample was no measurement */
} smo_q_t;

/* As smo_init(), smo_retune(), smo_reset(), smo_preset() and smo_step(). The resets divide. */
void smo_init_q(smo_q_t *smo, const smo_params_q_t *params);
void smo_retune_q(smo_q_t *smo, const smo_params_q_t *params);
void smo_reset_q(smo_q_t *smo, ab_q_t current, ab_q_t emf);
void smo_preset_q(smo_q_t *smo, ab_q_t current, ab_q_t switched, ab_q_t emf_hat);
ab_q_t smo_step_q(smo_q_t *smo, ab_q_t voltage, ab_q_t current);

/* k_f. */
int32_t smo_equivalent_gain_q(const smo_q_t *smo);

#endif
