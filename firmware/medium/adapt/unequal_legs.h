/* By how much the legs differ from their mean, in the voltage that they lose and in the resistance in series
 * with them, learnt from the EMF while the motor turns slowly.
 *
 * With the differences as vectors, of voltage V (leg j: Re(V e^(-j gamma_j)), gamma_j = 0, 120, 240 degrees)
 * and of resistance R, and the current I = |I| u, the EMF carries
 *
 *     (2/pi) V* u* - (2/(3 pi)) V (u^3 + u*^3) + ... + R* I* / 2
 *
 * The lines at three times the current, one either way, are the voltage's alone: nothing else of a motor
 * makes any (docs/theory.md, 25.1). That against it is taken for resistance, whatever makes it: the tracking
 * loop is spared it all the same. With the rest e - m(e) of dead_time_learn.h and its direction u of the
 * current
 *
 *     dV/dt = -g (3 pi/2) <(e - m(e)) u^3>,   dR/dt = 2 g <(e - m(e)) u>* / |I|
 *
 * What is learnt is taken off the voltage that the estimator gets, as its mean in each window, so what is
 * left is followed. Does not handle: a difference that depends on the current otherwise. */
#ifndef MEDIUM_ADAPT_UNEQUAL_LEGS_H
#define MEDIUM_ADAPT_UNEQUAL_LEGS_H

#include <stdbool.h>
#include <stdint.h>

#include "math/bounds.h"
#include "math/frames.h"
#include "medium/adapt/emf_shape.h"

/* [rad/s] electrical: at a third of it the sixth harmonic has the frequency of twice the speed, that of the
 * legs. */
#define UNEQUAL_LEGS_SPEED_MOST (3.0f * EMF_SHAPE_SPEED_MOST)

typedef struct {
    float rate;              /* at which it begins [1/s]; 0: off */
    float per_rate;          /* one over it [s] */
    float voltage_max;       /* of either component [V] */
    float voltage_chance;    /* that noise makes of it at the first rate [V] */
    float resistance_max;    /* of either component [ohm] */
    float resistance_chance; /* that noise makes of it at the first rate [ohm] */
    float per_zone;          /* one over the half width of the zone around zero current [1/A] */
} unequal_legs_tuning_t;

/* In the unit of what differs. */
typedef struct {
    ab_t used;
    ab_t seen; /* as learnt: what of it may be noise is not used */
} unequal_leg_t;

typedef struct {
    unequal_legs_tuning_t tuning;
    unequal_leg_t voltage;    /* V [V] */
    unequal_leg_t resistance; /* R [ohm] */
    float rate;               /* at which it learns now [1/s] */
} unequal_legs_t;

/* What a step of the dead time has seen. */
typedef struct {
    ab_t rest;    /* e - m(e) [V] */
    ab_t current; /* of the same periods [A] */
    float time;   /* that it counts for [s] */
    float taken;  /* share of what is used that was taken off this EMF [-] */
} unequal_legs_input_t;

/* These coefficients. What is learnt stays while it is on. */
void unequal_legs_take(unequal_legs_t *legs, const unequal_legs_tuning_t *tuning);

/* Follows what is seen of them. No division. */
void unequal_legs_step(unequal_legs_t *legs, const unequal_legs_input_t *input);

/* Share that is taken off at the speed omega_e [rad/s]: their ripple is at twice of it. */
static inline float unequal_legs_share(float omega_e)
{
    return emf_shape_share((1.0f / 3.0f) * omega_e);
}

/* What the legs lose beside what they have in common [V], times `share` [-], with this current [A]. */
ab_t unequal_legs_voltage(const unequal_legs_t *legs, float share, ab_t current);

#endif
