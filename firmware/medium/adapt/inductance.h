/* Inductance L from the response of the EMF to a small alternating i_d, while the motor turns.
 *
 * The EMF that is observed with the assumed R and L_q is u - R i - L_q di/dt - j omega L_q i. In the rotor's
 * frame its q axis is, with the effect of each error (true minus assumed value),
 *
 *     e_q = psi_f omega + dL (omega i_d + di_q/dt) + dR i_q,       dL = L_d,true - L_q,assumed
 *
 * If i_q does not swing, e_q responds to i_d with omega dL, for any R, psi_f and dead time;
 * with a correct assumed value dL is L_d - L_q, which is zero for a round rotor. Over each whole
 * cycle of a dither with the wave s
 *
 *     dL = sum(e_q s)/(omega sum(i_d s))
 *
 * and the learnt L moves towards the result of the cycle by the share rate (medium/adapt/gain.h) times length
 * of the cycle. The ratio of L_d and L_q is kept.
 *
 * Without a countermeasure i_q would swing: a wrong R or L makes the estimated angle oscillate with the
 * dither, the estimated speed oscillates as well, and the speed control responds. Each cycle measures this
 * swing in step with the wave and a quarter of a cycle ahead (c), and the next cycle opposes it.
 *
 * A rotor on an elastic shaft may swing with i_d nevertheless, because a wrong L turns a part of i_d into
 * torque. Its EMF p, per ampere in step with i_d, adds p to e_q, and omega/W p to e_d a quarter of a cycle
 * ahead, where W is the frequency of the dither. From INDUCTANCE_APART W on dL is computed from both axes,
 * without p (docs/theory.md, 24).
 *
 * Components that are not in step average out, constants exactly; a low-pass is subtracted from all of them
 * to remove slow changes. The wave consists of parabolas, s = 4 t (1 - |t|) for t from -1 to 1: a sine with a
 * third harmonic of 1/27. Its frequency is one of three. It is never near one, two, five, six or seven times
 * the electrical one, because errors of the current sensors, the dead time, and both together make e_q and
 * i_d swing at these frequencies (docs/theory.md, 24).
 *
 * A cycle has a result only if throughout the cycle the samples were sound, the loop was locked, the speed
 * was constant, i_d followed its command and swung beside it by less than the dither, and the EMF was
 * present, and if the resulting L is plausible. The result is used only if it agrees with the one before, and
 * while most results agree. Where no result is possible, at low speed or without torque, there is no dither.
 * The same applies where the response omega L i_d is so small that errors of the dead time exceed it, as with
 * a motor of 0.1 mH, or where i_q is smaller than the change of the current by the EMF in T, at less than
 * INDUCTANCE_RIPPLE_TURN: the signs of the phase currents then change within T. Where a step is a third of a
 * turn within INDUCTANCE_REPEATS, its samples repeat their angles, and there is no dither either.
 *
 * The voltage omega L i_d of the dither falls with the speed, and the errors of the EMF do not: what is left
 * of its harmonics, and the dead time. Below INDUCTANCE_SLOW the amplitude therefore grows with the
 * reciprocal of the speed, up to INDUCTANCE_SLOW_MOST and to 1/INDUCTANCE_TORQUE of i_q. A light rotor, which
 * the dither would set swinging, and a salient rotor, whose law is linear in the dither, keep their
 * amplitude. Up to four divisions at the beginning of a cycle.
 *
 * The dither is audible and adds half a per cent to the copper loss. It therefore pauses when nothing more is
 * to be learnt: the first learning interval lasts until the rate has fallen to INDUCTANCE_LOOKED of the
 * initial one, and then an interval of INDUCTANCE_LOOK follows each pause of INDUCTANCE_REST, which is less
 * than a twentieth of the time. A pause ends early if i_q has changed by INDUCTANCE_MOVED of the dither,
 * because the saturation of the iron changes then; there is no pause while R is learnt. The learnt value and
 * its confidence are held during a pause. An interval also ends if its cycles give no value, because the
 * shaft is not steady or the results contradict each other, as they do if the dither moves the angle of a
 * light rotor. If the confidence is small when an interval ends without a value, the learnt value
 * returns to the last one that had confidence.
 *
 * One step in every `every` periods of T, from the means over these. The means of a step are compared with
 * the dither of the previous step. If the dither acts later than that, it is output earlier by the
 * difference. Up to nine divisions at the end of a cycle.
 *
 * The e_q of a salient rotor does not show L_q, because an angle error changes it, too. Its dither keeps the
 * torque, di_q = t di_d with t = D i_q/psi_a, and the angle shows L_q: the angle of the loop and the part
 * that remains in e_d, without the voltage of the flux that the loop's own motion changes (docs/theory.md,
 * 24),
 *
 *     e_d - psi_a (omega turned + t d(turned)/dt), per ampere in step: 2 omega t (assumed - true L_q)
 *
 * If the q axis saturates, the whole curve psi_q(i_q) has one unknown factor, and the same law has psi_t in
 * place of psi_a and another factor G (docs/theory.md, 24). L_q is then the one without current.
 *
 * L_d then stays, and R is not learnt. Above L_q = 1.1 L_d without `salient_too`, and up to 1.5 L_d, the rate
 * is 0; so it is for a round rotor that saturates. Two divisions in a cycle instead of those of the round
 * rotor. */
#ifndef MEDIUM_ADAPT_INDUCTANCE_H
#define MEDIUM_ADAPT_INDUCTANCE_H

#include <stdbool.h>
#include <stdint.h>

#include "math/bounds.h"
#include "math/filter.h"
#include "math/frames.h"
#include "medium/adapt/assumed.h"

#define INDUCTANCE_DITHER        0.05f /* [-] of the current limit: about a tenth of the rated current */
#define INDUCTANCE_NOISE         5.0f  /* [-] of the sensors' noise: the dither is at least this ... */
#define INDUCTANCE_DITHER_MOST   0.15f /* [-] ... up to this share of the current limit */
#define INDUCTANCE_TORQUE        3.0f  /* [-] of the dither: least i_q */
#define INDUCTANCE_SLOW          80.0f /* [rad/s] electrical: below it the dither grows as the speed falls ... */
#define INDUCTANCE_SLOW_MOST     2.0f  /* [-] ... up to this factor */
#define INDUCTANCE_FREQUENCY_1   33.0f /* [Hz] */
#define INDUCTANCE_FREQUENCY_2   43.0f /* [Hz] if the first is too near */
#define INDUCTANCE_FREQUENCY_3   57.0f /* [Hz] if the second is too near as well */
#define INDUCTANCE_FREQUENCIES   3u
#define INDUCTANCE_NEAR          4.0f   /* [Hz] */
#define INDUCTANCE_NEAR_SIXTH    6.5f   /* [Hz] distance to six times the electrical one, under torque */
#define INDUCTANCE_SPEED_MIN     30.0f  /* [rad/s] electrical */
#define INDUCTANCE_EMF           0.1f   /* [V] least omega L times the dither, ten errors of the voltage */
#define INDUCTANCE_R_SPEED_MAX   100.0f /* [rad/s] up to which R is learnt: the dead time is known there */
#define INDUCTANCE_SPEED_DRIFT   0.03f  /* [-] of the speed over a cycle: a larger drift is not steady */
#define INDUCTANCE_R_SPEED_DRIFT 0.01f  /* [-] the same without torque and for R */
#define INDUCTANCE_APART         2.0f /* [-] of the dither's frequency: speed from which its swing is eliminated */
#define INDUCTANCE_DETECTOR_MAX  0.1f        /* [-] */
#define INDUCTANCE_CUTOFF        100.0f      /* [rad/s] of the low-pass that is subtracted */
#define INDUCTANCE_MIN           0.5f        /* [-] of the parameter, also for R */
#define INDUCTANCE_MAX           2.0f        /* [-] of the parameter, also for R */
#define INDUCTANCE_AGREES        0.2f        /* [-] of L: two cycles agree within this */
#define INDUCTANCE_LOOKED        0.2f        /* [-] of the initial rate, at which the first interval ends */
#define INDUCTANCE_LOOK          1.0f        /* [s] time of cycles with a result in each later interval */
#define INDUCTANCE_REST          20.0f       /* [s] pause between two intervals */
#define INDUCTANCE_MISSED        UINT32_C(2) /* [-] of INDUCTANCE_LOOK: cycles without a value, less others */
#define INDUCTANCE_MOVED         5.0f        /* [-] of the dither: change of i_q that ends a pause */
#define INDUCTANCE_SALIENT_MAX   1.10001f /* [-] L_q/L_d: 1.1 and its rounding; above, the rotor is salient */
#define INDUCTANCE_SALIENT_LEAST 1.5f     /* [-] L_q/L_d of a salient rotor from which L_q is learnt */
#define INDUCTANCE_SALIENT_MIN   0.75f    /* [-] of the parameter, of a salient rotor, which stays one */

/* Bits of `marks`: all samples of the cycle were sound; the voltage was known when it began. */
#define INDUCTANCE_SOUND UINT32_C(1)
#define INDUCTANCE_KNOWN UINT32_C(2)

typedef struct {
    float inductance_d;    /* assumed L_d [H], above 0 */
    float inductance_q;    /* assumed L_q without saturation [H], above 0 */
    float observed_q;      /* constant L_q of the observer [H]: of the same curve */
    float saturation;      /* I_s of the q axis [A]; 0: it does not saturate */
    float from;            /* L_q of the parameters [H], above 0 */
    float resistance;      /* assumed R [ohm], above 0 */
    float resistance_from; /* R of the parameters [ohm], above 0 */
    float flux_linkage;    /* psi_f [Wb] */
    float current_max;     /* limit of i_q [A] */
    float acceleration;    /* of the rotor by i_q = 1 A [rad/s^2], electrical; 0: it turns evenly */
    float noise;           /* of a measured current, standard deviation [A]; 0 where it does not matter */
    float rate;            /* initial rate [1/s], 0..20; 0 = off */
    float period;          /* T [s] */
    uint32_t every;        /* [periods] from one step to the next, at least 1 */
    uint32_t ahead;        /* [steps] delay of the dither, beyond the next step */
    bool salient;          /* by the parameters: the dither keeps the torque, and L_d stays */
    bool salient_too;      /* L_q of a salient rotor is learnt */
} inductance_params_t;

/* A frequency of the dither: a cycle consists of whole periods. */
typedef struct {
    uint32_t steps; /* [-] in a cycle, each of `every` periods */
    float step;     /* advance of the wave's t per step [-] */
    float per_sum;  /* amplitude of a current, after the low-pass, divided by its sum with s in a cycle [-] */
} inductance_wave_t;

typedef struct {
    inductance_wave_t wave[INDUCTANCE_FREQUENCIES];
    float rate;            /* initial rate [1/s]; 0 = off, and for a salient rotor */
    float from;            /* L_q of the parameters [H] */
    float inductance_q;    /* assumed L_q, without saturation [H] */
    float knee;            /* 1/I_s^2 [1/A^2]; 0: no saturation */
    float observed_q;      /* constant L_q of the observer [H] */
    float inductance_d;    /* assumed L_d [H] */
    float ratio;           /* L_q/L_d of a round rotor; 0: the rotor is salient [-] */
    float resistance;      /* R that the observer uses [ohm] */
    float resistance_from; /* R of the parameters [ohm] */
    float flux_linkage;    /* psi_f [Wb] */
    float current;         /* amplitude of the dither at INDUCTANCE_SLOW and above [A] */
    float slow_most;       /* its largest factor below, 1 to INDUCTANCE_SLOW_MOST [-] */
    float ripple;          /* change of the current by the EMF in T, over the speed [A s] */
    uint32_t look;         /* [steps] INDUCTANCE_LOOK */
    uint32_t rest;         /* [steps] INDUCTANCE_REST */
    float mean_share;      /* share of the low-pass that is subtracted [-] */
    float time;            /* from one step to the next [s] */
    float ahead;           /* [steps] delay of the dither, beyond the next step */
} inductance_tuning_t;

/* Learning intervals and pauses. */
typedef struct {
    uint32_t looked; /* steps of the present interval's cycles with a result [-] */
    uint32_t missed; /* steps of cycles without a value, less those with one, since the last pause [-] */
    uint32_t failed; /* [-] 1: the last interval ended because most of its cycles had no value */
    uint32_t rests;  /* remaining steps of a pause [-]; 0: an interval is active */
    float looked_at; /* i_q of the last interval [A] */
    float kept;      /* last L_q with enough confidence, or the parameter [H] */
} inductance_look_t;

/* Sums over a cycle, s being the wave and c the same a quarter of a cycle ahead. */
typedef struct {
    float detector; /* sum(|detector|) [-] */
    float drop;     /* sum((e_d - mean - psi_f omega turned) s) [V] */
    float emf;      /* sum((e_q - mean) s) [V] */
    float emf_c;    /* the same with c [V] */
    float answer;   /* sum((i_d - mean) s) [A] */
    float drop_c;   /* the sum of `drop` with c [V] */
    float answer_c; /* sum((i_d - mean) c) [A] */
    float square;   /* sum((i_d - mean)^2) [A^2] */
} inductance_sums_t;

/* The components of i_q in step with the wave and a quarter of a cycle ahead, and the current that opposes
 * both in the next cycle. */
typedef struct {
    float s;         /* sum((i_q - mean) s) [A] */
    float c;         /* sum((i_q - mean) c) [A] */
    float against_s; /* i_q against that swing, in step [A] */
    float against_c; /* the same, a quarter of a cycle ahead [A] */
    float i_d;       /* i_d of the last step, its mean subtracted [A] */
    uint32_t vain;   /* cycles in succession whose opposition has not reduced the swing [-] */
    uint32_t from;   /* index of the first frequency that has not been a resonance of the shaft [-] */
} inductance_swing_t;

typedef struct {
    inductance_tuning_t tuning;
    learnt_value_t learnt;     /* L_q [H] */
    learnt_value_t resistance; /* R [ohm] */
    float rate;                /* present rate of L [1/s] */
    float resistance_rate;     /* present rate of R [1/s] */
    float confidence;          /* share of the last cycles that agreed with the one before them [-] */
    float said;                /* result of the last cycle [H] */
    inductance_look_t look;
    /* of the cycle */
    uint32_t left;         /* remaining steps [-]; 0: no cycle */
    uint32_t marks;        /* [-] bits: the samples were sound, the voltage was known */
    uint32_t follows;      /* [-] 1: the cycle before was sound: the low-passes continue */
    uint32_t which;        /* [-] index of its frequency */
    float t;               /* position in the wave [-], -1..1 */
    float current;         /* amplitude of its dither [A] */
    float omega;           /* at the beginning [rad/s] */
    float theta;           /* at the last step [rad] */
    float turned;          /* high-pass of the loop's angle [rad] */
    float flux;            /* change of the flux along q per angle of the loop, at the beginning [Wb] */
    float along;           /* t: i_q of the dither over its i_d at constant torque [-] */
    dq_t emf_mean;         /* low-pass of the EMF [V] */
    dq_t mean;             /* low-pass of the current [A] */
    inductance_sums_t sum; /* of the cycle */
    inductance_swing_t swing;
    dq_t dither; /* to be added to the references until the next step [A] */
} inductance_t;

/* The means over the periods since the last step. */
typedef struct {
    dq_t emf;           /* mean in the rotor's frame, with the lag compensated [V] */
    dq_t current;       /* mean in the rotor's frame [A] */
    float detector;     /* present value [-] */
    float omega_smooth; /* present value [rad/s] electrical */
    float theta;        /* present angle of the rotor's frame [rad] */
    float flux;         /* psi_a of the loop [Wb] */
    bool sound;         /* all samples and estimates are valid */
    bool voltage_known; /* the dead time is learnt: a missing voltage along d comes from R */
} inductance_input_t;

/* Computes the coefficients. Divisions and an exponential: for the background. */
inductance_tuning_t inductance_prepare(const inductance_params_t *params);

/* Takes these coefficients; nothing is learnt, the rate is the initial one. */
void inductance_init(inductance_t *x, const inductance_tuning_t *tuning);

/* Takes over the coefficients. The learnt value is kept while the parameter from which it started is
 * unchanged and learning is on; otherwise learning restarts from the parameter. */
void inductance_take(inductance_t *x, const inductance_tuning_t *tuning);

/* The loop may not be judged: the cycle is discarded, and so is a value whose few cycles have not given it
 * enough confidence yet. */
static inline void inductance_rest(inductance_t *x)
{
    x->learnt.value = x->look.kept;
    x->left = 0u;
    x->follows = 0u;
    x->confidence = 0.0f;
    x->said = 0.0f;
    x->swing.against_s = 0.0f;
    x->swing.against_c = 0.0f;
    x->dither = (dq_t){0.0f, 0.0f};
}

/* One step of the wave. The caller calls it once in `every` periods while the loop is locked. */
void inductance_step(inductance_t *x, const inductance_input_t *input);

#endif
