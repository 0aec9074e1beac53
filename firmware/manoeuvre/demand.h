/* What a manoeuvre asks of control for one period. */
#ifndef MANOEUVRE_DEMAND_H
#define MANOEUVRE_DEMAND_H

#include "math/frames.h"

typedef struct {
    dq_t current;      /* reference in the frame in force [A] */
    dq_t emf;          /* known of the voltage beforehand, in the same frame [V] */
    float omega_m_ref; /* mechanical speed reference in force [rad/s] */
} demand_t;

#endif
