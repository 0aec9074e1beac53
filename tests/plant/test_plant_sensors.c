/* The values that the drive measures: voltages, noise, lag, counts; and the random numbers of the noise. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "host_sim/plant/noise.h"
#include "host_sim/plant/phasor.h"
#include "tests/plant/bench.h"
#include "unity.h"

#define PI 3.14159265358979323846

static plant_params_t quiet(void)
{
    return plant_of("current_noise = 0, shaft_locked = 1, dc_voltage = 30");
}

/* Drives about 19.5 A into phase a; half of it returns through each of b and c. */
static void charge(const plant_params_t *q)
{
    plant_init(&plant, q, 42);
    plant_gates(&plant, 0, PLANT_UPPER(0) | PLANT_LOWER(1) | PLANT_LOWER(2));
    plant_advance(&plant, 37500000u);
}

static void test_current_pins_read_offset_gain_and_range(void)
{
    plant_truth_t now;
    plant_params_t q =
        plant_with(quiet(), "current_gain_error_a = 0.02, current_offset_b = 0.5, current_range = 25");
    charge(&q);
    now = truth();
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 1.5 + 1.5 * 1.02 * now.i_a / 25.0,
                              plant_analog(&plant, PLANT_CURRENT_A));
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 1.5 + 1.5 * (now.i_b + 0.5) / 25.0,
                              plant_analog(&plant, PLANT_CURRENT_B));
    q.current_gain_error_b = -0.1;
    q.current_offset_a = -1.0;
    plant_set_params(&plant, &q);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 1.5 + 1.5 * (1.02 * now.i_a - 1.0) / 25.0,
                              plant_analog(&plant, PLANT_CURRENT_A));
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 1.5 + 1.5 * (0.9 * now.i_b + 0.5) / 25.0,
                              plant_analog(&plant, PLANT_CURRENT_B));
}

static void test_pins_stop_at_their_rails(void)
{
    plant_params_t q = quiet();
    q.current_range = 9.0; /* the current of a is beyond this range, that of b within it */
    charge(&q);
    TEST_ASSERT_EQUAL_DOUBLE(3.0, plant_analog(&plant, PLANT_CURRENT_A));
    TEST_ASSERT_EQUAL_DOUBLE(0.0, plant_analog(&plant, PLANT_CURRENT_B));
}

static void test_link_and_temperature_pins_are_straight_lines(void)
{
    begin(plant_with(
        quiet(), "dc_voltage = 311, dc_gain_error = -0.03, sink_temperature = 25, motor_temperature = 120"));
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 3.0 * 0.97 * 311.0 / 500.0, plant_analog(&plant, PLANT_DC_LINK));
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 3.0 * 75.0 / 200.0, plant_analog(&plant, PLANT_SINK));
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 3.0 * 170.0 / 200.0, plant_analog(&plant, PLANT_MOTOR));
}

static void test_noise_has_its_mean_deviation_and_independence(void)
{
    enum { N = 200000 };
    plant_params_t q = plant_with(quiet(), "current_noise = 0.2, dc_noise = 1.5");
    plant_init(&plant, &q, 7);
    double sum_a = 0.0, square_a = 0.0, sum_b = 0.0, square_b = 0.0, cross = 0.0, lag = 0.0, last = 0.0;
    double sum_v = 0.0, square_v = 0.0, fourth = 0.0;
    for (int n = 0; n < N; n++) {
        double a = (plant_analog(&plant, PLANT_CURRENT_A) - 1.5) * 20.0 / 1.5 / 0.2;
        double b = (plant_analog(&plant, PLANT_CURRENT_B) - 1.5) * 20.0 / 1.5 / 0.2;
        double v = (plant_analog(&plant, PLANT_DC_LINK) * 500.0 / 3.0 - 30.0) / 1.5;
        sum_a += a;
        square_a += a * a;
        fourth += a * a * a * a;
        sum_b += b;
        square_b += b * b;
        sum_v += v;
        square_v += v * v;
        cross += a * b;
        lag += a * last;
        last = a;
    }
    /* Five standard deviations: of a mean 1/sqrt(N), of a mean square sqrt(2/N), of a product 1/sqrt(N),
     * of a fourth power sqrt(96/N). The kurtosis is 3 - 0.041 as noise.h states. */
    double five = 5.0 / sqrt(N);
    TEST_ASSERT_DOUBLE_WITHIN(five, 0.0, sum_a / N);
    TEST_ASSERT_DOUBLE_WITHIN(five, 0.0, sum_b / N);
    TEST_ASSERT_DOUBLE_WITHIN(five, 0.0, sum_v / N);
    TEST_ASSERT_DOUBLE_WITHIN(five * sqrt(2.0), 1.0, square_a / N);
    TEST_ASSERT_DOUBLE_WITHIN(five * sqrt(2.0), 1.0, square_b / N);
    TEST_ASSERT_DOUBLE_WITHIN(five * sqrt(2.0), 1.0, square_v / N);
    TEST_ASSERT_DOUBLE_WITHIN(five, 0.0, cross / N);
    TEST_ASSERT_DOUBLE_WITHIN(five, 0.0, lag / N);
    TEST_ASSERT_DOUBLE_WITHIN(five * sqrt(96.0), 3.0 - 0.041, fourth / N);
}

static void test_generator_gives_the_published_numbers(void)
{
    /* splitmix64 from seed 1234567, as published with translations of the reference implementation
     * (Rosetta Code). */
    static const uint64_t published[5] = {UINT64_C(6457827717110365317), UINT64_C(3203168211198807973),
                                          UINT64_C(9817491932198370423), UINT64_C(4593380528125082431),
                                          UINT64_C(16408922859458223821)};
    uint64_t state = 1234567;
    for (int n = 0; n < 5; n++) {
        TEST_ASSERT_EQUAL_UINT64(published[n], noise_next(&state));
    }
}

static void test_same_seed_gives_the_same_noise_and_another_seed_another(void)
{
    plant_params_t q = plant_with(quiet(), "current_noise = 0.1");
    double first[10];
    int equal = 0;
    plant_init(&plant, &q, 99);
    for (int n = 0; n < 10; n++) {
        first[n] = plant_analog(&plant, PLANT_CURRENT_A);
    }
    plant_init(&plant, &q, 99);
    for (int n = 0; n < 10; n++) {
        TEST_ASSERT_EQUAL_DOUBLE(first[n], plant_analog(&plant, PLANT_CURRENT_A));
    }
    plant_init(&plant, &q, 100);
    for (int n = 0; n < 10; n++) {
        double x = plant_analog(&plant, PLANT_CURRENT_A);
        equal += x >= first[n] && x <= first[n];
    }
    TEST_ASSERT_EQUAL_INT(0, equal);
}

static void test_lagging_sensor_trails_a_ramp_by_its_time_constant(void)
{
    plant_params_t q =
        plant_with(quiet(), "resistance = 0, " NO_DROPS ", turn_on_delay = 0, current_bandwidth = 5000");
    plant_init(&plant, &q, 1);
    plant_gates(&plant, 0, PLANT_UPPER(0) | PLANT_LOWER(1) | PLANT_LOWER(2));
    double slope = 20.0 / 0.0125;
    for (int k = 1; k <= 10; k++) {
        double t = 1e-3 * k;
        plant_advance(&plant, (uint64_t)k * 150000u);
        double seen = (plant_analog(&plant, PLANT_CURRENT_A) - 1.5) * 20.0 / 1.5;
        double ideal = slope * (t - (1.0 - exp(-5000.0 * t)) / 5000.0);
        TEST_ASSERT_DOUBLE_WITHIN(1e-9, ideal, seen);
    }
}

static void test_encoder_counts_are_the_floor_of_the_angle(void)
{
    static const double angles[] = {0.0, 0.001, 1.0, 3.2, 6.2, 6.3, -0.001, -0.7, -6.29, 1000.3, -1000.3};
    plant_params_t q = begin(plant_params_default());
    for (size_t n = 0; n < sizeof angles / sizeof angles[0]; n++) {
        plant_set_motion(&plant, angles[n], 0.0);
        TEST_ASSERT_EQUAL_INT64((int64_t)floor(angles[n] * 10000.0 / (2.0 * PI)), plant_encoder(&plant));
    }
    q = plant_with(q, "encoder_lines = 1024, encoder_offset = -2, pole_pairs = 3");
    plant_set_params(&plant, &q);
    for (size_t n = 0; n < sizeof angles / sizeof angles[0]; n++) {
        plant_set_motion(&plant, angles[n], 0.0);
        TEST_ASSERT_EQUAL_INT64((int64_t)floor((angles[n] - 2.0) * 4096.0 / (2.0 * PI)),
                                plant_encoder(&plant));
    }
}

static void test_encoder_read_ahead_is_what_it_reads_then(void)
{
    begin(plant_of("shaft_locked = 1, shaft_locked_speed = -150"));
    for (uint64_t k = 1; k <= 1000; k++) {
        int64_t ahead = plant_encoder_at(&plant, k * 14999u);
        TEST_ASSERT_EQUAL_INT64(plant_encoder(&plant), plant_encoder_at(&plant, plant.tick));
        plant_advance(&plant, k * 14999u);
        TEST_ASSERT_EQUAL_INT64(plant_encoder(&plant), ahead);
    }
}

static void test_phasor_agrees_with_the_library_over_the_whole_range(void)
{
    for (int n = -100000; n <= 100000; n++) {
        double c, s;
        double x = n * 0.0031;
        phasor_at(x, &c, &s);
        /* Half an ulp of 1.0 each for the polynomial and for the library, and 1e-16 |x| from the rounding
         * of the argument. */
        TEST_ASSERT_DOUBLE_WITHIN(4e-16 + 1e-16 * fabs(x), cos(x), c);
        TEST_ASSERT_DOUBLE_WITHIN(4e-16 + 1e-16 * fabs(x), sin(x), s);
    }
    for (int n = -110; n <= 110; n++) {
        double c = 0.6, s = 0.8;
        double x = n * 1e-3;
        phasor_turn(&c, &s, x);
        TEST_ASSERT_DOUBLE_WITHIN(1e-14, 0.6 * cos(x) - 0.8 * sin(x), c);
        TEST_ASSERT_DOUBLE_WITHIN(1e-14, 0.8 * cos(x) + 0.6 * sin(x), s);
    }
    for (int n = 0; n <= 7000; n++) {
        double x = n * 0.1;
        TEST_ASSERT_DOUBLE_WITHIN(1e-15 * (1.0 + x) * exp(-x), exp(-x), phasor_decay(x));
    }
    TEST_ASSERT_EQUAL_DOUBLE(0.0, phasor_decay(701.0));
}
