/* What is believed of motor, inverter and sensors and could be learnt: one owner for each such value. It
 * begins as the parameters say; whoever learns better writes here, and all who use it read here. */
#ifndef ADAPT_BELIEVED_H
#define ADAPT_BELIEVED_H

#include "math/frames.h"

typedef struct {
    float resistance;   /* R of a phase, device included [ohm] */
    float inductance_d; /* L_d [H] */
    float inductance_q; /* L_q [H] */
    float flux_linkage; /* psi_f [Wb] */
    float inertia;      /* everything that turns [kg m^2] */
} believed_t;

#endif
