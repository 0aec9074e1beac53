#include "drive/drive.h"

#include <math.h>
#include <string.h>

#include "drive/reasons.h"
#include "drive/signals.h"
#include "unity.h"

static drive_t drive;
static params_t params;
static drive_samples_t samples;
static drive_command_t command;
static params_error_t why;

void setUp(void)
{
    params_defaults(&params);
    drive_init(&drive, &params);
    samples = (drive_samples_t){
        .u_dc = 311.0f, .sink_temperature = 40.0f, .motor_temperature = 40.0f, .flags = DRIVE_SAMPLE_TRIPPED};
    memset(&command, 0, sizeof command);
}

void tearDown(void)
{
}

static void steps(uint32_t count)
{
    for (uint32_t n = 0; n < count; n++) {
        drive_step(&drive, &samples, &command);
        /* what the trip zone does with the command */
        if (command.gates == GATES_ON) {
            samples.flags &= ~DRIVE_SAMPLE_TRIPPED;
        } else if (command.gates == GATES_OFF) {
            samples.flags |= DRIVE_SAMPLE_TRIPPED;
        }
    }
}

static void request(int32_t enable, int32_t reset)
{
    requests_t requests = drive.requests;
    requests.enable = enable;
    requests.fault_reset = reset;
    TEST_ASSERT_TRUE(drive_request(&drive, &requests, &why));
}

static void expect_state(drive_state_t state)
{
    TEST_ASSERT_EQUAL_INT32(state, drive.state);
}

static void bring_to_ready(void)
{
    steps(2000);
    expect_state(DRIVE_READY);
}

static void bring_to_run(void)
{
    bring_to_ready();
    request(REQUEST_ON, 0);
    steps(3);
    expect_state(DRIVE_OPERATION_ENABLED);
}

/* 64 samples to settle and calibration_periods to average; the transition is in the step that takes the last.
 */
static void test_offsets_take_exactly_their_time_and_gates_stay_off(void)
{
    steps(64 + 512 - 1);
    expect_state(DRIVE_NOT_READY);
    TEST_ASSERT_EQUAL_INT32(GATES_OFF, command.gates);
    steps(1);
    expect_state(DRIVE_READY);
    TEST_ASSERT_EQUAL_INT32(GATES_OFF, command.gates);
}

static void test_offsets_are_measured_and_removed(void)
{
    samples.i_a = 0.3f;
    samples.i_b = -0.2f;
    bring_to_ready();
    TEST_ASSERT_FLOAT_WITHIN(2e-5f, 0.3f, drive.offset.a); /* 512 roundings of 0.3 A at most 1.5e-8 each */
    TEST_ASSERT_FLOAT_WITHIN(2e-5f, -0.2f, drive.offset.b);
    samples.i_a = 2.3f;
    samples.i_b = -1.2f;
    steps(1);
    TEST_ASSERT_FLOAT_WITHIN(5e-5f, 2.0f, drive.current_abc.a);
    TEST_ASSERT_FLOAT_WITHIN(5e-5f, -1.0f, drive.current_abc.b);
    TEST_ASSERT_FLOAT_WITHIN(1e-4f, -1.0f, drive.current_abc.c);
}

static void test_an_offset_beyond_its_limit_is_a_fault(void)
{
    samples.i_b = 1.01f;
    steps(600);
    expect_state(DRIVE_FAULT);
    TEST_ASSERT_EQUAL_INT32(REASON_CURRENT_OFFSET, drive.fault.reason);
}

static void test_on_goes_through_switched_on_with_duties_before_gates(void)
{
    bring_to_ready();
    request(REQUEST_ON, 0);
    steps(1);
    expect_state(DRIVE_SWITCHED_ON);
    TEST_ASSERT_EQUAL_INT32(GATES_OFF, command.gates);
    steps(1);
    expect_state(DRIVE_SWITCHED_ON);
    TEST_ASSERT_EQUAL_INT32(GATES_ON, command.gates);
    steps(1);
    expect_state(DRIVE_OPERATION_ENABLED);
    TEST_ASSERT_EQUAL_INT32(GATES_KEEP, command.gates);
    steps(100);
    TEST_ASSERT_EQUAL_INT32(GATES_KEEP, command.gates); /* released once, never again by itself */
}

static void test_gates_that_do_not_come_on_are_a_fault(void)
{
    bring_to_ready();
    request(REQUEST_ON, 0);
    steps(2);
    samples.flags |= DRIVE_SAMPLE_TRIPPED;
    steps(1);
    expect_state(DRIVE_FAULT);
    TEST_ASSERT_EQUAL_INT32(REASON_GATES_REFUSED, drive.fault.reason);
}

static void test_on_is_refused_with_the_reason(void)
{
    request(REQUEST_ON, 0);
    steps(10);
    TEST_ASSERT_EQUAL_INT32(REASON_NOT_READY, drive.refusal);
    request(REQUEST_OFF, 0);
    bring_to_ready();

    samples.u_dc = 199.0f;
    request(REQUEST_ON, 0);
    steps(5);
    expect_state(DRIVE_READY);
    TEST_ASSERT_EQUAL_INT32(REASON_DC_UNDERVOLTAGE, drive.refusal);

    samples.u_dc = 311.0f;
    samples.flags |= DRIVE_SAMPLE_FAULT_LINE;
    steps(1);
    TEST_ASSERT_EQUAL_INT32(REASON_FAULT_PRESENT, drive.refusal);
    samples.flags &= ~DRIVE_SAMPLE_FAULT_LINE;
    steps(199); /* 20 ms after the line has gone high */
    expect_state(DRIVE_READY);
    steps(1);
    expect_state(DRIVE_SWITCHED_ON);
    TEST_ASSERT_EQUAL_INT32(REASON_NONE, drive.refusal);
}

static void test_off_opens_the_bridge_in_the_same_step(void)
{
    bring_to_run();
    request(REQUEST_OFF, 0);
    steps(1);
    expect_state(DRIVE_READY);
    TEST_ASSERT_EQUAL_INT32(GATES_OFF, command.gates);
    TEST_ASSERT_EQUAL_FLOAT(0.5f, command.duty.a);
}

static void test_off_while_switching_on_goes_back_to_ready(void)
{
    bring_to_ready();
    request(REQUEST_ON, 0);
    steps(1);
    request(REQUEST_OFF, 0);
    steps(1);
    expect_state(DRIVE_READY);
    TEST_ASSERT_EQUAL_INT32(GATES_OFF, command.gates);
}

static void turn(float omega_m)
{
    /* 10000 counts a turn; whole counts per period only, so that the tracked speed is exact */
    samples.encoder = (samples.encoder + (uint32_t)(omega_m / 6.2831853f + 0.5f)) % 10000u;
}

static void test_quick_stop_brakes_and_then_waits_for_off(void)
{
    bring_to_run();
    for (int n = 0; n < 2000; n++) { /* 2 counts a period: 12.57 rad/s */
        turn(12.5f);
        steps(1);
    }
    TEST_ASSERT_FLOAT_WITHIN(0.1f, 12.566f, drive.omega_m);
    request(REQUEST_QUICK_STOP, 0);
    for (int n = 0; n < 10; n++) {
        turn(12.5f);
        steps(1);
    }
    expect_state(DRIVE_QUICK_STOP);
    TEST_ASSERT_EQUAL_FLOAT(0.0f, drive.omega_m_ref);
    TEST_ASSERT_TRUE(drive.current_ref.q < -1.0f); /* k_p 0.5 times -12.6 rad/s brakes */
    steps(200);                                    /* standstill */
    expect_state(DRIVE_READY);
    TEST_ASSERT_EQUAL_INT32(GATES_OFF, command.gates);
    request(REQUEST_ON, 0);
    steps(10);
    expect_state(DRIVE_READY);
    request(REQUEST_OFF, 0);
    steps(1);
    request(REQUEST_ON, 0);
    steps(1);
    expect_state(DRIVE_SWITCHED_ON);
}

static void test_trip_goes_to_fault_at_once_and_freezes_what_was_seen(void)
{
    bring_to_run();
    samples.i_a = 1.5f;
    steps(1);
    const uint32_t period = drive.period;
    drive_trip(&drive);
    expect_state(DRIVE_FAULT);
    TEST_ASSERT_EQUAL_INT32(REASON_MODULE_FAULT, drive.fault.reason);
    TEST_ASSERT_EQUAL_UINT32(period, drive.fault.period);
    TEST_ASSERT_FLOAT_WITHIN(1e-6f, 1.5f, drive.fault.i_a);
    TEST_ASSERT_FLOAT_WITHIN(1e-6f, 311.0f, drive.fault.u_dc);
    steps(1);
    TEST_ASSERT_EQUAL_INT32(GATES_OFF, command.gates);
}

static void test_a_trip_without_the_interrupt_is_seen_in_the_flags(void)
{
    bring_to_run();
    samples.flags |= DRIVE_SAMPLE_TRIPPED;
    steps(1);
    expect_state(DRIVE_FAULT);
    TEST_ASSERT_EQUAL_INT32(REASON_MODULE_FAULT, drive.fault.reason);
}

static void test_a_trip_with_the_bridge_off_is_no_fault(void)
{
    bring_to_ready();
    drive_trip(&drive);
    steps(1);
    expect_state(DRIVE_READY);
}

static void test_the_first_fault_stays_and_later_ones_are_added(void)
{
    bring_to_run();
    samples.i_a = 15.5f;
    samples.i_b = -7.0f;
    steps(1);
    TEST_ASSERT_EQUAL_INT32(REASON_OVERCURRENT, drive.fault.reason);
    TEST_ASSERT_EQUAL_INT32(GATES_OFF, command.gates);
    samples.u_dc = 410.0f;
    steps(5);
    TEST_ASSERT_EQUAL_INT32(REASON_OVERCURRENT, drive.fault.reason);
    TEST_ASSERT_EQUAL_INT32(REASON_OVERCURRENT, protection_reason(drive.fault.later & 2u));
    TEST_ASSERT_EQUAL_INT32(REASON_DC_OVERVOLTAGE, protection_reason(drive.fault.later & 8u));
    TEST_ASSERT_FLOAT_WITHIN(1e-4f, 15.5f, drive.fault.i_a);
}

static void test_reset_needs_an_edge_and_a_cause_that_is_gone(void)
{
    bring_to_run();
    samples.u_dc = 410.0f;
    steps(2);
    expect_state(DRIVE_FAULT);
    request(REQUEST_OFF, 1);
    steps(1);
    expect_state(DRIVE_FAULT);
    TEST_ASSERT_EQUAL_INT32(REASON_FAULT_PRESENT, drive.refusal);
    samples.u_dc = 311.0f;
    steps(1000);
    expect_state(DRIVE_FAULT); /* the request stayed at yes: no edge */
    request(REQUEST_OFF, 0);
    steps(1);
    request(REQUEST_OFF, 1);
    steps(1);
    expect_state(DRIVE_NOT_READY);
    TEST_ASSERT_EQUAL_INT32(REASON_NONE, drive.fault.reason);
    bring_to_ready();
}

static void test_a_latched_fault_refuses_on(void)
{
    bring_to_run();
    drive_trip(&drive);
    steps(300);
    expect_state(DRIVE_FAULT);
    TEST_ASSERT_EQUAL_INT32(REASON_FAULT_LATCHED, drive.refusal);
}

static void test_board_failure_is_a_fault(void)
{
    drive_stop(&drive, REASON_BOARD_FAILED);
    expect_state(DRIVE_FAULT);
    TEST_ASSERT_EQUAL_INT32(REASON_BOARD_FAILED, drive.fault.reason);
}

static void test_samples_that_are_no_numbers_are_replaced_and_stop_the_drive_after_three(void)
{
    const float bad[] = {NAN, INFINITY, -INFINITY, 19.95f};
    for (size_t n = 0; n < sizeof bad / sizeof bad[0]; n++) {
        setUp();
        bring_to_run();
        samples.i_a = 1.0f;
        steps(1);
        samples.i_a = bad[n];
        steps(2);
        expect_state(DRIVE_OPERATION_ENABLED);
        TEST_ASSERT_FLOAT_WITHIN(1e-4f, 1.0f, drive.current_abc.a);
        steps(1);
        expect_state(DRIVE_FAULT);
        TEST_ASSERT_EQUAL_INT32(REASON_BAD_SAMPLE, drive.fault.reason);
        TEST_ASSERT_TRUE(command.duty.a >= 0.0f && command.duty.a <= 1.0f);
    }
}

static void test_duties_stay_within_what_dead_time_and_pulse_allow(void)
{
    bring_to_run();
    requests_t requests = drive.requests;
    requests.mode = MODE_CURRENT;
    requests.i_q_request = 10.0f;
    requests.i_d_request = -10.0f;
    TEST_ASSERT_TRUE(drive_request(&drive, &requests, &why));
    for (int n = 0; n < 2000; n++) { /* no current answers: the control winds up to the limit */
        samples.encoder = (samples.encoder + 7u) % 10000u;
        steps(1);
        const float duty[] = {command.duty.a, command.duty.b, command.duty.c};
        for (int leg = 0; leg < 3; leg++) {
            TEST_ASSERT_TRUE(duty[leg] >= 0.04f - 1e-6f && duty[leg] <= 0.96f + 1e-6f);
        }
    }
    /* and the integrators do not run away: back-calculation holds the wish near what can be applied */
    const float u = sqrtf(drive.voltage.d * drive.voltage.d + drive.voltage.q * drive.voltage.q);
    const float u_ref =
        sqrtf(drive.voltage_ref.d * drive.voltage_ref.d + drive.voltage_ref.q * drive.voltage_ref.q);
    /* the wish exceeds it by the proportional part, k_p 12.5 V/A times the error of 14.1 A */
    TEST_ASSERT_TRUE(u_ref < u + 1.2f * 12.5f * 14.2f);
}

static void test_current_mode_follows_its_references_within_the_limit(void)
{
    bring_to_run();
    requests_t requests = drive.requests;
    requests.mode = MODE_CURRENT;
    requests.i_q_request = 3.0f;
    requests.i_d_request = -1.0f;
    TEST_ASSERT_TRUE(drive_request(&drive, &requests, &why));
    steps(1);
    TEST_ASSERT_EQUAL_FLOAT(3.0f, drive.current_ref.q);
    TEST_ASSERT_EQUAL_FLOAT(-1.0f, drive.current_ref.d);
    requests.mode = MODE_SPEED; /* bumpless: the speed control goes on from 3 A */
    requests.speed_request = 0.0f;
    TEST_ASSERT_TRUE(drive_request(&drive, &requests, &why));
    steps(1);
    TEST_ASSERT_FLOAT_WITHIN(0.01f, 3.0f, drive.current_ref.q);
}

static void test_a_bad_set_is_refused_and_the_old_one_runs_on(void)
{
    params_t next = params;
    next.current_bandwidth = 5000.0f;
    TEST_ASSERT_FALSE(drive_apply(&drive, &next, &why));
    TEST_ASSERT_EQUAL_STRING("current_bandwidth", why.field);
    TEST_ASSERT_EQUAL_MEMORY(&params, &drive.params, sizeof params);
}

static void test_a_set_that_the_present_request_would_violate_is_refused(void)
{
    requests_t requests = drive.requests;
    requests.speed_request = 200.0f;
    TEST_ASSERT_TRUE(drive_request(&drive, &requests, &why));
    params_t next = params;
    next.overspeed_trip = 150.0f;
    TEST_ASSERT_FALSE(drive_apply(&drive, &next, &why));
    TEST_ASSERT_EQUAL_STRING("speed_request", why.field);
    TEST_ASSERT_EQUAL_FLOAT(220.0f, drive.params.overspeed_trip);
}

static void test_gains_change_while_running_without_a_jump(void)
{
    bring_to_run();
    requests_t requests = drive.requests;
    requests.speed_request = 10.0f; /* standing rotor: the integrator fills */
    TEST_ASSERT_TRUE(drive_request(&drive, &requests, &why));
    steps(200);
    const float before = drive.current_ref.q;
    params_t next = params;
    next.speed_ki = 5.0f;
    next.current_bandwidth = 1200.0f;
    TEST_ASSERT_TRUE(drive_apply(&drive, &next, &why));
    steps(1);
    /* one step of k_i 5 times 10 rad/s is 5 mA */
    TEST_ASSERT_FLOAT_WITHIN(0.011f, before, drive.current_ref.q);

    next.encoder_lines = 1000;
    TEST_ASSERT_FALSE(drive_apply(&drive, &next, &why));
    TEST_ASSERT_EQUAL_INT32(REASON_BRIDGE_ON, why.reason);
    request(REQUEST_OFF, 0);
    steps(1);
    TEST_ASSERT_TRUE(drive_apply(&drive, &next, &why));
}

/* The voltage computed at t_k acts one period later for one period: its frame is turned on by 1.5 T_s
 * omega_e. */
static void test_voltage_is_placed_where_the_rotor_will_be(void)
{
    bring_to_run();
    requests_t requests = drive.requests;
    requests.mode = MODE_CURRENT;
    TEST_ASSERT_TRUE(drive_request(&drive, &requests, &why));
    for (int n = 0; n < 3000; n++) { /* 20 counts a period: 125.66 rad/s, 1200 r/min */
        samples.encoder = (samples.encoder + 20u) % 10000u;
        steps(1);
    }
    /* No current flows and none is asked for: the integrators are at rest, the voltage is the EMF, psi_f
     * omega_e on q. */
    const double omega_e = 4.0 * 125.663706;
    const double angle = (double)drive.position.theta_e + 1.5e-4 * omega_e;
    const double expected_alpha = -0.183 * omega_e * sin(angle);
    const double alpha =
        311.0 * (2.0 * (double)command.duty.a - (double)command.duty.b - (double)command.duty.c) / 3.0;
    const double beta = 311.0 * ((double)command.duty.b - (double)command.duty.c) / sqrt(3.0);
    /* float arithmetic and 2e-6 of sin and cos on 92 V; one period of delay more or less would be 4.6 V */
    TEST_ASSERT_DOUBLE_WITHIN(0.01, expected_alpha, alpha);
    TEST_ASSERT_DOUBLE_WITHIN(0.01, 0.183 * omega_e * cos(angle), beta);
}

static void test_signals_show_the_drive(void)
{
    bring_to_run();
    const table_row_t *state = table_by_name(&signals_table, "state");
    TEST_ASSERT_EQUAL_FLOAT((float)DRIVE_OPERATION_ENABLED, table_get(state, &drive));
    TEST_ASSERT_EQUAL_INT32(DRIVE_OPERATION_ENABLED, table_choice(state, "operation_enabled"));
    TEST_ASSERT_EQUAL_INT32(DRIVE_FAULT, table_choice(state, "fault"));
    TEST_ASSERT_EQUAL_UINT32(drive.period, table_bits(table_by_name(&signals_table, "period"), &drive));
    TEST_ASSERT_EQUAL_FLOAT(311.0f, table_get(table_by_name(&signals_table, "u_dc"), &drive));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_offsets_take_exactly_their_time_and_gates_stay_off);
    RUN_TEST(test_offsets_are_measured_and_removed);
    RUN_TEST(test_an_offset_beyond_its_limit_is_a_fault);
    RUN_TEST(test_on_goes_through_switched_on_with_duties_before_gates);
    RUN_TEST(test_gates_that_do_not_come_on_are_a_fault);
    RUN_TEST(test_on_is_refused_with_the_reason);
    RUN_TEST(test_off_opens_the_bridge_in_the_same_step);
    RUN_TEST(test_off_while_switching_on_goes_back_to_ready);
    RUN_TEST(test_quick_stop_brakes_and_then_waits_for_off);
    RUN_TEST(test_trip_goes_to_fault_at_once_and_freezes_what_was_seen);
    RUN_TEST(test_a_trip_without_the_interrupt_is_seen_in_the_flags);
    RUN_TEST(test_a_trip_with_the_bridge_off_is_no_fault);
    RUN_TEST(test_the_first_fault_stays_and_later_ones_are_added);
    RUN_TEST(test_reset_needs_an_edge_and_a_cause_that_is_gone);
    RUN_TEST(test_a_latched_fault_refuses_on);
    RUN_TEST(test_board_failure_is_a_fault);
    RUN_TEST(test_samples_that_are_no_numbers_are_replaced_and_stop_the_drive_after_three);
    RUN_TEST(test_duties_stay_within_what_dead_time_and_pulse_allow);
    RUN_TEST(test_current_mode_follows_its_references_within_the_limit);
    RUN_TEST(test_a_bad_set_is_refused_and_the_old_one_runs_on);
    RUN_TEST(test_a_set_that_the_present_request_would_violate_is_refused);
    RUN_TEST(test_gains_change_while_running_without_a_jump);
    RUN_TEST(test_voltage_is_placed_where_the_rotor_will_be);
    RUN_TEST(test_signals_show_the_drive);
    return UNITY_END();
}
