/* The offsets of the current sensors while the bridge is off: they are found block by block, kept if they
 * have hardly moved, not changed while a current flows, and refused if they are too large. */
#include "fast/measure.h"

#include "tests/unit/compare.h"

#define SETTLE 64u
#define BLOCK  512u
#define SHARE  ((float)DRIVE_CURRENT_RANGE / 20.0f) /* [-] range of the board's sensors relative to 20 A */

static measure_t measure;
static measure_tuning_t tuning;
static drive_samples_t samples;
static ab_t trim;

void setUp(void)
{
    params_t params;
    params_defaults(&params);
    params.calibration_periods = (int32_t)BLOCK;
    params.current_offset_max = 1.0f * SHARE;
    tuning = measure_prepare(&params);
    measure_init(&measure);
    memset(&samples, 0, sizeof samples);
    samples.u_dc = 311.0f;
    trim = (ab_t){0.0f, 0.0f};
}

static bool period(double a, double b)
{
    samples.i_a = (float)a * SHARE;
    samples.i_b = (float)b * SHARE;
    samples.i_c = -samples.i_a - samples.i_b;
    measure_step(&measure, &samples, trim);
    return measure_rest(&measure, &tuning, &samples, trim);
}

static uint32_t periods(double a, double b, uint32_t count)
{
    uint32_t moved = 0u;
    for (uint32_t n = 0; n < count; n++) {
        moved += period(a, b) ? 1u : 0u;
    }
    return moved;
}

static void expect_offset(double a, double b)
{
    TEST_ASSERT_FLOAT_WITHIN(1e-4f * SHARE, (float)a * SHARE, measure.offset.a);
    TEST_ASSERT_FLOAT_WITHIN(1e-4f * SHARE, (float)b * SHARE, measure.offset.b);
    TEST_ASSERT_FLOAT_WITHIN(2e-4f * SHARE, (float)(-a - b) * SHARE, measure.offset.c);
}

/* The offset changes after 64 periods of settling and 512 of the block, and again 512 later: not earlier,
 * and not between these. */
static void test_an_offset_that_has_moved_is_taken_at_the_end_of_a_block(void)
{
    TEST_ASSERT_EQUAL_UINT32(0u, periods(0.5, -0.2, SETTLE + BLOCK - 1u));
    expect_offset(0.0, 0.0);
    TEST_ASSERT_EQUAL_INT32(CALIBRATION_GOES_ON, measure.rest.found);
    TEST_ASSERT_TRUE(period(0.5, -0.2));
    expect_offset(0.5, -0.2);
    TEST_ASSERT_EQUAL_INT32(CALIBRATION_GOOD, measure.rest.found);
    TEST_ASSERT_EQUAL_UINT32(0u, periods(-0.4, 0.3, BLOCK - 1u));
    TEST_ASSERT_TRUE(period(-0.4, 0.3));
    expect_offset(-0.4, 0.3);
}

/* The limit is 0.5 % of the range of the sensors, for the length of the vector: a alone has 2/3 of it
 * along alpha. The result of the trim during rotation belongs to the sensor, too; if it agrees, no offset
 * has moved. */
static void test_what_has_hardly_moved_stays(void)
{
    TEST_ASSERT_EQUAL_UINT32(0u, periods(0.099, -0.0495, SETTLE + 3u * BLOCK));
    expect_offset(0.0, 0.0);
    TEST_ASSERT_EQUAL_INT32(CALIBRATION_GOOD, measure.rest.found);
    TEST_ASSERT_EQUAL_UINT32(1u, periods(0.101, -0.0505, BLOCK));
    expect_offset(0.101, -0.0505);
    setUp();
    trim.alpha = 0.5f * SHARE;
    TEST_ASSERT_EQUAL_UINT32(0u, periods(0.5, -0.25, SETTLE + 2u * BLOCK));
    expect_offset(0.0, 0.0);
    TEST_ASSERT_EQUAL_UINT32(1u, periods(0.0, 0.0, BLOCK)); /* in this case the trim is wrong */
}

static void test_an_offset_beyond_its_limit_is_reported_and_not_taken(void)
{
    (void)periods(0.5, 0.0, SETTLE + BLOCK);
    TEST_ASSERT_EQUAL_UINT32(0u, periods(1.1, 0.0, 2u * BLOCK));
    expect_offset(0.5, 0.0);
    TEST_ASSERT_EQUAL_INT32(CALIBRATION_FAILED, measure.rest.found);
    TEST_ASSERT_EQUAL_UINT32(0u, periods(0.0, -1.1, 2u * BLOCK));
    TEST_ASSERT_EQUAL_INT32(CALIBRATION_FAILED, measure.rest.found);
    (void)periods(0.6, 0.0, 2u * BLOCK); /* the offset has returned */
    TEST_ASSERT_EQUAL_INT32(CALIBRATION_GOOD, measure.rest.found);
}

/* In a rotor that feeds the link each phase conducts near its crests, twice per turn. A block with this
 * current gives no result, at any position of the turns within the block. */
static void test_a_rotor_that_feeds_the_link_is_no_offset(void)
{
    for (double hertz = 15.0; hertz < 400.0; hertz *= 1.3) {
        setUp();
        (void)periods(0.3, 0.0, SETTLE + BLOCK);
        for (uint32_t n = 0; n < 5000u; n++) {
            const double phase = 2.0 * PI * hertz * 1e-4 * n;
            const double crest_a = fmax(0.0, fabs(sin(phase)) - 0.8) * copysign(2.0, sin(phase));
            const double crest_b = fmax(0.0, fabs(sin(phase - 2.1)) - 0.8) * copysign(2.0, sin(phase - 2.1));
            TEST_ASSERT_FALSE(period(0.3 + crest_a, crest_b));
        }
        expect_offset(0.3, 0.0);
        TEST_ASSERT_EQUAL_INT32(CALIBRATION_GOOD, measure.rest.found);
    }
}

/* The calibration contains a current whose mean over 2.3 turns is (1 - cos(0.3 x 2 pi))/(2.3 x 2 pi) of
 * 0.5 A, 45 mA. The first quiet block replaces the result although the difference is below the limit for a
 * moved offset. */
static void test_a_calibration_beside_a_current_is_replaced(void)
{
    for (uint32_t n = 0; n < SETTLE + BLOCK; n++) {
        const double current = 0.5 * sin(2.0 * PI * 45.0 * 1e-4 * (n - (double)SETTLE));
        samples.i_a = (float)current * SHARE;
        samples.i_b = (float)(-0.5 * current) * SHARE;
        samples.i_c = -samples.i_a - samples.i_b;
        measure_step(&measure, &samples, trim);
        TEST_ASSERT_EQUAL(n + 1u < SETTLE + BLOCK ? CALIBRATION_GOES_ON : CALIBRATION_GOOD,
                          measure_calibrate(&measure, &tuning, &samples));
    }
    TEST_ASSERT_FLOAT_WITHIN(0.003f * SHARE, 0.045f * SHARE, measure.offset.a);
    TEST_ASSERT_EQUAL_UINT32(1u, periods(0.01, 0.0, SETTLE + BLOCK));
    expect_offset(0.01, 0.0);
    TEST_ASSERT_EQUAL_UINT32(0u, periods(0.03, 0.0, 2u * BLOCK));
}

/* A low-pass of 1.5 % per period has a third of a step of 0.3 A after ln(2/3)/ln(0.985) = 26.8 periods.
 * From then on no start is allowed, until a block contains the step completely. If the step is in the
 * middle of a block, the block shows only a part of it. A new calibration is then due if the rest exceeds
 * a quarter of the usual limit: in this test 0.117 A in the 27th period, or 0.025 A in the 16th period of
 * the next block. */
static void test_a_step_is_due_until_it_is_measured(void)
{
    const uint32_t before = 200u;
    (void)periods(0.0, 0.0, SETTLE + BLOCK + before);
    (void)periods(0.3, -0.15, 26u);
    TEST_ASSERT_EQUAL_INT32(CALIBRATION_GOOD, measure_found(&measure));
    (void)periods(0.3, -0.15, 1u);
    TEST_ASSERT_EQUAL_INT32(CALIBRATION_DUE, measure_found(&measure));
    (void)periods(0.3, -0.15, BLOCK - before - 28u);
    TEST_ASSERT_EQUAL_INT32(CALIBRATION_DUE, measure_found(&measure));
    (void)periods(0.3, -0.15, 1u);
    TEST_ASSERT_FLOAT_WITHIN(1e-4f, 0.3f * SHARE * (float)(BLOCK - before) / (float)BLOCK, measure.offset.a);
    (void)periods(0.3, -0.15, 15u);
    TEST_ASSERT_EQUAL_INT32(CALIBRATION_GOOD, measure_found(&measure));
    (void)periods(0.3, -0.15, 1u);
    TEST_ASSERT_EQUAL_INT32(CALIBRATION_DUE, measure_found(&measure));
    (void)periods(0.3, -0.15, BLOCK - 16u);
    TEST_ASSERT_EQUAL_INT32(CALIBRATION_GOOD, measure_found(&measure));
    expect_offset(0.3, -0.15);
}

/* A step by more than the span of a quiet block, 0.4 A, restarts the block. A whole block later the
 * measured offset is the new one, and until then no start is allowed. */
static void test_a_step_beyond_the_span_of_a_block_restarts_it(void)
{
    for (int way = -1; way <= 1; way += 2) {
        setUp();
        (void)periods(0.0, 0.0, SETTLE + BLOCK + 300u);
        TEST_ASSERT_EQUAL_UINT32(0u, periods(way * 0.5, 0.0, BLOCK - 1u));
        TEST_ASSERT_EQUAL_INT32(CALIBRATION_DUE, measure_found(&measure));
        TEST_ASSERT_EQUAL_UINT32(1u, periods(way * 0.5, 0.0, 1u));
        TEST_ASSERT_EQUAL_INT32(CALIBRATION_GOOD, measure_found(&measure));
        expect_offset(way * 0.5, 0.0);
    }
}

/* A current changes repeatedly by this amount, and other checks detect it. No calibration is then due
 * until the current has been constant for 12.8 ms. */
static void test_two_steps_in_a_short_time_are_a_current(void)
{
    (void)periods(0.0, 0.0, SETTLE + BLOCK + 300u);
    (void)periods(0.5, 0.0, 100u);
    TEST_ASSERT_EQUAL_INT32(CALIBRATION_DUE, measure_found(&measure));
    (void)periods(1.0, 0.0, 128u);
    TEST_ASSERT_EQUAL_INT32(CALIBRATION_GOOD, measure_found(&measure));
    (void)periods(1.0, 0.0, 1u);
    TEST_ASSERT_EQUAL_INT32(CALIBRATION_DUE, measure_found(&measure));
}

static void test_what_is_left_to_the_trim_is_not_due(void)
{
    trim.alpha = 0.2f * SHARE;
    (void)periods(0.29, -0.145, SETTLE + BLOCK);
    TEST_ASSERT_EQUAL_INT32(CALIBRATION_GOOD, measure_found(&measure));
    (void)periods(1.1, 0.0, BLOCK);
    /* The offset exceeds the limit of a due calibration. */
    TEST_ASSERT_EQUAL_INT32(CALIBRATION_FAILED, measure_found(&measure));
    measure_begin_rest(&measure);
    TEST_ASSERT_EQUAL_INT32(CALIBRATION_GOES_ON, measure_found(&measure));
}

/* Noise of 1 A in both directions has a low-passed current, too, and so has a rotor that feeds the link.
 * The first sample of a block has no span yet. */
static void test_nothing_is_due_where_a_current_flows(void)
{
    uint32_t due = 0u;
    for (uint32_t n = 0; n < SETTLE + 3u * BLOCK; n++) {
        (void)period(n % 2u == 0u ? 1.3 : -0.7, 0.0);
        due += measure_found(&measure) == CALIBRATION_DUE ? 1u : 0u;
    }
    TEST_ASSERT_LESS_OR_EQUAL_UINT32(2u, due);
    expect_offset(0.0, 0.0);
}

/* The bridge was on: the currents decay, the sensors settle, and the earlier result is no longer valid. */
static void test_a_run_in_between_begins_again(void)
{
    (void)periods(0.5, 0.0, SETTLE + 2u * BLOCK + 100u); /* the second block confirms the first one */
    measure_begin_rest(&measure);
    TEST_ASSERT_EQUAL_INT32(CALIBRATION_GOES_ON, measure.rest.found);
    TEST_ASSERT_EQUAL_UINT32(0u, periods(8.0, -3.0, SETTLE)); /* the trim of the last run */
    TEST_ASSERT_EQUAL_UINT32(0u, periods(0.5, 0.0, BLOCK));
    expect_offset(0.5, 0.0);
    TEST_ASSERT_EQUAL_INT32(CALIBRATION_GOOD, measure.rest.found);
}

static void test_what_is_not_a_measurement_is_left_out(void)
{
    (void)periods(0.5, 0.0, SETTLE + 200u);
    for (int n = 0; n < 100; n++) {
        samples.i_a = NAN;
        measure_step(&measure, &samples, trim);
        TEST_ASSERT_FALSE(measure_rest(&measure, &tuning, &samples, trim));
    }
    TEST_ASSERT_EQUAL_UINT32(1u, periods(0.5, 0.0, BLOCK - 200u));
    expect_offset(0.5, 0.0);
}

/* The length of the block changes during a block, which is discarded. */
static void test_new_coefficients_begin_a_new_block(void)
{
    params_t params;
    (void)periods(0.5, 0.0, SETTLE + 300u);
    params_defaults(&params);
    params.calibration_periods = 16;
    params.current_offset_max = 1.0f * SHARE;
    tuning = measure_prepare(&params);
    measure_take(&measure);
    TEST_ASSERT_EQUAL_UINT32(0u, periods(0.5, 0.0, SETTLE + 15u));
    TEST_ASSERT_TRUE(period(0.5, 0.0));
    expect_offset(0.5, 0.0);
}
