/* Parameters that stay, through the whole ring: orders, HAL, the virtual chip's flash, its supply. */
#include <stdlib.h>

#include "host_sim/rig/rig_state.h"
#include "settings/reasons.h"
#include "talk/store.h"
#include "tests/rig/run.h"

static rig_t *rig;

void setUp(void)
{
    rig = run_rig(70);
    run_to_ready(rig);
}

void tearDown(void)
{
    rig_free(rig);
}

static chip_t *chip(void)
{
    return &rig_state(rig)->chip;
}

static bool order(const char *name)
{
    return rig_put(rig, "order", table_choice(rig_row_by_name("order"), name));
}

static void expect_store(const char *state)
{
    TEST_ASSERT_EQUAL_DOUBLE(table_choice(rig_row_by_name("store_state"), state),
                             rig_value(rig, "store_state"));
}

/* Another motor each time: a set that is applied. */
static params_t given_motor(uint32_t number)
{
    run_put(rig, "motor_resistance", 0.5 + 0.01 * number);
    run_put(rig, "motor_flux_linkage", 0.1 + 0.001 * number);
    run_parameter(rig, "encoder_lines", 1024.0 + number);
    return rig_state(rig)->app.active;
}

static params_t given_saved_motor(uint32_t number)
{
    const params_t set = given_motor(number);
    TEST_ASSERT_TRUE(order("save"));
    expect_store("saved");
    return set;
}

static bool runs(const params_t *set)
{
    return memcmp(set, &rig_state(rig)->app.active, sizeof *set) == 0;
}

static void test_a_saved_set_runs_after_the_supply_was_off(void)
{
    expect_store("empty");
    const params_t set = given_saved_motor(7u);
    rig_power_cycle(rig);
    TEST_ASSERT_TRUE(runs(&set));
    run_to_ready(rig);
    expect_store("loaded");
    TEST_ASSERT_EQUAL_DOUBLE(0.0, rig_value(rig, "fault_reason"));
    TEST_ASSERT_EQUAL_DOUBLE((double)(float)0.57, rig_value(rig, "motor_resistance"));
}

/* An erase keeps the interrupt away for two seconds; the drive stands it and can be started right after. */
static void test_the_drive_goes_on_after_a_page_was_erased(void)
{
    const uint32_t fit = 2048u / store_record_words(params_table.count);
    for (uint32_t n = 0; n <= fit; n++) {
        (void)given_saved_motor(n);
    }
    run_seconds(rig, 2.5);
    TEST_ASSERT_EQUAL_DOUBLE(fit + 1.0, rig_value(rig, "store_saves"));
    TEST_ASSERT_EQUAL_DOUBLE(0.0, rig_value(rig, "fault_reason"));
    TEST_ASSERT_EQUAL_DOUBLE(1.0, rig_value(rig, "state"));
    TEST_ASSERT_EQUAL_UINT32(0u, chip_report_total(chip()));
    rig_power_cycle(rig);
    TEST_ASSERT_EQUAL_DOUBLE((double)(0.5f + 0.01f * (float)fit), rig_value(rig, "motor_resistance"));
}

/* The bridge stays off until a reset; then the drive runs on its defaults, and what is saved then is good. */
static void test_a_corrupt_store_refuses_the_bridge_until_a_reset(void)
{
    static uint16_t page[CHIP_FLASH_WORDS];
    const params_t usual = rig_state(rig)->app.active;
    (void)given_saved_motor(7u);
    for (uint32_t at = 0; at < CHIP_FLASH_WORDS; at++) {
        page[at] = chip_flash_word(chip(), 0u, at);
    }
    page[100] ^= 0x0001u;
    TEST_ASSERT_TRUE(chip_flash_fill(chip(), 0u, page));
    rig_power_cycle(rig);
    run_seconds(rig, 0.1);
    expect_store("corrupt");
    TEST_ASSERT_TRUE(runs(&usual));
    TEST_ASSERT_EQUAL_DOUBLE(REASON_STORE_CORRUPT, rig_value(rig, "fault_reason"));
    run_on(rig, 100.0);
    run_seconds(rig, 0.5);
    TEST_ASSERT_EQUAL_DOUBLE(5.0, rig_value(rig, "state"));
    TEST_ASSERT_EQUAL_DOUBLE(0.0, rig_value(rig, "true_omega_m"));

    run_put(rig, "enable", 0.0);
    rig_run(rig, 1u);
    run_put(rig, "fault_reset", 1.0);
    run_seconds(rig, 0.1);
    TEST_ASSERT_EQUAL_DOUBLE(0.0, rig_value(rig, "fault_reason"));
    TEST_ASSERT_EQUAL_DOUBLE(1.0, rig_value(rig, "state"));
    TEST_ASSERT_TRUE(order("save"));
    rig_power_cycle(rig);
    run_to_ready(rig);
    expect_store("loaded");
}

/* ---- cuts of the power ---- */

/* Saves with a cut after each number of operations of the flash, then the supply comes back: the drive runs
 * on the one set or the other. How many operations it takes. */
static uint32_t cut_everywhere(const params_t *before, const char *state_before)
{
    const params_t next = given_motor(99u);
    void *at_first = malloc(rig_state_size());
    TEST_ASSERT_NOT_NULL(at_first);
    rig_save(rig, at_first);
    bool through = false;
    uint32_t cut = 0;
    for (; !through; cut++) {
        TEST_ASSERT_TRUE(rig_load(rig, at_first, rig_state_size()));
        const uint32_t done = chip_flash_operations(chip());
        chip_cut_power(chip(), cut);
        const bool said = order("save");
        through = chip_flash_operations(chip()) - done < cut;
        rig_power_cycle(rig);
        const bool is_old = runs(before);
        TEST_ASSERT_TRUE(is_old || runs(&next));
        TEST_ASSERT_TRUE(!said || !is_old);
        TEST_ASSERT_EQUAL(through, said && through);
        expect_store(is_old ? state_before : "loaded");
        TEST_ASSERT_EQUAL_INT32(REASON_NONE, rig_state(rig)->app.drive.fault_reason);
    }
    free(at_first);
    return cut - 2u;
}

/* Into the page of older sets, which is erased before. */
static void test_cut_in_a_save_that_erases_leaves_old_or_new(void)
{
    const uint32_t words = store_record_words(params_table.count);
    const uint32_t fit = 2048u / words;
    params_t before = given_saved_motor(0u);
    for (uint32_t n = 1; n < 2u * fit; n++) {
        before = given_saved_motor(n);
    }
    TEST_ASSERT_TRUE(cut_everywhere(&before, "loaded") >= words + 2u * 2048u);
}
