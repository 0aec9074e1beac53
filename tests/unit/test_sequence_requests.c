/* What a request leads to: on after a quick stop, on after a reset, and that no request stays without an
 * effect and without a refusal. */
#include "drive/sequence.h"

#include <string.h>
#include <unity.h>

#include "drive/faults.h"
#include "drive/reasons.h"

#define REARM ((uint32_t)(20e-3f / DRIVE_PERIOD + 0.5f)) /* [periods] without a fault or its line */
#define PAUSE ((uint32_t)(1.0f / DRIVE_PERIOD + 0.5f))   /* [periods] before a retry */

static sequence_t sequence;
static requests_t requests;
static measured_t measured;
static sequence_input_t input;

void setUp(void)
{
    const sequence_tuning_t tuning = {.dc_undervoltage = 200.0f, .stop_periods = 50u, .retries = 1u};
    memset(&sequence, 0x55, sizeof sequence);
    sequence_init(&sequence, &tuning);
    requests_defaults(&requests);
    memset(&measured, 0, sizeof measured);
    measured.u_dc = 311.0f;
    input = (sequence_input_t){.requests = &requests,
                               .measured = &measured,
                               .faults = fault_set_none(),
                               .stops = fault_set_none(),
                               .calibration = CALIBRATION_GOOD};
}

void tearDown(void)
{
}

static uint32_t steps(uint32_t count)
{
    uint32_t order = 0u;
    for (uint32_t n = 0; n < count; n++) {
        order = sequence_step(&sequence, &input);
    }
    return order;
}

static void expect(drive_state_t state, int32_t refusal)
{
    TEST_ASSERT_EQUAL_INT32(state, sequence.state);
    TEST_ASSERT_EQUAL_INT32(refusal, sequence.refusal);
}

static void bring_to_operation(void)
{
    steps(REARM + 1u);
    requests.enable = REQUEST_ON;
    steps(3);
    expect(DRIVE_OPERATION_ENABLED, REASON_NONE);
}

/* A fault that has gone, and is not reset yet. */
static void bring_to_fault(void)
{
    bring_to_operation();
    input.faults = fault_set_of(FAULT_LATE);
    steps(1);
    input.faults = fault_set_none();
    steps(2u * REARM);
    expect(DRIVE_FAULT, requests.enable == REQUEST_ON ? REASON_FAULT_LATCHED : REASON_NONE);
}

static void reset(void)
{
    requests.fault_reset = 0;
    steps(1);
    requests.fault_reset = 1;
    steps(1);
    requests.fault_reset = 0;
}

/* ---- on, and quick stop ---- */

/* The stop is brought to its end, says so, and then the motor runs: `enable` is on. */
static void test_on_during_a_quick_stop_names_the_stop_and_runs_after_it(void)
{
    bring_to_operation();
    requests.enable = REQUEST_QUICK_STOP;
    steps(10);
    expect(DRIVE_QUICK_STOP, REASON_NONE);
    requests.enable = REQUEST_ON;
    for (int n = 0; n < 100; n++) {
        steps(1);
        expect(DRIVE_QUICK_STOP, REASON_STOPPING);
    }
    input.standing = true;
    steps(1);
    expect(DRIVE_READY, REASON_NONE);
    steps(1);
    expect(DRIVE_SWITCHED_ON, REASON_NONE);
    steps(2);
    expect(DRIVE_OPERATION_ENABLED, REASON_NONE);
}

static void test_on_during_a_stop_for_a_fault_is_refused_by_that_fault(void)
{
    bring_to_operation();
    input.stops = fault_set_of(FAULT_MOTOR_HOT);
    steps(5);
    expect(DRIVE_QUICK_STOP, REASON_MOTOR_HOT);
    input.standing = true;
    steps(1);
    TEST_ASSERT_EQUAL_INT32(DRIVE_FAULT, sequence.state);
    TEST_ASSERT_EQUAL_INT32(REASON_MOTOR_HOT, sequence.fault_reason);
}

/* ---- a reset ---- */

static void test_a_reset_starts_nothing_while_enable_is_on(void)
{
    bring_to_fault();
    reset();
    steps(1); /* the offsets are measured */
    for (uint32_t n = 0; n < 3u * PAUSE; n++) {
        TEST_ASSERT_EQUAL_UINT32(GATES_OFF, steps(1) & SEQUENCE_GATES);
        expect(DRIVE_READY, REASON_ENABLE_HELD);
    }
    requests.enable = REQUEST_QUICK_STOP; /* is no off */
    steps(1);
    requests.enable = REQUEST_ON;
    steps(1);
    expect(DRIVE_READY, REASON_ENABLE_HELD);
    requests.enable = REQUEST_OFF;
    steps(1);
    expect(DRIVE_READY, REASON_NONE);
    requests.enable = REQUEST_ON;
    steps(1);
    expect(DRIVE_SWITCHED_ON, REASON_NONE);
}

/* Off and on again before the reset is no start either: the reset comes last. */
static void test_enable_toggled_before_the_reset_is_still_held(void)
{
    bring_to_fault();
    requests.enable = REQUEST_OFF;
    steps(1);
    requests.enable = REQUEST_ON;
    reset();
    steps(2);
    expect(DRIVE_READY, REASON_ENABLE_HELD);
}

/* Whoever has it off, or at quick stop, over the reset starts with the next on. */
static void test_enable_that_is_not_on_over_the_reset_starts_with_on(void)
{
    for (int32_t wish = REQUEST_OFF; wish <= REQUEST_QUICK_STOP; wish += 2) {
        setUp();
        bring_to_fault();
        requests.enable = wish;
        steps(1);
        reset();
        steps(10);
        expect(DRIVE_READY, REASON_NONE);
        requests.enable = REQUEST_ON;
        steps(1);
        expect(DRIVE_SWITCHED_ON, REASON_NONE);
    }
}

/* A reset that is refused holds nothing back. */
static void test_a_refused_reset_leaves_enable_as_it_is(void)
{
    bring_to_operation();
    input.faults = fault_set_of(FAULT_LATE);
    steps(1);
    reset();
    TEST_ASSERT_EQUAL_INT32(REASON_FAULT_PRESENT, sequence.refusal);
    input.faults = fault_set_none();
    requests.enable = REQUEST_OFF;
    steps(2u * REARM);
    reset();
    requests.enable = REQUEST_ON;
    steps(3);
    TEST_ASSERT_EQUAL_INT32(DRIVE_SWITCHED_ON, sequence.state);
}

/* module_fault_retries says that the motor starts again by itself: that is its purpose. */
static void test_a_retry_of_its_own_starts_the_motor(void)
{
    bring_to_operation();
    sequence_fault(&sequence, REASON_MODULE_FAULT);
    steps(PAUSE + 4u);
    expect(DRIVE_OPERATION_ENABLED, REASON_NONE);
    sequence_fault(&sequence, REASON_MODULE_FAULT);
    steps(2u * PAUSE);
    expect(DRIVE_FAULT, REASON_FAULT_LATCHED); /* one retry is allowed */
    reset();
    steps(2);
    expect(DRIVE_READY, REASON_ENABLE_HELD);
}

/* ---- every request has an effect ---- */

static uint32_t drawn(uint32_t *seed, uint32_t below)
{
    *seed = *seed * UINT32_C(1664525) + UINT32_C(1013904223);
    return (*seed >> 16) % below;
}

/* A thousand walks of random requests, faults, links, lines and rotors: where `enable` is on and the bridge
 * is off for a millisecond, a refusal says why. */
static void test_on_without_bridge_and_without_refusal_does_not_last(void)
{
    uint32_t seed = 1u;
    for (uint32_t walk = 0; walk < 1000u; walk++) {
        uint32_t silent = 0u;
        setUp();
        for (uint32_t n = 0; n < 400u; n++) {
            if (drawn(&seed, 8u) == 0u) {
                requests.enable = (int32_t)drawn(&seed, 3u);
            }
            if (drawn(&seed, 8u) == 0u) {
                requests.fault_reset = (int32_t)drawn(&seed, 2u);
            }
            input.faults = drawn(&seed, 100u) == 0u ? fault_set_of(FAULT_LATE) : fault_set_none();
            input.stops = drawn(&seed, 100u) == 0u ? fault_set_of(FAULT_SINK_HOT) : fault_set_none();
            input.standing = drawn(&seed, 4u) == 0u;
            measured.u_dc = drawn(&seed, 20u) == 0u ? 199.0f : 311.0f;
            measured.current.alpha = drawn(&seed, 20u) == 0u ? 0.03f * DRIVE_CURRENT_RANGE : 0.0f;
            if (drawn(&seed, 50u) == 0u && sequence_bridge_on(&sequence)) {
                sequence_coast(&sequence);
            }
            sequence.quiet_periods = drawn(&seed, 3u) == 0u ? REARM : sequence.quiet_periods;
            steps(1);
            const bool nothing = requests.enable == REQUEST_ON && !sequence_bridge_on(&sequence) &&
                                 sequence.refusal == REASON_NONE;
            silent = nothing ? silent + 1u : 0u;
            TEST_ASSERT_TRUE(silent < DRIVE_PERIODS(1e-3f));
        }
    }
}
