/* What the fifth and seventh harmonic of a rotor's EMF add to it, as far as the tracking loop would take it
 * for a motion: the sixth harmonic of e_d. A phase EMF of -psi_f omega (sin x + h5 sin 5 x + h7 sin 7 x) is
 * in the rotor's frame
 *
 *     e_d = -psi_f omega (h5 + h7) sin 6 theta_e,   e_q = psi_f omega (1 + (h7 - h5) cos 6 theta_e)
 *
 * and h5 + h7 the shape. That of e_q hardly turns the estimate, and is left in. It is learnt beside the dead
 * time (dead_time_learn.h), and taken off the voltage that the estimator gets; not at a speed at which the
 * loop does not follow six times of it (docs/theory.md, 25).
 *
 * No state. Does not handle: harmonics from the eleventh on. */
#ifndef ADAPT_EMF_SHAPE_H
#define ADAPT_EMF_SHAPE_H

#include "math/bounds.h"
#include "math/frames.h"

#define EMF_SHAPE_SPEED_FULL 200.0f /* [rad/s] electrical: up to it all is taken off ... */
#define EMF_SHAPE_SPEED_MOST 225.0f /* [rad/s] ... and from here on nothing */

/* Share that is taken off at the speed omega_e [rad/s]. */
static inline float emf_shape_share(float omega_e)
{
    const float share = (EMF_SHAPE_SPEED_MOST - bounds_magnitude(omega_e)) *
                        (1.0f / (EMF_SHAPE_SPEED_MOST - EMF_SHAPE_SPEED_FULL));
    return share < 1.0f ? (share > 0.0f ? share : 0.0f) : 1.0f;
}

/* The part of the EMF [V] of a rotor with this rotation, its amplitude being psi_f omega_e times the shape
 * [V]. */
static inline ab_t emf_shape_voltage(float amplitude, rotation_t rotor)
{
    const float square_re = rotor.cos * rotor.cos - rotor.sin * rotor.sin;
    const float square_im = 2.0f * rotor.cos * rotor.sin;
    const float cube_re = square_re * rotor.cos - square_im * rotor.sin;
    const float cube_im = square_re * rotor.sin + square_im * rotor.cos;
    const float d = -2.0f * amplitude * cube_re * cube_im;
    return (ab_t){d * rotor.cos, d * rotor.sin};
}

#endif
