/* The expected values come from three legs in double precision. A leg loses its share of dead time and
 * drops against its current, half at each of its edges, linearly within the zone. Its duty is the nearest
 * whole count. The remaining voltage acts two steps later. */
#include "fast/inverter/inverter.h"
#include "tests/unit/sweep.h"
#include "tests/unit/vectors.h"

#define COUNTS     7500
#define DUTY_MIN   0.04
#define DUTY_MAX   0.96
#define INDUCTANCE 12.5e-3 /* [H] */
#define EFFECTIVE  0.023   /* T_e/T [-] */
#define TURN       0.4     /* [rad] rotation of the EMF in a period */
#define OMEGA_E    ((float)(TURN / 1e-4))

/* T_e = 2.5 + 0.7 - 0.9 = 2.3 us of 100 us. */
static const inverter_params_t PARAMS = {
    .dead_time = {.dead_time = 2.5e-6f,
                  .turn_on_delay = 0.7e-6f,
                  .turn_off_delay = 0.9e-6f,
                  .drop = 0.875f,
                  .current_zone = 0.4f,
                  .period = 1e-4f},
    .compensated = 1.0f,
    .inductance = (float)INDUCTANCE,
    .sampled_upper = true,
    .duty_min = (float)DUTY_MIN,
    .duty_max = (float)DUTY_MAX,
    .duty_counts = COUNTS,
};

/* The limit is eight roundings of voltages up to 400 V. */
#define VOLT_TOLERANCE (8.0 * 400.0 / 16777216.0)

static const ab_t NONE = {0.0f, 0.0f};

/* Signs of the legs at their two edges in the last period. */
static double signs[2][3];

static inverter_t inverter;
static inverter_tuning_t tuning;

static void begin(float gain)
{
    inverter_params_t params = PARAMS;
    params.compensated = gain;
    tuning = inverter_prepare(&params);
    memset(&inverter, 0x55, sizeof inverter);
    inverter_init(&inverter);
    memset(signs, 0, sizeof signs);
}

void setUp(void)
{
    begin(1.0f);
}

static double complex vector_of(const double phases[3])
{
    double complex sum = 0.0;
    for (int phase = 0; phase < 3; phase++) {
        sum += 2.0 / 3.0 * phases[phase] * cexp(J * (2.0 * PI / 3.0 * phase));
    }
    return sum;
}

static double complex duties_of(abc_t duty)
{
    const double phases[3] = {(double)duty.a, (double)duty.b, (double)duty.c};
    return vector_of(phases);
}

/* The loss [V] of a leg whose current has a certain sign. */
static double leg_at(double u_dc)
{
    return 0.023 * u_dc + 0.875;
}

static double sign_of(double current)
{
    return fmax(-1.0, fmin(1.0, current / 0.4));
}

/* The loss if the current is the same at both edges of a leg. */
static double complex lost_at(double complex current, double u_dc)
{
    double lost[3];
    for (int phase = 0; phase < 3; phase++) {
        lost[phase] = leg_at(u_dc) * sign_of(phase_of(current, phase));
    }
    return vector_of(lost);
}

/* The loss if each edge has the current that flows at these duties: docs/theory.md, 12. Edges are late by
 * half of 2.5 + 0.7 + 0.9 us. tests/unit/test_edges.c compares these currents with an integration. */
static double complex lost_between(const abc_t *duties, double complex before, double complex now,
                                   double u_dc)
{
    const double made[3] = {(double)duties->a, (double)duties->b, (double)duties->c};
    const double ampere = u_dc * 1e-4 / INDUCTANCE;
    const double after = EFFECTIVE * (ampere * EFFECTIVE / 3.0) / (3.0 * 0.4);
    double acts[2][3], mean[2] = {0.0, 0.0}, free[3], lost[3], next[2][3];
    const double left = fmax(0.0, 1.0 - pow(cabs(now - before) / 0.4, 2.0));
    for (int edge = 0; edge < 2; edge++) {
        for (int leg = 0; leg < 3; leg++) {
            const double sign = 0.5 * ((1.0 + left) * signs[edge][leg] + (1.0 - left) * signs[1 - edge][leg]);
            acts[edge][leg] = made[leg] - EFFECTIVE * sign;
            mean[edge] += acts[edge][leg] / 3.0;
        }
    }
    for (int leg = 0; leg < 3; leg++) {
        const double u = 0.5 * (acts[0][leg] - mean[0] + acts[1][leg] - mean[1]);
        free[leg] = 0.5 * (phase_of(now - before, leg) - ampere * u);
    }
    for (int leg = 0; leg < 3; leg++) {
        /* (j f) of a leg is the difference of the other two over sqrt(3) */
        const double across = (free[(leg + 2) % 3] - free[(leg + 1) % 3]) / sqrt(3.0);
        const double rest = 1.0 - made[leg];
        const double current = 0.5 * phase_of(now + before, leg) - 0.1875 * TURN * across +
                               2.0 * 0.5 * (2.5 + 0.7 + 0.9) / 100.0 * free[leg];
        double apart[2] = {0.0, 0.0};
        for (int x = 0; x < 3; x++) {
            if (x != leg) {
                const double y = 0.5 * (acts[0][x] + acts[1][x]) - made[leg];
                apart[0] += 0.5 * (fabs(y) + fabs(y - 2.0 * after));
                apart[1] += 0.5 * (fabs(y) + fabs(y + 2.0 * after));
            }
        }
        next[0][leg] =
            sign_of(current - rest * free[leg] -
                    ampere * (0.25 * (acts[1][leg] - mean[1]) + EFFECTIVE / 6.0 - apart[0] / 12.0));
        next[1][leg] =
            sign_of(current + rest * free[leg] +
                    ampere * (0.25 * (acts[0][leg] - mean[0]) + EFFECTIVE / 6.0 - apart[1] / 12.0));
        lost[leg] = 0.5 * leg_at(u_dc) * (next[0][leg] + next[1][leg]);
    }
    memcpy(signs, next, sizeof signs);
    return vector_of(lost);
}

/* The longest voltage in this direction: a phase-to-phase voltage of 0.92 u_dc. */
static double longest(double angle, double u_dc)
{
    return (DUTY_MAX - DUTY_MIN) * u_dc / (sqrt(3.0) * cos(fmod(angle + 4.0 * PI, PI / 3.0) - PI / 6.0));
}

/* ---- from a voltage to duties ---- */

/* The ideal duty of each leg; the highest and the lowest are symmetric about the middle. The nearest count
 * that a register can hold is within half a count and the rounding of a float (7500 x 6e-8). */
static void expect_nearest_counts(double complex asked, double u_dc, abc_t duty)
{
    const double made[3] = {(double)duty.a, (double)duty.b, (double)duty.c};
    double highest = -1e9;
    double lowest = 1e9;
    for (int leg = 0; leg < 3; leg++) {
        highest = fmax(highest, phase_of(asked, leg));
        lowest = fmin(lowest, phase_of(asked, leg));
    }
    for (int leg = 0; leg < 3; leg++) {
        const double ideal = 0.5 + (phase_of(asked, leg) - 0.5 * (highest + lowest)) / u_dc;
        const double count = made[leg] * COUNTS;
        TEST_ASSERT_DOUBLE_WITHIN(1e-3, nearbyint(count), count);
        TEST_ASSERT_DOUBLE_WITHIN(0.5 + 6e-3, ideal * COUNTS, count);
    }
}

/* Voltages and currents in all directions, with currents within the zone and beyond it. */
static void test_duties_make_up_for_the_share_of_the_loss_that_is_compensated(void)
{
    const double stride = SWEEP > 1 ? 0.51 : 0.17;
    for (double gain = 0.0; gain <= 1.0; gain += 1.0) {
        int odd = 0;
        begin((float)gain);
        for (double angle = -3.1; angle < 3.1; angle += stride) {
            for (double amperes = 0.0; amperes < 10.0; amperes += 0.3) {
                const double complex wanted = 100.0 * cexp(J * angle);
                const double complex current = amperes * cexp(J * (angle + 0.6));
                const double u_dc = 311.0 - 3.0 * amperes;
                const inverter_made_t made =
                    inverter_make(&tuning, to_ab(wanted), to_ab(current), (float)leg_at(u_dc), (float)u_dc);
                expect_nearest_counts(wanted + gain * lost_at(current, u_dc), u_dc, made.duty);
                TEST_ASSERT_TRUE(made.missing.alpha == 0.0f && made.missing.beta == 0.0f);
                odd += (int)nearbyint((double)made.duty.a * COUNTS) & 1;
            }
        }
        TEST_ASSERT_TRUE(odd > 100); /* odd counts occur in enough of the 1258 or 442 cases */
    }
}

/* The limit applies to the requested voltage including the losses: below it, at it, above it. */
static void test_what_the_link_has_too_little_for_is_missing(void)
{
    static const double shares[] = {0.9, 0.999, 1.001, 1.2, 5.0};
    for (double angle = -3.1; angle < 3.1; angle += 0.17) {
        for (unsigned n = 0; n < sizeof shares / sizeof shares[0]; n++) {
            const double complex lost = lost_at(3.0 * J, 311.0);
            const double reach = longest(angle, 311.0);
            const double complex asked = shares[n] * reach * cexp(J * angle);
            const inverter_made_t made =
                inverter_make(&tuning, to_ab(asked - lost), to_ab(3.0 * J), (float)leg_at(311.0), 311.0f);
            const double complex missing = fmin(0.0, 1.0 - shares[n]) * reach * cexp(J * angle);
            TEST_ASSERT_DOUBLE_WITHIN(VOLT_TOLERANCE * fmax(1.0, shares[n]), 0.0,
                                      cabs(of_ab(made.missing) - missing));
            /* The duties agree with this: each is within half a count of 41 mV of the ideal one, which
             * makes 4/3 of that at most. */
            TEST_ASSERT_DOUBLE_WITHIN(4.0 / 3.0 * 0.5 * 311.0 / COUNTS + 1e-3, 0.0,
                                      cabs(duties_of(made.duty) * 311.0 - (asked + missing)));
        }
    }
}

/* ---- from duties to the voltage that acted ---- */

static void test_nothing_has_acted_at_first(void)
{
    const inverter_acted_t acted =
        inverter_acted(&inverter, &tuning, (float)EFFECTIVE, 2.5f, NONE, 0.0f, 311.0f);
    TEST_ASSERT_TRUE(acted.voltage.alpha == 0.0f && acted.voltage.beta == 0.0f);
    TEST_ASSERT_TRUE(acted.current.alpha == 0.0f && acted.current.beta == 0.0f);
}

typedef struct {
    abc_t duty;             /* duties that the step has returned */
    double complex current; /* [A] current at the sample of the step */
    double u_dc;            /* [V] link at the sample of the step */
} period_t;

static period_t period_of(int k)
{
    const float a = (float)(0.5 + 0.4 * sin(0.7 * k));
    return (period_t){.duty = {a, (float)(0.5 + 0.3 * sin(1.1 * k)), 1.0f - a},
                      .current = 2.0 * cexp(J * (0.37 * k)),
                      .u_dc = 311.0 + 20.0 * sin(0.9 * k)};
}

static void remember(const period_t *period)
{
    inverter_remember(&inverter, &period->duty, to_ab(period->current), (float)period->u_dc);
}

/* The whole loss acts, whatever share of it is compensated. */
static void test_duties_of_two_steps_ago_acted_less_what_the_inverter_took(void)
{
    double early = 0.0, late = 0.0, edges = 0.0;
    for (int k = 0; k < 1500; k++) {
        if (k % 500 == 0) {
            begin(0.5f * (float)(k / 500));
        }
        const period_t now = period_of(k);
        const period_t before = period_of(k - 1);
        const inverter_acted_t acted = inverter_acted(&inverter, &tuning, (float)EFFECTIVE, 2.5f,
                                                      to_ab(now.current), OMEGA_E, (float)now.u_dc);
        const double link = 0.5 * (now.u_dc + before.u_dc);
        const double complex mean = 0.5 * (now.current + before.current);
        if (k % 500 < 2) {
            memset(signs, 0, sizeof signs);
            inverter.signs = (edges_t){{0.0f, 0.0f, 0.0f}, {0.0f, 0.0f, 0.0f}};
        } else {
            const abc_t oldest = period_of(k - 2).duty;
            const double complex rest = -lost_between(&oldest, before.current, now.current, link);
            TEST_ASSERT_DOUBLE_WITHIN(VOLT_TOLERANCE, 0.0,
                                      cabs(of_ab(acted.voltage) - (duties_of(oldest) * link + rest)));
            edges = fmax(edges, cabs(rest + lost_at(mean, link)));
            TEST_ASSERT_DOUBLE_WITHIN(1e-6, 0.0, cabs(of_ab(acted.current) - mean));
            TEST_ASSERT_DOUBLE_WITHIN(2e-6, leg_at(link), (double)acted.leg);
            early = fmax(early, cabs(of_ab(acted.voltage) - (duties_of(before.duty) * link + rest)));
            late = fmax(late, cabs(of_ab(acted.voltage) - (duties_of(period_of(k - 3).duty) * link + rest)));
        }
        remember(&now);
    }
    /* The test cases have these differences, so that an error would show. */
    TEST_ASSERT_TRUE(early > 10.0 && late > 10.0 && edges > 1.0);
}

/* A drop of 1.875 V instead of 0.875 V and a third of the counts. The stored periods keep what they had. */
static void test_new_coefficients_act_at_once_on_what_stays_in_memory(void)
{
    const period_t oldest = period_of(3);
    const period_t last = period_of(4);
    remember(&oldest);
    remember(&last);
    inverter_params_t params = PARAMS;
    params.dead_time.drop = 1.875f;
    params.duty_counts = 2500.0f;
    tuning = inverter_prepare(&params);

    const period_t now = period_of(5);
    const double link = 0.5 * (now.u_dc + last.u_dc);
    const double more = 1.0 + 1.0 / leg_at(link);
    const inverter_acted_t acted = inverter_acted(&inverter, &tuning, (float)EFFECTIVE, 2.5f,
                                                  to_ab(now.current), OMEGA_E, (float)now.u_dc);
    TEST_ASSERT_DOUBLE_WITHIN(
        VOLT_TOLERANCE, 0.0,
        cabs(of_ab(acted.voltage) - (duties_of(oldest.duty) * link -
                                     more * lost_between(&oldest.duty, last.current, now.current, link))));
    TEST_ASSERT_DOUBLE_WITHIN(2e-6, leg_at(link) + 1.0, (double)acted.leg);

    const abc_t duty = inverter_make(&tuning, to_ab(50.0 + 20.0 * J), NONE, 8.0f, 311.0f).duty;
    const double count = 2500.0 * (double)duty.a;
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, nearbyint(count), count);
}
