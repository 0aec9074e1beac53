/* Fifth and seventh harmonic in the rotor's EMF, of 3 and 2 %, on the real inverter: their shape is told from
 * the dead time, at 80 to 300 r/min, without load and with, for every sign. */
#include "tests/rig/run.h"

/* Required four seconds after the load is on: an SD of 6 mrad at most, the legs' loss within 5 %, and a mean
 * of 3 mrad where a drive keeps that whose EMF has no harmonics (tests/rig/test_adaptation.c: 4.8 mrad under
 * load and 2.6 without at 100 r/min, by an error of the voltage, which makes less of an angle at higher
 * speed). */
#define SD          6.0  /* [mrad] */
#define LOSS        0.05 /* [-] */
#define MEAN        3.0  /* [mrad] */
#define MEAN_LOADED 4.8  /* [mrad] at 100 r/min */

static double mean_most(double rpm, double load)
{
    return fmax(MEAN, load > 0.0 ? MEAN_LOADED * 100.0 / fabs(rpm) : 0.0);
}

static void test_harmonics_of_the_emf_are_told_from_the_dead_time(void)
{
    static const double speeds[] = {80.0, 100.0, 150.0, 200.0, 300.0};
    static const double loads[] = {0.0, 2.5, 5.0};
    grid_t grid = grid_of("harmonics of the EMF", 2u * 2u * 2u * 3u * 5u);
    for (uint32_t n; grid_next(&grid, &n);) {
        const double way = grid_axis(&n, 2u) == 0u ? 1.0 : -1.0;
        const double fifth = grid_axis(&n, 2u) == 0u ? 0.03 : -0.03;
        const double seventh = grid_axis(&n, 2u) == 0u ? 0.02 : -0.02;
        const double load = loads[grid_axis(&n, 3u)];
        const double rpm = way * speeds[n];
        rig_t *rig = run_rig(1u);
        run_put(rig, "emf_5th", fifth);
        run_put(rig, "emf_7th", seventh);
        run_to_ready_at(rig, rpm);
        run_real(rig);
        run_on(rig, rpm);
        run_seconds(rig, 0.5);
        run_load(rig, RUN_LIMIT_SHARE * load, 1.5);
        run_seconds(rig, 4.0);
        const run_error_t err = run_error(rig, 3.0);
        const char *const message =
            run_say("%.0f r/min, %.1f N m, 5th %.0f %%, 7th %.0f %%: mean %.2f, SD %.2f mrad; "
                    "dead time %.3f, shape %.4f, %.4f",
                    rpm, load, 1e2 * fifth, 1e2 * seventh, err.mean, err.sd, run_learnt_loss(rig),
                    rig_value(rig, "emf_shape_d_hat"), rig_value(rig, "emf_shape_q_hat"));
        run_expect_no_fault(rig);
        TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(mean_most(rpm, load), 0.0, err.mean, message);
        TEST_ASSERT_TRUE_MESSAGE(err.sd <= SD, message);
        TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(LOSS, 1.0, run_learnt_loss(rig), message);
        rig_free(rig);
    }
}
