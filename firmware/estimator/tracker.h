/* Position and speed from the back-EMF: tracking loop (pll.h), speed of its feed-forward from the length of
 * the EMF (3), and validity of the result (validity.h).
 *
 * The EMF is that of the active flux psi_a = psi_f - D i_d, D = L_q - L_d, along the magnet: the flux that
 * remains after L_q i is subtracted (docs/theory.md, 30). A round rotor has D = 0, and psi_a is its psi_f;
 * its t is given (loop_lean.h), for an L that may be wrong.
 * With i_d, i_q in the frame of the loop
 *
 *     t = D i_q/psi_a              relative change of psi_a by an error of the angle, because the current
 *                                  that the loop holds rotates with the error
 *     f = 1/(1 + kp |t/omega|)     factor of kp and ki where t omega < 0, braking: there the motion of the
 *                                  loop itself changes psi_a in the opposite direction
 *
 * While braking the detector also shows the motion that an error of F causes, in the wrong direction. Only
 * the speed from the length of the EMF, which does not contain this motion, can correct F: its cutoff is
 * multiplied by 1/f^3.
 *
 * Where the iron of the q axis saturates (saturation.h), psi_q = L_q i_q + c with the constant L_q of the
 * observer, and the flux behind the EMF is psi_a + j c in the frame of the rotor. The part of c is known:
 * omega c is added to the EMF along the d axis, and the change of c to the voltage along the q axis. Then
 *
 *     t = (D + excess) i_q/psi_t,  psi_t = psi_f - (D + excess + |i_q| slope) i_d
 *
 * because an error of the angle changes the currents with the incremental inductances. The detector then
 * shows psi_t/psi_a of the error, and D i_q/(psi_a omega) of the motion of the loop: f uses D i_q/psi_t
 * instead of t, and kp and ki are multiplied by psi_a/psi_t. The torque is 1.5 p (psi_a i_q - c i_d).
 *
 * The speed from the length of the EMF is this length over a psi_a that is low-passed like the EMF. The
 * acceleration by the torque, K (psi_a i_q - psi_f i_L) with the load as a current of psi_f, can support the
 * loop (K = 0: off, as in the paper).
 *
 * Sample time: one step per T; the EMF is that of t_k and so is the result. No division: reciprocals are
 * updated by a step of Newton's method in each period. Does not handle: a flux below a tenth of psi_f, which
 * is limited to this value. */
#ifndef ESTIMATOR_TRACKER_H
#define ESTIMATOR_TRACKER_H

#include <stdint.h>

#include "estimator/pll.h"
#include "estimator/position.h"
#include "estimator/saturation.h"
#include "estimator/validity.h"
#include "math/frames.h"

/* Limits in the loop: least psi_a as a share of psi_f [-], and largest |t| [-]. */
#define TRACKER_FLUX_LEAST 0.1f
#define TRACKER_LEAN_MOST  3.0f

/* Largest factor for the detector of a saturated rotor [-]. */
#define TRACKER_GAIN_MOST 2.0f

/* Largest 1/f for the cutoff of the feed-forward in braking [-], and largest share of its low-pass there
 * [-]. */
#define TRACKER_TURNING_MOST 2.5f
#define TRACKER_SHARE_MOST   0.5f

typedef struct {
    pll_params_t pll;
    float flux_linkage;       /* psi_f [Wb], 1e-4..10 */
    float saliency;           /* D = L_q - L_d [H] */
    float torque_feedforward; /* 1.5 p^2 psi_f/J [rad/s^2 per A] */
    saturation_params_t saturation;
    validity_params_t validity;
} tracker_params_t;

typedef struct {
    pll_tuning_t pll;
    validity_tuning_t validity;
    float flux_linkage;       /* psi_f [Wb] */
    float speed_per_volt;     /* 1/psi_f [rad/s/V] */
    uint32_t salient;         /* 1: with a saliency or a saturation [-] */
    float saliency;           /* D [H] */
    float saliency_rate;      /* D/T [V/A] */
    float torque_feedforward; /* K = 1.5 p^2/J [rad/s^2 per Wb and A] */
    float frequency;          /* 1/T [1/s] */
    float pull_most;          /* largest factor of the feed-forward's cutoff, 1 or more [-] */
    saturation_t saturation;
} tracker_tuning_t;

/* The model of the motor in the loop. For a round rotor it is constant with psi_f. */
typedef struct {
    float i_d;            /* of the last step, in the loop's frame [A] */
    float flux;           /* psi_a [Wb] */
    float flux_emf;       /* the same, low-passed like the EMF in the loop [Wb] */
    float speed_per_volt; /* its reciprocal [rad/s/V] */
    float lean;           /* t [-]; of a round rotor by tracker_set_lean() */
    float moved;          /* D i_q/psi_t, with saturation; else t [-] */
    float gain;           /* psi_a/psi_t from 1 to 2, with saturation; else 1 [-] */
    float share;          /* factor of kp and ki [-]: f, with saturation times `gain` */
    float turning;        /* 1/f, from 1 to TRACKER_TURNING_MOST [-] */
    float pull;           /* its cube, limited: factor of the feed-forward's cutoff [-] */
    float inverse;        /* 1/(|omega| + kp |t|) [s/rad] */
    float cross;          /* c = psi_q - L_q i_q of the last step [Wb]; 0 without saturation */
    float per_turned;     /* 1/psi_t [1/Wb], with saturation */
} tracker_motor_t;

typedef struct {
    float flux_linkage;       /* psi_f, of the tuning or adapted [Wb] */
    uint32_t salient;         /* of the tuning: 1 with a saliency or a saturation [-] */
    float saliency;           /* D, of the tuning [H] */
    float saliency_rate;      /* D/T, of the tuning [V/A] */
    float torque_feedforward; /* K, of the tuning [rad/s^2 per Wb and A] */
    float load;               /* i_L [A], set by the caller; 0: the load is unknown */
    float frequency;          /* 1/T, of the tuning [1/s] */
    float pull_most;          /* of the tuning [-] */
    saturation_t saturation;  /* of the tuning */
    tracker_motor_t motor;
    pll_t pll;
    validity_t validity;
} tracker_t;

/* Computes the coefficients of a set whose parts have passed their checks. It has divisions and runs in the
 * background. */
void tracker_prepare(tracker_tuning_t *tuning, const tracker_params_t *params);

/* true: psi_a depends on the current. */
static inline bool tracker_is_salient(const tracker_t *tracker)
{
    return tracker->salient != 0u;
}

/* Sets another psi_f [Wb] and its reciprocal [rad/s/V]. */
static inline void tracker_set_flux(tracker_t *tracker, float flux_linkage, float speed_per_volt)
{
    tracker->flux_linkage = flux_linkage;
    if (!tracker_is_salient(tracker)) {
        tracker->motor.flux = flux_linkage;
        tracker->motor.flux_emf = flux_linkage;
        tracker->motor.speed_per_volt = speed_per_volt;
    }
}

/* Sets the lean of a round rotor [-] (estimator/loop_lean.h). */
static inline void tracker_set_lean(tracker_t *tracker, float lean)
{
    if (!tracker_is_salient(tracker)) {
        tracker->motor.lean = lean;
    }
}

/* Sets the coefficients, psi_f among them; the state is kept. */
static inline void tracker_take(tracker_t *tracker, const tracker_tuning_t *tuning)
{
    pll_take(&tracker->pll, &tuning->pll);
    validity_take(&tracker->validity, &tuning->validity);
    if (tracker->salient != tuning->salient) {
        tracker->motor.lean = 0.0f;
        tracker->motor.share = 1.0f;
        tracker->motor.pull = 1.0f;
    }
    tracker->salient = tuning->salient;
    tracker->saliency = tuning->saliency;
    tracker->saliency_rate = tuning->saliency_rate;
    tracker->torque_feedforward = tuning->torque_feedforward;
    tracker->frequency = tuning->frequency;
    tracker->pull_most = tuning->pull_most;
    if (saturation_is_on(&tuning->saturation)) {
        tracker->saturation = tuning->saturation;
    } else {
        tracker->saturation.per_step = 0.0f;
        tracker->motor.cross = 0.0f;
    }
    tracker_set_flux(tracker, tuning->flux_linkage, tuning->speed_per_volt);
}

/* Sets the state of a tracker locked at t_k at `start` [rad], [rad/s] with this current [A] in its frame, on
 * an EMF of this amplitude [V]; the next step is that of t_k+1. Validity starts again. It has divisions. */
void tracker_reset(tracker_t *tracker, position_t start, dq_t current, float amplitude);

/* psi_a [Wb] at this i_d [A]. */
static inline float tracker_flux(const tracker_t *tracker, float i_d)
{
    const float flux = tracker->flux_linkage - tracker->saliency * i_d;
    const float least = TRACKER_FLUX_LEAST * tracker->flux_linkage;
    return flux > least ? flux : least;
}

/* c [Wb] at this i_q [A]; 0 without saturation. */
static inline float tracker_cross(const tracker_t *tracker, float i_q)
{
    return saturation_is_on(&tracker->saturation) ? saturation_at(&tracker->saturation, i_q).excess * i_q
                                                  : 0.0f;
}

/* This voltage [V] with the part that the change of psi_a and c since t_k-1 causes, with this current [A] at
 * t_k: along the axes of the magnet in the middle of the period. For a salient rotor. */
ab_t tracker_transient(const tracker_t *tracker, dq_t current, ab_t voltage);

/* Updates the motor with this current [A] in the frame of the loop at t_k. For a salient rotor. */
void tracker_follow(tracker_t *tracker, dq_t current);

/* Acceleration by the torque: K (psi_a i_q - c i_d - psi_f i_L) [rad/s^2]. */
static inline float tracker_acceleration(const tracker_t *tracker, float i_q)
{
    const tracker_motor_t *motor = &tracker->motor;
    return tracker->torque_feedforward *
           (motor->flux * i_q - motor->cross * motor->i_d - tracker->flux_linkage * tracker->load);
}

/* This EMF [V] with the part omega c that the saturation takes from it, along the magnet. */
static inline ab_t tracker_straighten(const tracker_t *tracker, ab_t emf)
{
    const pll_t *pll = &tracker->pll;
    const float missing = pll->omega_e * tracker->motor.cross;
    return (ab_t){emf.alpha + missing * pll->rotation.cos, emf.beta + missing * pll->rotation.sin};
}

/* Position at t_k from the EMF [V] and the i_q [A] at t_k, with the motor of tracker_follow(). */
static inline position_t tracker_step(tracker_t *tracker, ab_t emf, float i_q)
{
    const tracker_motor_t *motor = &tracker->motor;
    const pll_motor_t loop = {motor->speed_per_volt, motor->lean, motor->share, motor->pull,
                              tracker_acceleration(tracker, i_q)};
    return pll_step_inline(&tracker->pll, emf, loop);
}

/* Judges the tracked period, with the square of the observer's current error [A^2]. */
static inline void tracker_judge(tracker_t *tracker, float error_square)
{
    const pll_t *pll = &tracker->pll;
    validity_step(&tracker->validity, pll->omega_smooth, pll->amplitude * tracker->motor.speed_per_volt,
                  pll->detector, error_square);
}

/* A period with a doubtful EMF: the filter of the loop takes it, the loop coasts, and the period is not
 * judged. */
static inline position_t tracker_watch(tracker_t *tracker, ab_t emf, float i_q)
{
    return pll_watch(&tracker->pll, emf, tracker_acceleration(tracker, i_q));
}

/* A period without an EMF: the loop coasts on the last speed, and the period is not judged. */
static inline position_t tracker_coast(tracker_t *tracker)
{
    return pll_coast(&tracker->pll, 0.0f);
}

#endif
