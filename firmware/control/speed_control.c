#include "control/speed_control.h"

speed_control_tuning_t speed_control_prepare(const speed_control_params_t *params)
{
    speed_control_tuning_t tuning = {params->current_limit, params->kp * (1.0f - params->weight),
                                     pi_prepare(params->kp, params->ki, params->period)};
    tuning.pi.back_gain = pi_prepare(params->kp * params->weight, params->ki, params->period).back_gain;
    return tuning;
}

void speed_control_init(speed_control_t *control, const speed_control_tuning_t *tuning)
{
    speed_control_take(control, tuning);
    speed_control_reset(control, 0.0f, 0.0f);
}
