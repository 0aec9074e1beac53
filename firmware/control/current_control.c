#include "control/current_control.h"

void current_control_init(current_control_t *control, const current_control_params_t *params)
{
    dq_t zero = {0.0f, 0.0f};
    current_control_reset(control, zero);
    current_control_retune(control, params);
}

void current_control_retune(current_control_t *control, const current_control_params_t *params)
{
    float ki = params->resistance * params->bandwidth;
    control->inductance_d = params->inductance_d;
    control->inductance_q = params->inductance_q;
    control->flux_linkage = params->flux_linkage;
    pi_retune(&control->d, params->inductance_d * params->bandwidth, ki, params->period);
    pi_retune(&control->q, params->inductance_q * params->bandwidth, ki, params->period);
}

void current_control_reset(current_control_t *control, dq_t integral)
{
    pi_reset(&control->d, integral.d);
    pi_reset(&control->q, integral.q);
    control->current_err.d = 0.0f;
    control->current_err.q = 0.0f;
    control->voltage_ref.d = 0.0f;
    control->voltage_ref.q = 0.0f;
}
