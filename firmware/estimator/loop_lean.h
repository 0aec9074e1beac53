/* The lean with which the tracking loop of a round rotor stays stable although L is wrong.
 *
 * The drive controls the current in the frame of the loop. If the assumed L is wrong by dL, the length of the
 * observed EMF therefore depends on the error of the loop, and the speed of the feed-forward is omega - c err
 * with
 *
 *     c = omega dL i_q/psi_f
 *
 * c > 0 acts against kp: while driving with an L that is too large, and while braking with one that is too
 * small. A lean t reduces c by omega t (estimator/pll.h). Let C be the c of an L that is wrong by
 * LOOP_LEAN_SIGMAS standard uncertainties u(L) at the top speed, which is the overspeed trip over
 * LOOP_LEAN_ROOM. The lean removes LOOP_LEAN_GAIN times the part of C above kp:
 *
 *     t = LOOP_LEAN_GAIN (LOOP_LEAN_SIGMAS u(L) |i_q|/psi_f - kp/omega_top),   at least 0
 *
 * with the sign of the speed. Then c <= kp for this L, and the loop is stable. If C is at most kp, t is 0.
 *
 * No state. Derivation: docs/theory.md, 6. */
#ifndef ESTIMATOR_LOOP_LEAN_H
#define ESTIMATOR_LOOP_LEAN_H

#include "math/bounds.h"

#define LOOP_LEAN_SIGMAS 2.0f /* standard uncertainties of L [-] */
#define LOOP_LEAN_GAIN   1.5f /* above 1: c decreases where more of it is removed [-] */
#define LOOP_LEAN_ROOM   1.4f /* overspeed trip over the top speed, by the rule of `tune` [-] */

typedef struct {
    float per_ampere; /* LOOP_LEAN_GAIN LOOP_LEAN_SIGMAS u(L)/psi_f [1/A] */
    float held;       /* LOOP_LEAN_GAIN kp/omega_top [-] */
} loop_lean_tuning_t;

/* Coefficients for the relative standard uncertainty `data` of L [-], L [H], psi_f [Wb], kp [rad/s] and the
 * overspeed trip [rad/s], electrical, > 0. Two divisions. */
static inline loop_lean_tuning_t loop_lean_prepare(float data, float inductance, float flux_linkage, float kp,
                                                   float trip)
{
    return (loop_lean_tuning_t){LOOP_LEAN_GAIN * LOOP_LEAN_SIGMAS * data * inductance / flux_linkage,
                                LOOP_LEAN_GAIN * LOOP_LEAN_ROOM * kp / trip};
}

/* The lean [-] at this i_q [A] and speed [rad/s]. */
static inline float loop_lean(const loop_lean_tuning_t *tuning, float i_q, float omega)
{
    const float lean = bounds_more(tuning->per_ampere * bounds_magnitude(i_q) - tuning->held, 0.0f);
    return omega < 0.0f ? -lean : lean;
}

#endif
