#include "medium/commission/wiring_step.h"

#include "math/bounds.h"
#include "math/root.h"

#define ZERO_WINDOWS  12u    /* [windows] of the zero vector */
#define ZERO_CURRENT  0.12f  /* [A] largest one in that time */
#define PULSE_WINDOWS 250u   /* [windows] longest decay of a pulse */
#define PULSE_LEAST   0.4f   /* [A] least answer */
#define PULSE_SHARE   0.1f   /* of the largest current [-] */
#define PULSE_NOISE   50.0f  /* of the noise, least answer: see RANK_LEAST [-] */
#define PULSE_ENOUGH  0.5f   /* of the largest current: an answer that is always sufficient [-] */
#define PULSE_MOST    0.6f   /* of the largest current, at which a pulse ends [-] */
#define FIRST_SHARE   0.005f /* of the DC link: voltage of the first pulse [-] */
#define MOST_SHARE    0.25f  /* of the DC link: largest voltage [-] */
#define GROWTH        1.25f
#define LESS          0.85f
#define PERIODS_MOST  100u
#define RIPPLE_MOST   0.6f /* of the largest current [-] */
/* Rank of the matrix below which a phase may be open, or a sensor may be stuck [-]; a very salient rotor has
 * such a rank as well. With an open phase an answer of r gives an entry of 2/sqrt(3) r in its column. The
 * noise of six answers, each a difference of two samples with the standard deviation s, gives 0.82 s in the
 * other one, and the rank 2 * 0.82 s/(1.15 r): 0.028 where r is PULSE_NOISE s, a fifth of this limit. */
#define RANK_LEAST 0.15f
#define TURNS_FROM 0.08f /* sum of the answers over the sum of their lengths [-] */

void wiring_step_begin(wiring_step_t *step)
{
    *step = (wiring_step_t){.phase = (int32_t)WIRING_ZERO, .periods = 1u};
}

/* Orders a pulse in this direction. */
static void fire(wiring_step_t *step, const commission_tuning_t *tuning, uint32_t direction,
                 excite_order_t *order)
{
    step->direction = direction;
    step->windows = 0u;
    order->kind = (int32_t)EXCITE_PULSE;
    order->serial++;
    order->axis = wiring_direction(direction);
    order->voltage = step->phase == (int32_t)WIRING_COMPARE ? LESS * step->voltage : step->voltage;
    order->periods = step->periods;
    order->current_max = PULSE_MOST * tuning->current_max;
}

static float length(ab_t vector)
{
    return root_or_none(vector.alpha * vector.alpha + vector.beta * vector.beta);
}

/* Three pulses had no sufficient answer: the next ones are larger. False: no larger pulse is permitted. */
static bool grow(wiring_step_t *step, float u_dc)
{
    if (step->voltage < MOST_SHARE * u_dc) {
        step->voltage *= GROWTH;
    } else {
        step->periods = step->periods + 1u + (2u * step->periods) / 5u;
    }
    step->largest = 0.0f;
    return step->periods <= PERIODS_MOST;
}

/* The answers do not cancel: the matrix is measured once more, because with small pulses noise can be the
 * reason. */
static commission_verdict_t turns(wiring_step_t *step, const commission_tuning_t *tuning,
                                  excite_order_t *order)
{
    if (step->repeated != 0u) {
        return commission_failed(COMMISSION_REASON_ROTOR_TURNS, 0);
    }
    *step = (wiring_step_t){
        .phase = (int32_t)WIRING_MATRIX, .periods = step->periods, .voltage = step->voltage, .repeated = 1u};
    fire(step, tuning, 0u, order);
    return commission_goes_on();
}

/* The pulses have ended. An open phase or a stuck sensor ends the step. */
static commission_verdict_t judge_wires(wiring_step_t *step)
{
    if (wiring_rank(&step->matrix) < RANK_LEAST) {
        const int32_t open = wiring_open_phase(&step->matrix);
        if (open != 0) {
            return commission_failed(COMMISSION_REASON_OPEN_PHASE, open);
        }
        const int32_t stuck = wiring_stuck_sensor(&step->matrix);
        if (stuck != 0) {
            return commission_failed(COMMISSION_REASON_SENSOR_STUCK, stuck);
        }
    }
    step->phase = (int32_t)WIRING_MAP;
    return commission_goes_on();
}

/* The map is known. It is judged before the inductance: with a sensor of the wrong sign or leg the current
 * falls along its pulse. */
static commission_verdict_t judge(wiring_step_t *step, const commission_tuning_t *tuning, float u_dc,
                                  excite_order_t *order, commission_results_t *results)
{
    const float inductance = FRAMES_ONE_THIRD * step->inductances;
    const wiring_map_t map = wiring_map_of(step->search.best);
    if (!wiring_is_right(map)) {
        return commission_failed(COMMISSION_REASON_SENSOR_MAP, wiring_code(map));
    }
    if (!(inductance > 0.0f) ||
        u_dc * tuning->period > 12.0f * RIPPLE_MOST * tuning->current_max * inductance) {
        return commission_failed(COMMISSION_REASON_RIPPLE_TOO_LARGE, 0);
    }
    if (length(step->sum) > TURNS_FROM * step->lengths) {
        return turns(step, tuning, order);
    }
    results->inductance_pulse = inductance;
    return commission_finished();
}

/* The answer to a pulse of the search; `noise` [A]: of the sensors. */
static commission_verdict_t search(wiring_step_t *step, const commission_tuning_t *tuning,
                                   const commission_input_t *input, excite_order_t *order, float noise)
{
    const float visible = bounds_more(PULSE_LEAST, PULSE_NOISE * noise);
    const float least = bounds_more(PULSE_SHARE * tuning->current_max,
                                    bounds_less(visible, PULSE_ENOUGH * tuning->current_max));
    step->largest = bounds_more(step->largest, length(input->seen->response));
    uint32_t next = step->direction + 2u;
    if (next >= WIRING_DIRECTIONS) {
        next = 0u;
        if (step->largest >= least) {
            step->phase = (int32_t)WIRING_MATRIX;
        } else if (!grow(step, input->u_dc)) {
            return commission_failed(COMMISSION_REASON_NO_MOTOR_CURRENT, 0);
        }
    }
    fire(step, tuning, next, order);
    return commission_goes_on();
}

/* The answer to a pulse of the matrix. */
static void add(wiring_step_t *step, const commission_tuning_t *tuning, ab_t response, excite_order_t *order)
{
    wiring_matrix_add(&step->matrix, response, wiring_direction(step->direction));
    step->sum.alpha += response.alpha;
    step->sum.beta += response.beta;
    step->lengths += length(response);
    step->along[step->direction] = frames_park(response, wiring_direction(step->direction)).d;
    if (step->direction + 1u < WIRING_DIRECTIONS) {
        fire(step, tuning, step->direction + 1u, order);
    } else {
        step->phase = (int32_t)WIRING_COMPARE;
        fire(step, tuning, 0u, order);
    }
}

/* The answer to a smaller pulse. */
static commission_verdict_t compare(wiring_step_t *step, const commission_tuning_t *tuning,
                                    const commission_input_t *input, excite_order_t *order)
{
    const float along = frames_park(input->seen->response, wiring_direction(step->direction)).d;
    const float rise = step->along[step->direction] - along;
    const float flux = (1.0f - LESS) * step->voltage * (float)step->periods * tuning->period;
    step->inductances += rise > 0.0f ? flux / rise : 0.0f;
    if (step->direction + 2u >= WIRING_DIRECTIONS) {
        return judge_wires(step);
    }
    fire(step, tuning, step->direction + 2u, order);
    return commission_goes_on();
}

commission_verdict_t wiring_step(wiring_step_t *step, const commission_tuning_t *tuning,
                                 const commission_input_t *input, excite_order_t *order,
                                 commission_results_t *results)
{
    const excite_seen_t *seen = input->seen;
    step->windows++;
    if (step->phase == (int32_t)WIRING_ZERO) {
        if (step->windows < ZERO_WINDOWS) {
            return commission_goes_on();
        }
        if (length(input->current) > ZERO_CURRENT) {
            return commission_failed(COMMISSION_REASON_ZERO_VECTOR_CURRENT, 0);
        }
        step->phase = (int32_t)WIRING_SEARCH;
        step->voltage = FIRST_SHARE * input->u_dc;
        fire(step, tuning, 0u, order);
        return commission_goes_on();
    }
    if (step->phase == (int32_t)WIRING_MAP) {
        return wiring_search(&step->search, &step->matrix) ? judge(step, tuning, input->u_dc, order, results)
                                                           : commission_goes_on();
    }
    if (seen->serial != order->serial || seen->done == 0u) {
        return step->windows < PULSE_WINDOWS ? commission_goes_on()
                                             : commission_failed(COMMISSION_REASON_ROTOR_TURNS, 0);
    }
    if (step->phase == (int32_t)WIRING_SEARCH) {
        return search(step, tuning, input, order, results->noise);
    }
    if (step->phase == (int32_t)WIRING_COMPARE) {
        return compare(step, tuning, input, order);
    }
    add(step, tuning, seen->response, order);
    return commission_goes_on();
}
