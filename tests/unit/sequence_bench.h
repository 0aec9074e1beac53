/* The sequence with its inputs from the drive: usual tuning, inputs, and functions that lead into its
 * states. */
#ifndef TESTS_UNIT_SEQUENCE_BENCH_H
#define TESTS_UNIT_SEQUENCE_BENCH_H

#include "medium/sequence.h"
#include "settings/faults.h"
#include "settings/reasons.h"
#include "tests/unit/compare.h"

#define REARM DRIVE_WINDOWS(20e-3f) /* [windows] without a fault and without the fault line */

#define OVERCURRENT fault_set_of(FAULT_OVERCURRENT)
#define LATE        fault_set_of(FAULT_LATE)
/* An arbitrary row of the warnings; its meaning does not matter here. */
#define WARM    fault_set_of(FAULT_SINK_WARM)
#define BOTH    fault_set_both(OVERCURRENT, LATE)
#define NOTHING fault_set_none()

#define STOP_WINDOWS 50u
#define RETRIES      2u
#define RETRY_PAUSE  DRIVE_WINDOWS(1.0f) /* [windows] */

static sequence_t sequence;
static requests_t requests;
static struct {
    fault_set_t faults, stops;
    calibration_t calibration;
    bool overspeed;
} input;
static uint32_t order; /* order of the last window */

#define OFF   UINT32_C(0)
#define ON    SEQUENCE_ON
#define BEGIN SEQUENCE_BEGIN

/* The state that the state machine must have, in each of the quantities that show it. */
static struct {
    bool fault_line, tripped, late, undervoltage, feeding, standing, not_enabled, brake_free;
} is;
static measured_t measured;
static bridge_t bridge; /* state of the bridge in the fast task */

#define UNDERVOLTAGE 200.0f                        /* [V] */
#define FEEDING      (0.02f * DRIVE_CURRENT_RANGE) /* [A] more than offsets and noise, while no gate is on */

/* No fault and no request; the rotor turns. */
void setUp(void)
{
    memset(&sequence, 0x55, sizeof sequence);
    const sequence_tuning_t tuning = {
        .dc_undervoltage = UNDERVOLTAGE, .stop_windows = STOP_WINDOWS, .retries = RETRIES};
    sequence_init(&sequence, &tuning);
    requests_defaults(&requests);
    memset(&is, 0, sizeof is);
    is.tripped = true;
    bridge = BRIDGE_OFF;
    memset(&input, 0, sizeof input);
    input.calibration = CALIBRATION_GOES_ON;
}

static inline void steps(uint32_t count)
{
    measured.flags = (is.tripped ? DRIVE_SAMPLE_TRIPPED : 0u) |
                     (is.fault_line ? DRIVE_SAMPLE_FAULT_LINE : 0u) | (is.late ? DRIVE_SAMPLE_LATE : 0u) |
                     (is.not_enabled ? DRIVE_SAMPLE_NOT_ENABLED : 0u);
    measured.u_dc = is.undervoltage ? 0.999f * UNDERVOLTAGE : UNDERVOLTAGE;
    measured.current = (ab_t){(is.feeding ? 0.61f : 0.59f) * FEEDING, -0.8f * FEEDING};
    for (uint32_t n = 0; n < count; n++) {
        order = sequence_step(&sequence, &(sequence_input_t){&requests, &measured, input.faults, input.stops,
                                                             is.standing, input.overspeed, !is.brake_free,
                                                             bridge, input.calibration});
        bridge = (order & SEQUENCE_ON) != 0u ? bridge : BRIDGE_OFF;
    }
}

static inline void expect_later(fault_set_t expected)
{
    TEST_ASSERT_EQUAL_HEX32(expected.word[0], sequence.faults_later.word[0]);
    TEST_ASSERT_EQUAL_HEX32(expected.word[1], sequence.faults_later.word[1]);
}

static inline void expect_state(drive_state_t state)
{
    TEST_ASSERT_EQUAL_INT32(state, sequence.state);
}

/* Runs this number of windows, after which the state machine must be in this state and give this order. */
static inline void go(uint32_t windows, drive_state_t state, uint32_t expected)
{
    steps(windows);
    expect_state(state);
    TEST_ASSERT_EQUAL_HEX32(expected, order);
}

/* Sets `enable` to this value and runs this number of windows, after which the state machine must be in
 * this state and give this order. */
static inline void wish(int32_t enable, uint32_t windows, drive_state_t state, uint32_t expected)
{
    requests.enable = enable;
    go(windows, state, expected);
}

/* The state must be fault, with this reason. */
static inline void expect_fault(int32_t reason)
{
    expect_state(DRIVE_FAULT);
    TEST_ASSERT_EQUAL_INT32(reason, sequence.fault_reason);
}

static inline void go_to_fault(uint32_t windows, int32_t reason)
{
    go(windows, DRIVE_FAULT, OFF);
    expect_fault(reason);
}

/* `enable` must be refused with this reason, in the state ready and before it. */
static inline void expect_refusal(int32_t enable, int32_t reason)
{
    requests.enable = enable;
    steps(1);
    TEST_ASSERT_EQUAL_INT32(reason, sequence.refusal);
}

static inline void bring_to_ready(void)
{
    steps(REARM);
    input.calibration = CALIBRATION_GOOD;
    go(1, DRIVE_READY, OFF);
    input.calibration = CALIBRATION_GOES_ON;
}

/* Leads into this state from the start, through the states before it. */
static inline void from(drive_state_t state)
{
    setUp();
    if (state != DRIVE_NOT_READY) {
        bring_to_ready();
    }
    if (state >= DRIVE_SWITCHED_ON) {
        wish(REQUEST_ON, 1, DRIVE_SWITCHED_ON, ON | BEGIN);
    }
    if (state >= DRIVE_OPERATION_ENABLED) {
        go(1, DRIVE_SWITCHED_ON, ON);
        is.tripped = false;
        bridge = BRIDGE_ON;
        go(1, DRIVE_OPERATION_ENABLED, ON);
    }
    if (state == DRIVE_QUICK_STOP) {
        wish(REQUEST_QUICK_STOP, 1, DRIVE_QUICK_STOP, ON);
    }
    if (state == DRIVE_FAULT) {
        input.faults = LATE;
        go_to_fault(1, REASON_LATE);
        input.faults = NOTHING;
        is.tripped = true;
    }
}

#define STATES ((int32_t)DRIVE_FAULT + 1)

/* A request that lasts for one window. */
static inline void reset_edge(void)
{
    requests.fault_reset = 0;
    steps(1);
    requests.fault_reset = 1;
    steps(1);
}

#endif
