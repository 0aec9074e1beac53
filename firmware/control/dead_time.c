#include "control/dead_time.h"

/* A zone of no width: any current but 0 has its full sign [A]. */
#define HARD_SIGN 1e-30f

void dead_time_init(dead_time_t *dead_time, const dead_time_params_t *params)
{
    dead_time_retune(dead_time, params);
}

void dead_time_retune(dead_time_t *dead_time, const dead_time_params_t *params)
{
    float effective = params->dead_time + params->turn_on_delay - params->turn_off_delay;
    dead_time->volt_per_volt = params->gain * effective / params->period;
    dead_time->drop = params->gain * params->drop;
    dead_time->zone = params->current_zone > HARD_SIGN ? params->current_zone : HARD_SIGN;
    dead_time->per_zone = 1.0f / dead_time->zone;
}

static float greater(float x, float y)
{
    return x > y ? x : y;
}

static float lesser(float x, float y)
{
    return x < y ? x : y;
}

dead_time_range_t dead_time_range(ab_t current)
{
    abc_t phases = frames_inverse_clarke(current);
    float a = bounds_magnitude(phases.a);
    float b = bounds_magnitude(phases.b);
    float c = bounds_magnitude(phases.c);
    return (dead_time_range_t){lesser(lesser(a, b), c), greater(greater(a, b), c)};
}
