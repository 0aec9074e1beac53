#include "medium/commission/turn_step.h"

#include "math/angle.h"
#include "math/bounds.h"
#include "math/periods.h"

#define SETTLE 0.1f /* [s] of a mean of the standing current */
#define LAG    0.3f /* current across over that along, with which a rotor counts as aligned [-] */
#define AHEAD  0.5f /* [rad] by which the axis is ordered ahead while it turns */

void turn_step_begin(turn_step_t *step)
{
    *step = (turn_step_t){.phase = (int32_t)TURN_BEGIN};
}

static commission_verdict_t begin(turn_step_t *step, const commission_tuning_t *tuning,
                                  const commission_input_t *input, excite_order_t *order,
                                  const commission_results_t *results)
{
    if (!(results->resistance > 0.0f && results->inductance_pulse > 0.0f)) {
        return commission_failed(COMMISSION_REASON_EARLIER_STEP, 0);
    }
    standing_begin(&step->standing, 0.0f, input->u_dc, tuning, results, order);
    order->current = results->current_hold;
    step->left = ANGLE_TWO_PI * tuning->pole_pairs;
    step->phase = (int32_t)TURN_ALIGN;
    return commission_goes_on();
}

static void advance(turn_step_t *step, const commission_tuning_t *tuning, const commission_input_t *input,
                    excite_order_t *order)
{
    const float before = step->standing.angle;
    const float target = before + bounds_less(step->left, AHEAD);
    const bool arrived = standing_turn(&step->standing, target, tuning, input->seen, order);
    step->left -= angle_wrap(step->standing.angle - before);
    if (arrived) {
        standing_wait(&step->standing);
        step->phase = (int32_t)TURN_STILL;
    }
}

commission_verdict_t turn_step(turn_step_t *step, const commission_tuning_t *tuning,
                               const commission_input_t *input, excite_order_t *order,
                               const commission_results_t *results)
{
    if (step->phase == (int32_t)TURN_BEGIN) {
        return begin(step, tuning, input, order, results);
    }
    if (input->seen->serial != order->serial) {
        return commission_goes_on();
    }
    if (step->phase == (int32_t)TURN_TURNS) {
        advance(step, tuning, input, order);
        return commission_goes_on();
    }
    const standing_want_t want = {periods_of(SETTLE, tuning->window), order->current, LAG * order->current};
    const standing_state_t state = standing_step(&step->standing, want, input->seen);
    if (state != STANDING_STEADY) {
        return standing_verdict(state);
    }
    if (step->phase == (int32_t)TURN_STILL) {
        return commission_finished();
    }
    step->phase = (int32_t)TURN_TURNS;
    return commission_goes_on();
}
