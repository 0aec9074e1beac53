#include "medium/manoeuvre/handover.h"

#include <stdbool.h>

#include "math/periods.h"

#define CURRENT_CUTOFF 10.0f /* [rad/s] rate at which the current falls to what the load needs */
/* [rad/s] of the means: a leg that passes zero disturbs the current for some 2 ms; an angle of the loop that
 * scatters by 0.05 rad changes the mean of the speed by 0.05 of this, 4 rad/s. */
#define MEAN_CUTOFF  70.0f
#define MARGIN       0.1f  /* [-] of I beyond what the load needs */
#define EXCESS       0.15f /* [-] of I: largest remaining i_d */
#define WANTED_TIME  0.15f /* [s] */
#define LONGEST_TIME 1.0f  /* [s] */

#define SALIENT_TIME 40e-3f /* [s] for a salient rotor */
#define LIMIT_ANY    1e6f /* limit for a salient rotor, which permits any remaining i_d [A] and swing [rad] */

#define SPEED_APART  0.7f  /* [-] a load that changes with the angle swings the rotor */
#define SLIP         1.57f /* [rad] a quarter turn: a rotor in step stays within this of the current vector */
#define LENGTH_MIN   0.65f /* [-] psi_f configured 30 % too large: 0.77; less by errors of the voltage */
#define LENGTH_MAX   1.7f  /* [-] psi_f configured 30 % too small: 1.43; more by errors of the voltage */
#define SCATTER_MAX  0.05f /* [-] mean square of the detector */
#define EXCESS_SHARE 1.6f  /* [-] of i_q */

handover_tuning_t handover_prepare(const handover_params_t *params)
{
    return (handover_tuning_t){
        .current_share = lowpass_share(CURRENT_CUTOFF, params->period),
        .mean_share = lowpass_share(MEAN_CUTOFF, params->period),
        .current_margin = MARGIN * params->current,
        .current_excess = params->salient ? LIMIT_ANY : EXCESS * params->current,
        .slip = params->salient ? LIMIT_ANY : SLIP,
        .period = params->period,
        .wanted = periods_of(params->salient ? SALIENT_TIME : WANTED_TIME, params->period),
        .longest = periods_of(LONGEST_TIME, params->period),
    };
}

void handover_init(handover_t *handover, const handover_tuning_t *tuning)
{
    handover_take(handover, tuning);
    handover_enter(handover, (dq_t){0.0f, 0.0f}, 0.0f);
}

static bool holds(const handover_t *handover, const lock_t *lock, float omega_forced)
{
    const handover_tuning_t *tuning = &handover->tuning;
    const float apart = handover->omega - omega_forced;
    return bounds_magnitude(apart) < SPEED_APART * bounds_magnitude(omega_forced) &&
           bounds_within(handover->slipped, tuning->slip) && lock->projection > LENGTH_MIN * lock->expected &&
           lock->projection < LENGTH_MAX * lock->expected && lock->scatter < SCATTER_MAX &&
           bounds_magnitude(handover->mean.d) < EXCESS_SHARE * handover->needed + tuning->current_excess;
}

handover_outcome_t handover_step(handover_t *handover, const estimate_t *estimate, const lock_t *lock,
                                 float omega_forced, dq_t current)
{
    const handover_tuning_t *tuning = &handover->tuning;
    handover->mean.d = lowpass_step(handover->mean.d, tuning->mean_share, current.d);
    handover->mean.q = lowpass_step(handover->mean.q, tuning->mean_share, current.q);
    handover->omega = lowpass_step(handover->omega, tuning->mean_share, estimate->omega_smooth);
    handover->slipped += tuning->period * (estimate->omega_smooth - omega_forced);
    if (holds(handover, lock, omega_forced)) {
        handover->held++;
    } else {
        handover->held = 0u;
        handover->slipped = 0.0f;
    }
    handover->periods++;
    if (handover->held >= tuning->wanted) {
        return HANDOVER_GOOD;
    }
    return handover->periods >= tuning->longest ? HANDOVER_FAILED : HANDOVER_GOES_ON;
}
