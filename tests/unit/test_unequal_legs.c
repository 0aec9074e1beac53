/* The effect on the EMF of three legs with different voltage losses and different resistances, summed leg
 * by leg. The expected values are the differences from the mean of the legs. */
#include "medium/adapt/unequal_legs.h"
#include "tests/unit/vectors.h"

#define RATE 1.2
#define STEP 8e-4 /* [s] */

static const unequal_legs_tuning_t TUNING = {(float)RATE, (float)(1.0 / RATE), 2.0f, 0.08f, 0.3f, 0.025f,
                                             20.0f};
static unequal_legs_t legs;
static double angle; /* [rad] angle of the current */

/* The values of the three legs without their common part. */
typedef struct {
    double volt[3]; /* [V] */
    double ohm[3];  /* [ohm] */
} lost_t;

void setUp(void)
{
    memset(&legs, 0, sizeof legs);
    unequal_legs_take(&legs, &TUNING);
    angle = 0.2;
}

static double complex axis(int32_t leg)
{
    return cexp(J * (2.0 * PI / 3.0 * leg));
}

/* The part of a difference, given as a vector, that belongs to this leg. */
static double of_leg(ab_t difference, int32_t leg)
{
    return creal(of_ab(difference) * conj(axis(leg)));
}

/* The EMF without its mean: the loss beyond the assumed one, without the part that rotates with the
 * current. */
static double complex rest_of(const lost_t *lost, double complex current)
{
    const double volt = (lost->volt[0] + lost->volt[1] + lost->volt[2]) / 3.0;
    const double ohm = (lost->ohm[0] + lost->ohm[1] + lost->ohm[2]) / 3.0;
    double complex rest = 0.0;
    for (int32_t leg = 0; leg < 3; leg++) {
        const double i = creal(current * conj(axis(leg)));
        const double more = lost->volt[leg] - volt - of_leg(legs.voltage.used, leg);
        const double resistance = lost->ohm[leg] - ohm - of_leg(legs.resistance.used, leg);
        rest += 2.0 / 3.0 * axis(leg) * (more * (i < 0.0 ? -1.0 : 1.0) + resistance * i);
    }
    return rest;
}

static void turn(const lost_t *lost, double amplitude, double omega, double seconds)
{
    for (int32_t n = 0; n < (int32_t)(seconds / STEP + 0.5); n++) {
        angle += omega * STEP;
        const double complex current = amplitude * cexp(J * angle);
        const double complex rest = rest_of(lost, current);
        const unequal_legs_input_t input = {to_ab(rest), to_ab(current), (float)STEP, 1.0f};
        unequal_legs_step(&legs, &input);
    }
}

static void expect(const lost_t *lost, double volt_within, double ohm_within)
{
    const double volt = (lost->volt[0] + lost->volt[1] + lost->volt[2]) / 3.0;
    const double ohm = (lost->ohm[0] + lost->ohm[1] + lost->ohm[2]) / 3.0;
    for (int32_t leg = 0; leg < 3; leg++) {
        TEST_ASSERT_DOUBLE_WITHIN(volt_within, lost->volt[leg] - volt, of_leg(legs.voltage.used, leg));
        TEST_ASSERT_DOUBLE_WITHIN(ohm_within, lost->ohm[leg] - ohm, of_leg(legs.resistance.used, leg));
    }
}

/* Voltage and resistance are distinguished for each leg by itself, at one speed and one current. */
static void test_voltage_and_resistance_of_a_leg_are_distinguished(void)
{
    static const lost_t cases[] = {
        {{0.5, 0.0, 0.0}, {0.0, 0.0, 0.0}}, {{0.0, 0.5, 0.0}, {0.0, 0.0, 0.0}},
        {{0.0, 0.0, 0.0}, {0.2, 0.0, 0.0}}, {{0.0, 0.0, 0.0}, {0.0, 0.0, -0.2}},
        {{0.5, 0.0, 0.0}, {0.2, 0.0, 0.0}}, {{0.3, -0.4, 0.1}, {0.0, 0.1, 0.2}},
    };
    for (size_t n = 0; n < 2u * sizeof cases / sizeof cases[0]; n++) {
        setUp();
        turn(&cases[n / 2u], 3.0, n % 2u != 0u ? -42.0 : 42.0, 60.0);
        expect(&cases[n / 2u], 0.015, 0.01);
    }
}

static void test_equal_legs_and_what_noise_may_make_are_not_used(void)
{
    static const lost_t little = {{0.06, 0.0, 0.0}, {0.02, 0.0, 0.0}};
    turn(&little, 3.0, 42.0, 0.5);
    TEST_ASSERT_TRUE(legs.voltage.seen.alpha > 0.002f && legs.resistance.seen.alpha > 0.001f);
    TEST_ASSERT_TRUE(legs.voltage.used.alpha == 0.0f && legs.voltage.used.beta == 0.0f);
    TEST_ASSERT_TRUE(legs.resistance.used.alpha == 0.0f && legs.resistance.used.beta == 0.0f);
}

static void test_limits(void)
{
    static const lost_t much = {{30.0, 0.0, 0.0}, {9.0, 0.0, 0.0}};
    turn(&much, 3.0, 42.0, 60.0);
    const float volt = legs.voltage.seen.alpha;
    const float ohm = legs.resistance.seen.alpha;
    TEST_ASSERT_TRUE(volt > 0.5f * TUNING.voltage_max && volt <= TUNING.voltage_max);
    TEST_ASSERT_TRUE(ohm > 0.5f * TUNING.resistance_max && ohm <= TUNING.resistance_max);
}

static void test_off_forgets_them_and_other_coefficients_do_not(void)
{
    static const lost_t lost = {{0.5, 0.0, 0.0}, {0.2, 0.0, 0.0}};
    turn(&lost, 3.0, 42.0, 20.0);
    const unequal_legs_t before = legs;
    unequal_legs_tuning_t tuning = TUNING;
    tuning.resistance_max = 0.4f;
    unequal_legs_take(&legs, &tuning);
    TEST_ASSERT_EQUAL_FLOAT(before.voltage.used.alpha, legs.voltage.used.alpha);
    TEST_ASSERT_EQUAL_FLOAT(before.rate, legs.rate);
    tuning.rate = 0.0f;
    unequal_legs_take(&legs, &tuning);
    TEST_ASSERT_TRUE(legs.voltage.used.alpha == 0.0f && legs.voltage.seen.alpha == 0.0f);
    TEST_ASSERT_TRUE(legs.resistance.used.alpha == 0.0f && legs.resistance.seen.alpha == 0.0f);
    unequal_legs_take(&legs, &TUNING);
    TEST_ASSERT_EQUAL_FLOAT((float)RATE, legs.rate);
}
