#include "control/dead_time.h"

/* 1/zone of a zone of no width: any current but 0 has its full sign [1/A]. */
#define HARD_SIGN 1e30f

void dead_time_init(dead_time_t *dead_time, const dead_time_params_t *params)
{
    dead_time_retune(dead_time, params);
}

void dead_time_retune(dead_time_t *dead_time, const dead_time_params_t *params)
{
    float effective = params->dead_time + params->turn_on_delay - params->turn_off_delay;
    dead_time->volt_per_volt = params->gain * effective / params->period;
    dead_time->drop = params->gain * params->drop;
    dead_time->per_zone = params->current_zone > 0.0f ? 1.0f / params->current_zone : HARD_SIGN;
}

static float saturated(float value)
{
    if (value > 1.0f) {
        return 1.0f;
    }
    return value < -1.0f ? -1.0f : value;
}

ab_t dead_time_voltage(const dead_time_t *dead_time, ab_t current, float u_dc)
{
    float leg = dead_time->volt_per_volt * u_dc + dead_time->drop;
    abc_t lost = frames_inverse_clarke(current);
    lost.a = leg * saturated(lost.a * dead_time->per_zone);
    lost.b = leg * saturated(lost.b * dead_time->per_zone);
    lost.c = leg * saturated(lost.c * dead_time->per_zone);
    return frames_clarke(lost);
}
