#include "medium/manoeuvre/speed_control.h"

speed_control_tuning_t speed_control_prepare(const speed_control_params_t *params)
{
    speed_control_tuning_t tuning = {params->current_limit, params->kp * (1.0f - params->weight),
                                     pi_prepare(params->kp, params->ki, params->period)};
    const float share = pi_prepare(params->kp * params->weight, params->ki, params->period).back_gain;
    const float most = params->period / SPEED_CONTROL_BACK_TIME;
    tuning.pi.back_gain = share < most ? share : most;
    return tuning;
}

void speed_control_init(speed_control_t *control, const speed_control_tuning_t *tuning)
{
    *control = (speed_control_t){.kick = tuning->kick};
    speed_control_take(control, tuning, 0.0f);
    speed_control_reset(control, 0.0f, 0.0f);
}
