/* Hand-over: judges whether control may change from the forced frame to the estimate's frame. The loop must
 * satisfy all of the following for a time without a break:
 *
 *     |LP(omega_hat) - omega_forced| < 0.7 omega_forced      it turns with the frame,
 *     |integral (omega_hat - omega_forced)| < pi/2           and does not slip meanwhile
 *     0.65 < LP(e_q sign(omega)) / LP(psi_f |omega|) < 1.7   its EMF has the right direction and length,
 *     LP(eps^2) < 0.05                                       and is steady (both of lock.h)
 *     |LP(i_d)| < 1.6 LP(|i_q|) + 0.15 I                     the current is little more than the load needs
 *
 * so that only the frame changes. Control continues with the means of the current and of the speed. i_q in a
 * single period may contain a response of the damping to a leg that passes zero current, which is no load.
 * The speed in a single period contains the noise of the loop, which for a light rotor exceeds 0.2 of a slow
 * speed while the angle is right.
 * Until then the current is reduced from the start current I to what the load needs, because the effect of
 * errors of R and of the dead time falls with the current. The limits of the length allow for an error of
 * psi_f by 30 %, and of about 15 % by R and dead time (docs/theory.md, 23).
 *
 * A salient rotor with a current along its magnet has nearly no EMF and swings for a long time: it is handed
 * over as soon as the loop has been locked for 40 ms, within 0.7 omega_forced and with any i_d.
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
    float current; /* I, current of a start [A] */
    bool salient;  /* the rotor is salient */
    float period;  /* from one step to the next [s] */
} handover_params_t;

typedef struct {
    float current_share;  /* of the fall of the current [-] */
    float current_margin; /* in addition to the current that the load needs [A] */
    float current_excess; /* largest remaining i_d [A] */
    float slip;           /* largest change of the angle between loop and frame [rad] */
    float period;         /* from one step to the next [s] */
    float mean_share;     /* of the means of the current and of the speed [-] */
    uint32_t wanted;      /* [steps] for which the conditions must hold */
    uint32_t longest;     /* [steps] longest time of a hand-over */
} handover_tuning_t;

typedef struct {
    handover_tuning_t tuning;
    dq_t mean;        /* current in the estimate's frame, low-passed [A] */
    float omega;      /* speed of the estimate, low-passed [rad/s], electrical */
    float slipped;    /* change of the angle between loop and frame while the conditions held [rad] */
    float needed;     /* current that the load needs [A] */
    uint32_t held;    /* [steps] without a break */
    uint32_t periods; /* [steps] so far */
} handover_t;

typedef enum { HANDOVER_GOES_ON, HANDOVER_GOOD, HANDOVER_FAILED } handover_outcome_t;

/* Computes the coefficients. An exponential: for the background. */
handover_tuning_t handover_prepare(const handover_params_t *params);

/* Takes these coefficients; nothing has been measured yet. */
void handover_init(handover_t *handover, const handover_tuning_t *tuning);

/* Takes over new coefficients; the state is kept. */
static inline void handover_take(handover_t *handover, const handover_tuning_t *tuning)
{
    handover->tuning = *tuning;
}

/* A hand-over begins, with this current in the estimate's frame [A] and this speed of the estimate [rad/s].
 */
static inline void handover_enter(handover_t *handover, dq_t current, float omega_e)
{
    handover->mean = current;
    handover->omega = omega_e;
    handover->slipped = 0.0f;
    handover->needed = 0.0f;
    handover->held = 0u;
    handover->periods = 0u;
}

/* The current of the forced frame [A]: it approaches what this i_q of the rotor [A] needs,
 * within the current of this try [A]. */
static inline float handover_current(handover_t *handover, float current, float most, float i_q)
{
    handover->needed = bounds_magnitude(i_q);
    const float wanted = 1.3f * handover->needed + handover->tuning.current_margin;
    const float next = lowpass_step(current, handover->tuning.current_share, wanted);
    return next < most ? next : most;
}

/* One step of the judgement, from the estimate, its lock, the speed of the forced frame [rad/s], and the
 * current in the estimate's frame [A]. */
handover_outcome_t handover_step(handover_t *handover, const estimate_t *estimate, const lock_t *lock,
                                 float omega_forced, dq_t current);

#endif
