#include "medium/protect/chopper_watch.h"

#include "math/exponential.h"
#include "math/filter.h"
#include "math/periods.h"

#define HEAT_LEAST 1e-6f /* [-] below it the resistor is cold; avoids denormal numbers */

chopper_watch_tuning_t chopper_watch_prepare(const chopper_watch_params_t *params)
{
    if (!(params->voltage > 0.0f)) {
        return (chopper_watch_tuning_t){.on = 0u};
    }
    return (chopper_watch_tuning_t){
        .on = 1u,
        .below = params->below,
        .conductance = 1.0f / params->resistance,
        .share = exponential_rest(params->period / params->time),
        .per_square = 1.0f / (params->resistance * params->continuous * params->periods),
        .most = (uint32_t)(params->periods + 0.5f),
        .looks = periods_of(CHOPPER_LOOK, params->period),
    };
}

static void begin(chopper_watch_t *x, float u_dc)
{
    x->began = u_dc;
    x->taken = 0.0f;
    x->returned = 0.0f;
    x->looks = 1u;
}

/* Evaluates a look in which the chopper was always on. The first such look only stores the voltage at its
 * end. */
static void look_at_effect(chopper_watch_t *x, const chopper_watch_tuning_t *tuning,
                           const chopper_watch_input_t *input)
{
    if (x->looks == 0u) {
        begin(x, input->u_dc);
        return;
    }
    x->taken += 0.5f * tuning->conductance * input->u_dc * input->u_dc;
    x->returned -= input->power < 0.0f ? input->power : 0.0f;
    x->looks++;
    if (x->looks <= tuning->looks) {
        return;
    }
    if (input->u_dc > (1.0f - CHOPPER_FALL) * x->began && x->returned < x->taken) {
        x->conditions |= CHOPPER_NO_EFFECT;
    }
    begin(x, input->u_dc);
}

void chopper_watch_step(chopper_watch_t *x, const chopper_watch_tuning_t *tuning,
                        const chopper_watch_input_t *input)
{
    const float power = tuning->per_square * (float)input->chopped * input->u_dc * input->u_dc;
    x->heat = lowpass_step(x->heat, tuning->share, power);
    if (x->heat > CHOPPER_HOT) {
        x->conditions |= CHOPPER_OVERLOAD;
    } else if (x->heat < CHOPPER_COOL) {
        x->conditions &= ~CHOPPER_OVERLOAD;
        x->heat = x->heat < HEAT_LEAST ? 0.0f : x->heat;
    }
    if (input->u_dc < tuning->below) {
        x->conditions &= ~CHOPPER_NO_EFFECT;
    }
    if (input->chopped >= tuning->most) {
        look_at_effect(x, tuning, input);
    } else {
        x->looks = 0u;
    }
}
