#include "inverter/doubt.h"

#define DOUBT_DECAY      2.0f /* [-] time constants of the EMF filter until a doubtful voltage is forgotten */
#define DOUBT_EMF_CUTOFF 200.0f /* [rad/s] a slower filter than this, or none, is not waited for */
#define DOUBT_LEAST      3.0f   /* [periods] that the observer itself remembers */

doubt_tuning_t doubt_prepare(const doubt_params_t *params)
{
    const float filter =
        params->emf_cutoff > DOUBT_EMF_CUTOFF ? DOUBT_DECAY / (params->emf_cutoff * params->period) : 0.0f;
    const bool heavy = 0.5f * params->acceleration * DOUBT_TIME * DOUBT_TIME < DOUBT_TURN;
    return (doubt_tuning_t){
        .current = params->current,
        .memory = (uint32_t)(DOUBT_LEAST + filter),
        .acceleration_known = params->acceleration_known,
        .speed_share = heavy ? DOUBT_SPEED_HEAVY : DOUBT_SPEED_LIGHT,
    };
}

void doubt_init(doubt_t *doubt, const doubt_tuning_t *tuning)
{
    doubt->tuning = *tuning;
    doubt->left = 0u;
}
