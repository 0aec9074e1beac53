#include "medium/protect/holding_brake.h"

#include "math/bounds.h"
#include "math/periods.h"

/* [looks] from a look until the setpoint that results from it has set the output. */
#define OUTPUT_LOOKS 2u

/* A time in looks, which may end between two of them. */
static uint32_t looks_of(float time, float period)
{
    return periods_of(time, period) + 1u;
}

holding_brake_tuning_t holding_brake_prepare(const holding_brake_params_t *params)
{
    return (holding_brake_tuning_t){
        .on = params->on ? UINT32_C(1) : UINT32_C(0),
        .release_looks = looks_of(params->release_time + params->take_time, params->period) + OUTPUT_LOOKS,
        .apply_looks = looks_of(params->apply_time, params->period) + OUTPUT_LOOKS,
        .steady_looks = looks_of(BRAKE_STEADY, params->period),
        .torque_looks = looks_of(BRAKE_TORQUE_TIME, params->period),
        .preload = params->preload,
        .near = BRAKE_NEAR * params->current_limit,
    };
}

static void enter(holding_brake_t *x, brake_state_t state)
{
    x->state = (int32_t)state;
    x->looks = 0u;
    x->waits = 0u;
}

static void while_set(holding_brake_t *x, const holding_brake_tuning_t *tuning,
                      const holding_brake_input_t *input)
{
    if (input->set || !input->holds) {
        x->looks = 0u;
        x->waits = 0u;
        return;
    }
    x->looks = bounds_within(input->torque - tuning->preload, tuning->near) ? x->looks + 1u : 0u;
    x->waits++;
    if (x->looks >= tuning->steady_looks) {
        enter(x, BRAKE_RELEASING);
    } else if (x->waits >= tuning->torque_looks) {
        x->failed = 1u;
    }
}

void holding_brake_step(holding_brake_t *x, const holding_brake_tuning_t *tuning,
                        const holding_brake_input_t *input)
{
    if (!input->bridge) {
        enter(x, BRAKE_SET);
        x->failed = 0u;
        return;
    }
    switch ((brake_state_t)x->state) {
    case BRAKE_SET:
        while_set(x, tuning, input);
        break;
    case BRAKE_RELEASING:
    case BRAKE_RELEASED:
        x->looks++;
        if (input->set) {
            enter(x, BRAKE_APPLYING);
        } else if (x->state == (int32_t)BRAKE_RELEASING && x->looks >= tuning->release_looks) {
            enter(x, BRAKE_RELEASED);
        }
        break;
    case BRAKE_APPLYING:
        x->looks++;
        if (x->looks >= tuning->apply_looks) {
            enter(x, BRAKE_SET);
        }
        break;
    }
}
