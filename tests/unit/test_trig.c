/* Sine, cosine and atan2 are compared with the double-precision library, densely over their whole ranges. The
 * limits are those of the header: the minimax errors, 3.4e-8 and for atan2 1.7e-6, plus the rounding.
 *
 * Rounding: with an error ds of sin h and dc of cos h, the sine changes by 2 cos h ds + 2 sin h dc and the
 * cosine by 4 cos h dc. Near angle 0, dc is half an ulp below 1 (3e-8). Near the largest angle (h = 2) the
 * largest terms of cos h and sin h are 2, with an ulp of 1.2e-7, of which two or three roundings take half
 * each. There dc and ds are up to 1.8e-7, which makes 4.8e-7; at pi, 2 dc makes 3.6e-7. sin^2 + cos^2 has
 * at worst twice the root of the sum of both squared errors. For atan2 near pi the rounding of the result
 * (2^-23) and of pi (1.5e-7) are added. */
#include "math/angle.h"
#include "math/trig.h"
#include "tests/unit/compare.h"
#include "tests/unit/worst.h"

#define SINE_TOLERANCE     4e-7 /* for angles up to pi */
#define LIMIT_TOLERANCE    5e-7 /* for angles up to TRIG_LIMIT */
#define RELATIVE_TOLERANCE 3e-7
#define ATAN2_TOLERANCE    3e-6

static void look_at(float theta)
{
    rotation_t rotation = trig_rotation(theta);
    keep_worst((double)rotation.sin - sin((double)theta));
    keep_worst((double)rotation.cos - cos((double)theta));
}

/* Every third float up to pi, and every float from there to the limit. */
static void test_sine_and_cosine_of_all_angles(void)
{
    for (float theta = 0.1f; theta <= (float)PI; theta = floats_on(theta, 3)) {
        look_at(theta);
    }
    check("to pi", SINE_TOLERANCE);
    for (float theta = (float)PI; theta <= TRIG_LIMIT; theta = floats_on(theta, 1)) {
        look_at(theta);
    }
    check("to the limit", LIMIT_TOLERANCE);
}

static void test_small_angles_keep_their_relative_accuracy(void)
{
    for (float theta = 1e-30f; theta < 1e-3f; theta *= 1.7f) {
        keep_worst((double)trig_rotation(theta).sin / sin((double)theta) - 1.0);
    }
    for (float theta = 1e-3f; theta <= 1.0f; theta = floats_on(theta, 31)) {
        keep_worst((double)trig_rotation(theta).sin / sin((double)theta) - 1.0);
    }
    check("sine, relative", RELATIVE_TOLERANCE);
}

static void test_angle_zero_is_exact_and_sine_is_odd_and_cosine_even_bit_for_bit(void)
{
    const rotation_t none = trig_rotation(0.0f);
    TEST_ASSERT_TRUE(none.sin == 0.0f && none.cos == 1.0f);
    int unequal = 0;
    for (int32_t k = 0; k <= 400000; k += SWEEP) {
        rotation_t forward = trig_rotation((float)k * 1e-5f);
        rotation_t backward = trig_rotation((float)-k * 1e-5f);
        if (forward.sin != -backward.sin || forward.cos != backward.cos) {
            unequal++;
        }
    }
    TEST_ASSERT_EQUAL_INT(0, unequal);
}

static void test_rotation_limit_below_at_above(void)
{
    look_at(nextafterf(TRIG_LIMIT, 0.0f));
    look_at(-nextafterf(TRIG_LIMIT, 0.0f));
    look_at(TRIG_LIMIT);
    look_at(-TRIG_LIMIT);
    check("at the limit", LIMIT_TOLERANCE);
    float beyond[] = {
        nextafterf(TRIG_LIMIT, 5.0f), -nextafterf(TRIG_LIMIT, 5.0f), 1e30f, -1e30f, INFINITY, -INFINITY, NAN};
    for (unsigned k = 0; k < sizeof beyond / sizeof beyond[0]; k++) {
        rotation_t rotation = trig_rotation(beyond[k]);
        TEST_ASSERT_TRUE(rotation.sin == 0.0f && rotation.cos == 0.0f);
    }
}

/* The tracking loop uses this function. The limits are 1.4e-6 for the polynomials and 4e-7 for rounding of
 * the angle, and 6e-7 for the length (S^2 is up to 2). The values are exact at 0; the cosine is even and
 * the sine odd. */
static void test_turn_of_a_wrapped_angle(void)
{
    double length = 0.0;
    for (int32_t k = -1000000; k <= 1000000; k += SWEEP) {
        float theta = (float)k * (ANGLE_LARGEST / 1000000.0f);
        rotation_t turn = trig_turn(theta);
        rotation_t back = trig_turn(-theta);
        double sine = (double)turn.sin, cosine = (double)turn.cos;
        double s = sin((double)theta), c = cos((double)theta);
        keep_worst(atan2(sine * c - cosine * s, cosine * c + sine * s));
        length = fmax(length, fabs(hypot(sine, cosine) - 1.0));
        TEST_ASSERT_TRUE(back.sin == -turn.sin && back.cos == turn.cos);
    }
    check("angle", 1.8e-6);
    keep_worst(length);
    check("length", 2e-6);
    rotation_t none = trig_turn(0.0f);
    TEST_ASSERT_TRUE(none.sin == 0.0f && none.cos == 1.0f);
}

static void look_at_vector(float y, float x)
{
    float angle = trig_atan2(y, x);
    double error = (double)angle - atan2((double)y, (double)x);
    keep_worst(circle(error));
    if (!(angle >= -ANGLE_LARGEST && angle <= ANGLE_LARGEST)) {
        worst = (double)INFINITY;
    }
}

static void test_atan2_over_the_circle_at_every_length(void)
{
    static const float lengths[] = {1e-36f, 1e-20f, 1e-3f, 1.0f, 115.0f, 1e9f, 5e37f};
    for (unsigned n = 0; n < sizeof lengths / sizeof lengths[0]; n++) {
        for (int32_t k = -200000; k < 200000; k += SWEEP) {
            double angle = PI * k / 200000.0;
            look_at_vector((float)sin(angle) * lengths[n], (float)cos(angle) * lengths[n]);
        }
    }
    check("atan2", ATAN2_TOLERANCE);
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

/* The limits are the bounds of the series and the rounding of two rotations. The series of the sine has
 * 0.95^9/9! = 1.74e-6, which is along the vector with sin 0.95 and across it with cos 0.95; that of the
 * cosine has 0.95^10/10! = 1.6e-7. */
static void test_advance_turns_a_rotation_on(void)
{
    for (double from = -3.1; from < 3.2; from += 0.31) {
        for (double angle = -(double)TRIG_ADVANCE_LIMIT; angle <= (double)TRIG_ADVANCE_LIMIT;
             angle += 0.003) {
            const rotation_t turned = trig_advance(trig_rotation((float)from), (float)angle);
            const double target = (double)(float)from + (double)(float)angle;
            const double along = (double)turned.cos * cos(target) + (double)turned.sin * sin(target);
            const double across = (double)turned.sin * cos(target) - (double)turned.cos * sin(target);
            TEST_ASSERT_DOUBLE_WITHIN(1.5e-6 + 8e-7, 1.0, along);
            TEST_ASSERT_DOUBLE_WITHIN(1.2e-6 + 8e-7, 0.0, across);
        }
    }
}

/* The angle of a rotation, in all quadrants and near every axis and diagonal. A length that is wrong by
 * 1e-3 changes the arc sine of the shorter component by at most 1e-3, the series is right within 3e-3, and
 * the Newton step leaves 1e-3 of both. */
static void test_angle_of_a_rotation(void)
{
    static const double lengths[] = {1.0, 0.999, 1.001};
    for (int n = 0; n < 3; n++) {
        worst = 0.0;
        for (int32_t k = -1000000; k <= 1000000; k += SWEEP) {
            const double theta = PI * k / 1000000.0;
            const rotation_t rotation = {(float)(lengths[n] * sin(theta)), (float)(lengths[n] * cos(theta))};
            const float angle = trig_angle(rotation);
            const double error = (double)angle - theta;
            keep_worst(circle(error));
            TEST_ASSERT_TRUE(angle >= -ANGLE_LARGEST && angle <= ANGLE_LARGEST);
        }
        check("angle of a rotation", n == 0 ? 2e-6 : 6e-6);
    }
}

static void test_angle_of_a_rotation_on_the_axes_and_of_none(void)
{
    TEST_ASSERT_TRUE(trig_angle((rotation_t){0.0f, 0.0f}) == 0.0f);
    TEST_ASSERT_TRUE(trig_angle((rotation_t){0.0f, 1.0f}) == 0.0f);
    TEST_ASSERT_DOUBLE_WITHIN(2e-6, PI / 2.0, (double)trig_angle((rotation_t){1.0f, 0.0f}));
    TEST_ASSERT_DOUBLE_WITHIN(2e-6, -PI / 2.0, (double)trig_angle((rotation_t){-1.0f, 0.0f}));
    TEST_ASSERT_DOUBLE_WITHIN(2e-6, PI, fabs((double)trig_angle((rotation_t){0.0f, -1.0f})));
}
