#include "medium/protect/link.h"

#include "math/bounds.h"
#include "math/periods.h"

link_tuning_t link_prepare(const link_params_t *params)
{
    const bool rides = params->ride_time > 0.0f;
    const float over_band = LINK_OVER_BAND * params->overvoltage;
    const float hold_band = LINK_HOLD_BAND * params->undervoltage;
    const float full = LINK_FULL * params->overvoltage;
    const float hold = LINK_HOLD * params->undervoltage;
    const float slow = LINK_FREE * params->resistance * params->current_max / params->torque;
    return (link_tuning_t){
        .current_max = params->current_max,
        .full = full,
        .braking_gain = params->current_max / over_band,
        .braking_from = full - over_band,
        .hold = hold,
        .driving_gain = params->current_max / hold_band,
        .driving_from = rides ? hold + hold_band : 0.0f,
        .undervoltage = params->undervoltage,
        .free_inverse = 1.0f / slow,
        .taken = LINK_TAKEN * params->current_max,
        .gained = slow,
        .back = full - LINK_BACK * params->overvoltage,
        .sink_most = LINK_SINK * params->undervoltage,
        .sink = LINK_SINK * params->undervoltage * (params->period / LINK_SINK_TIME),
        .above = LINK_ABOVE * hold_band,
        .above_sum = LINK_ABOVE * hold_band * (float)periods_of(LINK_FED_TIME, params->period),
        .fed_looks = periods_of(LINK_FED_TIME, params->period),
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
    *x = (link_t){.braking = tuning->current_max, .driving = tuning->current_max};
}

void link_take(link_t *x, const link_tuning_t *tuning)
{
    x->braking = tuning->current_max;
    x->driving = tuning->current_max;
    x->limits = 1u; /* looked at in the next period */
}

/* What may drive a rotor of this speed at a link above u_full [A]. A link that the rotor has filled slows it
 * or leaves it alone: one that becomes faster is driven, and the power comes from a supply. */
static float taken(link_t *x, const link_tuning_t *tuning, float u_dc, float speed)
{
    if (u_dc < tuning->full) {
        x->slowest = speed;
        x->held = u_dc < tuning->back ? 0u : x->held;
    } else if (speed < x->slowest) {
        x->slowest = speed;
    } else if (speed - x->slowest > tuning->gained + LINK_GAINED * x->slowest) {
        x->held = 1u;
    }
    return x->held != 0u ? 0.0f : tuning->taken;
}

void link_limit(link_t *x, const link_tuning_t *tuning, float u_dc, float omega_m)
{
    const float most = tuning->current_max;
    const float speed = bounds_magnitude(omega_m);
    const float slow = 1.0f - speed * tuning->free_inverse;
    const float opened = slow > 0.0f ? slow : 0.0f;
    const float least = -taken(x, tuning, u_dc, speed);
    const float falling = tuning->braking_gain * (tuning->full - u_dc);
    const float braking = falling > least ? (falling < most ? falling : most) : least;
    const float hold = tuning->hold - x->sunk;
    const float driving = tuning->ride_looks == 0u || x->low != 0u
                              ? most
                              : bounds_clamp(tuning->driving_gain * (u_dc - hold), most);
    x->slow = slow > 0.0f ? UINT32_C(1) : UINT32_C(0);
    x->braking = braking + opened * (most - braking);
    x->driving = driving > 0.0f ? driving : driving * (1.0f - opened);
    x->limits = x->braking < most || x->driving < most;
}

static void begin_fed(link_t *x, float before)
{
    x->fed_looks = 0u;
    x->fed_sum = 0.0f;
    x->fed_before = before;
}

/* Is the link fed although the supply seems lost: has a window of looks passed in which it stood so high, and
 * another before it, from which it has not fallen? */
static bool is_fed(link_t *x, const link_tuning_t *tuning, float u_dc)
{
    const bool stays = u_dc > tuning->hold - x->sunk + tuning->above || x->slow != 0u;
    if (!stays || u_dc < tuning->undervoltage) {
        begin_fed(x, 0.0f);
        return false;
    }
    x->fed_sum += u_dc;
    x->fed_looks++;
    if (x->fed_looks < tuning->fed_looks) {
        return false;
    }
    const bool fed = x->fed_before > 0.0f && x->fed_sum >= x->fed_before - tuning->above_sum;
    begin_fed(x, x->fed_sum);
    return fed;
}

/* A link in the band of the driving limit, or below: the hold sinks until it is known who feeds it. */
static void look_in_the_band(link_t *x, const link_tuning_t *tuning, float u_dc)
{
    x->sunk += x->sunk < tuning->sink_most ? tuning->sink : 0.0f;
    if (is_fed(x, tuning, u_dc)) {
        x->low = 1u;
        x->lost_looks = 0u;
    }
}

/* Is the supply there? */
static void look_at_supply(link_t *x, const link_tuning_t *tuning, float u_dc)
{
    const float lost_below = x->low != 0u ? tuning->undervoltage : tuning->hold;
    const float back_above = x->low != 0u ? tuning->undervoltage : tuning->driving_from;
    if (u_dc < lost_below || (x->lost_looks != 0u && u_dc < back_above)) {
        x->lost_looks += x->lost_looks <= tuning->ride_looks ? 1u : 0u;
    } else {
        x->lost_looks = 0u;
    }
    if (u_dc >= tuning->driving_from) {
        x->low = 0u;
        x->sunk = 0.0f;
        begin_fed(x, 0.0f);
    } else if (x->low == 0u) {
        look_in_the_band(x, tuning, u_dc);
    }
    if (u_dc < tuning->undervoltage) {
        x->low_looks += x->low_looks < 2u ? 1u : 0u;
    } else {
        x->low_looks = 0u;
    }
}

static void look_at_ripple(link_t *x, const link_tuning_t *tuning, float u_dc)
{
    x->largest = u_dc > x->largest ? u_dc : x->largest;
    x->smallest = u_dc < x->smallest ? u_dc : x->smallest;
    x->looks++;
    if (x->looks >= tuning->window_looks) {
        x->ripple = x->largest - x->smallest;
        const bool ripples = x->ripple > LINK_RIPPLE * x->largest;
        x->rippled = ripples ? x->rippled + (x->rippled < LINK_WINDOWS ? 1u : 0u) : 0u;
        begin_window(x, u_dc);
    }
}

void link_look(link_t *x, const link_tuning_t *tuning, float u_dc)
{
    look_at_supply(x, tuning, u_dc);
    look_at_ripple(x, tuning, u_dc);
    const bool excuses = link_excuses(x, tuning);
    x->conditions = (x->limits != 0u ? LINK_LIMITS : 0u) | (x->rippled >= LINK_WINDOWS ? LINK_RIPPLES : 0u) |
                    (x->low_looks >= 2u && excuses ? LINK_SINKS : 0u) | (excuses ? 0u : LINK_LOST);
}
