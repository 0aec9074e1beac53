/* Oracle: the period piece by piece. A leg is on at both ends, off in the middle, each edge early or late by
 * half of T_e as its current says; in the dead band of the tested leg, which carries no current, the
 * voltage is the mean of both. Currents are the integrals of these voltages and of a constant EMF. */
#include "fast/inverter/edges.h"

#include "tests/unit/compare.h"

#define PERIOD     1e-4    /* [s] */
#define INDUCTANCE 12.5e-3 /* [H] */
#define EFFECTIVE  0.023   /* T_e/T [-] */
#define LINK       311.0   /* [V] */

/* Currents of some 0.3 A, a dozen roundings of 1 A. */
#define AMPERE_TOLERANCE (12.0 / 16777216.0)

/* The switching of three legs in a period; times in periods. */
typedef struct {
    double duty[3]; /* of the compare registers [-] */
    double sign[3]; /* of the currents [-] */
    double emf[3];  /* with the voltage at the resistance [V], sum zero */
    int upper;      /* which switches are on at both ends: 1 or 0 */
} legs_t;

static double share_of(const legs_t *legs, int leg)
{
    return legs->upper ? legs->duty[leg] : 1.0 - legs->duty[leg];
}

static double way_of(const legs_t *legs)
{
    return legs->upper ? 1.0 : -1.0;
}

/* The time from 0 to `time` for which the sampled switch of this leg has been on: its edges are late or early
 * by half of T_e, against the current that flows out of the leg. Half way in the dead band where the sign is
 * 0. */
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

/* Current of a leg at `time` since the period's beginning [A]. */
static double current_at(const legs_t *legs, int leg, double time)
{
    double mean = 0.0;
    for (int x = 0; x < 3; x++) {
        mean += on_until(legs, x, time) / 3.0;
    }
    const double volts = way_of(legs) * LINK * (on_until(legs, leg, time) - mean) - legs->emf[leg] * time;
    return PERIOD / INDUCTANCE * volts;
}

static abc_t swing_of(const legs_t *legs)
{
    const edges_tuning_t edges = edges_prepare((float)PERIOD, (float)INDUCTANCE, legs->upper != 0);
    const double change[3] = {current_at(legs, 0, 1.0), current_at(legs, 1, 1.0), current_at(legs, 2, 1.0)};
    const abc_t duty = {(float)(legs->duty[0] - EFFECTIVE * legs->sign[0]),
                        (float)(legs->duty[1] - EFFECTIVE * legs->sign[1]),
                        (float)(legs->duty[2] - EFFECTIVE * legs->sign[2])};
    const abc_t phases = {(float)change[0], (float)change[1], (float)change[2]};
    return edges_swing(&edges, duty, frames_clarke(phases), (float)EFFECTIVE, (float)LINK);
}

/* For all duties, with an EMF, and without current in one leg after the other. Where another leg's edge
 * falls into the dead band
 * of the one that is looked at, the current bends within the band, and its middle is what both agree on. */
static void test_currents_at_the_edges_whichever_switches_are_on_at_the_sample(void)
{
    double largest[2] = {0.0, 0.0};
    for (int n = 0; n < 2 * 89; n++) {
        const double angle = 0.07 * (n / 2);
        for (double length = 0.0; length < 0.5; length += 0.09) {
            for (int leg = 0; leg < 3; leg++) {
                legs_t legs = {.upper = n % 2};
                for (int x = 0; x < 3; x++) {
                    const double phase = angle - x * 2.0943951023931953;
                    legs.duty[x] = 0.5 + length * cos(phase);
                    legs.emf[x] = 0.8 * length * LINK * cos(phase + 0.3);
                    legs.sign[x] = x == leg ? 0.0 : x == (leg + 1) % 3 ? 1.0 : -1.0;
                }
                const abc_t swings = swing_of(&legs);
                const double swing = (double)(leg == 0 ? swings.a : leg == 1 ? swings.b : swings.c);
                const double falling = current_at(&legs, leg, 0.5 * share_of(&legs, leg));
                const double rising = current_at(&legs, leg, 1.0 - 0.5 * share_of(&legs, leg));
                TEST_ASSERT_DOUBLE_WITHIN(AMPERE_TOLERANCE, 0.5 * (rising - falling), way_of(&legs) * swing);
                TEST_ASSERT_DOUBLE_WITHIN(1e-9, current_at(&legs, leg, 1.0), rising + falling);
                largest[n % 2] = fmax(largest[n % 2], fabs(swing));
            }
        }
    }
    TEST_ASSERT_TRUE(largest[0] > 0.1 && largest[1] > 0.1); /* [A]: and not nothing */
}
