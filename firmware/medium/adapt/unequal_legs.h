/* The deviation of each leg from the mean of the legs, in the lost voltage and in the series resistance,
 * learnt from the EMF while the motor turns slowly.
 *
 * With the differences as vectors, of voltage V (leg j: Re(V e^(-j gamma_j)), gamma_j = 0, 120, 240 degrees)
 * and of resistance R, and the current I = |I| u, the EMF carries
 *
 *     (2/pi) V* u* - (2/(3 pi)) V (u^3 + u*^3) + ... + R* I* / 2
 *
 * The lines at three times the frequency of the current, one in each direction, come from the voltage alone:
 * no other part of a motor causes them (docs/theory.md, 25.1). The line against the current is attributed to
 * resistance for any cause, because it is removed from the input of the tracking loop in any case. With the
 * rest e - m(e) of dead_time_learn.h and its direction u of the current
 *
 *     dV/dt = -g (3 pi/2) <(e - m(e)) u^3>,   dR/dt = 2 g <(e - m(e)) u>* / |I|
 *
 * The mean of the learnt voltage in each window is subtracted from the voltage that the
 * estimator gets, so the law follows the remaining error. Does not handle: a difference that
 * depends on the current by another law. */
#ifndef MEDIUM_ADAPT_UNEQUAL_LEGS_H
#define MEDIUM_ADAPT_UNEQUAL_LEGS_H

#include <stdbool.h>
#include <stdint.h>

#include "math/bounds.h"
#include "math/frames.h"
#include "medium/adapt/emf_shape.h"

/* [rad/s] electrical: the ripple of the legs, at twice this speed, has the frequency of the sixth
 * harmonic at a third of this speed. */
#define UNEQUAL_LEGS_SPEED_MOST (3.0f * EMF_SHAPE_SPEED_MOST)

typedef struct {
    float rate;              /* initial rate [1/s]; 0: off */
    float per_rate;          /* 1/rate [s] */
    float voltage_max;       /* of either component [V] */
    float voltage_chance;    /* effect of noise at the initial rate [V] */
    float resistance_max;    /* of either component [ohm] */
    float resistance_chance; /* effect of noise at the initial rate [ohm] */
    float per_zone;          /* one over the half width of the zone around zero current [1/A] */
} unequal_legs_tuning_t;

/* In the unit of the difference. */
typedef struct {
    ab_t used;
    ab_t seen; /* as learnt; the part that noise can explain is not used */
} unequal_leg_t;

typedef struct {
    unequal_legs_tuning_t tuning;
    unequal_leg_t voltage;    /* V [V] */
    unequal_leg_t resistance; /* R [ohm] */
    float rate;               /* present rate [1/s] */
} unequal_legs_t;

/* The measurements of a step of the dead time. */
typedef struct {
    ab_t rest;    /* e - m(e) [V] */
    ab_t current; /* of the same periods [A] */
    float time;   /* with which the step counts [s] */
    float taken;  /* share of the values in use that was subtracted from this EMF [-] */
} unequal_legs_input_t;

/* Takes over new coefficients. The learnt value is kept while learning is on. */
void unequal_legs_take(unequal_legs_t *legs, const unequal_legs_tuning_t *tuning);

/* Updates the learnt differences from this step. No division. */
void unequal_legs_step(unequal_legs_t *legs, const unequal_legs_input_t *input);

/* Share that is subtracted at the speed omega_e [rad/s]: the ripple of the legs is at twice this speed. */
static inline float unequal_legs_share(float omega_e)
{
    return emf_shape_share((1.0f / 3.0f) * omega_e);
}

/* The voltage that the legs lose beyond their common loss [V], times `share` [-], with this current [A]. */
ab_t unequal_legs_voltage(const unequal_legs_t *legs, float share, ab_t current);

#endif
