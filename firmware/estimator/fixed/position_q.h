/* Position and speed of the rotor in fixed point; see estimator/position.h. */
#ifndef ESTIMATOR_FIXED_POSITION_Q_H
#define ESTIMATOR_FIXED_POSITION_Q_H

#include <stdint.h>

typedef struct {
    uint32_t theta_e; /* 2^-32 of a turn, electrical */
    int32_t omega_e;  /* 2^-32 of a turn per period, electrical */
} position_q_t;

#endif
