/* The self-test of the processor, with memories that belong to the test. */
#include "app/self_watch.h"

#include "tests/unit/compare.h"

#define WORDS 100u

static uint16_t memories[HAL_REGIONS][WORDS];
static params_t params;
static self_watch_t watch;

hal_memory_t hal_memory(hal_region_t region)
{
    /* The memories have different lengths. */
    return (hal_memory_t){memories[region], WORDS - (uint32_t)region};
}

/* The number of calls for a whole round through the longest memory, plus one call that finds a change. */
static uint32_t calls_of_a_round(void)
{
    const uint32_t longest = WORDS > 2u * params_table.count ? WORDS : 2u * params_table.count;
    return SELF_WATCH_MEMORIES * ((longest + SELF_WATCH_WORDS - 1u) / SELF_WATCH_WORDS + 1u);
}

static void look(uint32_t calls)
{
    for (uint32_t n = 0; n < calls; n++) {
        self_watch_step(&watch, &params);
    }
}

void setUp(void)
{
    for (uint32_t n = 0; n < WORDS; n++) {
        for (uint32_t region = 0; region < (uint32_t)HAL_REGIONS; region++) {
            memories[region][n] = (uint16_t)(n * 0x9E37u + region);
        }
    }
    params_defaults(&params);
    memset(&watch, 0, sizeof watch);
    self_watch_accept(&watch, &params);
    look(calls_of_a_round());
}

static void test_nothing_is_found_where_nothing_changes(void)
{
    look(50u * calls_of_a_round());
    TEST_ASSERT_EQUAL_HEX32(0u, watch.found);
}

/* The change is found within two rounds, since the test may just have passed the place. */
static void test_a_bit_of_any_word_of_any_memory_is_found_and_stays_found(void)
{
    for (uint32_t region = 0; region < (uint32_t)HAL_REGIONS; region++) {
        for (uint32_t n = 0; n < WORDS - region; n++) {
            setUp();
            memories[region][n] = (uint16_t)(memories[region][n] ^ 1u << n % 16u);
            look(2u * calls_of_a_round());
            TEST_ASSERT_EQUAL_HEX32(UINT32_C(1) << region, watch.found);
            memories[region][n] = (uint16_t)(memories[region][n] ^ 1u << n % 16u);
            look(2u * calls_of_a_round());
            TEST_ASSERT_EQUAL_HEX32(UINT32_C(1) << region, watch.found);
        }
    }
}

static void test_a_changed_parameter_is_found_whichever_it_is_until_a_set_is_taken_over(void)
{
    for (uint32_t n = 0; n < params_table.count; n++) {
        setUp();
        uint32_t slot;
        char *place = (char *)&params + params_table.rows[n].offset;
        memcpy(&slot, place, sizeof slot);
        slot ^= UINT32_C(1) << n % 32u;
        memcpy(place, &slot, sizeof slot);
        look(2u * calls_of_a_round());
        TEST_ASSERT_EQUAL_HEX32(UINT32_C(1) << SELF_WATCH_PARAMS, watch.found);
        self_watch_accept(&watch, &params);
        look(2u * calls_of_a_round());
        TEST_ASSERT_EQUAL_HEX32(0u, watch.found);
    }
}

static void test_new_parameters_are_no_change_at_any_time(void)
{
    for (uint32_t calls = 0; calls < 2u * calls_of_a_round(); calls++) {
        look(calls % 7u);
        params.current_limit += 0.001f;
        self_watch_accept(&watch, &params);
        look(calls);
        TEST_ASSERT_EQUAL_HEX32(0u, watch.found);
    }
}
