/* The lean with which the tracking loop of a round rotor stays stable although L is wrong.
 *
 * The drive controls the current in the frame of the loop. If the assumed L is wrong by dL, the length of the
 * observed EMF therefore depends on the error of the loop, and the speed of the feed-forward is omega - c err
 * with
 *
 *     c = omega dL i_q/psi_f
 *
 * c > 0 acts against kp: while driving with an L that is too large, and while braking with one that is too
 * small. A lean t reduces c by omega t (estimator/pll.h). With the standard uncertainty u(L), the lean
 *
 *     t = LOOP_LEAN_SIGMAS u(L) |i_q|/psi_f - kp/omega_max,   at least 0, with the sign of the speed
 *
 * leaves c < kp for an L that is wrong by LOOP_LEAN_SIGMAS u(L), up to the speed omega_max of the overspeed
 * trip. It is 0 for the currents at which c is below kp without it.
 *
 * No state. Derivation: docs/theory.md, 6. */
#ifndef ESTIMATOR_LOOP_LEAN_H
#define ESTIMATOR_LOOP_LEAN_H

#include "math/bounds.h"

/* Standard uncertainties of L for which the loop is stable [-]; with two thirds of this error the damping is
 * at least 0.4. */
#define LOOP_LEAN_SIGMAS 3.0f

typedef struct {
    float per_ampere; /* LOOP_LEAN_SIGMAS u(L)/psi_f [1/A] */
    float held;       /* kp/omega_max [-] */
} loop_lean_tuning_t;

/* Coefficients for the relative standard uncertainty `data` of L [-], L [H], psi_f [Wb], kp [rad/s] and the
 * largest speed [rad/s], electrical, > 0. Two divisions. */
static inline loop_lean_tuning_t loop_lean_prepare(float data, float inductance, float flux_linkage, float kp,
                                                   float omega_max)
{
    return (loop_lean_tuning_t){LOOP_LEAN_SIGMAS * data * inductance / flux_linkage, kp / omega_max};
}

/* The lean [-] at this i_q [A] and speed [rad/s]. */
static inline float loop_lean(const loop_lean_tuning_t *tuning, float i_q, float omega)
{
    const float lean = bounds_more(tuning->per_ampere * bounds_magnitude(i_q) - tuning->held, 0.0f);
    return omega < 0.0f ? -lean : lean;
}

#endif
