#include "fast/inverter/doubt.h"

#define DOUBT_DECAY      2.0f   /* [-] time constants of the EMF filter until the effect has decayed */
#define DOUBT_EMF_CUTOFF 200.0f /* [rad/s] the memory assumes at least this cutoff, also without a filter */
#define DOUBT_LEAST      3.0f   /* [periods] for which the observer itself keeps the effect */

doubt_tuning_t doubt_prepare(const doubt_params_t *params)
{
    const float filter =
        params->emf_cutoff > DOUBT_EMF_CUTOFF ? DOUBT_DECAY / (params->emf_cutoff * params->period) : 0.0f;
    const float turn = 0.5f * params->acceleration * DOUBT_TIME * DOUBT_TIME;
    /* [A] a load that reverses causes twice its error */
    const float load = 0.5f * params->current_max * DOUBT_TURN / turn;
    const uint32_t memory = (uint32_t)(DOUBT_LEAST + filter);
    return (doubt_tuning_t){
        .current = params->current,
        .memory = memory,
        .share_per_speed = DOUBT_REMEMBERED * params->period * (float)memory,
        .load_most = params->acceleration_known ? load : 0.0f,
        .speed_share = turn < DOUBT_TURN ? DOUBT_SPEED_HEAVY : DOUBT_SPEED_LIGHT,
        .miss_share = DOUBT_TURN / turn,
    };
}
