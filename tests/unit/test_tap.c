/* A struct of sixteen slots. */
#include "contract/tap.h"

#include <string.h>
#include <unity.h>

#define SLOTS 16

typedef struct {
    uint32_t slot[SLOTS];
} source_t;

static source_t source;

/* Every slot differs from every other. */
static uint32_t value_of(uint32_t period, uint32_t slot)
{
    return (period * SLOTS + slot) * UINT32_C(2654435761);
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
static void test_slots_are_copied_bit_for_bit(void)
{
    static const uint32_t patterns[] = {UINT32_C(0x7FC01234), UINT32_C(0xFFA00001), UINT32_C(0x80000000),
                                        UINT32_C(0x00000001), UINT32_C(0x7F800000), UINT32_C(0xFFFFFFFF),
                                        UINT32_C(0x7FFFFFFF), UINT32_C(0)};
    static const size_t all[] = {0, offsetof(source_t, slot) + 15 * sizeof(uint32_t)};
    for (uint32_t p = 0; p < sizeof patterns / sizeof patterns[0]; p++) {
        uint32_t slots[2] = {1u, 1u};
        for (uint32_t n = 0; n < SLOTS; n++) {
            source.slot[n] = patterns[p];
        }
        tap_copy(all, 2u, &source, slots);
        TEST_ASSERT_EQUAL_HEX32(patterns[p], slots[0]);
        TEST_ASSERT_EQUAL_HEX32(patterns[p], slots[1]);
    }
}
