/* What the estimator knows after a step: all that anybody outside firmware/estimator reads of it. The float
 * estimator and the one in fixed point fill the same two structs: what others work with, and what the
 * observer shows of itself. */
#ifndef ESTIMATOR_ESTIMATE_H
#define ESTIMATOR_ESTIMATE_H

#include <stdint.h>

#include "math/frames.h"

typedef struct {
    frame_t frame;      /* of the rotor at t_k; its speed is the loop's whole frequency, k_p term included */
    float omega_smooth; /* integrator and feed-forward alone [rad/s], electrical */
    ab_t emf;           /* back-EMF at t_k, lag undone [V] */
    dq_t emf_loop;      /* back-EMF in this frame, filtered as the loop filters it [V] */
    float amplitude;    /* its length in the loop [V] */
    float flux; /* that makes the EMF in the loop, psi_a as it is believed [Wb]; a round rotor's is psi_f */
    float detector;   /* sine of the loop's error [-]; 0 while it coasts */
    ab_t current_err; /* observed minus measured current [A] */
    uint32_t invalid; /* [-] bits of validity.h: 0, or the criteria that failed */
    uint32_t coasted; /* [-] 1: the loop coasted in this period; nothing was judged */
} estimate_t;

typedef struct {
    ab_t emf_hat;   /* back-EMF as observed, filtered, with its lag [V] */
    ab_t gain_axis; /* k_f of each axis [1/A]; the vector form leaves it alone */
    float gain;     /* k_f that the compensation uses [1/A] */
} observed_t;

#endif
