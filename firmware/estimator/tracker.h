/* Position and speed from the back-EMF: tracking loop (pll.h), speed of its feed-forward from the EMF's
 * length (3), and whether the result can be believed (validity.h).
 *
 * The EMF is that of the active flux psi_a = psi_f - D i_d, D = L_q - L_d, along the magnet: all of the flux
 * that L_q i leaves (docs/theory.md, 6). A round rotor has D = 0, and psi_a is its psi_f. With i_d, i_q in
 * the frame of the loop
 *
 *     t = D i_q/psi_a              by which an error of the angle changes psi_a: the current that the loop
 * holds turns with it f = 1/(1 + kp |t/omega|)     on kp and ki where t omega < 0, braking: there the loop's
 * own motion moves psi_a against it
 *
 * The speed from the EMF's length is that over a psi_a which is low-passed like the EMF. The torque's share
 * of the acceleration, K (psi_a i_q - psi_f i_L) with the load as a current of psi_f, may help the loop along
 * (K = 0: off, as in the paper).
 *
 * Sample time: one step per T; the EMF is that of t_k and so is the result. No division: reciprocals follow
 * by a step of Newton's method in each period. Does not handle: a flux below a tenth of psi_f, taken as that.
 */
#ifndef ESTIMATOR_TRACKER_H
#define ESTIMATOR_TRACKER_H

#include <stdint.h>

#include "estimator/pll.h"
#include "estimator/position.h"
#include "estimator/validity.h"
#include "math/frames.h"

/* Least psi_a [-] of psi_f, and largest |t| [-], that the loop goes by. */
#define TRACKER_FLUX_LEAST 0.1f
#define TRACKER_LEAN_MOST  3.0f

typedef struct {
    pll_params_t pll;
    float flux_linkage;       /* psi_f [Wb], 1e-4..10 */
    float saliency;           /* D = L_q - L_d [H] */
    float torque_feedforward; /* 1.5 p^2 psi_f/J [rad/s^2 per A] */
    validity_params_t validity;
} tracker_params_t;

typedef struct {
    pll_tuning_t pll;
    validity_tuning_t validity;
    float flux_linkage;       /* psi_f [Wb] */
    float saliency;           /* D [H] */
    float saliency_rate;      /* D/T [V/A] */
    float torque_feedforward; /* K = 1.5 p^2/J [rad/s^2 per Wb and A] */
} tracker_tuning_t;

/* The motor in a period, as the loop sees it. */
typedef struct {
    dq_t current;         /* [A] */
    float flux;           /* psi_a [Wb] */
    float flux_emf;       /* the same, low-passed like the EMF in the loop [Wb] */
    float speed_per_volt; /* its reciprocal [rad/s/V] */
    float lean;           /* t [-] */
} tracker_motor_t;

typedef struct {
    float flux_linkage;       /* psi_f, of the tuning or as adapted [Wb] */
    float saliency;           /* D, of the tuning [H] */
    float saliency_rate;      /* D/T, likewise [V/A] */
    float torque_feedforward; /* K, likewise [rad/s^2 per Wb and A] */
    float load;               /* i_L [A], as set from outside; 0: nothing is known of a load */
    tracker_motor_t motor;    /* of the last step */
    float damping_inverse;    /* 1/(|omega| + kp |t|), likewise [s/rad] */
    pll_t pll;
    validity_t validity;
} tracker_t;

/* Coefficients of a set whose parts have passed their checks. Divisions: for the background. */
void tracker_prepare(tracker_tuning_t *tuning, const tracker_params_t *params);

/* The coefficients alone, psi_f among them; the state goes on. */
static inline void tracker_take(tracker_t *tracker, const tracker_tuning_t *tuning)
{
    pll_take(&tracker->pll, &tuning->pll);
    validity_take(&tracker->validity, &tuning->validity);
    tracker->flux_linkage = tuning->flux_linkage;
    tracker->saliency = tuning->saliency;
    tracker->saliency_rate = tuning->saliency_rate;
    tracker->torque_feedforward = tuning->torque_feedforward;
}

/* As if locked at t_k at `start` [rad], [rad/s] with this current [A] in its frame, on an EMF of this
 * amplitude [V]; the next step is that of t_k+1. Validity starts anew. A division. */
void tracker_reset(tracker_t *tracker, position_t start, dq_t current, float amplitude);

/* 1/`value`, from the reciprocal of a value near it: a step of Newton's method, which from a half to twice of
 * it comes nearer. */
static inline float tracker_reciprocal(float value, float last)
{
    const float product = value * last;
    return last * (2.0f - (product < 1.5f ? product : 1.5f));
}

/* psi_a [Wb] at this i_d [A]. */
static inline float tracker_flux(const tracker_t *tracker, float i_d)
{
    const float flux = tracker->flux_linkage - tracker->saliency * i_d;
    const float least = TRACKER_FLUX_LEAST * tracker->flux_linkage;
    return flux > least ? flux : least;
}

/* The motor at t_k, with this current [A]; the state stays. */
static inline tracker_motor_t tracker_motor(const tracker_t *tracker, ab_t current)
{
    tracker_motor_t motor;
    motor.current = frames_park(current, tracker->pll.rotation);
    motor.flux = tracker_flux(tracker, motor.current.d);
    motor.flux_emf = motor.flux + tracker->pll.tuning.emf_decay * (tracker->motor.flux_emf - motor.flux);
    motor.speed_per_volt = tracker_reciprocal(motor.flux_emf, tracker->motor.speed_per_volt);
    motor.lean = bounds_clamp(tracker->saliency * motor.current.q * motor.speed_per_volt, TRACKER_LEAN_MOST);
    return motor;
}

/* What the change of psi_a since t_k-1 takes of the voltage [V], to be added to it: along the magnet as it
 * was in the middle of the period. */
static inline ab_t tracker_transient(const tracker_t *tracker, const tracker_motor_t *motor)
{
    const pll_t *pll = &tracker->pll;
    const float voltage = tracker->saliency_rate * (motor->current.d - tracker->motor.current.d);
    const float back = 0.5f * pll->tuning.period * pll->omega_e;
    return (ab_t){voltage * (pll->rotation.cos + back * pll->rotation.sin),
                  voltage * (pll->rotation.sin - back * pll->rotation.cos)};
}

/* The torque's share: K (psi_a i_q - psi_f i_L) [rad/s^2]. */
static inline float tracker_acceleration(const tracker_t *tracker, const tracker_motor_t *motor)
{
    return tracker->torque_feedforward *
           (motor->flux * motor->current.q - tracker->flux_linkage * tracker->load);
}

/* f [-]. */
static inline float tracker_share(tracker_t *tracker, float lean)
{
    const pll_t *pll = &tracker->pll;
    const float magnitude = bounds_magnitude(pll->omega_smooth);
    const float speed = magnitude > PLL_SIGN_SPEED ? magnitude : PLL_SIGN_SPEED;
    tracker->damping_inverse =
        tracker_reciprocal(speed + pll->tuning.kp * bounds_magnitude(lean), tracker->damping_inverse);
    return lean * pll->omega_smooth < 0.0f ? speed * tracker->damping_inverse : 1.0f;
}

/* Position at t_k from the EMF [V] and the motor then; judged with the square of the observer's current error
 * [A^2]. */
static inline position_t tracker_step(tracker_t *tracker, ab_t emf, const tracker_motor_t *motor,
                                      float error_square)
{
    pll_t *pll = &tracker->pll;
    const pll_motor_t loop = {motor->speed_per_volt, motor->lean, tracker_share(tracker, motor->lean),
                              tracker_acceleration(tracker, motor)};
    tracker->motor = *motor;
    const position_t position = pll_step_inline(pll, emf, loop);
    validity_step(&tracker->validity, pll->omega_smooth, pll->amplitude * motor->speed_per_volt,
                  pll->detector, error_square);
    return position;
}

/* A period whose EMF is in doubt: it goes into the loop's filter, the loop coasts on, nothing is judged. */
static inline position_t tracker_watch(tracker_t *tracker, ab_t emf, const tracker_motor_t *motor)
{
    tracker->motor = *motor;
    return pll_watch(&tracker->pll, emf, tracker_acceleration(tracker, motor));
}

/* A period without an EMF: the loop coasts on the last speed, nothing is judged. */
static inline position_t tracker_coast(tracker_t *tracker)
{
    return pll_coast(&tracker->pll, 0.0f);
}

#endif
