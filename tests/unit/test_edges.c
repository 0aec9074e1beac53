/* The expected values are computed from the period piece by piece. A leg is on at both ends of the period
 * and off in the middle; each edge is early or late by half of T_e, depending on its current. The edges of
 * the tested leg, which carries no current, are in the middle of its dead times. Its current counts at the
 * end of each dead time: the voltages of all legs act until then, the EMF until the middle. Currents are the
 * integrals of these voltages and of an EMF that rotates. */
#include "fast/inverter/edges.h"

#include "tests/unit/compare.h"

#define PERIOD     1e-4    /* [s] */
#define INDUCTANCE 12.5e-3 /* [H] */
#define EFFECTIVE  0.023   /* [-] T_e/T */
#define LINK       311.0   /* [V] */

/* The limit is a dozen roundings of 1 A, for currents of about 0.3 A. */
#define AMPERE_TOLERANCE (12.0 / 16777216.0)

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
 * 0, the edge is in the middle of the dead time. */
static double on_until(const legs_t *legs, int leg, double time)
{
    const double falls = 0.5 * share_of(legs, leg);
    const double rises = 1.0 - falls;
    const double late = way_of(legs) * legs->sign[leg] * 0.5 * EFFECTIVE;
    return fmin(time, falls - late) + fmax(0.0, time - (rises + late));
}

/* The integral of the EMF of a leg until `time` [V]. */
static double emf_until(const legs_t *legs, int leg, double time)
{
    const double middle = legs->phase - leg * 2.0943951023931953;
    const double begin = middle - 0.5 * legs->turn;
    return legs->emf / legs->turn * (sin(begin + legs->turn * time) - sin(begin));
}

/* The current of a leg after the beginning of the period [A], if the legs act until `time` and the EMF until
 * `emf_time`. */
static double current_by(const legs_t *legs, int leg, double time, double emf_time)
{
    double mean = 0.0;
    for (int x = 0; x < 3; x++) {
        mean += on_until(legs, x, time) / 3.0;
    }
    const double volts =
        way_of(legs) * LINK * (on_until(legs, leg, time) - mean) - emf_until(legs, leg, emf_time);
    return PERIOD / INDUCTANCE * volts;
}

/* With a zone of 1 A, in which the currents of the other legs, 2 A, are certain. */
static edges_t edges_of(const legs_t *legs)
{
    const edges_tuning_t edges = edges_prepare((float)PERIOD, (float)INDUCTANCE, legs->upper != 0);
    const abc_t duty = {(float)legs->duty[0], (float)legs->duty[1], (float)legs->duty[2]};
    const abc_t mean = {(float)(2.0 * legs->sign[0]), (float)(2.0 * legs->sign[1]),
                        (float)(2.0 * legs->sign[2])};
    const abc_t change = {(float)current_by(legs, 0, 1.0, 1.0), (float)current_by(legs, 1, 1.0, 1.0),
                          (float)current_by(legs, 2, 1.0, 1.0)};
    return edges_currents(&edges, 1.0f, duty, frames_clarke(mean), frames_clarke(change), (float)EFFECTIVE,
                          (float)(legs->turn / PERIOD), (float)LINK);
}

static double of_leg(abc_t values, int leg)
{
    return (double)(leg == 0 ? values.a : leg == 1 ? values.b : values.c);
}

/* Tested for all duties, with an EMF of this rotation, and with one leg after the other without current.
 * The model has the parabola of a rotating EMF; the neglected terms are below turn^2/12 of the parabola, and
 * turn^2/8 of the odd part. The parabola of a leg follows from the slopes of the other two, which the model
 * takes as if their edges were in the middle of their dead times, too: each is wrong by T_e u_dc/(3 L), their
 * difference over sqrt(3) by twice that. */
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
                const edges_t edges = edges_of(&legs);
                const double way = way_of(&legs);
                const double first = way * of_leg(edges.first, leg);
                const double second = way * of_leg(edges.second, leg);
                const double falls = 0.5 * share_of(&legs, leg);
                const double sides = 0.5 * current_by(&legs, leg, 1.0, 1.0);
                const double falling = current_by(&legs, leg, falls + 0.5 * EFFECTIVE, falls) - sides;
                const double rising =
                    current_by(&legs, leg, 1.0 - falls + 0.5 * EFFECTIVE, 1.0 - falls) - sides;
                /* [A] change of the current in a period by the EMF. */
                const double amperes = PERIOD / INDUCTANCE * legs.emf;
                const double slopes = 2.0 / sqrt(3.0) * EFFECTIVE * LINK * PERIOD / (3.0 * INDUCTANCE);
                TEST_ASSERT_DOUBLE_WITHIN(AMPERE_TOLERANCE + amperes * turn * turn * turn / 96.0 +
                                              0.25 * turn * slopes,
                                          0.5 * (falling + rising), 0.5 * (first + second));
                TEST_ASSERT_DOUBLE_WITHIN(AMPERE_TOLERANCE + amperes * turn * turn / 48.0,
                                          0.5 * (rising - falling), 0.5 * (second - first));
                largest[n % 2] = fmax(largest[n % 2], 0.5 * fabs(rising - falling));
                bent = fmax(bent, 0.5 * fabs(rising + falling));
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
