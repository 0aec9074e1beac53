#include "fast/protect/still_watch.h"

#include "math/bounds.h"
#include "math/winding.h"

#define OFF_SHARE   0.05f   /* [-] of the range */
#define FAR_SHARE   0.15f   /* [-] of the range */
#define NONE_SHARE  0.0075f /* [-] of the range: largest value of a phase without current */
#define OFF_PERIODS 4u      /* [periods]: a step of the reference is visible in the third sample */
#define ALONE       8u      /* [periods] without a change, where a phase has almost no current */

still_watch_tuning_t still_watch_prepare(const still_watch_params_t *params)
{
    const uint32_t sensors = params->three_sensors ? UINT32_C(3) : UINT32_C(2);
    return (still_watch_tuning_t){
        .sensors = params->judged ? sensors : 0u,
        .off = OFF_SHARE * params->range,
        .far = FAR_SHARE * params->range,
        .none = NONE_SHARE * params->range,
        .slow = winding_slow_link(params->inductance, params->range, params->period),
    };
}

bool still_watch_judge(still_watch_t *watch, const still_watch_tuning_t *tuning, abc_t asked, abc_t current,
                       bool limited, float u_dc)
{
    const float wanted[3] = {asked.a, asked.b, asked.c};
    const bool alone = bounds_within(current.a, tuning->none) || bounds_within(current.b, tuning->none) ||
                       bounds_within(current.c, tuning->none);
    const float most = alone ? tuning->far : tuning->off;
    const bool counts = !limited || u_dc > tuning->slow;
    bool stuck = false;
    for (uint32_t n = 0; n < tuning->sensors; n++) {
        if (watch->still[n] <= STILL_SOME) {
            watch->off[n] = 0u;
        }
        const bool off =
            watch->still[n] >= STILL_SOME && counts && !bounds_within(wanted[n] - watch->value[n], most);
        watch->off[n] = off ? watch->off[n] + 1u : 0u;
        stuck = stuck || (watch->off[n] >= OFF_PERIODS && (!alone || watch->still[n] >= ALONE));
    }
    return stuck;
}
