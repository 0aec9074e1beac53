/* The effective dead time of the legs, learnt from the EMF while the motor turns slowly.
 *
 * A leg loses V = T_e/T u_dc + drop with the sign of its current (fast/inverter/dead_time.h). If V_hat is
 * assumed instead, the observer's EMF contains the difference,
 *
 *     e = e_rotor + (V - V_hat) r,     r: the three signs as a vector
 *
 * Along the current r is nearly constant, like the effect of resistance or flux;
 * across the current it is a sawtooth:
 *
 *     r ~ (4/pi) u (1 + j q),   q = -12/35 sin 6 phi + 24/143 sin 12 phi,   u = e^(j phi) along the current
 *
 * The sixth harmonic of q may also come from the fifth and seventh harmonics of the EMF
 * (emf_shape.h); the twelfth comes from the switching edges alone. The EMF across the current,
 * without its mean, is therefore correlated with the twelfth harmonic. The weight of a step is the
 * mean of 1 and the ratio of the angles by which u and the reference have turned, because an
 * overcompensated current dwells between its zero crossings:
 *
 *     m(x) = low-pass of x at |omega_ref| in a frame that turns with the reference, which has no ripple
 *     m(e) = omega_ref m(e/omega_ref), because the EMF grows with the speed while the frame accelerates
 *     d(T_e/T)/dt = g/((4/pi) <q s>) [u x (e - m(e))] s w/u_dc
 *     s = sin 12 phi,   w = 1/2 + dphi/(2 dphi_ref)
 *
 * V_hat then follows V with the rate g (medium/adapt/gain.h; docs/theory.md, 25). The learnt value is used
 * if it differs from the parameters by more than chance can explain. Below this threshold its weight falls
 * with the fourth power of the difference. Part of the threshold falls with g. The rest is the variance of
 * the learnt value by the noise of the current sensors, which acts like the voltage 12 omega L s, and by a
 * swing of the current in a forced frame, which shows a part of the shape of the EMF as its twelfth harmonic.
 * The value that is compared is a low-pass of the learnt one with 2 |omega_ref|, because a slow EMF across
 * the current, from a rotor that swings, moves the learnt value at the twelfth harmonic. The learnt value
 * that is used is the nearest to the parameters that differs from this one by no more than a wrong L may have
 * changed it. Another model of the observer shows another EMF of the same rotor: the means begin again.
 *
 * The law does not need the rotor's angle: it also learns in a forced frame and while the estimate
 * is lost. The learnt quantity is a time, because the unknown part is delays; the voltage then follows the
 * link. An error of the drop is learnt as if it were time.
 *
 * A component across the current that exceeds the whole dead band's voltage is ignored. If the component that
 * rotates against the current exceeds the effect of unequal legs, the current measurement is wrong and
 * nothing is learnt. Learning has further conditions; otherwise the value is held. The EMF of the speed is
 * not small compared with the dead band's voltage, and not so large that a sample contains only noise. A step
 * is short enough for the twelfth harmonic. The current is outside of the zone, large compared with its
 * ripple and with the noise of its sensors, and turns with the reference. Its mean square counts: the length
 * of a current near the limit exceeds it in some parts of a turn only, and the mean over these is not the one
 * over phi. The speed is near its reference.
 *
 * One step in every `every` periods of T, from the means over these. The deviation of each step
 * from the mean is provided for emf_shape.h and unequal_legs.h. Does not handle: eleventh and
 * thirteenth harmonics of the EMF. */
#ifndef MEDIUM_ADAPT_DEAD_TIME_LEARN_H
#define MEDIUM_ADAPT_DEAD_TIME_LEARN_H

#include <stdbool.h>
#include <stdint.h>

#include "math/frames.h"

#define DEAD_TIME_LEARN_EMF_MIN   0.45f /* [-] least EMF of the speed over the dead band's voltage */
#define DEAD_TIME_LEARN_EMF_FULL  0.85f /* [-] below this ratio learning is slower, by the square */
#define DEAD_TIME_LEARN_EMF_MAX   3.3f  /* [-] largest EMF of the speed over the same */
#define DEAD_TIME_LEARN_TURN      2.0f  /* [rad] largest turn of the twelfth harmonic from step to step */
#define DEAD_TIME_LEARN_MISS      0.35f /* [-] largest missing EMF of the speed over the same */
#define DEAD_TIME_LEARN_EMF_LEAST 0.02f /* [-] least EMF of a step over that of the speed */
#define DEAD_TIME_LEARN_ZONES     7.0f  /* [-] least current over the zone */
#define DEAD_TIME_LEARN_SWINGS    4.0f  /* [-] least current over the change that the EMF alone makes in T */
#define DEAD_TIME_LEARN_NOISES    2000.0f /* [-] least square of the current over that of a sensor's noise */
#define DEAD_TIME_LEARN_STEADY    0.8f    /* [-] least square of the mean direction of the current */
#define DEAD_TIME_LEARN_AGAINST   0.127f  /* [-] largest EMF against the current over that voltage */
#define DEAD_TIME_LEARN_RANGE                                                                                \
    1.7f /* [-] largest T_e over the dead band or the configured T_e; gate delays are below */
#define DEAD_TIME_LEARN_EMF_LIMIT 1e4f /* [V], [A] larger values are invalid measurements */

/* [-] of the initial rate: below this share the dead time counts as known, also for the laws that are learnt
 * together with it. */
#define DEAD_TIME_LEARN_SETTLED 0.2f
#define DEAD_TIME_LEARN_NEAR    0.6f
#define DEAD_TIME_LEARN_RIPPLE  0.075f /* [-] of the dead band: effect of a wrong L at the largest ripple */
/* [-] of the dead band: effect at the initial rate of chance other than the noise of the sensors */
#define DEAD_TIME_LEARN_CHANCE 0.08f

typedef struct {
    float rate;         /* initial rate [1/s]; 0: off */
    float effective;    /* T_e/T of the parameters [-] */
    float band;         /* dead band over T, which the hardware applies exactly [-] */
    float flux_linkage; /* psi_f [Wb] */
    float zone;         /* half width of the zone around zero current [A] */
    float inductance;   /* L [H]; 0: the ripple is not considered */
    float period;       /* T [s] */
    uint32_t every;     /* [periods] from one step to the next, at least 1 */
} dead_time_learn_params_t;

typedef struct {
    float rate;             /* initial rate [1/s]; 0: off */
    float per_rate;         /* 1/rate [s] */
    float effective;        /* T_e/T of the parameters [-] */
    float least, most;      /* limits of the learnt value [-] */
    float band;             /* [-] */
    float per_band;         /* psi_f over `band` [Wb] */
    float flux_linkage;     /* [Wb] */
    float current_square;   /* least |i|^2 [A^2] */
    float swing;            /* least |i| over the EMF of the speed [A/V] */
    float reactance_square; /* variance of the result of a step per square of omega s/u_dc [ohm^2 s^2] */
    float period;           /* from one step to the next [s] */
} dead_time_learn_tuning_t;

typedef struct {
    dead_time_learn_tuning_t tuning;
    float effective; /* T_e/T in use [-] */
    float learnt;    /* T_e/T as learnt [-] */
    float smooth;    /* low-pass of `learnt` [-] */
    float variance;  /* of `learnt` by the noise of the sensors and its swing [-] */
    uint32_t model;  /* of the observer in the last step [-] */
    float rate;      /* present rate [1/s] */
    float ripple; /* [-] mean of (DEAD_TIME_LEARN_SWINGS e T/(L |i|))^2 of the steps that `learnt` contains */
    uint32_t begun;  /* [-] 1: the following values belong to the last periods */
    ab_t emf_mean;   /* m(e) [V] */
    float omega_ref; /* of the last step [rad/s] */
    ab_t along_mean; /* m(u) [-] */
    float square;    /* low-pass of |i|^2 [A^2] */
    ab_t along;      /* u of the last step [-] */
    ab_t rest;       /* e - m(e) of the last step [V] */
    ab_t against;    /* component that turns against the current: low-pass of (e - m(e)) u [V] */
    float seen;      /* [s] time with which this step counts; 0: it is not used */
} dead_time_learn_t;

/* The means over the periods since the last step. */
typedef struct {
    ab_t emf;          /* mean, with the observer's lag compensated [V] */
    ab_t current;      /* mean [A] */
    float omega_e;     /* estimated speed of the rotor, smoothed [rad/s], electrical */
    float omega_e_ref; /* its reference [rad/s], electrical, finite */
    float link;        /* mean of the last period [V] */
    float noise;       /* mean square of the noise of a current sensor [A^2] */
    uint32_t model;    /* [-] a number of the observer's model of the rotor: another one has another EMF */
    bool forced;       /* the frame is forced: its damping turns the current while the rotor swings */
} dead_time_learn_input_t;

/* Computes the coefficients. Two divisions. */
dead_time_learn_tuning_t dead_time_learn_prepare(const dead_time_learn_params_t *params);

/* Takes over new coefficients. The learnt value is kept while learning is on and the parameters are
 * unchanged; otherwise learning restarts from the parameters with the initial rate. */
void dead_time_learn_take(dead_time_learn_t *learn, const dead_time_learn_tuning_t *tuning);

/* Separates the next step from the last one. */
static inline void dead_time_learn_pause(dead_time_learn_t *learn)
{
    learn->begun = 0u;
    learn->seen = 0.0f;
}

/* True if the dead time is known: it has been learnt, or learning is off. */
static inline bool dead_time_learn_is_settled(const dead_time_learn_t *learn)
{
    return learn->rate <= DEAD_TIME_LEARN_SETTLED * learn->tuning.rate;
}

/* True if the dead time is accurate enough to use the remaining EMF for the shape. */
static inline bool dead_time_learn_is_near(const dead_time_learn_t *learn)
{
    return learn->rate <= DEAD_TIME_LEARN_NEAR * learn->tuning.rate;
}

/* One step in every `every` periods, from the means since the last one. A constant current, invalid numbers
 * and a missing EMF are not used. No division. */
void dead_time_learn_step(dead_time_learn_t *learn, const dead_time_learn_input_t *input);

#endif
