/* Hand-over: judges whether control may change from the forced frame to the estimate's frame. The loop must
 * satisfy all of the following for a time without a break:
 *
 *     |integral (omega_hat - omega_forced)| < pi/2, and      it turns with the frame
 *                    < 0.7 omega_forced times this time
 *     0.65 < LP(e_q sign(omega)) / LP(psi_f |omega|) < 1.7   its EMF has the right direction and length,
 *     LP(eps^2) < 0.05                                       and is steady (both of lock.h)
 *     |LP(i_d)| < 1.6 LP(|i_q|) + 0.15 I                     the current is little more than the load needs
 *
 * so that only the frame changes. Control continues with the mean of the current, LP(i), because i_q in a
 * single period may contain a response of the damping to a leg that passes zero current, which is no load.
 * The speed in a single period shows less than the angle: a load that changes with the angle of the shaft
 * swings it by a half, and a fast loop contains noise of several rad/s.
 *
 * Until then the current is reduced from the start current I to what the load needs, because the effect of
 * errors of R and of the dead time falls with the current. The limits of the length allow for an error of
 * psi_f by 30 %, and of about 15 % by R and dead time (docs/theory.md, 23).
 *
 * A salient rotor with a current along its magnet has nearly no EMF and swings for a long time: it is handed
 * over as soon as the loop has been locked for 40 ms, with any i_d and any swing.
 *
 * One step per window. */
#ifndef MEDIUM_MANOEUVRE_HANDOVER_H
#define MEDIUM_MANOEUVRE_HANDOVER_H

#include <stdbool.h>
#include <stdint.h>

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
    float slip;           /* largest change of the angle between loop and frame, over the period [rad/s] */
    float mean_share;     /* of the mean of the current [-] */
    uint32_t wanted;      /* [steps] for which the conditions must hold */
} handover_tuning_t;

typedef struct {
    handover_tuning_t tuning;
    dq_t mean;     /* current in the estimate's frame, low-passed [A] */
    float slipped; /* meanwhile, change of the angle between loop and frame, over the period [rad/s] */
    uint32_t held; /* [steps] without a break */
} handover_t;

/* The inputs of a step. */
typedef struct {
    float omega_smooth; /* speed of the loop [rad/s] */
    float omega_forced; /* speed of the forced frame [rad/s] */
    dq_t current;       /* in the estimate's frame [A] */
    float needed;       /* mean of the current that the load needs, >= 0 [A] */
} handover_input_t;

/* Computes the coefficients. An exponential: for the background. */
handover_tuning_t handover_prepare(const handover_params_t *params);

/* Takes these coefficients; nothing has been measured yet. */
void handover_init(handover_t *handover, const handover_tuning_t *tuning);

/* Takes over new coefficients; the state is kept. */
static inline void handover_take(handover_t *handover, const handover_tuning_t *tuning)
{
    handover->tuning = *tuning;
}

/* A hand-over begins, with this current in the estimate's frame [A]. */
static inline void handover_enter(handover_t *handover, dq_t current)
{
    handover->mean = current;
    handover->slipped = 0.0f;
    handover->held = 0u;
}

/* The current of the forced frame [A]: it approaches what this i_q of the rotor [A] needs,
 * within the current of this try [A]. */
static inline float handover_current(const handover_t *handover, float current, float most, float i_q)
{
    const float needed = 1.3f * bounds_magnitude(i_q) + handover->tuning.current_margin;
    const float next = lowpass_step(current, handover->tuning.current_share, needed);
    return next < most ? next : most;
}

/* One step of the judgement. true: control may change to the estimate's frame. */
bool handover_step(handover_t *handover, const handover_input_t *input, const lock_t *lock);

#endif
