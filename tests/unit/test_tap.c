/* A struct of sixteen slots, of which twelve are chosen, in an order of their own. */
#include "contract/tap.h"

#include <string.h>
#include <unity.h>

#define SLOTS 16

typedef struct {
    uint32_t slot[SLOTS];
} source_t;

#define ROW(n)                                                                                               \
    {                                                                                                        \
        700u + (n), (slot_kind_t)((n) % 4), TABLE_READ, offsetof(source_t, slot) + (n) * sizeof(uint32_t),   \
            "slot" #n, "-", "a slot", "", 0.0f, 0.0f, 0.0f,                                                  \
        {                                                                                                    \
            0, 0, 0                                                                                          \
        }                                                                                                    \
    }

static const table_row_t rows[SLOTS] = {ROW(0), ROW(1), ROW(2),  ROW(3),  ROW(4),  ROW(5),  ROW(6),  ROW(7),
                                        ROW(8), ROW(9), ROW(10), ROW(11), ROW(12), ROW(13), ROW(14), ROW(15)};
static const table_t table = {"source", rows, SLOTS};

static const uint32_t chosen[TAP_SLOTS] = {715, 700, 707, 703, 714, 701, 710, 702, 712, 705, 704, 708};

static tap_history_t history;
static source_t source;

void setUp(void)
{
    memset(&history, 0x55, sizeof history);
    TEST_ASSERT_TRUE(tap_history_init(&history, &table, chosen));
}

void tearDown(void)
{
}

/* Every slot of every period differs from every other. */
static uint32_t value_of(uint32_t period, uint32_t slot)
{
    return (period * SLOTS + slot) * UINT32_C(2654435761);
}

static void keep(uint32_t period)
{
    for (uint32_t n = 0; n < SLOTS; n++) {
        source.slot[n] = value_of(period, n);
    }
    tap_history_keep(&history, &source);
}

static void expect_period(uint32_t period, const uint32_t *slots)
{
    for (uint32_t n = 0; n < TAP_SLOTS; n++) {
        TEST_ASSERT_EQUAL_HEX32(value_of(period, chosen[n] - 700u), slots[n]);
    }
}

static void test_copies_chosen_slots_in_their_order(void)
{
    static const size_t offsets[] = {offsetof(source_t, slot) + 5 * sizeof(uint32_t), 0,
                                     offsetof(source_t, slot) + 2 * sizeof(uint32_t)};
    uint32_t slots[4] = {0, 0, 0, UINT32_C(0xABCDEF01)};
    for (uint32_t n = 0; n < SLOTS; n++) {
        source.slot[n] = value_of(1u, n);
    }
    tap_copy(offsets, 3u, &source, slots);
    TEST_ASSERT_EQUAL_HEX32(value_of(1u, 5u), slots[0]);
    TEST_ASSERT_EQUAL_HEX32(value_of(1u, 0u), slots[1]);
    TEST_ASSERT_EQUAL_HEX32(value_of(1u, 2u), slots[2]);
    TEST_ASSERT_EQUAL_HEX32(0xABCDEF01, slots[3]); /* and nothing more */
    tap_copy(offsets, 0u, &source, slots);
    TEST_ASSERT_EQUAL_HEX32(value_of(1u, 5u), slots[0]);
}

/* Bits, not values: a NaN with a payload, minus zero, the least and the largest integer, whatever the row's
 * kind. */
static void test_slots_are_kept_bit_for_bit(void)
{
    static const uint32_t patterns[] = {UINT32_C(0x7FC01234), UINT32_C(0xFFA00001), UINT32_C(0x80000000),
                                        UINT32_C(0x00000001), UINT32_C(0x7F800000), UINT32_C(0xFFFFFFFF),
                                        UINT32_C(0x7FFFFFFF), UINT32_C(0)};
    for (uint32_t p = 0; p < sizeof patterns / sizeof patterns[0]; p++) {
        for (uint32_t n = 0; n < SLOTS; n++) {
            source.slot[n] = patterns[p];
        }
        tap_history_keep(&history, &source);
        for (uint32_t n = 0; n < TAP_SLOTS; n++) {
            TEST_ASSERT_EQUAL_HEX32(patterns[p], tap_history_at(&history, 0u)[n]);
        }
    }
}

static void test_history_begins_empty_and_knows_its_rows(void)
{
    TEST_ASSERT_EQUAL_UINT32(0u, tap_history_count(&history));
    for (uint32_t n = 0; n < TAP_SLOTS; n++) {
        TEST_ASSERT_EQUAL_UINT32(chosen[n], history.ids[n]);
    }
}

/* Through three fillings: the newest is 0 ago, all that are counted are there, in their order. */
static void test_history_keeps_the_last_periods_in_their_order(void)
{
    for (uint32_t period = 0; period < 3u * TAP_PERIODS + 7u; period++) {
        keep(period);
        const uint32_t count = period + 1u < TAP_PERIODS ? period + 1u : TAP_PERIODS;
        TEST_ASSERT_EQUAL_UINT32(count, tap_history_count(&history));
        expect_period(period, tap_history_at(&history, 0u));
        expect_period(period + 1u - count, tap_history_at(&history, count - 1u));
        if (period % 100u == 99u || period % TAP_PERIODS == 0u) {
            for (uint32_t ago = 0; ago < count; ago++) {
                expect_period(period - ago, tap_history_at(&history, ago));
            }
        }
    }
}

static void test_history_does_not_follow_what_changes_later(void)
{
    keep(5u);
    source.slot[15] = 1u;
    expect_period(5u, tap_history_at(&history, 0u));
}

static void test_init_empties_a_history(void)
{
    for (uint32_t period = 0; period < 300u; period++) {
        keep(period);
    }
    TEST_ASSERT_TRUE(tap_history_init(&history, &table, chosen));
    TEST_ASSERT_EQUAL_UINT32(0u, tap_history_count(&history));
    keep(7u);
    TEST_ASSERT_EQUAL_UINT32(1u, tap_history_count(&history));
    expect_period(7u, tap_history_at(&history, 0u));
}

/* Whichever of the twelve it is. */
static void test_an_unknown_id_is_refused_and_nothing_changes(void)
{
    for (uint32_t period = 0; period < 10u; period++) {
        keep(period);
    }
    static tap_history_t before;
    before = history;
    for (uint32_t n = 0; n < TAP_SLOTS; n++) {
        uint32_t ids[TAP_SLOTS] = {700, 701, 702, 703, 704, 705, 706, 707, 708, 709, 710, 711};
        ids[n] = 716u;
        TEST_ASSERT_FALSE(tap_history_init(&history, &table, ids));
        TEST_ASSERT_EQUAL_MEMORY(&before, &history, sizeof history);
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_copies_chosen_slots_in_their_order);
    RUN_TEST(test_slots_are_kept_bit_for_bit);
    RUN_TEST(test_history_begins_empty_and_knows_its_rows);
    RUN_TEST(test_history_keeps_the_last_periods_in_their_order);
    RUN_TEST(test_history_does_not_follow_what_changes_later);
    RUN_TEST(test_init_empties_a_history);
    RUN_TEST(test_an_unknown_id_is_refused_and_nothing_changes);
    return UNITY_END();
}
