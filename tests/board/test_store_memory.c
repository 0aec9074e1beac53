/* Parameters are kept in a memory on the I2C bus. The test runs the whole simulation: orders, background
 * task, HAL, I2C-A, and an EEPROM or FRAM with its supply. */
#include "app/keeping.h"
#include "host_sim/rig/rig_state.h"
#include "settings/reasons.h"
#include "tests/rig/run.h"

#define TICKS_PER_MS (CHIP_TICKS_PER_SECOND / 1000u)

static const chip_memory_t eeprom = {BOARD_STORE_ADDRESS, 64u, (uint32_t)(5u * TICKS_PER_MS)};
static rig_t *rig;

void setUp(void)
{
    rig = run_rig(71);
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

static bool is(const char *row, const char *choice)
{
    return rig_value(rig, row) == table_choice(rig_row_by_name(row), choice);
}

static void expect(const char *row, const char *choice)
{
    TEST_ASSERT_EQUAL_DOUBLE_MESSAGE(table_choice(rig_row_by_name(row), choice), rig_value(rig, row), choice);
}

/* Begins to save a set, which belongs to another motor each time; the save lasts until the power fails. */
static params_t begin_to_save(uint32_t number)
{
    run_put(rig, "motor_resistance", 0.5 + 0.001 * (double)(number % 1000u));
    run_put(rig, "motor_flux_linkage", 0.1 + 0.0001 * (double)(number % 1000u));
    run_parameter(rig, "encoder_lines", 1024.0 + number);
    TEST_ASSERT_TRUE_MESSAGE(order("save"), rig_error(rig));
    expect("store_state", "busy");
    return rig_state(rig)->app.active;
}

static void let_it_save(void)
{
    for (uint32_t n = 0; n < 60000u && is("store_state", "busy") && !chip_halted(chip()); n++) {
        rig_step(rig);
    }
}

static params_t save(uint32_t number)
{
    const params_t set = begin_to_save(number);
    let_it_save();
    expect("store_state", "saved");
    return set;
}

static bool runs(const params_t *set)
{
    return memcmp(set, &rig_state(rig)->app.active, sizeof *set) == 0;
}

static void test_a_page_has_room_for_a_set(void)
{
    TEST_ASSERT_EQUAL_UINT32(store_record_words(params_table.count), KEEPING_RECORD);
}

static void test_a_saved_set_runs_after_the_supply_was_off(void)
{
    for (uint32_t n = 0; n < 2u; n++) {
        if (n == 1u) {
            chip_attach_memory(chip(), &eeprom);
        }
        for (uint32_t number = 1u; number < 4u; number++) {
            const params_t set = save(10u * n + number);
            rig_power_cycle(rig);
            TEST_ASSERT_TRUE(runs(&set));
            run_to_ready(rig);
            expect("store_state", "loaded");
        }
    }
    TEST_ASSERT_EQUAL_DOUBLE(0.0, rig_value(rig, "fault_reason"));
    TEST_ASSERT_EQUAL_UINT32(0u, chip_report_total(chip()));
}

/* No part of a save blocks the interrupt. During a save the serial line is served, and the drive may be
 * switched on. */
static void test_the_drive_runs_while_a_set_is_being_saved(void)
{
    chip_attach_memory(chip(), &eeprom);
    (void)begin_to_save(5u);
    TEST_ASSERT_FALSE(order("save"));
    TEST_ASSERT_EQUAL_DOUBLE(REASON_STORE_BUSY, rig_value(rig, "order_refusal"));
    TEST_ASSERT_FALSE(order("restart"));
    TEST_ASSERT_FALSE(order("load"));
    run_on(rig, 100.0);
    run_seconds(rig, 0.1);
    expect("store_state", "busy");
    run_expect_no_fault(rig);
    let_it_save();
    expect("store_state", "saved");
    TEST_ASSERT_EQUAL_DOUBLE(1.0, rig_value(rig, "store_saves"));
    run_expect_no_fault(rig);
    TEST_ASSERT_EQUAL_UINT32(0u, chip_report_total(chip()));
}

static void test_erase_and_load_are_as_with_flash(void)
{
    const params_t usual = rig_state(rig)->app.active;
    const params_t set = save(9u);
    run_put(rig, "motor_resistance", 0.9);
    TEST_ASSERT_TRUE(order("load"));
    TEST_ASSERT_TRUE(rig_apply(rig));
    TEST_ASSERT_TRUE(runs(&set));
    TEST_ASSERT_TRUE(order("erase"));
    let_it_save();
    expect("store_state", "empty");
    rig_power_cycle(rig);
    expect("store_state", "empty");
    TEST_ASSERT_TRUE(runs(&usual));
}

/* `lagless serve --flash FILE` keeps the memory in such a file. */
static void test_the_content_goes_through_a_file_of_octets(void)
{
    static uint8_t octets[RIG_FLASH_SIZE];
    const params_t set = save(8u);
    rig_flash_save(rig, octets);
    rig_t *const other = run_rig(72);
    TEST_ASSERT_FALSE(rig_flash_load(other, octets, sizeof octets - 1u));
    TEST_ASSERT_TRUE(rig_flash_load(other, octets, sizeof octets));
    rig_power_cycle(other);
    TEST_ASSERT_EQUAL_MEMORY(&set, &rig_state(other)->app.active, sizeof set);
    rig_free(other);
}

/* ---- power ---- */

/* Number of octets received and written in one save. */
static uint32_t operations_of_a_save(const void *before)
{
    run_back_to(rig, before);
    const uint32_t from = chip_flash_operations(chip());
    (void)save(7u);
    return chip_flash_operations(chip()) - from;
}

static void cut_in_a_grid(const char *name)
{
    const params_t old = save(4u);
    void *const before = run_kept(rig);
    const uint32_t points = operations_of_a_save(before);
    TEST_ASSERT_TRUE(points > 4u * KEEPING_RECORD);
    grid_t grid = grid_of(name, (points + 9u) / 10u);
    for (uint32_t point; grid_next(&grid, &point);) {
        /* The power fails after every tenth octet, in a run of the whole grid after each octet */
        const uint32_t some = seed_values()->share == 1u ? 10u : 1u;
        const uint32_t first = 10u * point + (some == 1u ? grid_draw(name, point) % 10u : 0u);
        for (uint32_t cut = first; cut < first + some && cut < points; cut++) {
            run_back_to(rig, before);
            chip_cut_power(chip(), cut);
            const params_t set = begin_to_save(7u);
            let_it_save();
            TEST_ASSERT_TRUE(chip_halted(chip()));
            rig_power_cycle(rig);
            expect("store_state", "loaded");
            TEST_ASSERT_TRUE_MESSAGE(runs(&old) || runs(&set), run_say("%s, cut at %u", name, cut));
            TEST_ASSERT_EQUAL_DOUBLE(0.0, rig_value(rig, "fault_reason"));
        }
    }
    free(before);
}

static void test_a_cut_at_any_octet_of_an_fram_leaves_the_old_set_or_the_new_one(void)
{
    (void)save(3u);
    cut_in_a_grid("octets of a save, FRAM");
}

static void test_a_cut_at_any_octet_of_an_eeprom_leaves_the_old_set_or_the_new_one(void)
{
    chip_attach_memory(chip(), &eeprom);
    (void)save(3u);
    cut_in_a_grid("octets of a save, EEPROM");
}

/* ---- bad memories ---- */

/* The drive runs with its defaults and reports the reason; nothing can be saved, and no stored set is
 * lost. */
static void expect_defaults_and(const char *error)
{
    const params_t *active = &rig_state(rig)->app.active;
    params_t usual;
    params_defaults(&usual);
    TEST_ASSERT_EQUAL_MEMORY(&usual, active, sizeof usual);
    expect("store_state", "failed");
    expect("store_error", error);
    TEST_ASSERT_FALSE(order("save"));
    TEST_ASSERT_EQUAL_DOUBLE(REASON_STORE_FAILED, rig_value(rig, "order_refusal"));
    TEST_ASSERT_FALSE(order("load"));
    TEST_ASSERT_FALSE(order("erase"));
    run_to_ready(rig);
    run_on(rig, 100.0);
    run_seconds(rig, 0.3);
    run_expect_no_fault(rig);
    TEST_ASSERT_EQUAL_UINT32(0u, chip_report_total(chip()));
}

static void test_a_missing_memory_gives_no_answer_and_the_defaults(void)
{
    const params_t set = save(6u);
    chip_attach_memory(chip(), NULL);
    rig_power_cycle(rig);
    expect_defaults_and("no_answer");
    const chip_memory_t again = {BOARD_STORE_ADDRESS, 0u, 0u};
    chip_attach_memory(chip(), &again);
    rig_power_cycle(rig);
    expect("store_state", "loaded");
    TEST_ASSERT_TRUE(runs(&set));
}

static void test_a_data_line_that_stays_low_is_a_stuck_bus_and_gives_the_defaults(void)
{
    (void)save(6u);
    chip_hold_data(chip(), CHIP_FOREVER);
    rig_power_cycle(rig);
    expect_defaults_and("bus_stuck");
}

/* A reset of the chip during a read leaves the memory in this state; nine clocks free the line. */
static void test_a_memory_left_in_a_transfer_is_clocked_out_of_it(void)
{
    const params_t set = save(6u);
    for (uint32_t clocks = 1u; clocks <= 9u; clocks++) {
        rig_power_cycle(rig);
        chip_hold_data(chip(), clocks);
        rig_start(rig);
        expect("store_state", "loaded");
        TEST_ASSERT_TRUE(runs(&set));
    }
    TEST_ASSERT_EQUAL_UINT32(0u, chip_report_total(chip()));
}

static void test_a_memory_that_fails_during_a_save_keeps_the_set_before(void)
{
    static const char *const errors[] = {"no_answer", "bus_stuck", "not_taken"};
    const params_t old = save(6u);
    void *const before = run_kept(rig);
    for (uint32_t n = 0; n < 3u; n++) {
        run_back_to(rig, before);
        (void)begin_to_save(7u);
        run_seconds(rig, 0.02);
        expect("store_state", "busy");
        if (n == 0u) {
            chip_attach_memory(chip(), NULL);
        } else if (n == 1u) {
            chip_hold_data(chip(), CHIP_FOREVER);
        } else {
            chip_break_memory(chip(), true);
        }
        let_it_save();
        expect("store_state", "failed");
        expect("store_error", errors[n]);
        TEST_ASSERT_EQUAL_DOUBLE(1.0, rig_value(rig, "store_saves")); /* saves, as before */
        run_on(rig, 100.0);
        run_seconds(rig, 0.1);
        run_expect_no_fault(rig);
        const chip_memory_t again = {BOARD_STORE_ADDRESS, 0u, 0u};
        chip_attach_memory(chip(), &again);
        chip_hold_data(chip(), 0u);
        chip_break_memory(chip(), false);
        rig_power_cycle(rig);
        expect("store_state", "loaded");
        TEST_ASSERT_TRUE(runs(&old));
    }
    free(before);
}
