/* The fifth and seventh harmonics of the rotor's EMF. They cause a sixth harmonic of e_d, which the tracking
 * loop would interpret as motion, and of e_q, which the learning of L would interpret as a response. A phase
 * EMF of -psi_f omega (sin x + h5 sin 5 x + h7 sin 7 x) is in the rotor's frame
 *
 *     e_d = -psi_f omega a sin 6 theta,   e_q = psi_f omega (1 + b cos 6 theta),   a = h5 + h7,  b = h7 - h5
 *
 * and a, b are the shape. It is learnt together with the dead time (dead_time_learn.h) and subtracted
 * from the voltage that the estimator gets, except at speeds at which the loop does not follow six times
 * the speed (docs/theory.md, 25).
 *
 * With the mean m(e) and the rest r = e - m(e) of dead_time_learn.h, n being the direction of the mean,
 *
 *     n x r = psi_f |omega| a sin 6 theta,   n r = psi_f |omega| b cos 6 theta,   n^6 = -e^(j 6 theta)
 *     da/dt = 2 g (n x r/(psi_f |omega|) - a sin 6 theta) sin 6 theta,   and for b the same with the cosine
 *
 * Does not handle: harmonics from the eleventh on. */
#ifndef MEDIUM_ADAPT_EMF_SHAPE_H
#define MEDIUM_ADAPT_EMF_SHAPE_H

#include "math/bounds.h"
#include "math/frames.h"
#include "math/sixth.h"

#define EMF_SHAPE_MAX    0.2f   /* [-] largest a, b */
#define EMF_SHAPE_CHANCE 0.005f /* [-] effect of noise at the initial rate */

#define EMF_SHAPE_SPEED_FULL 200.0f /* [rad/s] electrical: below it the whole shape is subtracted ... */
#define EMF_SHAPE_SPEED_MOST 225.0f /* [rad/s] ... and above this speed nothing */

typedef struct {
    float rate;         /* initial rate [1/s]; 0: off */
    float per_rate;     /* 1/rate [s] */
    float flux_linkage; /* [Wb] */
} emf_shape_tuning_t;

typedef struct {
    emf_shape_tuning_t tuning;
    dq_t used;   /* a and b that are subtracted [-] */
    dq_t learnt; /* a and b as learnt [-] */
    float rate;  /* present rate [1/s] */
} emf_shape_t;

/* The measurements of a step of the dead time. */
typedef struct {
    ab_t emf_mean; /* m(e) [V] */
    ab_t rest;     /* e - m(e) [V] */
    float omega_e; /* [rad/s] electrical */
    float time;    /* with which the step counts [s] */
    float taken;   /* share of `used` that was subtracted from this EMF [-] */
} emf_shape_input_t;

/* Takes over new coefficients. The learnt value is kept while learning is on. */
void emf_shape_take(emf_shape_t *shape, const emf_shape_tuning_t *tuning);

/* Updates the learnt shape from this step. No division. */
void emf_shape_step(emf_shape_t *shape, const emf_shape_input_t *input);

/* Share of the shape that is subtracted at the speed omega_e [rad/s]. */
static inline float emf_shape_share(float omega_e)
{
    const float share = (EMF_SHAPE_SPEED_MOST - bounds_magnitude(omega_e)) *
                        (1.0f / (EMF_SHAPE_SPEED_MOST - EMF_SHAPE_SPEED_FULL));
    return share < 1.0f ? (share > 0.0f ? share : 0.0f) : 1.0f;
}

/* The EMF [V] of the shape for a rotor with this rotation and this speed [rad/s]. */
static inline ab_t emf_shape_voltage(const emf_shape_t *shape, float omega_e, rotation_t rotor)
{
    const float amplitude = shape->tuning.flux_linkage * omega_e;
    const ab_t sixth = sixth_power((ab_t){rotor.cos, rotor.sin});
    const dq_t emf = {-amplitude * shape->used.d * sixth.beta, amplitude * shape->used.q * sixth.alpha};
    return frames_inverse_park(emf, rotor);
}

#endif
