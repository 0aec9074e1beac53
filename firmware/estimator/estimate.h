/* The output of the estimator after a step, and the only part of its state that other modules read. The float
 * and the fixed-point estimator fill the same two structs: the results that other modules use, and the state
 * of the observer for display. */
#ifndef ESTIMATOR_ESTIMATE_H
#define ESTIMATOR_ESTIMATE_H

#include <stdbool.h>
#include <stdint.h>

#include "math/bounds.h"
#include "math/frames.h"

typedef struct {
    frame_t frame; /* of the rotor at t_k; its speed is the whole frequency of the loop, k_p term included */
    float omega_smooth; /* integrator and feed-forward only [rad/s], electrical */
    ab_t emf;           /* back-EMF at t_k, without lag [V] */
    dq_t emf_loop;      /* back-EMF in this frame, filtered by the loop [V] */
    float amplitude;    /* its length in the loop [V] */
    float flux;         /* estimated psi_a that makes the EMF in the loop [Wb]; psi_f for a round rotor */
    float cross;        /* psi_q - L_q i_q by the saturation of the q axis [Wb]; 0 without */
    float detector;     /* sine of the loop's error [-]; 0 while it coasts */
    uint32_t invalid;   /* [-] bits of validity.h: 0, or the criteria that failed */
    uint32_t coasted;   /* [-] 1: the loop coasted in this period, without a judgement */
} estimate_t;

/* [-] Least EMF of a rotor that the loop follows, over the EMF that its speed makes. The margin covers a
 * psi_f that is wrong by a third, and the effect of a wrong L. */
#define ESTIMATE_EMF_LEAST 0.5f

/* True if the EMF denies the speed of the loop: the loop has lost the rotor. */
static inline bool estimate_is_denied(const estimate_t *estimate)
{
    return estimate->amplitude <
           ESTIMATE_EMF_LEAST * estimate->flux * bounds_magnitude(estimate->omega_smooth);
}

typedef struct {
    ab_t current_err; /* observed minus measured current [A] */
    ab_t emf_hat;     /* back-EMF as observed, filtered, with its lag [V] */
    ab_t gain_axis;   /* k_f of each axis [1/A]; the vector form does not change it */
    float gain;       /* k_f that the compensation uses [1/A] */
} observed_t;

#endif
