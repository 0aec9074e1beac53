#include "control/dead_time.h"

#include "math/bounds.h"

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

static float greater(float x, float y)
{
    return x > y ? x : y;
}

static float lesser(float x, float y)
{
    return x < y ? x : y;
}

dead_time_loss_t dead_time_loss(const dead_time_t *dead_time, ab_t current, float u_dc)
{
    abc_t phases = frames_inverse_clarke(current);
    float a = bounds_magnitude(phases.a);
    float b = bounds_magnitude(phases.b);
    float c = bounds_magnitude(phases.c);

    dead_time_loss_t loss;
    loss.leg = dead_time->volt_per_volt * u_dc + dead_time->drop;
    loss.smallest = lesser(lesser(a, b), c);
    loss.largest = greater(greater(a, b), c);
    phases.a = loss.leg * bounds_clamp(phases.a * dead_time->per_zone, 1.0f);
    phases.b = loss.leg * bounds_clamp(phases.b * dead_time->per_zone, 1.0f);
    phases.c = loss.leg * bounds_clamp(phases.c * dead_time->per_zone, 1.0f);
    loss.voltage = frames_clarke(phases);
    return loss;
}

ab_t dead_time_voltage(const dead_time_t *dead_time, ab_t current, float u_dc)
{
    return dead_time_loss(dead_time, current, u_dc).voltage;
}
