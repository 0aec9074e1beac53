/* The modules together: the values that pass from one to another, and their timing. Each module has a test
 * of its own. */
#include "drive/drive.h"
#include "math/float_bits.h"
#include "settings/reasons.h"
#include "settings/signals.h"
#include "tests/unit/compare.h"
#include "tests/unit/drive_bench.h"
#include "tests/unit/rows.h"

void setUp(void)
{
    bench_begin();
}

/* ---- from room to room ---- */

/* 64 samples for the settling and calibration_periods for the average. The window that contains the last
 * sample decides the transition, which is shown a window later. */
static void test_calibration_takes_exactly_its_time_and_gates_stay_off(void)
{
    steps(64 + 512 - 1);
    expect_state(DRIVE_NOT_READY);
    TEST_ASSERT_EQUAL_INT32(GATES_OFF, command.gates);
    windows(1);
    expect_state(DRIVE_NOT_READY);
    windows(1);
    expect_state(DRIVE_READY);
    TEST_ASSERT_EQUAL_INT32(GATES_OFF, command.gates);
}

static void request_reset(void)
{
    requests_t requests = drive.requests;
    requests.fault_reset = 1;
    drive_request(&drive, &requests);
}

static void test_a_fault_calibrates_and_trims_again(void)
{
    bring_to_run();
    drive_trip(&drive);
    drive.medium.offset_trim.offset = (ab_t){0.1f, 0.1f};
    windows(38);
    samples.i_a = 0.5f;
    request(REQUEST_OFF);
    request_reset();
    windows(2);
    expect_state(DRIVE_NOT_READY);
    windows(1 + (64 + 512) / DRIVE_WINDOW);
    expect_state(DRIVE_READY);
    TEST_ASSERT_FLOAT_WITHIN(2e-5f, 0.5f, drive.fast.measure.offset.a); /* at most 512 roundings of 0.5 A */
    TEST_ASSERT_TRUE(drive.medium.offset_trim.offset.alpha == 0.0f &&
                     drive.medium.offset_trim.offset.beta == 0.0f);
}

static void test_a_fault_stops_the_calibration(void)
{
    steps(100);
    samples.u_dc = 410.0f;
    windows(1);
    expect_fault(REASON_DC_OVERVOLTAGE);
    windows_until_it_acts();
    TEST_ASSERT_EQUAL_UINT32(0u, drive.fast.measure.calibrated);
}

static void test_a_low_link_and_the_fault_line_refuse_the_start(void)
{
    bring_to_ready();
    samples.u_dc = nextafterf(200.0f, 0.0f);
    request(REQUEST_ON);
    windows(1);
    expect_state(DRIVE_READY);
    TEST_ASSERT_EQUAL_INT32(REASON_DC_UNDERVOLTAGE, drive.medium.sequence.refusal);
    samples.u_dc = 200.0f;
    samples.flags |= DRIVE_SAMPLE_FAULT_LINE;
    windows(1);
    TEST_ASSERT_EQUAL_INT32(REASON_FAULT_PRESENT, drive.medium.sequence.refusal);
    samples.flags &= ~DRIVE_SAMPLE_FAULT_LINE;
    windows(26); /* 20 ms, and one window until it is shown */
    expect_state(DRIVE_SWITCHED_ON);
}

static void test_off_leaves_nothing_on_when_it_acts(void)
{
    bring_to_run();
    request_currents(-1.0f, 3.0f);
    windows(4);
    TEST_ASSERT_TRUE(drive.fast.estimating != 0u && command.duty.a != 0.5f &&
                     drive.fast.control.voltage.q != 0.0f);
    request(REQUEST_OFF);
    windows_until_it_acts();
    expect_state(DRIVE_READY);
    TEST_ASSERT_EQUAL_INT32(GATES_OFF, command.gates);
    TEST_ASSERT_TRUE(command.duty.a == 0.5f && command.duty.b == 0.5f && command.duty.c == 0.5f);
    TEST_ASSERT_TRUE(drive.fast.demand.current.q == 0.0f && drive.fast.control.voltage.q == 0.0f &&
                     drive.fast.current_control.voltage_ref.q == 0.0f &&
                     drive.fast.demand.omega_m_ref == 0.0f);
    TEST_ASSERT_EQUAL_UINT32(0u, drive.fast.estimating);
}

/* Two counts per period are 12.57 rad/s, which k_p = 0.5 times this brakes; standstill is below 2 rad/s. */
static void test_quick_stop_brakes_until_standstill(void)
{
    bring_to_run();
    turn(2, 2000);
    request_speed(12.5f);
    request(REQUEST_QUICK_STOP);
    turn(2, 3 * DRIVE_WINDOW);
    expect_state(DRIVE_QUICK_STOP);
    TEST_ASSERT_EQUAL_FLOAT(0.0f, drive.fast.demand.omega_m_ref);
    TEST_ASSERT_TRUE(drive.fast.demand.current.q < -6.0f);
    for (int n = 0; n < 200 && drive.state == (int32_t)DRIVE_QUICK_STOP; n++) {
        const bool stood = fabsf(drive.window.omega_m) < 2.0f;
        windows(1); /* the encoder stands still, and its estimated speed decays */
        TEST_ASSERT_EQUAL(stood, drive.state == (int32_t)DRIVE_READY);
    }
    expect_state(DRIVE_READY);
    windows_until_it_acts();
    TEST_ASSERT_EQUAL_INT32(GATES_OFF, command.gates);
}

/* The request takes effect at the end of the window after the next. */
static void test_requests_reach_the_control(void)
{
    bring_to_run();
    request_currents(-1.0f, 3.0f);
    windows(3);
    TEST_ASSERT_TRUE(drive.fast.demand.current.d == -1.0f && drive.fast.demand.current.q == 3.0f);
    request_speed(0.0f); /* without a jump: the speed control continues at 3 A */
    windows(3);
    TEST_ASSERT_FLOAT_WITHIN(0.01f, 3.0f, drive.fast.demand.current.q);
    TEST_ASSERT_EQUAL_FLOAT(-1.0f, drive.fast.demand.current.d);
    request_speed(10.0f);
    windows(3);
    TEST_ASSERT_EQUAL_FLOAT(10.0f, drive.fast.demand.omega_m_ref);
    TEST_ASSERT_FLOAT_WITHIN(0.02f, 3.0f + 0.5f * 10.0f, drive.fast.demand.current.q);
}

/* The gates are switched on a period later than without charging. From the first duties on, and for this
 * number of periods after the gates are on, only the lower switches conduct. A current of the rotor ends
 * the charging. */
static void test_gates_are_charged_before_anything_is_controlled(void)
{
    for (int turns = 0; turns < 2; turns++) {
        bench_begin();
        drive.tunings[drive.in_force].fast.limits.charge_periods = 20u;
        bring_to_ready();
        request_currents(0.0f, 3.0f);
        request(REQUEST_ON);
        windows(2);
        for (uint32_t n = 1; n <= 3u + 20u; n++) {
            steps(1);
            samples.i_a = turns != 0 && n >= 10u ? 1.0f : 0.0f;
            const bool charges = n < 3u + 20u && (turns == 0 || n <= 10u);
            TEST_ASSERT_EQUAL(charges,
                              command.duty.a == 0.0f && command.duty.b == 0.0f && command.duty.c == 0.0f);
            TEST_ASSERT_EQUAL_INT32(n < 3u ? GATES_OFF : n == 3u ? GATES_ON : GATES_KEEP, command.gates);
            TEST_ASSERT_EQUAL(!charges, drive.fast.estimating != 0u);
        }
        windows(2);
        expect_state(DRIVE_OPERATION_ENABLED);
    }
}

/* Neither control keeps a value from earlier requests. While the gates switch on, the references are zero
 * for any request. */
static void test_every_start_is_from_rest(void)
{
    for (int speed = 0; speed < 2; speed++) {
        bench_begin();
        bring_to_run();
        request_currents(-1.0f, 3.0f);
        steps(100);
        TEST_ASSERT_TRUE(drive.fast.current_control.voltage_ref.q > 12.5f * 3.0f + 10.0f);
        request(REQUEST_OFF);
        windows(1);
        speed != 0 ? request_speed(0.0f) : request_currents(0.0f, 4.0f);
        request(REQUEST_ON);
        windows(2);
        while (drive.state != (int32_t)DRIVE_OPERATION_ENABLED) {
            steps(1);
            TEST_ASSERT_TRUE(drive.fast.demand.current.d == 0.0f && drive.fast.demand.current.q == 0.0f &&
                             drive.fast.current_control.voltage_ref.q == 0.0f);
        }
        windows(2);
        TEST_ASSERT_EQUAL_FLOAT(speed != 0 ? 0.0f : 4.0f, drive.fast.demand.current.q);
    }
}

static void test_trim_is_taken_from_the_current_that_is_controlled(void)
{
    bring_to_ready();
    samples.i_a = 1.0f;
    drive.medium.offset_trim.offset = (ab_t){0.125f, 0.0f};
    windows_until_it_acts();
    TEST_ASSERT_EQUAL_FLOAT(0.875f, drive.fast.measure.measured.current.alpha);
    TEST_ASSERT_EQUAL_FLOAT(1.0f, drive.fast.measure.measured.current_abc.a);
}

/* ---- faults ---- */

static void test_trip_goes_to_fault_at_once_and_freezes_what_was_seen(void)
{
    bring_to_run();
    turn(2, 1000);
    samples.i_a = 1.5f;
    samples.i_b = -0.25f;
    steps(1);
    const uint32_t period = drive.fast.period;
    const frame_t frame = drive.fast.rotor;
    drive_trip(&drive);
    expect_fault(REASON_MODULE_FAULT);
    samples.i_a = 0.0f;
    samples.u_dc = 100.0f;
    for (uint32_t n = 0; n < 3u * DRIVE_WINDOW; n++) {
        turn(2, 1);
        TEST_ASSERT_EQUAL_INT32(GATES_OFF, command.gates);
    }
    expect_fault(REASON_MODULE_FAULT);
    TEST_ASSERT_EQUAL_UINT32(period, drive.fault.period);
    TEST_ASSERT_FLOAT_WITHIN(1e-6f, 1.5f, drive.fault.i_a);
    TEST_ASSERT_FLOAT_WITHIN(1e-6f, -0.25f, drive.fault.i_b);
    TEST_ASSERT_FLOAT_WITHIN(1e-6f, 311.0f, drive.fault.u_dc);
    TEST_ASSERT_TRUE(drive.fault.theta_e == frame.theta_e && drive.fault.omega_e == frame.omega_e);
}

/* A rotor that its load drives feeds the link after the fault. */
static void test_a_link_that_rises_after_a_fault_does_not_take_its_place(void)
{
    bring_to_run();
    turn(2, 1000);
    drive_trip(&drive);
    windows(3);
    const drive_fault_t fault = drive.fault;
    samples.u_dc = 500.0f;
    for (uint32_t n = 0; n < 3u * DRIVE_WINDOW; n++) {
        steps(1);
        expect_fault(REASON_MODULE_FAULT);
        TEST_ASSERT_EQUAL_UINT32(fault.period, drive.fault.period);
    }
    TEST_ASSERT_EQUAL_UINT32(1u, drive.log.count);
}

static void test_a_trip_without_the_interrupt_is_seen_in_the_flags(void)
{
    bring_to_run();
    windows(2); /* the conditions of a running motor apply when its setpoint acts */
    samples.flags |= DRIVE_SAMPLE_TRIPPED;
    steps(1);
    expect_fault(REASON_MODULE_FAULT);
    TEST_ASSERT_EQUAL_UINT32(drive.fast.period, drive.fault.period);
    TEST_ASSERT_EQUAL_INT32(GATES_OFF, command.gates);
}

static void test_a_trip_with_the_bridge_off_is_no_fault(void)
{
    bring_to_ready();
    drive_trip(&drive);
    windows(2);
    expect_state(DRIVE_READY);
}

#define KEPT (CAPTURE_SLOTS / CAPTURE_COLUMNS) /* [periods] that are kept of the twelve rows */

/* The value of a row this number of periods ago; u_dc is the fourth of signals_history. */
static uint32_t kept(uint32_t ago, uint32_t slot)
{
    return capture_row(&drive.capture, capture_count(&drive.capture) - 1u - ago)[slot];
}

/* The link rises by 0.125 V per period, so that each period can be identified. */
static void test_history_ends_with_the_period_of_the_fault(void)
{
    bring_to_run();
    for (int n = 0; n <= 400; n++) { /* the last period is in the middle of a window */
        samples.u_dc = 300.0f + 0.125f * (float)n;
        samples.flags |= n == 400 ? DRIVE_SAMPLE_TRIPPED : 0u;
        steps(1);
    }
    steps(50);
    expect_fault(REASON_MODULE_FAULT);
    TEST_ASSERT_EQUAL_UINT32(KEPT, capture_count(&drive.capture));
    for (uint32_t ago = 0; ago < KEPT; ago++) {
        TEST_ASSERT_EQUAL_FLOAT(300.0f + 0.125f * (400.0f - (float)ago), float_of_bits(kept(ago, 3u)));
        TEST_ASSERT_EQUAL_UINT32(ago == 0u ? DRIVE_FAULT : DRIVE_OPERATION_ENABLED, kept(ago, 0u));
    }
}

/* The rows of the history are of successive periods, also if a second fault follows soon after the first. */
static void test_history_begins_again_with_the_reset(void)
{
    bring_to_run();
    drive_trip(&drive);
    request(REQUEST_OFF);
    windows(1u + DRIVE_WINDOWS(20e-3f));
    request_reset();
    samples.u_dc = 303.0f;
    windows(2);
    expect_state(DRIVE_NOT_READY);
    TEST_ASSERT_EQUAL_UINT32(1u, capture_count(&drive.capture));
    TEST_ASSERT_EQUAL_FLOAT(303.0f, float_of_bits(kept(0u, 3u)));
    steps(4);
    drive_stop(&drive, REASON_BOARD_FAILED);
    steps(4);
    TEST_ASSERT_EQUAL_UINT32(5u, capture_count(&drive.capture));
}

/* ---- parameters ---- */

/* Before the first period no window exists at whose end the set could take effect, so that it takes effect
 * at once. No signal may show another motor. */
static void test_an_offer_before_the_first_period_acts_at_once(void)
{
    params.motor_inductance_d = params.motor_inductance_q = 0.004f;
    offer_params();
    TEST_ASSERT_EQUAL_UINT32(0u, drive.offered);
    TEST_ASSERT_EQUAL_FLOAT(0.004f, drive.medium.inductance.learnt.value);
    TEST_ASSERT_EQUAL_FLOAT(0.004f, drive.tunings[drive.in_force].medium.inductance.inductance_q);
}

/* The set is offered in each period of a window in turn. The fast task takes it over in the second period of
 * the next window, the medium task with the window after it. The background then has the old one. */
static void test_an_offer_in_each_period_of_a_window_is_taken_in_the_second_of_the_next(void)
{
    for (uint32_t into = 0; into < DRIVE_WINDOW; into++) {
        bench_begin();
        bring_to_run();
        windows(1);
        steps(into);
        const uint32_t before = drive.in_force;
        params.current_bandwidth = 800.0f;
        params.dc_undervoltage = 100.0f;
        offer_params();
        steps(DRIVE_WINDOW + 1u - into);
        TEST_ASSERT_EQUAL_UINT32(before, drive.in_force);
        TEST_ASSERT_EQUAL_UINT32(1u, drive.offered);
        TEST_ASSERT_TRUE(drive.fast.current_control.q.tuning.kp != 0.0125f * 800.0f);
        steps(1); /* the second period of a window */
        TEST_ASSERT_EQUAL_UINT32(before ^ 1u, drive.in_force);
        TEST_ASSERT_TRUE(drive_idle_tuning(&drive) == &drive.tunings[before]);
        TEST_ASSERT_EQUAL_UINT32(0u, drive.offered);
        TEST_ASSERT_EQUAL_FLOAT(0.0125f * 800.0f, drive.fast.current_control.q.tuning.kp);
        TEST_ASSERT_EQUAL_FLOAT(200.0f, drive.medium.sequence.tuning.dc_undervoltage);
        windows(1);
        TEST_ASSERT_EQUAL_FLOAT(100.0f, drive.medium.sequence.tuning.dc_undervoltage);
        windows(2);
        TEST_ASSERT_EQUAL_UINT32(before ^ 1u, drive.in_force);
        expect_state(DRIVE_OPERATION_ENABLED);
    }
}

/* The medium task has not begun with its window, or has not finished it: it may still read the active
 * tuning, which the background must not get. The offer waits until the medium task has finished. */
static void test_an_offer_waits_for_a_medium_task_that_is_late(void)
{
    bring_to_run();
    windows(1);
    for (uint32_t n = 0; n + 1u < DRIVE_WINDOW; n++) {
        TEST_ASSERT_FALSE(drive_step(&drive, &samples, &command));
    }
    /* a window in which the medium task has not run. */
    TEST_ASSERT_TRUE(drive_step(&drive, &samples, &command));
    const uint32_t before = drive.in_force;
    params.dc_undervoltage = 100.0f;
    offer_params();
    for (uint32_t n = 0; n < DRIVE_WINDOW + 2u; n++) {
        TEST_ASSERT_FALSE(drive_step(&drive, &samples, &command));
    }
    TEST_ASSERT_EQUAL_UINT32(1u, drive.offered);
    TEST_ASSERT_EQUAL_UINT32(before, drive.in_force);
    drive_medium_step(&drive);
    TEST_ASSERT_EQUAL_FLOAT(200.0f, drive.medium.sequence.tuning.dc_undervoltage);
    windows(2);
    TEST_ASSERT_EQUAL_UINT32(0u, drive.offered);
    TEST_ASSERT_EQUAL_UINT32(before ^ 1u, drive.in_force);
    TEST_ASSERT_EQUAL_FLOAT(100.0f, drive.medium.sequence.tuning.dc_undervoltage);
}

/* The medium task of a window ends one window late: the end of the next window has no setpoint. */
static void miss_a_window(void)
{
    for (uint32_t n = 0; n + 1u < DRIVE_WINDOW; n++) {
        TEST_ASSERT_FALSE(drive_step(&drive, &samples, &command));
    }
    TEST_ASSERT_TRUE(drive_step(&drive, &samples, &command));
    for (uint32_t n = 0; n < DRIVE_WINDOW; n++) {
        TEST_ASSERT_FALSE(drive_step(&drive, &samples, &command));
    }
    TEST_ASSERT_EQUAL_UINT32(0u, drive.fast.sum.periods);
    TEST_ASSERT_EQUAL_UINT32(1u, drive.fast.sum.unsound);
    drive_medium_step(&drive);
}

static void test_two_missing_setpoints_of_three_open_the_bridge_and_every_third_does_not(void)
{
    bring_to_run();
    windows(1);
    for (uint32_t n = 0; n < 20u; n++) {
        miss_a_window();
        windows(1);
        TEST_ASSERT_EQUAL_UINT32(0u, drive.fast.bridge.open);
    }
    miss_a_window();
    miss_a_window();
    steps(1);
    TEST_ASSERT_EQUAL_UINT32(1u, drive.fast.bridge.open);
    windows(2);
    expect_fault(REASON_MEDIUM_LATE);
}

static void test_an_offer_withdrawn_is_not_taken(void)
{
    bring_to_run();
    params.dc_overvoltage = 310.0f;
    params.dc_undervoltage = 100.0f;
    offer_params();
    drive_withdraw(&drive);
    windows(3);
    expect_state(DRIVE_OPERATION_ENABLED);
    TEST_ASSERT_EQUAL_FLOAT(200.0f, drive.medium.sequence.tuning.dc_undervoltage);
}

/* For each part of the drive one coefficient that depends on the set, calculated by hand. */
static void test_a_new_set_reaches_every_part(void)
{
    bring_to_run();
    set_rows(&params, "calibration_periods=1024 overcurrent_trip=13 encoder_lines=1000 observer_gain=180 "
                      "motor_flux_linkage=0.16 offset_trim=0.025 minimum_pulse=2.5e-6 doubtful_current=0.2 "
                      "current_bandwidth=800 motor_inductance_d=12e-3 motor_inductance_q=12e-3 speed_kp=0.25 "
                      "motor_pole_pairs=2 start_speed=9 start_current=6 handover_speed=25 fallback_speed=11 "
                      "position_source=sensorless");
    offer_params();
    windows(3); /* the fast task takes it over in the second one, the medium task with the third */
    const fast_tuning_t *fast = &drive.tunings[drive.in_force].fast;
    TEST_ASSERT_EQUAL_UINT32(64u + 1024u, fast->measure.periods);
    TEST_ASSERT_EQUAL_FLOAT(13.0f, fast->guard.limit[FAULT_LIMIT_OVERCURRENT]);
    TEST_ASSERT_EQUAL_UINT32(3999u, fast->encoder.last_count);
    TEST_ASSERT_EQUAL_FLOAT(0.16f, drive.medium.flux.flux_linkage);
    TEST_ASSERT_EQUAL_FLOAT(0.025f, drive.medium.offset_trim.tuning.gain);
    const svpwm_tuning_t *modulation = &fast->inverter.modulation;
    TEST_ASSERT_FLOAT_WITHIN(1e-6f, 0.05f, modulation->middle - 0.5f * modulation->range);
    TEST_ASSERT_EQUAL_FLOAT(0.2f, fast->doubt.current);
    const current_control_t *control = &drive.fast.current_control;
    TEST_ASSERT_FLOAT_WITHIN(1e-6f, 9.6f, control->d.tuning.kp);
    TEST_ASSERT_FLOAT_WITHIN(1e-6f, 9.6f, control->q.tuning.kp);
    TEST_ASSERT_FLOAT_WITHIN(1e-4f, 120.0f, control->reactance.d); /* 12 mH in 0.1 ms */
    TEST_ASSERT_FLOAT_WITHIN(1e-4f, 120.0f, control->reactance.q);
    TEST_ASSERT_EQUAL_FLOAT(0.16f, fast->reference.flux_linkage);
    TEST_ASSERT_EQUAL_FLOAT(9.0f * 2.0f, fast->reference.catching.speed_min);
    TEST_ASSERT_EQUAL_FLOAT(6.0f, fast->reference.forced.current);
    const manoeuvres_t *m = &drive.medium.manoeuvres;
    TEST_ASSERT_EQUAL_FLOAT(0.25f, m->run.speed.pi.tuning.kp);
    TEST_ASSERT_EQUAL_FLOAT(0.5f, m->limits.pole_pairs_inverse);
    TEST_ASSERT_EQUAL_FLOAT(0.1f * 6.0f, m->handover.tuning.current_margin);
    TEST_ASSERT_EQUAL_FLOAT(11.0f * 2.0f, m->lock.tuning.speed_slow);
    TEST_ASSERT_EQUAL_FLOAT(25.0f * 2.0f, m->limits.handover_speed);
    TEST_ASSERT_EQUAL_UINT32(1u, m->limits.sensorless);
}

/* ---- voltage ---- */

/* The rotor stands still, and its current does not respond. The control receives the voltage that was
 * applied: its integral moves to this voltage, so that after 16 time constants L/R its output exceeds it
 * by k_p times the error. The longest voltage is 2/3 x 0.92 x 311 V = 190.7 V, less at least the 4/3 x
 * 8.03 V that the inverter takes. */
static void test_control_gets_what_the_link_has_too_little_for(void)
{
    bring_to_run();
    request_currents(-10.0f, 10.0f);
    steps(2000);
    const dq_t made = drive.fast.control.voltage;
    TEST_ASSERT_FLOAT_WITHIN(0.1f, -125.0f, drive.fast.current_control.voltage_ref.d - made.d);
    TEST_ASSERT_FLOAT_WITHIN(0.1f, 125.0f, drive.fast.current_control.voltage_ref.q - made.q);
    const double u = hypot((double)made.d, (double)made.q);
    TEST_ASSERT_TRUE(u > 150.0 && u < 190.7 + 10.8);
}

/* The voltage computed at t_k acts one period later for one period: its frame is rotated forward by 1.5
 * T_s omega_e. */
static void test_voltage_is_placed_where_the_rotor_will_be(void)
{
    bring_to_run();
    request_currents(0.0f, 0.0f);
    windows(2);
    turn(20, 3000); /* 125.66 rad/s, 1200 r/min */
    /* Without a current the integrators are at rest, and the voltage is the EMF, psi_f omega_e on q. */
    const double omega_e = 4.0 * (20.0 * 2.0 * PI);
    const double angle = (double)drive.fast.demand.frame.theta_e + 1.5e-4 * omega_e;
    const double alpha =
        311.0 * (2.0 * (double)command.duty.a - (double)command.duty.b - (double)command.duty.c) / 3.0;
    const double beta = 311.0 * ((double)command.duty.b - (double)command.duty.c) / sqrt(3.0);
    /* The limit is the sum of three parts: half a count of each leg, 311 V/15000 = 20.7 mV, of which 4/3
     * appear in alpha and 2/sqrt(3) in beta; the float arithmetic; and 2e-6 of sin and cos on 92 V. One
     * period of delay more or less would be 4.6 V. */
    TEST_ASSERT_DOUBLE_WITHIN(0.0277 + 0.01, -0.183 * omega_e * sin(angle), alpha);
    TEST_ASSERT_DOUBLE_WITHIN(0.0240 + 0.01, 0.183 * omega_e * cos(angle), beta);
}
