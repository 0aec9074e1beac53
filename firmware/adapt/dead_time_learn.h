/* The effective dead time of the legs, learnt from the EMF while the motor turns slowly.
 *
 * A leg loses V = T_e/T u_dc + drop with the sign of its current (inverter/dead_time.h). Where V_hat is
 * believed instead, the observer's EMF carries the rest,
 *
 *     e = e_rotor + (V - V_hat) r,     r: the three signs as a vector
 *
 * Along the current r hardly changes, which looks like resistance or flux; across it, it is a sawtooth that
 * looks like nothing else:
 *
 *     r ~ (4/pi) u (1 + j q),   q = -12/35 sin 6 phi + 24/143 sin 12 phi,   u = e^(j phi) along the current
 *
 * The fifth and seventh harmonic of the rotor's own EMF (adapt/emf_shape.h) make a ripple there too. It is a
 * sine without edges, and grows with the speed; V does neither. So V and the shape are regressed together,
 *
 *     m(x) = low-pass of x at |omega_ref| in a frame that turns with the reference, which has no ripple
 *     n    = direction of m(e), which is that of the rotor's EMF
 *     y    = m(u) x (e - m(e))
 *          = m(u) x [(V - V_hat) (r - m(r)) + psi_f |omega| n (j a_d sin 6 theta + a_q cos 6 theta)]
 *
 *     d(x_hat)/dt = w P f (y - y_hat),   dP/dt = -w P f f' P/6 + drift,   f: what a unit of each x makes of y
 *
 * with x = (T_e/T, a_d, a_q): adapt/gain.h for three values. w = 1 - sin^16 3 phi lets nothing count near a
 * sawtooth's edge, where a current crosses zero. At first V follows with the rate g, whatever the ripple is;
 * what of it was a shape is told apart more slowly (docs/theory.md, 25). Nothing in it needs the rotor's
 * estimated angle: it learns in a forced frame as well, and when the estimate is lost. What is learnt is a
 * time, for it is delays that nobody knows; the voltage then follows the link. An error of the drop is learnt
 * as if it were time.
 *
 * What is more across the current than the whole dead band's voltage is not it. It learns while the EMF of
 * the speed is neither small beside the dead band's voltage, nor large, while the current is well outside of
 * the zone and turns with the reference, and while speed and reference are together; else the values stay.
 *
 * One step in every so-manieth T, from the means of these. Does not handle: differences between the legs;
 * harmonics of the EMF from the eleventh on. */
#ifndef ADAPT_DEAD_TIME_LEARN_H
#define ADAPT_DEAD_TIME_LEARN_H

#include <stdbool.h>
#include <stdint.h>

#include "math/frames.h"

#define DEAD_TIME_LEARN_EMF_MIN   0.45f /* [-] EMF of the speed over the dead band's voltage, at least ... */
#define DEAD_TIME_LEARN_EMF_FULL  0.85f /* [-] below this EMF it is slower, by the square */
#define DEAD_TIME_LEARN_EMF_MAX   2.2f  /* [-] ... and at most */
#define DEAD_TIME_LEARN_MISS      0.35f /* [-] EMF of the speed that is missing over the same, at most */
#define DEAD_TIME_LEARN_EMF_LEAST 0.02f /* [-] EMF of a period over that of the speed, at least */
#define DEAD_TIME_LEARN_ZONES     7.0f  /* [-] current over the zone, at least */
#define DEAD_TIME_LEARN_STEADY    0.8f  /* [-] square of the mean direction of the current, at least */
#define DEAD_TIME_LEARN_RANGE                                                                                \
    1.7f /* [-] T_e over dead band or T_e of the parameters, at most: gates delay it by less */
#define DEAD_TIME_LEARN_EMF_LIMIT 1e4f /* [V], [A] what is longer is no measurement */

/* [-] of the rate it began with: so slow, it has seen enough. */
#define DEAD_TIME_LEARN_SETTLED 0.3f

#define DEAD_TIME_LEARN_SHAPE_MAX 0.2f /* [-] sixth harmonic of an axis over the EMF, at most */

/* How much is not known yet of the dead time (t) and of the shape's axes (d, q), and of each two together:
 * what is seen of an error is followed at this rate, in dead bands and in EMFs of the speed [1/s]. */
typedef struct {
    float tt, td, tq, dd, dq, qq;
} dead_time_learn_spread_t;

/* What a step has shown, all in dead bands [-]; `time` and `weight` that it counts for [s], 0: nothing. */
typedef struct {
    float seen;    /* across the current */
    float of_time; /* of it by a dead time that is a band too small */
    float of_d;    /* of it by a shape of 1 in the d axis */
    float of_q;    /* of it by a shape of 1 in the q axis */
    ab_t rotor;    /* direction of the rotor's EMF, seen from the current [-] */
    float due;     /* EMF of the speed */
    float shrink;  /* of the spread of a shape: 1, or one over the square of that EMF */
    float time, weight;
} dead_time_learn_look_t;

typedef struct {
    float rate;         /* at which it begins [1/s]; 0: off */
    float effective;    /* T_e/T of the parameters [-] */
    float band;         /* dead band over T, which the hardware keeps exactly [-] */
    float flux_linkage; /* psi_f [Wb] */
    float zone;         /* half width of the zone around zero current [A] */
    bool
        shaped; /* is the EMF's shape learnt beside? Not of a rotor that swings with a ripple of its torque */
    float period;   /* T [s] */
    uint32_t every; /* [periods] from one step to the next, at least 1 */
} dead_time_learn_params_t;

typedef struct {
    float rate;           /* at which it begins [1/s]; 0: off */
    float effective;      /* T_e/T of the parameters [-] */
    float least, most;    /* limits of what is learnt [-] */
    float band;           /* [-] */
    float per_band;       /* one over it [-] */
    float flux_linkage;   /* [Wb] */
    float current_square; /* least |i|^2 [A^2] */
    float period;         /* from one step to the next [s] */
    float time;           /* spread of the dead time with which it begins [1/s] */
    float shape;          /* likewise of a shape, where the EMF is a dead band's voltage [1/s] */
    float time_drift;     /* by which that of the dead time grows [1/s^2] */
    float shape_drift;    /* likewise that of a shape [1/s^2] */
} dead_time_learn_tuning_t;

typedef struct {
    dead_time_learn_tuning_t tuning;
    float effective; /* T_e/T as learnt [-] */
    dq_t shape;      /* sixth harmonic of e_d and e_q over the EMF (adapt/emf_shape.h) [-] */
    uint32_t fresh;  /* [-] 1: nothing has been seen since the spread was that of the tuning */
    dead_time_learn_spread_t spread;
    dead_time_learn_look_t look; /* of the last step */
    uint32_t begun;              /* [-] 1: what follows is of the last periods */
    ab_t emf_mean;               /* m(e) [V] */
    ab_t signs_mean;             /* m(r) [-] */
    ab_t current;                /* of the last step [A] */
    uint32_t moved;              /* [-] 1: it is not the one before */
} dead_time_learn_t;

/* What the periods since the last step bring. */
typedef struct {
    ab_t emf;          /* mean, lag undone [V] */
    ab_t current;      /* mean [A] */
    float omega_e;     /* of the rotor, estimated, smooth [rad/s], electrical */
    float omega_e_ref; /* its reference [rad/s], electrical, finite */
    float link;        /* mean of the last period [V] */
} dead_time_learn_input_t;

/* Coefficients. Two divisions. */
dead_time_learn_tuning_t dead_time_learn_prepare(const dead_time_learn_params_t *params);

/* These coefficients. What is learnt stays while the parameters say the same and it is on; else it starts
 * from them again, with the first rate. */
void dead_time_learn_take(dead_time_learn_t *learn, const dead_time_learn_tuning_t *tuning);

/* The next step does not go on from the last one. */
static inline void dead_time_learn_pause(dead_time_learn_t *learn)
{
    learn->begun = 0u;
    learn->look.time = 0.0f;
}

/* Is the dead time known, by what was learnt or because nothing is to be learnt of it? */
static inline bool dead_time_learn_is_settled(const dead_time_learn_t *learn)
{
    return learn->fresh == 0u && learn->spread.tt <= DEAD_TIME_LEARN_SETTLED * learn->tuning.time;
}

/* In every so-manieth period, as the tuning says: what the means since the last one teach. A current that
 * stands still, and what is no number or no EMF, teach nothing. No division. */
void dead_time_learn_step(dead_time_learn_t *learn, const dead_time_learn_input_t *input);

/* Once after it: dead time and shape follow what it has shown, while the share `left` [-] of the shape of
 * the d axis was still in the EMF. No division. */
void dead_time_learn_follow(dead_time_learn_t *learn, float left);

#endif
