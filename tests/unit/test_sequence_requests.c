/* The effect of requests: on after a quick stop, on after a reset, and that every request has either an
 * effect or a refusal. */
#include "tests/unit/sequence_bench.h"

/* Runs this number of windows with this value of `enable`; then the machine must be in this state and
 * report this about the request. */
static void ask(int32_t enable, uint32_t windows, drive_state_t state, int32_t refusal)
{
    requests.enable = enable;
    steps(windows);
    expect_state(state);
    TEST_ASSERT_EQUAL_INT32(refusal, sequence.refusal);
}

static void reset_and_expect(uint32_t windows, drive_state_t state, int32_t refusal)
{
    reset_edge();
    ask(requests.enable, windows, state, refusal);
}

/* The next calibration succeeds. */
static void bring_to_operation(void)
{
    from(DRIVE_OPERATION_ENABLED);
    input.calibration = CALIBRATION_GOOD;
}

/* A fault that has ended and is not reset yet. */
static void bring_to_fault(void)
{
    from(DRIVE_FAULT);
    input.calibration = CALIBRATION_GOOD;
    ask(REQUEST_ON, 2u * REARM, DRIVE_FAULT, REASON_FAULT_LATCHED);
}

/* ---- on, and quick stop ---- */

/* The stop is completed and reported; then the motor runs, because `enable` is on. */
static void test_on_during_a_quick_stop_names_the_stop_and_runs_after_it(void)
{
    bring_to_operation();
    ask(REQUEST_QUICK_STOP, 10u, DRIVE_QUICK_STOP, REASON_NONE);
    for (int n = 0; n < 100; n++) {
        ask(REQUEST_ON, 1u, DRIVE_QUICK_STOP, REASON_STOPPING);
    }
    is.standing = true;
    ask(REQUEST_ON, 1u, DRIVE_READY, REASON_NONE);
    ask(REQUEST_ON, 1u, DRIVE_SWITCHED_ON, REASON_NONE);
    bridge = BRIDGE_ON;
    ask(REQUEST_ON, 2u, DRIVE_OPERATION_ENABLED, REASON_NONE);
}

static void test_on_during_a_stop_for_a_fault_is_refused_by_that_fault(void)
{
    bring_to_operation();
    input.stops = fault_set_of(FAULT_MOTOR_HOT);
    ask(REQUEST_ON, 5u, DRIVE_QUICK_STOP, REASON_MOTOR_HOT);
    is.standing = true;
    steps(1);
    expect_fault(REASON_MOTOR_HOT);
}

/* ---- a reset ---- */

static void test_a_reset_starts_nothing_while_enable_is_on(void)
{
    bring_to_fault();
    reset_edge();
    steps(1); /* until the offsets are measured */
    for (uint32_t n = 0; n < 3u * RETRY_PAUSE; n++) {
        ask(REQUEST_ON, 1u, DRIVE_READY, REASON_ENABLE_HELD);
        TEST_ASSERT_EQUAL_UINT32(OFF, order & SEQUENCE_ON);
    }
    requests.enable = REQUEST_QUICK_STOP; /* a quick stop is not off */
    steps(1);
    ask(REQUEST_ON, 1u, DRIVE_READY, REASON_ENABLE_HELD);
    ask(REQUEST_OFF, 1u, DRIVE_READY, REASON_NONE);
    ask(REQUEST_ON, 1u, DRIVE_SWITCHED_ON, REASON_NONE);
}

/* If `enable` is off, or at quick stop, during the reset, the next on starts the motor. */
static void test_enable_that_is_not_on_over_the_reset_starts_with_on(void)
{
    for (int32_t wish = REQUEST_OFF; wish <= REQUEST_QUICK_STOP; wish += 2) {
        bring_to_fault();
        requests.enable = wish;
        steps(1);
        reset_and_expect(10u, DRIVE_READY, REASON_NONE);
        ask(REQUEST_ON, 1u, DRIVE_SWITCHED_ON, REASON_NONE);
    }
}

/* The description of module_fault_retries states that the motor starts again without a command. */
static void test_an_automatic_retry_starts_the_motor(void)
{
    bring_to_operation();
    sequence.tuning.retries = 1u;
    sequence_fault(&sequence, REASON_MODULE_FAULT);
    ask(REQUEST_ON, RETRY_PAUSE + 2u, DRIVE_SWITCHED_ON, REASON_NONE);
    bridge = BRIDGE_ON;
    ask(REQUEST_ON, 2u, DRIVE_OPERATION_ENABLED, REASON_NONE);
    sequence_fault(&sequence, REASON_MODULE_FAULT);
    ask(REQUEST_ON, 2u * RETRY_PAUSE, DRIVE_FAULT, REASON_FAULT_LATCHED); /* one retry is allowed */
    reset_and_expect(2u, DRIVE_READY, REASON_ENABLE_HELD);
}

/* ---- every request has an effect ---- */

static uint32_t drawn(uint32_t *seed, uint32_t below)
{
    *seed = *seed * UINT32_C(1664525) + UINT32_C(1013904223);
    return (*seed >> 16) % below;
}

/* A thousand sequences of random requests, faults, link voltages, lines and rotors: if `enable` is on and
 * the bridge stays off for a while, a refusal states the reason. */
static void test_on_without_bridge_and_without_refusal_does_not_last(void)
{
    uint32_t seed = 1u;
    for (uint32_t walk = 0; walk < 1000u; walk++) {
        uint32_t silent = 0u;
        setUp();
        is.tripped = false;
        input.calibration = CALIBRATION_GOOD;
        for (uint32_t n = 0; n < 400u; n++) {
            if (drawn(&seed, 8u) == 0u) {
                requests.enable = (int32_t)drawn(&seed, 3u);
            }
            if (drawn(&seed, 8u) == 0u) {
                requests.fault_reset = (int32_t)drawn(&seed, 2u);
            }
            input.faults = drawn(&seed, 100u) == 0u ? fault_set_of(FAULT_LATE) : fault_set_none();
            input.stops = drawn(&seed, 100u) == 0u ? fault_set_of(FAULT_SINK_HOT) : fault_set_none();
            is.standing = drawn(&seed, 4u) == 0u;
            is.undervoltage = drawn(&seed, 20u) == 0u;
            is.feeding = drawn(&seed, 20u) == 0u;
            if (drawn(&seed, 50u) == 0u && sequence_bridge_on(&sequence)) {
                sequence_coast(&sequence);
            }
            sequence.quiet_windows = drawn(&seed, 3u) == 0u ? REARM : sequence.quiet_windows;
            steps(1);
            const bool nothing = requests.enable == REQUEST_ON && !sequence_bridge_on(&sequence) &&
                                 sequence.refusal == REASON_NONE;
            silent = nothing ? silent + 1u : 0u;
            TEST_ASSERT_TRUE(silent < DRIVE_PERIODS(1e-3f));
        }
    }
}
