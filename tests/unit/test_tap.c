/* A struct of sixteen slots, of which twelve are chosen, in an order of their own. */
#include "contract/tap.h"

#include <string.h>
#include <unity.h>

#define SLOTS 16

typedef struct {
    uint32_t slot[SLOTS];
} source_t;

static const uint32_t chosen[TAP_SLOTS] = {15, 0, 7, 3, 14, 1, 10, 2, 12, 5, 4, 8};
static size_t offsets[TAP_SLOTS];

static tap_history_t history;
static source_t source;

void setUp(void)
{
    memset(&history, 0x55, sizeof history);
    tap_history_clear(&history);
    for (uint32_t n = 0; n < TAP_SLOTS; n++) {
        offsets[n] = offsetof(source_t, slot) + chosen[n] * sizeof(uint32_t);
    }
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
    tap_copy(offsets, TAP_SLOTS, &source, tap_history_next(&history));
}

static void expect_period(uint32_t period, const uint32_t *slots)
{
    for (uint32_t n = 0; n < TAP_SLOTS; n++) {
        TEST_ASSERT_EQUAL_HEX32(value_of(period, chosen[n]), slots[n]);
    }
}

static void test_copies_chosen_slots_in_their_order(void)
{
    static const size_t of_three[] = {offsetof(source_t, slot) + 5 * sizeof(uint32_t), 0,
                                      offsetof(source_t, slot) + 2 * sizeof(uint32_t)};
    uint32_t slots[4] = {0, 0, 0, UINT32_C(0xABCDEF01)};
    for (uint32_t n = 0; n < SLOTS; n++) {
        source.slot[n] = value_of(1u, n);
    }
    tap_copy(of_three, 3u, &source, slots);
    TEST_ASSERT_EQUAL_HEX32(value_of(1u, 5u), slots[0]);
    TEST_ASSERT_EQUAL_HEX32(value_of(1u, 0u), slots[1]);
    TEST_ASSERT_EQUAL_HEX32(value_of(1u, 2u), slots[2]);
    TEST_ASSERT_EQUAL_HEX32(0xABCDEF01, slots[3]); /* and nothing more */
    tap_copy(of_three, 0u, &source, slots);
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
        tap_copy(offsets, TAP_SLOTS, &source, tap_history_next(&history));
        for (uint32_t n = 0; n < TAP_SLOTS; n++) {
            TEST_ASSERT_EQUAL_HEX32(patterns[p], tap_history_at(&history, 0u)[n]);
        }
    }
}

static void test_history_begins_empty(void)
{
    TEST_ASSERT_EQUAL_UINT32(0u, tap_history_count(&history));
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

static void test_clear_empties_a_history(void)
{
    for (uint32_t period = 0; period < 300u; period++) {
        keep(period);
    }
    tap_history_clear(&history);
    TEST_ASSERT_EQUAL_UINT32(0u, tap_history_count(&history));
    keep(7u);
    TEST_ASSERT_EQUAL_UINT32(1u, tap_history_count(&history));
    expect_period(7u, tap_history_at(&history, 0u));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_copies_chosen_slots_in_their_order);
    RUN_TEST(test_slots_are_kept_bit_for_bit);
    RUN_TEST(test_history_begins_empty);
    RUN_TEST(test_history_keeps_the_last_periods_in_their_order);
    RUN_TEST(test_history_does_not_follow_what_changes_later);
    RUN_TEST(test_clear_empties_a_history);
    return UNITY_END();
}
