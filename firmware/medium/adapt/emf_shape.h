/* What the fifth and seventh harmonic of a rotor's EMF add to it: the sixth of e_d, which the tracking loop
 * would take for a motion, and that of e_q, which what is learnt of L would take for an answer. A phase EMF
 * of -psi_f omega (sin x + h5 sin 5 x + h7 sin 7 x) is in the rotor's frame
 *
 *     e_d = -psi_f omega a sin 6 theta,   e_q = psi_f omega (1 + b cos 6 theta),   a = h5 + h7,  b = h7 - h5
 *
 * and a, b the shape. It is learnt beside the dead time (dead_time_learn.h), and taken off the voltage that
 * the estimator gets; not at a speed at which the loop does not follow six times of it (docs/theory.md, 25).
 *
 * With the mean m(e) and the rest r = e - m(e) of dead_time_learn.h, n being the direction of the mean,
 *
 *     n x r = psi_f |omega| a sin 6 theta,   n r = psi_f |omega| b cos 6 theta,   n^6 = -e^(j 6 theta)
 *     da/dt = 2 g (n x r/(psi_f |omega|) - a sin 6 theta) sin 6 theta,   b with the cosine alike
 *
 * Does not handle: harmonics from the eleventh on. */
#ifndef MEDIUM_ADAPT_EMF_SHAPE_H
#define MEDIUM_ADAPT_EMF_SHAPE_H

#include "math/bounds.h"
#include "math/frames.h"
#include "math/sixth.h"

#define EMF_SHAPE_MAX    0.2f   /* [-] at most */
#define EMF_SHAPE_CHANCE 0.005f /* [-] that noise makes of it at the first rate */

#define EMF_SHAPE_SPEED_FULL 200.0f /* [rad/s] electrical: up to it all is taken off ... */
#define EMF_SHAPE_SPEED_MOST 225.0f /* [rad/s] ... and from here on nothing */

typedef struct {
    float rate;         /* at which it begins [1/s]; 0: off */
    float per_rate;     /* one over it [s] */
    float flux_linkage; /* [Wb] */
} emf_shape_tuning_t;

typedef struct {
    emf_shape_tuning_t tuning;
    dq_t used;   /* a and b, as they are taken off [-] */
    dq_t learnt; /* likewise as seen [-] */
    float rate;  /* at which it learns now [1/s] */
} emf_shape_t;

/* What a step of the dead time has seen. */
typedef struct {
    ab_t emf_mean; /* m(e) [V] */
    ab_t rest;     /* e - m(e) [V] */
    float omega_e; /* [rad/s] electrical */
    float time;    /* that it counts for [s] */
    float taken;   /* share of what is used that was taken off this EMF [-] */
} emf_shape_input_t;

/* These coefficients. What is learnt stays while it is on. */
void emf_shape_take(emf_shape_t *shape, const emf_shape_tuning_t *tuning);

/* Follows what is seen of it. No division. */
void emf_shape_step(emf_shape_t *shape, const emf_shape_input_t *input);

/* Share that is taken off at the speed omega_e [rad/s]. */
static inline float emf_shape_share(float omega_e)
{
    const float share = (EMF_SHAPE_SPEED_MOST - bounds_magnitude(omega_e)) *
                        (1.0f / (EMF_SHAPE_SPEED_MOST - EMF_SHAPE_SPEED_FULL));
    return share < 1.0f ? (share > 0.0f ? share : 0.0f) : 1.0f;
}

/* The part of the EMF [V] that the shape is, of a rotor with this rotation and this speed [rad/s]. */
static inline ab_t emf_shape_voltage(const emf_shape_t *shape, float omega_e, rotation_t rotor)
{
    const float amplitude = shape->tuning.flux_linkage * omega_e;
    const ab_t sixth = sixth_power((ab_t){rotor.cos, rotor.sin});
    const dq_t emf = {-amplitude * shape->used.d * sixth.beta, amplitude * shape->used.q * sixth.alpha};
    return frames_inverse_park(emf, rotor);
}

#endif
