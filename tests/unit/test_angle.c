/* The expected values come from remainder() in double precision. To have more digits of pi than a double,
 * k * PI_REST corrects the error of k * PI. */
#include "math/angle.h"
#include "tests/unit/compare.h"
#include "tests/unit/sweep.h"

static const double PI_REST = 1.2246467991473532e-16;

/* The limit of the error is the sum of three parts: half of 2^-23, the rounding of a result between 2 and
 * 4; 1e-9 for the product with the small part of 2 pi; and one step of a float, because the ends of the
 * range are not floats. */
#define TOLERANCE 4e-7

/* The distance on the circle between wrap(angle) and the angle itself [rad]. */
static double error_of(float angle)
{
    double difference = (double)angle - (double)angle_wrap(angle);
    double turns = nearbyint(difference / (2.0 * PI));
    return fabs(difference - turns * 2.0 * PI - turns * 2.0 * PI_REST);
}

static double worst;
static int outside;

static void look_at(float angle)
{
    double error = error_of(angle);
    if (!(error <= worst)) {
        worst = error;
    }
    double wrapped = (double)angle_wrap(angle);
    if (!(wrapped >= -PI && wrapped < PI)) {
        outside++;
    }
}

static void test_wraps_the_whole_range_into_one_turn(void)
{
    worst = 0.0;
    outside = 0;
    for (int32_t k = -4000000; k <= 4000000; k += SWEEP) {
        look_at((float)k * 0.0025f);
    }
    TEST_ASSERT_DOUBLE_WITHIN(TOLERANCE, 0.0, worst);
    TEST_ASSERT_EQUAL_INT(0, outside);
}

static void test_stays_strictly_inside_next_to_every_half_turn(void)
{
    worst = 0.0;
    outside = 0;
    for (int half = -3183; half <= 3183; half += 1 + SWEEP / 100) {
        float below = (float)(half * PI);
        float above = below;
        for (int step = 0; step < 12; step++) {
            look_at(below);
            look_at(above);
            below = nextafterf(below, -20000.0f);
            above = nextafterf(above, 20000.0f);
        }
    }
    TEST_ASSERT_DOUBLE_WITHIN(TOLERANCE, 0.0, worst);
    TEST_ASSERT_EQUAL_INT(0, outside);
}

static void test_leaves_what_is_inside_bit_for_bit(void)
{
    float inside[] = {0.0f, 1e-30f, -1e-30f, 1.0f, -2.0f, 3.0f, ANGLE_LARGEST, -ANGLE_LARGEST};
    for (unsigned k = 0; k < sizeof inside / sizeof inside[0]; k++) {
        TEST_ASSERT_TRUE(angle_wrap(inside[k]) == inside[k]);
    }
}

static void test_floats_next_to_pi_go_to_the_other_side(void)
{
    TEST_ASSERT_TRUE((double)ANGLE_LARGEST < PI);
    TEST_ASSERT_TRUE((double)nextafterf(ANGLE_LARGEST, 4.0f) > PI);
    TEST_ASSERT_TRUE(angle_wrap(ANGLE_PI) < -3.14159f);
    TEST_ASSERT_TRUE(angle_wrap(-ANGLE_PI) > 3.14159f);
    TEST_ASSERT_TRUE(fabsf(angle_wrap(ANGLE_TWO_PI)) < 4e-7f);
}

static void test_limit_of_the_range_below_at_above(void)
{
    TEST_ASSERT_DOUBLE_WITHIN(TOLERANCE, 0.0, error_of(nextafterf(ANGLE_WRAP_LIMIT, 0.0f)));
    TEST_ASSERT_DOUBLE_WITHIN(TOLERANCE, 0.0, error_of(ANGLE_WRAP_LIMIT));
    TEST_ASSERT_DOUBLE_WITHIN(TOLERANCE, 0.0, error_of(-ANGLE_WRAP_LIMIT));
    /* 1e4 = 1591 turns + 3.452..., so that its wrapped value is not 0. */
    TEST_ASSERT_TRUE(fabsf(angle_wrap(ANGLE_WRAP_LIMIT)) > 1.0f);
    TEST_ASSERT_TRUE(angle_wrap(nextafterf(ANGLE_WRAP_LIMIT, 20000.0f)) == 0.0f);
    TEST_ASSERT_TRUE(angle_wrap(-nextafterf(ANGLE_WRAP_LIMIT, 20000.0f)) == 0.0f);
}

static void test_no_number_and_infinity_become_zero(void)
{
    TEST_ASSERT_TRUE(angle_wrap(NAN) == 0.0f);
    TEST_ASSERT_TRUE(angle_wrap(INFINITY) == 0.0f);
    TEST_ASSERT_TRUE(angle_wrap(-INFINITY) == 0.0f);
}
