#include "medium/protect/link_watch.h"

#include "math/periods.h"

link_watch_tuning_t link_watch_prepare(const link_watch_params_t *params)
{
    return (link_watch_tuning_t){
        .undervoltage = params->undervoltage,
        .hold = params->hold,
        .driving_from = params->driving_from,
        .sink_most = LINK_SINK * params->undervoltage,
        .sink = LINK_SINK * params->undervoltage * (params->period / LINK_SINK_TIME),
        .above = LINK_ABOVE * params->band,
        .above_sum = LINK_ABOVE * params->band * (float)periods_of(LINK_FED_TIME, params->period),
        .fed_looks = periods_of(LINK_FED_TIME, params->period),
        .ride_looks = periods_of(params->ride_time, params->period),
        .window_looks = periods_of(LINK_WINDOW, params->period),
    };
}

static void begin_window(link_watch_t *x, float u_dc)
{
    x->largest = u_dc;
    x->smallest = u_dc;
    x->looks = 0u;
}

static void begin_fed(link_watch_t *x, float before)
{
    x->fed_looks = 0u;
    x->fed_sum = 0.0f;
    x->fed_before = before;
}

/* True if the link is fed although the supply seems lost: the mean of a complete window is above the
 * threshold and has not fallen from that of the window before. */
static bool is_fed(link_watch_t *x, const link_watch_tuning_t *tuning, const link_watch_input_t *input)
{
    const float u_dc = input->u_dc;
    const bool stays = u_dc > tuning->hold - x->sunk + tuning->above || input->slow != 0u;
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

/* For a link voltage in the band of the driving limit or below: u_hold decreases until it is known whether
 * the rotor or the supply feeds the link. */
static void look_in_the_band(link_watch_t *x, const link_watch_tuning_t *tuning,
                             const link_watch_input_t *input)
{
    x->sunk += x->sunk < tuning->sink_most ? tuning->sink : 0.0f;
    if (is_fed(x, tuning, input)) {
        x->low = 1u;
        x->lost_looks = 0u;
    }
}

/* Judges whether the supply is present. */
static void look_at_supply(link_watch_t *x, const link_watch_tuning_t *tuning,
                           const link_watch_input_t *input)
{
    const float u_dc = input->u_dc;
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
        look_in_the_band(x, tuning, input);
    }
    if (u_dc < tuning->undervoltage) {
        x->low_looks += x->low_looks < 2u ? 1u : 0u;
    } else {
        x->low_looks = 0u;
    }
}

static void look_at_ripple(link_watch_t *x, const link_watch_tuning_t *tuning, float u_dc)
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

void link_watch_step(link_watch_t *x, const link_watch_tuning_t *tuning, const link_watch_input_t *input)
{
    look_at_supply(x, tuning, input);
    look_at_ripple(x, tuning, input->u_dc);
    const bool excuses = link_watch_excuses(x, tuning);
    x->conditions = (input->limits != 0u ? LINK_LIMITS : 0u) |
                    (x->rippled >= LINK_WINDOWS ? LINK_RIPPLES : 0u) |
                    (x->low_looks >= 2u && excuses ? LINK_SINKS : 0u) | (excuses ? 0u : LINK_LOST);
}
