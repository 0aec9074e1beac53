/* The drive on its estimate, with a machine at its terminals. */
#include "drive/drive.h"
#include "settings/reasons.h"
#include "settings/signals.h"
#include "tests/unit/drive_bench.h"
#include "tests/unit/rows.h"
#include "tests/unit/vectors.h"

/* The paper's motor at a speed that no torque changes, with an inverter that loses the voltage of the
 * drive's model. It is solved exactly for a constant speed within each period. The command of step k acts
 * on [t_k+1, t_k+2). */
#define PERIOD 1e-4
#define R      (0.95 + 0.0215) /* [ohm] winding and devices */
#define L      0.0125
#define PSI    0.183
#define U_DC   311.0

static struct {
    double theta_e, omega_e; /* electrical, at t_k */
    double acceleration;     /* [rad/s^2] electrical */
    double flux, flux_end;   /* [Wb] present and final flux; it changes by 0.2 Wb/s */
    double loss;             /* [V] loss of a leg whose current has a certain sign */
    double noise;            /* [A] largest error of a current sample */
    double complex current;  /* [A] at t_k */
    double complex duty;     /* acts from t_k on if the gates are on */
    bool driven;
    bool encoder_stands; /* the count of the encoder is constant for any motion of the rotor */
    uint32_t random;
} machine;

void setUp(void)
{
    memset(&machine, 0, sizeof machine);
    machine.flux = PSI;
    machine.flux_end = PSI;
    bench_begin();
}

static double complex vector_of(double a, double b, double c)
{
    return (2.0 * a - b - c) / 3.0 + J * ((b - c) / sqrt(3.0));
}

/* As in the drive's model each leg loses its share against its current, linearly within 50 mA. */
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

/* Samples at t_k, runs the drive's step, and moves the machine to t_k+1. */
static void machine_step(void)
{
    samples.i_a = (float)(phase_of(machine.current, 0) + noise());
    samples.i_b = (float)(phase_of(machine.current, 1) + noise());
    const double turns = machine.theta_e / (2.0 * PI * 4.0);
    if (!machine.encoder_stands) {
        samples.encoder = (uint32_t)(10000.0 * (turns - floor(turns))) % 10000u;
    }
    steps(1);
    machine.driven = (samples.flags & DRIVE_SAMPLE_TRIPPED) == 0u;

    const double omega = machine.omega_e + 0.5 * machine.acceleration * PERIOD;
    if (machine.driven) {
        const double complex u = machine.duty * U_DC - lost_at(machine.current, machine.loss);
        const double rate = R / L;
        const double a = exp(-rate * PERIOD);
        const double complex emf = J * omega * machine.flux * cexp(J * machine.theta_e);
        const double complex turned = cexp(J * (omega * PERIOD));
        machine.current =
            a * machine.current + (1.0 - a) / R * u - emf / L * (turned - a) / (rate + J * omega);
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

/* Runs to the end of the present window, and this number of windows more. */
static void machine_windows(uint32_t count)
{
    do {
        machine_step();
        count -= drive.fast.sum.periods % DRIVE_WINDOW == 0u ? 1u : 0u;
    } while (count > 0u);
}

/* Makes the inverter lossless, in the machine and in the drive's parameters. */
static void make_inverter_ideal(void)
{
    params.turn_on_delay = 0.0f;
    params.turn_off_delay = params.dead_time;
    params.device_drop = 0.0f;
}

#define CATCH DRIVE_PERIODS(20e-3f) /* longest duration of a catch */
#define ACTS  (2u * DRIVE_WINDOW)   /* from the end of a window to the period in which its setpoint acts */
/* After a relock the EMF must agree with the angle four times for 2 ms, each of which is counted in whole
 * windows. Two windows more are the one in which the catch ends and the one after it. */
#define PROVED ((4u * 3u + 2u) * DRIVE_WINDOW + ACTS)

static void expect_manoeuvre(manoeuvre_t manoeuvre)
{
    TEST_ASSERT_EQUAL_INT32(manoeuvre, drive.medium.manoeuvres.now);
}

/* A machine at this speed with `params`, in mode current without a request; the drive is ready and not on. */
static void given_machine(double omega_e)
{
    drive_init(&drive, &params);
    machine.theta_e = 0.3;
    machine.omega_e = omega_e;
    request_currents(0.0f, 0.0f);
    machine_steps(2000);
    expect_state(DRIVE_READY);
}

static void given_running_machine(double omega_e, double i_q)
{
    given_machine(omega_e);
    request_currents(0.0f, (float)i_q);
    request(REQUEST_ON);
    machine_windows(SWITCHING_ON);
    expect_state(DRIVE_OPERATION_ENABLED);
}

/* The angle of the estimator minus that of the machine at the instant of the last sample. */
static double estimate_error(void)
{
    return circle((double)drive.fast.estimator.estimate.frame.theta_e -
                  (machine.theta_e - machine.omega_e * PERIOD));
}

/* The estimator receives the voltage of the duties of two steps ago, less the loss of the inverter. The
 * expected value comes from a second model of the inverter (test_inverter.c) with the steps and samples of
 * this drive. Currents and link voltage, and with them the duties, differ from step to step. The limit is
 * ten float roundings of 200 V, 1.2e-4 V. */
static void test_observer_gets_the_voltage_that_acted_in_the_last_period(void)
{
    params.offset_trim = 0.0f; /* so that the estimator receives the sample itself */
    drive_init(&drive, &params);
    inverter_t beside;
    const inverter_tuning_t *tuning = &drive.tunings[drive.in_force].fast.inverter;
    inverter_init(&beside);
    bring_to_ready();
    request_currents(0.0f, 5.0f);
    request(REQUEST_ON);
    for (int k = 0; k < 400; k++) {
        const double complex current = k < 10 ? 0.0 : 4.0 * cexp(J * (0.37 * k)); /* rarely near zero */
        samples.i_a = (float)phase_of(current, 0);
        samples.i_b = (float)phase_of(current, 1);
        samples.u_dc = (float)(U_DC + 10.0 * sin(0.9 * k));
        const bool before_start = drive.fast.estimating == 0u;
        const float omega_e = drive.fast.demand.frame.omega_e; /* the speed in the period that ends now */
        const float effective = drive.setpoints[drive.acting].models.dead_time;
        const float per_zone =
            drive.setpoints[drive.acting].models.per_zone; /* follows the link: test_leg_zone.c */
        turn(20, 1);
        const ab_t sampled = to_ab(current);
        const ab_t expected =
            inverter_acted(&beside, tuning, effective, per_zone, sampled, omega_e, samples.u_dc).voltage;
        inverter_remember(&beside, &command.duty, sampled, samples.u_dc);
        if (!before_start) {
            TEST_ASSERT_DOUBLE_WITHIN(2e-4, 0.0, cabs(of_ab(drive.fast.acted.voltage) - of_ab(expected)));
        }
    }
    expect_state(DRIVE_OPERATION_ENABLED);
    TEST_ASSERT_TRUE(drive.fast.estimating != 0u);
}

/* The current flows against its reference. The drive predicts the loss of the legs from the reference and
 * compensates it. The test requests a voltage within the link voltage first, then one far beyond it. The
 * limit is half a count of each leg, 4/3 x 20.7 mV. */
static void test_voltage_that_is_shown_is_made_by_the_duties_less_what_the_reference_loses(void)
{
    bring_to_run();
    for (int n = 0; n < 40; n++) {
        const double complex wanted = n < 20 ? -3.0 + J * 2.0 : -9.0 + J * 8.0;
        if (n % 20 == 0) {
            request_currents((float)creal(wanted), (float)cimag(wanted));
            windows(3);
        }
        samples.i_a = n % 2 == 0 ? -2.0f : 2.0f;
        samples.i_b = n % 2 == 0 ? 0.7f : 0.3f;
        turn(20, 1);
        const double angle =
            (double)drive.fast.demand.frame.theta_e + 1.5 * PERIOD * (double)drive.fast.demand.frame.omega_e;
        const double complex frame = cexp(J * angle);
        const double complex voltage = of_dq(drive.fast.control.voltage) * frame;
        const double complex made = duty_of(&command) * U_DC - lost_at(wanted * frame, 0.023 * U_DC + 0.875);
        TEST_ASSERT_DOUBLE_WITHIN(0.0277 + 0.01, 0.0, cabs(made - voltage));
        TEST_ASSERT_EQUAL(n < 20, drive.fast.current_control.voltage_ref.d == drive.fast.control.voltage.d);
    }
}

/* While the bridge was off the rotor has been turned and reversed: the estimator must not continue from
 * its last angle. The angle of the encoder is right within half a step, 1.3 mrad, and its speed within 1.5
 * rad/s; the error that this speed leaves after 10 ms is below the 5 mrad that a reset may leave. */
static void test_estimator_starts_again_at_every_switching_on(void)
{
    make_inverter_ideal();
    given_running_machine(418.9, 0.0);
    machine_steps(2000);
    request(REQUEST_OFF);
    machine_windows(2);
    machine_steps(1);
    machine.theta_e += 1.7;
    machine.omega_e = -300.0;
    const estimate_t last = drive.fast.estimator.estimate;
    machine_steps(500);
    /* The estimator does not run. */
    TEST_ASSERT_EQUAL_MEMORY(&last, &drive.fast.estimator.estimate, sizeof last);
    request(REQUEST_ON);
    machine_windows(SWITCHING_ON);
    expect_state(DRIVE_OPERATION_ENABLED);
    for (int n = 0; n < 1000; n++) {
        machine_step();
        TEST_ASSERT_DOUBLE_WITHIN(5e-3, 0.0, estimate_error());
    }
    TEST_ASSERT_EQUAL_UINT32(0u, drive.medium.estimate.invalid);
}

/* The angle of the control continues by omega T from period to period. The angle of the encoder is right
 * within half a step, 1.257 mrad, and the estimate within 0.3 mrad. In the current only noise is visible:
 * 4 A times 1.5 mrad. */
static void test_position_source_changes_live_without_a_bump(void)
{
    for (int way = -1; way <= 1; way += 2) {
        setUp();
        params.inductance_adaptation = 0.0f; /* so that i_d remains zero */
        make_inverter_ideal();
        given_running_machine(way * 418.9, way * 4.0);
        machine_steps(4000);
        for (int n = 0; n < 8; n++) {
            params.position_source = n % 2 == 0 ? POSITION_SENSORLESS : POSITION_ENCODER;
            offer_params();
            for (int m = 0; m < 50 + n; m++) {
                const double before = (double)drive.fast.demand.frame.theta_e;
                machine_step();
                const double moved = circle((double)drive.fast.demand.frame.theta_e - before);
                TEST_ASSERT_DOUBLE_WITHIN(2.0 * 1.26e-3 + 3e-4, way * 418.9e-4, moved);
                TEST_ASSERT_DOUBLE_WITHIN(0.05, way * 4.0, (double)drive.fast.control.current.q);
                TEST_ASSERT_DOUBLE_WITHIN(0.05, 0.0, (double)drive.fast.control.current.d);
                const frame_t *estimated = &drive.fast.estimator.estimate.frame;
                const position_t source = n % 2 == 0 ? (position_t){estimated->theta_e, estimated->omega_e}
                                                     : drive.fast.shaft.position;
                if ((uint32_t)m < ACTS + DRIVE_WINDOW) {
                    continue;
                }
                TEST_ASSERT_TRUE(source.theta_e == drive.fast.demand.frame.theta_e &&
                                 source.omega_e == drive.fast.demand.frame.omega_e);
            }
        }
        expect_state(DRIVE_OPERATION_ENABLED);
    }
}

/* During a catch the drive does not know whether the rotor turns: a quick stop must wait until the rotor
 * is caught, and then until it stands still. 100 rad/s come to standstill within 0.5 s. */
static void test_a_quick_stop_ends_only_when_the_rotor_is_known_to_stand(void)
{
    make_inverter_ideal();
    params.position_source = POSITION_SENSORLESS;
    given_machine(100.0);
    request(REQUEST_ON);
    machine_windows(SWITCHING_ON);
    request(REQUEST_QUICK_STOP);
    machine_windows(1);
    for (uint32_t n = 0; drive.medium.manoeuvres.now == (int32_t)MANOEUVRE_CATCH && n < CATCH;
         n += DRIVE_WINDOW) {
        machine_windows(1);
        expect_state(DRIVE_QUICK_STOP);
    }
    expect_manoeuvre(MANOEUVRE_RUN);
    machine.acceleration = -200.0;
    while (machine.omega_e > 0.0) {
        machine_step();
        /* The mechanical speed at which the stop ends is 2 rad/s; the rest is the lag of the estimate. */
        TEST_ASSERT_TRUE(drive.state == (int32_t)DRIVE_QUICK_STOP || machine.omega_e < 4.0 * 3.0);
    }
    machine.acceleration = 0.0;
    machine.omega_e = 0.0;
    machine_steps(3000);
    expect_state(DRIVE_READY);
    TEST_ASSERT_EQUAL_INT32(GATES_OFF, command.gates);
}

/* The drive runs sensorless and has settled: 1 s is eight time constants of the slowest loop in this file.
 * That loop is a conventional one; its integrator stops when it would change by less than half its last
 * digit, 1.6e-5 rad/s, that is below 1.6e-5/(65 1e-4) = 2.5 mrad. */
static void given_sensorless(double omega_e)
{
    make_inverter_ideal();
    params.position_source = POSITION_SENSORLESS;
    given_running_machine(omega_e, 0.0);
    machine_steps(10000);
    expect_state(DRIVE_OPERATION_ENABLED);
    TEST_ASSERT_DOUBLE_WITHIN(3e-3, 0.0, estimate_error());
}

/* The rotor jumps by half a turn in one period, with the torque of the current reversed. Returns the time
 * [s] until the guard reports it, 0.1 if it does not. */
static double told_after(double way)
{
    given_sensorless(way * 400.0);
    machine.theta_e += PI;
    machine.current = -machine.current;
    const uint32_t begin = drive.fast.period;
    while (!fault_set_any(drive.medium.guard.losses) && drive.fast.period - begin < 1000u) {
        machine_step();
    }
    return (drive.fast.period - begin) * PERIOD;
}

/* The speed of control is that of the loop without its proportional part, and with it while the shaft counts
 * as one that swings. */
static void test_the_speed_contains_the_proportional_part_while_the_shaft_swings(void)
{
    given_sensorless(400.0);
    for (uint32_t swings = 0u; swings < 2u; swings++) {
        drive.medium.manoeuvres.run.swings = swings;
        machine_windows(3);
        machine.theta_e += 0.1; /* the detector is not zero */
        machine_steps(3);
        const estimate_t *estimate = &drive.fast.estimator.estimate;
        const float expected = swings != 0u ? estimate->frame.omega_e : estimate->omega_smooth;
        TEST_ASSERT_TRUE(estimate->frame.omega_e != estimate->omega_smooth);
        TEST_ASSERT_EQUAL_FLOAT(expected * drive.medium.manoeuvres.limits.pole_pairs_inverse,
                                drive.fast.omega_m);
    }
}

/* In a forced frame the loop may have no EMF to follow, and its proportional part is noise. */
static void test_in_a_forced_frame_the_speed_never_contains_the_proportional_part(void)
{
    make_inverter_ideal();
    params.position_source = POSITION_SENSORLESS;
    given_machine(0.0);
    request_currents(0.0f, 2.0f);
    request(REQUEST_ON);
    for (uint32_t n = 0; !manoeuvres_forces(&drive.medium.manoeuvres) && n < 200u; n++) {
        machine_windows(1);
    }
    expect_manoeuvre(MANOEUVRE_ALIGN);
    drive.medium.manoeuvres.run.swings = 1u;
    machine_windows(1);
    TEST_ASSERT_EQUAL_UINT32(1u, drive.medium.setpoint.smooth);
}

/* Each of these rows turns its own criterion off; the lock has a criterion of its own. */
static void test_a_lost_lock_is_reported_whatever_criteria_are_off(void)
{
    for (int32_t judged = 0; judged <= 1; judged++) {
        setUp();
        set_rows(&params, "estimate_amplitude_min=0 estimate_amplitude_max=1 estimate_detector_max=0 "
                          "estimate_current_max=0 estimate_speed_min=0");
        params.lock_judged = judged;
        const double after = told_after(1.0);
        /* 1.4 ms of the low-pass, up to the end of a window (0.4 ms), and seven windows (5.6 ms) for the 5
         * ms. */
        TEST_ASSERT_DOUBLE_WITHIN(1e-3, judged != 0 ? 1.4e-3 + 0.4e-3 + 5.6e-3 : 0.1, after);
    }
}

/* The noise of the sensors exceeds the permitted error of the observer's current at the end of each window.
 * This is reported after estimate_time, 0.1 s, which are 126 windows in which the loop tracks. */
static void test_a_current_that_the_observer_misses_is_reported_after_its_time(void)
{
    given_sensorless(400.0);
    drive.medium.trust.validity.tuning.error_square_max = 1e-6f;
    machine.noise = 0.3;
    uint32_t windows = 0u;
    while (drive.medium.estimate.invalid == 0u && windows < 200u) {
        machine_windows(1);
        windows++;
    }
    TEST_ASSERT_EQUAL_UINT32(ESTIMATOR_CURRENT, drive.medium.estimate.invalid);
    TEST_ASSERT_UINT32_WITHIN(2u, 126u, windows);
}

/* The EMF opposes the estimated axis. The low-pass of 5 ms falls from 1 through one half within 5 ms
 * ln(2/1.5) = 1.4 ms, and the condition must last for 5 ms. The rotor is caught at its angle; one loss is
 * not a fault, and two losses are not either. */
static void test_a_rotor_half_a_turn_off_is_caught_again_at_once(void)
{
    for (int way = -1; way <= 1; way += 2) {
        setUp();
        const double after = told_after(way);
        TEST_ASSERT_TRUE(fault_set_has(drive.medium.guard.losses, FAULT_UNLOCKED));
        TEST_ASSERT_TRUE(after <= 12e-3);
        expect_manoeuvre(MANOEUVRE_RELOCK);
        machine_steps(CATCH + PROVED + 1u);
        expect_manoeuvre(MANOEUVRE_RUN);
        machine_steps(25000);
        expect_state(DRIVE_OPERATION_ENABLED);
        expect_manoeuvre(MANOEUVRE_RUN);
        TEST_ASSERT_EQUAL_UINT32(1u, drive.medium.manoeuvres.losses.count);
        TEST_ASSERT_DOUBLE_WITHIN(3e-3, 0.0, estimate_error());
        for (int n = 0; n < 3; n++) { /* the third loss within 2 s is a fault */
            TEST_ASSERT_EQUAL_INT32(DRIVE_OPERATION_ENABLED, drive.state);
            machine.theta_e += PI;
            machine.current = -machine.current;
            machine_steps(3000);
        }
        expect_fault(REASON_LOCK_LOST);
        TEST_ASSERT_EQUAL_INT32(GATES_OFF, command.gates);
        TEST_ASSERT_TRUE(command.duty.a == 0.5f && command.duty.b == 0.5f && command.duty.c == 0.5f);
    }
}

/* At 100 r/min and 5.76 A the EMF is 7.67 V, and a leg loses 8.03 V. A phase needs 0.2/(5.76 x 41.9) =
 * 0.83 ms to pass +-0.1 A, which are 8.3 periods, and this occurs six times in a turn of 150 ms. For 12
 * periods more the crossing is remembered. While the tracking loop coasts, the estimated speed is the
 * smooth one, and no error is counted. Except for a noise of 5 mA, the loop coasts while the mean of the
 * samples at t_k-1 and t_k has a phase within 0.1 A of zero. It continues to coast for 3 periods and two
 * time constants of the EMF filter, 10 periods, after that. */
static void test_voltage_in_doubt_near_a_current_zero_is_not_tracked(void)
{
    for (int way = -1; way <= 1; way += 2) {
        setUp();
        machine.loss = 0.023 * U_DC + 0.875;
        params.observer_emf_cutoff = 2000.0f;
        given_running_machine(way * 41.89, way * 5.76);
        machine.noise = 0.005;
        machine_steps(5000);
        double complex before = machine.current;
        uint32_t since = 100u;
        uint32_t coasted = 0u;
        for (int n = 0; n < 3000; n++) { /* two turns with twelve zero crossings */
            const double complex mean = 0.5 * (before + machine.current);
            const float smooth = drive.fast.estimator.estimate.omega_smooth;
            before = machine.current;
            machine_step();
            double smallest = 100.0;
            for (int phase = 0; phase < 3; phase++) {
                smallest = fmin(smallest, fabs(phase_of(mean, phase)));
            }
            since = smallest < 0.11 ? 0u : since + 1u;
            if (drive.fast.estimator.estimate.coasted != 0u) {
                coasted++;
                TEST_ASSERT_TRUE(since < 13u);
                const float now = drive.fast.estimator.estimate.frame.omega_e;
                TEST_ASSERT_TRUE(now == drive.fast.estimator.estimate.omega_smooth);
                /* The speed changes only by the torque of the feed-forward: at most that of the whole
                 * current. */
                TEST_ASSERT_FLOAT_WITHIN((float)(PERIOD * 1.5 * 16.0 * PSI * 6.0) / params.motor_inertia,
                                         smooth, now);
                TEST_ASSERT_EQUAL_FLOAT(0.0f, drive.fast.estimator.estimate.detector);
            } else {
                TEST_ASSERT_TRUE(smallest >= 0.09);
            }
        }
        expect_state(DRIVE_OPERATION_ENABLED);
        TEST_ASSERT_TRUE(coasted >= 12u * 16u && coasted <= 12u * 26u);
    }
}

/* All signals of a period combined into one number. */
static uint32_t signals_of_now(void)
{
    uint32_t sum = 0u;
    for (uint32_t n = 0; n < signals_table.count; n++) {
        sum = (sum ^ table_bits(&signals_table.rows[n], &drive)) * 16777619u;
    }
    return sum;
}

/* A set with the values of the active one is taken over in each window of a calibration, a catch, an
 * acceleration and a quick stop. No module may lose what it has measured, summed, learnt or integrated. With
 * the largest uncertainty of the data the loop has a lean at small currents. */
static void test_the_same_set_again_changes_nothing(void)
{
    static uint32_t seen[11000];
    for (int again = 0; again < 2; again++) {
        setUp();
        params.position_source = POSITION_SENSORLESS;
        params.motor_data_uncertainty = 1.0f;
        drive_init(&drive, &params);
        machine.omega_e = 200.0;
        request_speed(60.0f);
        for (uint32_t k = 0; k < sizeof seen / sizeof seen[0]; k++) {
            machine.acceleration = k > 4000u && k < 5000u ? 400.0 : k > 9000u ? -600.0 : 0.0;
            if (k == 1000u || k == 9000u) {
                request(k == 1000u ? REQUEST_ON : REQUEST_QUICK_STOP);
            }
            if (again != 0 && k % DRIVE_WINDOW == 3u) {
                offer_params();
            }
            machine_step();
            TEST_ASSERT_TRUE_MESSAGE(again == 0 || signals_of_now() == seen[k], "another signal");
            seen[k] = signals_of_now();
        }
    }
}
