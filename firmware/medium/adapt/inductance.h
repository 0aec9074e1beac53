/* Inductance L from the answer of the EMF to a small alternating i_d, while the motor turns.
 *
 * The EMF that is observed with the believed R and L_q is u - R i - L_q di/dt - j omega L_q i; in the rotor's
 * frame its q axis is, with what each error (true minus believed) adds,
 *
 *     e_q = psi_f omega + dL (omega i_d + di_q/dt) + dR i_q,       dL = L_d,true - L_q,believed
 *
 * so while i_q does not swing, e_q answers i_d by omega dL, whatever R, psi_f, dead time and shaft are; with
 * the right belief by L_d - L_q, nothing for a round rotor. Over each whole cycle of a dither with the wave s
 *
 *     dL = sum(e_q s)/(omega sum(i_d s))
 *
 * and the learnt L follows what the cycle says by its rate (medium/adapt/gain.h) times the cycle's length.
 * L_d and L_q keep their ratio.
 *
 * i_q would swing: R or L wrong turns the estimate to and fro with the dither, its speed with it, and the
 * speed control answers. What a cycle sees of that, in step and a quarter of a cycle ahead (c), the next one
 * opposes.
 *
 * What is not in step averages out, a constant exactly; a low-pass is taken off all, for slow changes. The
 * wave is made of parabolas, s = 4 t (1 - |t|) for t from -1 to 1: a sine with a third harmonic of 1/27. Its
 * frequency is one of three, never near one, two, five, six or seven times the electrical one, at which
 * errors of the current sensors and the dead time, and both together, let e_q and i_d swing by themselves
 * (docs/theory.md, 24).
 *
 * A cycle says something only if all through it the samples were sound, the loop was locked and the speed
 * stood, if i_d did as it was told and the EMF is there, and if the L it says can be; it counts only if it
 * agrees with the one before, and while most of them do. Where there is nothing to see, slow or without
 * torque, there is no dither.
 *
 * The dither is heard, and costs a half per cent of the copper loss. So it rests while there is nothing to
 * learn: after the first look, which lasts until the rate has fallen to INDUCTANCE_LOOKED of the first, a
 * look of INDUCTANCE_LOOK follows each rest of INDUCTANCE_REST, less than a twentieth of the time. A rest
 * ends early where i_q has moved by INDUCTANCE_MOVED of the limit, with which iron saturates or comes out of
 * it, and while R is looked for there is none. What has been learnt holds meanwhile, and so does its
 * confidence.
 *
 * One step in every so-manieth T, from the means of these. The dither that a step gives is looked for in the
 * means of the next: where it acts later, it is given earlier by as much. Two divisions at the end of a
 * cycle. Does not handle: an L_q that falls with i_q otherwise than L_d; a salient rotor, on which what is
 * learnt drifts away from the right value and takes the loop with it: above L_q = 1.1 L_d the rate is 0. */
#ifndef MEDIUM_ADAPT_INDUCTANCE_H
#define MEDIUM_ADAPT_INDUCTANCE_H

#include <stdbool.h>
#include <stdint.h>

#include "math/bounds.h"
#include "math/filter.h"
#include "math/frames.h"
#include "medium/adapt/believed.h"

#define INDUCTANCE_DITHER      0.05f /* [-] of the current limit: about a tenth of the rated current */
#define INDUCTANCE_TORQUE      0.15f /* [-] of the current limit: i_q at least */
#define INDUCTANCE_FREQUENCY_1 33.0f /* [Hz] */
#define INDUCTANCE_FREQUENCY_2 43.0f /* [Hz] where the first is too near */
#define INDUCTANCE_FREQUENCY_3 57.0f /* [Hz] where the second is, too */
#define INDUCTANCE_FREQUENCIES 3u
#define INDUCTANCE_NEAR        4.0f  /* [Hz] */
#define INDUCTANCE_NEAR_SIXTH  6.5f  /* [Hz] to six times the electrical one, under torque */
#define INDUCTANCE_SPEED_MIN   30.0f /* [rad/s] electrical */
#define INDUCTANCE_R_SPEED_MAX                                                                               \
    100.0f                              /* [rad/s] up to which R is looked for: the dead time is known there \
                                         */
#define INDUCTANCE_SPEED_DRIFT   0.03f  /* [-] of the speed, over a cycle: more is not steady ... */
#define INDUCTANCE_R_SPEED_DRIFT 0.01f  /* [-] ... nor is that, without torque and for R */
#define INDUCTANCE_DETECTOR_MAX  0.1f   /* [-] */
#define INDUCTANCE_CUTOFF        100.0f /* [rad/s] of the low-pass that is taken off */
#define INDUCTANCE_MIN           0.5f   /* [-] of the parameter, R likewise */
#define INDUCTANCE_MAX           2.0f   /* [-] of the parameter, R likewise */
#define INDUCTANCE_AGREES        0.2f   /* [-] of L: two cycles that say the same */
#define INDUCTANCE_LOOKED        0.2f   /* [-] of the first rate, at which the first look ends */
#define INDUCTANCE_LOOK          1.0f   /* [s] of cycles that said something, in each later one */
#define INDUCTANCE_REST          20.0f  /* [s] from one look to the next */
#define INDUCTANCE_MOVED         0.25f  /* [-] of the current limit, by which i_q ends a rest */
#define INDUCTANCE_SALIENT_MAX   1.10001f /* [-] L_q/L_d: 1.1, and its rounding; above it nothing is learnt */

typedef struct {
    float inductance_d;    /* L_d, believed [H], above 0 */
    float inductance_q;    /* L_q, believed [H], above 0 */
    float from;            /* L_q of the parameters [H], above 0 */
    float resistance;      /* R, believed [ohm], above 0 */
    float resistance_from; /* R of the parameters [ohm], above 0 */
    float flux_linkage;    /* psi_f [Wb] */
    float current_max;     /* limit of i_q [A] */
    float rate;            /* at which it begins [1/s], 0..20; 0 = off */
    float period;          /* T [s] */
    uint32_t every;        /* [periods] from one step to the next, at least 1 */
    uint32_t ahead;        /* [steps] that the dither acts later than in the next one */
} inductance_params_t;

/* A frequency of the dither: a cycle of whole periods. */
typedef struct {
    uint32_t steps; /* [-] of a cycle, of so many periods each */
    float step;     /* of the wave's t a step [-] */
    float per_sum;  /* amplitude of a current over its sum with s of a cycle, behind the low-pass [-] */
} inductance_wave_t;

typedef struct {
    inductance_wave_t wave[INDUCTANCE_FREQUENCIES];
    float rate;            /* at which it begins [1/s]; 0 = off, and for a salient rotor */
    float from;            /* L_q of the parameters [H] */
    float inductance_q;    /* L_q with which the observer works [H] */
    float saliency;        /* L_d - L_q of this belief [H] */
    float ratio;           /* L_q/L_d [-] */
    float resistance;      /* R with which the observer works [ohm] */
    float resistance_from; /* R of the parameters [ohm] */
    float flux_linkage;    /* psi_f [Wb] */
    float current;         /* amplitude of the dither [A] */
    float moved;           /* of i_q, which ends a rest [A] */
    uint32_t look;         /* [steps] of cycles that said something, in a later look */
    uint32_t rest;         /* [steps] from one look to the next */
    float mean_share;      /* of the low-pass that is taken off [-] */
    float time;            /* from one step to the next [s] */
    float ahead;           /* [steps] that the dither acts later than in the next one */
} inductance_tuning_t;

/* Of looks and rests. */
typedef struct {
    uint32_t looked; /* steps of the present look's cycles that said something [-] */
    uint32_t rests;  /* steps that are left of a rest [-]; 0: a look */
    float looked_at; /* i_q of the last look [A] */
} inductance_look_t;

/* Over a cycle, s being the wave. */
typedef struct {
    float detector; /* sum(|detector|) [-] */
    float drop;     /* sum((e_d - mean - psi_f omega turned) s) [V] */
    float emf;      /* sum((e_q - mean) s) [V] */
    float answer;   /* sum((i_d - mean) s) [A] */
} inductance_sums_t;

/* Of i_q with the wave and a quarter of a cycle ahead, and what opposes it in the next cycle. */
typedef struct {
    float s;         /* sum((i_q - mean) s) [A] */
    float c;         /* sum((i_q - mean) c) [A] */
    float against_s; /* of i_q, against that swing, in step [A] */
    float against_c; /* the same, a quarter of a cycle ahead [A] */
} inductance_swing_t;

typedef struct {
    inductance_tuning_t tuning;
    learnt_value_t learnt;     /* L_q [H] */
    learnt_value_t resistance; /* R [ohm] */
    float rate;                /* at which L learns now [1/s] */
    float resistance_rate;     /* likewise R [1/s] */
    float confidence;          /* share of the last cycles that agreed with the one before them [-] */
    float said;                /* by the last one [H] */
    inductance_look_t look;
    /* of the cycle */
    uint32_t left;          /* steps that are left of it [-]; 0: none */
    uint32_t sound;         /* [-] 1: nothing has spoilt it */
    uint32_t voltage_known; /* [-] 1: the voltage was, when it began */
    uint32_t follows;       /* [-] 1: it follows one whose samples were sound: the low-passes go on */
    uint32_t which;         /* [-] of the frequencies it has */
    float t;                /* place in the wave [-], -1..1 */
    float omega;            /* when it began [rad/s] */
    float theta;            /* of the last step [rad] */
    float turned;           /* of the loop, to and fro: its high-pass [rad] */
    float emf_d_mean;       /* low-pass of e_d [V] */
    float emf_mean;         /* low-pass of e_q [V] */
    dq_t mean;              /* low-pass of the current [A] */
    inductance_sums_t sum;  /* of the cycle */
    inductance_swing_t swing;
    dq_t dither; /* to be added to the references until the next step [A] */
} inductance_t;

/* What the periods since the last step bring. */
typedef struct {
    dq_t emf;           /* mean in the rotor's frame, lag undone [V] */
    dq_t current;       /* mean in the rotor's frame [A] */
    float detector;     /* now [-] */
    float omega_smooth; /* now [rad/s] electrical */
    float theta;        /* of the rotor's frame now [rad] */
    bool sound;         /* all of them may be believed */
    bool voltage_known; /* the dead time is learnt: what is missing along d is R's */
} inductance_input_t;

/* Coefficients. Divisions and an exponential: for the background. */
inductance_tuning_t inductance_prepare(const inductance_params_t *params);

/* These coefficients; nothing learnt, the first rate. */
void inductance_init(inductance_t *x, const inductance_tuning_t *tuning);

/* The coefficients. What was learnt stays while the parameter that it began from is not changed and the
 * learning is on; else it starts from the parameter again. */
void inductance_take(inductance_t *x, const inductance_tuning_t *tuning);

/* No loop that may be judged: the cycle is given up. */
static inline void inductance_rest(inductance_t *x)
{
    x->left = 0u;
    x->follows = 0u;
    x->confidence = 0.0f;
    x->said = 0.0f;
    x->swing.against_s = 0.0f;
    x->swing.against_c = 0.0f;
    x->dither = (dq_t){0.0f, 0.0f};
}

/* In every so-manieth period with a locked loop, as the tuning says: the step of the wave. */
void inductance_step(inductance_t *x, const inductance_input_t *input);

#endif
