/* The rotor's position from voltage and current: observer, phase self-compensation and PLL in a row.
 *
 *     u, i --> smo: v, x --> lag_emf: e --> pll: theta_e, omega_e
 *               eqs. (5), (12)   eq. (14)      eqs. (15)-(27), speed of the feed-forward from |e| (3)
 *
 * The compensation acts on the EMF, not on the tracked angle: what the PLL sees is the EMF of t_k itself, in
 * angle and length, so its angle is the rotor's and its amplitude psi_f |omega_e|. The lag belongs to the
 * loop's whole frequency of the last period: with the integrator's speed alone a loop that is late by a/ki
 * would be late by the lag of its missing kp a/ki on top. As that feeds the frequency back, kp and ki act as
 * if divided by 1 - kp times the lag per speed (1 % at a bandwidth of 200 rad/s).
 *
 * With LAG_EXACT the EMF filter (11) acts in the frame of the loop (pll.h), with the paper's modes in the
 * stationary frame (smo.h).
 *
 * Validity: four signs that do not depend on each other, each with its own limits and debounce. A sign that
 * fails counts the periods up, else down; it is raised when the count reaches the debounce and falls when it
 * is back at zero. Debounces are long against a period, so that judging, estimator_judge(), may be rarer than
 * the steps.
 *
 * Sample time: one step per T, in the timing of smo.h: the current of t_k, the voltage that acted on
 * [t_k-1, t_k) (dead time, drops and saturation accounted for), the position at t_k.
 *
 * Does not handle: standstill and very slow passages through zero (the EMF vanishes; the speed sign says so),
 * salient rotors, the choice of dead-time model. */
#ifndef ESTIMATOR_ESTIMATOR_H
#define ESTIMATOR_ESTIMATOR_H

#include <stdbool.h>
#include <stdint.h>

#include "contract/refusal.h"
#include "estimator/lag.h"
#include "estimator/pll.h"
#include "estimator/position.h"
#include "estimator/smo.h"
#include "math/frames.h"

/* k_s over the largest EMF, at least: below 1 the sliding error runs away, eq. (10); the margin is for the
 * voltage error that the observer has to take as well. */
#define ESTIMATOR_GAIN_MARGIN 1.1f

/* Largest K [rad/s^2 per A]. */
#define ESTIMATOR_TORQUE_FEEDFORWARD_MAX 1e7f

/* The flux adapts only when the EMF is large enough to be measured and the loop has settled. */
#define ESTIMATOR_ADAPTATION_SPEED    60.0f /* [rad/s] */
#define ESTIMATOR_ADAPTATION_DETECTOR 0.05f /* [-] */
#define ESTIMATOR_ADAPTATION_CUTOFF   20.0f /* [rad/s], low-pass of EMF and speed */

/* An EMF near zero speed is judged with this allowance, as a speed [rad/s]: the voltage error of an inverter.
 */
#define ESTIMATOR_AMPLITUDE_ALLOWANCE 10.0f

/* Bits of estimator_invalid(). */
#define ESTIMATOR_AMPLITUDE UINT32_C(1)  /* |e| does not fit psi_f |omega_e| */
#define ESTIMATOR_DETECTOR  UINT32_C(2)  /* the EMF does not lie on the q axis */
#define ESTIMATOR_CURRENT   UINT32_C(4)  /* the observer's current is far from the measured one */
#define ESTIMATOR_SPEED     UINT32_C(8)  /* too slow to be seen, or faster than the observer can follow */
#define ESTIMATOR_SAMPLE    UINT32_C(16) /* the last sample was no number: coasting; without debounce */

typedef struct {
    float amplitude_min;  /* of |e|/(psi_f |omega_e|) [-], 0..1; 0 = not judged */
    float amplitude_max;  /* likewise [-], above 1; 0 = not judged */
    float amplitude_time; /* debounce [s], 0..10 */
    float detector_max;   /* of |eps|, the sine of the EMF's angle to the q axis [-], 0..1; 0 = not judged */
    float detector_time;  /* debounce [s], 0..10 */
    float current_max;    /* of |i_hat - i| [A]; 0 = not judged */
    float current_time;   /* debounce [s], 0..10 */
    float speed_min;      /* of |omega_e| [rad/s]; 0 = not judged */
    float speed_max;      /* likewise [rad/s], the largest EMF is psi_f times this; 0 = not judged */
    float speed_time;     /* debounce [s], 0..10 */
} validity_params_t;

typedef struct {
    smo_params_t smo;
    lag_mode_t lag;
    pll_params_t pll;
    float flux_linkage;       /* psi_f [Wb], 1e-4..10; for the feed-forward (3) only */
    float flux_adaptation;    /* [rad/s], 0..100; 0 = off */
    float torque_feedforward; /* K = 1.5 p^2 psi_f/J [rad/s^2 per A], 0..1e7; 0 = off, as in the paper */
    validity_params_t validity;
} estimator_params_t;

#define ESTIMATOR_SIGNS 4

/* A range that is judged with one comparison. */
typedef struct {
    float middle, half;
} band_t;

typedef struct {
    /* coefficients, from estimator_init */
    band_t amplitude;                   /* of |e|/(psi_f |omega_e|) [-] */
    float detector_max;                 /* [-] */
    float error_square_max;             /* current_max^2 [A^2] */
    band_t speed;                       /* of |omega_e| [rad/s] */
    uint32_t debounce[ESTIMATOR_SIGNS]; /* [periods], at least 1, in the order of the bits */
    int32_t lag;                        /* lag_mode_t */
    float flux_linkage_set;             /* psi_f of the parameters [Wb] */
    float torque_feedforward;           /* K [rad/s^2 per A] */
    float adaptation_share;             /* flux_adaptation T [-] */
    /* coefficients and state */
    smo_t smo;
    pll_t pll;
    lowpass_t emf_mean;   /* |e| [V], for the adaptation */
    lowpass_t speed_mean; /* |omega_e| [rad/s], likewise */
    /* state */
    ab_t emf;                        /* e at t_k, lag undone [V] */
    float flux_linkage;              /* psi_f as adapted [Wb] */
    float speed_per_volt;            /* 1/psi_f as adapted [rad/s/V] */
    ab_t reset_current;              /* of estimator_reset [A] */
    float reset_angle;               /* likewise, as the lag mode leaves it [rad] */
    uint32_t special;                /* [-] bits of what few periods have to do: 0 is the shortest way */
    uint32_t count[ESTIMATOR_SIGNS]; /* [periods] */
    uint32_t counting;               /* [-] not 0: a count is not zero */
    uint32_t invalid;                /* [-] bits */
} estimator_t;

/* Whether the set can run: those of smo, pll and validity, equal periods, and the rules between them:
 * k_s >= ESTIMATOR_GAIN_MARGIN psi_f speed_max, and a torque feed-forward only with a feed-forward cutoff,
 * which forgets its error. false: the first violated rule in `why`, fields by the names they have in their
 * part. */
bool estimator_params_check(const estimator_params_t *params, params_error_t *why);

/* Observer and loop as they run: with LAG_EXACT the EMF filter acts in the frame of the loop, in which the
 * EMF stands still and the filter has no lag; the paper's modes have it where the paper has it. */
typedef struct {
    smo_params_t smo;
    pll_params_t pll;
} estimator_parts_t;

estimator_parts_t estimator_parts(const estimator_params_t *params);

/* Coefficients, and a start at angle 0, speed 0, no current. The set must be good (checked). */
void estimator_init(estimator_t *est, const estimator_params_t *params);

/* Coefficients alone; the state goes on. An adapted flux stays while flux_linkage is not changed and the
 * adaptation is on. */
void estimator_retune(estimator_t *est, const estimator_params_t *params);

/* As if locked on a rotor at `start` (angle [rad] and speed [rad/s] at t_k) with this current [A] at t_k: on
 * data without error the following steps of the vector form stay within 0.1 mrad of where they settle up to
 * |omega_e| T = 0.1 and 5 mrad up to LAG_TURN_LIMIT (12 with R T/L = 0.5), those of the sigmoid per axis,
 * whose lag itself has a ripple, within 3 and 40 mrad; whatever the lag mode leaves added is there from the
 * start. The next step may be that of the same t_k (then it gives the start again) or of t_k+1; which it is
 * shows in its current, and in its voltage where the current does not change. Validity starts anew, the
 * adapted flux stays. Both must be finite. Many divisions; not for every period. */
void estimator_reset(estimator_t *est, position_t start, ab_t current);

/* Position at t_k from the voltage [V] that acted on [t_k-1, t_k) and the current [A] at t_k. A sample that
 * is no number or beyond SMO_ERROR_LIMIT coasts on the last speed, raises ESTIMATOR_SAMPLE and changes
 * nothing else. Always finite. Judges nothing. Straight line with one division in the vector form with exact
 * lag and without adaptation, while the loop follows (pll_track). */
position_t estimator_step(estimator_t *est, ab_t voltage, ab_t current);

/* Sine and cosine of the angle that the next step will return: known before it. */
static inline rotation_t estimator_rotation(const estimator_t *est)
{
    return est->pll.rotation;
}

/* Judges the last step, which stands for `periods` periods since the last judgement. A period that was
 * coasted is not judged. Straight line while every sign holds. */
void estimator_judge(estimator_t *est, uint32_t periods);

/* The same as estimator_step for a sample whose voltage is in doubt (a phase current near zero in an inverter
 * with dead time): the observer goes on, the tracking loop coasts, nothing is judged. */
position_t estimator_coast(estimator_t *est, ab_t voltage, ab_t current);

/* 0, or the bits of the signs that failed. */
uint16_t estimator_invalid(const estimator_t *est);

#endif
