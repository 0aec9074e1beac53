/* Standard uncertainty of the estimated angle. Each cause that the drive knows contributes a standard
 * deviation; the result is the root of the sum of their squares.
 *
 * An error of the EMF causes an angle error: its component along the d axis, divided by the EMF. The
 * components of the assumed values and of the sensors are
 *
 *     V       (4/pi) u(V) ((i_d/|i|)^2 + 1/2 (12/35)^2 f^2)^(1/2)
 *     L       |omega| u(L_q) i_q
 *     R       u(R) i_d
 *     gains   ANGLE_SIGMA_GAIN |omega| L_q |i|
 *
 * The voltage that the legs lose has a component along the current, and a sawtooth perpendicular to it
 * (dead_time_learn.h). The loop follows the sixth harmonic of this sawtooth with the share
 * f = k_p/(k_p^2 + 36 omega^2)^(1/2). After a value was learnt until its rate is g (gain.h), (g/g_0)^6 of the
 * initial error remains, and noise in proportion to the root of g:
 *
 *     u^2 = ((g/g_0)^12 data^2 + (g/g_0) learnt^2) value^2
 *
 * V is learnt without being used until it differs from the parameters by a share of g (dead_time_learn.h).
 * Its u^2 contains this difference, (ANGLE_SIGMA_V_UNUSED g/g_0 V)^2. The ripple of the current is r = u_dc
 * T/(8 L_d). If r exceeds the current, the current changes its sign within a period, and the model of the
 * legs is less accurate. Therefore u(V)^2 contains another term, (ANGLE_SIGMA_V_RIPPLE V)^2 r^2/(r^2 +
 * |i|^2).
 *
 * The loop adds errors of its own. Its lag is the angle of the window's mean EMF in its frame. The square of
 * the lag, less the part that noise of the mean causes, is low-passed, so that a lag that swings with the
 * shaft counts with its rms value. The noise of the detector causes T (k_p + k_i/k_p)/2 of its low-passed
 * variance in the angle. While the loop coasts, its speed is not corrected, and the angle error increases by
 * ANGLE_SIGMA_DRIFT of the angle by which the rotor turns.
 *
 * One step per window. Does not handle: errors that the drive cannot know, such as a wrong number of pole
 * pairs, or a loop that has lost the rotor (lock.h). */
#ifndef MEDIUM_ADAPT_ANGLE_SIGMA_H
#define MEDIUM_ADAPT_ANGLE_SIGMA_H

#include <stdint.h>

#include "math/frames.h"

/* The value for an unknown angle: the standard deviation of a uniform distribution, pi/sqrt 3 [rad]. */
#define ANGLE_SIGMA_UNKNOWN 1.8137994f

#define ANGLE_SIGMA_LEAST    0.2e-3f /* [rad] by resolution, and by harmonics of the EMF that are not learnt */
#define ANGLE_SIGMA_GAIN     2e-3f   /* [-] of a sensor, current or DC link */
#define ANGLE_SIGMA_V_LEARNT 2e-3f   /* [-] of V, by noise, at the initial rate */
#define ANGLE_SIGMA_L_LEARNT 5e-3f   /* [-] the same of L_q */
#define ANGLE_SIGMA_R_LEARNT 0.03f   /* [-] the same of R */
#define ANGLE_SIGMA_V_UNUSED                                                                                 \
    0.08f /* [-] of V, at the initial rate: the difference that is not used, DEAD_TIME_LEARN_CHANCE */
#define ANGLE_SIGMA_V_RIPPLE  0.05f  /* [-] of V, if the ripple exceeds the current */
#define ANGLE_SIGMA_DRIFT     0.05f  /* [-] of the speed of a loop that coasts */
#define ANGLE_SIGMA_MEAN_TIME 10e-3f /* [s] of the mean squares of lag and detector */

typedef struct {
    float data;         /* standard uncertainty of V, L and R before they are learnt [-], relative */
    float resistance;   /* assumed R [ohm] */
    float inductance_d; /* assumed L_d [H] */
    float inductance_q; /* assumed L_q [H] */
    float kp, ki;       /* of the loop [rad/s], [rad/s^2] */
    float band;         /* dead band over T [-] */
    float zone;     /* half width of the zone around zero current, in which its direction is unknown [A] */
    float leg_rate; /* g_0 of V [1/s]; 0: not learnt */
    float inductance_rate; /* the same of L and R [1/s] */
    float encoder;         /* electrical angle of a count of the encoder [rad] */
    float period;          /* T [s] */
    float window;          /* from one step to the next [s] */
} angle_sigma_params_t;

typedef struct {
    float data_square;         /* [-] */
    float resistance_square;   /* [ohm^2] */
    float inductance_square;   /* of L_q [H^2] */
    float band;                /* voltage of the dead band per volt of the link [-] */
    float ripple;              /* of the current, per volt of the link [A/V] */
    float follow_square;       /* k_p^2 [rad^2/s^2] */
    float noise_share;         /* variance of the angle over that of the detector [rad^2] */
    float mean_share;          /* of the low-passes of lag and detector [-] */
    float zone_square;         /* [A^2] */
    float per_leg_rate;        /* 1/g_0 of V [s]; 0: not learnt */
    float per_inductance_rate; /* the same of L and R [s] */
    float encoder;             /* of the encoder's angle [rad] */
    float window;              /* [s] */
} angle_sigma_tuning_t;

/* The inputs at the end of a window. */
typedef struct {
    float amplitude;       /* |e| in the loop [V] */
    float omega_e;         /* smoothed speed [rad/s], electrical */
    dq_t current;          /* mean in the rotor's frame [A] */
    dq_t emf;              /* mean in the loop's frame [V] */
    float scatter;         /* mean square of the detector [-] */
    float noise;           /* variance of the mean over that of a sample, for white noise [-] */
    float link;            /* voltage of the DC link [V] */
    float leg_rate;        /* g of V [1/s] */
    float inductance_rate; /* the same of L [1/s] */
    float resistance_rate; /* the same of R [1/s] */
    uint32_t coasted;      /* [-] 1: the loop coasted in this window */
} angle_sigma_input_t;

typedef struct {
    float lag;     /* low-pass of the square of the lag [rad^2], which noise makes negative at times */
    float square;  /* low-pass of the square of the detector [-] */
    float drifted; /* while the loop coasts [rad] */
    float sigma;   /* [rad], up to ANGLE_SIGMA_UNKNOWN */
} angle_sigma_t;

/* Computes the coefficients. Three divisions and an exponential: for the background. */
angle_sigma_tuning_t angle_sigma_prepare(const angle_sigma_params_t *params);

/* Sets sigma to `known` [rad], the deviation of an angle that is not estimated, for example an encoder's. */
void angle_sigma_reset(angle_sigma_t *sigma, float known);

/* Updates sigma->sigma after a window in which the loop tracked or coasted. Five divisions. */
void angle_sigma_step(angle_sigma_t *sigma, const angle_sigma_tuning_t *tuning,
                      const angle_sigma_input_t *input);

#endif
