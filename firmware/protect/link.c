#include "protect/link.h"

#include "math/bounds.h"
#include "math/periods.h"

link_tuning_t link_prepare(const link_params_t *params)
{
    const bool rides = params->ride_time > 0.0f;
    const float over_band = LINK_OVER_BAND * params->overvoltage;
    const float hold_band = LINK_HOLD_BAND * params->undervoltage;
    const float full = LINK_FULL * params->overvoltage;
    const float hold = LINK_HOLD * params->undervoltage;
    return (link_tuning_t){
        .current_max = params->current_max,
        .full = full,
        .braking_gain = params->current_max / over_band,
        .braking_from = full - over_band,
        .hold = hold,
        .driving_gain = params->current_max / hold_band,
        .driving_from = rides ? hold + hold_band : 0.0f,
        .undervoltage = params->undervoltage,
        .free_inverse = params->torque / (LINK_FREE * params->resistance * params->current_max),
        .ride_looks = periods_of(params->ride_time, params->period),
        .window_looks = periods_of(LINK_WINDOW, params->period),
    };
}

static void begin_window(link_t *x, float u_dc)
{
    x->largest = u_dc;
    x->smallest = u_dc;
    x->looks = 0u;
}

void link_init(link_t *x, const link_tuning_t *tuning)
{
    *x = (link_t){.tuning = *tuning, .braking = tuning->current_max, .driving = tuning->current_max};
}

void link_take(link_t *x, const link_tuning_t *tuning)
{
    x->tuning = *tuning;
    x->braking = tuning->current_max;
    x->driving = tuning->current_max;
    x->limits = 1u; /* looked at in the next period */
}

void link_limit(link_t *x, float u_dc, float omega_m)
{
    const link_tuning_t *tuning = &x->tuning;
    const float most = tuning->current_max;
    const float slow = 1.0f - bounds_magnitude(omega_m) * tuning->free_inverse;
    const float opened = slow > 0.0f ? slow : 0.0f;
    const float braking = bounds_clamp(tuning->braking_gain * (tuning->full - u_dc), most);
    const float driving =
        tuning->ride_looks == 0u ? most : bounds_clamp(tuning->driving_gain * (u_dc - tuning->hold), most);
    x->braking = braking + opened * (most - braking);
    x->driving = driving > 0.0f ? driving : driving * (1.0f - opened);
    x->limits = x->braking < most || x->driving < most;
}

/* Is the supply there? */
static void look_at_supply(link_t *x, float u_dc)
{
    const link_tuning_t *tuning = &x->tuning;
    if (u_dc < tuning->hold || (x->lost_looks != 0u && u_dc < tuning->driving_from)) {
        x->lost_looks += x->lost_looks <= tuning->ride_looks ? 1u : 0u;
    } else {
        x->lost_looks = 0u;
    }
    if (u_dc < tuning->undervoltage) {
        x->low_looks += x->low_looks < 2u ? 1u : 0u;
    } else {
        x->low_looks = 0u;
    }
}

static void look_at_ripple(link_t *x, float u_dc)
{
    x->largest = u_dc > x->largest ? u_dc : x->largest;
    x->smallest = u_dc < x->smallest ? u_dc : x->smallest;
    x->looks++;
    if (x->looks >= x->tuning.window_looks) {
        x->ripple = x->largest - x->smallest;
        const bool ripples = x->ripple > LINK_RIPPLE * x->largest;
        x->rippled = ripples ? x->rippled + (x->rippled < LINK_WINDOWS ? 1u : 0u) : 0u;
        begin_window(x, u_dc);
    }
}

void link_look(link_t *x, float u_dc)
{
    look_at_supply(x, u_dc);
    look_at_ripple(x, u_dc);
    const bool excuses = link_excuses(x);
    x->conditions = (x->limits != 0u ? LINK_LIMITS : 0u) | (x->rippled >= LINK_WINDOWS ? LINK_RIPPLES : 0u) |
                    (x->low_looks >= 2u && excuses ? LINK_SINKS : 0u) | (excuses ? 0u : LINK_LOST);
}
