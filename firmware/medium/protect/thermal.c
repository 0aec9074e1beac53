#include "medium/protect/thermal.h"

#include "math/bounds.h"
#include "math/exponential.h"
#include "math/filter.h"

#define TWO_THIRDS 0.666666667f /* i_alpha^2 + i_beta^2 of i_a^2 + i_b^2 + i_c^2, their sum being zero */

#define HEAT_MOST 10.0f /* [-] of the trip: the drive has stopped long before */

/* A body whose i^2 is `share` of the sum of squares. */
static thermal_body_t prepare_body(const thermal_params_t *params, float continuous, float time, float share)
{
    if (!(continuous > 0.0f && time > 0.0f)) {
        return (thermal_body_t){1.0f, 0.0f, 0.0f};
    }
    const float beyond = params->current_max - continuous;
    return (thermal_body_t){
        .share = exponential_rest(params->period * (float)THERMAL_SUMS / time),
        .per_sum = share / ((float)THERMAL_SUMS * continuous * continuous),
        .per_heat = beyond > 0.0f ? beyond / (1.0f - THERMAL_WARM) : 0.0f,
    };
}

thermal_tuning_t thermal_prepare(const thermal_params_t *params)
{
    return (thermal_tuning_t){
        .motor = prepare_body(params, params->motor_continuous, params->motor_time, TWO_THIRDS),
        .module = prepare_body(params, params->module_continuous, params->module_time, 1.0f),
        .current_max = params->current_max,
        .least = THERMAL_LEAST * params->current_max,
        .per_kelvin = (1.0f - THERMAL_LEAST) * params->current_max / THERMAL_KELVIN,
        .sink_hot = params->sink_hot,
        .motor_hot = params->motor_hot,
    };
}

void thermal_init(thermal_t *x, const thermal_tuning_t *tuning)
{
    *x = (thermal_t){.tuning = *tuning, .limit = tuning->current_max};
}

static float less(float a, float b)
{
    return a < b ? a : b;
}

/* The current limit by this body [A]. */
static float left_by(const thermal_tuning_t *tuning, const thermal_body_t *body, float heat)
{
    const float beyond = heat - THERMAL_WARM;
    return tuning->current_max - (beyond > 0.0f ? body->per_heat * beyond : 0.0f);
}

/* Sets the limit from the heat and these temperatures [degC], and the conditions. */
static void judge(thermal_t *x, float sink, float motor)
{
    const thermal_tuning_t *tuning = &x->tuning;
    const float bodies = less(left_by(tuning, &tuning->motor, x->motor_heat),
                              left_by(tuning, &tuning->module, x->module_heat));
    const float cooler = less(tuning->sink_hot - sink, tuning->motor_hot - motor);
    const float measured = tuning->least + (cooler > 0.0f ? tuning->per_kelvin * cooler : 0.0f);
    const float limit = less(bodies, less(measured, tuning->current_max));
    x->limit = limit > 0.0f ? limit : 0.0f;
    x->conditions = (x->motor_heat > THERMAL_TRIP ? THERMAL_MOTOR : 0u) |
                    (x->module_heat > THERMAL_TRIP ? THERMAL_MODULE : 0u) |
                    (x->limit < tuning->current_max ? THERMAL_DERATING : 0u);
}

void thermal_take(thermal_t *x, const thermal_tuning_t *tuning)
{
    const bool limited = (x->conditions & THERMAL_DERATING) != 0u;
    x->tuning = *tuning;
    x->limit = limited ? less(x->limit, tuning->current_max) : tuning->current_max;
}

/* Stays between 0 and HEAT_MOST: a value that is not a number, after a bit error,
 * counts as hot and cools down again. */
static float warmed(const thermal_body_t *body, float heat, float sum)
{
    const float warmer = less(lowpass_step(heat, body->share, body->per_sum * sum), HEAT_MOST);
    return warmer > 0.0f ? warmer : 0.0f;
}

void thermal_step(thermal_t *x, const measured_t *measured)
{
    const thermal_body_t *module = &x->tuning.module;
    const abc_t sum = x->squares;
    x->squares = (abc_t){0.0f, 0.0f, 0.0f};
    x->count = 0u;
    x->motor_heat = warmed(&x->tuning.motor, x->motor_heat, sum.a + sum.b + sum.c);
    x->leg_heat = (abc_t){warmed(module, x->leg_heat.a, sum.a), warmed(module, x->leg_heat.b, sum.b),
                          warmed(module, x->leg_heat.c, sum.c)};
    x->module_heat = bounds_span(x->leg_heat.a, x->leg_heat.b, x->leg_heat.c).largest;
    judge(x, measured->sink_temperature, measured->motor_temperature);
}
