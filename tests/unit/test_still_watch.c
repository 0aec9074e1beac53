/* A current sensor has a constant output while the control requests another current. The sensors have a
 * range of 20 A, so that a difference of 1 A counts as wrong, one of 3 A as far, and a current below 0.15
 * A as almost none. */
#include "fast/protect/still_watch.h"

#include "unity.h"

#define RANGE 20.0f

static still_watch_t watch;
static still_watch_tuning_t tuning;
static bool limited;  /* the control has not got the voltage that it requested */
static float u_dc;    /* [V] */
static ab_t voltage;  /* [V] voltage that acts */
static float omega_e; /* [rad/s] */
static float apart;   /* [A] sum of the three values */
static float gain;    /* [ohm] of the current control */

/* With 12 mH, 2/3 of 72 V changes the current by 0.4 A in 100 us, 2 % of the range. */
static still_watch_tuning_t prepared(bool three_sensors, bool judged)
{
    const still_watch_params_t params = {.range = RANGE,
                                         .inductance = 12e-3f,
                                         .gain = gain,
                                         .dead_time = 2e-6f,
                                         .drop = 1.0f,
                                         .period = 1e-4f,
                                         .three_sensors = three_sensors,
                                         .judged = judged};
    return still_watch_prepare(&params);
}

void setUp(void)
{
    limited = false;
    u_dc = 311.0f;
    voltage = (ab_t){0.0f, 0.0f};
    omega_e = 0.0f;
    apart = 0.0f;
    gain = 1000.0f;
    watch = (still_watch_t){.still = {0u, 0u, 0u}};
    tuning = prepared(false, true);
}

/* One period; c is minus the sum of the other two, plus `apart`. */
static bool step(float a, float b, float asked_a)
{
    const abc_t current = {a, b, apart - a - b};
    const still_watch_input_t input = {
        .asked = frames_clarke((abc_t){asked_a, b, -asked_a - b}),
        .current = &current,
        .voltage = &voltage,
        .omega_e = omega_e,
        .u_dc = u_dc,
        .limited = limited,
    };
    const bool stuck =
        still_watch_count(&watch, &tuning, &current) && still_watch_judge(&watch, &tuning, &input);
    still_watch_remember(&watch, &voltage);
    return stuck;
}

/* For this number of periods a stays constant although its request differs by `miss`, while b moves.
 * Returns the period in which a is reported as stuck, 0 if it is not. */
static unsigned stuck_after(float a, float b, float miss, unsigned periods)
{
    (void)step(a + 1.0f, b, a + miss);
    for (unsigned n = 1; n <= periods; n++) {
        if (step(a, b + 0.01f * (float)n, a + miss)) {
            return n;
        }
    }
    return 0u;
}

/* The value changes with the first sample and stays for three; in the third of these, and in the three
 * after it, it is wrong. If almost no current flows in this phase or another, the difference must be large
 * and last longer. If the voltage is at its limit, a current may change as slowly as the link allows. */
static void test_a_constant_value_that_differs_from_the_request_is_stuck(void)
{
    static const struct {
        float a, b, miss, link; /* [A], [V] */
        bool limited, judged;
        unsigned after; /* [periods]; 0: never */
    } cases[] = {{4.0f, -2.0f, 1.1f, 311.0f, false, true, 7u}, {-4.0f, 2.0f, -1.1f, 311.0f, false, true, 7u},
                 {4.0f, -2.0f, 0.9f, 311.0f, false, true, 0u}, {4.0f, -2.0f, 9.0f, 71.9f, true, true, 0u},
                 {4.0f, -2.0f, 9.0f, 72.1f, true, true, 7u},   {4.0f, -2.0f, 9.0f, 71.9f, false, true, 7u},
                 {0.0f, 5.0f, 2.9f, 311.0f, false, true, 0u},  {0.0f, 5.0f, 3.1f, 311.0f, false, true, 9u},
                 {4.0f, 0.0f, 3.1f, 311.0f, false, true, 9u},  {4.0f, -2.0f, 8.0f, 311.0f, false, false, 0u}};
    for (size_t n = 0; n < sizeof cases / sizeof cases[0]; n++) {
        setUp();
        limited = cases[n].limited;
        u_dc = cases[n].link;
        tuning = prepared(!cases[n].judged, cases[n].judged);
        TEST_ASSERT_EQUAL_UINT(cases[n].after, stuck_after(cases[n].a, cases[n].b, cases[n].miss, 100u));
    }
}

/* A leg loses 2 us/100 us 311 V + 1 V = 7.22 V. If the leg of phase a and that of the computed current c are
 * compensated with the wrong sign, the voltage of phase a is wrong by (2 2 + 2)/3 7.22 V = 14.44 V. The
 * gain of the control is 6 ohm: it makes this voltage with a difference of 2.41 A, or of 1.02 A with 103 V.
 * An offset below 0.15 A reverses no sign; there 1 A, or 3 A with a phase without current, remain the limit.
 */
static void test_a_value_that_the_dead_time_may_hold_with_an_offset_is_not_stuck(void)
{
    static const struct {
        float a, miss, link; /* [A], [V] */
        unsigned after;      /* [periods]; 0: never */
    } cases[] = {{1.8f, -2.35f, 311.0f, 0u}, {1.8f, -2.45f, 311.0f, 7u}, {-1.8f, 2.35f, 311.0f, 0u},
                 {-1.8f, 2.45f, 311.0f, 7u}, {1.8f, -1.01f, 103.0f, 0u}, {1.8f, -1.05f, 103.0f, 7u},
                 {0.14f, 2.9f, 311.0f, 0u},  {0.14f, 3.1f, 311.0f, 9u}};
    for (size_t n = 0; n < sizeof cases / sizeof cases[0]; n++) {
        setUp();
        gain = 6.0f;
        u_dc = cases[n].link;
        tuning = prepared(false, true);
        TEST_ASSERT_EQUAL_UINT(cases[n].after, stuck_after(cases[n].a, -20.0f, cases[n].miss, 12u));
    }
}

/* A stuck value makes the sum of three sensors different from zero by its error. At 1 A from the request,
 * half of it decides. Two sensors have no sum. */
static void test_three_values_that_add_up_to_zero_are_not_stuck(void)
{
    static const struct {
        float apart; /* [A] */
        bool three;
        unsigned after; /* [periods]; 0: never */
    } cases[] = {{0.0f, true, 0u},  {0.45f, true, 0u},  {-0.45f, true, 0u},
                 {0.55f, true, 7u}, {-0.55f, true, 7u}, {0.0f, false, 7u}};
    for (size_t n = 0; n < sizeof cases / sizeof cases[0]; n++) {
        setUp();
        tuning = prepared(cases[n].three, true);
        apart = cases[n].apart;
        TEST_ASSERT_EQUAL_UINT(cases[n].after, stuck_after(4.0f, -2.0f, 1.1f, 100u));
    }
}

static void test_a_code_that_moves_begins_again(void)
{
    for (unsigned n = 0; n < 200u; n++) {
        TEST_ASSERT_FALSE(step(4.0f + (n % 6u == 0u ? 0.01f : 0.0f), -2.0f + 0.01f * (float)(n % 3u), 9.0f));
    }
}

/* A current has been constant for long; then its reference steps, and the current changes in the third
 * sample. */
static void test_a_step_of_the_reference_is_not_a_stuck_sensor(void)
{
    for (unsigned n = 0; n < 100u; n++) {
        TEST_ASSERT_FALSE(step(4.0f, -2.0f, 4.0f));
    }
    TEST_ASSERT_FALSE(step(4.0f, -2.0f, -8.0f));
    TEST_ASSERT_FALSE(step(4.0f, -2.0f, -8.0f));
    TEST_ASSERT_FALSE(step(3.5f, -2.0f, -8.0f));
}

/* Sensor a stays at the reference, and in the second of three periods the voltage of its phase jumps by
 * `jump` [V]. 0.4 A in 12 mH need 48 V periods. The loss of three legs, twice with the other sign, is 16/3
 * of (2 us/100 us 311 V + 1 V), 38.5 V: together 86.5 V, 43.3 V in each of two periods. A rotor at 500
 * rad/s with 100 V before the jump adds 3 x 0.05 x 100 V, 7.5 V in each period. */
static unsigned pushed_after(float a, float b, float jump, float before)
{
    voltage = (ab_t){before, 0.0f};
    (void)step(a + 8.0f, b, a);
    (void)step(a + 8.0f, b, a);
    for (unsigned n = 0; n <= 20u; n++) {
        voltage = (ab_t){n < 2u ? before : before + jump, 0.0f};
        if (step(a, b + 0.01f * (float)n, a)) {
            return n;
        }
    }
    return 0u;
}

static void test_a_value_that_stays_while_its_voltage_jumps_is_stuck(void)
{
    static const struct {
        float a, b, jump, before, omega_e; /* [A], [V], [rad/s] */
        unsigned after;                    /* [periods]; 0: never */
    } cases[] = {{0.3f, -2.0f, 44.0f, 5.0f, 0.0f, 3u},     {0.3f, -2.0f, -44.0f, -5.0f, 0.0f, 3u},
                 {0.3f, -2.0f, 42.0f, 5.0f, 0.0f, 0u},     {0.1f, -2.0f, 44.0f, 5.0f, 0.0f, 8u},
                 {0.3f, -2.0f, 52.0f, 100.0f, 500.0f, 3u}, {0.3f, -2.0f, 50.0f, 100.0f, 500.0f, 0u},
                 {0.3f, -2.0f, 50.0f, 100.0f, 0.0f, 3u},   {0.3f, -2.0f, -52.0f, 100.0f, -500.0f, 3u}};
    for (size_t n = 0; n < sizeof cases / sizeof cases[0]; n++) {
        setUp();
        omega_e = cases[n].omega_e;
        TEST_ASSERT_EQUAL_UINT(cases[n].after,
                               pushed_after(cases[n].a, cases[n].b, cases[n].jump, cases[n].before));
    }
}
