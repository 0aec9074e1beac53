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

/* true: a phase has almost no current, as behind an open wire. */
static bool is_alone(const still_watch_tuning_t *tuning, abc_t current)
{
    return bounds_within(current.a, tuning->none) || bounds_within(current.b, tuning->none) ||
           bounds_within(current.c, tuning->none);
}

/* One period of sensor `n`, whose value differs from the reference by `miss` [A]. true: it is stuck. */
static inline bool is_stuck(still_watch_t *watch, const still_watch_tuning_t *tuning, uint32_t n, float miss,
                            abc_t current)
{
    const uint32_t still = watch->still[n];
    const uint32_t before = still <= STILL_SOME ? 0u : watch->off[n];
    watch->off[n] = 0u;
    if (still < STILL_SOME || bounds_within(miss, tuning->off)) {
        return false;
    }
    const bool alone = is_alone(tuning, current);
    if (alone && bounds_within(miss, tuning->far)) {
        return false;
    }
    watch->off[n] = before + 1u;
    return watch->off[n] >= OFF_PERIODS && (!alone || still >= ALONE);
}

bool still_watch_judge(still_watch_t *watch, const still_watch_tuning_t *tuning, abc_t asked, abc_t current,
                       bool limited, float u_dc)
{
    if (limited && !(u_dc > tuning->slow)) {
        watch->off[0] = 0u;
        watch->off[1] = 0u;
        watch->off[2] = 0u;
        return false;
    }
    const bool a = is_stuck(watch, tuning, 0u, asked.a - watch->value[0], current);
    const bool b = is_stuck(watch, tuning, 1u, asked.b - watch->value[1], current);
    const bool c = tuning->sensors == 3u && is_stuck(watch, tuning, 2u, asked.c - watch->value[2], current);
    return a || b || c;
}
