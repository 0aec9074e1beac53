/* The Clarke and Park transforms are compared with complex numbers in double precision: the space vector
 * 2/3 (a + b w + c w^2), w = exp(j 2 pi/3), and its product with exp(-j theta). */
#include "math/frames.h"
#include "tests/unit/vectors.h"

/* Each output is a sum of at most three products of numbers up to 100 with constants up to 1. There are
 * five roundings, of the operations and of the constants, each by 2^-24 of at most 200 (the sums before
 * they are scaled). */
#define TOLERANCE (5.0 * 200.0 / 16777216.0)

static const abc_t PHASES[] = {
    {1.0f, 0.0f, 0.0f},   {0.0f, 1.0f, 0.0f},      {0.0f, 0.0f, 1.0f},     {1.0f, -0.5f, -0.5f},
    {-3.0f, 7.0f, -4.0f}, {100.0f, -60.0f, 40.0f}, {-0.01f, 0.02f, 99.0f}, {12.5f, 12.5f, 12.5f},
    {0.0f, 0.0f, 0.0f},   {5.0f, -5.0f, 0.0f},     {-77.0f, -11.0f, 3.0f},
};
enum { PHASES_COUNT = sizeof PHASES / sizeof PHASES[0] };

static double complex space_vector(abc_t phases)
{
    double complex third = cexp(J * 2.0 * PI / 3.0);
    return 2.0 / 3.0 * ((double)phases.a + (double)phases.b * third + (double)phases.c * third * third);
}

static rotation_t rotation_of(double angle)
{
    rotation_t rotation = {(float)sin(angle), (float)cos(angle)};
    return rotation;
}

static void test_clarke_is_the_space_vector(void)
{
    for (int k = 0; k < PHASES_COUNT; k++) {
        ab_t stationary = frames_clarke(PHASES[k]);
        double complex expected = space_vector(PHASES[k]);
        TEST_ASSERT_DOUBLE_WITHIN(TOLERANCE, creal(expected), (double)stationary.alpha);
        TEST_ASSERT_DOUBLE_WITHIN(TOLERANCE, cimag(expected), (double)stationary.beta);
    }
}

static void test_inverse_clarke_gives_phases_back_without_zero_sequence(void)
{
    for (int k = 0; k < PHASES_COUNT; k++) {
        abc_t phases = PHASES[k];
        double zero = ((double)phases.a + (double)phases.b + (double)phases.c) / 3.0;
        abc_t back = frames_inverse_clarke(frames_clarke(phases));
        TEST_ASSERT_DOUBLE_WITHIN(2.0 * TOLERANCE, (double)phases.a - zero, (double)back.a);
        TEST_ASSERT_DOUBLE_WITHIN(2.0 * TOLERANCE, (double)phases.b - zero, (double)back.b);
        TEST_ASSERT_DOUBLE_WITHIN(2.0 * TOLERANCE, (double)phases.c - zero, (double)back.c);
    }
}

static void test_park_is_a_turn_backwards_and_its_inverse_forwards(void)
{
    for (int k = 0; k < PHASES_COUNT; k++) {
        ab_t stationary = {PHASES[k].a, PHASES[k].b};
        double complex vector = of_ab(stationary);
        for (int degree = -180; degree < 180; degree += 15) {
            double angle = degree * PI / 180.0;
            rotation_t rotation = rotation_of(angle);

            dq_t rotor = frames_park(stationary, rotation);
            double complex expected = vector * cexp(-J * angle);
            TEST_ASSERT_DOUBLE_WITHIN(TOLERANCE, creal(expected), (double)rotor.d);
            TEST_ASSERT_DOUBLE_WITHIN(TOLERANCE, cimag(expected), (double)rotor.q);

            dq_t same = {stationary.alpha, stationary.beta};
            ab_t turned = frames_inverse_park(same, rotation);
            expected = vector * cexp(J * angle);
            TEST_ASSERT_DOUBLE_WITHIN(TOLERANCE, creal(expected), (double)turned.alpha);
            TEST_ASSERT_DOUBLE_WITHIN(TOLERANCE, cimag(expected), (double)turned.beta);
        }
    }
}

/* The rotation from one frame to another: a vector in the one frame, rotated by it, is the same vector in
 * the other frame. */
static void test_turn_between_two_frames(void)
{
    const ab_t vector = {7.0f, -3.0f};
    for (double from = -3.1; from < 3.2; from += 0.37) {
        for (double to = -3.1; to < 3.2; to += 0.41) {
            const rotation_t turn = frames_between(rotation_of(from), rotation_of(to));
            TEST_ASSERT_DOUBLE_WITHIN(3e-7, sin(to - from), (double)turn.sin);
            TEST_ASSERT_DOUBLE_WITHIN(3e-7, cos(to - from), (double)turn.cos);
            const dq_t before = frames_park(vector, rotation_of(from));
            const dq_t after = frames_park((ab_t){before.d, before.q}, turn);
            const dq_t expected = frames_park(vector, rotation_of(to));
            TEST_ASSERT_DOUBLE_WITHIN(1e-5, (double)expected.d, (double)after.d);
            TEST_ASSERT_DOUBLE_WITHIN(1e-5, (double)expected.q, (double)after.q);
        }
    }
}
