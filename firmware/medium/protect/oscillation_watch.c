#include "medium/protect/oscillation_watch.h"

#include <string.h>

#include "math/bounds.h"
#include "math/filter.h"
#include "math/periods.h"

#define PI          3.1415927f
#define FAST_SHARE  0.5f   /* [-] of the tracking loop's bandwidth: higher frequencies are noise */
#define GROWS_BY    1.1f   /* [-] from block to block */
#define GROWN_LEAST 0.005f /* [-] of the current limit */
#define SUSTAINED   0.1f   /* [-] of the current limit */
#define SHORTEST    3u     /* [steps] of a half-wave */
#define IRREGULAR   3u     /* tolerance: this part of the last half-wave, and a step */

oscillation_watch_tuning_t oscillation_watch_prepare(const oscillation_watch_params_t *params)
{
    const float period = params->period * (float)params->every;
    const float least = (float)OSCILLATION_WAVES * params->current_limit;
    return (oscillation_watch_tuning_t){
        .slow_share = lowpass_share(params->slow, period),
        .fast_share = lowpass_share(FAST_SHARE * params->fast, period),
        .growing = GROWN_LEAST * least,
        .sustained = SUSTAINED * least,
        .longest = periods_of(PI / params->slow, period),
    };
}

void oscillation_watch_init(oscillation_watch_t *watch, const oscillation_watch_tuning_t *tuning)
{
    memset(watch, 0, sizeof *watch);
    oscillation_watch_take(watch, tuning);
}

static void begin_anew(oscillation_watch_t *watch)
{
    watch->sum = 0.0f;
    watch->before = 0.0f;
    watch->usual = 0u;
    watch->waves = 0u;
    watch->blocks = 0u;
}

/* Judges a complete block. */
static bool judge_block(oscillation_watch_t *watch)
{
    const oscillation_watch_tuning_t *tuning = &watch->tuning;
    const bool grows = watch->before > 0.0f && watch->sum > GROWS_BY * watch->before;
    const bool tells = watch->sum > tuning->sustained || (grows && watch->sum > tuning->growing);
    watch->before = watch->sum;
    watch->sum = 0.0f;
    watch->waves = 0u;
    watch->blocks = tells ? watch->blocks + 1u : 0u;
    if (watch->blocks < OSCILLATION_BLOCKS) {
        return false;
    }
    begin_anew(watch);
    return true;
}

/* True if a complete half-wave has nearly the length of the last one. */
static bool judge_wave(oscillation_watch_t *watch)
{
    const uint32_t usual = watch->usual;
    const uint32_t length = watch->length;
    const uint32_t apart = length > usual ? length - usual : usual - length;
    if (length < SHORTEST || (usual != 0u && apart * IRREGULAR > usual + IRREGULAR)) {
        begin_anew(watch);
    }
    watch->usual = length;
    watch->sum += watch->peak;
    watch->waves++;
    watch->length = 0u;
    watch->peak = 0.0f;
    return watch->waves >= OSCILLATION_WAVES && judge_block(watch);
}

bool oscillation_watch_step(oscillation_watch_t *watch, float i_q_ref, float omega_m_ref)
{
    const oscillation_watch_tuning_t *tuning = &watch->tuning;
    if (watch->begun == 0u || omega_m_ref != watch->reference) {
        watch->slow = i_q_ref;
        watch->fast = 0.0f;
        watch->length = 0u;
        watch->peak = 0.0f;
        watch->begun = 1u;
        watch->reference = omega_m_ref;
        begin_anew(watch);
        return false;
    }
    const float last = watch->fast;
    watch->slow = lowpass_step(watch->slow, tuning->slow_share, i_q_ref);
    watch->fast = lowpass_step(last, tuning->fast_share, i_q_ref - watch->slow);
    const float amount = bounds_magnitude(watch->fast);
    const bool turned = last * watch->fast < 0.0f;
    const bool told = turned && judge_wave(watch);
    watch->peak = amount > watch->peak ? amount : watch->peak;
    watch->length++;
    if (watch->length > tuning->longest) {
        begin_anew(watch);
    }
    return told;
}
