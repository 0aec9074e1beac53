/* Encoder mode: speed steps 100 -> 1500 -> 1000 r/min on the switched plant, both shafts, loads and
 * directions. */
#include <math.h>

#include "tests/rig/no_rig.h"
#include "tests/rig/run.h"

#define TRANSIENT_PERIODS 50u /* 5 ms after each step */

/* Runs one step and judges it: speed within 1 r/min at the end (0.2 s without leaving the band; the bare
 * motor within 1.3, for it ripples by 0.94 to 1.15 over seeds on the kit's board), i_d within 0.3 A of its
 * reference after 5 ms, no phase current above 1.2 times the limit. */
static void step_to(rig_t *rig, double rpm, double seconds, const char *what)
{
    double i_d_peak = 0.0;
    double i_peak = 0.0;
    double rpm_err = 0.0;
    const uint32_t periods = (uint32_t)(seconds / RIG_PERIOD_SECONDS + 0.5);
    run_put(rig, "speed_request", rpm * RPM);
    for (uint32_t n = 0; n < periods; n++) {
        rig_step(rig);
        i_peak = fmax(i_peak, fabs(rig_value(rig, "true_i_a")));
        i_peak = fmax(i_peak, fabs(rig_value(rig, "true_i_b")));
        i_peak = fmax(i_peak, fabs(rig_value(rig, "true_i_c")));
        if (n >= TRANSIENT_PERIODS) {
            i_d_peak = fmax(i_d_peak, fabs(rig_value(rig, "true_i_d") - rig_value(rig, "i_d_ref")));
        }
        if (n >= periods - 2000u) {
            rpm_err = fmax(rpm_err, fabs(rig_value(rig, "true_omega_m") / RPM - rpm));
        }
    }
    const char *const message =
        run_say("%s to %.0f r/min: speed off by %.3f r/min, |i_d| %.3f A, peak %.2f A", what, rpm, rpm_err,
                i_d_peak, i_peak);
    TEST_ASSERT_TRUE_MESSAGE(rpm_err <= (rig_value(rig, "inertia") < 0.01 ? 1.3 : 1.0), message);
    TEST_ASSERT_TRUE_MESSAGE(i_d_peak <= 0.3, message);
    TEST_ASSERT_TRUE_MESSAGE(i_peak <= 1.2 * rig_value(rig, "current_limit"), message);
    run_expect_no_fault(rig);
}

/* The rig and the bare motor, without load and under the rated one; inertia, friction and load as with 10 A.
 */
static void test_speed_steps_of_both_shafts_in_both_directions(void)
{
    static const struct {
        double inertia, friction, seconds;
    } shafts[] = {{0.0636, 1.32, 2.2}, {0.003, 0.0, 2.0}};
    grid_t grid = grid_of("speed steps", 8u);
    for (uint32_t n; grid_next(&grid, &n);) {
        const double direction = grid_axis(&n, 2u) == 0u ? 1.0 : -1.0;
        const double load = grid_axis(&n, 2u) == 0u ? 0.0 : 5.0;
        const double seconds = shafts[n].seconds;
        char what[80];
        rig_t *rig = run_rig(11);
        snprintf(what, sizeof what, "J %g, load %g N m,", shafts[n].inertia, load);
        run_put(rig, "inertia", shafts[n].inertia);
        run_put(rig, "friction_coulomb", shafts[n].friction);
        run_paper_drive(rig);
        run_shaft_of_board(rig);
        TEST_ASSERT_TRUE(rig_apply(rig));
        run_to_ready(rig);
        run_on(rig, 0.0);
        rig_step(rig);
        run_put(rig, "load_torque", RUN_LIMIT_SHARE * load);
        step_to(rig, direction * 100.0, seconds, what);
        step_to(rig, direction * 1500.0, 1.6 * seconds, what);
        step_to(rig, direction * 1000.0, seconds, what);
        rig_free(rig);
    }
}

/* Another encoder: its lines reach the counter, which starts at zero again, as the rotor stands. */
static void test_another_number_of_lines_reaches_the_counter(void)
{
    rig_t *rig = run_rig(13);
    run_paper_drive(rig);
    run_put(rig, "plant.encoder_lines", 1000.0);
    run_parameter(rig, "params.encoder_lines", 1000.0);
    run_to_ready(rig);
    run_on(rig, 300.0);
    double largest = 0.0;
    double error = 0.0;
    for (uint32_t n = 0; n < 20000u; n++) {
        rig_step(rig);
        largest = fmax(largest, rig_value(rig, "encoder_count"));
        error = fmax(error, fabs(rig_value(rig, "theta_err")));
    }
    run_expect_no_fault(rig);
    TEST_ASSERT_EQUAL_DOUBLE(3999.0, largest);
    /* half a count and what the shaft turns from t_k to the next: a step is 2 pi 4/4000 */
    TEST_ASSERT_TRUE(error < 1.1 * 3.14159265358979 * 4.0 / 4000.0);
    rig_free(rig);
}
