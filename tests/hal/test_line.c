/* The serial line and the stored pages of the HAL on the recording bus. The registers of the serial
 * line are described in SPRUFZ5. */
#include "hal/f28335/flash.h"
#include "hal/hal.h"
#include "tests/hal/recording_bus.h"
#include "unity.h"

#define C_AT 0x328000u
#define B_AT 0x330000u

static void on_interrupt(void)
{
}

static void start(void)
{
    const hal_config_t config = {375u, 9999u, on_interrupt, on_interrupt, on_interrupt, on_interrupt};
    TEST_ASSERT_EQUAL(HAL_OK, hal_init(&config));
    recording_clear_log();
}

void setUp(void)
{
    recording_reset();
    for (uint32_t n = 0; n < 2u * RECORDING_FLASH_WORDS; n++) {
        rec.flash[n] = 0xFFFFu;
    }
    rec.flash_beside = 0xABCDu;
}

void tearDown(void)
{
    TEST_ASSERT_EQUAL_UINT32(0u, rec.overflows);
    TEST_ASSERT_FALSE(rec.allowed);
    TEST_ASSERT_EQUAL_UINT32(0u, rec.nested);
    TEST_ASSERT_EQUAL_HEX16(0xABCDu, rec.flash_beside);
}

static uint32_t did(did_t what, uint32_t from)
{
    while (from < rec.entries && rec.entry[from].did != what) {
        from++;
    }
    return from;
}

/* ---- Serial line ---- */

static void test_start_up_sets_eight_bits_at_the_board_s_rate_with_both_fifos(void)
{
    start();
    TEST_ASSERT_EQUAL_HEX16(0x0007u, SCIA->SCICCR);
    TEST_ASSERT_EQUAL_HEX16(0x0023u, SCIA->SCICTL1);
    TEST_ASSERT_EQUAL_HEX16(0x0000u, SCIA->SCICTL2);
    TEST_ASSERT_EQUAL_HEX16(0u, SCIA->SCIHBAUD);
    TEST_ASSERT_EQUAL_HEX16(4u, SCIA->SCILBAUD); /* 37.5 MHz / (8 x 5) = 937500 */
    TEST_ASSERT_EQUAL_HEX16(0xE000u, SCIA->SCIFFTX);
    TEST_ASSERT_EQUAL_HEX16(0x2000u, SCIA->SCIFFRX);
    TEST_ASSERT_EQUAL_HEX16(0u, SCIA->SCIFFCT);
    TEST_ASSERT_EQUAL_HEX16(0x0008u, SCIA->SCIPRI);
    TEST_ASSERT_EQUAL_HEX16(TCR_TSS, CPU_TIMER(2u)->TCR);
    TEST_ASSERT_EQUAL_UINT32(0u, hal_serial_errors());
}

/* 37.5 MHz / (8 x 244) = 19211 bit/s, 0.06 % too high; 37.5 MHz / (8 x 488) = 9605 bit/s. The module is
 * held in reset during the change. */
static void test_another_rate_is_the_nearest_of_the_divider(void)
{
    start();
    hal_serial_baud(19200u);
    TEST_ASSERT_EQUAL_HEX16(243u, SCIA->SCIHBAUD << 8 | SCIA->SCILBAUD);
    hal_serial_baud(9600u);
    TEST_ASSERT_EQUAL_HEX16(487u, SCIA->SCIHBAUD << 8 | SCIA->SCILBAUD);
    hal_serial_baud(937500u);
    TEST_ASSERT_EQUAL_HEX16(4u, SCIA->SCIHBAUD << 8 | SCIA->SCILBAUD);
    TEST_ASSERT_EQUAL_HEX16(0x0023u, SCIA->SCICTL1);
}

static void test_it_sends_until_fifo_and_shift_register_are_empty(void)
{
    start();
    rec.regs.scia.SCICTL2 = 0x00C0u;
    rec.regs.scia.SCIFFTX = 0xE000u;
    TEST_ASSERT_FALSE(hal_serial_sends());
    rec.regs.scia.SCICTL2 = 0x0080u;
    TEST_ASSERT_TRUE(hal_serial_sends());
    rec.regs.scia.SCICTL2 = 0x00C0u;
    rec.regs.scia.SCIFFTX = 0xE100u;
    TEST_ASSERT_TRUE(hal_serial_sends());
}

static void test_before_start_up_there_is_no_line(void)
{
    uint16_t octets[4] = {1u, 2u, 3u, 4u};
    rec.regs.cpu_timer[2].PRD = 77u;
    TEST_ASSERT_EQUAL_UINT32(0u, hal_serial_read(octets, 4u));
    TEST_ASSERT_EQUAL_UINT32(0u, hal_serial_write(octets, 4u));
    TEST_ASSERT_EQUAL_UINT32(0u, hal_serial_errors());
    hal_serial_baud(9600u);
    TEST_ASSERT_EQUAL_UINT32(0u, rec.entries);
}

/* The line then reports why the rest of the drive did not start. */
static void test_the_line_is_there_on_a_board_that_does_not_take_its_trip(void)
{
    const hal_config_t config = {375u, 9999u, on_interrupt, on_interrupt, on_interrupt, on_interrupt};
    uint16_t octet = 0u;
    rec.trip_deaf = 1u;
    TEST_ASSERT_EQUAL(HAL_TRIP_FAILED, hal_init(&config));
    recording_receive(0x42u);
    TEST_ASSERT_EQUAL_UINT32(1u, hal_serial_read(&octet, 1u));
    TEST_ASSERT_EQUAL_HEX16(0x42u, octet);
}

static void test_reading_takes_what_is_there_and_there_is_room_for(void)
{
    uint16_t octets[16];
    start();
    TEST_ASSERT_EQUAL_UINT32(0u, hal_serial_read(octets, 16u));
    for (uint16_t n = 0; n < 5u; n++) {
        recording_receive((uint16_t)(0x10u + n));
    }
    TEST_ASSERT_EQUAL_UINT32(3u, hal_serial_read(octets, 3u));
    TEST_ASSERT_EQUAL_HEX16(0x10u, octets[0]);
    TEST_ASSERT_EQUAL_HEX16(0x12u, octets[2]);
    TEST_ASSERT_EQUAL_UINT32(2u, hal_serial_read(octets, 16u));
    TEST_ASSERT_EQUAL_HEX16(0x14u, octets[1]);
    TEST_ASSERT_EQUAL_UINT32(0u, rec.entries);
    TEST_ASSERT_EQUAL_UINT32(0u, hal_serial_errors());
}

static void test_an_octet_without_its_stop_bit_is_left_out_and_counted(void)
{
    uint16_t octets[16];
    start();
    recording_receive(0x10u);
    recording_receive(0x8011u);
    recording_receive(0x12u);
    TEST_ASSERT_EQUAL_UINT32(2u, hal_serial_read(octets, 16u));
    TEST_ASSERT_EQUAL_HEX16(0x12u, octets[1]);
    TEST_ASSERT_EQUAL_UINT32(1u, hal_serial_errors());
}

static void test_an_overrun_is_counted_and_forgotten(void)
{
    uint16_t octets[16];
    start();
    recording_receive(0x10u);
    recording_overrun();
    TEST_ASSERT_EQUAL_UINT32(1u, hal_serial_read(octets, 16u));
    TEST_ASSERT_EQUAL_UINT32(1u, hal_serial_errors());
    TEST_ASSERT_EQUAL_UINT32(0u, hal_serial_read(octets, 16u));
    TEST_ASSERT_EQUAL_UINT32(1u, hal_serial_errors());
    TEST_ASSERT_EQUAL_HEX16(0x2000u, SCIA->SCIFFRX);
}

static void test_a_break_restarts_the_receiver(void)
{
    uint16_t octets[16];
    start();
    rec.regs.scia.SCIRXST = 0x00A0u;
    TEST_ASSERT_EQUAL_UINT32(0u, hal_serial_read(octets, 16u));
    TEST_ASSERT_EQUAL_UINT32(1u, hal_serial_errors());
    const uint32_t off = recording_find_value(0u, &SCIA->SCICTL1, 0x0003u);
    TEST_ASSERT_TRUE(recording_find_value(off, &SCIA->SCICTL1, 0x0023u) < rec.entries);
    TEST_ASSERT_EQUAL_UINT32(0u, hal_serial_read(octets, 16u));
    TEST_ASSERT_EQUAL_UINT32(1u, hal_serial_errors());
}

static void test_writing_stops_where_the_fifo_is_full(void)
{
    uint16_t octets[20];
    for (uint16_t n = 0; n < 20u; n++) {
        octets[n] = (uint16_t)(0xFF00u + n);
    }
    start();
    TEST_ASSERT_EQUAL_UINT32(3u, hal_serial_write(octets, 3u));
    TEST_ASSERT_EQUAL_UINT32(3u, recording_count(&SCIA->SCITXBUF));
    TEST_ASSERT_EQUAL_HEX32(0x02u, rec.entry[rec.entries - 1u].value);
    rec.regs.scia.SCIFFTX = (uint16_t)(0xE000u | 5u << 8);
    TEST_ASSERT_EQUAL_UINT32(11u, hal_serial_write(octets, 20u));
    rec.regs.scia.SCIFFTX = (uint16_t)(0xE000u | 16u << 8);
    TEST_ASSERT_EQUAL_UINT32(0u, hal_serial_write(octets, 20u));
    TEST_ASSERT_EQUAL_UINT32(14u, recording_count(&SCIA->SCITXBUF));
}

/* ---- Pages ---- */

static void test_pages_are_sectors_c_and_b(void)
{
    start();
    rec.flash[0] = 0x0001u;
    rec.flash[RECORDING_FLASH_WORDS - 1u] = 0x0002u;
    rec.flash[RECORDING_FLASH_WORDS] = 0x0003u;
    TEST_ASSERT_EQUAL_HEX16(0x0001u, hal_store_word(0u, 0u));
    TEST_ASSERT_EQUAL_HEX16(0x0002u, hal_store_word(0u, HAL_STORE_WORDS - 1u));
    TEST_ASSERT_EQUAL_HEX16(0x0003u, hal_store_word(1u, 0u));
    TEST_ASSERT_EQUAL_HEX16(0u, hal_store_word(0u, HAL_STORE_WORDS));
    TEST_ASSERT_EQUAL_HEX16(0u, hal_store_word(2u, 0u));
}

/* Interrupts and watchdog are off before the access; afterwards the code of the interrupt is copied back
 * and both are on again, in this order. */
static void assert_guarded(uint32_t first, uint32_t last)
{
    const uint32_t dog_off = recording_find_value(0u, &SYSCTRL->WDCR, 0x0068u);
    const uint32_t dog_on = recording_find_value(0u, &SYSCTRL->WDCR, 0x002Fu);
    const uint32_t copied = did(DID_COPY_CODE, 0u);
    TEST_ASSERT_TRUE(did(DID_INTERRUPTS_OFF, 0u) < dog_off);
    TEST_ASSERT_TRUE(dog_off < first);
    TEST_ASSERT_TRUE(last < copied);
    TEST_ASSERT_TRUE(copied < dog_on);
    TEST_ASSERT_TRUE(dog_on < did(DID_INTERRUPTS_ON, 0u));
    TEST_ASSERT_TRUE(did(DID_INTERRUPTS_ON, 0u) == rec.entries - 1u);
}

static void test_an_erase_runs_without_interrupts_and_watchdog(void)
{
    start();
    hal_watchdog_start();
    recording_clear_log();
    rec.flash[9] = 0u;
    TEST_ASSERT_TRUE(hal_store_erase(0u));
    const uint32_t erase = did(DID_ERASE, 0u);
    TEST_ASSERT_EQUAL_UINT32(4u, rec.entry[erase].value);
    assert_guarded(erase, erase);
    recording_clear_log();
    TEST_ASSERT_TRUE(hal_store_erase(1u));
    TEST_ASSERT_EQUAL_UINT32(2u, rec.entry[did(DID_ERASE, 0u)].value);
}

static void test_words_are_programmed_one_by_one_and_read_back(void)
{
    const uint16_t words[3] = {0x1111u, 0x2222u, 0x3333u};
    start();
    hal_watchdog_start();
    recording_clear_log();
    TEST_ASSERT_TRUE(hal_store_program(1u, HAL_STORE_WORDS - 3u, words, 3u));
    const uint32_t first = did(DID_PROGRAM, 0u);
    TEST_ASSERT_EQUAL_HEX32(B_AT + 0x7FFDu, rec.entry[first].address);
    assert_guarded(first, first + 2u);
    TEST_ASSERT_EQUAL_HEX16(0x3333u, hal_store_word(1u, HAL_STORE_WORDS - 1u));
    TEST_ASSERT_TRUE(hal_store_program(0u, 0u, words, 0u));

    recording_clear_log();
    const uint16_t ones = 0x3334u; /* bit 2 is 0 in the flash already */
    TEST_ASSERT_FALSE(hal_store_program(1u, HAL_STORE_WORDS - 1u, &ones, 1u));
}

static void test_a_watchdog_that_did_not_run_stays_off(void)
{
    const uint16_t word = 0u;
    start();
    TEST_ASSERT_TRUE(hal_store_program(0u, 0u, &word, 1u));
    TEST_ASSERT_EQUAL_UINT32(rec.entries, recording_find_value(0u, &SYSCTRL->WDCR, 0x002Fu));
}

static void test_with_gates_on_or_beyond_the_pages_nothing_is_done(void)
{
    const uint16_t words[2] = {0u, 0u};
    TEST_ASSERT_FALSE(hal_store_erase(0u)); /* before hal_init the gates are not tripped */
    start();
    TEST_ASSERT_FALSE(hal_store_erase(2u));
    TEST_ASSERT_FALSE(hal_store_program(2u, 0u, words, 1u));
    TEST_ASSERT_FALSE(hal_store_program(0u, HAL_STORE_WORDS - 1u, words, 2u));
    TEST_ASSERT_FALSE(hal_store_program(0u, HAL_STORE_WORDS + 1u, words, 0u));
    TEST_ASSERT_FALSE(hal_store_program(0u, 1u, words, UINT32_MAX));
    TEST_ASSERT_TRUE(hal_gates_on());
    TEST_ASSERT_FALSE(hal_store_erase(0u));
    TEST_ASSERT_FALSE(hal_store_program(0u, 0u, words, 1u));
    TEST_ASSERT_EQUAL_UINT32(rec.entries, did(DID_ERASE, 0u));
    TEST_ASSERT_EQUAL_UINT32(rec.entries, did(DID_PROGRAM, 0u));
    TEST_ASSERT_EQUAL_UINT32(rec.entries, did(DID_INTERRUPTS_OFF, 0u));
}

static void test_a_flash_that_does_not_follow_is_reported(void)
{
    const uint16_t words[2] = {0x1111u, 0x2222u};
    start();
    rec.flash[3] = 0u;
    rec.flash_broken = true;
    TEST_ASSERT_FALSE(hal_store_erase(0u));
    TEST_ASSERT_FALSE(hal_store_program(0u, 8u, words, 2u));
    TEST_ASSERT_EQUAL_HEX16(0xFFFFu, hal_store_word(0u, 9u)); /* the first failure ends the write */
    TEST_ASSERT_TRUE(rec.interrupts_on);
}

/* The clock in the units of the API: 31457280 = 1048576 x 200 ns/6.667 ns, as in TI's header for 150 MHz.
 * The API gets no call-back function. */
static void test_the_clock_is_given_to_the_flash_api(void)
{
    start();
    rec.code[RECORDING_API_SCALE + 2u] = 0x1234u;
    TEST_ASSERT_TRUE(flash_begin());
    TEST_ASSERT_EQUAL_HEX16(0x0000u, rec.code[RECORDING_API_SCALE]);
    TEST_ASSERT_EQUAL_HEX16(0x01E0u, rec.code[RECORDING_API_SCALE + 1u]);
    TEST_ASSERT_EQUAL_HEX16(0u, rec.code[RECORDING_API_SCALE + 2u]);
    TEST_ASSERT_EQUAL_HEX16(0u, rec.code[RECORDING_API_SCALE + 3u]);
    flash_end();
}

/* In a build without the library, or with another version of it, no word is erased, and the code of the
 * interrupt is back before the interrupt is enabled. */
static void test_without_the_right_flash_api_nothing_is_done(void)
{
    for (uint32_t n = 0; n < 2u; n++) {
        const uint16_t word = 0u;
        start();
        hal_watchdog_start();
        rec.api_words = n == 0u ? 0u : RECORDING_API_WORDS;
        rec.api_version = 0x0100u;
        recording_clear_log();
        TEST_ASSERT_FALSE(hal_store_erase(0u));
        TEST_ASSERT_FALSE(hal_store_program(0u, 0u, &word, 1u));
        TEST_ASSERT_EQUAL_UINT32(rec.entries, did(DID_ERASE, 0u));
        TEST_ASSERT_EQUAL_UINT32(rec.entries, did(DID_PROGRAM, 0u));
        TEST_ASSERT_TRUE(did(DID_COPY_CODE, 0u) < did(DID_INTERRUPTS_ON, 0u));
        TEST_ASSERT_TRUE(rec.interrupts_on);
    }
}

/* ---- Restart ---- */

static void test_a_restart_shuts_the_gates_and_writes_a_wrong_check(void)
{
    start();
    TEST_ASSERT_TRUE(hal_gates_on());
    recording_clear_log();
    hal_restart();
    const uint32_t wrong = recording_find_value(0u, &SYSCTRL->WDCR, 0u);
    TEST_ASSERT_TRUE(recording_find_value(0u, &EPWM(3u)->TZFRC, TZ_OST) < wrong);
    TEST_ASSERT_TRUE(wrong < rec.entries);
    TEST_ASSERT_TRUE(rec.entry[wrong].allowed);
}
