/* The position of the rotor from voltage and current: observer, phase self-compensation and PLL in series.
 *
 *     u, i --> smo: v, x --> lag_emf: e --> pll: theta_e, omega_e
 *               eqs. (5), (12)   eq. (14)      eqs. (15)-(27), speed of the feed-forward from |e| (3)
 *
 * The compensation acts on the EMF, not on the tracked angle: the input of the PLL is the EMF at t_k in angle
 * and length, so its angle is that of the rotor and its amplitude psi_f |omega_e|. The lag is computed for
 * the whole frequency of the loop in the last period. The speed of the integrator alone is too small by kp
 * a/ki while the loop has the error a/ki, and would add the lag of this difference. As the frequency is fed
 * back, kp and ki act as if divided by 1 - kp times the lag per speed (1 % at a bandwidth of 200 rad/s).
 *
 * With LAG_EXACT the EMF filter (11) acts in the frame of the loop (pll.h), with the paper's modes in the
 * stationary frame (smo.h).
 *
 * A salient rotor, D = L_q - L_d: the observer uses L_q, and its EMF is that of the active flux (tracker.h),
 * along the q axis for any current. The voltage of the flux's change is known and added before the observer,
 * D/T (i_d(k) - i_d(k-1)) along the d axis. While the loop rests the axis is unknown, and D/T (i(k) - i(k-1))
 * changes the observer to one with L_d: current control with the feed-forward of this EMF would be unstable
 * on the d axis with L_q.
 *
 * Sample time: one step per T, in the timing of smo.h: the current of t_k, the voltage that acted on [t_k-1,
 * t_k) (dead time, drops and saturation accounted for), the position at t_k.
 *
 * The results of a step are in `estimate` and `observed`; other modules do not read the rest.
 *
 * Does not handle: standstill and very slow passages through zero (the EMF vanishes; the criterion of speed
 * reports it), saturation of the d axis and between the axes, the choice of the dead-time model. */
#ifndef ESTIMATOR_ESTIMATOR_H
#define ESTIMATOR_ESTIMATOR_H

#include <stdbool.h>
#include <stdint.h>

#include "contract/refusal.h"
#include "estimator/estimate.h"
#include "estimator/lag.h"
#include "estimator/observer.h"
#include "estimator/pll.h"
#include "estimator/position.h"
#include "estimator/smo.h"
#include "estimator/tracker.h"
#include "estimator/validity.h"
#include "math/frames.h"

/* Smallest ratio of k_s to the largest EMF: below 1 the sliding error diverges, eq. (10); the margin is for
 * the voltage error that the observer also has to compensate. */
#define ESTIMATOR_GAIN_MARGIN 1.1f

/* Largest K [rad/s^2 per A]. */
#define ESTIMATOR_TORQUE_FEEDFORWARD_MAX 1e7f

typedef struct {
    smo_params_t smo;
    lag_mode_t lag;
    pll_params_t pll;
    float flux_linkage;       /* psi_f [Wb], 1e-4..10; for the feed-forward (3) only */
    float saliency;           /* D = L_q - L_d [H], -1..1; smo.inductance is L_q */
    float flux_most;          /* largest psi_a [Wb], for the check of k_s; psi_f if smaller than psi_f */
    float flux_adaptation;    /* [rad/s], 0..100; 0 = off; for medium/adapt/flux.h, which runs beside the
                                 estimator */
    float torque_feedforward; /* K = 1.5 p^2 psi_f/J [rad/s^2 per A], 0..1e7; 0 = off, as in the paper */
    saturation_params_t saturation; /* of the q axis, with smo.inductance; all zero: none */
    validity_params_t validity;
} estimator_params_t;

typedef struct {
    observer_tuning_t observer;
    tracker_tuning_t tracker;
} estimator_tuning_t;

typedef struct {
    observer_t observer;
    tracker_t tracker;
    ab_t current;        /* of the last step or reset [A] */
    uint32_t rested;     /* [-] 1: the loop has rested since the last lock or reset */
    estimate_t estimate; /* after the last step */
    observed_t observed; /* after the last step */
} estimator_t;

/* true: the set is valid: the ranges of smo, pll and validity, equal periods, and the rules between them: k_s
 * >= ESTIMATOR_GAIN_MARGIN flux_most speed_max, and a torque feed-forward only with a feed-forward cutoff,
 * which removes its error. false: `why` has the first violated rule, with the field's name in its part. */
bool estimator_params_check(const estimator_params_t *params, params_error_t *why);

/* Observer and loop with the filter at its place: with LAG_EXACT the EMF filter acts in the frame of the
 * loop, in which the EMF is constant and the filter has no lag; in the paper's modes it is at the place given
 * in the paper. */
typedef struct {
    observer_params_t observer;
    tracker_params_t tracker;
} estimator_parts_t;

estimator_parts_t estimator_parts(const estimator_params_t *params);

/* Computes the coefficients of a valid (checked) set. It has divisions and exponentials and runs in the
 * background. */
void estimator_prepare(estimator_tuning_t *tuning, const estimator_params_t *params);

/* Sets the coefficients, psi_f among them; the state is kept. It copies a struct, which is short enough for
 * the interrupt. */
static inline void estimator_take(estimator_t *est, const estimator_tuning_t *tuning)
{
    observer_take(&est->observer, &tuning->observer);
    tracker_take(&est->tracker, &tuning->tracker);
}

/* Sets the coefficients and starts at angle 0, speed 0, without current. The set must be valid (checked). */
void estimator_init(estimator_t *est, const estimator_params_t *params);

/* Sets another psi_f [Wb] and its reciprocal [rad/s/V] for the next steps, until the next
 * estimator_take(). */
static inline void estimator_set_flux(estimator_t *est, float flux_linkage, float speed_per_volt)
{
    tracker_set_flux(&est->tracker, flux_linkage, speed_per_volt);
}

/* Sets the lean of the loop of a round rotor [-] (estimator/loop_lean.h), until the next call. */
static inline void estimator_set_lean(estimator_t *est, float lean)
{
    tracker_set_lean(&est->tracker, lean);
}

/* Sets the part of i_q that carries the load, as a current of psi_f [A], until the next call: the torque of
 * the rest accelerates the rotor. It is limited to the largest current. */
static inline void estimator_set_load(estimator_t *est, float current)
{
    est->tracker.load = current;
}

/* Sets the state of an estimator locked on a rotor at `start` (angle [rad] and speed [rad/s] at t_k) with
 * this current [A] at t_k; the next step is that of t_k+1 (a caller whose next step is t_k first turns the
 * angle back by omega_e T). On data without error the following steps of the vector form stay within 0.1 mrad
 * of their final value up to LAG_TURN_LIMIT, and those of the sigmoid per axis, whose lag itself has a
 * ripple, within 3 mrad up to |omega_e| T = 0.1; an error that the lag mode leaves is present from the start.
 * Validity starts again. Both arguments must be finite. Many divisions; not for every period. */
void estimator_reset(estimator_t *est, position_t start, ab_t current);

/* Position at t_k from the voltage [V] that acted on [t_k-1, t_k) and the current [A] at t_k. With a sample
 * that is not finite or above SMO_ERROR_LIMIT the estimator coasts on the last speed, raises ESTIMATOR_SAMPLE
 * and changes nothing else. The result is always finite. Each tracked period is judged. One division in the
 * vector form with exact lag. */
position_t estimator_step(estimator_t *est, ab_t voltage, ab_t current);

/* The same without a judgement, for a caller that judges by the estimate, and less often; the result is in
 * est->estimate only. */
void estimator_track(estimator_t *est, ab_t voltage, ab_t current);

/* A period in which the loop does not track: only the observer runs, with the lag of this speed [rad/s]. EMF
 * and amplitude are those of t_k; frame, speed and validity stay. A sample that is not finite changes
 * nothing. */
void estimator_observe(estimator_t *est, ab_t voltage, ab_t current, float omega_e);

/* Locks the loop at `start` (angle [rad] and speed [rad/s] at t_k, finite) on an EMF of this mean length [V],
 * >= 0; the observer continues, validity starts again, and the next step is that of t_k+1. */
void estimator_lock(estimator_t *est, position_t start, float amplitude);

/* The same as estimator_step for a sample with a doubtful voltage (a phase current near zero in an inverter
 * with dead time): the observer continues, the tracking loop coasts, and the period is not judged. */
position_t estimator_coast(estimator_t *est, ab_t voltage, ab_t current);

/* 0, or the bits of the criteria that failed. */
uint16_t estimator_invalid(const estimator_t *est);

#endif
