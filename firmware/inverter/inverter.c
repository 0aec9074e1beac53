#include "inverter/inverter.h"

#include <stdint.h>

#include "inverter/svpwm.h"

inverter_tuning_t inverter_prepare(const inverter_params_t *params)
{
    dead_time_params_t all = params->dead_time;
    all.gain = 1.0f;
    return (inverter_tuning_t){
        .compensated = dead_time_prepare(&params->dead_time),
        .lost = dead_time_prepare(&all),
        .duty_min = params->duty_min,
        .duty_max = params->duty_max,
        .duty_counts = params->duty_counts,
        .per_count = 1.0f / params->duty_counts,
    };
}

void inverter_init(inverter_t *inverter, const inverter_tuning_t *tuning)
{
    const ab_t none = {0.0f, 0.0f};
    inverter_take(inverter, tuning);
    inverter->duty_prev[0] = none;
    inverter->duty_prev[1] = none;
    inverter->current_prev = none;
    inverter->u_dc_prev = 0.0f;
}

void inverter_take(inverter_t *inverter, const inverter_tuning_t *tuning)
{
    inverter->tuning = *tuning;
}

/* The nearest duty that the compare registers can hold: what the observer is told is then what acts. */
static float whole_counts(const inverter_t *inverter, float duty)
{
    return (float)(int32_t)(duty * inverter->tuning.duty_counts + 0.5f) * inverter->tuning.per_count;
}

inverter_made_t inverter_make(const inverter_t *inverter, ab_t wanted, ab_t current, float u_dc)
{
    const ab_t lost = dead_time_voltage(&inverter->tuning.compensated, current, u_dc);
    const ab_t asked = {wanted.alpha + lost.alpha, wanted.beta + lost.beta};
    const svpwm_t modulated =
        svpwm_modulate(asked, u_dc, inverter->tuning.duty_min, inverter->tuning.duty_max);
    return (inverter_made_t){
        {whole_counts(inverter, modulated.duty.a), whole_counts(inverter, modulated.duty.b),
         whole_counts(inverter, modulated.duty.c)},
        {modulated.voltage.alpha - asked.alpha, modulated.voltage.beta - asked.beta},
    };
}

inverter_acted_t inverter_acted(const inverter_t *inverter, ab_t current, float u_dc)
{
    const float link = 0.5f * (u_dc + inverter->u_dc_prev);
    const ab_t middle = {0.5f * (current.alpha + inverter->current_prev.alpha),
                         0.5f * (current.beta + inverter->current_prev.beta)};
    const ab_t lost = dead_time_voltage(&inverter->tuning.lost, middle, link);
    return (inverter_acted_t){
        {inverter->duty_prev[1].alpha * link - lost.alpha, inverter->duty_prev[1].beta * link - lost.beta},
        middle,
        dead_time_leg(&inverter->tuning.lost, link),
    };
}

void inverter_remember(inverter_t *inverter, abc_t duty, ab_t current, float u_dc)
{
    inverter->duty_prev[1] = inverter->duty_prev[0];
    inverter->duty_prev[0] = frames_clarke(duty);
    inverter->current_prev = current;
    inverter->u_dc_prev = u_dc;
}
