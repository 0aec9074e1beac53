/* The common input of the learning laws: means of EMF and current over some periods.
 *
 * All learning laws are slow, but the noise of an observed EMF is L times the change of the current's noise.
 * In a sum only the noise of the two ends remains, while a single sample contains all of it. So every period
 * is summed in the stationary frame, and the laws are evaluated once for several periods. The mean in the
 * rotor's frame is the mean of the stationary vectors, transformed with the angle of the rotor in the middle
 * of the periods. It is too short by the share (omega t)^2/24, t being the averaging time: 0.3 % at 650 rad/s
 * and 0.4 ms, the same for EMF and current. */
#ifndef MEDIUM_ADAPT_SUMS_H
#define MEDIUM_ADAPT_SUMS_H

#include <stdint.h>

#include "math/frames.h"
#include "math/trig.h"

typedef struct {
    ab_t emf;         /* of the EMF at t_k, with the lag compensated [V] */
    ab_t current;     /* of the current [A] */
    uint32_t unsound; /* [-] not 0: one of the periods has no valid sample or estimate */
} sums_t;

typedef struct {
    ab_t emf;           /* stationary [V] */
    ab_t current;       /* stationary [A] */
    dq_t emf_rotor;     /* in the rotor's frame at the middle of the periods [V] */
    dq_t current_rotor; /* the same of the current [A] */
    float theta;        /* angle of the rotor at their end [rad] */
    float omega;        /* smoothed speed of the rotor at their end [rad/s] */
    uint32_t unsound;   /* [-] not 0: one of the periods has no valid sample or estimate */
    uint32_t even;      /* [-] 1: the rotor turns so evenly that it causes no ripple of the EMF */
} means_t;

/* The means of these sums, `share` being one over the number of periods [-], for a rotor that has this
 * rotation and this speed [rad/s] now; `ago` [s] is the time since the middle of the periods. If the rotor
 * turns by more than WINDING_TURN_MOST in all periods, the means in its frame are not valid. */
static inline void sums_mean(const sums_t *sums, float share, rotation_t now, float omega, float ago,
                             means_t *means)
{
    const rotation_t middle = trig_advance(now, -ago * omega);
    const ab_t emf = {share * sums->emf.alpha, share * sums->emf.beta};
    const ab_t current = {share * sums->current.alpha, share * sums->current.beta};
    means->emf = emf;
    means->current = current;
    means->emf_rotor = frames_park(emf, middle);
    means->current_rotor = frames_park(current, middle);
    means->omega = omega;
    means->unsound = sums->unsound;
}

#endif
