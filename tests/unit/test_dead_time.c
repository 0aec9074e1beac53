/* Numbers from docs/theory.md, 12, and from the module that the plant simulates: 311 V, 100 us, turn-on
 * 0.7 us, turn-off 0.9 us; and the six-vector diagram, integrated in double precision. */
#include "fast/inverter/dead_time.h"
#include "tests/unit/vectors.h"

static const dead_time_params_t PARAMS = {.dead_time = 2.5e-6f,
                                          .turn_on_delay = 0.7e-6f,
                                          .turn_off_delay = 0.9e-6f,
                                          .drop = 0.875f,
                                          .current_zone = 0.4f,
                                          .period = 1e-4f};

/* The limit is five roundings of voltages up to 13 V. */
#define TOLERANCE (5.0 * 16.0 / 16777216.0)

/* Error of one leg whose current has a certain sign [V]. */
static const double LEG = 2.3e-6 / 1e-4 * 311.0 + 0.875;

static double complex lost(const dead_time_params_t *params, double amplitude, double angle, double u_dc)
{
    const dead_time_tuning_t dead_time = dead_time_prepare(params);
    ab_t current = {(float)(amplitude * cos(angle)), (float)(amplitude * sin(angle))};
    const abc_t twice = dead_time_signs(&dead_time, current);
    const float leg = dead_time_leg(&dead_time, dead_time.volt_per_volt, (float)u_dc);
    ab_t voltage = dead_time_voltage(twice, 0.5f * leg);
    return of_ab(voltage);
}

static void test_is_the_sum_of_its_legs_in_and_out_of_the_zone(void)
{
    static const double amplitudes[] = {0.0, 0.1, 0.39, 0.4, 0.41, 0.8, 3.0};
    for (unsigned n = 0; n < sizeof amplitudes / sizeof amplitudes[0]; n++) {
        for (int degree = -180; degree < 180; degree += 3) {
            double angle = degree * PI / 180.0;
            double complex expected = 0.0;
            for (int leg = 0; leg < 3; leg++) {
                double current = amplitudes[n] * cos(angle - leg * 2.0 * PI / 3.0);
                double sign = fmax(-1.0, fmin(1.0, current / 0.4));
                expected += 2.0 / 3.0 * LEG * sign * cexp(J * leg * 2.0 * PI / 3.0);
            }
            TEST_ASSERT_DOUBLE_WITHIN(TOLERANCE, 0.0,
                                      cabs(lost(&PARAMS, amplitudes[n], angle, 311.0) - expected));
        }
    }
}

static void test_zone_of_no_width_is_one_of_a_milliampere(void)
{
    dead_time_params_t params = PARAMS;
    params.current_zone = 0.0f;
    TEST_ASSERT_TRUE(lost(&params, 0.0, 0.0, 311.0) == 0.0);
    TEST_ASSERT_DOUBLE_WITHIN(TOLERANCE, 4.0 / 3.0 * LEG, creal(lost(&params, 0.01, 0.0, 311.0)));
    TEST_ASSERT_DOUBLE_WITHIN(TOLERANCE, -4.0 / 3.0 * LEG, creal(lost(&params, -0.01, 0.0, 311.0)));
}
