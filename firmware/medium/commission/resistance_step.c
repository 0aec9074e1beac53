#include "medium/commission/resistance_step.h"

#include "math/bounds.h"
#include "math/periods.h"

#define FIRST_SHARE      0.3f        /* of the largest current: first level [-] */
#define BLOCK            0.1f        /* [s] of a mean */
#define SETTLE           0.07f       /* [s] after a change of the level */
#define VOLTAGE_MOST     0.5f        /* of the DC link, for the largest level [-] */
#define RESISTANCE_LEAST 1e-3f       /* [ohm] for the gains and the largest level */
#define CURRENT_LEAST    0.5f        /* [A] */
#define SPREAD_MOST      0.02f       /* largest relative difference of the directions [-] */
#define SPREAD_OHM       4e-3f       /* [ohm] added to it */
#define ACROSS           0.05f       /* current across over that along of a rotor at rest [-] */
#define SIXTH_TURN       1.04719755f /* [rad] */
#define LEG              0.75f       /* V over the rest of the line [-] */

#define LEVEL_COUNT 6u
#define LEVEL_LEAST 0.32f /* lowest level of the line over the largest [-], ... */
#define LEVEL_CLEAR 0.45f /* [A] but clear of the zone, ... */
#define LEVEL_MOST  0.5f  /* of the largest, at most [-] */

#define ZONE_COUNT      7u
#define ZONE_BELOW      0.8f   /* largest level of the zone over the lowest one of the line [-] */
#define ZONE_ALL        0.25f  /* missing share of the loss from which on all legs are in their zone [-] */
#define ZONE_SHARE_MOST 0.9f   /* largest missing share [-] */
#define ZONE_LEAST      0.001f /* [A] */

void resistance_step_begin(resistance_step_t *step)
{
    *step = (resistance_step_t){.phase = (int32_t)RESISTANCE_BEGIN};
}

/* Adds the mean of a level to the line of this direction. */
static void add(resistance_step_t *step, commission_results_t *results)
{
    const dq_t voltage = commission_mean_of(&step->mean, step->mean.voltage);
    const dq_t current = commission_mean_of(&step->mean, step->mean.current);
    results->point = (commission_point_t){current.d, voltage.d};
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

/* Called when a current has settled: 0.3 I, 0.15 I, I_h, or I_h in a new direction. */
static commission_verdict_t first_value(resistance_step_t *step, const commission_tuning_t *tuning,
                                        const commission_input_t *input, excite_order_t *order,
                                        commission_results_t *results)
{
    const commission_mean_t settled = step->standing.mean;
    const dq_t voltage = commission_mean_of(&settled, settled.voltage);
    const dq_t current = commission_mean_of(&settled, settled.current);
    standing_wait(&step->standing);
    if (step->phase == (int32_t)RESISTANCE_FIRST) {
        step->first = (dq_t){current.d, voltage.d};
        order->current = 0.5f * FIRST_SHARE * tuning->current_max;
        step->phase = (int32_t)RESISTANCE_HALF;
        return commission_goes_on();
    }
    if (step->phase == (int32_t)RESISTANCE_HALF) {
        const float rise = step->first.d - current.d;
        if (!(rise > 0.0f)) {
            return commission_failed(COMMISSION_REASON_NO_STEADY_CURRENT, 0);
        }
        /* with a small R, noise can hide the rise of the voltage here; the staircase shows whether the
         * voltage rises */
        const float resistance = bounds_more((step->first.q - voltage.d) / rise, RESISTANCE_LEAST);
        const float rest = step->first.q - resistance * step->first.d; /* of the dead time */
        const float most = (VOLTAGE_MOST * input->u_dc - rest) / resistance;
        step->current = bounds_less(most, bounds_less(tuning->current_max, tuning->current_hold));
        if (step->current < CURRENT_LEAST) {
            return commission_failed(COMMISSION_REASON_HEAT_LIMIT_TOO_LOW, 0);
        }
        results->resistance = resistance;
        standing_gains(input->u_dc, tuning, results, order);
        order->current = step->current;
        step->phase = (int32_t)RESISTANCE_FULL;
        return commission_goes_on();
    }
    /* after RESISTANCE_FULL and RESISTANCE_STILL: this mean is the first level of the line */
    step->phase = (int32_t)RESISTANCE_LEVELS;
    step->mean = settled;
    step->level = 0u;
    step->windows = 0u;
    step->n = 0.0f;
    step->x = 0.0f;
    step->y = 0.0f;
    step->xx = 0.0f;
    step->xy = 0.0f;
    add(step, results);
    step->level = 1u;
    return commission_goes_on();
}

/* Evaluates the line of a direction. */
static void close(resistance_step_t *step)
{
    const float per_n = 1.0f / step->n;
    const float slope = (step->xy - per_n * step->x * step->y) / (step->xx - per_n * step->x * step->x);
    const float middle = per_n * (step->y - slope * step->x);
    step->slope[step->direction] = slope;
    step->rest[step->direction] = step->first.q + middle - slope * step->first.d;
}

/* The results, when all directions are measured. */
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
        step->phase = (int32_t)RESISTANCE_TURN;
        return commission_goes_on();
    }
    results->resistance = mean;
    results->resistance_spread = (most - least) / mean;
    results->dead_voltage = LEG * rest / (float)RESISTANCE_DIRECTIONS;
    results->current_hold = step->current;
    if (2.0f * tuning->period * mean > results->inductance_pulse) {
        return commission_failed(COMMISSION_REASON_TIME_CONSTANT_SHORT, 0);
    }
    step->phase = (int32_t)RESISTANCE_ZONE;
    step->level = 0u;
    return commission_goes_on();
}

/* Currents of the line: from I_h down to one that is clear of the zone, if possible. */
static float level_of(const resistance_step_t *step, uint32_t level)
{
    static const float shares[LEVEL_COUNT] = {1.0f, 0.7f, 0.47f, 0.26f, 0.12f, 0.0f};
    const float clear = bounds_less(LEVEL_CLEAR, LEVEL_MOST * step->current);
    const float least = bounds_more(LEVEL_LEAST * step->current, clear);
    return least + shares[level] * (step->current - least);
}

/* Adds a window to the mean of a level. True at the end of the level, at which the next one begins. */
static bool is_averaged(resistance_step_t *step, const commission_tuning_t *tuning,
                        const commission_input_t *input)
{
    const uint32_t from = periods_of(SETTLE, tuning->window);
    step->windows++;
    if (step->windows <= from) {
        commission_mean_begin(&step->mean);
        return false;
    }
    commission_mean_add(&step->mean, input->seen);
    if (step->windows < from + periods_of(BLOCK, tuning->window)) {
        return false;
    }
    step->windows = 0u;
    return true;
}

/* The half width of the zone, from the mean current and voltage of a level in it. */
static float zone_of(const commission_results_t *results, dq_t current, dq_t voltage)
{
    const float whole = results->dead_voltage * (1.0f / LEG);
    const float loss = voltage.d - results->resistance * current.d;
    const float missing = whole > 0.0f ? 1.0f - loss / whole : 0.0f;
    const float zone = missing > ZONE_ALL ? 0.75f * current.d / (1.0f - bounds_less(missing, ZONE_SHARE_MOST))
                                          : 0.5f * current.d / (1.0f - 2.0f * missing);
    return bounds_more(zone, ZONE_LEAST);
}

/* A window of the staircase below the line. */
static commission_verdict_t descend(resistance_step_t *step, const commission_tuning_t *tuning,
                                    const commission_input_t *input, excite_order_t *order,
                                    commission_results_t *results)
{
    static const float levels[ZONE_COUNT] = {0.5f, 0.35f, 0.22f, 0.14f, 0.09f, 0.055f, 0.03f}; /* [A] */
    const float most = ZONE_BELOW * level_of(step, LEVEL_COUNT - 1u);
    while (levels[step->level] > most && step->level < ZONE_COUNT - 1u) {
        step->level++;
    }
    order->current = levels[step->level];
    if (!is_averaged(step, tuning, input)) {
        return commission_goes_on();
    }
    const dq_t voltage = commission_mean_of(&step->mean, step->mean.voltage);
    const dq_t current = commission_mean_of(&step->mean, step->mean.current);
    results->point = (commission_point_t){current.d, voltage.d};
    step->level++;
    if (step->level < ZONE_COUNT) {
        return commission_goes_on();
    }
    results->current_zone = zone_of(results, current, voltage);
    return commission_finished();
}

/* A window of a level. */
static commission_verdict_t climb(resistance_step_t *step, const commission_tuning_t *tuning,
                                  const commission_input_t *input, excite_order_t *order,
                                  commission_results_t *results)
{
    order->current = level_of(step, step->level);
    if (!is_averaged(step, tuning, input)) {
        return commission_goes_on();
    }
    add(step, results);
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
    step->phase = (int32_t)RESISTANCE_TURN;
    return commission_goes_on();
}

commission_verdict_t resistance_step(resistance_step_t *step, const commission_tuning_t *tuning,
                                     const commission_input_t *input, excite_order_t *order,
                                     commission_results_t *results)
{
    if (step->phase == (int32_t)RESISTANCE_BEGIN) {
        results->resistance = 0.0f;
        standing_begin(&step->standing, 0.0f, input->u_dc, tuning, results, order);
        order->current = FIRST_SHARE * tuning->current_max;
        step->phase = (int32_t)RESISTANCE_FIRST;
        return commission_goes_on();
    }
    if (input->seen->serial != order->serial) {
        return commission_goes_on();
    }
    if (step->phase == (int32_t)RESISTANCE_LEVELS) {
        return climb(step, tuning, input, order, results);
    }
    if (step->phase == (int32_t)RESISTANCE_ZONE) {
        return descend(step, tuning, input, order, results);
    }
    if (step->phase == (int32_t)RESISTANCE_TURN) {
        order->current = step->current;
        if (standing_turn(&step->standing, SIXTH_TURN * (float)step->direction, tuning, input->seen, order)) {
            standing_wait(&step->standing);
            step->phase = (int32_t)RESISTANCE_STILL;
        }
        return commission_goes_on();
    }
    const standing_want_t want = {periods_of(BLOCK, tuning->window), order->current, ACROSS * order->current};
    const standing_state_t state = standing_step(&step->standing, want, input->seen);
    if (state != STANDING_STEADY) {
        return standing_verdict(state);
    }
    return first_value(step, tuning, input, order, results);
}
