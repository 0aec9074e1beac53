/* Observer, phase self-compensation and PLL in a row, in fixed point: the twin of estimator/estimator.h, in
 * the formats of formats.h. Same order, same modes, same signs of validity with the same bits. */
#ifndef ESTIMATOR_FIXED_ESTIMATOR_Q_H
#define ESTIMATOR_FIXED_ESTIMATOR_Q_H

#include <stdint.h>

#include "estimator/estimator.h"
#include "estimator/fixed/lag_q.h"
#include "estimator/fixed/pll_q.h"
#include "estimator/fixed/position_q.h"
#include "estimator/fixed/smo_q.h"
#include "math/filter_q.h"
#include "math/frames_q.h"

/* Per unit, made from estimator_params_t by fixed.c. */
typedef struct {
    smo_params_q_t smo;
    pll_params_q_t pll;
    int32_t lag;                        /* lag_mode_t */
    int32_t speed_per_volt;             /* of the motor's psi_f, Q30, below 1/2 */
    int32_t adaptation_share;           /* flux_adaptation T, Q31; 0 = off */
    int32_t mean_share;                 /* of ESTIMATOR_ADAPTATION_CUTOFF, Q31 */
    int32_t adaptation_speed;           /* ESTIMATOR_ADAPTATION_SPEED, Q31 */
    int32_t torque_feedforward;         /* K, Q38, turns per period^2 and I, below 1/128 */
    int32_t amplitude_min;              /* of |e|/(psi_f |omega_e|), Q30 */
    int32_t amplitude_max;              /* Q24 */
    int32_t amplitude_allowance;        /* as a speed, Q31 */
    int32_t detector_max;               /* Q30 */
    int32_t current_max;                /* Q25 */
    int32_t speed_min;                  /* Q31 */
    int32_t speed_max;                  /* Q31 */
    uint32_t debounce[ESTIMATOR_SIGNS]; /* [periods], at least 1 */
} estimator_params_q_t;

typedef struct {
    estimator_params_q_t params;
    smo_q_t smo;
    pll_q_t pll;
    lowpass_q_t speed_per_volt; /* 1/psi_f as adapted, Q30 */
    lowpass_q_t emf_mean;       /* |e|, for the adaptation */
    lowpass_q_t speed_mean;     /* |omega_e|, likewise */
    /* state */
    ab_q_t emf;                      /* e at t_k, lag undone */
    ab_q_t reset_current;            /* of estimator_reset_q */
    uint32_t reset_angle;            /* likewise, as the lag mode leaves it */
    uint32_t special;                /* [-] bits of what few periods have to do */
    uint32_t count[ESTIMATOR_SIGNS]; /* [periods] */
    uint32_t counting;               /* [-] not 0: a count is not zero */
    uint32_t invalid;                /* [-] bits */
} estimator_q_t;

/* As estimator_init(), estimator_retune(), estimator_reset(), estimator_step(), estimator_coast(),
 * estimator_judge() and estimator_invalid(). No division anywhere; a sample beyond +-SAMPLE_LARGEST is
 * none. */
void estimator_init_q(estimator_q_t *est, const estimator_params_q_t *params);
void estimator_retune_q(estimator_q_t *est, const estimator_params_q_t *params);
void estimator_reset_q(estimator_q_t *est, position_q_t start, ab_q_t current);
position_q_t estimator_step_q(estimator_q_t *est, ab_q_t voltage, ab_q_t current);
position_q_t estimator_coast_q(estimator_q_t *est, ab_q_t voltage, ab_q_t current);
void estimator_judge_q(estimator_q_t *est, uint32_t periods);
uint16_t estimator_invalid_q(const estimator_q_t *est);

#endif
