/* What a manoeuvre asks of control for one period. */
#ifndef FAST_REFERENCE_DEMAND_H
#define FAST_REFERENCE_DEMAND_H

#include <stdint.h>

#include "math/frames.h"

/* What becomes of the integrals of current control. */
typedef enum {
    FRAME_GOES_ON, /* the frame is that of the last period, a period on */
    FRAME_TURNS,   /* another frame: the integrals are turned into it and nothing jumps */
    FRAME_ANEW     /* another frame, and nothing of the old one holds there: integrals zero */
} frame_change_t;

typedef struct {
    frame_t frame;     /* in which control works, at t_k */
    int32_t change;    /* [-] frame_change_t */
    dq_t current;      /* reference in this frame [A] */
    dq_t emf;          /* known of the voltage beforehand, in the same frame [V] */
    float omega_m_ref; /* mechanical speed reference in force [rad/s] */
} demand_t;

#endif
