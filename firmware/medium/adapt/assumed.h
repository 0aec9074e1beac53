/* The assumed values of motor, inverter and sensors that the drive can learn. Each value has one owner:
 * it starts from the parameter, the module that learns a better value writes it here, and all modules
 * that use the value read it here. */
#ifndef MEDIUM_ADAPT_ASSUMED_H
#define MEDIUM_ADAPT_ASSUMED_H

#include <stdbool.h>
#include <stdint.h>

#include "math/bounds.h"

#define ASSUMED_STEP 1e-3f /* [-] relative change that is large enough for a new tuning */

typedef struct {
    float resistance;   /* R of a phase, power device included [ohm] */
    float inductance_d; /* L_d [H] */
    float inductance_q; /* L_q [H]; of a q axis that saturates at 0.8 of the current limit */
    float bend;         /* L_q without saturation over inductance_q, minus 1 [-]; 0: no saturation */
    float flux_linkage; /* psi_f [Wb] */
    float inertia;      /* inertia of all rotating parts [kg m^2] */
    float noise;        /* of a current sensor, rms [A]; 0: too small to change the hand-over speed */
} assumed_t;

#define ASSUMED_SLOTS ((uint32_t)(sizeof(assumed_t) / sizeof(uint32_t))) /* every member is one slot */

static inline bool assumed_differs(float from, float to)
{
    return !bounds_within(to - from, ASSUMED_STEP * from);
}

/* True if a value has changed by more than ASSUMED_STEP of its earlier amount. */
static inline bool assumed_moved(const assumed_t *from, const assumed_t *to)
{
    return assumed_differs(from->resistance, to->resistance) ||
           assumed_differs(from->inductance_d, to->inductance_d) ||
           assumed_differs(from->inductance_q, to->inductance_q) ||
           assumed_differs(from->flux_linkage, to->flux_linkage) ||
           assumed_differs(from->inertia, to->inertia) || from->noise != to->noise;
}

/* A learnt value and the value of the parameter from which learning started. The learnt value is valid only
 * while the parameter still has that value. */
typedef struct {
    float value, from; /* in the parameter's unit */
} learnt_value_t;

/* All values that the interrupt has learnt and from which the background makes the assumed values. */
typedef struct {
    learnt_value_t resistance;   /* [ohm] */
    learnt_value_t inductance_q; /* [H] */
    learnt_value_t inertia;      /* [kg m^2] */
    float noise_square;          /* of a current sensor, mean square [A^2]; 0: not measured yet */
} learnt_t;

#endif
