#include "fast/protect/still_watch.h"

#include "math/winding.h"

#define OFF_SHARE  0.05f   /* [-] of the range */
#define NONE_SHARE 0.0075f /* [-] of the range: largest value of a phase without current */
#define PUSH_SHARE 0.02f   /* [-] of the range: change of the current by a jump of the voltage, 40 codes */
/* [periods] sum of the distances from the first of three periods to the others, one and two */
#define PUSH_TURN 3.0f

still_watch_tuning_t still_watch_prepare(const still_watch_params_t *params)
{
    const uint32_t sensors = params->three_sensors ? UINT32_C(3) : UINT32_C(2);
    return (still_watch_tuning_t){
        .sensors = params->judged ? sensors : 0u,
        .off = OFF_SHARE * params->range,
        .gain = params->gain,
        .held = STILL_HELD_DEAD * params->drop,
        .none = NONE_SHARE * params->range,
        .slow = winding_slow_link(params->inductance, params->range, params->period),
        .push =
            PUSH_SHARE * params->range * params->inductance / params->period + STILL_PUSH_DEAD * params->drop,
        .push_link = STILL_PUSH_DEAD * params->dead_time / params->period,
        .turn = PUSH_TURN * params->period,
    };
}
