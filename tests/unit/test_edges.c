/* The expected values are computed from the period piece by piece. A leg is on at both ends of the period
 * and off in the middle; each edge is early or late by half of T_e, depending on its current. In the dead
 * band of the tested leg, which carries no current, the voltage is the mean of both levels. Currents are
 * the integrals of these voltages and of an EMF that rotates. */
#include "fast/inverter/edges.h"

#include "tests/unit/compare.h"

#define PERIOD     1e-4    /* [s] */
#define INDUCTANCE 12.5e-3 /* [H] */
#define EFFECTIVE  0.023   /* [-] T_e/T */
#define LINK       311.0   /* [V] */

/* A zone in which all currents are proportional to their signs [A]. */
#define WIDE 20.0

/* The limit is a dozen roundings of a sign near 1, and the time after the middle of the dead time in which
 * the current counts, (EFFECTIVE z/(3 w)) of the current that a link voltage causes in a period, with z = 19
 * mA. */
#define AMPERE_TOLERANCE                                                                                     \
    (12.0 / 16777216.0 * WIDE + EFFECTIVE * 0.0191 / (3.0 * WIDE) * LINK * PERIOD / INDUCTANCE)

/* The states of three legs in a period; times are in periods. */
typedef struct {
    double duty[3]; /* [-] duty in the compare registers */
    double sign[3]; /* [-] sign of the currents */
    double emf;     /* [V] length of the EMF and the voltage drop at the resistance */
    double phase;   /* [rad] phase of the EMF of the first leg in the middle of the period */
    double turn;    /* [rad] rotation of the EMF in a period, > 0 */
    int upper;      /* switches that are on at both ends: 1 for the upper ones, 0 for the lower ones */
} legs_t;

static double share_of(const legs_t *legs, int leg)
{
    return legs->upper ? legs->duty[leg] : 1.0 - legs->duty[leg];
}

static double way_of(const legs_t *legs)
{
    return legs->upper ? 1.0 : -1.0;
}

/* The time from 0 to `time` for which the sampled switch of this leg has been on. Its edges are late or
 * early by half of T_e, which reduces the voltage of a current that flows out of the leg. If the sign is
 * 0, the edge is in the middle of the dead band. */
static double on_until(const legs_t *legs, int leg, double time)
{
    const double band = EFFECTIVE;
    const double falls = 0.5 * share_of(legs, leg);
    const double rises = 1.0 - falls;
    const double late = way_of(legs) * legs->sign[leg] * 0.5 * band;
    if (legs->sign[leg] != 0.0) {
        return fmin(time, falls - late) + fmax(0.0, time - (rises + late));
    }
    const double begun = fmin(fmax(time - (falls - 0.5 * band), 0.0), band);
    const double ended = fmin(fmax(time - (rises - 0.5 * band), 0.0), band);
    return fmin(time, falls - 0.5 * band) + 0.5 * (begun + ended) + fmax(0.0, time - (rises + 0.5 * band));
}

/* The integral of the EMF of a leg until `time` [V]. */
static double emf_until(const legs_t *legs, int leg, double time)
{
    const double middle = legs->phase - leg * 2.0943951023931953;
    const double begin = middle - 0.5 * legs->turn;
    return legs->emf / legs->turn * (sin(begin + legs->turn * time) - sin(begin));
}

/* The current of a leg at `time` after the beginning of the period [A]. */
static double current_at(const legs_t *legs, int leg, double time)
{
    double mean = 0.0;
    for (int x = 0; x < 3; x++) {
        mean += on_until(legs, x, time) / 3.0;
    }
    const double volts =
        way_of(legs) * LINK * (on_until(legs, leg, time) - mean) - emf_until(legs, leg, time);
    return PERIOD / INDUCTANCE * volts;
}

/* Currents [A] minus the mean of the samples, in the direction of the sampled switches. */
typedef struct {
    double first[3], second[3];
} currents_t;

/* From the signs of a zone so wide that they are proportional to the currents. */
static currents_t currents_of(const legs_t *legs)
{
    const edges_tuning_t edges = edges_prepare((float)PERIOD, (float)INDUCTANCE, 0.0f, legs->upper != 0);
    const abc_t duty = {(float)legs->duty[0], (float)legs->duty[1], (float)legs->duty[2]};
    const abc_t change = {(float)current_at(legs, 0, 1.0), (float)current_at(legs, 1, 1.0),
                          (float)current_at(legs, 2, 1.0)};
    const float twice = (float)(2.0 * way_of(legs));
    const abc_t last = {twice * (float)legs->sign[0], twice * (float)legs->sign[1],
                        twice * (float)legs->sign[2]};
    const edges_t before = {last, last};
    const ab_t none = {0.0f, 0.0f};
    const edges_t signs = edges_signs(&edges, &before, (float)(1.0 / WIDE), duty, none, frames_clarke(change),
                                      (float)EFFECTIVE, (float)(legs->turn / PERIOD), (float)LINK);
    const abc_t *const first = &signs.first;
    const abc_t *const second = &signs.second;
    const double half = 0.5 * WIDE;
    return (currents_t){{half * (double)first->a, half * (double)first->b, half * (double)first->c},
                        {half * (double)second->a, half * (double)second->b, half * (double)second->c}};
}

/* Tested for all duties, with an EMF of this rotation, and with one leg after the other without current.
 * The comparison is made in the middle of the dead band. The model has the parabola of a rotating EMF at a
 * duty of 1/2; the neglected terms are below turn^2/12 of the parabola, and turn^2/8 of the odd part. */
static void expect_currents_at_the_edges(double turn)
{
    double largest[2] = {0.0, 0.0};
    double bent = 0.0;
    for (int n = 0; n < 2 * 89; n++) {
        const double angle = 0.07 * (n / 2);
        for (double length = 0.0; length < 0.5; length += 0.09) {
            for (int leg = 0; leg < 3; leg++) {
                legs_t legs = {
                    .emf = 0.8 * length * LINK, .phase = angle + 0.3, .turn = turn, .upper = n % 2};
                for (int x = 0; x < 3; x++) {
                    legs.duty[x] = 0.5 + length * cos(angle - x * 2.0943951023931953);
                    legs.sign[x] = x == leg ? 0.0 : x == (leg + 1) % 3 ? 1.0 : -1.0;
                }
                const currents_t currents = currents_of(&legs);
                const double swing = 0.5 * (currents.second[leg] - currents.first[leg]);
                const double bend = -0.5 * way_of(&legs) * (currents.second[leg] + currents.first[leg]);
                const double rest = 1.0 - share_of(&legs, leg);
                const double falling = current_at(&legs, leg, 0.5 * share_of(&legs, leg));
                const double rising = current_at(&legs, leg, 1.0 - 0.5 * share_of(&legs, leg));
                const double sides = 0.5 * current_at(&legs, leg, 1.0);
                /* [A] change of the current in a period by the EMF. */
                const double amperes = PERIOD / INDUCTANCE * legs.emf;
                TEST_ASSERT_DOUBLE_WITHIN(AMPERE_TOLERANCE + amperes * turn * turn * turn / 96.0 +
                                              amperes * turn / 8.0 * fabs(rest * rest - 0.25),
                                          bend, sides - 0.5 * (rising + falling));
                TEST_ASSERT_DOUBLE_WITHIN(AMPERE_TOLERANCE + amperes * turn * turn / 48.0,
                                          0.5 * (rising - falling), way_of(&legs) * swing);
                largest[n % 2] = fmax(largest[n % 2], fabs(swing));
                bent = fmax(bent, fabs(bend));
            }
        }
    }
    TEST_ASSERT_TRUE(largest[0] > 0.1 && largest[1] > 0.1); /* [A] the currents are not zero */
    TEST_ASSERT_TRUE(bent > 0.08 * turn);
}

static void test_currents_at_the_edges_whichever_switches_are_on_at_the_sample(void)
{
    expect_currents_at_the_edges(1e-6);
}

static void test_an_emf_that_turns_within_the_period_moves_both_edges_alike(void)
{
    expect_currents_at_the_edges(0.3);
    expect_currents_at_the_edges(0.6);
}

static edges_t signs_at(double middle, double change, double late, const edges_t *last)
{
    const edges_tuning_t edges = edges_prepare((float)PERIOD, (float)INDUCTANCE, (float)late, true);
    const abc_t half = {0.5f, 0.5f, 0.5f};
    const ab_t mean = {(float)middle, 0.0f};
    const ab_t step = {(float)change, 0.0f};
    return edges_signs(&edges, last, 1.0f, half, mean, step, (float)EFFECTIVE, 0.0f, (float)LINK);
}

static const edges_t UNKNOWN = {{0.0f, 0.0f, 0.0f}, {0.0f, 0.0f, 0.0f}};

/* Beyond the zone of 1 A the signs are certain: twice 1 for the leg with all of the current, twice -1 for
 * those with half of it each. */
static void test_large_currents_have_certain_signs(void)
{
    const edges_t signs = signs_at(4.0, 0.0, 0.0, &UNKNOWN);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 2.0, (double)signs.first.a);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, -2.0, (double)signs.first.b);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 2.0, (double)signs.second.a);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, -2.0, (double)signs.second.c);
}

/* Edges that are late by 2 us of 100 us see 2 % more of the change of 0.5 A in a period: twice 0.01 of the
 * zone. */
static void test_late_edges_see_the_current_go_on(void)
{
    const edges_t now = signs_at(0.2, 0.5, 0.0, &UNKNOWN);
    const edges_t later = signs_at(0.2, 0.5, 2e-6, &UNKNOWN);
    TEST_ASSERT_DOUBLE_WITHIN(1e-5, 0.02, (double)(later.first.a - now.first.a));
    TEST_ASSERT_DOUBLE_WITHIN(1e-5, 0.02, (double)(later.second.a - now.second.a));
}

/* A leg that lost half of T_e more at its first edge than at the second one, with signs 1/2 and -1/2, has
 * z/4 less current at both edges at a duty of 1/2: z is 19.1 mA. */
static void test_different_signs_at_the_two_edges_shift_both(void)
{
    const edges_t last = {{1.0f, 0.0f, 0.0f}, {-1.0f, 0.0f, 0.0f}};
    const edges_t equal = signs_at(0.0, 0.0, 0.0, &UNKNOWN);
    const edges_t shifted = signs_at(0.0, 0.0, 0.0, &last);
    const double z = EFFECTIVE * LINK * PERIOD / (3.0 * INDUCTANCE);
    TEST_ASSERT_DOUBLE_WITHIN(1e-5, -0.25 * z * 2.0, (double)(shifted.first.a - equal.first.a));
    TEST_ASSERT_DOUBLE_WITHIN(1e-5, -0.25 * z * 2.0, (double)(shifted.second.a - equal.second.a));
}
