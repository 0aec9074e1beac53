/* Does the speed loop swing a shaft? Sines of the torque reference, as they grow, stay or fade, and noise. */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unity.h>

#include "medium/protect/oscillation_watch.h"

#define LIMIT 5.0    /* [A] */
#define STEP  0.8e-3 /* [s] */

static oscillation_watch_t watch;
static double reference; /* [rad/s] of the speed */

void setUp(void)
{
    const oscillation_watch_params_t params = {70.0f, 1000.0f, (float)LIMIT, 1e-4f, 8u};
    const oscillation_watch_tuning_t tuning = oscillation_watch_prepare(&params);
    memset(&watch, 0x55, sizeof watch);
    oscillation_watch_init(&watch, &tuning);
    reference = 200.0;
}

void tearDown(void)
{
}

/* When a sine of this frequency [Hz], which begins with this share of the limit and grows with this rate
 * [1/s] around 1 A, is told [s]; 0: not in `most` [s]. */
static double told(double hertz, double share, double rate, double most)
{
    for (double t = 0.0; t < most; t += STEP) {
        const double swing = share * LIMIT * exp(rate * t) * sin(6.2831853 * hertz * t);
        if (oscillation_watch_step(&watch, (float)(1.0 + swing), (float)reference)) {
            return t + STEP;
        }
    }
    return 0.0;
}

/* Three blocks of 16 half-waves, and one in which the filters settle. */
static void test_a_large_swing_that_stays_is_told_after_some_blocks(void)
{
    static const double hertz[] = {15.0, 30.0, 50.0, 85.0};
    for (int n = 0; n < 4; n++) {
        setUp();
        const double after = told(hertz[n], 0.25, 0.0, 5.0);
        TEST_ASSERT_TRUE(after > 0.0 && after < 4.2 * 16.0 / (2.0 * hertz[n]));
    }
}

/* The elastic shaft of the report: 85 Hz, by e in 0.35 s. */
static void test_a_small_swing_that_grows_is_told_before_it_is_large(void)
{
    const double after = told(85.0, 0.003, 1.0 / 0.35, 3.0);
    TEST_ASSERT_TRUE(after > 0.2 && after < 0.8);
}

static void test_a_small_swing_that_stays_or_fades_is_none(void)
{
    TEST_ASSERT_EQUAL_DOUBLE(0.0, told(75.0, 0.04, 0.0, 5.0));
    setUp();
    TEST_ASSERT_EQUAL_DOUBLE(0.0, told(75.0, 0.09, -2.0, 5.0));
}

/* Slower than the speed loop itself, or beyond the band. */
static void test_a_swing_outside_of_the_band_is_none(void)
{
    TEST_ASSERT_EQUAL_DOUBLE(0.0, told(5.0, 0.3, 0.0, 5.0));
    setUp();
    TEST_ASSERT_EQUAL_DOUBLE(0.0, told(400.0, 0.3, 0.0, 5.0));
}

static void test_noise_is_none(void)
{
    srand(7);
    for (int n = 0; n < 100000; n++) {
        const float noise = 2.0f * ((float)rand() / (float)RAND_MAX - 0.5f);
        TEST_ASSERT_FALSE(oscillation_watch_step(&watch, noise, (float)reference));
    }
}

static void test_a_change_of_the_speed_reference_begins_anew(void)
{
    for (int n = 0; n < 20; n++) { /* 48 half-waves of 50 Hz take 0.48 s */
        reference += 1.0;
        TEST_ASSERT_EQUAL_DOUBLE(0.0, told(50.0, 0.25, 0.0, 0.4));
    }
    TEST_ASSERT_TRUE(told(50.0, 0.25, 0.0, 1.0) > 0.0);
}

static void test_a_rest_begins_anew(void)
{
    TEST_ASSERT_EQUAL_DOUBLE(0.0, told(50.0, 0.25, 0.0, 0.4));
    oscillation_watch_rest(&watch);
    TEST_ASSERT_EQUAL_DOUBLE(0.0, told(50.0, 0.25, 0.0, 0.4));
}
