/* Phase-locked loop in fixed point: the counterpart of estimator/pll.h, eqs. (15)-(27), in the formats of
 * formats.h. The period is the unit of time, so the speed itself is the change of the angle, which wraps by
 * overflow. Integrator and feed-forward have 63 bits below a turn per period and no dead zone.
 *
 * No division. The speed from the EMF is limited to a quarter of a turn per period; the whole frequency stays
 * below a turn: 3/2 pi of it in integrator and feed-forward, and 2/2 pi of kp, as kp - ki T < 2/T. */
#ifndef ESTIMATOR_FIXED_PLL_Q_H
#define ESTIMATOR_FIXED_PLL_Q_H

#include <stdint.h>

#include "estimator/fixed/formats.h"
#include "estimator/fixed/position_q.h"
#include "estimator/pll.h"
#include "math/filter_q.h"
#include "math/frames_q.h"

/* Per unit, computed from pll_params_t by fixed.c. */
typedef struct {
    int32_t kp_rest;     /* kp - ki T, Q31, turns per period, 0..0.32: ki T is already in the new integral */
    q_scale_t ki_period; /* to Q63 from the detector's Q30 */
    int32_t feedforward_share;  /* 1 - exp(-omega_c T), Q31; 0 = conventional */
    int32_t amplitude_floor;    /* Q27, at least PLL_FLOOR_LEAST */
    int32_t inverse_floor;      /* Q15, 1/amplitude_floor */
    int32_t emf_decay;          /* exp(-emf_cutoff T), Q30; 0 = no filter */
    int32_t sign_speed;         /* PLL_SIGN_SPEED, Q31 */
    int32_t inverse_sign_speed; /* Q14, 1/PLL_SIGN_SPEED */
    int32_t signed_speed;       /* PLL_SIGNED_SPEED, Q31 */
} pll_tuning_q_t;

/* Least floor for which 1/amplitude_floor fits its format. */
#define PLL_FLOOR_LEAST Q_ONE(VOLTAGE_Q - 15)

/* Largest turn in a period, 1 rad, as a speed in both formats: 2^31/2 pi. */
#define PLL_SHORT_LIMIT INT32_C(341782637)
#define PLL_SPEED_LIMIT (PLL_SHORT_LIMIT * (INT64_C(1) << (LONG_SPEED_Q - SPEED_Q)))

typedef struct {
    pll_tuning_q_t tuning;
    /* state */
    uint32_t theta_e;      /* angle of the next step's result */
    rotation_q_t rotation; /* its sine and cosine */
    int64_t integral;      /* I, Q63 */
    int64_t feedforward;   /* F, Q63 */
    dq_q_t emf;            /* in the frame of the loop, filtered */
    int32_t omega_e;       /* whole frequency of the last step: the speed for the lag */
    int32_t omega_smooth;  /* w_s = I + F after the last step */
    int32_t direction;     /* +-1 from a reset below 20 rad/s until |w_s| reaches 20 rad/s; then 0 [-] */
    int32_t detector;      /* eps of the last step, Q30 */
    int32_t amplitude;     /* |e| of the last step */
} pll_q_t;

/* The same as pll_take(), pll_reset(), pll_reset_emf(), pll_reset_feedforward(), pll_step(), pll_coast() and
 * pll_watch(); `acceleration` is the change of the speed in a period, Q63, within +-2 PLL_SPEED_LIMIT;
 * `speed_per_volt` is Q30. */
void pll_take_q(pll_q_t *pll, const pll_tuning_q_t *tuning);
void pll_reset_q(pll_q_t *pll, position_q_t start);
void pll_reset_emf_q(pll_q_t *pll, int32_t amplitude);
void pll_reset_feedforward_q(pll_q_t *pll, int32_t speed_per_volt);
position_q_t pll_step_q(pll_q_t *pll, ab_q_t emf, int32_t speed_per_volt, int64_t acceleration);
position_q_t pll_coast_q(pll_q_t *pll, int64_t acceleration);
position_q_t pll_watch_q(pll_q_t *pll, ab_q_t emf, int64_t acceleration);

#endif
