/* The demand of a manoeuvre on current control for one period. */
#ifndef FAST_REFERENCE_DEMAND_H
#define FAST_REFERENCE_DEMAND_H

#include <stdint.h>

#include "math/frames.h"

/* Treatment of the integrals of current control. */
typedef enum {
    FRAME_GOES_ON, /* the frame of the last period continues */
    FRAME_TURNS,   /* another frame: the integrals are transformed into it without a step */
    FRAME_ANEW     /* another frame that is not related to the old one: integrals zero */
} frame_change_t;

/* Origin of the EMF in the feed-forward. */
typedef enum {
    EMF_OTHER,   /* of a manoeuvre that starts without a known EMF */
    EMF_MODEL,   /* psi_f omega of the encoder */
    EMF_OBSERVED /* of the estimator */
} demand_emf_t;

typedef struct {
    frame_t frame;     /* of current control, at t_k */
    int32_t change;    /* [-] frame_change_t */
    dq_t current;      /* reference in this frame [A] */
    dq_t emf;          /* known voltage for the feed-forward, in the same frame [V] */
    int32_t origin;    /* [-] demand_emf_t */
    float omega_m_ref; /* present speed reference, mechanical [rad/s] */
} demand_t;

#endif
