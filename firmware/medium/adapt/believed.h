/* The assumed values of motor, inverter and sensors that the drive can learn. Each value has one owner:
 * it starts from the parameter, the module that learns a better value writes it here, and all modules
 * that use the value read it here. */
#ifndef MEDIUM_ADAPT_BELIEVED_H
#define MEDIUM_ADAPT_BELIEVED_H

#include <stdbool.h>
#include <stdint.h>

#include "math/bounds.h"

#define BELIEVED_STEP 1e-3f /* [-] relative change that is large enough for a new tuning */

typedef struct {
    float resistance;   /* R of a phase, power device included [ohm] */
    float inductance_d; /* L_d [H] */
    float inductance_q; /* L_q [H]; of a q axis that saturates at 0.8 of the current limit */
    float bend;         /* L_q without saturation over inductance_q, minus 1 [-]; 0: no saturation */
    float flux_linkage; /* psi_f [Wb] */
    float inertia;      /* inertia of all rotating parts [kg m^2] */
} believed_t;

static inline bool believed_differs(float from, float to)
{
    return !bounds_within(to - from, BELIEVED_STEP * from);
}

/* True if a value has changed by more than BELIEVED_STEP of its earlier amount. */
static inline bool believed_moved(const believed_t *from, const believed_t *to)
{
    return believed_differs(from->resistance, to->resistance) ||
           believed_differs(from->inductance_d, to->inductance_d) ||
           believed_differs(from->inductance_q, to->inductance_q) ||
           believed_differs(from->flux_linkage, to->flux_linkage) ||
           believed_differs(from->inertia, to->inertia);
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
} learnt_t;

#endif
