#include "medium/protect/supply_limit.h"

#include <float.h>

#include "math/bounds.h"
#include "math/filter.h"
#include "math/root.h"

supply_limit_tuning_t supply_limit_prepare(const supply_limit_params_t *params)
{
    return (supply_limit_tuning_t){
        .on = params->drawn > 0.0f || params->back > 0.0f ? UINT32_C(1) : UINT32_C(0),
        .drawn = params->drawn > 0.0f ? params->drawn : FLT_MAX,
        .back = params->back > 0.0f ? params->back : FLT_MAX,
        .current_max = params->current_max,
        .loss = 1.5f * params->resistance,
        .sixfold = 6.0f * params->resistance,
        .free_inverse = 1.0f / params->free_emf,
        .third_inverse = 1.0f / (3.0f * params->resistance),
        .torque = params->torque,
        .drop = params->drop,
        .share = lowpass_share(1.0f / SUPPLY_LIMIT_TIME, params->period),
    };
}

/* Nothing is limited. */
static void unlimited(supply_limit_t *x, const supply_limit_tuning_t *tuning)
{
    x->driving = tuning->current_max;
    x->braking = tuning->current_max;
    x->limits = 0u;
}

void supply_limit_reset(supply_limit_t *x, const supply_limit_tuning_t *tuning)
{
    x->current = 0.0f;
    x->rest = 0.0f;
    unlimited(x, tuning);
}

/* The smaller root of 1.5 R i^2 - e i + power = 0, or the positive one of 1.5 R i^2 + e i - power = 0: both
 * are 2 power/(e + root), root = sqrt(e^2 -+ 6 R power), a form without the difference of two near numbers.
 * Not below zero. */
static float smaller(float power, float e, float root)
{
    const float sum = e + root;
    return power > 0.0f && sum > 0.0f ? 2.0f * power / sum : 0.0f;
}

/* The limits for the largest power that may be drawn, and the largest that may be returned [W], in addition
 * to the power P_r; `e` is K_t |omega_m| [V]. */
static void limit(supply_limit_t *x, const supply_limit_tuning_t *tuning, float drawn, float back, float e)
{
    const float most = tuning->current_max;
    x->driving = most;
    x->braking = most;
    if (drawn < FLT_MAX) {
        const float root = root_or_none(e * e + tuning->sixfold * drawn);
        x->driving = bounds_less(smaller(drawn, e, root), most);
        x->braking = bounds_less(tuning->third_inverse * (e + root), most);
    }
    /* negative: no braking current returns that much, because the copper loss is larger */
    const float square = back < FLT_MAX ? e * e - tuning->sixfold * back : -1.0f;
    if (square > 0.0f) {
        const float opened = bounds_more(1.0f - e * tuning->free_inverse, 0.0f);
        const float least = smaller(back, e, root_or_none(square));
        x->braking = bounds_less(least + opened * (most - least), x->braking);
    }
}

/* 1: i_q has reached the limit by the supply, which is below that of the drive. */
static uint32_t reached(float i, float limit, float most)
{
    return limit < most && i > SUPPLY_LIMIT_NEAR * limit ? UINT32_C(1) : UINT32_C(0);
}

void supply_limit_step(supply_limit_t *x, const supply_limit_tuning_t *tuning,
                       const supply_limit_input_t *input)
{
    if (input->conducting == 0u || !(input->u_dc > 0.0f)) {
        supply_limit_reset(x, tuning);
        return;
    }
    const float power = input->power + tuning->drop * input->magnitudes;
    x->current = lowpass_step(x->current, tuning->share, power / input->u_dc);
    if (input->in_rotor == 0u) {
        x->rest = 0.0f;
        unlimited(x, tuning);
        return;
    }
    const float torque = tuning->torque * input->torque_share;
    const float model = (tuning->loss * input->i_q + torque * input->omega_m) * input->i_q;
    x->rest = lowpass_step(x->rest, tuning->share, power - model);
    const float drawn = tuning->drawn < FLT_MAX ? tuning->drawn * input->u_dc - x->rest : FLT_MAX;
    const float back = tuning->back < FLT_MAX ? tuning->back * input->u_dc + x->rest : FLT_MAX;
    limit(x, tuning, drawn, back, torque * bounds_magnitude(input->omega_m));
    const float forward = input->omega_m < 0.0f ? -input->i_q : input->i_q;
    x->limits = reached(forward, x->driving, tuning->current_max) |
                reached(-forward, x->braking, tuning->current_max);
}
