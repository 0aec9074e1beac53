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
    const float per_change = params->inductance / params->period;
    return (still_watch_tuning_t){
        .sensors = params->judged ? sensors : 0u,
        .off = OFF_SHARE * params->range,
        .gain = params->gain,
        .held = STILL_HELD_DEAD * params->drop,
        .none = NONE_SHARE * params->range,
        .slow = winding_slow_link(params->inductance, params->range, params->period),
        .push = PUSH_SHARE * params->range * per_change + STILL_PUSH_DEAD * params->drop,
        .push_link = STILL_PUSH_DEAD * params->dead_time / params->period,
        .turn = PUSH_TURN * params->period,
        .per_change = per_change,
    };
}

/* True if the mean square of the noise is at least this share of the square of almost no current. */
static bool has_noise(const still_watch_tuning_t *tuning, const still_limits_t *limits, float least)
{
    return limits->noise >= least * tuning->none * tuning->none;
}

void still_watch_forget(still_watch_t *watch)
{
    for (uint32_t n = 0u; n < 3u; n++) {
        watch->off[n] = 0u;
    }
}

still_noise_t still_watch_noise(const still_watch_tuning_t *tuning, const still_limits_t *limits,
                                uint32_t still, float other)
{
    if (still >= STILL_SILENT && has_noise(tuning, limits, STILL_SILENT_LEAST) &&
        !bounds_within(other, STILL_FLOWS * tuning->none)) {
        return STILL_NOISE_SILENT;
    }
    return has_noise(tuning, limits, STILL_NOISY_LEAST) ? STILL_NOISE_SOON : STILL_NOISE_NONE;
}

bool still_watch_is_alone(const still_watch_tuning_t *tuning, const abc_t *current)
{
    return tuning->sensors < 3u &&
           (bounds_within(current->a, tuning->none) || bounds_within(current->b, tuning->none) ||
            bounds_within(current->c, tuning->none));
}

uint32_t still_watch_verdict(const still_watch_tuning_t *tuning, const still_limits_t *limits, uint32_t n,
                             uint32_t still, float miss, still_noise_t noise)
{
    const bool sure = noise == STILL_NOISE_SILENT || !still_watch_is_alone(tuning, limits->current) ||
                      (noise == STILL_NOISE_SOON && still >= STILL_NOISY) ||
                      (still >= STILL_ALONE && !bounds_within(miss, STILL_FAR * limits->off));
    return sure ? STILL_WATCH_STUCK : still >= STILL_WIRED ? STILL_WATCH_OPEN << n : 0u;
}
