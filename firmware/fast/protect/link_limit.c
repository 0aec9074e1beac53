#include "fast/protect/link_limit.h"

#include "math/bounds.h"

link_limit_tuning_t link_limit_prepare(const link_limit_params_t *params)
{
    const float over_band = LINK_OVER_BAND * params->overvoltage;
    const float hold_band = LINK_HOLD_BAND * params->undervoltage;
    const float full = LINK_FULL * params->overvoltage;
    const float hold = LINK_HOLD * params->undervoltage;
    const float slow = LINK_FREE * params->resistance * params->current_max / params->torque;
    return (link_limit_tuning_t){
        .current_max = params->current_max,
        .full = full,
        .braking_gain = params->current_max / over_band,
        .braking_from = full - over_band,
        .hold = hold,
        .driving_gain = params->current_max / hold_band,
        .driving_from = params->rides ? hold + hold_band : 0.0f,
        .rides = params->rides ? UINT32_C(1) : UINT32_C(0),
        .free_inverse = 1.0f / slow,
        .taken = LINK_TAKEN * params->current_max,
        .gained = slow,
        .back = full - LINK_BACK * params->overvoltage,
    };
}

void link_limit_init(link_limit_t *x, const link_limit_tuning_t *tuning)
{
    *x = (link_limit_t){.braking = tuning->current_max, .driving = tuning->current_max};
}

void link_limit_take(link_limit_t *x, const link_limit_tuning_t *tuning)
{
    if (x->limits == 0u) { /* otherwise both are computed in the next period */
        x->braking = tuning->current_max;
        x->driving = tuning->current_max;
    }
}

/* The current that may drive a rotor of this speed at a link above u_full [A]. A link that the rotor has
 * filled only brakes the rotor. If the rotor accelerates, the power comes from a supply. */
static float taken(link_limit_t *x, const link_limit_tuning_t *tuning, float u_dc, float speed)
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

void link_limit_step(link_limit_t *x, const link_limit_tuning_t *tuning, float u_dc, float omega_m)
{
    const float most = tuning->current_max;
    const float speed = bounds_magnitude(omega_m);
    const float slow = 1.0f - speed * tuning->free_inverse;
    const float opened = slow > 0.0f ? slow : 0.0f;
    const float least = -taken(x, tuning, u_dc, speed);
    const float falling = tuning->braking_gain * (tuning->full - u_dc);
    const float braking = falling > least ? (falling < most ? falling : most) : least;
    const float hold = tuning->hold - x->sunk;
    const float driving =
        tuning->rides == 0u || x->low != 0u ? most : bounds_clamp(tuning->driving_gain * (u_dc - hold), most);
    x->slow = slow > 0.0f ? UINT32_C(1) : UINT32_C(0);
    x->braking = braking + opened * (most - braking);
    x->driving = driving > 0.0f ? driving : driving * (1.0f - opened);
    x->limits = x->braking < most || x->driving < most;
}
