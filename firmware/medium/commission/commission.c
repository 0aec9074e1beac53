#include "medium/commission/commission.h"

#include <string.h>

#include "math/bounds.h"
#include "math/root.h"

/* The standard deviation of N samples has the standard error (2 N)^(-1/2), here 1.3 %, so that the noise is
 * within 5 % (docs/commissioning.md, Requirements). */
#define BOARD_SAMPLES 3072.0f

typedef enum { BRIDGE_OFF_STEP, STANDS_STEP, TURNS_STEP } motion_t;

typedef struct {
    float seconds; /* [s] largest time */
    motion_t motion;
} row_t;

static const row_t rows[] = {
#define ROW_OF_STEP(NAME, name, seconds, kind) {seconds, kind##_STEP},
    COMMISSION_STEPS(ROW_OF_STEP)
#undef ROW_OF_STEP
};

void commission_init(commission_t *commission)
{
    memset(commission, 0, sizeof *commission);
}

bool commission_excites(const commission_t *commission)
{
    return rows[commission->step].motion == STANDS_STEP;
}

bool commission_turns(const commission_t *commission)
{
    return rows[commission->step].motion == TURNS_STEP;
}

/* Orders the zero vector, at which no current flows. */
static void rest(commission_t *commission)
{
    const uint32_t serial = commission->order.serial;
    commission->order = (excite_order_t){.kind = (int32_t)EXCITE_HOLD, .serial = serial + 1u};
    commission->order.axis = (rotation_t){0.0f, 1.0f};
    commission->wish = (turning_wish_t){0u, 0.0f, {0.0f, 0.0f}};
}

static void begin_work(commission_t *commission)
{
    commission_work_t *work = &commission->work;
    switch ((commission_step_t)commission->step) {
    case COMMISSION_WIRING:
        wiring_step_begin(&work->wiring);
        break;
    case COMMISSION_RESISTANCE:
        resistance_step_begin(&work->resistance);
        break;
    case COMMISSION_INDUCTANCE:
        sine_step_begin(&work->sine);
        break;
    case COMMISSION_ANGLE:
        angle_step_begin(&work->angle);
        break;
    case COMMISSION_CURRENT_LOOP:
        loop_step_begin(&work->loop);
        break;
    case COMMISSION_TURN:
        turn_step_begin(&work->turn);
        break;
    case COMMISSION_SWING:
        swing_step_begin(&work->swing);
        break;
    case COMMISSION_FLUX:
        flux_test_begin(&work->flux);
        break;
    case COMMISSION_INERTIA:
        torque_test_begin(&work->torque);
        break;
    case COMMISSION_BOARD:
    case COMMISSION_OFF:
        work->board = (commission_board_t){.n = 0.0f};
        break;
    }
}

static void begin(commission_t *commission, int32_t step)
{
    commission->step = step;
    commission->state = (int32_t)COMMISSION_WAITS;
    commission->reason = (int32_t)COMMISSION_REASON_NONE;
    commission->detail = 0;
    commission->windows = 0u;
    commission->largest = 0.0f;
    begin_work(commission);
    rest(commission);
}

/* ---- board ---- */

static float deviation(const commission_board_t *board, float sum, float square)
{
    const float mean = sum / board->n;
    return root_or_none(square / board->n - mean * mean);
}

static commission_verdict_t board_step(commission_t *commission, const commission_tuning_t *tuning,
                                       const commission_window_t *window)
{
    const commission_input_t *input = &window->standing;
    commission_board_t *board = &commission->work.board;
    const abc_t now = input->current_abc;
    if (board->n == 0.0f) {
        board->first = now;
    }
    const abc_t moved = {now.a - board->first.a, now.b - board->first.b, now.c - board->first.c};
    board->n += 1.0f;
    board->sum = (abc_t){board->sum.a + moved.a, board->sum.b + moved.b, board->sum.c + moved.c};
    board->square = (abc_t){board->square.a + moved.a * moved.a, board->square.b + moved.b * moved.b,
                            board->square.c + moved.c * moved.c};
    if (board->n < BOARD_SAMPLES) {
        return commission_goes_on();
    }
    const float noise_a = deviation(board, board->sum.a, board->square.a);
    const float noise_b = deviation(board, board->sum.b, board->square.b);
    commission->results.noise = bounds_more(noise_a, noise_b);
    if (input->tripped == 0u && !window->bridge_on) {
        return commission_failed(COMMISSION_REASON_TRIP_FAILED, 0);
    }
    if (input->u_dc < tuning->undervoltage) {
        return commission_failed(COMMISSION_REASON_LINK_LOW, 0);
    }
    return commission->results.noise > tuning->noise_max
               ? commission_failed(COMMISSION_REASON_NOISE, noise_a > noise_b ? 1 : 2)
               : commission_finished();
}

/* ---- all steps ---- */

static commission_verdict_t work(commission_t *commission, const commission_tuning_t *tuning,
                                 const commission_window_t *input)
{
    commission_work_t *work = &commission->work;
    excite_order_t *order = &commission->order;
    commission_results_t *results = &commission->results;
    switch ((commission_step_t)commission->step) {
    case COMMISSION_BOARD:
        return board_step(commission, tuning, input);
    case COMMISSION_WIRING:
        return wiring_step(&work->wiring, tuning, &input->standing, order, results);
    case COMMISSION_RESISTANCE:
        if (!(results->inductance_pulse > 0.0f)) {
            return commission_failed(COMMISSION_REASON_EARLIER_STEP, 0);
        }
        return resistance_step(&work->resistance, tuning, &input->standing, order, results);
    case COMMISSION_INDUCTANCE:
        return sine_step(&work->sine, tuning, &input->standing, order, results);
    case COMMISSION_ANGLE:
        return angle_step(&work->angle, tuning, &input->standing, order, results);
    case COMMISSION_CURRENT_LOOP:
        return loop_step(&work->loop, tuning, &input->standing, order, results);
    case COMMISSION_TURN:
        return turn_step(&work->turn, tuning, &input->standing, order, results);
    case COMMISSION_SWING:
        return swing_step(&work->swing, tuning, &input->standing, order, results);
    case COMMISSION_FLUX:
        return flux_test_step(&work->flux, tuning, &input->turning, &commission->wish, results);
    case COMMISSION_INERTIA:
        return torque_test_step(&work->torque, tuning, &input->turning, &commission->wish, results);
    case COMMISSION_OFF:
        break;
    }
    return commission_finished();
}

static void finish(commission_t *commission, commission_verdict_t verdict)
{
    const bool good = verdict.reason == (int32_t)COMMISSION_REASON_NONE;
    commission->state = (int32_t)(good ? COMMISSION_DONE : COMMISSION_FAILED);
    commission->reason = verdict.reason;
    commission->detail = verdict.detail;
    rest(commission);
}

/* Ends a step that has exceeded its time. The reason of a turning step names the condition for which it has
 * waited. */
static commission_verdict_t late(const commission_t *commission, const commission_window_t *input)
{
    if (!commission_turns(commission)) {
        return commission_failed(COMMISSION_REASON_TIME_OUT, 0);
    }
    return commission_failed(input->turning.runs != 0u ? COMMISSION_REASON_SENSORLESS_LOST
                                                       : COMMISSION_REASON_ROTOR_NOT_TURNING,
                             0);
}

void commission_window(commission_t *commission, const commission_tuning_t *tuning, int32_t requested,
                       const commission_window_t *input)
{
    if (requested != commission->step) {
        begin(commission, requested);
    }
    const row_t *row = &rows[commission->step];
    const ab_t current = input->standing.current;
    const bool may = row->motion == BRIDGE_OFF_STEP || input->bridge_on;
    if (commission->step == (int32_t)COMMISSION_OFF || commission->state >= (int32_t)COMMISSION_DONE) {
        return;
    }
    if (commission->state == (int32_t)COMMISSION_WAITS) {
        if (!may) {
            return;
        }
        commission->state = (int32_t)COMMISSION_WORKS;
    }
    commission->largest = bounds_more(
        commission->largest, root_or_none(current.alpha * current.alpha + current.beta * current.beta));
    if (!may) {
        finish(commission, commission_failed(COMMISSION_REASON_BRIDGE_OPENED, 0));
        return;
    }
    commission->windows++;
    commission_verdict_t verdict = work(commission, tuning, input);
    if (verdict.finished == 0u && (float)commission->windows * tuning->window > row->seconds) {
        verdict = late(commission, input);
    }
    if (verdict.finished != 0u) {
        finish(commission, verdict);
    }
}
