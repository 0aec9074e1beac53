/* The expected values are computed from the period piece by piece. A leg is on at both ends of the period
 * and off in the middle; each edge is early or late by half of T_e, depending on its current. In the dead
 * band of the tested leg, which carries no current, the voltage is the mean of both levels. Currents are
 * the integrals of these voltages and of an EMF that rotates. */
#include "fast/inverter/edges.h"

#include "medium/adapt/leg_zone.h"
#include "tests/unit/compare.h"

#define PERIOD     1e-4    /* [s] */
#define INDUCTANCE 12.5e-3 /* [H] */
#define EFFECTIVE  0.023   /* [-] T_e/T */
#define LINK       311.0   /* [V] */

/* A zone in which all currents are proportional to their signs [A]. */
#define WIDE 20.0

/* The limit is a dozen roundings of a sign near 1, and the time after the middle of the dead time in which
 * half of a change counts, (EFFECTIVE z/(3 w)) of the current that a link voltage causes in a period, with
 * z = 19 mA. */
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
    const float four = (float)(4.0 * way_of(legs));
    const abc_t last = {four * (float)legs->sign[0], four * (float)legs->sign[1],
                        four * (float)legs->sign[2]};
    const edges_t before = {last, last};
    const ab_t none = {0.0f, 0.0f};
    const edges_t signs = edges_signs(&edges, &before, (float)(1.0 / WIDE), duty, none, frames_clarke(change),
                                      (float)EFFECTIVE, (float)(legs->turn / PERIOD), (float)LINK);
    const abc_t *const first = &signs.first;
    const abc_t *const second = &signs.second;
    const double quarter = 0.25 * WIDE;
    return (currents_t){
        {quarter * (double)first->a, quarter * (double)first->b, quarter * (double)first->c},
        {quarter * (double)second->a, quarter * (double)second->b, quarter * (double)second->c}};
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

/* Beyond the zone of 1 A the signs are certain: 4 times 1 for the leg with all of the current, 4 times -1 for
 * those with half of it each. */
static void test_large_currents_have_certain_signs(void)
{
    const edges_t signs = signs_at(4.0, 0.0, 0.0, &UNKNOWN);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 4.0, (double)signs.first.a);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, -4.0, (double)signs.first.b);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 4.0, (double)signs.second.a);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, -4.0, (double)signs.second.c);
}

/* Edges that are late by 2 us of 100 us see 2 % more of the change of 0.5 A in a period: 4 times 0.01 of
 * the zone. */
static void test_late_edges_see_the_current_go_on(void)
{
    const edges_t now = signs_at(0.2, 0.5, 0.0, &UNKNOWN);
    const edges_t later = signs_at(0.2, 0.5, 2e-6, &UNKNOWN);
    TEST_ASSERT_DOUBLE_WITHIN(2e-5, 0.04, (double)(later.first.a - now.first.a));
    TEST_ASSERT_DOUBLE_WITHIN(2e-5, 0.04, (double)(later.second.a - now.second.a));
}

/* A leg that lost half of T_e more at its first edge than at the second one, with signs 1/2 and -1/2, has
 * z/4 less current at both edges at a duty of 1/2: z is 19.1 mA. */
static void test_different_signs_at_the_two_edges_shift_both(void)
{
    const edges_t last = {{2.0f, 0.0f, 0.0f}, {-2.0f, 0.0f, 0.0f}};
    const edges_t equal = signs_at(0.0, 0.0, 0.0, &UNKNOWN);
    const edges_t shifted = signs_at(0.0, 0.0, 0.0, &last);
    const double z = EFFECTIVE * LINK * PERIOD / (3.0 * INDUCTANCE);
    TEST_ASSERT_DOUBLE_WITHIN(2e-5, -0.25 * z * 4.0, (double)(shifted.first.a - equal.first.a));
    TEST_ASSERT_DOUBLE_WITHIN(2e-5, -0.25 * z * 4.0, (double)(shifted.second.a - equal.second.a));
}

/* A change of the current by half of the zone of 1 A leaves 3/4 of this shift, one by the zone or more none.
 */
static void test_difference_of_the_last_period_counts_while_the_current_stays_in_the_zone(void)
{
    static const struct {
        double change, left;
    } cases[] = {{0.5, 0.75}, {1.0, 0.0}, {1.5, 0.0}};
    const edges_t last = {{2.0f, 0.0f, 0.0f}, {-2.0f, 0.0f, 0.0f}};
    const double z = EFFECTIVE * LINK * PERIOD / (3.0 * INDUCTANCE);
    for (int n = 0; n < 3; n++) {
        const edges_t equal = signs_at(0.0, cases[n].change, 0.0, &UNKNOWN);
        const edges_t shifted = signs_at(0.0, cases[n].change, 0.0, &last);
        TEST_ASSERT_DOUBLE_WITHIN(2e-5, -0.25 * z * 4.0 * cases[n].left,
                                  (double)(shifted.first.a - equal.first.a));
    }
}

/* ---- a leg whose current passes zero while the other two switch in its dead time ---- */

#define STEPS 4000 /* of a period */

/* A motor at rest, whose legs b and c have certain signs, -1 and 1. */
typedef struct {
    double inductance, zone; /* [H], [A] */
    double begin, end;       /* current of leg a at both samples [A] */
    double slope;            /* its change in a period by the resistance [A] */
    double duty[3];          /* [-] */
    double first, second;    /* mean sign of leg a in its two dead times [-] */
} passage_t;

/* Share of the time for which the output of a leg with this sign is at the positive end of the link. */
static double is_high(double time, double duty, double sign)
{
    const double on = 0.5 * (duty - EFFECTIVE * sign);
    return time < on || time > 1.0 - on ? 1.0 : 0.0;
}

/* Integrates the current through the period. In the dead time the voltage of leg a follows its current. */
static void integrate(passage_t *passage)
{
    const double fall = 0.5 * (passage->duty[0] - EFFECTIVE);
    const double rise = 1.0 - 0.5 * (passage->duty[0] + EFFECTIVE);
    double current = passage->begin;
    passage->first = passage->second = 0.0;
    for (int n = 0; n < STEPS; n++) {
        const double time = (n + 0.5) / STEPS;
        const double sign = fmax(-1.0, fmin(1.0, current / passage->zone));
        double own = time < fall || time > rise + EFFECTIVE ? 1.0 : 0.0;
        if (time >= fall && time < fall + EFFECTIVE) {
            own = 0.5 - 0.5 * sign;
            passage->first += sign / (STEPS * EFFECTIVE);
        } else if (time >= rise && time <= rise + EFFECTIVE) {
            own = 0.5 - 0.5 * sign;
            passage->second += sign / (STEPS * EFFECTIVE);
        }
        const double others = is_high(time, passage->duty[1], -1.0) + is_high(time, passage->duty[2], 1.0);
        current +=
            (LINK * PERIOD / passage->inductance * (2.0 * own - others) / 3.0 + passage->slope) / STEPS;
    }
    passage->end = current;
}

/* Both errors of the model for this passage, added to the sum of squares; the larger one. */
static double error_of(const passage_t *passage, double *squares)
{
    const edges_tuning_t edges = edges_prepare((float)PERIOD, (float)passage->inductance, 0.0f, true);
    const abc_t duty = {(float)passage->duty[0], (float)passage->duty[1], (float)passage->duty[2]};
    const edges_t last = {{(float)(4.0 * passage->first), -4.0f, 4.0f},
                          {(float)(4.0 * passage->second), -4.0f, 4.0f}};
    /* b and c have opposite currents beside half of that of a */
    const ab_t middle = {(float)(0.5 * (passage->begin + passage->end)), -3.0f};
    const ab_t change = {(float)(passage->end - passage->begin), 0.0f};
    const double shift = EFFECTIVE * LINK * PERIOD / passage->inductance / 6.0;
    const float per_zone = leg_zone_inverse((float)(1.0 / passage->zone), (float)shift);
    const edges_t signs =
        edges_signs(&edges, &last, per_zone, duty, middle, change, (float)EFFECTIVE, 0.0f, (float)LINK);
    const double first = 0.25 * (double)signs.first.a - passage->first;
    const double second = 0.25 * (double)signs.second.a - passage->second;
    *squares += first * first + second * second;
    return fmax(fabs(first), fabs(second));
}

/* For currents across the whole passage, and the edges of the other legs before, in and after the middle of
 * the dead time, the sign is right within 0.15, rms 0.05 (docs/theory.md, 12), up to z = 2 zone. */
static void test_sign_of_a_leg_in_whose_dead_time_the_others_switch(void)
{
    static const double zones[] = {0.5, 1.0, 2.0, 8.0}; /* over z */
    for (int n = 0; n < 4; n++) {
        const double z = EFFECTIVE * LINK * PERIOD / (3.0 * INDUCTANCE);
        double squares = 0.0, largest = 0.0;
        int count = 0;
        for (int at = -6; at <= 6; at++) {
            for (int shift = -3; shift <= 3; shift++) {
                passage_t passage = {
                    .inductance = INDUCTANCE,
                    .zone = zones[n] * z,
                    .begin = at / 6.0 * (zones[n] + 1.3) * z,
                    .duty = {0.5 + shift * EFFECTIVE / 4.0, 0.5 - EFFECTIVE, 0.5 + EFFECTIVE},
                };
                for (int again = 0; again < 20; again++) { /* until the current stays where it is */
                    integrate(&passage);
                    passage.slope -= 0.5 * (passage.end - passage.begin);
                }
                largest = fmax(largest, error_of(&passage, &squares));
                count += 2;
            }
        }
        TEST_ASSERT_TRUE(largest < 0.15);
        TEST_ASSERT_TRUE(sqrt(squares / count) < 0.05);
    }
}
