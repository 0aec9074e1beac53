/* EMFs with a fifth and a seventh harmonic, calculated by algebra; the expected value is the sum of the
 * two harmonics. */
#include "medium/adapt/emf_shape.h"
#include "tests/unit/vectors.h"

#define PSI  0.183
#define RATE 1.8
#define STEP 8e-4 /* [s] */

static const emf_shape_tuning_t TUNING = {(float)RATE, (float)(1.0 / RATE), (float)PSI};
static emf_shape_t shape;
static double theta, taken;

void setUp(void)
{
    memset(&shape, 0, sizeof shape);
    emf_shape_take(&shape, &TUNING);
    theta = 0.3;
    taken = 0.0;
}

/* Runs for this time at this speed [rad/s], with the sixth harmonics `d` of the d axis and `q` of the q
 * axis. */
static void turn(double omega, double d, double q, double seconds)
{
    for (int32_t n = 0; n < (int32_t)(seconds / STEP + 0.5); n++) {
        theta += omega * STEP;
        const double complex frame = cexp(J * theta);
        const double left = d - taken * (double)shape.used.d;
        const double left_q = q - taken * (double)shape.used.q;
        const double complex rest =
            PSI * omega * (-left * sin(6.0 * theta) + J * left_q * cos(6.0 * theta)) * frame;
        const emf_shape_input_t input = {to_ab(J * PSI * omega * frame), to_ab(rest), (float)omega,
                                         (float)STEP, (float)taken};
        emf_shape_step(&shape, &input);
    }
}

static void test_sum_and_difference_of_both_harmonics_are_learnt_whichever_way_it_turns(void)
{
    static const double speeds[] = {34.0, -34.0, 125.0, -125.0};
    static const double sums[] = {0.05, -0.05, 0.01};
    for (int32_t n = 0; n < 12; n++) {
        setUp();
        taken = n % 2 != 0 ? 1.0 : 0.0;
        turn(speeds[n % 4], sums[n / 4], 0.02, 20.0);
        TEST_ASSERT_DOUBLE_WITHIN(2e-3, sums[n / 4], (double)shape.used.d);
        TEST_ASSERT_DOUBLE_WITHIN(2e-3, 0.02, (double)shape.used.q);
    }
}

static void test_the_axes_are_distinguished_and_what_noise_may_make_is_not_used(void)
{
    turn(42.0, 0.0, 0.05, 1.0);
    TEST_ASSERT_DOUBLE_WITHIN(2e-3, 0.0, (double)shape.learnt.d);
    setUp();
    turn(42.0, 0.003, 0.003, 0.5); /* 0.5 s at less than 0.005 of the first rate */
    TEST_ASSERT_TRUE(shape.learnt.d > 0.001f && shape.learnt.q > 0.001f);
    TEST_ASSERT_EQUAL_FLOAT(0.0f, shape.used.d);
    TEST_ASSERT_EQUAL_FLOAT(0.0f, shape.used.q);
}

static void test_no_more_than_a_fifth_is_learnt(void)
{
    turn(42.0, 0.6, 0.0, 30.0);
    TEST_ASSERT_EQUAL_FLOAT(EMF_SHAPE_MAX, shape.learnt.d);
    setUp();
    turn(42.0, -0.6, 0.0, 30.0);
    TEST_ASSERT_EQUAL_FLOAT(-EMF_SHAPE_MAX, shape.learnt.d);
}

static void test_off_forgets_it_and_other_coefficients_do_not(void)
{
    turn(42.0, 0.05, 0.0, 10.0);
    const float learnt = shape.used.d;
    emf_shape_tuning_t tuning = TUNING;
    tuning.flux_linkage *= 1.1f;
    const float rate = shape.rate;
    emf_shape_take(&shape, &tuning);
    TEST_ASSERT_EQUAL_FLOAT(learnt, shape.used.d);
    TEST_ASSERT_EQUAL_FLOAT(rate, shape.rate);
    tuning.rate = 0.0f;
    emf_shape_take(&shape, &tuning);
    TEST_ASSERT_EQUAL_FLOAT(0.0f, shape.used.d);
    TEST_ASSERT_EQUAL_FLOAT(0.0f, shape.learnt.d);
    emf_shape_take(&shape, &TUNING);
    TEST_ASSERT_EQUAL_FLOAT((float)RATE, shape.rate);
}

/* The value of the formula for a rotor that turns backwards, at any angle. */
static void test_voltage_of_a_shape(void)
{
    shape.used = (dq_t){0.04f, -0.01f};
    for (int32_t n = 0; n < 24; n++) {
        const double angle = 0.27 * n;
        const rotation_t rotor = {(float)sin(angle), (float)cos(angle)};
        const ab_t voltage = emf_shape_voltage(&shape, -70.0f, rotor);
        const double complex expected =
            PSI * 70.0 * (0.04 * sin(6.0 * angle) + J * 0.01 * cos(6.0 * angle)) * cexp(J * angle);
        TEST_ASSERT_DOUBLE_WITHIN(1e-5, 0.0, cabs(of_ab(voltage) - expected));
    }
}

static void test_share_fades_out_where_the_loop_no_longer_follows(void)
{
    static const double cases[][2] = {{0.0, 1.0}, {200.0, 1.0}, {212.5, 0.5}, {225.0, 0.0}, {300.0, 0.0}};
    for (size_t n = 0; n < sizeof cases / sizeof cases[0]; n++) {
        TEST_ASSERT_DOUBLE_WITHIN(1e-6, cases[n][1], (double)emf_shape_share((float)cases[n][0]));
        TEST_ASSERT_DOUBLE_WITHIN(1e-6, cases[n][1], (double)emf_shape_share((float)-cases[n][0]));
    }
}
