/* What is believed of motor, inverter and sensors and could be learnt: one owner for each such value. It
 * begins as the parameters say; whoever learns better writes here, and all who use it read here. */
#ifndef MEDIUM_ADAPT_BELIEVED_H
#define MEDIUM_ADAPT_BELIEVED_H

#include <stdbool.h>
#include <stdint.h>

#include "math/bounds.h"

#define BELIEVED_STEP 1e-3f /* [-] a change that is worth a tuning */

typedef struct {
    float resistance;   /* R of a phase, device included [ohm] */
    float inductance_d; /* L_d [H] */
    float inductance_q; /* L_q [H] */
    float flux_linkage; /* psi_f [Wb] */
    float inertia;      /* everything that turns [kg m^2] */
} believed_t;

static inline bool believed_differs(float from, float to)
{
    return !bounds_within(to - from, BELIEVED_STEP * from);
}

/* Has anything moved by more than BELIEVED_STEP of what it was? */
static inline bool believed_moved(const believed_t *from, const believed_t *to)
{
    return believed_differs(from->resistance, to->resistance) ||
           believed_differs(from->inductance_d, to->inductance_d) ||
           believed_differs(from->inductance_q, to->inductance_q) ||
           believed_differs(from->flux_linkage, to->flux_linkage) ||
           believed_differs(from->inertia, to->inertia);
}

/* A value that is learnt, and that of the parameter from which it began: it is worth something only while the
 * parameter is still that. */
typedef struct {
    float value, from; /* in the parameter's unit */
} learnt_value_t;

/* All that the interrupt has learnt and the background turns into a belief. */
typedef struct {
    learnt_value_t resistance;   /* [ohm] */
    learnt_value_t inductance_q; /* [H] */
    learnt_value_t inertia;      /* [kg m^2] */
} learnt_t;

#endif
