/* Proof: judges whether a loop that has just been locked follows the rotor. Several windows of the EMF in the
 * loop's own frame must agree in succession before control applies torque by this angle:
 *
 *     |sum e_d| < 0.5 sum e_q sign(omega)                        the mean lies along the estimated axis,
 *     0.5 < sum e_q sign(omega) / sum psi_a |omega| < 2.0        with the length for the loop's speed
 *
 * A window consists of PROOF_TIME of periods in which the loop tracks; the voltage of the others is
 * uncertain. A window that does not agree restarts the count, and the proof fails after
 * PROOF_LONGEST without enough windows. It fails earlier, after PROOF_DENIED windows in succession whose EMF
 * denies the speed:
 *
 *     |sum e| < 0.5 sum psi_a |omega|
 *
 * Such a loop does not recover: without the rotor's EMF its speed drifts to its limit, and control would
 * report an overspeed.
 *
 * One step per T; bounded, no division. */
#ifndef MEDIUM_MANOEUVRE_PROOF_H
#define MEDIUM_MANOEUVRE_PROOF_H

#include <stdbool.h>
#include <stdint.h>

#include "estimator/estimate.h"
#include "math/frames.h"

#define PROOF_TIME    2e-3f  /* [s] of a window */
#define PROOF_WINDOWS 4      /* [windows] that must agree, in succession */
#define PROOF_DENIED  3      /* [windows] whose EMF denies the speed, in succession */
#define PROOF_LONGEST 50e-3f /* [s] */

typedef struct {
    uint32_t window;  /* [periods] of a window */
    uint32_t longest; /* [periods] longest duration of the proof */
} proof_tuning_t;

typedef struct {
    proof_tuning_t tuning;
    dq_t emf;         /* sum in this window, q in the direction of rotation [V] */
    float expected;   /* sum of psi_a |omega| [V] */
    uint32_t tracked; /* [periods] of this window */
    int32_t verdicts; /* [windows] in succession that agreed; below zero: that denied the speed */
    uint32_t periods; /* [periods] so far */
} proof_t;

typedef enum { PROOF_GOES_ON, PROOF_GOOD, PROOF_FAILED } proof_outcome_t;

/* T [s]. Divisions: for the background. */
proof_tuning_t proof_prepare(float period);

/* Takes these coefficients; nothing has been measured yet. */
void proof_init(proof_t *proof, const proof_tuning_t *tuning);

/* Takes over new coefficients; the state is kept. */
static inline void proof_take(proof_t *proof, const proof_tuning_t *tuning)
{
    proof->tuning = *tuning;
}

/* A proof begins. */
void proof_enter(proof_t *proof);

/* One period of the loop. */
proof_outcome_t proof_step(proof_t *proof, const estimate_t *estimate);

#endif
