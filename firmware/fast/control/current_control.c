#include "fast/control/current_control.h"

#include "math/bounds.h"
#include "math/root.h"

#define HELD_MOST                                                                                            \
    0.25f /* [-] of kp and bandwidth: with R = 0 both poles of the response to an EMF are equal */

float current_control_integral(const current_control_params_t *params)
{
    const float most = HELD_MOST * params->inductance_q * params->bandwidth * params->bandwidth;
    return bounds_more(params->resistance * params->bandwidth, bounds_less(params->held, most));
}

current_control_tuning_t current_control_prepare(const current_control_params_t *params)
{
    const float ki = params->resistance * params->bandwidth;
    const float gain = params->bandwidth * params->period;
    const float slow = 0.5f + 0.5f * root_or_none(1.0f - 4.0f * gain);
    return (current_control_tuning_t){
        .reactance = {params->inductance_d / params->period, params->inductance_q / params->period},
        .share = slow - 0.5f * gain,
        .d = pi_prepare(params->inductance_d * params->bandwidth, ki, params->period),
        .q = pi_prepare(params->inductance_q * params->bandwidth, current_control_integral(params),
                        params->period),
    };
}

void current_control_init(current_control_t *control, const current_control_tuning_t *tuning)
{
    current_control_take(control, tuning);
    current_control_reset(control, (dq_t){0.0f, 0.0f});
}

void current_control_reset(current_control_t *control, dq_t integral)
{
    pi_reset(&control->d, integral.d);
    pi_reset(&control->q, integral.q);
    control->current_err = (dq_t){0.0f, 0.0f};
    control->voltage_ref = (dq_t){0.0f, 0.0f};
}
