#include "estimator/saturation.h"

#include "math/winding.h"

#define SATURATION_DEEPEST 1e6f /* [-] i_q/I_s: the square stays in the range of a float */

float saturation_share(const saturation_params_t *params, float i_q)
{
    if (params->current == 0.0f) {
        return 1.0f;
    }
    const float x = bounds_less(i_q / params->current, SATURATION_DEEPEST);
    return (1.0f + params->bend) * winding_saturation(x * x);
}

saturation_t saturation_prepare(const saturation_params_t *params)
{
    saturation_t saturation = {.per_step = 0.0f};
    for (uint32_t n = 0; n < SATURATION_POINTS; n++) {
        saturation.excess[n] = 0.0f;
    }
    if (params->current == 0.0f) {
        return saturation;
    }
    saturation.per_step = (float)SATURATION_STEPS / params->current_max;
    for (uint32_t n = 0; n < SATURATION_POINTS; n++) {
        const float i_q = (float)n * params->current_max / (float)SATURATION_STEPS;
        saturation.excess[n] = params->inductance * (saturation_share(params, i_q) - 1.0f);
    }
    return saturation;
}
