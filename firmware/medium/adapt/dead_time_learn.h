/* The effective dead time of the legs, learnt from the EMF while the motor turns slowly.
 *
 * A leg loses V = T_e/T u_dc + drop with the sign of its current (fast/inverter/dead_time.h). Where V_hat is
 * believed instead, the observer's EMF carries the rest,
 *
 *     e = e_rotor + (V - V_hat) r,     r: the three signs as a vector
 *
 * Along the current r hardly changes, which resembles resistance or flux; across it, it is a sawtooth:
 *
 *     r ~ (4/pi) u (1 + j q),   q = -12/35 sin 6 phi + 24/143 sin 12 phi,   u = e^(j phi) along the current
 *
 * Its sixth harmonic may be that of the EMF's fifth and seventh (emf_shape.h), its twelfth is the edges'
 * alone. So what the EMF has across the current, without its mean, is correlated with that line, each step
 * counting by half of the way of u over that of the reference, for a current that is compensated too much
 * dwells between its zero crossings:
 *
 *     m(x) = low-pass of x at |omega_ref| in a frame that turns with the reference, which has no ripple
 *     d(T_e/T)/dt = g/((4/pi) <q s>) [u x (e - m(e))] s w/u_dc,   s = sin 12 phi,   w = 1/2 + dphi/(2
 * dphi_ref)
 *
 * whereby V_hat follows V with the rate g (medium/adapt/gain.h; docs/theory.md, 25). It is used once it
 * differs from the parameters by more than noise makes of it, which falls with the square root of g. Nothing
 * in it needs the rotor's angle: it learns in a forced frame as well, and when the estimate is lost. What is
 * learnt is a time, for it is delays that nobody knows; the voltage then follows the link. An error of the
 * drop is learnt as if it were time.
 *
 * What is more across the current than the whole dead band's voltage is not it, and while there is more
 * against the current than legs that differ make, the currents are not what the sensors say. It learns while
 * the EMF of the speed is neither small beside the dead band's voltage, nor large, where noise is all that is
 * left of a sample, while a step is short enough to follow the twelfth harmonic, while the current is well
 * outside of the zone and turns with the reference, and while speed and reference are together; else the
 * value stays.
 *
 * One step in every so-manieth T, from the means of these. What each has seen beside the mean is there for
 * emf_shape.h and unequal_legs.h. Does not handle: eleventh and thirteenth harmonics of the EMF. */
#ifndef MEDIUM_ADAPT_DEAD_TIME_LEARN_H
#define MEDIUM_ADAPT_DEAD_TIME_LEARN_H

#include <stdbool.h>
#include <stdint.h>

#include "math/frames.h"

#define DEAD_TIME_LEARN_EMF_MIN   0.45f /* [-] EMF of the speed over the dead band's voltage, at least ... */
#define DEAD_TIME_LEARN_EMF_FULL  0.85f /* [-] below this EMF it is slower, by the square */
#define DEAD_TIME_LEARN_EMF_MAX   3.3f  /* [-] ... and at most */
#define DEAD_TIME_LEARN_TURN      2.0f /* [rad] of twelve times the angle, from one step to the next, at most */
#define DEAD_TIME_LEARN_MISS      0.35f /* [-] EMF of the speed that is missing over the same, at most */
#define DEAD_TIME_LEARN_EMF_LEAST 0.02f /* [-] EMF of a period over that of the speed, at least */
#define DEAD_TIME_LEARN_ZONES     7.0f  /* [-] current over the zone, at least */
#define DEAD_TIME_LEARN_STEADY    0.8f  /* [-] square of the mean direction of the current, at least */
#define DEAD_TIME_LEARN_AGAINST                                                                              \
    0.127f /* [-] EMF against the current over the dead band's voltage, at most                              \
            */
#define DEAD_TIME_LEARN_RANGE                                                                                \
    1.7f /* [-] T_e over dead band or T_e of the parameters, at most: gates delay it by less */
#define DEAD_TIME_LEARN_EMF_LIMIT 1e4f /* [V], [A] what is longer is no measurement */

/* [-] of the rate it began with: so slow, it has seen enough, and enough for what is learnt beside it. */
#define DEAD_TIME_LEARN_SETTLED 0.2f
#define DEAD_TIME_LEARN_NEAR    0.6f
#define DEAD_TIME_LEARN_CHANCE                                                                               \
    0.028f /* [-] of the dead band, that noise may make of it at the first rate                              \
            */

typedef struct {
    float rate;         /* at which it begins [1/s]; 0: off */
    float effective;    /* T_e/T of the parameters [-] */
    float band;         /* dead band over T, which the hardware keeps exactly [-] */
    float flux_linkage; /* psi_f [Wb] */
    float zone;         /* half width of the zone around zero current [A] */
    float period;       /* T [s] */
    uint32_t every;     /* [periods] from one step to the next, at least 1 */
} dead_time_learn_params_t;

typedef struct {
    float rate;           /* at which it begins [1/s]; 0: off */
    float per_rate;       /* one over it [s] */
    float effective;      /* T_e/T of the parameters [-] */
    float least, most;    /* limits of what is learnt [-] */
    float band;           /* [-] */
    float per_band;       /* psi_f over it [Wb] */
    float flux_linkage;   /* [Wb] */
    float current_square; /* least |i|^2 [A^2] */
    float period;         /* from one step to the next [s] */
} dead_time_learn_tuning_t;

typedef struct {
    dead_time_learn_tuning_t tuning;
    float effective; /* T_e/T as used [-] */
    float learnt;    /* likewise as seen [-] */
    float rate;      /* at which it learns now [1/s] */
    uint32_t begun;  /* [-] 1: what follows is of the last periods */
    ab_t emf_mean;   /* m(e) [V] */
    ab_t along_mean; /* m(u) [-] */
    ab_t along;      /* u of the last step [-] */
    float way;       /* of u in that step over the reference's [-] */
    ab_t current;    /* of the last step [A] */
    uint32_t moved;  /* [-] 1: it is not the one before */
    ab_t rest;       /* e - m(e) of the last step [V] */
    ab_t against;    /* what turns against the current: low-pass of (e - m(e)) u [V] */
    float seen;      /* [s] that this step counts for; 0: it teaches nothing */
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
    learn->seen = 0.0f;
}

/* Is the dead time known, by what was learnt or because nothing is to be learnt of it? */
static inline bool dead_time_learn_is_settled(const dead_time_learn_t *learn)
{
    return learn->rate <= DEAD_TIME_LEARN_SETTLED * learn->tuning.rate;
}

/* Is it near enough that what it leaves in the EMF is not taken for a shape? */
static inline bool dead_time_learn_is_near(const dead_time_learn_t *learn)
{
    return learn->rate <= DEAD_TIME_LEARN_NEAR * learn->tuning.rate;
}

/* In every so-manieth period, as the tuning says: what the means since the last one teach. A current that
 * stands still, and what is no number or no EMF, teach nothing. No division. */
void dead_time_learn_step(dead_time_learn_t *learn, const dead_time_learn_input_t *input);

#endif
