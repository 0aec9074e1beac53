#include "fast/inverter/inverter.h"

inverter_tuning_t inverter_prepare(const inverter_params_t *params)
{
    const dead_time_params_t *lost = &params->dead_time;
    const float late = 0.5f * (lost->dead_time + lost->turn_on_delay + lost->turn_off_delay);
    return (inverter_tuning_t){
        .lost = dead_time_prepare(lost),
        .edges = edges_prepare(lost->period, params->inductance, late, params->sampled_upper),
        .modulation = svpwm_prepare(params->duty_min, params->duty_max, params->over_modulation),
        .half_gain = 0.5f * params->compensated,
        .duty_counts = params->duty_counts,
        .per_count = 1.0f / params->duty_counts,
    };
}

void inverter_init(inverter_t *inverter)
{
    const ab_t none = {0.0f, 0.0f};
    const abc_t middle = {0.5f, 0.5f, 0.5f};
    inverter->duty_prev[0] = middle;
    inverter->duty_prev[1] = middle;
    inverter->current_prev = none;
    inverter->u_dc_prev = 0.0f;
    inverter->signs = (edges_t){{0.0f, 0.0f, 0.0f}, {0.0f, 0.0f, 0.0f}};
}
