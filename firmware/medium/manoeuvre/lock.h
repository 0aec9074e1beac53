/* Lock: judges whether the loop whose angle control uses follows the rotor. Three
 * signs fail for different reasons:
 *
 *     projection   LP(e_q sign(omega)) < 0.5 LP(psi_a |omega|)   the EMF along the estimated axis: 1 on the
 *                                                               rotor, -1 half a turn off, 0 blocked
 *     scatter      LP(eps^2) > 0.12                             the loop's error: 0.35 rad rms
 *     standing     |omega| slow, |omega_ref| not, and the      the case that the other two miss
 *                  torque is at its limit, for 20 ms; or
 *                  |omega| below the least one of the projection,
 *                  for 40 ms, at any torque
 *
 * LP: a low-pass of 5 ms. e_q is that of the loop, filtered in its frame. A mean of samples in the stationary
 * frame is shorter at a high speed: half of the EMF at 0.47 rad a period. While the torque is below its
 * limit, a slow estimate is no sign, because the speed control is still responding to a load or to a fast
 * reference. An estimate below the least speed has no EMF: what is measured there are the errors of R and of
 * the dead time, and the angle is not known, whatever the speed control does. One step per window, of its
 * means; the guard defines how long a sign must last (settings/faults.h). Does not handle: the passage
 * through zero speed, where there is no EMF (the caller does not judge the lock then). */
#ifndef MEDIUM_MANOEUVRE_LOCK_H
#define MEDIUM_MANOEUVRE_LOCK_H

#include <stdbool.h>
#include <stdint.h>

#include "estimator/estimate.h"
#include "math/bounds.h"
#include "math/filter.h"
#include "math/frames.h"

#define LOCK_PROJECTION_MIN 0.5f   /* [-] */
#define LOCK_SCATTER_MAX    0.12f  /* [-] mean square of the detector */
#define LOCK_CUTOFF         200.0f /* [rad/s] of the low-passes */
#define LOCK_STANDING       0.02f  /* [s] */
#define LOCK_LEAVES         4u     /* [half steps] that a faster step takes back */

typedef struct {
    float flux_linkage; /* psi_f [Wb], > 0 */
    float speed_slow;   /* a slower estimate means that no rotor is followed ... [rad/s], electrical */
    float speed_asked;  /* ... while the reference is above this [rad/s], electrical */
    float period;       /* from one step to the next [s] */
} lock_params_t;

typedef struct {
    float share;        /* of the low-passes [-] */
    float flux_linkage; /* psi_f at a reset of the lock [Wb] */
    float speed_floor;  /* least |omega| in the projection [rad/s] */
    float speed_slow;   /* [rad/s] electrical */
    float speed_asked;  /* [rad/s] electrical */
    uint32_t standing;  /* [half steps] after which a standing estimate is a sign */
} lock_tuning_t;

typedef struct {
    lock_tuning_t tuning;
    float projection; /* LP of the EMF along the axis in the direction of rotation [V] */
    float expected;   /* LP of psi_a |omega| [V] */
    float scatter;    /* LP of the detector's square [-] */
    uint32_t stood;   /* [half steps] with a standing estimate, less LOCK_LEAVES for each faster step */
} lock_t;

/* Computes the coefficients. An exponential: for the background. */
lock_tuning_t lock_prepare(const lock_params_t *params);

/* Takes these coefficients; locked at standstill. */
void lock_init(lock_t *lock, const lock_tuning_t *tuning);

/* Takes over new coefficients; the means are kept. */
static inline void lock_take(lock_t *lock, const lock_tuning_t *tuning)
{
    lock->tuning = *tuning;
}

/* Sets the state as if the loop had been locked at omega_e [rad/s] for a long time. */
void lock_reset(lock_t *lock, float omega_e);

/* Counts for how long the estimate has been slow, at this |omega| below `speed_slow` [rad/s], although its
 * reference [rad/s] is not: with the torque at its limit, or at half the rate without an EMF. The speed of a
 * loop without EMF scatters: one faster step does not show that the rotor has left this speed. */
static inline void lock_compare(lock_t *lock, float speed, float omega_ref, bool limited)
{
    const lock_tuning_t *tuning = &lock->tuning;
    const bool stands =
        (limited || speed < tuning->speed_floor) && !bounds_within(omega_ref, tuning->speed_asked);
    const uint32_t left = lock->stood > LOCK_LEAVES ? lock->stood - LOCK_LEAVES : 0u;
    lock->stood = !stands ? left : limited ? lock->stood + 2u : lock->stood + 1u;
}

/* One window in which the loop tracked; `estimate` is that at its end; `scatter`: mean square of the detector
 * [-]. While control uses the estimate, `omega_ref` is its reference [rad/s], otherwise 0; `limited`: the
 * torque is at its limit. */
static inline void lock_step(lock_t *lock, const estimate_t *estimate, float scatter, float omega_ref,
                             bool limited)
{
    const lock_tuning_t *tuning = &lock->tuning;
    const float across = estimate->emf_loop.q;
    float speed = bounds_magnitude(estimate->omega_smooth);
    const float along = estimate->omega_smooth < 0.0f ? -across : across;
    const float flux = estimate->flux;
    if (speed < tuning->speed_slow) {
        lock_compare(lock, speed, omega_ref, limited);
        speed = speed > tuning->speed_floor ? speed : tuning->speed_floor;
    } else {
        lock->stood = 0u;
    }
    lock->projection = lowpass_step(lock->projection, tuning->share, along);
    lock->expected = lowpass_step(lock->expected, tuning->share, flux * speed);
    lock->scatter = lowpass_step(lock->scatter, tuning->share, scatter);
}

/* True if the EMF does not lie along the estimated axis. */
static inline bool lock_is_off(const lock_t *lock)
{
    return lock->projection < LOCK_PROJECTION_MIN * lock->expected;
}

/* True if the loop does not settle. */
static inline bool lock_is_scattered(const lock_t *lock)
{
    return lock->scatter > LOCK_SCATTER_MAX;
}

/* True if one of the signs of a lost lock is present. The scatter counts only in a loop that is `settled`:
 * after locking a loop needs time to find its speed. */
static inline bool lock_is_lost(const lock_t *lock, bool settled)
{
    return lock_is_off(lock) || (settled && lock_is_scattered(lock)) || lock->stood > lock->tuning.standing;
}

#endif
