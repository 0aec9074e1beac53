/* Faults injected below the seam run the real code: the drive stops with the right reason and the motor gets
 * no voltage. What the fault matrix asks of every manoeuvre (host_sim/lab/matrix_table.h) is not asked here.
 */
#include <math.h>

#include "drive/reasons.h"
#include "host_sim/rig/rig_state.h"
#include "tests/rig/run.h"

static rig_t *rig;

void setUp(void)
{
    rig = run_rig(31);
    run_paper_drive(rig);
    run_to_ready(rig);
    run_on(rig, 600.0);
    run_put(rig, "inertia", 0.003);
    run_seconds(rig, 0.5);
    run_expect_no_fault(rig);
}

void tearDown(void)
{
    rig_free(rig);
}

static void expect_stopped(int32_t reason)
{
    TEST_ASSERT_EQUAL_DOUBLE((double)reason, rig_value(rig, "fault_reason"));
    TEST_ASSERT_EQUAL_DOUBLE(5.0, rig_value(rig, "state"));
    run_seconds(rig, 0.02);
    /* gates open, EMF of 46 V far below the DC link: no current */
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, 0.0, rig_value(rig, "true_i_a"));
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, 0.0, rig_value(rig, "true_i_b"));
    TEST_ASSERT_EQUAL_DOUBLE((double)reason, rig_value(rig, "fault_reason"));
}

/* A fault that leaves time for it: a quick stop has begun, which ends at standstill with the bridge open. */
static void expect_braked(int32_t reason)
{
    TEST_ASSERT_EQUAL_DOUBLE((double)DRIVE_QUICK_STOP, rig_value(rig, "state"));
    TEST_ASSERT_EQUAL_DOUBLE(0.0, rig_value(rig, "fault_reason"));
    run_seconds(rig, rig_value(rig, "fault_stop_time"));
    TEST_ASSERT_DOUBLE_WITHIN(1.0 * RPM, 0.0, rig_value(rig, "true_omega_m"));
    expect_stopped(reason);
}

/* The cause is gone and `enable` off: a reset, and the drive runs again. */
static void expect_reset_and_running_again(void)
{
    run_put(rig, "fault_reset", 1.0);
    run_seconds(rig, 0.1);
    TEST_ASSERT_EQUAL_DOUBLE(1.0, rig_value(rig, "state"));
    run_put(rig, "enable", 1.0);
    run_seconds(rig, 0.5);
    run_expect_no_fault(rig);
}

static void test_module_fault_stops_in_the_same_period_and_can_be_reset(void)
{
    const double period = rig_value(rig, "period");
    run_put(rig, "force_fault", 1.0);
    rig_step(rig);
    TEST_ASSERT_DOUBLE_WITHIN(1.0, period, rig_value(rig, "fault_period"));
    expect_stopped(REASON_MODULE_FAULT);

    run_put(rig, "enable", 0.0);
    run_put(rig, "fault_reset", 1.0); /* the line is still low */
    run_seconds(rig, 0.05);
    TEST_ASSERT_EQUAL_DOUBLE(5.0, rig_value(rig, "state"));
    run_put(rig, "fault_reset", 0.0);
    run_put(rig, "force_fault", 0.0);
    run_seconds(rig, 0.03);
    expect_reset_and_running_again();
}

/* A temperature of the plant rises above the limit; it comes back, and the limit goes down to 0 degC, the
 * lowest that is accepted. A drive without that sensor shows that it has none, and nothing stops it. */
static void expect_stopped_by_heat(const char *name, bool sensor, double hot, reason_t reason)
{
    char plant[40];
    char limit[40];
    snprintf(plant, sizeof plant, "plant.%s", name);
    snprintf(limit, sizeof limit, "%s_max", name);
    char signal[40];
    snprintf(signal, sizeof signal, "signals.%s", name);
    TEST_ASSERT_DOUBLE_WITHIN(0.05, sensor ? 40.0 : (double)DRIVE_NO_TEMPERATURE, rig_value(rig, signal));
    run_put(rig, plant, hot);
    run_seconds(rig, 0.09);
    TEST_ASSERT_EQUAL_DOUBLE(0.0, rig_value(rig, "fault_reason"));
    TEST_ASSERT_DOUBLE_WITHIN(0.05, sensor ? hot : (double)DRIVE_NO_TEMPERATURE, rig_value(rig, signal));
    run_seconds(rig, 0.02);
    if (sensor) {
        expect_braked(reason);
        return;
    }
    run_parameter(rig, limit, 0.0);
    run_seconds(rig, 0.3);
    run_expect_no_fault(rig);
    run_put(rig, plant, 150.0);
    run_seconds(rig, 0.3);
    run_put(rig, plant, -50.0);
    run_seconds(rig, 0.3);
    run_expect_no_fault(rig);
    TEST_ASSERT_EQUAL_DOUBLE((double)DRIVE_NO_TEMPERATURE, rig_value(rig, signal));
}

static void test_hot_heat_sink(void)
{
    expect_stopped_by_heat("sink_temperature", DRIVE_SINK_SENSOR, 95.0, REASON_SINK_HOT);
}

static void test_hot_motor(void)
{
    expect_stopped_by_heat("motor_temperature", DRIVE_MOTOR_SENSOR, 135.0, REASON_MOTOR_HOT);
}

/* Degrees from the point where the warning begins, 10 K below the limit: whatever the limit is. */
static void put_sink_beside_warning(double kelvin)
{
    run_put(rig, "plant.sink_temperature", rig_value(rig, "sink_temperature_max") - 10.0 + kelvin);
}

static bool warns_of_heat(void)
{
    return ((uint32_t)rig_value(rig, "warnings") >> FAULT_SINK_WARM & 1u) != 0u;
}

/* A code of the converter is worth less than 0.05 K. A drive without the sensor has nothing to warn of; one
 * with it has less current, at the next step of its heat at the latest. */
static void expect_warning_of_heat(bool sensor)
{
    put_sink_beside_warning(-0.2);
    run_seconds(rig, 0.3);
    TEST_ASSERT_FALSE(warns_of_heat());

    put_sink_beside_warning(0.2);
    rig_run(rig, rig_periods(0.1) - 2u);
    TEST_ASSERT_FALSE(warns_of_heat());
    rig_run(rig, 4u + 2u * GUARD_LOOK_PERIODS);
    TEST_ASSERT_EQUAL(sensor, warns_of_heat());
    put_sink_beside_warning(9.8);
    run_seconds(rig, 0.3);
    TEST_ASSERT_EQUAL(sensor, warns_of_heat());
    run_expect_no_fault(rig);
    TEST_ASSERT_EQUAL_DOUBLE(0.0, rig_value(rig, "refusal"));
    TEST_ASSERT_DOUBLE_WITHIN(1.0, 600.0, rig_value(rig, "true_omega_m") / RPM);

    put_sink_beside_warning(-0.2);
    rig_run(rig, 2u + GUARD_LOOK_PERIODS);
    TEST_ASSERT_FALSE(warns_of_heat());
    run_expect_no_fault(rig);
}

static void test_warm_heat_sink_warns_and_the_drive_runs_on(void)
{
    expect_warning_of_heat(DRIVE_SINK_SENSOR);
}

/* Once hot the warning goes on beside the fault; it is no fault itself, not even a later one. */
static void expect_warmth_then_fault(bool sensor)
{
    put_sink_beside_warning(0.2);
    run_seconds(rig, 0.2);
    run_expect_no_fault(rig);
    put_sink_beside_warning(10.2);
    run_seconds(rig, 0.11);
    if (!sensor) {
        run_expect_no_fault(rig);
        return;
    }
    TEST_ASSERT_TRUE(warns_of_heat());
    expect_braked(REASON_SINK_HOT);
    TEST_ASSERT_BITS(1u << FAULT_SINK_WARM, 0u, (uint32_t)rig_value(rig, "faults_later"));
}

static void test_warm_heat_sink_that_gets_hot_stops_the_drive(void)
{
    expect_warmth_then_fault(DRIVE_SINK_SENSOR);
}

/* ---- the history before a fault ---- */

#define KEPT   (CAPTURE_SLOTS / CAPTURE_COLUMNS)
#define TAPPED (CAPTURE_COLUMNS + 1u)

static uint32_t tapped[KEPT][TAPPED]; /* `period` and the rows of the history, in place of `period` */
static uint32_t taps;

static void keep_tap(void *context, uint32_t period, const uint32_t *slots, uint32_t count)
{
    (void)context;
    (void)period;
    memcpy(tapped[slots[0] % KEPT], slots, count * sizeof *slots);
    taps++;
}

static void tap_rows_of_history(void)
{
    uint32_t ids[TAPPED] = {rig_row_by_name("period")->id};
    memcpy(&ids[1], rig_history_rows(rig), CAPTURE_COLUMNS * sizeof ids[0]);
    taps = 0;
    TEST_ASSERT_TRUE(rig_tap(rig, ids, TAPPED, 1u, keep_tap, NULL));
}

/* Bit for bit what the tap saw, back from this period. */
static void expect_history_as_tapped(uint32_t newest, uint32_t count)
{
    TEST_ASSERT_EQUAL_UINT32(count, rig_history_count(rig));
    for (uint32_t ago = 0; ago < count; ago++) {
        uint32_t period = 0;
        const uint32_t *slots = rig_history(rig, ago, &period);
        const uint32_t *seen = tapped[(newest - ago) % KEPT];
        TEST_ASSERT_EQUAL_UINT32(newest - ago, period);
        TEST_ASSERT_EQUAL_UINT32(newest - ago, seen[0]);
        TEST_ASSERT_EQUAL_HEX32_ARRAY(&seen[1], slots, CAPTURE_COLUMNS);
    }
}

static void test_history_goes_with_the_run_and_ends_with_the_period_of_the_fault(void)
{
    tap_rows_of_history();
    run_seconds(rig, 0.05);
    TEST_ASSERT_FALSE(rig_history_held(rig));
    expect_history_as_tapped((uint32_t)rig_value(rig, "period"), KEPT);

    run_put(rig, "dc_voltage", rig_value(rig, "dc_overvoltage") + 5.0);
    while (rig_value(rig, "state") != 5.0) {
        rig_step(rig);
    }
    const uint32_t fault = (uint32_t)rig_value(rig, "fault_period");
    TEST_ASSERT_EQUAL_UINT32(fault, (uint32_t)rig_value(rig, "period")); /* the step itself found it */
    TEST_ASSERT_TRUE(rig_history_held(rig));
    expect_history_as_tapped(fault, KEPT);
    TEST_ASSERT_TRUE(rig_tap(rig, rig_history_rows(rig), 1u, 1u, NULL, NULL));
    run_seconds(rig, 0.05);
    expect_history_as_tapped(fault, KEPT); /* held */
}

static void test_history_before_a_trip_ends_with_the_step_before_it_and_a_reset_begins_anew(void)
{
    tap_rows_of_history();
    run_seconds(rig, 0.05);
    const uint32_t period = (uint32_t)rig_value(rig, "period");
    TEST_ASSERT_TRUE(rig_tap(rig, rig_history_rows(rig), 1u, 1u, NULL, NULL));
    run_put(rig, "force_fault", 1.0);
    run_seconds(rig, 0.01);
    TEST_ASSERT_EQUAL_UINT32(period, (uint32_t)rig_value(rig, "fault_period"));
    expect_history_as_tapped(period, KEPT);

    run_put(rig, "force_fault", 0.0);
    run_put(rig, "enable", 0.0);
    run_seconds(rig, 0.03);
    TEST_ASSERT_TRUE(rig_history_held(rig));
    run_put(rig, "fault_reset", 1.0);
    tap_rows_of_history();
    rig_run(rig, 30u);
    TEST_ASSERT_FALSE(rig_history_held(rig));
    TEST_ASSERT_EQUAL_UINT32(30u, taps);
    expect_history_as_tapped((uint32_t)rig_value(rig, "period"), 30u);
}

/* ---- encoder and position ---- */

/* Four whole turns between two looks of the eQEP: more counts than its clock has cycles since then, so that
 * both tracks changed within one. The angle is where it was, and the counter follows the tracks modulo 4: it
 * loses what the shaft did between the two looks, up to the 10 counts of a period, and nothing but the phase
 * error tells of it. */
#define JUMP (4.0 * 2.0 * 3.14159265358979323846) /* [rad] mechanical */

/* The step that saw it, within the next two: the flag is there for one period. */
static void expect_phase_error_seen_once(void)
{
    uint32_t seen = 0;
    for (uint32_t n = 0; n < 4u; n++) {
        rig_step(rig);
        const uint32_t flags = (uint32_t)rig_value(rig, "sample_flags");
        seen += (flags & DRIVE_SAMPLE_ENCODER) != 0u;
        TEST_ASSERT_TRUE(n < 2u || (flags & DRIVE_SAMPLE_ENCODER) == 0u);
    }
    TEST_ASSERT_EQUAL_UINT32(1, seen);
}

static double encoder_error(void)
{
    return remainder(rig_value(rig, "encoder_theta_e") - rig_value(rig, "true_theta_e"),
                     2.0 * 3.14159265358979323846);
}

static void test_encoder_tracks_that_change_both_at_once_stop_the_drive(void)
{
    TEST_ASSERT_EQUAL_DOUBLE(0.0, rig_value(rig, "sample_flags"));
    const double period = rig_value(rig, "period");
    const double lost = rig_value(rig, "true_omega_e") * RIG_PERIOD_SECONDS;
    run_put(rig, "plant.encoder_offset", JUMP);
    expect_phase_error_seen_once();
    TEST_ASSERT_DOUBLE_WITHIN(1.0, period + 1.0, rig_value(rig, "fault_period"));
    expect_stopped(REASON_ENCODER_PHASE);
    TEST_ASSERT_DOUBLE_WITHIN(0.5 * lost + 0.004, -0.5 * lost, encoder_error()); /* a count is 2.5 mrad */

    /* Nothing of it is left: a reset, and the drive runs again. */
    run_put(rig, "enable", 0.0);
    expect_reset_and_running_again();
}

/* Somebody plugs the encoder in: told, and no fault while the bridge is off. */
static void test_encoder_tracks_may_jump_while_the_bridge_is_off(void)
{
    run_put(rig, "enable", 0.0);
    run_seconds(rig, 0.01);
    TEST_ASSERT_EQUAL_DOUBLE(1.0, rig_value(rig, "state"));
    run_put(rig, "plant.encoder_offset", JUMP);
    expect_phase_error_seen_once();
    TEST_ASSERT_EQUAL_DOUBLE(1.0, rig_value(rig, "state"));
    TEST_ASSERT_EQUAL_DOUBLE(0.0, rig_value(rig, "fault_reason"));
    run_put(rig, "enable", 1.0);
    run_seconds(rig, 0.1);
    run_expect_no_fault(rig);
}

/* The shaft seizes: the EMF is gone at once, and within 20 ms the rotor counts as lost. It is not found,
 * three starts find it held, and the drive stops: each is a catch or a pause, an alignment of 16 over the
 * pendulum's frequency w_n = sqrt(p K_t I/J), and a ramp. The EMF of 46 V that is gone surges through L
 * before the current control sees it: 46 V/(e L 1000 rad/s) = 1.4 A on top of the limit, for which there must
 * be room below the trip. */
static void test_seized_shaft_is_started_three_times_and_then_stops_the_drive(void)
{
    const double limit = rig_value(rig, "overcurrent_trip") / 1.5;
    const double natural = sqrt(4.0 * 1.5 * 4.0 * 0.183 * limit / rig_value(rig, "motor_inertia"));
    const double aligning = 3.0 * 16.0 / natural;
    run_put(rig, "current_limit", limit);
    run_parameter(rig, "position_source", 1.0);
    run_seconds(rig, 0.5);
    run_expect_no_fault(rig);
    TEST_ASSERT_DOUBLE_WITHIN(5e-3, 0.0, rig_value(rig, "theta_hat_err"));
    const double period = rig_value(rig, "period");
    run_put(rig, "shaft_locked", 1.0);
    run_seconds(rig, 0.02);
    TEST_ASSERT_EQUAL_DOUBLE(1.0, rig_value(rig, "lock_losses"));
    TEST_ASSERT_EQUAL_DOUBLE((double)MANOEUVRE_RELOCK, rig_value(rig, "manoeuvre"));
    run_seconds(rig, 3.0 * aligning);
    TEST_ASSERT_EQUAL_DOUBLE(3.0, rig_value(rig, "start_try"));
    const double seconds = (rig_value(rig, "fault_period") - period) * RIG_PERIOD_SECONDS;
    printf("told after %.3f s, of which %.3f s of alignment\n", seconds, aligning);
    TEST_ASSERT_TRUE(seconds > aligning + 0.6 && seconds < 2.5 * aligning + 0.6);
    expect_stopped(REASON_START_STALLED);
}

static void test_late_interrupt_is_noticed(void)
{
    run_put(rig, "interrupt_delay", 99.5e-6); /* past the zero of the next period */
    run_seconds(rig, 0.002);
    TEST_ASSERT_EQUAL_DOUBLE((double)REASON_LATE, rig_value(rig, "fault_reason"));
}

static void test_interrupt_that_is_delayed_but_in_time_does_no_harm(void)
{
    run_put(rig, "interrupt_delay", 45e-6);
    run_seconds(rig, 0.3);
    run_expect_no_fault(rig);
    TEST_ASSERT_DOUBLE_WITHIN(1.0, 600.0, rig_value(rig, "true_omega_m") / RPM);
}

static void test_offsets_of_the_sensors_are_measured_at_the_start(void)
{
    rig_free(rig);
    rig = run_rig(32);
    run_put(rig, "current_offset_a", 0.2);
    run_put(rig, "current_offset_b", -0.15);
    run_put(rig, "current_offset_c", 0.1);
    run_to_ready(rig);
    /* 10 mA noise on codes of 9.8 mA at most over 512 samples: 0.6 mA rms; a code stands for its middle */
    TEST_ASSERT_DOUBLE_WITHIN(3e-3, 0.2, rig_value(rig, "offset_a"));
    TEST_ASSERT_DOUBLE_WITHIN(3e-3, -0.15, rig_value(rig, "offset_b"));
    /* without a sensor c is minus the sum of the others, and so is its offset */
    TEST_ASSERT_DOUBLE_WITHIN(5e-3, DRIVE_CURRENT_SENSORS == 3 ? 0.1 : -0.05,
                              (double)rig_state(rig)->app.drive.measure.offset.c);
}

static void test_quick_stop_brings_the_motor_to_standstill(void)
{
    run_put(rig, "enable", 2.0);
    run_seconds(rig, 0.5);
    TEST_ASSERT_EQUAL_DOUBLE(1.0, rig_value(rig, "state"));
    TEST_ASSERT_DOUBLE_WITHIN(2.1, 0.0, rig_value(rig, "true_omega_m"));
}

/* The last rad/s pass in 5 ms; the estimate is not blind for long enough to count as lost. */
static void test_quick_stop_without_the_encoder_ends_ready_too(void)
{
    run_parameter(rig, "position_source", 1.0);
    run_seconds(rig, 0.5);
    run_put(rig, "enable", 2.0);
    run_seconds(rig, 0.5);
    TEST_ASSERT_EQUAL_DOUBLE(0.0, rig_value(rig, "fault_reason"));
    TEST_ASSERT_EQUAL_DOUBLE(1.0, rig_value(rig, "state"));
    TEST_ASSERT_DOUBLE_WITHIN(2.1, 0.0, rig_value(rig, "true_omega_m"));
}

static void test_switching_on_at_speed_makes_no_current_surge(void)
{
    run_put(rig, "enable", 0.0);
    run_seconds(rig, 0.001);
    rig_set_motion(rig, 0.0, 1200.0 * RPM);
    run_seconds(rig, 0.1); /* the tracking of the encoder settles */
    run_put(rig, "friction_coulomb", 0.0);
    run_put(rig, "mode", 1.0);
    run_put(rig, "enable", 1.0);
    double peak = 0.0;
    for (int n = 0; n < 200; n++) {
        rig_step(rig);
        peak = fmax(peak, fabs(rig_value(rig, "true_i_a")));
        peak = fmax(peak, fabs(rig_value(rig, "true_i_b")));
    }
    run_expect_no_fault(rig);
    char message[80];
    snprintf(message, sizeof message, "largest phase current %.2f A", peak);
    TEST_ASSERT_TRUE_MESSAGE(
        peak < 1.0, message); /* a zero vector for one period would give 92 V / 12.5 mH x 100 us = 0.74 A */
}
