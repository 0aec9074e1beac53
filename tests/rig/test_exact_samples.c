/* Ideal sensors (`sensors` = exact): the drive receives the true values at t_k, in every period and for
 * every order of switching. tests/board/test_gates.c tests the conversion of a current by the ADC and the
 * period in which each edge acts; test_oracle.c tests the currents that follow from the edges. */
#include "tests/rig/run.h"

#define SENSORS_EXACT 1.0

/* A motor that already turns at this speed under 5 N m; the drive is not enabled yet. */
static rig_t *turning(double rpm)
{
    rig_t *rig = run_rig(61);
    run_paper_drive(rig);
    run_puts(rig, "fidelity=1 load_torque=5");
    rig_set_motion(rig, 0.3, rpm * RPM);
    run_put(rig, "speed_request", rpm * RPM);
    return rig;
}

/* The phases that have a sensor. */
static const char *const sampled[] = {"i_a", "i_b", "i_c"};
static const char *const truths[] = {"true_i_a", "true_i_b", "true_i_c"};

/* All errors of the sensors are set, the link voltage changes, and every gate edge is simulated: none of
 * this has an effect on the samples. */
static void test_exact_samples_have_no_sensor_error(void)
{
    rig_t *rig = turning(700.0);
    run_put(rig, "sensors", SENSORS_EXACT);
    run_puts(rig, "fidelity=0 current_gain_error_a=0.02 current_gain_error_b=-0.03 "
                  "current_offset_a=0.3 current_offset_b=-0.2 current_gain_error_c=0.03 "
                  "current_offset_c=0.2 current_noise=0.1 plant.current_bandwidth=5000 "
                  "dc_gain_error=0.02 dc_noise=2 dc_resistance=1 dc_capacitance=1e-3");
    run_to_ready(rig);
    TEST_ASSERT_EQUAL_DOUBLE(0.0, rig_value(rig, "offset_a"));
    TEST_ASSERT_EQUAL_DOUBLE(0.0, rig_value(rig, "offset_b"));
    run_put(rig, "enable", 1.0);
    for (uint32_t n = 0; n < 3000u;
         n++) { /* compares bits and not numbers, because the drive has a copy of the true value */
        rig_step(rig);
        for (uint32_t k = 0; k < BOARD_CURRENT_SENSORS; k++) {
            TEST_ASSERT_EQUAL_DOUBLE(rig_value(rig, truths[k]), rig_value(rig, sampled[k]));
        }
        TEST_ASSERT_EQUAL_DOUBLE(rig_value(rig, "true_u_dc"), rig_value(rig, "u_dc"));
    }
    run_expect_no_fault(rig);
    TEST_ASSERT_TRUE(fabs(rig_value(rig, "true_u_dc") - 311.0) > 0.5); /* the link voltage did change */
    rig_free(rig);
}
