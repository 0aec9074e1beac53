#include "fast/reference/forced.h"

static float torque_per_ampere(const forced_params_t *params)
{
    return 1.5f * params->pole_pairs * params->flux_linkage;
}

float forced_natural(const forced_params_t *params)
{
    const float square = params->pole_pairs * torque_per_ampere(params) * params->current / params->inertia;
    return square * inverse_root(square);
}

float forced_damping(const forced_params_t *params)
{
    const float wanted = forced_natural(params) * params->inertia /
                         (params->pole_pairs * torque_per_ampere(params) * params->flux_linkage);
    const float most =
        0.5f / (0.3f * params->resistance + 0.25f * params->dead_voltage / params->current + 1e-6f);
    return wanted < most ? wanted : most;
}

float forced_emf_share(const forced_params_t *params)
{
    const float observed = params->inductance - params->saliency; /* L_d, or L of a round rotor */
    const float by_saliency = params->saliency / observed;
    const float by_saturation = observed / params->inductance_least - 1.0f;
    const float gain = by_saliency > by_saturation ? by_saliency : by_saturation;
    return gain > 1.0f ? FORCED_EMF_SHARE / gain : FORCED_EMF_SHARE;
}

forced_tuning_t forced_prepare(const forced_params_t *params)
{
    const float damping = params->damping > 0.0f ? params->damping : forced_damping(params);
    const float cutoff = 2.5f / (damping * params->inductance);
    const float cutoff_max = 1.0f / params->period;
    return (forced_tuning_t){
        .current = params->current,
        .current_inverse = 1.0f / params->current,
        .square_max = params->current_max * params->current_max,
        .damping = damping,
        .damping_share = lowpass_share(cutoff < cutoff_max ? cutoff : cutoff_max, params->period),
        .swing_share = lowpass_share(FORCED_SWING_CUTOFF, params->period),
        .emf_share = forced_emf_share(params),
        .period = params->period,
    };
}

void forced_init(forced_t *forced)
{
    forced_enter(forced, 0.0f, 0.0f, 0.0f);
}

void forced_enter(forced_t *forced, float theta_e, float omega_e, float current)
{
    forced->frame = (frame_t){theta_e, omega_e, trig_turn(theta_e)};
    forced->current = current;
    forced->emf_mean = 0.0f;
    forced->swing = 0.0f;
}
