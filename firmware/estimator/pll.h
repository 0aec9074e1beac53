/* Phase-locked loop on the estimated back-EMF: conventional and feed-forward PLL, paper eqs. (15)-(27). One
 * step per `period`; the EMF is that of t_k and so is the result.
 *
 * In the frame of the loop's own angle, e = (e_d, e_q), locked when e_d = 0 (then e_q = psi_f omega_e):
 *
 *     w_s   = I + F                                       smooth speed: integrator + feed-forward
 *     s     = clamp(w_s / 20 rad/s, -1, 1)                soft sign: nothing jumps at zero speed
 *     eps   = -e_d s / max(|e|, floor)                    detector (15), normalised (17), signed (erratum 6)
 *     w_emf = (e_q or sign(w_s) |e|) speed_per_volt       speed from the EMF (3): e_q below 80 rad/s
 *     F    += (1 - exp(-omega_c T)) (w_emf - F)           feed-forward, Fig. 7,
 *             + T acceleration                            and the torque's share
 *     omega = I + kp eps + F
 *     theta(k+1) = theta(k) + T omega,   I(k+1) = I(k) + ki T eps
 *
 * With emf_cutoff the EMF is low-passed in this frame first, where it stands still at constant speed and the
 * filter has no lag, unlike that of eq. (11); it is one more pole of the loop.
 *
 * For small errors the loop is type III with Phi_1 = (22), error function (23) (erratum 7: the denominator of
 * (21) is s^3); without feed-forward it is the type-II loop (19). While the electrical acceleration is a
 * [rad/s^2] the angle is late by asin(a/ki) without and by (1 - gamma) a/ki with feed-forward, gamma being
 * the incremental gain from speed to w_emf (erratum 10); F and I sort any constant error of w_emf out between
 * them.
 *
 * |e| is the amplitude of this sample, not filtered again: a filter of its own would lag the speed.
 *
 * Resolution: where the integrator carries the whole speed (conventional), it stops when ki T eps is below
 * half of the speed's last digit and eps may rest there: 0.1 mrad for ki 1624 at 335 rad/s, in proportion to
 * speed/(ki T). F stops in the same way short of w_emf, which the integrator then makes up without an angle
 * error.
 *
 * Does not handle: a lag or an attenuation of the EMF (estimator/lag.h, speed_per_volt); the search for the
 * rotor at standstill; passing zero speed slowly, where the EMF and with it the detector fade. In particular
 * a conventional loop whose w_s has come to rest at zero has no detector any more and stays there until it is
 * reset; started below 20 rad/s it needs the right direction and about the right angle. With a feed-forward,
 * e_q gets it away. */
#ifndef ESTIMATOR_PLL_H
#define ESTIMATOR_PLL_H

#include <stdbool.h>
#include <stdint.h>

#include "contract/refusal.h"
#include "estimator/position.h"
#include "math/angle.h"
#include "math/bounds.h"
#include "math/filter.h"
#include "math/frames.h"
#include "math/root.h"
#include "math/trig.h"

/* The soft sign is whole from here on [rad/s]. */
#define PLL_SIGN_SPEED 20.0f

/* Below this smooth speed [rad/s] e_q, which has a sign of its own, stands for the amplitude. */
#define PLL_SIGNED_SPEED 80.0f

/* Largest angle that the feed-forward may turn in one period [rad]; the integrator may turn twice this, so
 * that it can still oppose a feed-forward that is at its limit. */
#define PLL_TURN_LIMIT 1.0f

/* What has a square that stays in range [V]. */
#define PLL_EMF_LIMIT 1.0e15f

typedef struct {
    float kp;                 /* [rad/s], on the normalised detector (17): ki T < kp < 2/T + ki T/2 */
    float ki;                 /* [rad/s^2], 0 < ki < 4/T^2 */
    float feedforward_cutoff; /* omega_c [rad/s], 0..1/T; 0 = conventional */
    float
        amplitude_floor; /* [V], 1e-3..1e4: below it the detector is divided by the floor; psi_f * 11 rad/s */
    float period;        /* T [s], 1e-6..1e-2 */
    float emf_cutoff;    /* low-pass of the EMF in the loop's frame [rad/s], kp..1e5; 0 = none */
} pll_params_t;

typedef struct {
    float kp;                /* [rad/s] */
    float ki_period;         /* ki T [rad/s] */
    float feedforward_share; /* 1 - exp(-omega_c T) [-]; 0 = conventional */
    float inverse_floor;     /* 1/amplitude_floor [1/V] */
    float speed_limit;       /* PLL_TURN_LIMIT/T [rad/s] */
    float period;            /* T [s] */
    float emf_decay;         /* exp(-emf_cutoff T) [-]; 0 = no filter */
} pll_tuning_t;

typedef struct {
    pll_tuning_t tuning;
    /* state */
    float theta_e;       /* angle of the next step's result [rad], [-pi, pi) */
    rotation_t rotation; /* its sine and cosine [-] */
    float integral;      /* I [rad/s] */
    float feedforward;   /* F [rad/s] */
    dq_t emf;            /* in the frame of the loop, filtered [V] */
    float omega_e;       /* whole frequency of the last step [rad/s]: the speed for the lag */
    float omega_smooth;  /* w_s = I + F after the last step [rad/s] */
    float direction; /* +-1 from a reset below 20 rad/s until |w_s| gets there, stands for s; then 0 [-] */
    float detector;  /* eps of the last step [-], -1..1 */
    float amplitude; /* |e| of the last step [V] */
} pll_t;

/* Good, or the first violated rule in `why` (untouched if good): the ranges above and, for kp and ki, the
 * stability of the sampled loop z^2 + (kp T - 2) z + 1 - kp T + ki T^2 (Jury). A loop that is stable with s =
 * 1 is so with every smaller s; the feed-forward is outside the loop and always stable. */
bool pll_params_check(const pll_params_t *params, params_error_t *why);

/* Coefficients of a good (checked) set. Divisions and exponentials: for the background. */
void pll_prepare(pll_tuning_t *tuning, const pll_params_t *params);

/* The coefficients alone; the state goes on. Bumpless when the detector is 0, else the speed jumps by its
 * share of kp. If the feed-forward is switched off its last value stays, and the integrator works against it:
 * reset then. */
static inline void pll_take(pll_t *pll, const pll_tuning_t *tuning)
{
    pll->tuning = *tuning;
}

/* Coefficients; angle 0, speed 0. The set must be good (checked). */
void pll_init(pll_t *pll, const pll_params_t *params);

/* As if the loop had been locked at `start`, the angle [rad] and speed [rad/s] of the EMF: with that EMF the
 * next step returns just these. The speed, cut to +-PLL_TURN_LIMIT/T, goes to the feed-forward if there is
 * one (integrator 0), else to the integrator. Its sign is the direction, zero counts as positive; below 20
 * rad/s the detector keeps that direction, at full gain, until the loop has once been faster. `start` must be
 * finite. */
void pll_reset(pll_t *pll, position_t start);

/* Angle and speed of the EMF [V] at t_k: theta_e where e_d was zero, in [-pi, pi), and omega_e the loop's
 * whole frequency, k_p term included. The rotor's angle, if the EMF has no lag (lag_emf); else add
 * lag_angle(). `speed_per_volt` = 1/psi_f [rad/(s V)], over the EMF's attenuation if it has one; without
 * effect on a conventional loop.
 * `acceleration` [rad/s^2]: the torque's share K i_q, 0 = the paper. On a conventional loop nothing ever
 * forgets its integral, which then ends at the limit while the integrator opposes it: use it with a
 * feed-forward.
 *
 * feedforward_cutoff = 0 with acceleration = 0 is the conventional PLL bit for bit. For any input, non-finite
 * ones too, result and state stay finite: with an EMF that is not finite or, filtered, beyond 1e15 V the loop
 * coasts; an F that would leave +-PLL_TURN_LIMIT/T, or would be no number, stays as it was, and so does an I
 * that would leave twice that limit. Zero EMF: detector 0, F decays.
 *
 * No division. */
position_t pll_step(pll_t *pll, ab_t emf, float speed_per_volt, float acceleration);

/* After a reset: as if the filter had settled on an EMF of this amplitude [V] too. Without it the filter
 * starts from zero and the feed-forward dips for some of its time constants. */
void pll_reset_emf(pll_t *pll, float amplitude);

/* After that: as if F too had settled, on what this EMF tells of the speed with psi_f as it is believed
 * (`speed_per_volt` as in pll_step()), and I on what it lacks. Without it F, which starts at the whole speed,
 * pulls the loop away until I has made up for psi_f: wrong by a quarter, further than the loop reaches. No
 * effect on a conventional loop, nor below PLL_SIGNED_SPEED, where one sample of |e| says too little. */
void pll_reset_feedforward(pll_t *pll, float speed_per_volt);

/* A period without an EMF: position at t_k from the smooth speed alone, which goes on with `acceleration`
 * [rad/s^2]. */
position_t pll_coast(pll_t *pll, float acceleration);

/* The EMF in the frame of the loop, low-passed there. */
static inline dq_t pll_filtered(const pll_t *pll, ab_t emf)
{
    dq_t e = frames_park(emf, pll->rotation);
    e.d += pll->tuning.emf_decay * (pll->emf.d - e.d);
    e.q += pll->tuning.emf_decay * (pll->emf.q - e.q);
    return e;
}

/* Is this |e|^2 [V^2] that of an EMF? Not of one beyond PLL_EMF_LIMIT or no number. */
static inline bool pll_is_emf(float square)
{
    return square <= PLL_EMF_LIMIT * PLL_EMF_LIMIT;
}

/* s: the detector's sign, soft around zero speed; once the loop is faster, a start's direction is no longer
 * needed. */
static inline float pll_soft_sign(pll_t *pll)
{
    float sign = bounds_clamp(pll->omega_smooth * (1.0f / PLL_SIGN_SPEED), 1.0f);
    if (bounds_magnitude(sign) >= 1.0f) {
        pll->direction = 0.0f;
    }
    return pll->direction != 0.0f ? pll->direction : sign;
}

/* To the angle of the next result, at this speed. I + F + kp eps turn by less than a turn in a period. */
static inline void pll_turn(pll_t *pll, float omega_e)
{
    pll->omega_e = omega_e;
    pll->theta_e = angle_turn_back(pll->theta_e + pll->tuning.period * omega_e);
    pll->rotation = trig_turn(pll->theta_e);
}

/* What the loop knows of the motor in a step. A round rotor: 1/psi_f, 0, 1 and the torque's share. */
typedef struct {
    float speed_per_volt; /* 1/psi_a [rad/s/V] */
    float lean;           /* t: by which the flux grows with the loop's error, d psi_a/(psi_a d err) [-] */
    float share;          /* of kp and ki [-], above 0, at most 1 */
    float acceleration;   /* the torque's share [rad/s^2] */
} pll_motor_t;

/* pll_step() itself for any rotor, inline for the interrupt. The EMF's length over psi_a is the speed times 1
 * + t err, for the error turns the true current; t e_d takes that out of the feed-forward, which would feed
 * the error back with w t. */
static inline position_t pll_step_inline(pll_t *pll, ab_t emf, pll_motor_t motor)
{
    const float acceleration = motor.acceleration;
    const pll_tuning_t *tuning = &pll->tuning;
    dq_t e = pll_filtered(pll, emf);
    float square = e.d * e.d + e.q * e.q;
    if (!pll_is_emf(square)) {
        pll->amplitude = 0.0f;
        return pll_coast(pll, acceleration);
    }

    /* Detector and its normalisation, eqs. (15) - (17). */
    float inverse = inverse_root(square);
    float amplitude = square * inverse;
    float sign = pll_soft_sign(pll);
    float detector = -(sign * e.d) * (inverse < tuning->inverse_floor ? inverse : tuning->inverse_floor);

    /* Speed from the EMF (3), feed-forward of Fig. 7; an F that would leave its limit, or is no number,
     * stays as it was; so does I. */
    float signed_emf = bounds_magnitude(pll->omega_smooth) < PLL_SIGNED_SPEED ? e.q : sign * amplitude;
    const float omega_emf = (signed_emf - motor.lean * e.d) * motor.speed_per_volt;
    float feedforward =
        lowpass_step(pll->feedforward, tuning->feedforward_share, omega_emf) + tuning->period * acceleration;
    if (!(bounds_magnitude(feedforward) <= tuning->speed_limit)) {
        feedforward = pll->feedforward;
    }

    /* Loop, eqs. (18), (19); its integrator acts from the next period on. */
    const float error = motor.share * detector;
    position_t position = {pll->theta_e, pll->integral + tuning->kp * error + feedforward};
    float integral = pll->integral + tuning->ki_period * error;
    if (bounds_magnitude(integral) <= 2.0f * tuning->speed_limit) {
        pll->integral = integral;
    }
    pll->feedforward = feedforward;
    pll->omega_smooth = pll->integral + feedforward;
    pll->emf = e;
    pll->amplitude = amplitude;
    pll->detector = detector;
    pll_turn(pll, position.omega_e);
    return position;
}

/* A period whose EMF is in doubt: it goes into the filter, and the loop coasts. */
position_t pll_watch(pll_t *pll, ab_t emf, float acceleration);

/* kp, ki, feedforward_cutoff and period for a -3 dB `bandwidth` [rad/s] of the closed loop, eq. (22):
 * kp = 2 damping wn, ki = wn^2, where with u = wn/bandwidth, c = feedforward_cutoff/bandwidth, z = damping
 *
 *     (1 + c^2) u^4 + [4 z^2 + 2 + c^2 (4 z^2 - 2)] u^2 + 8 z c u = 1 - c^2           (|Phi_1|^2 = 1/2)
 *
 * so gains fall as the cutoff rises (erratum 11; the paper's comparison has damping 1). For c < 1 and damping
 * >= 0.5 there is exactly one such u, and |Phi_1| crosses -3 dB only there. As built, with sample and hold,
 * the bandwidth is off by a share of at most about bandwidth T/2. amplitude_floor is left as it is. False,
 * and `params` untouched, if damping is not within 0.5..5, the cutoff not below the bandwidth, or the result
 * breaks a rule of pll_params_check() (amplitude_floor apart). A Newton iteration of 24 steps: for init. */
bool pll_design(pll_params_t *params, float bandwidth, float damping, float feedforward_cutoff, float period);

#endif
