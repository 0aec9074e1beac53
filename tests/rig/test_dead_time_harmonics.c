/* The compensation of the dead time reduces the 5th and the 7th harmonic of the phase current. The drive
 * has a dead time of 3 us, a speed of 100 r/min and a load of 5 N m. */
#include "tests/rig/run.h"

typedef struct {
    double first, fifth, seventh; /* [A] amplitudes */
} harmonics_t;

/* Computes Fourier sums over the rotor angle instead of the time, so that the ripple of the speed does not
 * smear the lines; the window is ten electrical turns. */
static harmonics_t measure(double compensation)
{
    const int order[3] = {1, 5, 7};
    double re[3] = {0.0};
    double im[3] = {0.0};
    double turned = 0.0;
    rig_t *rig = run_rig(21);
    run_paper_drive(rig);
    run_put(rig, "dead_time", 3e-6);
    run_parameter(rig, "compensation_gain", compensation);
    run_to_ready(rig);
    run_on(rig, 100.0);
    run_put(rig, "load_torque", 5.0);
    run_seconds(rig, 3.0);
    run_expect_no_fault(rig);
    TEST_ASSERT_DOUBLE_WITHIN(2.0, 100.0, rig_value(rig, "true_omega_m") / RPM);

    while (turned < 10.0 * 2.0 * 3.14159265358979) {
        rig_step(rig);
        const double step = rig_value(rig, "true_omega_e") * RIG_PERIOD_SECONDS;
        const double theta = rig_value(rig, "true_theta_e");
        const double i_a = rig_value(rig, "true_i_a");
        for (int n = 0; n < 3; n++) {
            re[n] += i_a * cos(order[n] * theta) * step;
            im[n] += i_a * sin(order[n] * theta) * step;
        }
        turned += step;
    }
    rig_free(rig);
    double amplitude[3];
    for (int n = 0; n < 3; n++) {
        amplitude[n] = 2.0 * sqrt(re[n] * re[n] + im[n] * im[n]) / turned;
    }
    return (harmonics_t){amplitude[0], amplitude[1], amplitude[2]};
}

static void test_compensation_takes_at_least_four_fifths_of_5th_and_7th_away(void)
{
    grid_t grid = grid_of("harmonics", SEED_PHASES);
    for (uint32_t n; grid_next(&grid, &n);) {
        const harmonics_t without = measure(0.0);
        const harmonics_t with = measure(1.0);
        const char *const message = run_say(
            "fundamental %.3f A; 5th %.1f mA without, %.1f mA with; 7th %.1f mA without, %.1f mA with",
            with.first, 1e3 * without.fifth, 1e3 * with.fifth, 1e3 * without.seventh, 1e3 * with.seventh);
        TEST_ASSERT_TRUE_MESSAGE(without.fifth > 5.0 * with.fifth, message);
        TEST_ASSERT_TRUE_MESSAGE(without.seventh > 5.0 * with.seventh, message);
        /* The fundamental carries load and friction with and without compensation. */
        TEST_ASSERT_DOUBLE_WITHIN(0.05, 6.32 / (1.5 * 4.0 * 0.183), with.first);
        TEST_ASSERT_DOUBLE_WITHIN(0.05, 6.32 / (1.5 * 4.0 * 0.183), without.first);
    }
}
