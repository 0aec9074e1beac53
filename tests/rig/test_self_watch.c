/* Errors of the parameters' memory and of the background under a running drive: what is noticed, how soon,
 * and what follows. Those of program and stack are in the fault matrix. */
#include "app/app.h"
#include "settings/reasons.h"
#include "tests/rig/run.h"
#include "tests/rig/the_rig.h"

/* [s] A slice of 16 words of one of four memories each 0.4 ms: two rounds of the host's 128 words, and of the
 * active parameters. */
#define NOTICED 0.05

void setUp(void)
{
    rig = run_rig(11);
    run_put(rig, "fidelity", 1.0);
    run_to_ready_at(rig, 600.0);
    run_on(rig, 600.0);
    run_seconds(rig, 0.5);
    run_expect_no_fault(rig);
}

/* [s] until the drive is in fault with this reason. */
static double seconds_to_fault(int32_t reason, double most)
{
    const uint32_t begin = rig_period(rig);
    while (rig_value(rig, "fault_reason") == 0.0 && (rig_period(rig) - begin) * RIG_PERIOD_SECONDS < most) {
        rig_step(rig);
    }
    TEST_ASSERT_EQUAL_DOUBLE((double)reason, rig_value(rig, "fault_reason"));
    const double taken = (rig_period(rig) - begin) * RIG_PERIOD_SECONDS;
    printf("reason %d after %.4f s\n", (int)reason, taken);
    return taken;
}

static void expect_lasting(int32_t reason)
{
    run_seconds(rig, 0.5);
    run_put(rig, "fault_reset", 0.0);
    rig_run(rig, DRIVE_WINDOW);
    run_put(rig, "fault_reset", 1.0);
    rig_run(rig, DRIVE_WINDOW);
    TEST_ASSERT_EQUAL_DOUBLE((double)DRIVE_FAULT, rig_value(rig, "state"));
    TEST_ASSERT_EQUAL_DOUBLE((double)reason, rig_value(rig, "fault_present"));
}

static void test_a_healthy_drive_finds_nothing_in_ten_seconds_and_a_thousand_changes(void)
{
    for (int n = 0; n < 1000; n++) {
        run_parameter(rig, "current_bandwidth", n % 2 == 0 ? 900.0 : 1000.0);
        run_seconds(rig, 0.01);
        run_expect_no_fault(rig);
    }
    TEST_ASSERT_DOUBLE_WITHIN(6.0, 600.0, rig_value(rig, "true_omega_m") / RPM);
}

/* The active set, by the place that it has among the application's variables. */
static void test_a_changed_parameter_opens_the_bridge_until_a_set_is_taken_over(void)
{
    const size_t word = (offsetof(app_t, active) + offsetof(params_t, current_limit)) / sizeof(uint32_t);
    run_put(rig, "flip_bit", 3.0);
    run_put(rig, "flip_word", (double)word);
    TEST_ASSERT_TRUE(seconds_to_fault(REASON_PARAMS_CORRUPT, 1.0) <= NOTICED);
    expect_lasting(REASON_PARAMS_CORRUPT);
    TEST_ASSERT_TRUE(rig_apply(rig));
    run_seconds(rig, 0.1);
    run_put(rig, "fault_reset", 0.0);
    rig_run(rig, DRIVE_WINDOW);
    run_put(rig, "fault_reset", 1.0);
    run_seconds(rig, 0.2);
    TEST_ASSERT_EQUAL_DOUBLE(0.0, rig_value(rig, "fault_reason"));
}

/* Braked in what the watchdog leaves of its time. */
static void test_a_background_that_stalls_brings_the_motor_to_a_stop(void)
{
    run_put(rig, "background_time", 0.6);
    const uint32_t begin = rig_period(rig);
    while (rig_value(rig, "state") == (double)DRIVE_OPERATION_ENABLED &&
           (rig_period(rig) - begin) * RIG_PERIOD_SECONDS < 0.2) {
        rig_step(rig);
    }
    const double taken = (rig_period(rig) - begin) * RIG_PERIOD_SECONDS;
    printf("stops after %.4f s\n", taken);
    TEST_ASSERT_EQUAL_DOUBLE((double)DRIVE_QUICK_STOP, rig_value(rig, "state"));
    TEST_ASSERT_DOUBLE_WITHIN(2e-3, 0.1, taken);
}
