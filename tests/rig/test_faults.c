/* Jumping encoder tracks, a quick stop without the encoder, a bridge that turns on at speed, and a
 * background task that stalls. The requirements of the fault matrix (host_sim/lab/matrix_table.h) are not
 * tested here. */
#include "host_sim/rig/rig_state.h"
#include "settings/reasons.h"
#include "tests/rig/run.h"
#include "tests/rig/the_rig.h"

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

/* The shaft jumps by four whole turns between two samples of the eQEP. That is more counts than its clock
 * has had cycles, so that both tracks have changed within one cycle. The angle is the same as before, and
 * the counter follows the tracks modulo 4. It loses the motion of the shaft between the two samples, up to
 * 10 counts per period, and only the phase error shows this. */
#define JUMP (4.0 * 2.0 * 3.14159265358979323846) /* [rad] mechanical */

/* One of the next two steps detects it: the flag is set for one period. */
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
    TEST_ASSERT_EQUAL_DOUBLE((double)REASON_ENCODER_PHASE, rig_value(rig, "fault_reason"));
    TEST_ASSERT_EQUAL_DOUBLE((double)DRIVE_FAULT, rig_value(rig, "state"));
    run_seconds(rig, 0.02);
    /* The gates are open, and the EMF of 46 V is far below the DC link: no current flows. */
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, 0.0, rig_value(rig, "true_i_a"));
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, 0.0, rig_value(rig, "true_i_b"));
    TEST_ASSERT_DOUBLE_WITHIN(0.5 * lost + 0.004, -0.5 * lost, encoder_error()); /* a count is 2.5 mrad */

    /* The fault has no lasting effect: after a reset the drive runs again. */
    run_puts(rig, "enable=0 fault_reset=1");
    run_seconds(rig, 0.1);
    run_put(rig, "enable", 1.0);
    run_seconds(rig, 0.5);
    run_expect_no_fault(rig);
}

/* The encoder is plugged in while the bridge is off: the drive reports this, and it is no fault. */
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

/* The last rad/s passes within 5 ms, during which the estimate is not without an EMF for long enough to be
 * reported as lost. */
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
    rig_run(rig, 3u * DRIVE_WINDOW); /* at the end of this window and one more the bridge is on */
    rig_set_motion(rig, 0.0, 1200.0 * RPM);
    run_seconds(rig, 0.1); /* the tracking loop of the encoder settles */
    run_puts(rig, "friction_coulomb=0 mode=1 enable=1");
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
        peak < 1.0, message); /* a zero vector of one period would give 92 V / 12.5 mH x 100 us = 0.74 A */
}

/* The limit is 0.1 s (background_time_max); the drive brakes within the rest of the watchdog's time. */
static void test_a_background_that_stalls_brings_the_motor_to_a_stop(void)
{
    run_put(rig, "background_time", 0.6);
    const uint32_t begin = rig_period(rig);
    while (rig_value(rig, "state") == (double)DRIVE_OPERATION_ENABLED &&
           (rig_period(rig) - begin) * RIG_PERIOD_SECONDS < 0.2) {
        rig_step(rig);
    }
    const double taken = (rig_period(rig) - begin) * RIG_PERIOD_SECONDS;
    TEST_ASSERT_EQUAL_DOUBLE((double)DRIVE_QUICK_STOP, rig_value(rig, "state"));
    TEST_ASSERT_DOUBLE_WITHIN(2e-3, 0.1, taken);
}

/* The exponent of an integral of the current control changes, so that the required voltage is 1e38 V. */
static void test_a_voltage_beyond_every_cause_opens_the_bridge(void)
{
    run_put(rig, "flip_bit", 30.0);
    run_put(rig, "flip_word",
            (double)(offsetof(app_t, drive.fast.current_control.d.integral) / sizeof(uint32_t)));
    rig_run(rig, 4u * DRIVE_WINDOW); /* the reason is shown after two windows */
    TEST_ASSERT_EQUAL_DOUBLE((double)REASON_PARAMS_CORRUPT, rig_value(rig, "fault_reason"));
    TEST_ASSERT_EQUAL_DOUBLE((double)DRIVE_FAULT, rig_value(rig, "state"));
    run_seconds(rig, 0.02);
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, 0.0, rig_value(rig, "true_i_a"));
}

/* The largest phase current [A] in 20 ms with 6 A at 600 r/min, after this row has got this value. */
static double largest_after(const char *row, double value)
{
    run_puts(rig, "mode=1 i_q_request=6");
    run_seconds(rig, 0.01);
    run_put(rig, row, value);
    double largest = 0.0;
    for (int n = 0; n < 200; n++) {
        rig_step(rig);
        largest = fmax(largest, fmax(fabs(rig_value(rig, "true_i_a")), fabs(rig_value(rig, "true_i_b"))));
    }
    return largest;
}

/* The code of zero current is 2048. The law of the winding shows that the other phases do not behave as with
 * an open wire. */
static void test_a_sensor_that_stays_near_zero_is_reported_as_stuck(void)
{
    TEST_ASSERT_TRUE(largest_after("stuck_current_a", 2050.0) < 19.0);
    TEST_ASSERT_EQUAL_DOUBLE((double)REASON_CURRENT_STUCK, rig_value(rig, "fault_reason"));
}

static void test_an_open_wire_is_no_stuck_sensor(void)
{
    TEST_ASSERT_TRUE(largest_after("open_phase_a", 1.0) < 19.0);
    TEST_ASSERT_EQUAL_DOUBLE((double)REASON_PHASE_LOSS, rig_value(rig, "fault_reason"));
}
