/* The detection of an oscillation that the speed loop causes in a shaft: growing, constant and decreasing
 * sines of the torque reference, and noise. */
#include <stdlib.h>

#include "medium/protect/oscillation_watch.h"
#include "tests/unit/compare.h"

#define LIMIT 5.0    /* [A] */
#define STEP  0.8e-3 /* [s] between two steps */

static oscillation_watch_t watch;
static double reference; /* [rad/s] reference of the speed */

void setUp(void)
{
    const oscillation_watch_params_t params = {70.0f, 1000.0f, (float)LIMIT, 1e-4f, 8u};
    const oscillation_watch_tuning_t tuning = oscillation_watch_prepare(&params);
    memset(&watch, 0x55, sizeof watch);
    oscillation_watch_init(&watch, &tuning);
    reference = 200.0;
}

/* The time [s] at which the watch reports a sine around 1 A, 0 if it does not within `most` [s]. The sine
 * has this frequency [Hz]; its amplitude begins with this share of the limit and grows at this rate [1/s]. */
static double told(double hertz, double share, double rate, double most)
{
    for (double t = 0.0; t < most; t += STEP) {
        const double swing = share * LIMIT * exp(rate * t) * sin(6.2831853 * hertz * t);
        if (oscillation_watch_step(&watch, (float)(1.0 + swing), (float)reference) == OSCILLATION_CERTAIN) {
            return t + STEP;
        }
    }
    return 0.0;
}

/* A sustained swing needs 24 waves in succession, of which the filters may shorten the first, and the time in
 * which they settle. A swing that grows needs a wave that gives the length, a first block of two waves and
 * four steps of growth. A step takes the time t in which exp(rate t) is 1.1, rounded up to blocks. A swing
 * does not count if it is small and constant or decreasing, if a step takes longer than 32 waves (0.38 s at
 * 85 Hz), if it is slower than the speed loop, or if it is beyond the band. */
static void test_an_oscillation_is_reported_if_it_is_large_or_grows(void)
{
    static const struct {
        /* Earliest and latest time of the report [s]; 0: never. */
        double hertz, share, rate, earliest, latest;
    } cases[] = {{15.0, 0.25, 0.0, 23.0 / 15.0, 2.24},
                 {30.0, 0.25, 0.0, 23.0 / 30.0, 1.12},
                 {50.0, 0.25, 0.0, 23.0 / 50.0, 0.672},
                 {85.0, 0.25, 0.0, 23.0 / 85.0, 0.395},
                 {85.0, 0.003, 1.0 / 0.35, 0.2, 0.5}, /* above 0.5 % behind the filters from 0.34 s on */
                 {85.0, 0.01, 0.65, 4.0 * 0.1466, 4.0 * 0.1466 + 8.0 * 2.0 / 85.0 + 0.05},
                 {26.0, 0.01, 2.2, 4.0 * 0.0433, 11.0 / 26.0 + 0.05},
                 {85.0, 0.02, 0.15, 0.0, 0.0},
                 {75.0, 0.04, 0.0, 0.0, 0.0},
                 {75.0, 0.09, -2.0, 0.0, 0.0},
                 {5.0, 0.3, 0.0, 0.0, 0.0},
                 {400.0, 0.3, 0.0, 0.0, 0.0}};
    for (size_t n = 0; n < sizeof cases / sizeof cases[0]; n++) {
        setUp();
        const double after = told(cases[n].hertz, cases[n].share, cases[n].rate, 5.0);

        TEST_ASSERT_TRUE(cases[n].latest == 0.0 ? after == 0.0
                                                : after > cases[n].earliest && after < cases[n].latest);
    }
}

/* The time [s] of the first sign of such a sine, 0 if there is none within `most` [s]. */
static double begun(double hertz, double share, double rate, double most)
{
    for (double t = 0.0; t < most; t += STEP) {
        const double swing = share * LIMIT * exp(rate * t) * sin(6.2831853 * hertz * t);
        if (oscillation_watch_step(&watch, (float)(1.0 + swing), (float)reference) == OSCILLATION_BEGINS) {
            return t + STEP;
        }
    }
    return 0.0;
}

/* Two waves that are each larger than the last one by more than 1.15: the one before them is the first or the
 * second wave, because the filters settle in the first. With 1.3 per wave an amplitude of 0.4 % is above 2 %
 * after ln(5)/ln(1.3) = 6.1 waves, behind the filters a wave later. A growth of 1.1 per wave, a constant and
 * a decreasing swing are none. */
static void test_the_first_sign_of_a_quick_growth_is_reported_within_a_few_waves(void)
{
    static const struct {
        double hertz, share, growth, earliest, latest; /* [Hz], [-] of the limit, [-] a wave, [waves] */
    } cases[] = {{50.0, 0.02, 1.3, 2.0, 4.5},  {26.0, 0.02, 1.25, 2.0, 4.5}, {72.0, 0.02, 1.7, 2.0, 4.5},
                 {50.0, 0.004, 1.3, 6.1, 9.5}, {50.0, 0.02, 1.1, 0.0, 0.0},  {75.0, 0.04, 1.0, 0.0, 0.0},
                 {75.0, 0.09, 0.9, 0.0, 0.0},  {400.0, 0.02, 1.3, 0.0, 0.0}};
    for (size_t n = 0; n < sizeof cases / sizeof cases[0]; n++) {
        setUp();
        const double hertz = cases[n].hertz;
        const double waves = hertz * begun(hertz, cases[n].share, hertz * log(cases[n].growth), 16.0 / hertz);

        TEST_ASSERT_TRUE(cases[n].latest == 0.0 ? waves == 0.0
                                                : waves > cases[n].earliest && waves < cases[n].latest);
    }
}

/* A load that rises by a tenth of the limit in a second moves the half-waves apart, not the waves. */
static void test_a_growth_is_reported_on_a_torque_that_changes(void)
{
    bool found = false;
    for (double t = 0.0; t < 1.0; t += STEP) {
        const double swing = 0.01 * LIMIT * exp(2.2 * t) * sin(6.2831853 * 26.0 * t);
        const float i_q_ref = (float)(1.0 + 0.1 * LIMIT * t + swing);
        found = oscillation_watch_step(&watch, i_q_ref, (float)reference) == OSCILLATION_CERTAIN || found;
    }
    TEST_ASSERT_TRUE(found);
}

/* The ripple of a rotor that loses its speed: its frequency falls from 75 to 25 Hz within 0.3 s, and
 * the amplitude triples as it does near a resonance. It takes 0.09 s to the first wave that is longer by a
 * fifth; within this time the amplitude grows by 1.39, less than four steps. */
static void test_a_ripple_that_follows_the_speed_is_not_an_oscillation(void)
{
    double phase = 0.0;
    for (double t = 0.0; t < 0.3; t += STEP) {
        phase += STEP * 6.2831853 * (75.0 - 50.0 / 0.3 * t);
        const double swing = 0.01 * LIMIT * exp(3.66 * t) * sin(phase);
        TEST_ASSERT_TRUE(oscillation_watch_step(&watch, (float)(1.0 + swing), (float)reference) !=
                         OSCILLATION_CERTAIN);
    }
}

static void test_noise_is_not_an_oscillation(void)
{
    srand(7);
    for (int n = 0; n < 100000; n++) {
        const float noise = 2.0f * ((float)rand() / (float)RAND_MAX - 0.5f);
        TEST_ASSERT_TRUE(oscillation_watch_step(&watch, noise, (float)reference) != OSCILLATION_CERTAIN);
    }
}

static void test_a_change_of_the_speed_reference_and_a_rest_begin_again(void)
{
    for (int n = 0; n < 20; n++) { /* 24 waves of 50 Hz take 0.48 s */
        reference += 1.0;
        TEST_ASSERT_EQUAL_DOUBLE(0.0, told(50.0, 0.25, 0.0, 0.4));
    }
    TEST_ASSERT_TRUE(told(50.0, 0.25, 0.0, 1.0) > 0.0);
    setUp();
    TEST_ASSERT_EQUAL_DOUBLE(0.0, told(50.0, 0.25, 0.0, 0.4));
    oscillation_watch_rest(&watch);
    TEST_ASSERT_EQUAL_DOUBLE(0.0, told(50.0, 0.25, 0.0, 0.4));
}
