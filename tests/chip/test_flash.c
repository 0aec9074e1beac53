/* Flash sectors C and B: erase, program, and the content after a loss of power. */
#include <string.h>

#include "bench.h"
#include "hal/f28335/flash.h"
#include "unity.h"

#define C_AT          0x328000u
#define B_AT          0x330000u
#define C             4u
#define B             2u
#define ERASE         (2u * (CHIP_FLASH_KEPT + 1u)) /* operations of an erase */
#define PROGRAM_TICKS 7500u                         /* [ticks] 50 us */
#define ERASE_TICKS   300000000u                    /* [ticks] 2 s */

void setUp(void)
{
    bench_power_on();
    bench_clock();
    bus_interrupts_disable();
    (void)flash_begin();
}

static void program(uint32_t at, uint32_t count)
{
    for (uint32_t n = 0; n < count; n++) {
        TEST_ASSERT_TRUE(flash_program(at + n, (uint16_t)(0x1000u + n)));
    }
}

static void power_cycle(void)
{
    chip_power_cycle(&bench_chip);
    bench_clock();
    bus_interrupts_disable();
    (void)flash_begin();
}

static void test_a_new_chip_is_erased(void)
{
    for (uint32_t n = 0; n < 2u * CHIP_FLASH_WORDS; n++) {
        TEST_ASSERT_EQUAL_HEX16(0xFFFFu, bus_flash(C_AT + n));
    }
}

static void test_programming_turns_ones_into_zeros_and_nothing_else(void)
{
    TEST_ASSERT_TRUE(flash_program(C_AT + 5u, 0xF0F0u));
    TEST_ASSERT_TRUE(flash_program(C_AT + 5u, 0xF000u));
    TEST_ASSERT_FALSE(flash_program(C_AT + 5u, 0xF001u));
    TEST_ASSERT_EQUAL_HEX16(0xF000u, bus_flash(C_AT + 5u));
    TEST_ASSERT_EQUAL_HEX16(0xFFFFu, bus_flash(C_AT + 4u));
    TEST_ASSERT_EQUAL_HEX16(0xFFFFu, bus_flash(B_AT + 5u));
    TEST_ASSERT_EQUAL_UINT32(2u, chip_flash_operations(&bench_chip));
}

static void test_an_erase_takes_one_sector(void)
{
    program(C_AT, 100u);
    program(B_AT, 100u);
    TEST_ASSERT_TRUE(flash_erase(C));
    TEST_ASSERT_EQUAL_UINT32(200u + ERASE, chip_flash_operations(&bench_chip));
    for (uint32_t n = 0; n < 100u; n++) {
        TEST_ASSERT_EQUAL_HEX16(0xFFFFu, bus_flash(C_AT + n));
        TEST_ASSERT_EQUAL_HEX16(0x1000u + n, bus_flash(B_AT + n));
    }
    TEST_ASSERT_TRUE(flash_erase(B));
    TEST_ASSERT_EQUAL_HEX16(0xFFFFu, bus_flash(B_AT));
}

static void test_with_interrupts_or_watchdog_on_it_is_refused_and_reported(void)
{
    bus_interrupts_enable();
    TEST_ASSERT_FALSE(flash_program(C_AT, 0u));
    TEST_ASSERT_FALSE(flash_erase(C));
    bus_interrupts_disable();
    bench_allowed16(&SYSCTRL->WDCR, WDCR_WDCHK | WDCR_WDPS(7u));
    TEST_ASSERT_FALSE(flash_program(C_AT, 0u));
    TEST_ASSERT_EQUAL_UINT32(3u, bench_reports(CHIP_FLASH_MISUSE));
    TEST_ASSERT_EQUAL_HEX16(0xFFFFu, bus_flash(C_AT));
}

/* Each word of the flash API is required, at the address that the table names; the API may be used only
 * until the code of the interrupt is copied back. */
static void test_without_the_whole_api_in_its_place_it_is_refused_and_reported(void)
{
    const bus_memory_t api = bus_flash_api();
    for (uint32_t n = 0; n < api.count; n++) {
        setUp();
        bus_code_ram()[n] ^= 1u;
        TEST_ASSERT_FALSE(flash_program(C_AT, 0u));
        TEST_ASSERT_TRUE(bench_reports(CHIP_FLASH_MISUSE) == 1u);
    }
    setUp();
    flash_end();
    TEST_ASSERT_FALSE(flash_erase(C));
    TEST_ASSERT_EQUAL_UINT32(1u, bench_reports(CHIP_FLASH_MISUSE));
    TEST_ASSERT_EQUAL_HEX16(0xFFFFu, bus_flash(C_AT));
}

static void test_after_it_the_code_of_the_interrupt_is_back(void)
{
    uint16_t before[CHIP_MEMORY_WORDS];
    flash_end();
    memcpy(before, bus_code_ram(), sizeof before);
    TEST_ASSERT_TRUE(flash_begin());
    TEST_ASSERT_TRUE(memcmp(before, bus_code_ram(), sizeof before) != 0);
    TEST_ASSERT_TRUE(flash_erase(B));
    flash_end();
    TEST_ASSERT_EQUAL_HEX16_ARRAY(before, bus_code_ram(), CHIP_MEMORY_WORDS);
}

static void test_behind_the_words_it_keeps_it_refuses_to_program(void)
{
    TEST_ASSERT_TRUE(flash_program(C_AT + CHIP_FLASH_KEPT - 1u, 0u));
    TEST_ASSERT_FALSE(flash_program(C_AT + CHIP_FLASH_KEPT, 0u));
    TEST_ASSERT_EQUAL_UINT32(1u, bench_reports(CHIP_FLASH_BEYOND));
    TEST_ASSERT_EQUAL_HEX16(0xFFFFu, bus_flash(C_AT + CHIP_FLASH_KEPT));
}

/* ---- Power ---- */

static void test_what_is_programmed_outlives_the_supply_and_all_else_does_not(void)
{
    const uint64_t before = chip_now(&bench_chip);
    program(B_AT + 7u, 3u);
    chip_flip_memory(&bench_chip, 0u, 3u, 1u);
    const uint16_t flipped = bus_memory(BUS_PROGRAM).words[3];
    chip_power_cycle(&bench_chip);
    TEST_ASSERT_EQUAL_HEX16(0x1000u, bus_flash(B_AT + 7u));
    TEST_ASSERT_EQUAL_HEX16(0x1002u, bus_flash(B_AT + 9u));
    TEST_ASSERT_EQUAL_HEX16(0u, SYSCTRL->PLLCR);
    TEST_ASSERT_EQUAL_UINT32(15000000u, chip_sysclk_hz(&bench_chip));
    TEST_ASSERT_TRUE(chip_now(&bench_chip) >= before);
    TEST_ASSERT_TRUE(bus_memory(BUS_PROGRAM).words[3] != flipped);
    TEST_ASSERT_FALSE(chip_halted(&bench_chip));
}

static void test_a_cut_while_programming_leaves_words_before_it_done_and_words_behind_it_erased(void)
{
    for (uint32_t cut = 0; cut < 20u; cut++) {
        setUp();
        chip_cut_power(&bench_chip, cut);
        for (uint32_t n = 0; n < 20u; n++) {
            TEST_ASSERT_EQUAL(n < cut, flash_program(C_AT + n, 0x0000u));
        }
        TEST_ASSERT_TRUE(chip_halted(&bench_chip));
        power_cycle();
        for (uint32_t n = 0; n < 20u; n++) {
            if (n != cut) {
                TEST_ASSERT_EQUAL_HEX16(n < cut ? 0x0000u : 0xFFFFu, bus_flash(C_AT + n));
            }
        }
        const uint16_t torn = bus_flash(C_AT + cut);
        TEST_ASSERT_TRUE(torn != 0x0000u && torn != 0xFFFFu);
    }
}

static void test_a_cut_in_an_erase_leaves_each_word_old_cleared_erased_or_torn(void)
{
    for (uint32_t cut = 0; cut < ERASE; cut += cut % 97u == 0u ? 1u : 96u) {
        setUp();
        program(C_AT, 50u);
        chip_cut_power(&bench_chip, cut);
        TEST_ASSERT_FALSE(flash_erase(C));
        power_cycle();
        const bool second = cut > CHIP_FLASH_KEPT;
        const uint32_t at_work = second ? cut - CHIP_FLASH_KEPT - 1u : cut;
        for (uint32_t n = 0; n <= CHIP_FLASH_KEPT; n++) {
            const uint16_t old = n < 50u ? (uint16_t)(0x1000u + n) : 0xFFFFu;
            const uint16_t done = second ? 0xFFFFu : 0x0000u;
            const uint16_t yet = second ? 0x0000u : old;
            if (n != at_work) {
                TEST_ASSERT_EQUAL_HEX16(n < at_work ? done : yet, bus_flash(C_AT + n));
            }
        }
        TEST_ASSERT_EQUAL_HEX16(bus_flash(C_AT + CHIP_FLASH_KEPT), bus_flash(B_AT - 1u));
        TEST_ASSERT_EQUAL_HEX16(0xFFFFu, bus_flash(B_AT));
        TEST_ASSERT_TRUE(flash_erase(C));
        TEST_ASSERT_EQUAL_HEX16(0xFFFFu, bus_flash(C_AT + at_work));
    }
}

static void test_after_the_cut_nothing_is_done_until_the_power_is_back(void)
{
    program(C_AT, 3u);
    chip_cut_power(&bench_chip, 0u);
    TEST_ASSERT_FALSE(flash_program(C_AT + 10u, 0u));
    TEST_ASSERT_FALSE(flash_program(C_AT + 11u, 0u));
    TEST_ASSERT_FALSE(flash_erase(C));
    TEST_ASSERT_EQUAL_HEX16(0x1001u, bus_flash(C_AT + 1u));
    TEST_ASSERT_EQUAL_HEX16(0xFFFFu, bus_flash(C_AT + 11u));
    power_cycle();
    TEST_ASSERT_TRUE(flash_program(C_AT + 11u, 0u));
}

/* ---- Time ---- */

static void none(void)
{
}

static void test_interrupts_wait_until_it_is_over(void)
{
    bench_allowed32(&PIE_VECTORS->vector[PIE_SEQ1INT], bus_vector(none));
    bus_write16(&PIE->PIECTRL, PIECTRL_ENPIE);
    bus_write16(&PIE->group[0].IER, 1u);
    bus_enable_group(1u);
    const uint64_t begin = chip_now(&bench_chip);
    program(C_AT, 4u);
    flash_end();
    bus_write16(&PIE->group[0].IFR, 1u); /* a request of the ADC */
    bus_interrupts_enable();
    chip_run(begin + 4u * PROGRAM_TICKS - 1u);
    TEST_ASSERT_EQUAL_UINT32(0u, chip_interrupt_count(&bench_chip, PIE_SEQ1INT));
    chip_run(begin + 4u * PROGRAM_TICKS + 1u);
    TEST_ASSERT_EQUAL_UINT32(1u, chip_interrupt_count(&bench_chip, PIE_SEQ1INT));
    TEST_ASSERT_EQUAL_UINT32(0u, bench_reports(CHIP_FLASH_MISUSE));
    (void)flash_begin();
    bus_write16(&PIE->PIEACK, 1u);
    bus_write16(&PIE->group[0].IFR, 1u);
    chip_run(begin + 5u * PROGRAM_TICKS);
    /* The API has replaced the code of the interrupt. */
    TEST_ASSERT_EQUAL_UINT32(1u, bench_reports(CHIP_FLASH_MISUSE));
}

static void test_a_watchdog_that_is_started_behind_an_erase_counts_from_its_end(void)
{
    const uint64_t begin = chip_now(&bench_chip);
    TEST_ASSERT_TRUE(flash_erase(C));
    bus_allow();
    bus_write16(&SYSCTRL->WDKEY, WDKEY_FIRST);
    bus_write16(&SYSCTRL->WDKEY, WDKEY_SECOND);
    bus_write16(&SYSCTRL->WDCR, WDCR_WDCHK | WDCR_WDPS(7u));
    bus_protect();
    const uint64_t span = 256u * 512u * 64u * 5u; /* counts x crystal cycles of 5 ticks */
    chip_run(begin + ERASE_TICKS + span - 1u);
    TEST_ASSERT_FALSE(chip_halted(&bench_chip));
    chip_run(begin + ERASE_TICKS + span + 1u);
    TEST_ASSERT_TRUE(chip_halted(&bench_chip));
    TEST_ASSERT_FALSE(chip_restart_asked(&bench_chip));
}

static void test_a_wrong_check_is_a_restart_that_was_asked_for(void)
{
    TEST_ASSERT_FALSE(chip_restart_asked(&bench_chip));
    bus_allow();
    bus_write16(&SYSCTRL->WDCR, 0u);
    TEST_ASSERT_TRUE(chip_restart_asked(&bench_chip));
    chip_boot(&bench_chip);
    TEST_ASSERT_FALSE(chip_restart_asked(&bench_chip));
}

/* ---- Access by the test bench ---- */

static void test_a_page_is_filled_if_it_fits_what_is_kept(void)
{
    static uint16_t words[CHIP_FLASH_WORDS];
    memset(words, 0xFF, sizeof words);
    words[0] = 0x1234u;
    words[CHIP_FLASH_KEPT - 1u] = 0x4321u;
    TEST_ASSERT_TRUE(chip_flash_fill(&bench_chip, 1u, words));
    TEST_ASSERT_EQUAL_HEX16(0x1234u, bus_flash(B_AT));
    TEST_ASSERT_EQUAL_HEX16(0x4321u, chip_flash_word(&bench_chip, 1u, CHIP_FLASH_KEPT - 1u));
    words[0] = 0x5555u;
    words[CHIP_FLASH_WORDS - 1u] = 0u;
    TEST_ASSERT_FALSE(chip_flash_fill(&bench_chip, 1u, words));
    TEST_ASSERT_EQUAL_HEX16(0x1234u, bus_flash(B_AT));
}
