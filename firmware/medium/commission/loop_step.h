/* Checks the current loop with the measured R and L: the current control of the drive works along the axis of
 * a standing current, and its reference steps between two values. With the period T and the bandwidth w_c the
 * loop is an integrator behind a delay of two periods, with the gain K = w_c T if the measured L is right:
 *
 *     e_k - e_k+1 = K e_k-1       e: reference minus current, in the periods after a step
 *
 * The least-squares value of K over forty steps is K_0 L_hat/L, with K_0 of the parameters. A rise time
 * would not show L: at small L/R it hardly depends on it. The noise of the sensors adds its square to the sum
 * of e^2; this part is subtracted. If the d axis saturates, L at the standing current is less than the L_d of
 * the parameters by a ratio that the step `inductance` has measured, and K_0 is larger by this ratio. For an
 * L/R of few periods the result of the fit is smaller by the factor 1 - (x/2)/(1 + 3 x/(4 K_0)), x = R T/L.
 * The factor agrees within 0.6 % with the exact law of the winding for K_0 of 0.05 to 0.25 and x up to 0.5.
 */
#ifndef MEDIUM_COMMISSION_LOOP_STEP_H
#define MEDIUM_COMMISSION_LOOP_STEP_H

#include "medium/commission/standing.h"

typedef enum { LOOP_BEGIN, LOOP_ALIGN, LOOP_TURN, LOOP_STILL, LOOP_RUNS } loop_phase_t;

typedef struct {
    int32_t phase;    /* [-] loop_phase_t */
    uint32_t windows; /* [windows] of the stepping reference */
    float moved;      /* sum of (e_k - e_k+1) e_k-1 [A^2] */
    float square;     /* sum of e_k-1^2 [A^2] */
    float periods;    /* [periods] */
    standing_t standing;
} loop_step_t;

void loop_step_begin(loop_step_t *step);

commission_verdict_t loop_step(loop_step_t *step, const commission_tuning_t *tuning,
                               const commission_input_t *input, excite_order_t *order,
                               commission_results_t *results);

#endif
