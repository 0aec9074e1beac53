#include "drive/drive.h"

#include <complex.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "drive/reasons.h"
#include "drive/signals.h"
#include "unity.h"

static drive_t drive;
static params_t params;
static drive_samples_t samples; /* of two current sensors */
static drive_command_t command;
static params_error_t why;

/* The paper's motor at a speed that nothing disturbs, behind an inverter that loses what the drive's model
 * says: solved for a constant speed within each period. What step k commands acts on [t_k+1, t_k+2). */
#define PI     3.14159265358979323846
#define PERIOD 1e-4
#define R      (0.95 + 0.0215) /* winding and devices */
#define L      0.0125
#define PSI    0.183
#define U_DC   311.0

static struct {
    double theta_e, omega_e; /* electrical, at t_k */
    double acceleration;     /* [rad/s^2] electrical */
    double flux, flux_end;   /* [Wb], goes there at 0.2 Wb/s */
    double loss;             /* [V] of a leg whose current is certain */
    double noise;            /* [A] largest error of a current sample */
    double complex current;  /* [A] at t_k */
    double complex duty;     /* acts from t_k on, if the gates are on */
    bool driven;
    uint32_t random;
} machine;

static void step(void)
{
    samples.i_c = -(samples.i_a + samples.i_b);
    drive_step(&drive, &samples, &command);
}

void setUp(void)
{
    memset(&machine, 0, sizeof machine);
    machine.flux = PSI;
    machine.flux_end = PSI;
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
        step();
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
    /* Half a count of each leg, 311 V/15000 = 20.7 mV: 4/3 of it in alpha, 2/sqrt(3) in beta; float
     * arithmetic and 2e-6 of sin and cos on 92 V; one period of delay more or less would be 4.6 V. */
    TEST_ASSERT_DOUBLE_WITHIN(0.0277 + 0.01, expected_alpha, alpha);
    TEST_ASSERT_DOUBLE_WITHIN(0.0240 + 0.01, 0.183 * omega_e * cos(angle), beta);
}

/* ---- without the encoder ---- */

static double wrapped(double angle)
{
    return angle - 2.0 * PI * nearbyint(angle / (2.0 * PI));
}

static double complex vector_of(double a, double b, double c)
{
    return (2.0 * a - b - c) / 3.0 + (double complex)I * ((b - c) / sqrt(3.0));
}

static double phase_of(double complex vector, int phase)
{
    return creal(vector * cexp(-(double complex)I * (2.0 * PI / 3.0 * phase)));
}

/* As the model: each leg loses its share against its current, linearly within 50 mA. */
static double complex lost_at(double complex current, double leg)
{
    double lost[3];
    for (int phase = 0; phase < 3; phase++) {
        lost[phase] = leg * fmax(-1.0, fmin(1.0, phase_of(current, phase) / 0.05));
    }
    return vector_of(lost[0], lost[1], lost[2]);
}

static double noise(void)
{
    machine.random = machine.random * 1664525u + 1013904223u;
    return machine.noise * ((double)(machine.random >> 8) / 8388608.0 - 1.0);
}

static double complex duty_of(const drive_command_t *of)
{
    return vector_of((double)of->duty.a, (double)of->duty.b, (double)of->duty.c);
}

/* Samples at t_k, the drive's step, and the machine on to t_k+1. */
static void machine_step(void)
{
    samples.i_a = (float)(phase_of(machine.current, 0) + noise());
    samples.i_b = (float)(phase_of(machine.current, 1) + noise());
    const double turns = machine.theta_e / (2.0 * PI * 4.0);
    samples.encoder = (uint32_t)(10000.0 * (turns - floor(turns))) % 10000u;
    steps(1);
    machine.driven = (samples.flags & DRIVE_SAMPLE_TRIPPED) == 0u;

    const double omega = machine.omega_e + 0.5 * machine.acceleration * PERIOD;
    if (machine.driven) {
        const double complex u = machine.duty * U_DC - lost_at(machine.current, machine.loss);
        const double rate = R / L;
        const double a = exp(-rate * PERIOD);
        const double complex emf =
            (double complex)I * omega * machine.flux * cexp((double complex)I * machine.theta_e);
        const double complex turned = cexp((double complex)I * (omega * PERIOD));
        machine.current = a * machine.current + (1.0 - a) / R * u -
                          emf / L * (turned - a) / (rate + (double complex)I * omega);
    } else {
        machine.current = 0.0;
    }
    machine.duty = duty_of(&command);
    machine.theta_e += omega * PERIOD;
    machine.omega_e += machine.acceleration * PERIOD;
    machine.flux += fmax(-0.2 * PERIOD, fmin(0.2 * PERIOD, machine.flux_end - machine.flux));
}

static void machine_steps(uint32_t count)
{
    for (uint32_t n = 0; n < count; n++) {
        machine_step();
    }
}

/* An inverter without loss, on the machine's side and on the drive's. */
static void make_inverter_ideal(void)
{
    params.turn_on_delay = 0.0f;
    params.turn_off_delay = params.dead_time;
    params.device_drop = 0.0f;
}

/* With `params`, at this speed, in mode current without a request: ready, not on. */
static void given_machine(double omega_e)
{
    drive_init(&drive, &params);
    machine.theta_e = 0.3;
    machine.omega_e = omega_e;
    requests_t requests = drive.requests;
    requests.mode = MODE_CURRENT;
    TEST_ASSERT_TRUE(drive_request(&drive, &requests, &why));
    machine_steps(2000);
    expect_state(DRIVE_READY);
}

static void given_running_machine(double omega_e, double i_q)
{
    given_machine(omega_e);
    requests_t requests = drive.requests;
    requests.enable = REQUEST_ON;
    requests.i_q_request = (float)i_q;
    TEST_ASSERT_TRUE(drive_request(&drive, &requests, &why));
    machine_steps(3);
    expect_state(DRIVE_OPERATION_ENABLED);
}

/* Angle of the estimator against the machine at the instant of the last sample. */
static double estimate_error(void)
{
    return wrapped((double)drive.estimate.theta_e - (machine.theta_e - machine.omega_e * PERIOD));
}

/* The estimator's voltage of step k is what step k-2 modulated, times the link's mean over the period, less
 * what the inverter takes at the mean current, whatever share of that is compensated. The currents are
 * nothing but different from step to step, so is the link. Float: ten roundings of 200 V, 1.2e-4 V. */
static void test_observer_gets_the_voltage_that_acted_in_the_last_period(void)
{
    static const float gains[] = {1.0f, 0.5f, 0.0f};
    for (int m = 0; m < 3; m++) {
        double complex duty[4] = {0.0}; /* newest first */
        double complex current = 0.0;
        double u_dc = U_DC;
        double early = 0.0;
        double late = 0.0;
        setUp();
        params.compensation_gain = gains[m];
        params.offset_trim = 0.0f; /* the estimator gets the sample itself */
        drive_init(&drive, &params);
        bring_to_ready();
        TEST_ASSERT_TRUE(drive.observer_voltage.alpha == 0.0f && drive.observer_voltage.beta == 0.0f);
        request(REQUEST_ON, 0);
        requests_t requests = drive.requests;
        requests.mode = MODE_CURRENT;
        requests.i_q_request = 5.0f;
        TEST_ASSERT_TRUE(drive_request(&drive, &requests, &why));
        for (int k = 0; k < 400; k++) {
            const double complex before = current;
            const double u_dc_before = u_dc;
            current =
                k < 10 ? 0.0 : 4.0 * cexp((double complex)I * (0.37 * k)); /* nowhere near zero for long */
            u_dc = U_DC + 10.0 * sin(0.9 * k);
            samples.i_a = (float)phase_of(current, 0);
            samples.i_b = (float)phase_of(current, 1);
            samples.u_dc = (float)u_dc;
            samples.encoder = (samples.encoder + 20u) % 10000u;
            const bool before_start = drive.estimating == 0u;
            steps(1);
            if (before_start) {
                TEST_ASSERT_TRUE(drive.observer_voltage.alpha == 0.0f && drive.observer_voltage.beta == 0.0f);
            } else {
                const double mean_dc = 0.5 * (u_dc + u_dc_before);
                const double complex lost = lost_at(0.5 * (current + before), 0.023 * mean_dc + 0.875);
                const double complex seen = (double)drive.observer_voltage.alpha +
                                            (double complex)I * (double)drive.observer_voltage.beta;
                TEST_ASSERT_DOUBLE_WITHIN(2e-4, 0.0, cabs(seen - (duty[1] * mean_dc - lost)));
                early = fmax(early, cabs(seen - (duty[0] * mean_dc - lost)));
                late = fmax(late, cabs(seen - (duty[2] * mean_dc - lost)));
            }
            memmove(&duty[1], &duty[0], 3 * sizeof duty[0]);
            duty[0] = duty_of(&command);
        }
        expect_state(DRIVE_OPERATION_ENABLED);
        TEST_ASSERT_TRUE(drive.estimating != 0u);
        TEST_ASSERT_TRUE(early > 1.0 && late > 1.0); /* so it would have shown */
    }
}

/* The same in the loop: the estimator is right when its voltage is. Without errors in inverter and sensors
 * it is off by what float arithmetic leaves, 0.3 mrad; a voltage one period off is omega T = 42 mrad. */
static void test_estimate_is_that_of_the_sample_in_either_direction(void)
{
    for (int way = -1; way <= 1; way += 2) {
        setUp();
        make_inverter_ideal();
        given_running_machine(way * 418.9, way * 4.0);
        machine_steps(5000);
        for (int n = 0; n < 1000; n++) {
            machine_step();
            TEST_ASSERT_DOUBLE_WITHIN(3e-4, 0.0, estimate_error());
        }
        TEST_ASSERT_DOUBLE_WITHIN(1.0, way * 418.9, (double)drive.estimate.omega_e);
        TEST_ASSERT_EQUAL_UINT32(0u, drive.estimator.estimate.invalid);
    }
}

/* While the bridge was off the rotor has been turned and reversed: the estimator does not go on from where
 * it was. The encoder's angle is right to half a step, 1.3 mrad, and its speed to 1.5 rad/s here; what is
 * left by that speed after 10 ms is below the 5 mrad that a reset may leave. */
static void test_estimator_starts_anew_at_every_switching_on(void)
{
    make_inverter_ideal();
    given_running_machine(418.9, 0.0);
    machine_steps(2000);
    request(REQUEST_OFF, 0);
    machine_steps(1);
    machine.theta_e += 1.7;
    machine.omega_e = -300.0;
    const position_t last = drive.estimate;
    machine_steps(500);
    TEST_ASSERT_EQUAL_MEMORY(&last, &drive.estimate, sizeof last); /* it rests */
    request(REQUEST_ON, 0);
    machine_steps(3);
    expect_state(DRIVE_OPERATION_ENABLED);
    for (int n = 0; n < 1000; n++) {
        machine_step();
        TEST_ASSERT_DOUBLE_WITHIN(5e-3, 0.0, estimate_error());
    }
    TEST_ASSERT_EQUAL_UINT32(0u, drive.estimator.estimate.invalid);
}

/* The control's angle goes on by omega T from period to period. The encoder's is right to its half step,
 * 1.257 mrad, the estimate to 0.3 mrad; in current that is nothing but noise: 4 A times 1.5 mrad. */
static void test_position_source_changes_live_without_a_bump(void)
{
    for (int way = -1; way <= 1; way += 2) {
        setUp();
        make_inverter_ideal();
        given_running_machine(way * 418.9, way * 4.0);
        machine_steps(4000);
        params_t next = drive.params;
        for (int n = 0; n < 8; n++) {
            next.position_source = n % 2 == 0 ? POSITION_SENSORLESS : POSITION_ENCODER;
            TEST_ASSERT_TRUE(drive_apply(&drive, &next, &why));
            for (int m = 0; m < 50 + n; m++) {
                const double before = (double)drive.position.theta_e;
                machine_step();
                const double moved = wrapped((double)drive.position.theta_e - before);
                TEST_ASSERT_DOUBLE_WITHIN(2.0 * 1.26e-3 + 3e-4, way * 418.9e-4, moved);
                TEST_ASSERT_DOUBLE_WITHIN(0.05, way * 4.0, (double)drive.current.q);
                TEST_ASSERT_DOUBLE_WITHIN(0.05, 0.0, (double)drive.current.d);
                const position_t *source = n % 2 == 0 ? &drive.estimate : &drive.encoder_position;
                TEST_ASSERT_EQUAL_MEMORY(source, &drive.position, sizeof *source);
            }
        }
        expect_state(DRIVE_OPERATION_ENABLED);
    }
}

/* 8 rad/s: one count a period is 6.28 rad/s, two are 12.57. */
static void test_sensorless_start_needs_a_rotor_that_turns(void)
{
    static const struct {
        double omega_m;
        bool sensorless, starts;
    } cases[] = {{0.0, true, false},   {6.2832, true, false}, {-6.2832, true, false}, {7.9, true, false},
                 {-7.9, true, false},  {8.1, true, true},     {-8.1, true, true},     {12.566, true, true},
                 {-150.0, true, true}, {0.0, false, true},    {6.2832, false, true}};
    for (size_t n = 0; n < sizeof cases / sizeof cases[0]; n++) {
        setUp();
        params.position_source = cases[n].sensorless ? POSITION_SENSORLESS : POSITION_ENCODER;
        given_machine(4.0 * cases[n].omega_m);
        TEST_ASSERT_EQUAL_MEMORY(&drive.encoder_position, &drive.position, sizeof drive.position);
        request(REQUEST_ON, 0);
        machine_steps(1);
        expect_state(cases[n].starts ? DRIVE_SWITCHED_ON : DRIVE_READY);
        TEST_ASSERT_EQUAL_INT32(cases[n].starts ? REASON_NONE : REASON_TOO_SLOW, drive.refusal);
        if (!cases[n].starts) { /* and as soon as it turns, it goes */
            TEST_ASSERT_EQUAL_INT32(GATES_OFF, command.gates);
            machine.omega_e = 40.0;
            machine_steps(200);
            expect_state(DRIVE_OPERATION_ENABLED);
            TEST_ASSERT_EQUAL_INT32(REASON_NONE, drive.refusal);
        }
    }
}

/* Until the sign `bit` fails in every period it takes what the machine does; from then on 0.1 s on balance,
 * 1001 periods. The step that finds it opens the bridge. */
static void expect_lost(int32_t reason, uint32_t bit, double most_seconds)
{
    const uint32_t begin = drive.period;
    for (uint32_t n = 0; drive.state == DRIVE_OPERATION_ENABLED && n < (uint32_t)(most_seconds / PERIOD);
         n++) {
        TEST_ASSERT_EQUAL_HEX32(0u, drive.estimator.estimate.invalid);
        machine_step();
    }
    const double taken = (drive.period - begin) * PERIOD;
    printf("%s after %.4f s\n", reason_by_number(drive.fault.reason)->name, taken);
    expect_state(DRIVE_FAULT);
    TEST_ASSERT_EQUAL_INT32(reason, drive.fault.reason);
    TEST_ASSERT_EQUAL_HEX32(bit, drive.estimator.estimate.invalid);
    TEST_ASSERT_EQUAL_INT32(GATES_OFF, command.gates);
    TEST_ASSERT_TRUE(command.duty.a == 0.5f && command.duty.b == 0.5f && command.duty.c == 0.5f);
    TEST_ASSERT_EQUAL_UINT32(drive.period, drive.fault.period);
    TEST_ASSERT_TRUE(taken > 0.1);
    machine_steps(300);
    expect_state(DRIVE_FAULT);
    TEST_ASSERT_EQUAL_INT32(reason, drive.fault.reason);
}

/* Sensorless and settled: 1 s is eight time constants of the slowest loop used here. That one is
 * conventional; its integrator moves by less than half its last digit, 1.6e-5 rad/s, below 1.6e-5/(65 1e-4)
 * = 2.5 mrad. */
static void given_sensorless(double omega_e)
{
    make_inverter_ideal();
    params.position_source = POSITION_SENSORLESS;
    given_running_machine(omega_e, 0.0);
    machine_steps(10000);
    expect_state(DRIVE_OPERATION_ENABLED);
    TEST_ASSERT_DOUBLE_WITHIN(3e-3, 0.0, estimate_error());
}

/* At 1.6 of the flux |e| is 1.6 psi_f omega, more than the parameter's 1.5 and 20 rad/s allow (1.55), at 0.45
 * less than its 0.5. On the way there the feed-forward sees the speed change by 0.2 Wb/s/0.183 Wb 400 rad/s =
 * 437 rad/s^2, which costs an angle of 437/ki = 0.16 rad and no lock. */
static void test_estimate_whose_emf_does_not_fit_its_speed_is_lost(void)
{
    given_sensorless(400.0);
    machine.flux_end = 1.6 * PSI;
    expect_lost(REASON_ESTIMATE_AMPLITUDE, ESTIMATOR_AMPLITUDE, 0.7);
    setUp();
    given_sensorless(-400.0);
    machine.flux_end = 0.45 * PSI;
    expect_lost(REASON_ESTIMATE_AMPLITUDE, ESTIMATOR_AMPLITUDE, 0.7);
}

/* A conventional loop of 20 rad/s: wn = 8.06 rad/s, ki = 65 rad/s^2. At 50 rad/s^2 of acceleration it needs a
 * sine of 0.77, more than 0.5, and is there with its time constant of 0.12 s. */
static void test_estimate_that_does_not_keep_up_is_lost(void)
{
    for (int way = -1; way <= 1; way += 2) {
        setUp();
        params.pll_bandwidth = 20.0f;
        params.feedforward_cutoff = 0.0f;
        params.estimate_detector_max = 0.5f;
        given_sensorless(way * 400.0);
        machine.acceleration = way * 50.0;
        expect_lost(REASON_ESTIMATE_DETECTOR, ESTIMATOR_DETECTOR, 0.6);
    }
}

/* An EMF of 150 V wants an error of 2 atanh(150/200) = 1.95 A, more than 1.5 A. Amplitude not judged. */
static void test_estimate_whose_current_is_not_the_measured_one_is_lost(void)
{
    params.estimate_current_max = 1.5f;
    params.estimate_amplitude_max = 1.0f;
    given_sensorless(400.0);
    machine.flux_end = 150.0 / 400.0;
    expect_lost(REASON_ESTIMATE_CURRENT, ESTIMATOR_CURRENT, 1.2);
}

/* estimate_speed_min = 3 rad/s are 12 rad/s electrical. */
static void test_estimate_of_a_rotor_too_slow_to_see_is_lost(void)
{
    for (int way = -1; way <= 1; way += 2) {
        setUp();
        given_sensorless(way * 60.0);
        machine.acceleration = way * -100.0;
        machine_steps(4700);
        machine.acceleration = 0.0;
        TEST_ASSERT_DOUBLE_WITHIN(1e-6, way * 13.0, machine.omega_e);
        machine_steps(2000);
        expect_state(DRIVE_OPERATION_ENABLED);
        machine.acceleration = way * -30.0;
        expect_lost(REASON_ESTIMATE_SPEED, ESTIMATOR_SPEED, 0.2); /* at 7 rad/s */
    }
}

/* Who runs on the encoder does not care. */
static void test_lost_estimate_is_no_fault_on_the_encoder(void)
{
    make_inverter_ideal();
    given_running_machine(400.0, 0.0);
    machine_steps(3000);
    machine.flux_end = 1.6 * PSI;
    machine_steps(7000);
    TEST_ASSERT_EQUAL_HEX32(ESTIMATOR_AMPLITUDE, drive.estimator.estimate.invalid);
    expect_state(DRIVE_OPERATION_ENABLED);
    params_t next = drive.params; /* and stops as soon as it would have to rely on it */
    next.position_source = POSITION_SENSORLESS;
    TEST_ASSERT_TRUE(drive_apply(&drive, &next, &why));
    machine_steps(1);
    expect_state(DRIVE_FAULT);
    TEST_ASSERT_EQUAL_INT32(REASON_ESTIMATE_AMPLITUDE, drive.fault.reason);
    TEST_ASSERT_EQUAL_INT32(GATES_OFF, command.gates);
}

typedef struct {
    uint32_t coasted, crossings; /* periods; periods with a current near zero */
} coasting_t;

/* A turn and more in steady state, after half a second. When the tracking loop coasts, the speed of the
 * estimate is the smooth one of the period before and no error is counted. `near`: the mean of the samples
 * at t_k-1 and t_k has a phase within 0.1 A of zero; noise of 5 mA apart, that is when it coasts, and for the
 * 3 periods and two time constants of the EMF filter, 10 periods, that it is remembered. */
static coasting_t coasting(double periods)
{
    coasting_t result = {0u, 0u};
    uint32_t since = 100u;
    machine.noise = 0.005;
    machine_steps(5000);
    double complex before = machine.current;
    for (double n = 0.0; n < periods; n += 1.0) {
        const double complex mean = 0.5 * (before + machine.current);
        const double smooth = (double)drive.estimator.estimate.omega_smooth;
        before = machine.current;
        machine_step();
        double smallest = 100.0;
        for (int phase = 0; phase < 3; phase++) {
            smallest = fmin(smallest, fabs(phase_of(mean, phase)));
        }
        const bool coasts = drive.doubt != 0u;
        since = smallest < 0.11 ? 0u : since + 1u;
        result.crossings += smallest < 0.09;
        result.coasted += coasts;
        if (coasts) {
            TEST_ASSERT_TRUE(since < 13u);
            TEST_ASSERT_TRUE((double)drive.estimate.omega_e == smooth);
            TEST_ASSERT_EQUAL_FLOAT(0.0f, drive.estimator.estimate.detector);
        } else {
            TEST_ASSERT_TRUE(smallest >= 0.09 || drive.params.doubtful_current == 0.0f ||
                             fabs(machine.omega_e) > 60.0);
        }
    }
    expect_state(DRIVE_OPERATION_ENABLED);
    return result;
}

/* 100 r/min, 5.76 A: the EMF is 7.67 V, a leg loses 8.03 V. A phase passes +-0.1 A in 0.2/(5.76 41.9) = 0.83
 * ms, six times a turn of 150 ms. */
static void test_voltage_in_doubt_near_a_current_zero_is_not_tracked(void)
{
    for (int way = -1; way <= 1; way += 2) {
        setUp();
        machine.loss = 0.023 * U_DC + 0.875;
        params.observer_emf_cutoff = 2000.0f;
        given_running_machine(way * 41.89, way * 5.76);
        const coasting_t found = coasting(3000.0); /* two turns, twelve zeros */
        printf("coasted %u of 3000 periods, %u near zero\n", (unsigned)found.coasted,
               (unsigned)found.crossings);
        TEST_ASSERT_TRUE(found.crossings >= 12u * 6u && found.crossings <= 12u * 10u);
        /* each zero: 8.3 periods and 12 that remember */
        TEST_ASSERT_TRUE(found.coasted >= 12u * 16u && found.coasted <= 12u * 26u);
    }
}

static void test_no_doubt_where_the_emf_is_large_or_the_limit_is_zero(void)
{
    machine.loss = 0.023 * U_DC + 0.875;
    given_running_machine(185.0, 2.0); /* 33.9 V, more than four times 8.03 V: 32.1 V */
    TEST_ASSERT_EQUAL_UINT32(0u, coasting(1000.0).coasted);
    setUp();
    machine.loss = 0.023 * U_DC + 0.875;
    given_running_machine(165.0, 2.0); /* 30.2 V */
    TEST_ASSERT_TRUE(coasting(1000.0).coasted > 0u);
    setUp();
    machine.loss = 0.023 * U_DC + 0.875;
    params.doubtful_current = 0.0f;
    given_running_machine(41.89, 5.76);
    const coasting_t found = coasting(3000.0);
    TEST_ASSERT_EQUAL_UINT32(0u, found.coasted);
    TEST_ASSERT_TRUE(found.crossings > 0u);
}

/* The compare registers hold whole counts, 7500 a period: a duty between two of them would not act as told. A
 * float at 7500 is good to 5e-4. */
static void test_duties_are_whole_counts_of_the_timer(void)
{
    bool odd = false;
    given_running_machine(418.9, 4.0);
    for (int n = 0; n < 1000; n++) {
        machine_step();
        const float duty[] = {command.duty.a, command.duty.b, command.duty.c};
        for (int leg = 0; leg < 3; leg++) {
            const double count = 7500.0 * (double)duty[leg];
            TEST_ASSERT_DOUBLE_WITHIN(1e-3, nearbyint(count), count);
            odd = odd || ((int)nearbyint(count) & 1) != 0;
        }
    }
    TEST_ASSERT_TRUE(odd); /* and not fewer steps */
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
    RUN_TEST(test_observer_gets_the_voltage_that_acted_in_the_last_period);
    RUN_TEST(test_estimate_is_that_of_the_sample_in_either_direction);
    RUN_TEST(test_estimator_starts_anew_at_every_switching_on);
    RUN_TEST(test_position_source_changes_live_without_a_bump);
    RUN_TEST(test_sensorless_start_needs_a_rotor_that_turns);
    RUN_TEST(test_estimate_whose_emf_does_not_fit_its_speed_is_lost);
    RUN_TEST(test_estimate_that_does_not_keep_up_is_lost);
    RUN_TEST(test_estimate_whose_current_is_not_the_measured_one_is_lost);
    RUN_TEST(test_estimate_of_a_rotor_too_slow_to_see_is_lost);
    RUN_TEST(test_lost_estimate_is_no_fault_on_the_encoder);
    RUN_TEST(test_voltage_in_doubt_near_a_current_zero_is_not_tracked);
    RUN_TEST(test_no_doubt_where_the_emf_is_large_or_the_limit_is_zero);
    RUN_TEST(test_duties_are_whole_counts_of_the_timer);
    RUN_TEST(test_signals_show_the_drive);
    return UNITY_END();
}
