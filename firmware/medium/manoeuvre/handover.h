/* Hand-over: may control leave the forced frame for the estimate's? The loop must have held all of this for a
 * time without a break:
 *
 *     |omega_hat - omega_forced| < 0.2 omega_forced          it turns with the frame
 *     0.75 < LP(e_q sign(omega)) / LP(psi_f |omega|) < 1.3   its EMF lies where it should, with its length,
 *     LP(eps^2) < 0.05                                       and does so steadily (both of lock.h)
 *     |LP(i_d)| < 1.6 |LP(i_q)| + 0.15 I                     the current is what the load needs, and a little
 *
 * so that nothing but the frame changes. What goes on is the mean of the current, LP(i): a leg that passes
 * zero in that very period turns the damping's answer to it into i_q, which is no load. Until then the
 * current is brought down from that of a start I to what the load needs, for what R and dead time leave of
 * error goes with it.
 *
 * A salient rotor on a current along its magnet has next to no EMF and swings for long: it is taken over as
 * soon as the loop has been locked for 40 ms, within 0.7 omega_forced and whatever its i_d.
 *
 * One step per window. */
#ifndef MEDIUM_MANOEUVRE_HANDOVER_H
#define MEDIUM_MANOEUVRE_HANDOVER_H

#include <stdbool.h>
#include <stdint.h>

#include "estimator/estimate.h"
#include "math/bounds.h"
#include "math/filter.h"
#include "math/frames.h"
#include "medium/manoeuvre/lock.h"

typedef struct {
    float current; /* I of a start [A] */
    bool salient;  /* the rotor is */
    float period;  /* from one step to the next [s] */
} handover_params_t;

typedef struct {
    float current_share;  /* of the way down [-] */
    float current_margin; /* over what the load needs [A] */
    float current_excess; /* i_d that may be left [A] */
    float speed_apart;    /* [-] of the forced frame's */
    float mean_share;     /* of the mean of the current [-] */
    uint32_t wanted;      /* [steps] that it must hold */
    uint32_t longest;     /* [steps] that it may take */
} handover_tuning_t;

typedef struct {
    handover_tuning_t tuning;
    dq_t mean;        /* current in the estimate's frame, low-passed [A] */
    uint32_t held;    /* [steps] without a break */
    uint32_t periods; /* [steps] so far */
} handover_t;

typedef enum { HANDOVER_GOES_ON, HANDOVER_GOOD, HANDOVER_FAILED } handover_outcome_t;

/* Coefficients. An exponential: for the background. */
handover_tuning_t handover_prepare(const handover_params_t *params);

/* These coefficients; nothing has been seen. */
void handover_init(handover_t *handover, const handover_tuning_t *tuning);

/* New coefficients; what has been seen stays. */
static inline void handover_take(handover_t *handover, const handover_tuning_t *tuning)
{
    handover->tuning = *tuning;
}

/* A hand-over begins, with this current in the estimate's frame [A]. */
static inline void handover_enter(handover_t *handover, dq_t current)
{
    handover->mean = current;
    handover->held = 0u;
    handover->periods = 0u;
}

/* The current of the forced frame [A] towards what this i_q of the rotor [A] needs, within that of this try
 * [A]. */
static inline float handover_current(const handover_t *handover, float current, float most, float i_q)
{
    const float needed = 1.3f * bounds_magnitude(i_q) + handover->tuning.current_margin;
    const float next = lowpass_step(current, handover->tuning.current_share, needed);
    return next < most ? next : most;
}

/* One step: estimate, its lock, speed of the forced frame [rad/s], current in the estimate's frame [A]. */
handover_outcome_t handover_step(handover_t *handover, const estimate_t *estimate, const lock_t *lock,
                                 float omega_forced, dq_t current);

#endif
