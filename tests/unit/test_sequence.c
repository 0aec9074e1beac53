#include "tests/unit/sequence_bench.h"
#include "tests/unit/sweep.h"

/* ---- not ready ---- */

static void test_begins_not_ready_with_gates_off(void)
{
    expect_state(DRIVE_NOT_READY);
    go(3u * REARM, DRIVE_NOT_READY, OFF);
    TEST_ASSERT_EQUAL_INT32(REASON_NONE, sequence.refusal);
    TEST_ASSERT_EQUAL_INT32(REASON_NONE, sequence.fault_reason);
    TEST_ASSERT_EQUAL_UINT32(REARM, sequence.quiet_windows); /* the count ends there */
}

static void test_a_calibration_ends_in_ready_or_in_a_fault(void)
{
    input.calibration = CALIBRATION_GOOD;
    go(1, DRIVE_READY, OFF);
    setUp();
    input.calibration = CALIBRATION_FAILED;
    go_to_fault(1, REASON_CURRENT_OFFSET);
    setUp();
    input.calibration = CALIBRATION_NOISY;
    go_to_fault(1, REASON_CURRENT_NOISE);
}

/* ---- ready ---- */

static void test_on_goes_through_switched_on_until_the_bridge_is_on(void)
{
    from(DRIVE_READY);
    go(10, DRIVE_READY, OFF);
    wish(REQUEST_ON, 1, DRIVE_SWITCHED_ON, ON | BEGIN);
    go(3, DRIVE_SWITCHED_ON, ON);
    is.tripped = false;
    bridge = BRIDGE_CHARGES;
    go(20, DRIVE_SWITCHED_ON, ON);
    bridge = BRIDGE_ON;
    go(100, DRIVE_OPERATION_ENABLED, ON);
}

static void expect_refused(int32_t reason)
{
    const bool refused = reason != REASON_NONE;
    go(1, refused ? DRIVE_READY : DRIVE_SWITCHED_ON, refused ? OFF : ON | BEGIN);
    TEST_ASSERT_EQUAL_INT32(reason, sequence.refusal);
}

/* Each obstacle of a start in turn, the most serious one first. */
static void test_on_is_refused_with_the_reason(void)
{
    from(DRIVE_READY);
    is.fault_line = true;
    is.late = true;
    is.undervoltage = true;
    is.feeding = true;
    expect_refusal(REQUEST_OFF, REASON_NONE);
    requests.enable = REQUEST_ON;
    expect_refused(REASON_FAULT_PRESENT);
    is.fault_line = false;
    for (uint32_t n = 1; n < REARM; n++) {
        expect_refused(REASON_FAULT_PRESENT);
    }
    expect_refused(REASON_LATE);
    is.late = false;
    expect_refused(REASON_DC_UNDERVOLTAGE);
    is.undervoltage = false;
    expect_refused(REASON_ROTOR_TOO_FAST);
    is.feeding = false;
    input.overspeed = true;
    expect_refused(REASON_OVERSPEED);
    input.overspeed = false;
    expect_refused(REASON_NONE);
}

/* The sensors have just drifted, and the stored offsets would be wrong. A current that flows is the better
 * reason. */
static void test_a_start_waits_for_offsets_that_are_due(void)
{
    from(DRIVE_READY);
    input.calibration = CALIBRATION_DUE;
    requests.enable = REQUEST_ON;
    go(500, DRIVE_READY, OFF);
    expect_refused(REASON_NOT_READY);
    is.feeding = true;
    expect_refused(REASON_ROTOR_TOO_FAST);
    is.feeding = false;
    input.calibration = CALIBRATION_GOOD;
    expect_refused(REASON_NONE);
}

/* A current flows although no gate is on: the rotor feeds the link through the diodes. With the gates on
 * the current could become larger than they can turn off. This holds for every direction of the current. */
static void test_a_rotor_that_feeds_the_link_is_not_started_on(void)
{
    for (int n = 0; n < 24; n++) {
        const float angle = 0.2618f * (float)n;
        const ab_t direction = {cosf(angle), sinf(angle)};
        from(DRIVE_READY);
        requests.enable = REQUEST_ON;
        measured.flags = DRIVE_SAMPLE_TRIPPED;
        for (int over = 1; over >= 0; over--) {
            const float length = (over != 0 ? 1.001f : 0.999f) * FEEDING;
            measured.current = (ab_t){length * direction.alpha, length * direction.beta};
            (void)sequence_step(&sequence, &(sequence_input_t){&requests, &measured, NOTHING, NOTHING, false,
                                                               false, true, BRIDGE_OFF, CALIBRATION_GOES_ON});
            expect_state(over != 0 ? DRIVE_READY : DRIVE_SWITCHED_ON);
            TEST_ASSERT_EQUAL_INT32(over != 0 ? REASON_ROTOR_TOO_FAST : REASON_NONE, sequence.refusal);
        }
    }
}

/* ---- switched on ---- */

static void test_gates_that_do_not_come_on_are_a_fault(void)
{
    for (int charges = 0; charges < 2; charges++) {
        from(DRIVE_SWITCHED_ON);
        go(1, DRIVE_SWITCHED_ON, ON);
        bridge = charges != 0 ? BRIDGE_CHARGES : BRIDGE_ON;
        go_to_fault(1, REASON_GATES_REFUSED);
    }
}

/* The fast task opens the bridge only with a reason; without one a bit of the memory has flipped. */
static void test_gates_that_are_off_without_a_reason_are_a_fault(void)
{
    for (int32_t n = 0; n < 2; n++) {
        from(DRIVE_OPERATION_ENABLED);
        wish(n == 0 ? REQUEST_ON : REQUEST_QUICK_STOP, 5, n == 0 ? DRIVE_OPERATION_ENABLED : DRIVE_QUICK_STOP,
             ON);
        bridge = BRIDGE_CHARGES;
        steps(1);
        TEST_ASSERT_EQUAL_HEX32(ON, order);
        bridge = BRIDGE_OFF;
        go(1, DRIVE_FAULT, OFF);
        TEST_ASSERT_EQUAL_INT32(REASON_GATES_REFUSED, sequence.fault_reason);
    }
}

/* ---- fault ---- */

static void test_the_latched_fault_is_not_a_later_one(void)
{
    from(DRIVE_FAULT);
    input.faults = LATE;
    go_to_fault(3, REASON_LATE);
    expect_later(NOTHING);
    input.faults = NOTHING;
    steps(3);
    input.faults = BOTH;
    steps(1);
    expect_later(OVERCURRENT);
    /* This reason is not in the table, so that each row that occurs is a later fault. */
    sequence_fault(&sequence, REASON_BOARD_FAILED);
    steps(1);
    expect_later(BOTH);
}

/* No fault and no signal of the fault line may occur for exactly this time, counted from the last of them. */
static void test_reset_needs_quiet_for_its_whole_time(void)
{
    for (int line = 0; line < 2; line++) {
        for (uint32_t quiet = REARM - 1u; quiet <= REARM; quiet++) {
            from(DRIVE_FAULT);
            steps(3u * REARM);
            input.faults = line == 0 ? LATE : NOTHING;
            is.fault_line = line != 0;
            steps(1);
            input.faults = NOTHING;
            is.fault_line = false;
            steps(quiet - 1u);
            requests.fault_reset = 1;
            go(1, quiet == REARM ? DRIVE_NOT_READY : DRIVE_FAULT, OFF);
            TEST_ASSERT_EQUAL_INT32(quiet == REARM ? REASON_NONE : REASON_LATE, sequence.fault_reason);
            if (quiet != REARM) {
                TEST_ASSERT_EQUAL_INT32(REASON_FAULT_PRESENT, sequence.refusal);
            }
        }
    }
}

static void test_reset_needs_an_edge(void)
{
    from(DRIVE_FAULT);
    requests.fault_reset = 1;
    go(3u * REARM, DRIVE_FAULT, OFF);
    reset_edge();
    expect_state(DRIVE_NOT_READY);
    from(DRIVE_OPERATION_ENABLED); /* an edge before the fault does not count */
    requests.fault_reset = 1;
    steps(1);
    sequence_fault(&sequence, REASON_MODULE_FAULT);
    go(3u * REARM, DRIVE_FAULT, OFF);
}

static void test_a_fault_reports_why_it_refuses(void)
{
    from(DRIVE_FAULT);
    expect_refusal(REQUEST_ON, REASON_FAULT_PRESENT); /* the time without faults is too short */
    steps(REARM);
    TEST_ASSERT_EQUAL_INT32(REASON_FAULT_LATCHED, sequence.refusal);
    expect_refusal(REQUEST_OFF, REASON_NONE);
}

/* ---- a fault that lets the motor stop first ---- */

static void begin_stop(uint32_t windows)
{
    from(DRIVE_OPERATION_ENABLED);
    input.stops = WARM;
    go(windows, DRIVE_QUICK_STOP, ON);
}

static void test_a_stop_ends_in_its_fault_after_its_time_or_with_off(void)
{
    begin_stop(STOP_WINDOWS);
    go_to_fault(1, REASON_SINK_WARM);
    begin_stop(2);
    requests.enable = REQUEST_OFF;
    go_to_fault(1, REASON_SINK_WARM);
}

/* ---- refused resets and automatic resets ---- */

static void test_a_refused_reset_reports_what_is_still_there(void)
{
    static const struct {
        bool fault, stop, line;
        int32_t present;
    } cases[] = {
        {true, false, false, REASON_OVERCURRENT},
        {false, true, false, REASON_SINK_WARM},
        {false, false, true, REASON_MODULE_FAULT},
        {false, false, false, REASON_LATE}, /* the condition has ended, but not for long enough */
    };
    for (size_t n = 0; n < sizeof cases / sizeof cases[0]; n++) {
        from(DRIVE_FAULT);
        input.faults = cases[n].fault ? OVERCURRENT : NOTHING;
        input.stops = cases[n].stop ? WARM : NOTHING;
        is.fault_line = cases[n].line;
        sequence.quiet_windows = 0u;
        steps(1);
        TEST_ASSERT_EQUAL_INT32(REASON_NONE, sequence.fault_present); /* no reset has been requested */
        requests.fault_reset = 1;
        steps(1);
        expect_state(DRIVE_FAULT);
        TEST_ASSERT_EQUAL_INT32(cases[n].present, sequence.fault_present);
        input.faults = NOTHING;
        input.stops = NOTHING;
        is.fault_line = false;
        steps(REARM);
        requests.fault_reset = 0;
        steps(1);
        reset_edge();
        expect_state(DRIVE_NOT_READY);
        TEST_ASSERT_EQUAL_INT32(REASON_NONE, sequence.fault_present);
    }
}

/* A fault of the power module as in operation. */
static void fail_the_module(void)
{
    sequence.state = (int32_t)DRIVE_OPERATION_ENABLED;
    requests.enable = REQUEST_ON;
    sequence_fault(&sequence, REASON_MODULE_FAULT);
}

static void test_a_fault_of_the_module_resets_itself_so_often_and_no_more(void)
{
    from(DRIVE_OPERATION_ENABLED);
    for (uint32_t n = 0; n < RETRIES; n++) {
        fail_the_module();
        go(RETRY_PAUSE - 1u, DRIVE_FAULT, OFF);
        go(1, DRIVE_NOT_READY, OFF);
    }
    fail_the_module();
    go(3u * RETRY_PAUSE, DRIVE_FAULT, OFF);
    /* After a new request the same number of retries is allowed again. */
    wish(REQUEST_OFF, 1, DRIVE_FAULT, OFF);
    wish(REQUEST_ON, 2u * RETRY_PAUSE, DRIVE_NOT_READY, OFF);
}

static void test_no_other_fault_and_no_lasting_one_resets_itself(void)
{
    from(DRIVE_FAULT);
    go(3u * RETRY_PAUSE, DRIVE_FAULT, OFF);
    from(DRIVE_OPERATION_ENABLED);
    fail_the_module();
    is.fault_line = true;
    go(3u * RETRY_PAUSE, DRIVE_FAULT, OFF);
    is.fault_line = false;
    go(REARM, DRIVE_NOT_READY, OFF);
    for (int32_t wish = REQUEST_OFF; wish <= REQUEST_QUICK_STOP; wish += 2) { /* no request for on */
        from(DRIVE_OPERATION_ENABLED);
        fail_the_module();
        requests.enable = wish;
        go(3u * RETRY_PAUSE, DRIVE_FAULT, OFF);
    }
}

static void test_retries_are_forgotten_after_a_quiet_minute(void)
{
    from(DRIVE_OPERATION_ENABLED);
    fail_the_module();
    go(RETRY_PAUSE, DRIVE_NOT_READY, OFF);
    TEST_ASSERT_EQUAL_UINT32(1u, sequence.retried);
    sequence.state = (int32_t)DRIVE_OPERATION_ENABLED;
    bridge = BRIDGE_ON;
    sequence.retry_windows = 0u;
    steps(60u * RETRY_PAUSE - 1u);
    TEST_ASSERT_EQUAL_UINT32(1u, sequence.retried);
    steps(1);
    TEST_ASSERT_EQUAL_UINT32(0u, sequence.retried);
}

/* ---- a lost supply ---- */

/* The gates are off at once, without a fault. They turn on again as soon as the link voltage returns while
 * `enable` is still on. */
static void test_a_coasting_drive_comes_on_again_by_itself(void)
{
    from(DRIVE_OPERATION_ENABLED);
    steps(REARM);
    sequence_coast(&sequence);
    is.undervoltage = true;
    is.tripped = true;
    go(1, DRIVE_READY, OFF);
    TEST_ASSERT_EQUAL_INT32(REASON_DC_UNDERVOLTAGE, sequence.refusal);
    TEST_ASSERT_EQUAL_INT32(REASON_NONE, sequence.fault_reason);
    go(1000, DRIVE_READY, OFF);
    is.undervoltage = false;
    go(1, DRIVE_SWITCHED_ON, ON | BEGIN);
}

/* ---- every input in every state ---- */

/* The table has the states that one step may lead to; every input is tried in every state. */
static void test_no_input_leads_to_a_forbidden_state(void)
{
    static const bool may[6][6] = {
        /* columns: not_ready ready switched operation quick_stop fault */
        {true, true, false, false, false, true}, /* the drive is not ready */
        {false, true, true, false, false, true}, /* ready */
        {false, true, true, true, false, true},  /* switched on */
        {false, true, false, true, true, true},  /* operation enabled */
        {false, true, false, false, true, true}, /* quick stop */
        {true, false, false, false, false, true} /* fault */
    };
    static bool seen[6][6];
    const uint32_t stride = SWEEP > 1 ? 23u : 1u;
    for (uint32_t bits = 0; bits < UINT32_C(1) << 14; bits += stride) {
        for (int32_t enable = REQUEST_OFF; enable <= REQUEST_QUICK_STOP; enable++) {
            for (int32_t state = 0; state < STATES; state++) {
                setUp();
                sequence.state = state;
                sequence.quiet_windows = (bits & 1u) != 0u ? REARM : 0u;
                bridge = (bits >> 1 & 1u) != 0u ? BRIDGE_ON : BRIDGE_OFF;
                sequence.held = bits >> 2 & 1u;
                sequence.fault_reset_seen = (int32_t)(bits >> 3 & 1u);
                requests.enable = enable;
                requests.fault_reset = (int32_t)(bits >> 4 & 1u);
                input.faults = (bits >> 5 & 1u) != 0u ? OVERCURRENT : NOTHING;
                is.fault_line = (bits >> 6 & 1u) != 0u;
                is.tripped = (bits >> 7 & 1u) != 0u;
                is.undervoltage = (bits >> 8 & 1u) != 0u;
                is.feeding = (bits >> 9 & 1u) != 0u;
                is.standing = (bits >> 10 & 1u) != 0u;
                input.calibration = (calibration_t)(bits >> 11 & 3u);
                input.stops = (bits >> 13 & 1u) != 0u ? WARM : NOTHING;
                steps(1);

                const int32_t next = sequence.state;
                TEST_ASSERT_TRUE(next >= 0 && next < STATES && may[state][next]);
                seen[state][next] = true;
                TEST_ASSERT_EQUAL(next == (int32_t)DRIVE_SWITCHED_ON ||
                                      next == (int32_t)DRIVE_OPERATION_ENABLED ||
                                      next == (int32_t)DRIVE_QUICK_STOP,
                                  sequence_bridge_on(&sequence));
                /* Only `on` without an obstacle starts the drive; an obstacle of a start does not stop a
                 * running drive. */
                const bool stopped = fault_set_any(input.faults) || fault_set_any(input.stops);
                const bool gates_off = (bits >> 1 & 1u) == 0u;
                const bool obstacle = is.fault_line || is.undervoltage || is.feeding;
                TEST_ASSERT_TRUE(state != (int32_t)DRIVE_READY || next != (int32_t)DRIVE_SWITCHED_ON ||
                                 (enable == REQUEST_ON && !obstacle));
                if (state == (int32_t)DRIVE_OPERATION_ENABLED && !stopped && !gates_off) {
                    TEST_ASSERT_EQUAL_INT32(enable == REQUEST_ON    ? DRIVE_OPERATION_ENABLED
                                            : enable == REQUEST_OFF ? DRIVE_READY
                                                                    : DRIVE_QUICK_STOP,
                                            next);
                }
                /* The state fault ends only by an edge of the reset, after no fault has occurred for long
                 * enough. */
                const bool edge = requests.fault_reset != 0 && (bits >> 3 & 1u) == 0u;
                TEST_ASSERT_TRUE(state != (int32_t)DRIVE_FAULT || next == state ||
                                 (edge && !stopped && !is.fault_line && (bits & 1u) != 0u));
                /* The gates are off unless the bridge is on and remains on; the control starts again when
                 * the bridge turns on. */
                TEST_ASSERT_EQUAL(sequence_bridge_on(&sequence), (order & ON) != 0u);
                TEST_ASSERT_EQUAL(state == (int32_t)DRIVE_READY && next == (int32_t)DRIVE_SWITCHED_ON,
                                  (order & BEGIN) != 0u);
                /* No state but fault follows while a fault is present, and its reason is latched only at
                 * the entry. */
                TEST_ASSERT_TRUE(!fault_set_any(input.faults) || next == (int32_t)DRIVE_FAULT);
                TEST_ASSERT_EQUAL(next == (int32_t)DRIVE_FAULT && state != next,
                                  state != (int32_t)DRIVE_FAULT && sequence.fault_reason != REASON_NONE);
            }
        }
    }
    TEST_ASSERT_EQUAL_MEMORY(may, seen, sizeof may); /* every permitted change has occurred */
}

/* With a holding brake a turning motor is stopped first, and the bridge stays on until the brake is set. */
static void with_brake(void)
{
    from(DRIVE_OPERATION_ENABLED);
    sequence.tuning.brakes = 1u;
    is.brake_free = true;
}

static void test_with_a_brake_a_stop_opens_the_bridge_only_when_it_is_set(void)
{
    static const int32_t wishes[] = {REQUEST_OFF, REQUEST_QUICK_STOP};
    for (size_t n = 0; n < sizeof wishes / sizeof wishes[0]; n++) {
        with_brake();
        wish(wishes[n], 10, DRIVE_QUICK_STOP, ON);
        TEST_ASSERT_EQUAL_UINT32(0u, sequence.setting);
        is.standing = true;
        go(1, DRIVE_QUICK_STOP, ON);
        TEST_ASSERT_EQUAL_UINT32(1u, sequence.setting);
        is.standing = false; /* a motion while the brake closes does not release it again */
        go(20, DRIVE_QUICK_STOP, ON);
        TEST_ASSERT_EQUAL_UINT32(1u, sequence.setting);
        is.brake_free = false;
        go(1, DRIVE_READY, OFF);
        TEST_ASSERT_EQUAL_UINT32(0u, sequence.setting);
    }
}

static void test_a_stop_ends_at_2_rad_s_or_a_four_hundredth_of_overspeed_trip(void)
{
    params_t params;
    params_defaults(&params);
    params.overspeed_trip = 790.0f;
    TEST_ASSERT_EQUAL_FLOAT(2.0f, sequence_prepare(&params).standstill);
    params.overspeed_trip = 1650.0f;
    TEST_ASSERT_FLOAT_WITHIN(1e-5f, 4.125f, sequence_prepare(&params).standstill);
}

static void test_with_a_brake_a_stop_that_does_not_end_sets_it_after_its_time(void)
{
    with_brake();
    wish(REQUEST_OFF, STOP_WINDOWS, DRIVE_QUICK_STOP, ON);
    TEST_ASSERT_EQUAL_UINT32(0u, sequence.setting);
    go(1, DRIVE_QUICK_STOP, ON);
    TEST_ASSERT_EQUAL_UINT32(1u, sequence.setting);
    is.brake_free = false;
    go(1, DRIVE_READY, OFF);
}
