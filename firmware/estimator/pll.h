/* Phase-locked loop on the estimated back-EMF: conventional and feed-forward PLL, paper eqs. (15)-(27). One
 * step per `period`; the EMF is that of t_k and so is the result.
 *
 * In the frame of the loop's own angle, e = (e_d, e_q), locked when e_d = 0 (then e_q = psi_f omega_e):
 *
 *     w_s   = I + F                                       smooth speed: integrator + feed-forward
 *     s     = clamp(w_s / 20 rad/s, -1, 1)                soft sign: no step at zero speed
 *     eps   = -e_d s / max(|e|, floor)                    detector (15), normalised (17), signed (erratum 6)
 *     w_emf = (e_q or sign(w_s) |e|) speed_per_volt       speed from the EMF (3): e_q below 80 rad/s
 *     F    += (1 - exp(-omega_c T)) (w_emf - F)           feed-forward, Fig. 7,
 *             + T acceleration                            and the acceleration by the torque
 *     omega = I + kp eps + F
 *     theta(k+1) = theta(k) + T omega,   I(k+1) = I(k) + ki T eps
 *
 * With emf_cutoff the EMF is first low-passed in this frame, where it is constant at constant speed and the
 * filter has no lag, unlike that of eq. (11); the filter is one more pole of the loop.
 *
 * For small errors the loop is type III with Phi_1 = (22), error function (23) (erratum 7: the denominator of
 * (21) is s^3); without feed-forward it is the type-II loop (19). With a constant electrical acceleration a
 * [rad/s^2] the angle lags by asin(a/ki) without and by (1 - gamma) a/ki with feed-forward, where gamma is
 * the incremental gain from speed to w_emf (erratum 10). I compensates any constant error of w_emf in F.
 *
 * |e| is the amplitude of this sample without another filter, because a filter would make the speed lag.
 *
 * Resolution: in the conventional loop the integrator contains the whole speed. It stops when ki T eps is
 * below half of the last digit of the speed, and eps may keep this value. It is 0.1 mrad for ki 1624 at 335
 * rad/s, in proportion to speed/(ki T). F stops in the same way before it reaches w_emf; the integrator then
 * compensates the difference without an angle error.
 *
 * Does not handle: a lag or an attenuation of the EMF (estimator/lag.h, speed_per_volt); the search for the
 * rotor at standstill; a slow passage through zero speed, where the EMF and with it the detector vanish. A
 * conventional loop whose w_s is zero has a detector of zero and stays there until it is reset; started below
 * 20 rad/s it needs the correct direction and about the correct angle. With a feed-forward, e_q starts it. */
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

/* At this speed and above the soft sign is +-1 [rad/s]. */
#define PLL_SIGN_SPEED 20.0f

/* Below this smooth speed [rad/s] the loop uses e_q, which has a sign, instead of the amplitude. */
#define PLL_SIGNED_SPEED 80.0f

/* Largest angle by which the feed-forward may rotate in one period [rad]; the integrator may rotate by twice
 * this, so that it can still compensate a feed-forward at its limit. */
#define PLL_TURN_LIMIT 1.25f

/* Largest value whose square stays in range [V]. */
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
    float direction;     /* +-1 from a reset below 20 rad/s until |w_s| reaches it, replaces s; then 0 [-] */
    float detector;      /* eps of the last step [-], -1..1 */
    float amplitude;     /* |e| of the last step [V] */
} pll_t;

/* true: the set is valid; `why` is then unchanged. false: `why` has the first violated rule: the ranges above
 * and, for kp and ki, the stability of the sampled loop z^2 + (kp T - 2) z + 1 - kp T + ki T^2 (Jury). A loop
 * that is stable with s = 1 is stable with every smaller s; the feed-forward is outside the loop and always
 * stable. */
bool pll_params_check(const pll_params_t *params, params_error_t *why);

/* Computes the coefficients of a valid (checked) set. It has divisions and exponentials and runs in the
 * background. */
void pll_prepare(pll_tuning_t *tuning, const pll_params_t *params);

/* Sets the coefficients; the state is kept. If the detector is not 0, the speed has a step in
 * proportion to the change of kp. If the feed-forward is switched off, its last value stays and the
 * integrator works against it; the caller then has to reset the loop. */
static inline void pll_take(pll_t *pll, const pll_tuning_t *tuning)
{
    pll->tuning = *tuning;
}

/* Sets the coefficients; angle 0, speed 0. The set must be valid (checked). */
void pll_init(pll_t *pll, const pll_params_t *params);

/* Sets the state of a loop locked at `start`, the angle [rad] and speed [rad/s] of the EMF: with that EMF the
 * next step returns exactly these. The speed, limited to +-PLL_TURN_LIMIT/T, goes to the feed-forward if
 * there is one (integrator 0), else to the integrator. Its sign is the direction, zero counts as positive;
 * below 20 rad/s the detector keeps that direction, at full gain, until the loop has once been faster.
 * `start` must be finite. */
void pll_reset(pll_t *pll, position_t start);

/* Angle and speed of the EMF [V] at t_k: theta_e, where e_d was zero, in [-pi, pi), and omega_e, the whole
 * frequency of the loop, k_p term included. It is the angle of the rotor if the EMF has no lag (lag_emf);
 * else the caller adds lag_angle(). `speed_per_volt` = 1/psi_f [rad/(s V)], divided by the attenuation of the
 * EMF if it has one; it has no effect on a conventional loop. `acceleration` [rad/s^2] by the torque is K
 * i_q; 0 = the paper. It requires a feed-forward: in a conventional loop its integral would never decay and
 * would end at the limit, opposed by the integrator.
 *
 * feedforward_cutoff = 0 with acceleration = 0 is exactly the conventional PLL. For any input, also
 * non-finite ones, result and state stay finite: with an EMF that is not finite or, filtered, above 1e15 V
 * the loop coasts; an F that would exceed +-PLL_TURN_LIMIT/T, or would not be finite, keeps its value, and so
 * does an I that would exceed twice that limit. Zero EMF: detector 0, F decays.
 *
 * No division. */
position_t pll_step(pll_t *pll, ab_t emf, float speed_per_volt, float acceleration);

/* After a reset: sets the state of a filter that has settled on an EMF of this amplitude [V]. Without this
 * call the filter starts from zero, and the feed-forward is too small for some time constants of the filter.
 */
void pll_reset_emf(pll_t *pll, float amplitude);

/* After pll_reset_emf(): sets F to the speed from this EMF with the assumed psi_f (`speed_per_volt` as in
 * pll_step()), and I to the difference. Without this call F, which starts at the whole speed, moves the loop
 * away until I has compensated the error of psi_f: with an error of a quarter, further than the range of the
 * loop. No effect on a conventional loop, nor below PLL_SIGNED_SPEED, where one sample of |e| is too
 * inaccurate. */
void pll_reset_feedforward(pll_t *pll, float speed_per_volt);

/* A period without an EMF: position at t_k from the smooth speed only, which changes by `acceleration`
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

/* true: this |e|^2 [V^2] is that of a valid EMF, finite and not above PLL_EMF_LIMIT. */
static inline bool pll_is_emf(float square)
{
    return square <= PLL_EMF_LIMIT * PLL_EMF_LIMIT;
}

/* s: the sign of the detector, soft around zero speed; once the loop is faster, the direction of the start is
 * no longer needed. */
static inline float pll_soft_sign(pll_t *pll)
{
    float sign = bounds_clamp(pll->omega_smooth * (1.0f / PLL_SIGN_SPEED), 1.0f);
    if (bounds_magnitude(sign) >= 1.0f) {
        pll->direction = 0.0f;
    }
    return pll->direction != 0.0f ? pll->direction : sign;
}

/* Advances to the angle of the next result, at this speed. I + F + kp eps rotate by less than a turn in a
 * period. */
static inline void pll_turn(pll_t *pll, float omega_e)
{
    pll->omega_e = omega_e;
    pll->theta_e = angle_turn_back(pll->theta_e + pll->tuning.period * omega_e);
    pll->rotation = trig_turn(pll->theta_e);
}

/* Values of the motor for a step of the loop. A round rotor: 1/psi_f, 0, 1, 1 and the acceleration by the
 * torque. */
typedef struct {
    float speed_per_volt; /* 1/psi_a [rad/s/V] */
    float lean;  /* t: relative increase of the flux with the error of the loop, d psi_a/(psi_a d err) [-] */
    float share; /* factor of kp and ki [-], above 0, at most 1 */
    float pull;  /* factor of the cutoff of the feed-forward [-], 1 to 3 */
    float acceleration; /* by the torque [rad/s^2] */
} pll_motor_t;

/* pll_step() for any rotor, inline for the interrupt. The length of the EMF over psi_a is the speed times 1 +
 * t err, because the error rotates the true current; t e_d removes this from the feed-forward, which would
 * otherwise feed the error back with w t. */
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

    /* Speed from the EMF (3), feed-forward of Fig. 7; an F that would exceed its limit, or is not finite,
     * keeps its value; so does I. */
    float signed_emf = bounds_magnitude(pll->omega_smooth) < PLL_SIGNED_SPEED ? e.q : sign * amplitude;
    const float omega_emf = (signed_emf - motor.lean * e.d) * motor.speed_per_volt;
    float feedforward = lowpass_step(pll->feedforward, motor.pull * tuning->feedforward_share, omega_emf) +
                        tuning->period * acceleration;
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

/* A period with a doubtful EMF: the filter takes it, and the loop coasts. */
position_t pll_watch(pll_t *pll, ab_t emf, float acceleration);

/* kp, ki, feedforward_cutoff and period for a -3 dB `bandwidth` [rad/s] of the closed loop, eq. (22): kp = 2
 * damping wn, ki = wn^2, where with u = wn/bandwidth, c = feedforward_cutoff/bandwidth, z = damping
 *
 *     (1 + c^2) u^4 + [4 z^2 + 2 + c^2 (4 z^2 - 2)] u^2 + 8 z c u = 1 - c^2           (|Phi_1|^2 = 1/2)
 *
 * so the gains fall as the cutoff rises (erratum 11; the paper's comparison has damping 1). For c < 1 and
 * damping >= 0.5 there is exactly one such u, and |Phi_1| crosses -3 dB only there. With sample and hold, the
 * bandwidth deviates by a share of at most about bandwidth T/2. amplitude_floor is not changed. The result is
 * false, and `params` is unchanged, if damping is not within 0.5..5, the cutoff is not below the bandwidth,
 * or the result violates a rule of pll_params_check() (except for amplitude_floor). A Newton iteration of 24
 * steps: for init. */
bool pll_design(pll_params_t *params, float bandwidth, float damping, float feedforward_cutoff, float period);

#endif
