#include "medium/manoeuvre/handover.h"

#include <stdbool.h>

#include "math/periods.h"

#define CURRENT_CUTOFF 10.0f /* [rad/s] rate at which the current falls to what the load needs */
#define MEAN_CUTOFF    70.0f /* [rad/s] of the current: a leg that passes zero disturbs it for some 2 ms */
#define MARGIN         0.1f  /* [-] of I beyond what the load needs */
#define EXCESS         0.15f /* [-] of I: largest remaining i_d */
#define WANTED_TIME    0.15f /* [s] */

#define SALIENT_TIME 40e-3f /* [s] for a salient rotor */
#define LIMIT_ANY    1e6f /* limit for a salient rotor, which permits any remaining i_d [A] and swing [rad] */

#define SPEED_APART  0.7f  /* [-] of the frame's speed: largest difference of the mean speed */
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
        .slip = (params->salient ? LIMIT_ANY : SLIP) / params->period,
        .wanted = periods_of(params->salient ? SALIENT_TIME : WANTED_TIME, params->period),
    };
}

void handover_init(handover_t *handover, const handover_tuning_t *tuning)
{
    handover_take(handover, tuning);
    handover_enter(handover, (dq_t){0.0f, 0.0f});
}

static bool holds(const handover_t *handover, const lock_t *lock, float omega_forced, float needed)
{
    const handover_tuning_t *tuning = &handover->tuning;
    const float apart = SPEED_APART * (float)tuning->wanted * bounds_magnitude(omega_forced);
    return bounds_within(handover->slipped, apart < tuning->slip ? apart : tuning->slip) &&
           lock->projection > LENGTH_MIN * lock->expected && lock->projection < LENGTH_MAX * lock->expected &&
           lock->scatter < SCATTER_MAX &&
           bounds_magnitude(handover->mean.d) < EXCESS_SHARE * needed + tuning->current_excess;
}

bool handover_step(handover_t *handover, const handover_input_t *input, const lock_t *lock)
{
    const handover_tuning_t *tuning = &handover->tuning;
    handover->mean.d = lowpass_step(handover->mean.d, tuning->mean_share, input->current.d);
    handover->mean.q = lowpass_step(handover->mean.q, tuning->mean_share, input->current.q);
    handover->slipped += input->omega_smooth - input->omega_forced;
    if (holds(handover, lock, input->omega_forced, input->needed)) {
        handover->held++;
    } else {
        handover->held = 0u;
        handover->slipped = 0.0f;
    }
    return handover->held >= tuning->wanted;
}
