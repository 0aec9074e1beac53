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
static float noise;   /* [-] mean square of the noise, in squared codes */
static float doubt;   /* [V] four times the error of the EMF */
static ab_t emf;      /* [V] */
static abc_t last;    /* [A] */

#define CODE (RANGE / 2048.0f)

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
    noise = 0.0f;
    doubt = 0.0f;
    emf = (ab_t){0.0f, 0.0f};
    last = (abc_t){0.0f, 0.0f, 0.0f};
    watch = (still_watch_t){.still = {0u, 0u, 0u}};
    tuning = prepared(false, true);
}

/* The judgement with both steps. */
static bool is_stuck(uint32_t found, const abc_t *current)
{
    const still_watch_winding_t winding = {
        .current = current, .before = &last, .voltage = &voltage, .emf = emf, .doubt = doubt, .u_dc = u_dc};
    return (found & STILL_WATCH_STUCK) != 0u ||
           (found != 0u && still_watch_is_wired(&tuning, found, &winding));
}

/* One period; c is minus the sum of the other two, plus `apart`. */
static bool step(float a, float b, float asked_a)
{
    const abc_t current = {a, b, apart - a - b};
    const still_watch_input_t input = {
        .asked = frames_clarke((abc_t){asked_a, b, -asked_a - b}),
        .current = &current,
        .noise = noise * CODE * CODE,
        .voltage = &voltage,
        .omega_e = omega_e,
        .u_dc = u_dc,
        .limited = limited,
    };
    const bool stuck = still_watch_count(&watch, &tuning, current.a, current.b, current.c) &&
                       is_stuck(still_watch_judge(&watch, &tuning, &input), &current);
    still_watch_remember(&watch, &voltage);
    last = current;
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

/* The voltage of phase a exceeds its EMF by 100 V, and the current of a, zero, does not change. Beside an
 * open wire the star point moves by 50 V, and phase b has an excess of -50 V; with a stuck sensor it has
 * none. The limit is between them, -25 V: Clarke makes (100, 28.87) V of (100, -25, -75) V. The current of b
 * changes by 0.01 A and that of c by -0.01 A in a period, which takes 120 ohm 0.01 A = 1.2 V of the excess of
 * b: the limit is that of 28.87 V + 2/sqrt(3) 1.2 V = 30.3 V. The comparison needs more than 86.5 V (the
 * voltage of a jump, below) and more than the error of the EMF in addition. */
static unsigned open_after(float alpha, float beta, float miss)
{
    emf = (ab_t){-alpha, -beta};
    return stuck_after(0.0f, 5.0f, miss, 30u);
}

static void test_an_excess_of_the_voltage_in_one_phase_alone_excludes_an_open_wire(void)
{
    static const struct {
        float alpha, beta, miss, doubt; /* [V], [A] */
        unsigned after;                 /* [periods]; 0: never */
    } cases[] = {{100.0f, 57.74f, 1.1f, 0.0f, 7u},   {-100.0f, -57.74f, -1.1f, 0.0f, 7u},
                 {100.0f, 31.0f, 1.1f, 0.0f, 7u},    {100.0f, 29.6f, 1.1f, 0.0f, 0u},
                 {100.0f, 0.0f, 1.1f, 0.0f, 0u},     {100.0f, 0.0f, 3.1f, 0.0f, 9u},
                 {85.0f, 49.07f, 1.1f, 0.0f, 0u},    {100.0f, 57.74f, 1.1f, 14.0f, 0u},
                 {100.0f, 57.74f, 1.1f, 13.0f, 7u},  {100.0f, 57.74f, 0.9f, 0.0f, 0u},
                 {-100.0f, -57.74f, 1.1f, 0.0f, 7u}, {-100.0f, 57.74f, 1.1f, 0.0f, 0u}};
    for (size_t n = 0; n < sizeof cases / sizeof cases[0]; n++) {
        setUp();
        doubt = cases[n].doubt;
        TEST_ASSERT_EQUAL_UINT(cases[n].after, open_after(cases[n].alpha, cases[n].beta, cases[n].miss));
    }
}

/* Sensor b is stuck at zero, and its phase has the excess (0, 100, -100) V: (0, 115.5) V. Beside an open wire
 * of b it is (-50, 100, -50) V: (-50, 86.6) V. */
static unsigned b_after(float alpha, float beta)
{
    emf = (ab_t){-alpha, -beta};
    for (unsigned n = 0; n <= 30u; n++) {
        const float a = 5.0f + 0.01f * (float)n;
        const abc_t current = {a, n == 0u ? 1.0f : 0.0f, n == 0u ? -a - 1.0f : -a};
        const still_watch_input_t input = {
            .asked = frames_clarke((abc_t){5.0f, 1.1f, -6.1f}),
            .current = &current,
            .voltage = &voltage,
            .u_dc = u_dc,
        };
        if (still_watch_count(&watch, &tuning, current.a, current.b, current.c) &&
            is_stuck(still_watch_judge(&watch, &tuning, &input), &current)) {
            return n;
        }
        still_watch_remember(&watch, &voltage);
        last = current;
    }
    return 0u;
}

static void test_the_phase_beside_sensor_b_is_that_of_sensor_a(void)
{
    TEST_ASSERT_EQUAL_UINT(7u, b_after(0.0f, 115.5f));
    setUp();
    TEST_ASSERT_EQUAL_UINT(0u, b_after(-50.0f, 86.6f));
}

/* A sensor with this noise would have changed within 12 periods. This excludes an open wire, and a current
 * that the dead time holds at zero beside an offset. The difference from the reference needs only 2 % of the
 * range then, 0.4 A, in the last four periods, unless the voltage is at its limit. */
static void test_noise_excludes_an_open_wire_and_an_offset(void)
{
    static const struct {
        float a, b, miss, noise; /* [A], [-] */
        bool limited;
        unsigned after; /* [periods]; 0: never */
    } cases[] = {{0.0f, 5.0f, 0.41f, 0.76f, false, 13u},   {0.0f, 5.0f, 0.41f, 0.74f, false, 0u},
                 {4.0f, 0.0f, 0.41f, 0.76f, false, 13u},   {4.0f, 5.0f, 0.41f, 0.76f, false, 13u},
                 {0.0f, 5.0f, 0.39f, 0.76f, false, 0u},    {0.0f, 5.0f, 0.41f, 0.76f, true, 0u},
                 {0.0f, 5.0f, 1.1f, 0.76f, true, 13u},     {0.0f, 5.0f, 3.1f, 0.76f, false, 9u},
                 {1.8f, -20.0f, -2.3f, 0.76f, false, 13u}, {1.8f, -20.0f, -2.3f, 0.74f, false, 0u}};
    for (size_t n = 0; n < sizeof cases / sizeof cases[0]; n++) {
        setUp();
        gain = 6.0f;
        u_dc = cases[n].limited ? 72.1f : 311.0f; /* 14.44 V with the wrong sign: 2.41 A */
        noise = cases[n].noise;
        limited = cases[n].limited;
        tuning = prepared(false, true);
        TEST_ASSERT_EQUAL_UINT(cases[n].after, stuck_after(cases[n].a, cases[n].b, cases[n].miss, 30u));
    }
}

/* A value that stays at its reference for 40 periods in spite of noise is stuck if 2 % of the range, 0.4 A,
 * flows through the other sensor. Three values that add up to zero are not stuck. */
static void test_a_silent_sensor_is_stuck_as_soon_as_another_current_flows(void)
{
    static const struct {
        float b, noise; /* [A], [-] */
        bool three;
        unsigned after; /* [periods]; 0: never */
    } cases[] = {{0.41f, 0.42f, false, 41u},
                 {-0.42f, 0.42f, false, 41u},
                 {0.38f, 0.42f, false, 0u},
                 {0.41f, 0.38f, false, 0u},
                 {0.41f, 0.42f, true, 0u}};
    for (size_t n = 0; n < sizeof cases / sizeof cases[0]; n++) {
        setUp();
        noise = cases[n].noise;
        tuning = prepared(cases[n].three, true);
        (void)step(1.0f, cases[n].b, 1.0f);
        unsigned after = 0u;
        for (unsigned k = 1; k <= 100u && after == 0u; k++) {
            after = step(0.0f, cases[n].b + 0.01f * (float)(k % 2u), 0.0f) ? k : 0u;
        }
        TEST_ASSERT_EQUAL_UINT(cases[n].after, after);
    }
}

/* With three sensors the sum is zero if a wire is open: a phase without current needs no longer time. */
static void test_the_sum_of_three_sensors_decides_whether_a_wire_is_open(void)
{
    static const struct {
        float apart;    /* [A] */
        unsigned after; /* [periods]; 0: never */
    } cases[] = {{0.0f, 0u}, {0.55f, 7u}};
    for (size_t n = 0; n < sizeof cases / sizeof cases[0]; n++) {
        setUp();
        tuning = prepared(true, true);
        apart = cases[n].apart;
        TEST_ASSERT_EQUAL_UINT(cases[n].after, stuck_after(0.0f, 5.0f, 1.1f, 100u));
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
