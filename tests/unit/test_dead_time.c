/* Numbers from docs/theory.md, 12, and from the module that the plant simulates: 311 V, 100 us, turn-on
 * 0.7 us, turn-off 0.9 us; and the six-vector diagram, integrated in double precision. */
#include "fast/inverter/dead_time.h"
#include "tests/unit/vectors.h"

static const dead_time_params_t PARAMS = {.dead_time = 2.5e-6f,
                                          .turn_on_delay = 0.7e-6f,
                                          .turn_off_delay = 0.9e-6f,
                                          .drop = 0.875f,
                                          .current_zone = 0.4f,
                                          .gain = 1.0f,
                                          .period = 1e-4f};

/* The limit is five roundings of voltages up to 13 V. */
#define TOLERANCE (5.0 * 16.0 / 16777216.0)

/* Error of one leg whose current has a certain sign [V]. */
static const double LEG = 2.3e-6 / 1e-4 * 311.0 + 0.875;

static double complex lost(const dead_time_params_t *params, double amplitude, double angle, double u_dc)
{
    const dead_time_tuning_t dead_time = dead_time_prepare(params);
    ab_t current = {(float)(amplitude * cos(angle)), (float)(amplitude * sin(angle))};
    const abc_t signs = dead_time_signs(&dead_time, frames_inverse_clarke(current));
    ab_t voltage = dead_time_voltage(signs, dead_time_leg(&dead_time, (float)u_dc));
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

/* Each edge has its own half of the loss. Currents of -1/4 and 3/4 of the zone have the sum 1/2. If one edge
 * is beyond the zone on one side and the other edge on the other side, nothing is lost. */
static void test_each_edge_loses_half_by_its_own_current(void)
{
    const abc_t first = {-0.25f, 5.75f, -3.75f};
    const abc_t second = {0.75f, 4.25f, 1.25f};
    const abc_t signs = dead_time_edge_signs(first, second);
    TEST_ASSERT_TRUE(signs.a == 0.5f && signs.b == 2.0f && signs.c == 0.0f);
    const abc_t same = dead_time_edge_signs(second, first);
    TEST_ASSERT_TRUE(same.a == signs.a && same.b == signs.b && same.c == signs.c);
}

static void test_gain_scales_all_of_it(void)
{
    dead_time_params_t params = PARAMS;
    params.gain = 0.85f;
    TEST_ASSERT_DOUBLE_WITHIN(TOLERANCE, 0.85 * 4.0 / 3.0 * LEG, creal(lost(&params, 5.0, 0.0, 311.0)));
    params.gain = 0.0f;
    TEST_ASSERT_TRUE(lost(&params, 5.0, 0.3, 311.0) == 0.0);
}

static void test_zone_of_no_width_is_a_hard_sign(void)
{
    dead_time_params_t params = PARAMS;
    params.current_zone = 0.0f;
    TEST_ASSERT_TRUE(lost(&params, 0.0, 0.0, 311.0) == 0.0);
    TEST_ASSERT_DOUBLE_WITHIN(TOLERANCE, 4.0 / 3.0 * LEG, creal(lost(&params, 1e-6, 0.0, 311.0)));
    TEST_ASSERT_DOUBLE_WITHIN(TOLERANCE, -4.0 / 3.0 * LEG, creal(lost(&params, -1e-6, 0.0, 311.0)));
}
