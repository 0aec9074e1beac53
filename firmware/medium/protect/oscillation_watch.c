#include "medium/protect/oscillation_watch.h"

#include <string.h>

#include "math/bounds.h"
#include "math/filter.h"
#include "math/periods.h"

#define TWO_PI      6.2831853f
#define FAST_SHARE  0.5f   /* [-] of the tracking loop's bandwidth: higher frequencies are noise */
#define GROWS_BY    1.1f   /* [-] a step of growth, or of decay */
#define GROWN_LEAST 0.005f /* [-] of the current limit */
#define SUSTAINED   0.1f   /* [-] of the current limit */
#define RISES_BY    1.15f  /* [-] a wave over the last one */
#define BEGINS      0.02f  /* [-] of the current limit */
#define SHORTEST    6u     /* [steps] of a wave */
#define IRREGULAR   5u     /* tolerance: this part of the first wave, and a step */
#define SLOWEST     32u    /* [waves] longest step of growth */

oscillation_watch_tuning_t oscillation_watch_prepare(const oscillation_watch_params_t *params)
{
    const float period = params->period * (float)params->every;
    const float least = 2.0f * (float)OSCILLATION_WAVES * params->current_limit;
    return (oscillation_watch_tuning_t){
        .slow_share = lowpass_share(params->slow, period),
        .fast_share = lowpass_share(FAST_SHARE * params->fast, period),
        .growing = GROWN_LEAST * least,
        .sustained = SUSTAINED * least,
        .begins = 2.0f * BEGINS * params->current_limit,
        .longest = periods_of(TWO_PI / params->slow, period),
    };
}

void oscillation_watch_init(oscillation_watch_t *watch, const oscillation_watch_tuning_t *tuning)
{
    memset(watch, 0, sizeof *watch);
    oscillation_watch_take(watch, tuning);
}

/* The count begins with a wave of this length [steps] and this sum [A]; 0: none yet. */
static void begin_anew(oscillation_watch_t *watch, uint32_t length, float wave)
{
    watch->sum = 0.0f;
    watch->wave = 0.0f;
    watch->last = wave;
    watch->rises = 0u;
    watch->step = 0.0f;
    watch->first = length;
    watch->waves = 0u;
    watch->growths = 0u;
    watch->large = 0u;
}

/* A step of growth or decay ends with a block of this sum [A]. */
static void end_step(oscillation_watch_t *watch, float sum, uint32_t growths)
{
    watch->step = sum;
    watch->growths = growths;
    watch->waves = 0u;
}

/* True if a complete block makes the oscillation certain. */
static bool judge_block(oscillation_watch_t *watch)
{
    const oscillation_watch_tuning_t *tuning = &watch->tuning;
    const float sum = watch->sum;
    const float step = watch->step;
    watch->sum = 0.0f;
    watch->large = sum > tuning->sustained ? watch->large + 1u : 0u;
    if (step > 0.0f && sum > GROWS_BY * step) {
        end_step(watch, sum, watch->growths + 1u);
    } else if (step == 0.0f || GROWS_BY * sum < step || watch->waves >= SLOWEST) {
        end_step(watch, sum, 0u);
    }
    const bool grown = watch->growths >= OSCILLATION_GROWTHS && sum > tuning->growing;
    return grown || watch->large >= OSCILLATION_SUSTAINED;
}

/* True if this wave with this sum [A] is the last one of a rise. */
static bool judge_rise(oscillation_watch_t *watch, float wave)
{
    watch->rises = wave > RISES_BY * watch->last ? watch->rises + 1u : 0u;
    watch->last = wave;
    return watch->rises >= OSCILLATION_RISES && wave > watch->tuning.begins;
}

/* Counts a complete wave of nearly the length of the first one. */
static oscillation_t judge_wave(oscillation_watch_t *watch)
{
    const uint32_t first = watch->first;
    const uint32_t length = watch->length;
    const uint32_t apart = length > first ? length - first : first - length;
    const float wave = watch->wave;
    watch->length = 0u;
    if (first == 0u || length < SHORTEST || apart * IRREGULAR > first + IRREGULAR) {
        begin_anew(watch, length, wave);
        return OSCILLATION_NONE;
    }
    watch->wave = 0.0f;
    watch->sum += wave;
    watch->waves++;
    const bool begins = judge_rise(watch, wave);
    if (watch->waves % OSCILLATION_WAVES != 0u || !judge_block(watch)) {
        return begins ? OSCILLATION_BEGINS : OSCILLATION_NONE;
    }
    begin_anew(watch, 0u, 0.0f);
    return OSCILLATION_CERTAIN;
}

oscillation_t oscillation_watch_step(oscillation_watch_t *watch, float i_q_ref, float omega_m_ref)
{
    const oscillation_watch_tuning_t *tuning = &watch->tuning;
    if (watch->length == 0u || omega_m_ref != watch->reference) {
        watch->slow = i_q_ref;
        watch->fast = 0.0f;
        watch->length = 1u;
        watch->peak = 0.0f;
        watch->reference = omega_m_ref;
        begin_anew(watch, 0u, 0.0f);
        return OSCILLATION_NONE;
    }
    const float last = watch->fast;
    watch->slow = lowpass_step(watch->slow, tuning->slow_share, i_q_ref);
    watch->fast = lowpass_step(last, tuning->fast_share, i_q_ref - watch->slow);
    const float amount = bounds_magnitude(watch->fast);
    oscillation_t found = OSCILLATION_NONE;
    if (last * watch->fast < 0.0f) {
        watch->wave += watch->peak;
        watch->peak = 0.0f;
        if (watch->fast > 0.0f) {
            found = judge_wave(watch);
        }
    }
    watch->peak = bounds_more(watch->peak, amount);
    watch->length++;
    if (watch->length > tuning->longest) {
        begin_anew(watch, 0u, 0.0f);
    }
    return found;
}
