/* The captured struct has twenty slots of every kind, described by a table. Its values differ in each
 * period, so that each row can be identified. */
#include "contract/capture.h"

#include "math/float_bits.h"
#include "tests/unit/compare.h"

#define SLOTS 16

typedef struct {
    uint32_t slot[SLOTS];
    float speed;
    int32_t state;
    uint32_t count;
    int32_t position;
} source_t;

static table_row_t rows[SLOTS + 4];
static const table_t table = {"signals", rows, SLOTS + 4};

static void describe(uint32_t row, uint32_t id, slot_kind_t kind, size_t offset)
{
    rows[row] = (table_row_t){
        .id = id, .kind = kind, .offset = offset, .name = "", .unit = "-", .text = "", .choices = ""};
}

static const capture_wish_t usual = {
    .on = CAPTURE_ON_FAULT,
    .columns = 12u,
    .id = {2015, 2000, 2007, 2003, 2014, 2001, 2010, 2002, 2012, 2005, 2004, 2008},
};
#define USUAL_PERIODS 341u /* [periods] 4096 / 12 */

static capture_t capture;
static capture_tuning_t default_tuning;
static source_t source;
static uint32_t period;

static capture_tuning_t prepared(const capture_wish_t *wish)
{
    capture_tuning_t tuning;
    TEST_ASSERT_EQUAL_UINT32(CAPTURE_GOOD, capture_prepare(wish, &table, &tuning));
    return tuning;
}

void setUp(void)
{
    memset(&capture, 0x55, sizeof capture);
    memset(&source, 0, sizeof source);
    period = 0u;
    for (uint32_t n = 0; n < SLOTS; n++) {
        describe(n, 2000u + n, SLOT_UINT, offsetof(source_t, slot) + n * sizeof source.slot[0]);
    }
    describe(SLOTS, 2100u, SLOT_FLOAT, offsetof(source_t, speed));
    describe(SLOTS + 1u, 2101u, SLOT_ENUM, offsetof(source_t, state));
    describe(SLOTS + 2u, 2102u, SLOT_UINT, offsetof(source_t, count));
    describe(SLOTS + 3u, 2103u, SLOT_INT, offsetof(source_t, position));
    default_tuning = prepared(&usual);
    capture_init(&capture, &default_tuning);
}

/* Every slot in every period has another value. */
static uint32_t value_of(uint32_t when, uint32_t slot)
{
    return (when * SLOTS + slot) * UINT32_C(2654435761);
}

static void step(void)
{
    period++;
    for (uint32_t n = 0; n < SLOTS; n++) {
        source.slot[n] = value_of(period, n);
    }
    capture_step(&capture, &source, period);
}

static void steps(uint32_t count)
{
    for (uint32_t n = 0; n < count; n++) {
        step();
    }
}

static void arm(const capture_wish_t *wish)
{
    const capture_tuning_t tuning = prepared(wish);
    capture_arm(&capture, &tuning);
}

/* The record contains whole rows of these ids, without a gap, from the period `first` to `last`. */
static void expect_rows(const uint32_t *id, uint32_t columns, uint32_t first, uint32_t last)
{
    TEST_ASSERT_EQUAL_UINT32(columns, capture.tuning.columns);
    TEST_ASSERT_EQUAL_UINT32(last - first + 1u, capture_count(&capture));
    TEST_ASSERT_EQUAL_UINT32(last, capture.newest);
    for (uint32_t n = 0; n < capture_count(&capture); n++) {
        const uint32_t *row = capture_row(&capture, n);
        for (uint32_t c = 0; c < columns; c++) {
            TEST_ASSERT_EQUAL_HEX32(value_of(first + n, id[c] - 2000u), row[c]);
        }
    }
}

static void expect_state(capture_state_t state)
{
    TEST_ASSERT_EQUAL_UINT32(state, capture.state);
}

/* ---- the ring ---- */

/* The record has the last periods in their order and uses the whole memory, also across the end of the
 * ring buffer. */
static void test_each_number_of_columns_uses_the_whole_ring(void)
{
    for (uint32_t columns = 1; columns <= CAPTURE_COLUMNS; columns++) {
        capture_wish_t wish = usual;
        wish.columns = columns;
        wish.on = CAPTURE_ON_COMMAND;
        arm(&wish);
        const uint32_t before = period;
        const uint32_t room = columns <= 8u ? 512u : USUAL_PERIODS;
        TEST_ASSERT_EQUAL_UINT32(room, capture_room(columns));
        for (uint32_t n = 1; n <= 3u * room + 7u; n++) {
            step();
            if (n < 3u || n % 500u == 0u || n % room < 2u) {
                expect_rows(wish.id, columns, n < room ? before + 1u : period - room + 1u, period);
            }
        }
    }
    TEST_ASSERT_EQUAL_UINT32(512u, capture_room(8u));
}

/* ---- a fault ---- */

/* The fault occurs within a step, before its row is stored, or between two steps: the newest period is
 * that of the fault. */
static void test_fault_holds_with_its_own_period_the_newest(void)
{
    for (uint32_t within = 0; within < 2u; within++) {
        setUp();
        steps(1000u);
        capture_trigger(&capture, 1000u + within);
        expect_state(within != 0u ? CAPTURE_TRIGGERED : CAPTURE_HELD);
        steps(within);
        expect_state(CAPTURE_HELD);
        steps(500u);
        TEST_ASSERT_EQUAL_UINT32(1000u + within, capture.at);
        expect_rows(usual.id, 12u, 1000u + within - USUAL_PERIODS + 1u, 1000u + within);
    }
}

static void test_reset_empties_only_what_was_not_requested(void)
{
    for (int asked = 0; asked < 2; asked++) {
        setUp();
        if (asked != 0) {
            arm(&usual);
        }
        steps(20u);
        capture_trigger(&capture, 20u);
        capture_reset(&capture);
        expect_state(asked != 0 ? CAPTURE_HELD : CAPTURE_IDLE);
        steps(3u);
        expect_rows(usual.id, 12u, asked != 0 ? 1u : 21u, asked != 0 ? 20u : 23u);
    }
}

static void test_a_fault_triggers_with_any_trigger(void)
{
    static const int32_t triggers[] = {CAPTURE_ON_ABOVE, CAPTURE_ON_BELOW, CAPTURE_ON_COMMAND};
    for (uint32_t n = 0; n < 3u; n++) {
        capture_wish_t wish = usual;
        wish.on = triggers[n];
        wish.source = 2100u;
        arm(&wish);
        steps(10u);
        capture_trigger(&capture, period);
        expect_state(CAPTURE_HELD);
        capture_trigger(&capture, period + 1u);
        TEST_ASSERT_EQUAL_UINT32(period, capture.at); /* the first one is stored */
    }
}

static void test_fault_before_the_first_step_holds_an_empty_ring(void)
{
    capture_trigger(&capture, 0u);
    steps(5u);
    expect_state(CAPTURE_HELD);
    TEST_ASSERT_EQUAL_UINT32(0u, capture_count(&capture));
}

/* ---- edges ---- */

static void speed_step(float speed)
{
    source.speed = speed;
    step();
}

static capture_wish_t on_speed(int32_t on, float level)
{
    capture_wish_t wish = usual;
    wish.on = on;
    wish.source = 2100u;
    wish.level = level;
    return wish;
}

/* The trigger is not at the level itself but in the first period beyond it. A signal that is beyond the
 * level from the start must return first. A value that is not a number exceeds no level. */
static void test_value_that_passes_its_level_triggers_with_its_period(void)
{
    static const struct {
        int32_t on;
        float level, speeds[4]; /* the last speed triggers */
    } cases[] = {{CAPTURE_ON_ABOVE, 10.0f, {8.0f, 9.0f, 10.0f, 10.000001f}},
                 {CAPTURE_ON_BELOW, -2.5f, {4.0f, 3.0f, -2.5f, -2.75f}},
                 {CAPTURE_ON_ABOVE, 10.0f, {11.0f, 12.0f, 9.0f, 11.0f}},
                 {CAPTURE_ON_ABOVE, 10.0f, {8.0f, 9.0f, NAN, INFINITY}}};
    for (size_t n = 0; n < sizeof cases / sizeof cases[0]; n++) {
        const capture_wish_t wish = on_speed(cases[n].on, cases[n].level);
        setUp();
        arm(&wish);
        for (size_t k = 0; k < 4u; k++) {
            expect_state(CAPTURE_ARMED);
            speed_step(cases[n].speeds[k]);
        }
        expect_state(CAPTURE_HELD);
        TEST_ASSERT_EQUAL_UINT32(4u, capture.at);
        speed_step(9.0f);
        expect_rows(usual.id, 12u, 1u, 4u);
    }
}

static void test_edge_is_followed_by_the_requested_number_of_periods(void)
{
    capture_wish_t wish = on_speed(CAPTURE_ON_ABOVE, 10.0f);
    wish.columns = 8u;
    wish.after = 256u;
    arm(&wish);
    speed_step(0.0f);
    steps(999u);
    speed_step(11.0f);
    steps(255u);
    expect_state(CAPTURE_TRIGGERED);
    step();
    expect_state(CAPTURE_HELD);
    steps(700u);
    TEST_ASSERT_EQUAL_UINT32(1001u, capture.at);
    expect_rows(usual.id, 8u, 1001u + 256u - 511u, 1001u + 256u);
}

/* The tested values include the sign bit of an int and the upper half of a uint. */
static void test_whole_values_trigger_by_their_own_kind(void)
{
    static const struct {
        int32_t on;
        uint32_t source;
        float level;
        uint32_t before, beyond; /* bits of the slot before and beyond the level */
    } cases[] = {{CAPTURE_ON_BELOW, 2103u, -1.5f, UINT32_MAX, UINT32_MAX - 1u},
                 {CAPTURE_ON_ABOVE, 2102u, 3e9f, UINT32_C(2900000000), UINT32_C(3100000000)},
                 {CAPTURE_ON_ABOVE, 2101u, 4.5f, 4u, 5u}};
    for (size_t n = 0; n < sizeof cases / sizeof cases[0]; n++) {
        capture_wish_t wish = on_speed(cases[n].on, cases[n].level);
        wish.source = cases[n].source;
        arm(&wish);
        table_set_bits(table_by_id(&table, wish.source), &source, cases[n].before);
        step();
        expect_state(CAPTURE_ARMED);
        table_set_bits(table_by_id(&table, wish.source), &source, cases[n].beyond);
        step();
        expect_state(CAPTURE_HELD);
    }
}

/* ---- command, arming, release ---- */

static void test_held_until_armed_again_or_released(void)
{
    capture_wish_t wish = on_speed(CAPTURE_ON_ABOVE, 10.0f);
    arm(&wish);
    speed_step(0.0f);
    speed_step(11.0f);
    for (int n = 0; n < 2000; n++) {
        speed_step(n % 2 == 0 ? 0.0f : 20.0f);
    }
    expect_state(CAPTURE_HELD);
    expect_rows(usual.id, 12u, 1u, 2u);

    arm(&wish);
    expect_state(CAPTURE_ARMED);
    speed_step(0.0f);
    expect_rows(usual.id, 12u, period, period);
    speed_step(11.0f);
    capture_release(&capture, &default_tuning);
    expect_state(CAPTURE_IDLE);
    speed_step(0.0f);
    speed_step(11.0f);
    expect_state(CAPTURE_IDLE);
    expect_rows(usual.id, 12u, period - 1u, period);
}

/* ---- requests that are refused ---- */

static void expect_refused(uint32_t refusal, const capture_wish_t *wish)
{
    capture_tuning_t tuning = default_tuning;
    TEST_ASSERT_EQUAL_UINT32(refusal, capture_prepare(wish, &table, &tuning));
    TEST_ASSERT_EQUAL_MEMORY(&default_tuning, &tuning, sizeof tuning);
}

static void test_request_is_refused_for_what_is_wrong_with_it(void)
{
    capture_wish_t wish = on_speed(4, 1.0f);
    expect_refused(CAPTURE_BAD_ON, &wish);
    wish.on = -1;
    expect_refused(CAPTURE_BAD_ON, &wish);
    wish = on_speed(CAPTURE_ON_ABOVE, 1.0f);
    wish.source = 2099u;
    expect_refused(CAPTURE_BAD_SOURCE, &wish);
    wish = on_speed(CAPTURE_ON_BELOW, NAN);
    expect_refused(CAPTURE_BAD_LEVEL, &wish);
    wish = usual;
    wish.columns = 0u;
    expect_refused(CAPTURE_BAD_COLUMNS, &wish);
    wish.columns = 13u;
    expect_refused(CAPTURE_BAD_COLUMNS, &wish);
    wish = usual;
    wish.after = USUAL_PERIODS;
    expect_refused(CAPTURE_BAD_AFTER, &wish);
    wish = usual;
    wish.id[0] = 1u;
    expect_refused(CAPTURE_BAD_ID, &wish);
    wish = usual;
    wish.id[11] = 2104u;
    expect_refused(CAPTURE_BAD_ID + 11u, &wish);
}

static void test_what_a_request_does_not_use_may_be_anything(void)
{
    capture_wish_t wish = usual;
    wish.source = 1u;
    wish.level = NAN;
    wish.columns = 11u;
    wish.id[11] = 1u;
    wish.after = USUAL_PERIODS - 1u;
    arm(&wish);
    steps(1000u);
    capture_trigger(&capture, period);
    steps(1000u);
    expect_rows(usual.id, 11u, 1000u, 1340u); /* the period of the trigger is the oldest */
    TEST_ASSERT_EQUAL_UINT32(1000u, capture.at);
}
