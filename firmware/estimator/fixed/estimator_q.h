/* Observer, phase self-compensation and PLL in series, in fixed point: the counterpart of
 * estimator/estimator.h, in the formats of formats.h. Order, modes and criteria of validity with their bits
 * are the same. */
#ifndef ESTIMATOR_FIXED_ESTIMATOR_Q_H
#define ESTIMATOR_FIXED_ESTIMATOR_Q_H

#include <stdint.h>

#include "estimator/debounce.h"
#include "estimator/estimator.h"
#include "estimator/fixed/lag_q.h"
#include "estimator/fixed/pll_q.h"
#include "estimator/fixed/position_q.h"
#include "estimator/fixed/smo_q.h"
#include "math/frames_q.h"

/* Per unit, computed from estimator_params_t by fixed.c. */
typedef struct {
    smo_tuning_q_t smo;
    pll_tuning_q_t pll;
    int32_t lag;                 /* lag_mode_t */
    int32_t speed_per_volt;      /* of the motor's psi_f, Q30, below 1/2 */
    int32_t torque_feedforward;  /* K, Q38, turns per period^2 and I, below 1/128 */
    int32_t amplitude_min;       /* of |e|/(psi_f |omega_e|), Q30 */
    int32_t amplitude_max;       /* Q24 */
    int32_t amplitude_allowance; /* as a speed, Q31 */
    int32_t detector_max;        /* Q30 */
    int32_t current_max;         /* Q25 */
    int32_t speed_min;           /* Q31 */
    int32_t speed_max;           /* Q31 */
    debounce_tuning_t debounce;
} estimator_tuning_q_t;

typedef struct {
    estimator_tuning_q_t tuning;
    smo_q_t smo;
    pll_q_t pll;
    /* state */
    int32_t speed_per_volt; /* 1/psi_f, Q30, below 1/2 */
    int32_t load;           /* i_L, within +-SAMPLE_LARGEST */
    ab_q_t emf;             /* e at t_k, without lag */
    debounce_t debounce;
    uint32_t coasted; /* [-] 1: the last period was not tracked */
} estimator_q_t;

/* The same as estimator_take(), estimator_reset(), estimator_step(), estimator_coast(), estimator_observe(),
 * estimator_lock() and estimator_invalid(). No division; a sample beyond +-SAMPLE_LARGEST is rejected. */
void estimator_take_q(estimator_q_t *est, const estimator_tuning_q_t *tuning);
void estimator_reset_q(estimator_q_t *est, position_q_t start, ab_q_t current);
position_q_t estimator_step_q(estimator_q_t *est, ab_q_t voltage, ab_q_t current);
position_q_t estimator_coast_q(estimator_q_t *est, ab_q_t voltage, ab_q_t current);
void estimator_observe_q(estimator_q_t *est, ab_q_t voltage, ab_q_t current, int32_t omega_e);
void estimator_lock_q(estimator_q_t *est, position_q_t start, int32_t amplitude);
uint32_t estimator_invalid_q(const estimator_q_t *est);

#endif
