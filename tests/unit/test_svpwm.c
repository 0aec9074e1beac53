/* The expected values come from the space vector of three pole voltages d u_dc in double precision, and
 * from the hexagon of its range. */
#include "fast/inverter/svpwm.h"
#include "tests/unit/sweep.h"
#include "tests/unit/vectors.h"

/* The limit is five roundings of 2^-24 each of numbers up to 311 V and 1. */
#define VOLT_TOLERANCE (5.0 * 311.0 / 16777216.0)
#define DUTY_TOLERANCE (5.0 / 16777216.0)

static svpwm_t modulate(ab_t voltage, float u_dc, float duty_min, float duty_max)
{
    const svpwm_tuning_t tuning = svpwm_prepare(duty_min, duty_max, false);
    return svpwm_modulate(&tuning, voltage, u_dc);
}

static double complex vector_of(abc_t duty, double u_dc)
{
    double complex third = cexp(J * 2.0 * PI / 3.0);
    return 2.0 / 3.0 * u_dc * ((double)duty.a + (double)duty.b * third + (double)duty.c * third * third);
}

static ab_t polar(double length, double angle)
{
    ab_t voltage = {(float)(length * cos(angle)), (float)(length * sin(angle))};
    return voltage;
}

/* The longest vector in this direction whose phase voltages span at most `volts`. In a sector of 60
 * degrees the largest phase-to-phase voltage is sqrt(3) |v| cos(angle to its middle). */
static double hexagon(double angle, double volts)
{
    double sector = fmod(angle + 4.0 * PI, PI / 3.0);
    return volts / (sqrt(3.0) * cos(sector - PI / 6.0));
}

static double highest_of(abc_t duty)
{
    return (double)fmaxf(duty.a, fmaxf(duty.b, duty.c));
}

static double lowest_of(abc_t duty)
{
    return (double)fminf(duty.a, fminf(duty.b, duty.c));
}

static void sweep(double u_dc, float duty_min, float duty_max)
{
    double volts = ((double)duty_max - (double)duty_min) * u_dc;
    double middle = ((double)duty_max + (double)duty_min) / 2.0;
    for (double angle = -PI; angle<PI; angle += SWEEP> 1 ? 0.101 : 0.0101) {
        for (double part = 0.0; part < 3.0; part += 0.0999) {
            double length = part * volts / sqrt(3.0);
            ab_t wanted = polar(length, angle);
            svpwm_t result = modulate(wanted, (float)u_dc, duty_min, duty_max);

            TEST_ASSERT_TRUE(highest_of(result.duty) <= (double)duty_max);
            TEST_ASSERT_TRUE(lowest_of(result.duty) >= (double)duty_min);
            TEST_ASSERT_DOUBLE_WITHIN(2.0 * DUTY_TOLERANCE, 2.0 * middle,
                                      highest_of(result.duty) + lowest_of(result.duty));

            double complex applied = vector_of(result.duty, u_dc);
            TEST_ASSERT_DOUBLE_WITHIN(VOLT_TOLERANCE, 0.0, cabs(applied - of_ab(result.voltage)));

            double reachable = hexagon(angle, volts);
            double complex expected = (length < reachable ? length : reachable) * cexp(J * angle);
            /* The direction of the request is itself rounded: by 2^-24 of its length, reduced with it. */
            TEST_ASSERT_DOUBLE_WITHIN(2.0 * VOLT_TOLERANCE, 0.0, cabs(applied - expected));
        }
    }
}

static void test_any_vector_is_made_or_cut_in_its_direction(void)
{
    sweep(311.0, 0.0f, 1.0f);
    sweep(311.0, 0.04f, 0.96f);
    sweep(311.0, 0.1f, 0.7f);
    sweep(24.0, 0.0f, 1.0f);
}

/* A voltage that is possible comes back bit for bit; a longer one is limited in exactly the direction of
 * the request. */
static void test_voltage_is_a_share_of_the_request(void)
{
    for (double angle = -3.1; angle < 3.2; angle += 0.1) {
        const double edge = hexagon(angle, 0.92 * 311.0);
        const ab_t inside = polar(0.999 * edge, angle);
        const svpwm_t whole = modulate(inside, 311.0f, 0.04f, 0.96f);
        TEST_ASSERT_TRUE(whole.voltage.alpha == inside.alpha && whole.voltage.beta == inside.beta);
        for (double times = 1.01; times < 1e6; times *= 10.0) {
            const ab_t wanted = polar(times * edge, angle);
            const double complex cut = of_ab(modulate(wanted, 311.0f, 0.04f, 0.96f).voltage);
            const double complex share = cut / of_ab(wanted);
            TEST_ASSERT_DOUBLE_WITHIN(1e-6 / times, 1.0 / times, creal(share));
            TEST_ASSERT_DOUBLE_WITHIN(1e-7 / times, 0.0, cimag(share));
        }
    }
}

static void test_invalid_input_gives_half_duties_and_no_voltage(void)
{
    static const float cases[][3] = {
        {10.0f, 5.0f, 0.0f},        {10.0f, 5.0f, -0.0f},      {10.0f, 5.0f, -311.0f},
        {10.0f, 5.0f, NAN},         {10.0f, 5.0f, INFINITY},   {10.0f, 5.0f, -INFINITY},
        {10.0f, 5.0f, 1e-38f},      {NAN, 5.0f, 311.0f},       {10.0f, NAN, 311.0f},
        {INFINITY, 5.0f, 311.0f},   {-INFINITY, 5.0f, 311.0f}, {10.0f, INFINITY, 311.0f},
        {10.0f, -INFINITY, 311.0f}, {1.1e30f, 0.0f, 311.0f},   {0.0f, -1.1e30f, 311.0f},
        {0.0f, 0.0f, NAN},
    };
    for (unsigned k = 0; k < sizeof cases / sizeof cases[0]; k++) {
        ab_t voltage = {cases[k][0], cases[k][1]};
        svpwm_t result = modulate(voltage, cases[k][2], 0.04f, 0.96f);
        TEST_ASSERT_TRUE(result.duty.a == 0.5f && result.duty.b == 0.5f && result.duty.c == 0.5f);
        TEST_ASSERT_TRUE(result.voltage.alpha == 0.0f && result.voltage.beta == 0.0f);
    }
}

static void test_extremes_inside_the_range_stay_finite_and_inside(void)
{
    static const float cases[][3] = {{1e30f, -1e30f, 311.0f},
                                     {10.0f, 5.0f, 1e-37f},
                                     {1e-30f, 1e-36f, 311.0f},
                                     {1e30f, 1e30f, 1e-37f},
                                     {1.0f, 1.0f, 1e30f}};
    for (unsigned k = 0; k < sizeof cases / sizeof cases[0]; k++) {
        ab_t voltage = {cases[k][0], cases[k][1]};
        for (int over = 0; over < 2; over++) {
            const svpwm_tuning_t tuning = svpwm_prepare(0.04f, 0.96f, over != 0);
            svpwm_t result = svpwm_modulate(&tuning, voltage, cases[k][2]);
            TEST_ASSERT_TRUE(highest_of(result.duty) <= (double)0.96f &&
                             lowest_of(result.duty) >= (double)0.04f);
            TEST_ASSERT_TRUE(isfinite(result.voltage.alpha) && isfinite(result.voltage.beta));
        }
    }
}

/* ---- over-modulation ---- */

static svpwm_t over(double share, double angle)
{
    const svpwm_tuning_t tuning = svpwm_prepare(0.04f, 0.96f, true);
    return svpwm_modulate(&tuning, polar(share * 0.92 * 311.0, angle), 311.0f);
}

/* The fundamental divided by range u_dc, by integration. The legs are driven beyond their range by a sine
 * of the amplitude a range u_dc, less the mean of the two extreme legs. Up to 2/3 there is one clipped
 * interval of +-d around 30 degrees, cos d = 1/(sqrt(3) a); beyond, there is one from zero to acos(1/(3
 * a)). Six-step has 2/pi. */
static double clipped(double a)
{
    if (a <= 1.0 / sqrt(3.0)) {
        return a;
    }
    if (a <= 2.0 / 3.0) {
        const double half = acos(1.0 / (sqrt(3.0) * a));
        return a - 3.0 * a / PI * half + sqrt(3.0) / PI * sin(half);
    }
    const double c = 1.0 / (3.0 * a);
    return (sqrt(1.0 - c * c) + asin(c) / c) / PI;
}

#define ANGLES 3600

/* The fundamental [-] of range u_dc that requests of one length make over a turn. */
static double complex fundamental(double share)
{
    double complex sum = 0.0;
    for (int k = 0; k < ANGLES; k++) {
        const double angle = 2.0 * PI * (k + 0.5) / ANGLES;
        const svpwm_t made = over(share, angle);
        TEST_ASSERT_TRUE(highest_of(made.duty) <= (double)0.96f && lowest_of(made.duty) >= (double)0.04f);
        const double complex voltage = vector_of(made.duty, 311.0);
        TEST_ASSERT_DOUBLE_WITHIN(2.0 * VOLT_TOLERANCE, 0.0, cabs(voltage - of_ab(made.voltage)));
        sum += voltage * cexp(-J * angle);
    }
    return sum / (ANGLES * 0.92 * 311.0);
}

/* A leg that is neither the highest nor the lowest has 3/2 of the voltage of its phase: its duty shows the
 * amplitude to which the request has been changed. */
static void test_overmodulation_follows_the_known_curve_up_to_six_step(void)
{
    for (double share = 0.5; share < 0.99 * 2.0 / PI; share += 0.001 * SWEEP_FEW) {
        const double angle = 89.9 * PI / 180.0;
        const double a = ((double)over(share, angle).duty.a - 0.5) / (1.5 * 0.92 * cos(angle));
        const double complex made = fundamental(share);
        TEST_ASSERT_DOUBLE_WITHIN(2e-4, clipped(a), creal(made));
        TEST_ASSERT_DOUBLE_WITHIN(5e-3 * share, share, creal(made));
        TEST_ASSERT_DOUBLE_WITHIN(1e-5, 0.0, cimag(made));
    }
    TEST_ASSERT_DOUBLE_WITHIN(0.003, 0.9985 * 2.0 / PI, creal(fundamental(1.0)));
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, 2.0 / PI, creal(fundamental(10.0)));
}

static void test_overmodulation_leaves_the_linear_range_as_requested(void)
{
    for (double angle = -3.1; angle < 3.2; angle += 0.1) {
        const ab_t wanted = polar(0.99999 / sqrt(3.0) * 0.92 * 311.0, angle);
        const svpwm_t made = over(0.99999 / sqrt(3.0), angle);
        TEST_ASSERT_TRUE(made.voltage.alpha == wanted.alpha && made.voltage.beta == wanted.beta && !made.cut);
        TEST_ASSERT_DOUBLE_WITHIN(2.0 * VOLT_TOLERANCE, 0.0,
                                  cabs(vector_of(made.duty, 311.0) - of_ab(wanted)));
    }
}
