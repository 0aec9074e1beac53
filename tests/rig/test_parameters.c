/* Saved parameters in the whole simulation: orders, HAL, flash of the virtual chip, supply.
 * tests/unit/test_app.c tests a drive whose stored parameters are damaged. */
#include "host_sim/rig/rig_state.h"
#include "talk/store.h"
#include "tests/rig/run.h"
#include "tests/rig/the_rig.h"

void setUp(void)
{
    rig = run_rig(70);
    run_to_ready(rig);
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

/* Each call applies the parameters of a different motor. */
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

/* An erase delays the interrupt by two seconds; the drive can be started directly afterwards. */
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

/* ---- power ---- */

/* Both pages are full, so that a save erases one and then programs it. The supply fails at each word of
 * the record, and at each word in both passes of the erase. */
static void test_a_cut_at_any_word_or_step_of_a_save_leaves_the_old_set_or_the_new_one(void)
{
    const uint32_t fit = 2048u / store_record_words(params_table.count);
    for (uint32_t n = 1u; n < 2u * fit; n++) {
        (void)given_saved_motor(n);
    }
    const params_t old = given_saved_motor(2u * fit);
    (void)given_motor(99u);
    void *const before = run_kept(rig);
    TEST_ASSERT_TRUE(order("save"));
    const params_t set = rig_state(rig)->app.active;
    const uint32_t all = chip_flash_operations(chip());
    run_back_to(rig, before);
    const uint32_t points = all - chip_flash_operations(chip());
    TEST_ASSERT_TRUE(points > 2u * CHIP_FLASH_KEPT + store_record_words(params_table.count));
    uint32_t kept = 0;
    for (uint32_t cut = 0; cut < points; cut++) {
        run_back_to(rig, before);
        chip_cut_power(chip(), cut);
        (void)order("save");
        TEST_ASSERT_TRUE(chip_halted(chip()));
        rig_power_cycle(rig);
        expect_store("loaded");
        TEST_ASSERT_TRUE(runs(&old) || runs(&set));
        kept += runs(&old) ? 1u : 0u;
        TEST_ASSERT_EQUAL_DOUBLE(0.0, rig_value(rig, "fault_reason"));
    }
    free(before);
    run_say("old set after %u of %u cuts", kept, points);
}
