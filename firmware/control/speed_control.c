#include "control/speed_control.h"

void speed_control_init(speed_control_t *control, const speed_control_params_t *params)
{
    speed_control_reset(control, 0.0f);
    speed_control_retune(control, params);
}

void speed_control_retune(speed_control_t *control, const speed_control_params_t *params)
{
    control->current_limit = params->current_limit;
    pi_retune(&control->pi, params->kp, params->ki, params->period);
}

void speed_control_reset(speed_control_t *control, float current)
{
    pi_reset(&control->pi, current);
}
