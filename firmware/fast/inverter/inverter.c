#include "fast/inverter/inverter.h"

inverter_tuning_t inverter_prepare(const inverter_params_t *params)
{
    dead_time_params_t all = params->dead_time;
    all.gain = 1.0f;
    const float late = 0.5f * (all.dead_time + all.turn_on_delay + all.turn_off_delay);
    return (inverter_tuning_t){
        .lost = dead_time_prepare(&all),
        .edges = edges_prepare(params->dead_time.period, params->inductance, late, params->sampled_upper),
        .modulation = svpwm_prepare(params->duty_min, params->duty_max, params->over_modulation),
        .half_gain = 0.5f * params->dead_time.gain,
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
