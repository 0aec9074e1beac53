#include "fast/inverter/dead_time.h"

/* The narrowest zone [A]: a hundred times wider than the rounding of currents of 100 A. */
#define HARD_SIGN 1e-3f

dead_time_tuning_t dead_time_prepare(const dead_time_params_t *params)
{
    const float effective = params->dead_time + params->turn_on_delay - params->turn_off_delay;
    const float zone = params->current_zone > HARD_SIGN ? params->current_zone : HARD_SIGN;
    return (dead_time_tuning_t){
        .volt_per_volt = effective / params->period,
        .drop = params->drop,
        .per_zone = 1.0f / zone,
    };
}
