#include "inverter/doubt.h"

#include "math/bounds.h"

#define DOUBT_SHARE        0.2f /* [-] of the largest phase current that may be in doubt: else all of a turn is */
#define DOUBT_ANGLE        0.005f /* [rad] */
#define DOUBT_SPEED_STEADY 30.0f  /* [rad/s] slower, a current is near zero for too long to coast */
#define DOUBT_SPEED_SHARE                                                                                    \
    0.1f /* [-] of the speed that may be missing: further from it, nothing may be missed */
#define DOUBT_DETECTOR       0.03f /* [-] a loop with an error to work off shall work */
#define DOUBT_SHARE_FORESEEN 0.02f /* [-] DOUBT_SHARE while the speed changes as the loop is told */
#define DOUBT_SPEED_FORESEEN 10.0f /* [rad/s] DOUBT_SPEED_STEADY likewise */
#define DOUBT_DECAY          2.0f /* [-] time constants of the EMF filter until a doubtful voltage is forgotten */
#define DOUBT_EMF_CUTOFF     200.0f /* [rad/s] a slower filter than this, or none, is not waited for */
#define DOUBT_LEAST          3.0f   /* [periods] that the observer itself remembers */

doubt_tuning_t doubt_prepare(const doubt_params_t *params)
{
    const float filter =
        params->emf_cutoff > DOUBT_EMF_CUTOFF ? DOUBT_DECAY / (params->emf_cutoff * params->period) : 0.0f;
    return (doubt_tuning_t){params->current, (uint32_t)(DOUBT_LEAST + filter), params->acceleration_known};
}

void doubt_init(doubt_t *doubt, const doubt_tuning_t *tuning)
{
    doubt->tuning = *tuning;
    doubt->left = 0u;
}

bool doubt_step(doubt_t *doubt, const doubt_input_t *input)
{
    const abc_t phases = frames_inverse_clarke(input->current);
    const bounds_span_t span =
        bounds_span(bounds_magnitude(phases.a), bounds_magnitude(phases.b), bounds_magnitude(phases.c));
    const float zone = doubt->tuning.current;
    const float speed = bounds_magnitude(input->omega_e);

    const bool steady =
        bounds_within(input->detector, DOUBT_DETECTOR) &&
        bounds_within(input->omega_m_miss, DOUBT_SPEED_SHARE * bounds_magnitude(input->omega_m)) &&
        speed >= DOUBT_SPEED_STEADY;
    const bool foreseen = doubt->tuning.acceleration_known != 0u &&
                          zone < DOUBT_SHARE_FORESEEN * span.largest && speed >= DOUBT_SPEED_FORESEEN;
    if (!steady && !foreseen) {
        doubt->left = 0u;
    } else if (span.smallest < zone && zone < DOUBT_SHARE * span.largest &&
               input->amplitude < DOUBT_EMF * input->leg &&
               input->leg * zone > DOUBT_ANGLE * input->amplitude * span.largest) {
        doubt->left = doubt->tuning.memory;
    } else if (doubt->left > 0u) {
        doubt->left--;
    }
    return doubt->left > 0u;
}
