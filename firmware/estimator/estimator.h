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
 * A salient rotor, D = L_q - L_d: the observer has L_q, and what it sees is the EMF of the active flux
 * (tracker.h), along the q axis whatever the current. What the flux's change takes of the voltage is known
 * and added to it before the observer, D/T (i_d(k) - i_d(k-1)) along the d axis. While the loop rests the
 * axis is not known, and D/T (i(k) - i(k-1)) makes of the observer one with L_d: current control that is fed
 * its EMF would be unstable on the d axis with L_q.
 *
 * Sample time: one step per T, in the timing of smo.h: the current of t_k, the voltage that acted on
 * [t_k-1, t_k) (dead time, drops and saturation accounted for), the position at t_k.
 *
 * What it knows after a step is in `estimate` and `observed`; nobody outside reads the rest.
 *
 * Does not handle: standstill and very slow passages through zero (the EMF vanishes; the criterion of speed
 * says so), saturation of the iron, the choice of dead-time model. */
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

/* k_s over the largest EMF, at least: below 1 the sliding error runs away, eq. (10); the margin is for the
 * voltage error that the observer has to take as well. */
#define ESTIMATOR_GAIN_MARGIN 1.1f

/* Largest K [rad/s^2 per A]. */
#define ESTIMATOR_TORQUE_FEEDFORWARD_MAX 1e7f

typedef struct {
    smo_params_t smo;
    lag_mode_t lag;
    pll_params_t pll;
    float flux_linkage;       /* psi_f [Wb], 1e-4..10; for the feed-forward (3) only */
    float saliency;           /* D = L_q - L_d [H], -1..1; smo.inductance is L_q */
    float flux_most;          /* largest psi_a [Wb], for the judgement of k_s; less than psi_f: psi_f */
    float flux_adaptation;    /* [rad/s], 0..100; 0 = off; for medium/adapt/flux.h, which works beside the
                                 estimator */
    float torque_feedforward; /* K = 1.5 p^2 psi_f/J [rad/s^2 per A], 0..1e7; 0 = off, as in the paper */
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
    estimate_t estimate; /* after it */
    observed_t observed; /* likewise */
} estimator_t;

/* Whether the set can run: those of smo, pll and validity, equal periods, and the rules between them:
 * k_s >= ESTIMATOR_GAIN_MARGIN flux_most speed_max, and a torque feed-forward only with a feed-forward
 * cutoff, which forgets its error. false: the first violated rule in `why`, fields by the names they have in
 * their part. */
bool estimator_params_check(const estimator_params_t *params, params_error_t *why);

/* Observer and loop as they run: with LAG_EXACT the EMF filter acts in the frame of the loop, in which the
 * EMF stands still and the filter has no lag; the paper's modes have it where the paper has it. */
typedef struct {
    observer_params_t observer;
    tracker_params_t tracker;
} estimator_parts_t;

estimator_parts_t estimator_parts(const estimator_params_t *params);

/* Coefficients of a good (checked) set. Divisions and exponentials: for the background. */
void estimator_prepare(estimator_tuning_t *tuning, const estimator_params_t *params);

/* The coefficients alone, psi_f among them; the state goes on. A copy: cheap enough for the interrupt. */
static inline void estimator_take(estimator_t *est, const estimator_tuning_t *tuning)
{
    observer_take(&est->observer, &tuning->observer);
    tracker_take(&est->tracker, &tuning->tracker);
}

/* Coefficients, and a start at angle 0, speed 0, no current. The set must be good (checked). */
void estimator_init(estimator_t *est, const estimator_params_t *params);

/* Another psi_f [Wb] and its reciprocal [rad/s/V] from the next step on, until the next estimator_take(). */
static inline void estimator_set_flux(estimator_t *est, float flux_linkage, float speed_per_volt)
{
    tracker_set_flux(&est->tracker, flux_linkage, speed_per_volt);
}

/* What carries the load, as a current of psi_f [A], until it is set anew: the torque of the rest accelerates.
 * Within the largest current. */
static inline void estimator_set_load(estimator_t *est, float current)
{
    est->tracker.load = current;
}

/* As if locked on a rotor at `start` (angle [rad] and speed [rad/s] at t_k) with this current [A] at t_k; the
 * next step is that of t_k+1 (whoever steps t_k itself turns the angle back by omega_e T before). On data
 * without error the following steps of the vector form stay within 0.1 mrad of where they settle up to
 * LAG_TURN_LIMIT, those of the sigmoid per axis, whose lag itself has a ripple, within 3 mrad up to
 * |omega_e| T = 0.1; whatever the lag mode leaves added is there from the start. Validity starts anew. Both
 * must be finite. Many divisions; not for every period. */
void estimator_reset(estimator_t *est, position_t start, ab_t current);

/* Position at t_k from the voltage [V] that acted on [t_k-1, t_k) and the current [A] at t_k. A sample that
 * is no number or beyond SMO_ERROR_LIMIT coasts on the last speed, raises ESTIMATOR_SAMPLE and changes
 * nothing else. Always finite. Judges each period that is tracked. One division in the vector form with exact
 * lag. */
position_t estimator_step(estimator_t *est, ab_t voltage, ab_t current);

/* The same without a judgement, for a caller who judges by the estimate, and less often. */
position_t estimator_track(estimator_t *est, ab_t voltage, ab_t current);

/* A period in which the loop does not track: the observer alone, with the lag of this speed [rad/s]. EMF and
 * amplitude are those of t_k; frame, speed and validity stay. A sample that is no number changes nothing. */
void estimator_observe(estimator_t *est, ab_t voltage, ab_t current, float omega_e);

/* The loop as if locked at `start` (angle [rad] and speed [rad/s] at t_k, finite) on an EMF of this mean
 * length [V], >= 0; the observer goes on, validity starts anew, and the next step is that of t_k+1. */
void estimator_lock(estimator_t *est, position_t start, float amplitude);

/* The same as estimator_step for a sample whose voltage is in doubt (a phase current near zero in an inverter
 * with dead time): the observer goes on, the tracking loop coasts, nothing is judged. */
position_t estimator_coast(estimator_t *est, ab_t voltage, ab_t current);

/* 0, or the bits of the criteria that failed. */
uint16_t estimator_invalid(const estimator_t *est);

#endif
