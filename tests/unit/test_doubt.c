/* The inequalities of the header, each just inside, at and just outside its limit.
 *
 * Limits in a steady drive: 0.2 of the largest current; an EMF of four leg losses; 5 mrad; a detector of 0.1;
 * a speed error of 0.2 (0.1 for a light rotor); 30 rad/s.
 *
 * Limits with a known acceleration: 0.1 of the largest current; 3 rad/s; a load, or an unexpected
 * acceleration, that turns the rotor by 20 mrad in 5 ms at a reversal. */
#include "fast/inverter/doubt.h"

#include "tests/unit/compare.h"
#include "tests/unit/sweep.h"

#define ZONE 0.1f /* [A] */
#define LEG  8.0f /* [V] */

static const doubt_params_t PARAMS = {.current = ZONE,
                                      .emf_cutoff = 0.0f,
                                      .acceleration_known = false,
                                      .acceleration = 690.0f,
                                      .current_max = 10.0f,
                                      .period = 1e-4f};

static doubt_t doubt;
static doubt_tuning_t tuning;
static doubt_input_t input;

static void begin(const doubt_params_t *params)
{
    tuning = doubt_prepare(params);
    doubt_init(&doubt);
}

/* Phase a carries `largest`, b almost nothing: the voltage is uncertain in a steady drive. */
static ab_t largest_of(float largest)
{
    return (ab_t){largest, 0.577350269f * largest};
}

/* Phase a carries `smallest`, b and c carry much more. */
static ab_t smallest_of(float smallest)
{
    return (ab_t){smallest, 3.0f};
}

void setUp(void)
{
    begin(&PARAMS);
    input = (doubt_input_t){
        .current = largest_of(4.0f),
        .leg = LEG,
        .amplitude = 7.0f,
        .detector = 0.0f,
        .omega_e = 42.0f,
        .omega_m = 10.5f,
        .omega_m_miss = 0.0f,
    };
}

/* Whether the voltage is uncertain; the result depends on this input alone. */
static bool doubted(void)
{
    doubt.left = 0u;
    return doubt_step(&doubt, &tuning, &input);
}

/* Tests one value just below a limit, at it, and just above it. */
static void expect_around(float *value, float limit, bool below, bool at, bool above)
{
    const float towards = limit < 0.0f ? -1e9f : 1e9f; /* "above" means a larger magnitude */
    *value = nextafterf(limit, 0.0f);
    TEST_ASSERT_EQUAL(below, doubted());
    *value = limit;
    TEST_ASSERT_EQUAL(at, doubted());
    *value = nextafterf(limit, towards);
    TEST_ASSERT_EQUAL(above, doubted());
}

/* Tests the magnitude of a value in the same way, with either sign. */
static void expect_around_amount(float *value, float limit, bool below, bool at, bool above)
{
    expect_around(value, limit, below, at, above);
    expect_around(value, -limit, below, at, above);
}

/* ---- the voltage ---- */

/* At 0.5 A one zone, 0.1 A, is a fifth of the largest current. The speed is the slowest one, because the
 * memory of a crossing counts as part of the turn, too. */
static void test_largest_current_below_at_above_what_makes_one_zone_a_part_of_the_turn(void)
{
    tuning.share_per_speed = 0.0f;
    for (int sign = -1; sign <= 1; sign += 2) {
        input.current = largest_of((float)sign * 0.5f);
        expect_around(&input.current.alpha, (float)sign * 0.5f, false, false, true);
    }
}

/* The largest current may be in any phase: in this test it is in b or c, with 0.45 A in a, for which 0.866
 * beta compensates. */
static void test_every_phase_counts_as_the_largest(void)
{
    tuning.share_per_speed = 0.0f;
    for (int sign = -1; sign <= 1; sign += 2) {
        input.current = (ab_t){0.05f, (float)sign * 0.54f}; /* 0.025 + 0.4677 = 0.4927 A */
        TEST_ASSERT_FALSE(doubted());
        input.current = (ab_t){0.05f, (float)sign * 0.55f}; /* 0.5013 A */
        TEST_ASSERT_TRUE(doubted());
        input.current = (ab_t){-0.05f, (float)sign * 0.55f};
        TEST_ASSERT_TRUE(doubted());
    }
}

/* The first conditions are the EMF and the smallest current: with |e| largest = 128 VA and a leg loss of 8
 * V the limit of the zone is 0.005 x 128/8 = 0.08 A. The other conditions of a steady drive are the
 * detector and the speed. */
static void test_each_condition_of_a_steady_drive_below_at_above(void)
{
    expect_around(&input.amplitude, 4.0f * LEG, true, false, false);
    input.amplitude = 16.0f;
    input.current = largest_of(8.0f);
    expect_around(&tuning.current, 0.005f * 16.0f, false, false, true);
    setUp();
    input.current = smallest_of(0.0f);
    expect_around_amount(&input.current.alpha, ZONE, true, false, false);
    setUp();
    expect_around_amount(&input.detector, 0.1f, true, false, false);
    input.detector = 0.0f;
    expect_around_amount(&input.omega_e, 8.0f, false, true, true);
}

static void test_no_limit_is_no_doubt(void)
{
    doubt_params_t params = PARAMS;
    params.current = 0.0f;
    begin(&params);
    TEST_ASSERT_FALSE(doubted());
    input.current = smallest_of(0.0f);
    TEST_ASSERT_FALSE(doubted());
    input.current = (ab_t){0.0f, 0.0f};
    TEST_ASSERT_FALSE(doubted());
}

/* ---- when the loop may coast: a steady drive ---- */

static void expect_around_miss(float acceleration, float share)
{
    doubt_params_t params = PARAMS;
    params.acceleration = acceleration;
    begin(&params);
    for (int way = -1; way <= 1; way += 2) {
        input.omega_m = (float)way * 10.5f;
        expect_around_amount(&input.omega_m_miss, share * 10.5f, true, false, false);
    }
}

/* The limit is a fifth, and a tenth for a light rotor, which the current limit turns by 20 mrad in 5 ms,
 * with 1600 rad/s^2. */
static void test_speed_miss_below_at_above_a_fifth_or_a_tenth(void)
{
    expect_around_miss(PARAMS.acceleration, 0.2f);
    expect_around_miss(1599.0f, 0.2f);
    expect_around_miss(1601.0f, 0.1f);
}

/* ---- when the loop may coast: a drive whose acceleration is known ---- */

/* The drive is not steady by any of its conditions. */
static void given_known_acceleration(void)
{
    doubt_params_t params = PARAMS;
    params.acceleration_known = true;
    begin(&params);
    input.current = largest_of(8.0f);
    input.detector = 0.5f;
    input.omega_m_miss = 100.0f;
    input.omega_e = 5.0f;
}

static void test_known_acceleration_needs_no_steady_drive_but_a_large_current_and_a_speed(void)
{
    given_known_acceleration();
    TEST_ASSERT_TRUE(doubted());
    begin(&PARAMS);
    TEST_ASSERT_FALSE(doubted());
    given_known_acceleration();
    expect_around_amount(&input.omega_e, 3.0f, false, true, true);
    tuning.current = 0.1f * 4.0f;
    input.current = largest_of(4.0f);
    expect_around(&input.current.alpha, 4.0f, false, false, true);
}

/* The limit is twice 11.594 A at 69 rad/s^2 per ampere, 0.02 rad in 5 ms. */
static void test_known_acceleration_needs_a_small_load_below_at_above(void)
{
    given_known_acceleration();
    for (int sign = -1; sign <= 1; sign += 2) {
        input.load = (float)sign * 11.59f;
        TEST_ASSERT_TRUE(doubted());
        input.load = (float)sign * 11.60f;
        TEST_ASSERT_FALSE(doubted());
    }
}

/* For a light rotor, with 14640 rad/s^2, the limit is 20 mrad of 183 mrad in 5 ms, a share of 0.10929. For
 * a heavy rotor the error may exceed the whole value. */
static void test_known_acceleration_needs_a_speed_gained_as_foreseen_below_at_above(void)
{
    given_known_acceleration();
    input.gained = -200.0f;
    input.foreseen = 200.0f;
    TEST_ASSERT_TRUE(doubted());
    doubt_params_t light = PARAMS;
    light.acceleration_known = true;
    light.acceleration = 14640.0f;
    begin(&light);
    for (int sign = -1; sign <= 1; sign += 2) {
        input.gained = (float)sign * 200.0f;
        for (int more = -1; more <= 1; more += 2) {
            input.foreseen = (float)sign * (200.0f + (float)more * 21.8f);
            TEST_ASSERT_TRUE(doubted());
            input.foreseen = (float)sign * (200.0f + (float)more * 21.9f);
            TEST_ASSERT_FALSE(doubted());
        }
    }
    input.gained = 0.0f;
    input.foreseen = 0.0f;
    TEST_ASSERT_TRUE(doubted());
    input.gained = NAN;
    TEST_ASSERT_FALSE(doubted());
}

/* ---- memory ---- */

/* The number of periods in which the loop coasts: the uncertain period itself and the periods in which it
 * is remembered. */
static uint32_t coasted(void)
{
    uint32_t count = doubted() ? 1u : 0u;
    input.amplitude = 100.0f;
    while (count < 1000u && doubt_step(&doubt, &tuning, &input)) {
        count++;
    }
    return count;
}

/* The observer remembers for three periods, and an EMF filter above 200 rad/s for two time constants,
 * 2/(cutoff T). */
static void test_is_remembered_as_long_as_the_filter_does(void)
{
    static const struct {
        float cutoff;
        uint32_t periods;
    } cases[] = {{0.0f, 3u},          {100.0f, 3u},       {200.0f, 3u},  {201.0f, 3u + 99u},
                 {1300.0f, 3u + 15u}, {2300.0f, 3u + 8u}, {21000.0f, 3u}};
    for (size_t n = 0; n < sizeof cases / sizeof cases[0]; n++) {
        doubt_params_t params = PARAMS;
        params.emf_cutoff = cases[n].cutoff;
        setUp();
        input.omega_e = 9.0f; /* so slow that 102 periods are less than a tenth of the turn */
        begin(&params);
        TEST_ASSERT_EQUAL_UINT32(cases[n].periods, coasted());
    }
}

/* In a turn at omega with the width w = 2 zone/|i| of each of six crossings and m periods of memory, the
 * loop coasts for the share 6 (2 asin(zone/|i|) + omega m T)/(2 pi). This share must be at most a third
 * for every speed, every width of the zone and every m. */
static void test_of_a_turn_no_more_than_a_third_is_coasted(void)
{
    static const double speeds[] = {9.0, 42.0, 150.0, 400.0, 700.0, 900.0, 1100.0, 3000.0};
    for (size_t n = 0; n < sizeof speeds / sizeof speeds[0]; n++) {
        for (int part = 1; part < 40; part += SWEEP_FEW * SWEEP_FEW) {
            const double length = 0.1 * part + 0.2;
            uint32_t coasts = 0u;
            const double turns = SWEEP > 1 ? 1.0 : 20.0;
            const uint32_t periods = (uint32_t)(6.28318530718 * turns / (speeds[n] * 1e-4));
            setUp();
            input.omega_e = (float)speeds[n];
            for (uint32_t k = 0; k < periods; k++) {
                const double angle = speeds[n] * 1e-4 * k;
                input.current = (ab_t){(float)(length * cos(angle)), (float)(length * sin(angle))};
                coasts += doubt_step(&doubt, &tuning, &input) ? 1u : 0u;
            }
            /* A crossing begins and ends with a period, which adds up to two periods to each. */
            TEST_ASSERT_TRUE((double)coasts / periods <=
                             0.3334 + 6.0 * 2.0 * speeds[n] * 1e-4 / 6.28318530718);
        }
    }
}

static void given_remembered_doubt(void)
{
    TEST_ASSERT_TRUE(doubt_step(&doubt, &tuning, &input));
    input.amplitude = 100.0f;
    TEST_ASSERT_TRUE(doubt_step(&doubt, &tuning, &input));
}

static void test_a_new_doubt_begins_the_memory_again(void)
{
    given_remembered_doubt();
    input.amplitude = 7.0f;
    TEST_ASSERT_EQUAL_UINT32(3u, coasted());
}

static void test_memory_ends_with_the_steady_drive(void)
{
    given_remembered_doubt();
    input.detector = 0.5f;
    TEST_ASSERT_FALSE(doubt_step(&doubt, &tuning, &input));
    input.detector = 0.0f;
    TEST_ASSERT_FALSE(doubt_step(&doubt, &tuning, &input));
}

/* Without a filter of the EMF a doubt is remembered for three periods. A bit that flips in this number makes
 * it much larger: the loop tracks again after three periods at the latest. */
static void test_a_flipped_bit_does_not_make_the_loop_coast_for_longer(void)
{
    for (uint32_t bit = 0; bit < 32u; bit++) {
        setUp();
        TEST_ASSERT_EQUAL_UINT32(3u, tuning.memory);
        TEST_ASSERT_TRUE(doubt_step(&doubt, &tuning, &input));
        input.amplitude = 1000.0f; /* no doubt from here on */
        doubt.left ^= UINT32_C(1) << bit;
        uint32_t coasted = 0;
        while (coasted < 100u && doubt_step(&doubt, &tuning, &input)) {
            coasted++;
        }
        TEST_ASSERT_LESS_OR_EQUAL_UINT32(2u, coasted);
        TEST_ASSERT_FALSE(doubt_may_be(&doubt, input.amplitude, input.leg));
    }
}
