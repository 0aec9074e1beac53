#include "medium/adapt/inertia.h"

#include "math/filter.h"

inertia_tuning_t inertia_prepare(const inertia_params_t *params)
{
    const float tail = INERTIA_TAIL / params->period;
    const float impulse =
        1.5f * params->pole_pairs * params->pole_pairs * params->flux_linkage * params->period;
    return (inertia_tuning_t){
        .from = params->from,
        .impulse = impulse,
        .gain = impulse / params->inertia,
        .load_share = lowpass_share(INERTIA_LOAD_CUTOFF, params->period),
        .torque = INERTIA_TORQUE_LEAST * params->current_max,
        .half_per_tail = 0.5f / tail,
        .tail_steps = (uint32_t)tail,
        .most_steps = (uint32_t)(INERTIA_LONGEST / params->period),
        .on = params->on ? 1u : 0u,
    };
}

static void start(inertia_t *x)
{
    x->learnt = (learnt_value_t){x->tuning.from, x->tuning.from};
    x->said[0] = x->tuning.from;
    x->said[1] = x->tuning.from;
    inertia_rest(x);
}

void inertia_init(inertia_t *x, const inertia_tuning_t *tuning)
{
    x->tuning = *tuning;
    x->omega_ref = 0.0f;
    start(x);
}

void inertia_take(inertia_t *x, const inertia_tuning_t *tuning)
{
    x->tuning = *tuning;
    if (tuning->from != x->learnt.from || tuning->on == 0u) {
        start(x);
    }
}

void inertia_begin(inertia_t *x, float omega)
{
    x->under_way = 1u;
    x->through = 0u;
    x->near = 0u;
    x->sound = 1u;
    x->steps = 0u;
    x->left = 0u;
    x->omega = omega;
    x->sum = 0.0f;
}

/* The median of three values. */
static float median(float a, float b, float c)
{
    const float more = a > b ? a : b;
    const float less = a > b ? b : a;
    return c > more ? more : (c < less ? less : c);
}

/* Processes the J [kg m^2], finite and above 0, that a change of the speed has given. */
static void hear(inertia_t *x, float said)
{
    const float least = x->tuning.from * (1.0f / INERTIA_RANGE);
    const float most = x->tuning.from * INERTIA_RANGE;
    const float next = said < most ? (said > least ? said : least) : most;
    x->learnt.value = median(next, x->said[0], x->said[1]);
    x->said[1] = x->said[0];
    x->said[0] = next;
}

void inertia_end(inertia_t *x, float omega)
{
    const inertia_tuning_t *tuning = &x->tuning;
    const float way = (float)(x->steps - tuning->tail_steps);
    const float gained = x->omega_arrived - x->omega;
    const float gained_tail = omega - x->omega_arrived;
    const float sum_tail = x->sum - x->sum_arrived;
    const float r = tuning->half_per_tail * way;
    const float turned = gained - r * gained_tail;
    const float pushed = x->sum_arrived - r * sum_tail;
    x->under_way = 0u;
    x->left = tuning->tail_steps;
    if (x->sound == 0u || x->steps > tuning->most_steps || bounds_within(gained, INERTIA_SPEED_LEAST) ||
        !(bounds_magnitude(x->sum_arrived) > tuning->torque * way)) {
        return;
    }
    /* c t_way, times dw/S */
    const float added = 2.0f * r * (sum_tail * turned - gained_tail * pushed);
    if (turned * pushed > 0.0f &&
        bounds_within(added, INERTIA_LOAD_MOST * bounds_magnitude(x->sum_arrived * turned))) {
        hear(x, tuning->impulse * pushed / turned);
    }
}
