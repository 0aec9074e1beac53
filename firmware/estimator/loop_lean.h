/* The lean with which the tracking loop of a round rotor stays stable although L is wrong.
 *
 * The drive controls the current in the frame of the loop. If the assumed L is wrong by dL, the length of the
 * observed EMF therefore depends on the error of the loop, and the speed of the feed-forward is omega - c err
 * with
 *
 *     c = omega dL i_q/psi_f
 *
 * c > 0 acts against kp: while driving with an L that is too large, and while braking with one that is too
 * small. By Routh's criterion the loop is stable up to
 *
 *     c_stable = kp + ki kp/(omega_c (kp + omega_c))
 *
 * A lean t reduces c by omega t (estimator/pll.h). Let C be the c, at this speed and current, of an L that is
 * wrong by LOOP_LEAN_SIGMAS standard uncertainties u(L). The lean removes LOOP_LEAN_GAIN times the part of C
 * above LOOP_LEAN_MARGIN c_stable:
 *
 *     t = LOOP_LEAN_GAIN (LOOP_LEAN_SIGMAS u(L) |i_q|/psi_f - LOOP_LEAN_MARGIN c_stable/|omega|)
 *
 * but at least 0, with the sign of the speed. Then c <= LOOP_LEAN_MARGIN c_stable for this L. Where C is
 * smaller, t is 0, and so it is without a feed-forward (omega_c = 0).
 *
 * No state. Derivation: docs/theory.md, 6. */
#ifndef ESTIMATOR_LOOP_LEAN_H
#define ESTIMATOR_LOOP_LEAN_H

#include "estimator/pll.h"
#include "math/bounds.h"
#include "math/root.h"

#define LOOP_LEAN_SIGMAS 2.0f  /* standard uncertainties of L [-] */
#define LOOP_LEAN_GAIN   2.5f  /* least error after a jump of i_q, for either sign of dL [-] */
#define LOOP_LEAN_MARGIN 0.75f /* share of Routh's limit that needs no lean [-] */

typedef struct {
    float per_ampere; /* LOOP_LEAN_GAIN LOOP_LEAN_SIGMAS u(L)/psi_f [1/A] */
    float held;       /* LOOP_LEAN_GAIN LOOP_LEAN_MARGIN c_stable [rad/s] */
} loop_lean_tuning_t;

/* Coefficients for the relative standard uncertainty `data` of L [-], L [H], psi_f [Wb], and this loop. Two
 * divisions. */
static inline loop_lean_tuning_t loop_lean_prepare(float data, float inductance, float flux_linkage,
                                                   const pll_params_t *loop)
{
    const float cutoff = loop->feedforward_cutoff;
    if (cutoff == 0.0f) {
        return (loop_lean_tuning_t){0.0f, 0.0f};
    }
    const float stable = loop->kp + loop->ki * loop->kp / (cutoff * (loop->kp + cutoff));
    return (loop_lean_tuning_t){LOOP_LEAN_GAIN * LOOP_LEAN_SIGMAS * data * inductance / flux_linkage,
                                LOOP_LEAN_GAIN * LOOP_LEAN_MARGIN * stable};
}

/* The lean [-] at this i_q [A] and speed [rad/s]. */
static inline float loop_lean(const loop_lean_tuning_t *tuning, float i_q, float omega)
{
    const float held = tuning->held * inverse_root(omega * omega);
    const float lean = bounds_more(tuning->per_ampere * bounds_magnitude(i_q) - held, 0.0f);
    return omega < 0.0f ? -lean : lean;
}

#endif
