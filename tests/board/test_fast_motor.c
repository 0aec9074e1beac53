/* The fastest motor that a carrier allows, with an electrical angle of 0.3 rad per sample (950 Hz at 20
 * kHz), runs without the encoder on an inverter and sensors with their real errors.
 * tests/rig/test_sensorless_ideal.c has the ideal ones. */
#include <math.h>

#include "tests/rig/run.h"

#define TOP    (0.3 / RIG_PERIOD_SECONDS) /* [rad/s] electrical */
#define LOADED 3.0                        /* [A] of i_q */

/* The EMF is 0.6 of the voltage that the link allows at the top speed. */
static run_motor_t fast_motor(void)
{
    const double emf = 0.6 * BOARD_DC_NOMINAL_MV / 1e3 / sqrt(3.0);
    return (run_motor_t){.pole_pairs = 4.0,
                         .resistance = 0.3,
                         .inductance = 2.0e-3,
                         .flux_linkage = emf / TOP,
                         .inertia = 1e-3,
                         .friction = 0.2,
                         .speed = TOP / 4.0,
                         .bandwidth = 15.0};
}

static run_error_t error_at(double share, double amperes)
{
    const run_motor_t motor = fast_motor();
    const double cutoff = fmax(50.0, 1.6 * sqrt(1.5 * motor.pole_pairs * motor.pole_pairs *
                                                motor.flux_linkage * 10.0 / motor.inertia));
    rig_t *rig = run_rig(7);
    run_paper_drive(rig);
    run_put_motor(rig, &motor);
    run_put(rig, "handover_speed", 0.1 * motor.speed);
    run_put(rig, "fallback_speed", 0.04 * motor.speed);
    run_put(rig, "overspeed_trip", 1.2 * motor.speed);
    run_put(rig, "feedforward_cutoff", cutoff);
    run_parameter(rig, "pll_bandwidth", 4.0 * cutoff);
    run_real(rig);
    run_put(rig, "friction_coulomb", 0.0);
    rig_set_motion(rig, 0.0, share * motor.speed);
    rig_run(rig, 64u + 512u + 24u);
    run_put(rig, "friction_coulomb", motor.friction);
    run_on(rig, share * motor.speed / RPM);
    run_seconds(rig, 0.1);
    run_parameter(rig, "position_source", 1.0);
    run_seconds(rig, 0.3);
    run_load(rig, 1.5 * motor.pole_pairs * motor.flux_linkage * amperes, 1.0);
    run_seconds(rig, 1.0);
    const run_error_t err = run_error(rig, 0.5);
    const char *const where =
        run_say("%+.2f of %.0f r/min, %.0f A: mean %.2f, SD %.2f, peak %.2f mrad, fault %d", share,
                motor.speed / RPM, amperes, err.mean, err.sd, err.peak, (int)rig_value(rig, "fault_reason"));
    run_expect_no_fault(rig);
    TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(0.01 * motor.speed / RPM, share * motor.speed / RPM, err.speed_mean,
                                      where);
    rig_free(rig);
    return err;
}

#define POINTS 16u

/* The last speed is close to a whole number of samples per turn, 21, so that an error repeats in each
 * turn. */
static double share_of(uint32_t point)
{
    static const double shares[] = {0.25, 0.5, 0.75, 1.02};
    return (point % 2u != 0u ? -1.0 : 1.0) * shares[point / 4u];
}

/* Without load the current is 1.6 A, not much more than its ripple. The error that remains grows with the
 * speed, by 1.4 us of angle at the top. Over seven seeds the largest mean is 8.4 mrad without load and 4.6
 * mrad with it, the largest SD 2.0 mrad and the largest peak 13.1 mrad; the limits are 1.25 times these
 * values. */
static void test_real_inverter_and_sensors_leave_a_hundredth_of_a_radian(void)
{
    grid_t grid = grid_of("real, fast", POINTS);
    for (uint32_t n; grid_next(&grid, &n);) {
        const bool loaded = n / 2u % 2u != 0u;
        const run_error_t err = error_at(share_of(n), loaded ? LOADED : 0.0);
        TEST_ASSERT_DOUBLE_WITHIN(loaded ? 5.8 : 10.6, 0.0, err.mean);
        TEST_ASSERT_TRUE(err.sd <= 2.6);
        TEST_ASSERT_TRUE(err.peak <= 16.5);
    }
}
