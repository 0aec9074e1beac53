#include "medium/manoeuvre/proof.h"

#include "math/bounds.h"
#include "math/periods.h"

#define ASIDE_SHARE 0.5f /* [-] of the component along the axis: 27 degrees */
#define LENGTH_MIN  0.5f /* [-] of psi_f |omega| */
#define LENGTH_MAX  2.0f /* [-] */

proof_tuning_t proof_prepare(float period)
{
    return (proof_tuning_t){
        .window = periods_of(PROOF_TIME, period),
        .longest = periods_of(PROOF_LONGEST, period),
    };
}

void proof_init(proof_t *proof, const proof_tuning_t *tuning)
{
    proof_take(proof, tuning);
    proof_enter(proof);
}

static void begin_window(proof_t *proof)
{
    proof->emf = (dq_t){0.0f, 0.0f};
    proof->expected = 0.0f;
    proof->tracked = 0u;
}

void proof_enter(proof_t *proof)
{
    begin_window(proof);
    proof->verdicts = 0;
    proof->periods = 0u;
}

/* True if the window's EMF lies along the loop's axis, and has the length for the loop's speed. */
static bool agrees(const proof_t *proof)
{
    const float along = proof->emf.q;
    return bounds_within(proof->emf.d, ASIDE_SHARE * along) && along > LENGTH_MIN * proof->expected &&
           along < LENGTH_MAX * proof->expected;
}

/* True if the window's EMF is shorter than that of any rotor with the loop's speed. */
static bool denies(const proof_t *proof)
{
    const float least = LENGTH_MIN * proof->expected;
    return proof->emf.d * proof->emf.d + proof->emf.q * proof->emf.q < least * least;
}

proof_outcome_t proof_step(proof_t *proof, const estimate_t *estimate)
{
    const proof_tuning_t *tuning = &proof->tuning;
    proof->periods++;
    if (estimate->coasted == 0u) {
        const dq_t emf = estimate->emf_loop;
        proof->emf.d += emf.d;
        proof->emf.q += estimate->omega_smooth < 0.0f ? -emf.q : emf.q;
        proof->expected += estimate->flux * bounds_magnitude(estimate->omega_smooth);
        proof->tracked++;
    }
    if (proof->tracked >= tuning->window) {
        const int32_t now = proof->verdicts;
        if (agrees(proof)) {
            proof->verdicts = now > 0 ? now + 1 : 1;
        } else if (denies(proof)) {
            proof->verdicts = now < 0 ? now - 1 : -1;
        } else {
            proof->verdicts = 0;
        }
        begin_window(proof);
    }
    if (proof->verdicts >= PROOF_WINDOWS) {
        return PROOF_GOOD;
    }
    const bool ends = proof->verdicts <= -PROOF_DENIED || proof->periods >= tuning->longest;
    return ends ? PROOF_FAILED : PROOF_GOES_ON;
}
