#include "medium/commission/loop_step.h"

#include "math/bounds.h"
#include "math/periods.h"

#define SHARE      0.2f        /* step to either side over the standing current [-] */
#define VOLTAGE    0.125f      /* of the DC link: largest voltage for a step to either side [-] */
#define EVERY      0.04f       /* [s] from one step to the next */
#define SETTLE     0.4f        /* [s] before the sums */
#define LASTS      1.6f        /* [s] of the sums: 40 steps */
#define BLOCK      0.1f        /* [s] of a mean of the standing current */
#define ACROSS     0.05f       /* current across over that along of a rotor at rest [-] */
#define TOLERANCE  0.12f       /* of K over K_0 [-] */
#define SIXTH_TURN 1.04719755f /* [rad] */

void loop_step_begin(loop_step_t *step)
{
    *step = (loop_step_t){.phase = (int32_t)LOOP_BEGIN};
}

/* A rotor with L_q > L_d is aligned only up to a limit of the current (docs/theory.md, 30). If it has left
 * the axis at I_h, the steps of the reference stay within the current at which it was aligned. */
static float standing_current(const commission_results_t *results)
{
    return results->current_aligned < results->current_hold
               ? results->current_aligned * (1.0f / (1.0f + SHARE))
               : results->current_hold;
}

static commission_verdict_t begin(loop_step_t *step, const commission_tuning_t *tuning,
                                  const commission_input_t *input, excite_order_t *order,
                                  commission_results_t *results)
{
    results->loop_gain = 0.0f;
    if (!(results->resistance > 0.0f && results->inductance_d > 0.0f)) {
        return commission_failed(COMMISSION_REASON_EARLIER_STEP, 0);
    }
    standing_begin(&step->standing, -SIXTH_TURN, input->u_dc, tuning, results, order);
    order->current = standing_current(results);
    step->phase = (int32_t)LOOP_ALIGN;
    return commission_goes_on();
}

/* The order of the stepping reference. */
static void run(loop_step_t *step, const commission_tuning_t *tuning, const commission_input_t *input,
                excite_order_t *order)
{
    /* the control responds to a step of 2 A with the voltage w_c L 2 A */
    const float gain = tuning->loop_gain * tuning->inductance_d;
    const float most = VOLTAGE * input->u_dc * tuning->period / gain;
    order->kind = (int32_t)EXCITE_LOOP;
    order->serial++;
    order->step = bounds_less(SHARE * order->current, most);
    order->periods = periods_of(EVERY, tuning->period);
    step->phase = (int32_t)LOOP_RUNS;
    step->windows = 0u;
}

static commission_verdict_t judge(const loop_step_t *step, const commission_tuning_t *tuning,
                                  const excite_order_t *order, commission_results_t *results)
{
    const float fitted = (float)(EXCITE_FITTED - 2u) * step->periods / (float)order->periods;
    const float square = step->square - fitted * results->noise * results->noise;
    if (!(square > 0.0f)) {
        return commission_failed(COMMISSION_REASON_CURRENT_LOOP, 0);
    }
    const float least =
        results->inductance_d_least > 0.0f ? results->inductance_d_least : results->inductance_d;
    /* the correction for an L/R of few periods, see loop_step.h */
    const float x = results->resistance * tuning->period / least;
    const float bends = 1.0f - 0.5f * x / (1.0f + 0.75f * x / tuning->loop_gain);
    const float design = tuning->loop_gain * bends * results->inductance_d / least;
    results->loop_gain = step->moved / (square * design);
    return bounds_within(results->loop_gain - 1.0f, TOLERANCE)
               ? commission_finished()
               : commission_failed(COMMISSION_REASON_CURRENT_LOOP, 0);
}

static commission_verdict_t run_on(loop_step_t *step, const commission_tuning_t *tuning,
                                   const commission_input_t *input, const excite_order_t *order,
                                   commission_results_t *results)
{
    const uint32_t from = periods_of(SETTLE, tuning->window);
    step->windows++;
    if (step->windows > from) {
        step->moved += input->seen->voltage_cos.d;
        step->square += input->seen->current_cos.d;
        step->periods += (float)input->seen->periods;
    }
    return step->windows < from + periods_of(LASTS, tuning->window) ? commission_goes_on()
                                                                    : judge(step, tuning, order, results);
}

commission_verdict_t loop_step(loop_step_t *step, const commission_tuning_t *tuning,
                               const commission_input_t *input, excite_order_t *order,
                               commission_results_t *results)
{
    if (step->phase == (int32_t)LOOP_BEGIN) {
        return begin(step, tuning, input, order, results);
    }
    if (input->seen->serial != order->serial) {
        return commission_goes_on();
    }
    if (step->phase == (int32_t)LOOP_RUNS) {
        return run_on(step, tuning, input, order, results);
    }
    if (step->phase == (int32_t)LOOP_TURN) {
        if (standing_turn(&step->standing, 0.0f, tuning, input->seen, order)) {
            standing_wait(&step->standing);
            step->phase = (int32_t)LOOP_STILL;
        }
        return commission_goes_on();
    }
    const standing_want_t want = {periods_of(BLOCK, tuning->window), order->current, ACROSS * order->current};
    const standing_state_t state = standing_step(&step->standing, want, input->seen);
    if (state != STANDING_STEADY) {
        return standing_verdict(state);
    }
    if (step->phase == (int32_t)LOOP_STILL) {
        run(step, tuning, input, order);
    } else {
        step->phase = (int32_t)LOOP_TURN;
    }
    return commission_goes_on();
}
