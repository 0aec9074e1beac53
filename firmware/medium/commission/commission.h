/* Commissioning: the drive measures the data of an unknown motor by itself, step by step. The request
 * `commission` selects a step. Signals show its end, the results, or the reason why there is no result. The
 * bridge has to be switched on for each step but the first, and the client that requested the step switches
 * it off after it.
 *
 *     board        bridge off: noise of the current sensors, DC link
 *     wiring       pulses that move no rotor (wiring_step.h)
 *     resistance   R and the loss of the legs (resistance_step.h)
 *     angle        direction of the d axis of a rotor that is held (angle_step.h)
 *     inductance   L_d, L_q (sine_step.h)
 *     current_loop the current control with the measured R and L (loop_step.h)
 *     turn         one turn of the shaft, which the user watches (turn_step.h)
 *     swing        first values of psi_f and J (swing_step.h)
 *     flux         psi_f (turning_steps.h), with the parameters that follow from the steps before
 *     inertia      J and friction (turning_steps.h)
 *
 * Standing steps order an excitation in place of current control; turning steps order speeds and currents of
 * the usual run. All trips and limits of the drive remain active: a fault ends the step. Each step has a
 * largest time. One step of the state machine per window. */
#ifndef MEDIUM_COMMISSION_COMMISSION_H
#define MEDIUM_COMMISSION_COMMISSION_H

#include "medium/commission/angle_step.h"
#include "medium/commission/commission_types.h"
#include "medium/commission/loop_step.h"
#include "medium/commission/resistance_step.h"
#include "medium/commission/sine_step.h"
#include "medium/commission/swing_step.h"
#include "medium/commission/turn_step.h"
#include "medium/commission/turning_steps.h"
#include "medium/commission/wiring_step.h"

/* The steps: S(NAME, "|name", largest time [s], kind of motion). Append only. */
#define COMMISSION_STEPS(S)                                                                                  \
    S(OFF, "off", 0.0f, BRIDGE_OFF)                                                                          \
    S(BOARD, "|board", 4.0f, BRIDGE_OFF)                                                                     \
    S(WIRING, "|wiring", 5.0f, STANDS)                                                                       \
    S(RESISTANCE, "|resistance", 60.0f, STANDS)                                                              \
    S(INDUCTANCE, "|inductance", 15.0f, STANDS)                                                              \
    S(SWING, "|swing", 40.0f, STANDS)                                                                        \
    S(FLUX, "|flux", 60.0f, TURNS)                                                                           \
    S(INERTIA, "|inertia", 120.0f, TURNS)                                                                    \
    S(CURRENT_LOOP, "|current_loop", 15.0f, STANDS)                                                          \
    S(TURN, "|turn", 140.0f, STANDS)                                                                         \
    S(ANGLE, "|angle", 25.0f, STANDS)

typedef enum {
#define COMMISSION_STEP(NAME, name, seconds, kind) COMMISSION_##NAME,
    COMMISSION_STEPS(COMMISSION_STEP)
#undef COMMISSION_STEP
} commission_step_t;
#define COMMISSION_STEP_NAME(NAME, name, seconds, kind) name
#define COMMISSION_STEP_NAMES                           COMMISSION_STEPS(COMMISSION_STEP_NAME)

typedef enum { COMMISSION_WAITS, COMMISSION_WORKS, COMMISSION_DONE, COMMISSION_FAILED } commission_state_t;
#define COMMISSION_STATE_NAMES "waits|works|done|failed"

/* Noise of the current sensors, with the bridge off. */
typedef struct {
    float n;
    abc_t sum;    /* [A] */
    abc_t square; /* [A^2] */
    abc_t first;  /* [A] */
} commission_board_t;

/* Only one step works at a time. */
typedef union {
    commission_board_t board;
    wiring_step_t wiring;
    resistance_step_t resistance;
    sine_step_t sine;
    angle_step_t angle;
    loop_step_t loop;
    turn_step_t turn;
    swing_step_t swing;
    flux_test_t flux;
    torque_test_t torque;
} commission_work_t;

typedef struct {
    int32_t step;     /* [-] commission_step_t that is requested */
    int32_t state;    /* [-] commission_state_t */
    int32_t reason;   /* [-] commission_reason_t */
    int32_t detail;   /* [-] of the reason */
    uint32_t windows; /* [windows] that the step has worked */
    float largest;    /* largest current since the step was requested, length of the vector [A] */
    commission_results_t results;
    excite_order_t order;
    turning_wish_t wish;
    commission_work_t work;
} commission_t;

/* The inputs of a window. */
typedef struct {
    commission_input_t standing;
    turning_input_t turning;
    bool bridge_on; /* the motor may follow orders */
} commission_window_t;

void commission_init(commission_t *commission);

/* One window, with the requested step. */
void commission_window(commission_t *commission, const commission_tuning_t *tuning, int32_t requested,
                       const commission_window_t *input);

/* true: no step is requested, and a window changes nothing. */
static inline bool commission_is_off(const commission_t *commission, int32_t requested)
{
    return requested == (int32_t)COMMISSION_OFF && commission->step == (int32_t)COMMISSION_OFF;
}

/* true: the requested step excites a standing motor, and current control does not work. */
bool commission_excites(const commission_t *commission);

/* true: the requested step orders speed or current. */
bool commission_turns(const commission_t *commission);

#endif
