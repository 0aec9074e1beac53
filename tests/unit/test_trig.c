/* Sine, cosine and atan2 against the double-precision library, densely over their whole ranges. The limits
 * are the ones the header states; they follow from the minimax errors (2e-9, 1e-10, 1.7e-6) plus the rounding
 * of the reduced angle (2^-25), of the polynomial near 1 (2^-24) and, for atan2 near pi, of the result
 * (2^-23) and the shortened pi (1.5e-7). */
#include <math.h>
#include <unity.h>

#include "math/angle.h"
#include "math/trig.h"

static const double PI = 3.14159265358979323846;

#define SINE_TOLERANCE  2e-7
#define ATAN2_TOLERANCE 3e-6

static double worst;

static void keep_worst(double error)
{
    if (!(fabs(error) <= worst)) {
        worst = fabs(error);
    }
}

void setUp(void)
{
    worst = 0.0;
}

void tearDown(void)
{
}

static void look_at(float theta)
{
    rotation_t rotation = trig_rotation(theta);
    keep_worst((double)rotation.sin - sin((double)theta));
    keep_worst((double)rotation.cos - cos((double)theta));
}

static void test_sine_and_cosine_over_two_turns(void)
{
    for (int k = -2000000; k <= 2000000; k++) {
        look_at((float)(2.0 * PI * k / 2000000.0));
    }
    TEST_ASSERT_DOUBLE_WITHIN(SINE_TOLERANCE, 0.0, worst);
}

static void test_sine_and_cosine_over_the_whole_range(void)
{
    for (int k = -1000000; k <= 1000000; k++) {
        look_at((float)k * 1e-4f);
    }
    TEST_ASSERT_DOUBLE_WITHIN(SINE_TOLERANCE, 0.0, worst);
}

static void test_seams_between_the_octants(void)
{
    for (int eighth = -16; eighth <= 16; eighth++) {
        float below = (float)(eighth * PI / 4.0);
        float above = below;
        for (int step = 0; step < 20; step++) {
            look_at(below);
            look_at(above);
            below = nextafterf(below, -10.0f);
            above = nextafterf(above, 10.0f);
        }
    }
    TEST_ASSERT_DOUBLE_WITHIN(SINE_TOLERANCE, 0.0, worst);
}

static void test_small_angles_keep_their_relative_accuracy(void)
{
    for (float theta = 1e-30f; theta < 0.1f; theta *= 1.7f) {
        keep_worst((double)trig_sin(theta) / sin((double)theta) - 1.0);
    }
    TEST_ASSERT_DOUBLE_WITHIN(SINE_TOLERANCE, 0.0, worst);
    TEST_ASSERT_TRUE(trig_sin(0.0f) == 0.0f);
    TEST_ASSERT_TRUE(trig_cos(0.0f) == 1.0f);
}

static void test_sine_is_odd_and_cosine_even_bit_for_bit(void)
{
    int unequal = 0;
    for (int k = 0; k <= 100000; k++) {
        rotation_t forward = trig_rotation((float)k * 1e-3f);
        rotation_t backward = trig_rotation((float)-k * 1e-3f);
        if (forward.sin != -backward.sin || forward.cos != backward.cos) {
            unequal++;
        }
    }
    TEST_ASSERT_EQUAL_INT(0, unequal);
}

static void test_single_functions_are_halves_of_the_rotation(void)
{
    for (int k = -100; k <= 100; k++) {
        float theta = (float)k * 0.0613f;
        TEST_ASSERT_TRUE(trig_sin(theta) == trig_rotation(theta).sin);
        TEST_ASSERT_TRUE(trig_cos(theta) == trig_rotation(theta).cos);
    }
}

static void test_rotation_limit_below_at_above(void)
{
    look_at(nextafterf(TRIG_LIMIT, 0.0f));
    look_at(TRIG_LIMIT);
    look_at(-TRIG_LIMIT);
    TEST_ASSERT_DOUBLE_WITHIN(SINE_TOLERANCE, 0.0, worst);
    float beyond[] = {
        nextafterf(TRIG_LIMIT, 1000.0f), -nextafterf(TRIG_LIMIT, 1000.0f), 1e30f, INFINITY, -INFINITY, NAN};
    for (unsigned k = 0; k < sizeof beyond / sizeof beyond[0]; k++) {
        rotation_t rotation = trig_rotation(beyond[k]);
        TEST_ASSERT_TRUE(rotation.sin == 0.0f && rotation.cos == 0.0f);
    }
}

static void look_at_vector(float y, float x)
{
    float angle = trig_atan2(y, x);
    double error = (double)angle - atan2((double)y, (double)x);
    keep_worst(error - 2.0 * PI * nearbyint(error / (2.0 * PI)));
    if (!(angle >= -ANGLE_LARGEST && angle <= ANGLE_LARGEST)) {
        worst = INFINITY;
    }
}

static void test_atan2_over_the_circle_at_every_length(void)
{
    static const float lengths[] = {1e-36f, 1e-20f, 1e-3f, 1.0f, 115.0f, 1e9f, 5e37f};
    for (unsigned n = 0; n < sizeof lengths / sizeof lengths[0]; n++) {
        for (int k = -200000; k < 200000; k++) {
            double angle = PI * k / 200000.0;
            look_at_vector((float)sin(angle) * lengths[n], (float)cos(angle) * lengths[n]);
        }
    }
    TEST_ASSERT_DOUBLE_WITHIN(ATAN2_TOLERANCE, 0.0, worst);
}

static void test_atan2_of_every_ratio(void)
{
    for (int k = 0; k <= 1000000; k++) {
        float ratio = (float)k * 1e-6f;
        look_at_vector(ratio, 1.0f);
        look_at_vector(-1.0f, -ratio);
    }
    TEST_ASSERT_DOUBLE_WITHIN(ATAN2_TOLERANCE, 0.0, worst);
}

static void test_atan2_on_the_axes_and_diagonals(void)
{
    TEST_ASSERT_TRUE(trig_atan2(0.0f, 2.0f) == 0.0f);
    TEST_ASSERT_DOUBLE_WITHIN(1e-7, PI / 2.0, (double)trig_atan2(2.0f, 0.0f));
    TEST_ASSERT_DOUBLE_WITHIN(1e-7, -PI / 2.0, (double)trig_atan2(-2.0f, 0.0f));
    TEST_ASSERT_TRUE(trig_atan2(0.0f, -2.0f) == ANGLE_LARGEST);
    TEST_ASSERT_DOUBLE_WITHIN(ATAN2_TOLERANCE, PI / 4.0, (double)trig_atan2(3.0f, 3.0f));
    TEST_ASSERT_DOUBLE_WITHIN(ATAN2_TOLERANCE, 3.0 * PI / 4.0, (double)trig_atan2(3.0f, -3.0f));
    TEST_ASSERT_DOUBLE_WITHIN(ATAN2_TOLERANCE, -3.0 * PI / 4.0, (double)trig_atan2(-3.0f, -3.0f));
    TEST_ASSERT_DOUBLE_WITHIN(ATAN2_TOLERANCE, -PI / 4.0, (double)trig_atan2(-3.0f, 3.0f));
}

static void test_atan2_of_no_vector_is_zero(void)
{
    static const float pairs[][2] = {
        {0.0f, 0.0f}, {0.0f, -0.0f},     {1e-38f, -1e-38f}, {9e37f, -9e37f},      {NAN, -1.0f},
        {1.0f, NAN},  {INFINITY, -1.0f}, {1.0f, -INFINITY}, {INFINITY, INFINITY}, {NAN, INFINITY}};
    for (unsigned k = 0; k < sizeof pairs / sizeof pairs[0]; k++) {
        TEST_ASSERT_TRUE(trig_atan2(pairs[k][0], pairs[k][1]) == 0.0f);
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_sine_and_cosine_over_two_turns);
    RUN_TEST(test_sine_and_cosine_over_the_whole_range);
    RUN_TEST(test_seams_between_the_octants);
    RUN_TEST(test_small_angles_keep_their_relative_accuracy);
    RUN_TEST(test_sine_is_odd_and_cosine_even_bit_for_bit);
    RUN_TEST(test_single_functions_are_halves_of_the_rotation);
    RUN_TEST(test_rotation_limit_below_at_above);
    RUN_TEST(test_atan2_over_the_circle_at_every_length);
    RUN_TEST(test_atan2_of_every_ratio);
    RUN_TEST(test_atan2_on_the_axes_and_diagonals);
    RUN_TEST(test_atan2_of_no_vector_is_zero);
    return UNITY_END();
}
