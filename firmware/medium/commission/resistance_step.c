#include "medium/commission/resistance_step.h"

#include "math/bounds.h"
#include "math/periods.h"

#define FIRST_SHARE   0.3f        /* of the largest current: first level [-] */
#define BLOCK         0.1f        /* [s] of a mean */
#define SETTLE        0.07f       /* [s] after a change of the level */
#define VOLTAGE_MOST  0.5f        /* of the DC link, for the largest level [-] */
#define CURRENT_LEAST 0.5f        /* [A] */
#define SPREAD_MOST   0.02f       /* largest relative difference of the directions [-] */
#define SPREAD_OHM    4e-3f       /* [ohm] added to it */
#define ACROSS        0.05f       /* current across over that along of a rotor at rest [-] */
#define SIXTH_TURN    1.04719755f /* [rad] */
#define LEG           0.75f       /* V over the rest of the line [-] */

#define LEVEL_COUNT 6u

void resistance_step_begin(resistance_step_t *step)
{
    *step = (resistance_step_t){.phase = RESISTANCE_BEGIN};
}

/* A current has settled: 0.3 I, 0.15 I, I_h, or I_h in a new direction. */
static commission_verdict_t first_value(resistance_step_t *step, const commission_tuning_t *tuning,
                                        const commission_input_t *input, excite_order_t *order,
                                        commission_results_t *results)
{
    const dq_t voltage = commission_mean_of(&step->standing.mean, step->standing.mean.voltage);
    const dq_t current = commission_mean_of(&step->standing.mean, step->standing.mean.current);
    standing_wait(&step->standing);
    if (step->phase == RESISTANCE_FIRST) {
        step->first = (dq_t){current.d, voltage.d};
        order->current = 0.5f * FIRST_SHARE * tuning->current_max;
        step->phase = RESISTANCE_HALF;
        return commission_goes_on();
    }
    if (step->phase == RESISTANCE_HALF) {
        const float rise = step->first.d - current.d;
        const float resistance = rise > 0.0f ? (step->first.q - voltage.d) / rise : 0.0f;
        if (!(resistance > 0.0f)) {
            return commission_failed(COMMISSION_REASON_NO_STEADY_CURRENT, 0);
        }
        const float rest = step->first.q - resistance * step->first.d; /* of the dead time */
        const float most = (VOLTAGE_MOST * input->u_dc - rest) / resistance;
        step->current = bounds_less(most, bounds_less(tuning->current_max, tuning->current_hold));
        if (step->current < CURRENT_LEAST) {
            return commission_failed(COMMISSION_REASON_HEAT_LIMIT_TOO_LOW, 0);
        }
        results->resistance = resistance;
        standing_gains(input->u_dc, tuning, results, order);
        order->current = step->current;
        step->phase = RESISTANCE_FULL;
        return commission_goes_on();
    }
    step->phase = RESISTANCE_LEVELS; /* after RESISTANCE_FULL and RESISTANCE_STILL */
    step->level = 0u;
    step->windows = 0u;
    step->n = 0.0f;
    step->x = 0.0f;
    step->y = 0.0f;
    step->xx = 0.0f;
    step->xy = 0.0f;
    return commission_goes_on();
}

/* The mean of a level into the line of this direction. */
static void add(resistance_step_t *step)
{
    const dq_t voltage = commission_mean_of(&step->mean, step->mean.voltage);
    const dq_t current = commission_mean_of(&step->mean, step->mean.current);
    if (step->level == 0u) {
        step->first = (dq_t){current.d, voltage.d};
    }
    const float x = current.d - step->first.d;
    const float y = voltage.d - step->first.q;
    step->n += 1.0f;
    step->x += x;
    step->y += y;
    step->xx += x * x;
    step->xy += x * y;
}

/* The line of a direction. */
static void close(resistance_step_t *step)
{
    const float per_n = 1.0f / step->n;
    const float slope = (step->xy - per_n * step->x * step->y) / (step->xx - per_n * step->x * step->x);
    const float middle = per_n * (step->y - slope * step->x);
    step->slope[step->direction] = slope;
    step->rest[step->direction] = step->first.q + middle - slope * step->first.d;
}

/* All directions are measured. */
static commission_verdict_t judge(resistance_step_t *step, const commission_tuning_t *tuning,
                                  commission_results_t *results)
{
    float sum = 0.0f;
    float rest = 0.0f;
    float most = step->slope[0];
    float least = step->slope[0];
    float change = 0.0f;
    for (uint32_t n = 0u; n < RESISTANCE_DIRECTIONS; n++) {
        sum += step->slope[n];
        rest += step->rest[n];
        most = bounds_more(most, step->slope[n]);
        least = bounds_less(least, step->slope[n]);
        change = bounds_more(change, bounds_magnitude(step->slope[n] - step->before[n]));
        step->before[n] = step->slope[n];
    }
    const float mean = sum / (float)RESISTANCE_DIRECTIONS;
    if (!(mean > 0.0f)) {
        return commission_failed(COMMISSION_REASON_NO_STEADY_CURRENT, 0);
    }
    if (most - least > SPREAD_MOST * mean + SPREAD_OHM) {
        if (step->repeated != 0u) {
            return commission_failed(change < 0.5f * (most - least) ? COMMISSION_REASON_SENSOR_GAIN
                                                                    : COMMISSION_REASON_ROTOR_SWINGS,
                                     0);
        }
        step->repeated = 1u;
        step->direction = 0u;
        step->phase = RESISTANCE_TURN;
        return commission_goes_on();
    }
    results->resistance = mean;
    results->resistance_spread = (most - least) / mean;
    results->dead_voltage = LEG * rest / (float)RESISTANCE_DIRECTIONS;
    results->current_hold = step->current;
    return 2.0f * tuning->period * mean > results->inductance_pulse
               ? commission_failed(COMMISSION_REASON_TIME_CONSTANT_SHORT, 0)
               : commission_finished();
}

/* A window of a level. */
static commission_verdict_t climb(resistance_step_t *step, const commission_tuning_t *tuning,
                                  const commission_input_t *input, excite_order_t *order,
                                  commission_results_t *results)
{
    static const float levels[LEVEL_COUNT] = {1.0f, 0.8f, 0.64f, 0.5f, 0.4f, 0.32f};
    const uint32_t from = periods_of(SETTLE, tuning->window);
    order->current = levels[step->level] * step->current;
    step->windows++;
    if (step->windows <= from) {
        commission_mean_begin(&step->mean);
        return commission_goes_on();
    }
    commission_mean_add(&step->mean, input->seen);
    if (step->windows < from + periods_of(BLOCK, tuning->window)) {
        return commission_goes_on();
    }
    add(step);
    step->windows = 0u;
    step->level++;
    if (step->level < LEVEL_COUNT) {
        return commission_goes_on();
    }
    close(step);
    order->current = step->current;
    step->direction++;
    if (step->direction == RESISTANCE_DIRECTIONS) {
        return judge(step, tuning, results);
    }
    step->phase = RESISTANCE_TURN;
    return commission_goes_on();
}

commission_verdict_t resistance_step(resistance_step_t *step, const commission_tuning_t *tuning,
                                     const commission_input_t *input, excite_order_t *order,
                                     commission_results_t *results)
{
    if (step->phase == RESISTANCE_BEGIN) {
        results->resistance = 0.0f;
        standing_begin(&step->standing, 0.0f, input->u_dc, tuning, results, order);
        order->current = FIRST_SHARE * tuning->current_max;
        step->phase = RESISTANCE_FIRST;
        return commission_goes_on();
    }
    if (input->seen->serial != order->serial) {
        return commission_goes_on();
    }
    if (step->phase == RESISTANCE_LEVELS) {
        return climb(step, tuning, input, order, results);
    }
    if (step->phase == RESISTANCE_TURN) {
        order->current = step->current;
        if (standing_turn(&step->standing, SIXTH_TURN * (float)step->direction, tuning, input->seen, order)) {
            standing_wait(&step->standing);
            step->phase = RESISTANCE_STILL;
        }
        return commission_goes_on();
    }
    const standing_want_t want = {periods_of(BLOCK, tuning->window), order->current, ACROSS * order->current};
    switch (standing_step(&step->standing, want, input->seen)) {
    case STANDING_STEADY:
        return first_value(step, tuning, input, order, results);
    case STANDING_NEVER:
        return commission_failed(step->phase == RESISTANCE_STILL ? COMMISSION_REASON_ROTOR_SWINGS
                                                                 : COMMISSION_REASON_NO_STEADY_CURRENT,
                                 0);
    case STANDING_NOT_YET:
        break;
    }
    return commission_goes_on();
}
