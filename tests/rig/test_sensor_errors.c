/* What the current sensors' errors make of the angle at low speed without an encoder, on a real inverter: a
 * start into a turning rotor, the bare motor at 100 r/min, a step of the speed, a reversal under load; and
 * what was learnt of the offsets outlasts a stop. Seeds in both directions. */
#include "tests/rig/start.h"
#include "tests/rig/the_rig.h"

#include <complex.h>
#include <stdlib.h>

#define SEEDS     32u /* of both directions */
#define RUNS_SLOW 8u  /* of the bare motor, of whose SD the median is judged */

static start_seen_t seen;

typedef struct {
    double sd, peak; /* [mrad] while run lasts */
} angle_error_t;

static angle_error_t watch(double seconds)
{
    double sum = 0.0, square = 0.0, peak = 0.0;
    uint32_t count = 0u;
    for (uint32_t n = rig_periods(seconds); n > 0u; n--) {
        rig_step(rig);
        if (seen.manoeuvre == RUNS) {
            const double error = 1e3 * seen.error;
            sum += error;
            square += error * error;
            start_raise(&peak, fabs(error));
            count++;
        }
    }
    TEST_ASSERT_TRUE(count > rig_periods(0.9 * seconds));
    const double mean = sum / count;
    return (angle_error_t){sqrt(fmax(0.0, square / count - mean * mean)), peak};
}

/* Ready, the rotor turning at this speed; friction waits, so that it keeps it. */
static void turning(start_shaft_t shaft, uint32_t seed, const start_row_t *rows, size_t count, double rpm)
{
    rig_free(rig);
    rig = start_on_desk(shaft, seed);
    for (size_t n = 0; n < count; n++) {
        run_put(rig, rows[n].name, rows[n].value);
    }
    if (!rig_apply(rig)) {
        TEST_FAIL_MESSAGE(rig_error(rig));
    }
    run_to_ready_at(rig, rpm);
    run_real(rig);
    start_watch(rig, &seen);
}

static int by_size(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return x < y ? -1 : x > y;
}

static void test_start_into_a_rotor_at_100_rpm(void)
{
    grid_t grid = grid_of("start at 100 r/min", START_BOTH * SEEDS);
    for (uint32_t n; grid_next(&grid, &n);) {
        const start_shaft_t shaft = (start_shaft_t)grid_axis(&n, START_BOTH);
        const double rpm = n % 2u == 0u ? 100.0 : -100.0;
        turning(shaft, 1u + n / 2u, NULL, 0u, rpm);
        run_on(rig, rpm);
        run_seconds(rig, 0.025); /* the catch */
        const double peak = watch(0.5).peak;
        run_expect_no_fault(rig);
        printf("start at %.0f r/min, %c: peak %.1f mrad\n", rpm, START_SHAFT_NAMES[shaft], peak);
        TEST_ASSERT_TRUE(peak <= 61.0); /* asked: 80; of 68 starts 21, one 47 */
    }
}

static void expect_calm(double friction, double median_limit)
{
    double sd[RUNS_SLOW], peak = 0.0;
    for (uint32_t n = 0; n < RUNS_SLOW; n++) {
        const double direction = n % 2u == 0u ? 1.0 : -1.0;
        turning(BARE, 1u + n / 2u, NULL, 0u, direction * 500.0);
        run_on(rig, direction * 500.0);
        run_seconds(rig, 0.3);
        run_put(rig, "friction_coulomb", friction);
        for (int32_t step = 1; step <= 40; step++) {
            run_on(rig, direction * (500.0 - 10.0 * step));
            run_seconds(rig, 0.04);
        }
        run_seconds(rig, 2.0);
        const angle_error_t error = watch(1.0);
        run_expect_no_fault(rig);
        sd[n] = error.sd;
        start_raise(&peak, error.peak);
    }
    qsort(sd, RUNS_SLOW, sizeof sd[0], by_size);
    printf("bare motor at 100 r/min, %.2f N m: SD median %.2f, worst %.2f, peak %.1f mrad of %u\n", friction,
           sd[RUNS_SLOW / 2u], sd[RUNS_SLOW - 1u], peak, RUNS_SLOW);
    TEST_ASSERT_TRUE(sd[RUNS_SLOW / 2u] <= median_limit);
    TEST_ASSERT_TRUE(sd[RUNS_SLOW - 1u] <= 2.9);
    TEST_ASSERT_TRUE(peak <= 18.0);
}

/* Asked: medians of 3 and 4.5, an SD of 7 and peaks of 50 mrad. */
static void test_bare_motor_at_100_rpm(void)
{
    grid_t grid = grid_of("bare motor at 100 r/min", 2u);
    for (uint32_t n; grid_next(&grid, &n);) {
        expect_calm(n == 0u ? 0.0 : 1.32, n == 0u ? 2.1 : 2.5);
    }
}

/* The loop is told of the motor's torque by the inertia of the parameter from the first step on. */
static void test_step_from_100_to_1500_rpm(void)
{
    static const start_row_t told[] = {{"torque_feedforward", 1.0}, {"inertia_adaptation", 0.0}};
    grid_t grid = grid_of("100 to 1500 r/min", START_ALL * SEEDS);
    for (uint32_t n; grid_next(&grid, &n);) {
        const start_shaft_t shaft = (start_shaft_t)grid_axis(&n, START_ALL);
        const double direction = n % 2u == 0u ? 1.0 : -1.0;
        turning(shaft, 1u + n / 2u, told, 2u, direction * 100.0);
        run_on(rig, direction * 100.0);
        run_seconds(rig, 2.0);
        run_on(rig, direction * 1500.0);
        const double peak = watch(2.0).peak;
        run_expect_no_fault(rig);
        printf("100 to 1500 r/min, %c: peak %.1f mrad\n", START_SHAFT_NAMES[shaft], peak);
        TEST_ASSERT_TRUE(
            peak <=
            (shaft == HEAVY
                 ? 26.0
                 : 13.0)); /* of 16 heavy ones 20.9 is the most, 11 without what is learnt of the legs */
    }
}

/* Load and friction change their signs at zero, which nobody tells the loop: its bandwidth alone follows,
 * two and a half times the default's. Asked: 90. */
static void test_reversal_under_a_passive_load(void)
{
    static const start_row_t rows[] = {{"torque_feedforward", 1.0},
                                       {"inertia_adaptation", 0.0},
                                       {"pll_bandwidth", 500.0},
                                       {"feedforward_cutoff", 125.0}};
    grid_t grid = grid_of("reversal under a load", SEEDS);
    for (uint32_t n; grid_next(&grid, &n);) {
        double worst = 0.0;
        const double rpm = n % 2u == 0u ? 500.0 : -500.0;
        turning(HEAVY, 1u + n / 2u, rows, 4u, rpm);
        run_on(rig, rpm);
        run_seconds(rig, 0.5);
        run_load(rig, RATED_TORQUE, 1.5);
        run_seconds(rig, 0.5);
        run_on(rig, -rpm);
        for (uint32_t k = rig_periods(2.0); k > 0u; k--) {
            rig_step(rig);
            if (seen.manoeuvre == RUNS) {
                start_raise(&worst, 1e3 * fabs(seen.error));
            }
        }
        run_expect_no_fault(rig);
        TEST_ASSERT_DOUBLE_WITHIN(10.0, -rpm, seen.speed);
        printf("%.0f to %.0f r/min, 5 N m: peak %.1f mrad\n", rpm, -rpm, worst);
        TEST_ASSERT_TRUE(worst <= 90.0); /* 62 +- 6.6 of 32 */
    }
}

/* Of the angle's error over six turns, the part that goes with the rotor [mrad]. */
static double first_order(void)
{
    double complex sum = 0.0;
    const uint32_t periods = rig_periods(0.3);
    for (uint32_t n = 0; n < periods; n++) {
        rig_step(rig);
        sum += 1e3 * seen.error * cexp(-(double complex)I * seen.theta_e);
    }
    return 2.0 * cabs(sum) / periods;
}

/* A start into a rotor at 300 r/min, 20 turns a second, that learns nothing on the way. */
static double first_order_of_a_start(void)
{
    run_parameter(rig, "offset_trim", 0.0);
    run_on(rig, 300.0);
    run_seconds(rig, 0.5);
    return first_order();
}

static void test_offset_that_was_learnt_outlasts_a_stop(void)
{
    turning(HEAVY, 1u, NULL, 0u, 300.0);
    const double before = first_order_of_a_start();
    run_parameter(rig, "offset_trim", 0.05);
    run_seconds(rig, 4.0);
    const double trim[] = {rig_value(rig, "trim_alpha"), rig_value(rig, "trim_beta")};
    run_put(rig, "enable", 0.0);
    run_seconds(rig, 0.02);
    TEST_ASSERT_EQUAL_DOUBLE(1.0, rig_value(rig, "state"));
    const double after = first_order_of_a_start();
    printf("first order at a start: %.2f mrad, with what was learnt %.2f; trim %.1f, %.1f mA\n", before,
           after, 1e3 * trim[0], 1e3 * trim[1]);
    TEST_ASSERT_EQUAL_DOUBLE(trim[0], rig_value(rig, "trim_alpha"));
    TEST_ASSERT_EQUAL_DOUBLE(trim[1], rig_value(rig, "trim_beta"));
    TEST_ASSERT_DOUBLE_WITHIN(6e-3, 0.03, trim[0]);
    TEST_ASSERT_DOUBLE_WITHIN(6e-3, 0.03 / sqrt(3.0), trim[1]);
    TEST_ASSERT_TRUE(after <= 0.45 * before); /* 6 mA of each axis of 35, and the noise of six turns */
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_start_into_a_rotor_at_100_rpm);
    RUN_TEST(test_bare_motor_at_100_rpm);
    RUN_TEST(test_step_from_100_to_1500_rpm);
    RUN_TEST(test_reversal_under_a_passive_load);
    SEED_RUN_EIGHT(test_offset_that_was_learnt_outlasts_a_stop);
    return UNITY_END();
}
