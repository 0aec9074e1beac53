/* The enable input of the board: without it the bridge does not turn on, its loss stops the motor within
 * 50 ms, and its return alone does not start the motor. */
#include <unity.h>

#include "tests/unit/sequence_bench.h"

#define DEBOUNCE 3u                    /* [windows] */
#define STOP     DRIVE_WINDOWS(50e-3f) /* [windows] longest stop after a loss */

static void with_debounce(drive_state_t state)
{
    from(state);
    sequence.tuning.debounce = DEBOUNCE;
    sequence.tuning.stop_windows = 100u * STOP;
}

/* The input has this level for as long as the debounce takes. */
static void input_for(bool active, uint32_t windows)
{
    is.not_enabled = !active;
    steps(windows);
}

static void lose(drive_state_t state)
{
    with_debounce(state);
    input_for(false, DEBOUNCE + 1u);
}

/* ---- the enable input turns on ---- */

static void test_an_input_that_comes_back_starts_nothing_by_itself(void)
{
    with_debounce(DRIVE_READY);
    input_for(false, DEBOUNCE + 1u);
    wish(REQUEST_ON, 1, DRIVE_READY, OFF);
    is.not_enabled = false;
    go(DEBOUNCE, DRIVE_READY, OFF);
    TEST_ASSERT_EQUAL_INT32(REASON_ENABLE_INPUT, sequence.refusal);
    go(100, DRIVE_READY, OFF);
    TEST_ASSERT_EQUAL_INT32(REASON_ENABLE_HELD, sequence.refusal);
    wish(REQUEST_OFF, 1, DRIVE_READY, OFF);
    wish(REQUEST_ON, 1, DRIVE_SWITCHED_ON, ON | BEGIN);
}

/* The motor must not start even where the drive may start again without a command, after a fault of the
 * power module. */
static void test_an_automatic_reset_does_not_start_a_motor_whose_input_was_lost_during_this_time(void)
{
    for (uint32_t lost = 0; lost < 2u; lost++) {
        with_debounce(DRIVE_OPERATION_ENABLED);
        sequence_fault(&sequence, REASON_MODULE_FAULT);
        is.tripped = true;
        input_for(lost == 0u, DEBOUNCE + 1u);
        is.not_enabled = false;
        input.calibration = CALIBRATION_GOOD;
        steps(RETRY_PAUSE + REARM);
        expect_state(lost == 0u ? DRIVE_SWITCHED_ON : DRIVE_READY);
        TEST_ASSERT_EQUAL_INT32(lost == 0u ? REASON_NONE : REASON_ENABLE_HELD, sequence.refusal);
    }
}

/* ---- the enable input turns off ---- */

/* The input returns, which does not end the stop, and is lost again. */
static void test_a_second_loss_opens_at_once(void)
{
    lose(DRIVE_OPERATION_ENABLED);
    input_for(true, DEBOUNCE + 1u);
    expect_state(DRIVE_QUICK_STOP);
    is.not_enabled = true;
    go(DEBOUNCE, DRIVE_QUICK_STOP, ON);
    go_to_fault(1, REASON_ENABLE_INPUT);
}

static void test_a_loss_in_the_users_quick_stop_ends_it_within_50_ms(void)
{
    with_debounce(DRIVE_QUICK_STOP);
    go(10u * STOP, DRIVE_QUICK_STOP, ON);
    input_for(false, DEBOUNCE + 1u);
    go(STOP - 1u, DRIVE_QUICK_STOP, ON);
    go_to_fault(1, REASON_ENABLE_INPUT);
}

/* The reported fault remains the first cause. */
static void test_a_loss_in_a_stop_for_a_fault_opens_within_50_ms_with_that_fault(void)
{
    with_debounce(DRIVE_OPERATION_ENABLED);
    input.stops = WARM;
    go(10u * STOP, DRIVE_QUICK_STOP, ON);
    input_for(false, DEBOUNCE + 1u);
    go(STOP - 1u, DRIVE_QUICK_STOP, ON);
    go_to_fault(1, REASON_SINK_WARM);
}

static void test_a_loss_while_the_bridge_comes_on_opens_at_once(void)
{
    with_debounce(DRIVE_SWITCHED_ON);
    is.not_enabled = true;
    go(DEBOUNCE, DRIVE_SWITCHED_ON, ON);
    go_to_fault(1, REASON_ENABLE_INPUT);
}

/* ---- the way out of the fault ---- */

static void test_after_a_loss_it_takes_a_reset_the_input_and_a_new_enable(void)
{
    lose(DRIVE_OPERATION_ENABLED);
    is.standing = true;
    go_to_fault(1, REASON_ENABLE_INPUT);
    is.tripped = true;
    input.calibration = CALIBRATION_GOOD;
    steps(REARM);
    reset_edge();
    expect_state(DRIVE_NOT_READY);
    go(5, DRIVE_READY, OFF);
    TEST_ASSERT_EQUAL_INT32(REASON_ENABLE_INPUT, sequence.refusal);
    input_for(true, DEBOUNCE + 1u);
    expect_state(DRIVE_READY);
    TEST_ASSERT_EQUAL_INT32(REASON_ENABLE_HELD, sequence.refusal);
    wish(REQUEST_OFF, 1, DRIVE_READY, OFF);
    wish(REQUEST_ON, 1, DRIVE_SWITCHED_ON, ON | BEGIN);
}
