/* I2C-A as a master with FIFOs (SPRUG03), and the memory on its bus. */
#include <string.h>

#include "bench.h"
#include "unity.h"

#define BIT_TICKS   375u /* [ticks] 150 MHz / 15 = 10 MHz; a bit has 10 + 5 + 2 x 5 of its cycles: 400 kHz */
#define OCTET_TICKS (9u * BIT_TICKS)
#define PLACE       0x50u
#define WRITE_TICKS 750000u /* 5 ms */

#define SCD   0x0020u
#define ARDY  0x0004u
#define NACK  0x0002u
#define BB    0x1000u
#define XSMT  0x0400u
#define IDLE  0x4020u /* FREE, IRS */
#define WRITE 0x6E20u /* START, STOP, master, transmitter */
#define SEEK  0x6620u /* START, master, transmitter, without STOP */
#define READ  0x6C20u /* START, STOP, master, receiver */
#define STOP  0x4E20u

static const chip_memory_t eeprom = {PLACE, 64u, WRITE_TICKS};
static const chip_memory_t fram = {PLACE, 0u, 0u};

static void connect(uint32_t mux)
{
    bus_allow();
    bus_write32(&GPIO_CONTROL(1u)->MUX1, mux);
    bus_protect();
}

static void set_up(uint16_t prescale)
{
    bus_allow();
    bus_write16(&SYSCTRL->PCLKCR0, SYSCTRL->PCLKCR0 | 0x0010u);
    bus_protect();
    connect(0x5u);
    bus_write16(&I2CA->I2CMDR, 0u);
    bus_write16(&I2CA->I2CPSC, prescale);
    bus_write16(&I2CA->I2CCLKL, 10u);
    bus_write16(&I2CA->I2CCLKH, 5u);
    bus_write16(&I2CA->I2CFFTX, 0x6000u);
    bus_write16(&I2CA->I2CFFRX, 0x2000u);
    bus_write16(&I2CA->I2CMDR, IDLE);
}

void setUp(void)
{
    bench_power_on();
    bench_clock();
    chip_attach_memory(&bench_chip, &eeprom);
    set_up(14u);
}

void tearDown(void)
{
}

static uint16_t flags(void)
{
    return bus_read16(&I2CA->I2CSTR);
}

static uint32_t reports(chip_report_kind_t kind)
{
    return chip_report_count(&bench_chip, kind);
}

static void prepare(uint16_t slave, uint32_t at, uint16_t count)
{
    bus_write16(&I2CA->I2CFFTX, 0x4000u);
    bus_write16(&I2CA->I2CFFRX, 0x0000u);
    bus_write16(&I2CA->I2CFFTX, 0x6000u);
    bus_write16(&I2CA->I2CFFRX, 0x2000u);
    bus_write16(&I2CA->I2CSTR, 0x0027u);
    bus_write16(&I2CA->I2CSAR, slave);
    bus_write16(&I2CA->I2CCNT, count);
    bus_write16(&I2CA->I2CDXR, (uint16_t)(at >> 8));
    bus_write16(&I2CA->I2CDXR, (uint16_t)(at & 0xFFu));
}

/* Writes this number of octets, which count up from `first`. Returns the flags after the transfer, with
 * STOP sent where it is needed. */
static uint16_t write_octets(uint32_t at, uint16_t first, uint16_t count)
{
    prepare(PLACE, at, (uint16_t)(2u + count));
    bus_write16(&I2CA->I2CMDR, WRITE);
    for (uint16_t n = 0; n < count; n++) {
        bus_write16(&I2CA->I2CDXR, (uint16_t)((first + n) & 0xFFu));
        bus_wait(OCTET_TICKS);
    }
    bus_wait(4u * OCTET_TICKS);
    const uint16_t seen = flags();
    if ((seen & NACK) != 0u) {
        bus_write16(&I2CA->I2CMDR, STOP);
        bus_wait(2u * BIT_TICKS);
    }
    return seen;
}

static uint16_t read_octets(uint32_t at, uint16_t count, uint8_t *octets)
{
    prepare(PLACE, at, 2u);
    bus_write16(&I2CA->I2CMDR, SEEK);
    bus_wait(4u * OCTET_TICKS);
    if ((flags() & NACK) != 0u) {
        bus_write16(&I2CA->I2CMDR, STOP);
        bus_wait(2u * BIT_TICKS);
        return NACK;
    }
    TEST_ASSERT_EQUAL_HEX16(ARDY, flags() & (ARDY | SCD | NACK));
    bus_write16(&I2CA->I2CSTR, ARDY);
    bus_write16(&I2CA->I2CCNT, count);
    bus_write16(&I2CA->I2CMDR, READ);
    bus_wait((count + 2u) * OCTET_TICKS);
    TEST_ASSERT_EQUAL_UINT16(count, bus_read16(&I2CA->I2CFFRX) >> 8 & 31u);
    for (uint16_t n = 0; n < count; n++) {
        octets[n] = (uint8_t)bus_read16(&I2CA->I2CDRR);
    }
    return flags();
}

static void expect_octets(uint32_t at, const uint8_t *octets, uint32_t count)
{
    TEST_ASSERT_EQUAL_HEX8_ARRAY(octets, chip_memory_octets(&bench_chip) + at, count);
}

/* ---- the module ---- */

/* START and STOP take one bit each, and an octet takes nine: address, place in the memory, two octets. */
static void test_a_write_takes_its_bits_and_ends_with_stop(void)
{
    prepare(PLACE, 0x0010u, 4u);
    bus_write16(&I2CA->I2CDXR, 0x12u);
    bus_write16(&I2CA->I2CDXR, 0x34u);
    TEST_ASSERT_EQUAL_UINT16(4u, bus_read16(&I2CA->I2CFFTX) >> 8 & 31u);
    bus_write16(&I2CA->I2CMDR, WRITE);
    TEST_ASSERT_EQUAL_HEX16(BB, flags() & (BB | SCD));
    bus_wait(5u * OCTET_TICKS + 2u * BIT_TICKS - 1u);
    TEST_ASSERT_EQUAL_HEX16(BB, flags() & (BB | SCD));
    TEST_ASSERT_EQUAL_HEX16(STOP, I2CA->I2CMDR); /* the hardware has cleared START */
    bus_wait(1u);
    TEST_ASSERT_EQUAL_HEX16(SCD, flags() & (BB | SCD | NACK | ARDY));
    TEST_ASSERT_EQUAL_HEX16(0x4220u, I2CA->I2CMDR); /* the hardware has cleared STOP and master too */
    expect_octets(0x10u, (const uint8_t[]){0x12u, 0x34u, 0xFFu}, 3u);
    TEST_ASSERT_EQUAL_UINT32(0u, chip_report_total(&bench_chip));
}

static void test_what_was_written_is_read_after_a_repeated_start(void)
{
    uint8_t octets[6];
    TEST_ASSERT_EQUAL_HEX16(SCD, write_octets(0x0120u, 0xA0u, 6u) & (SCD | NACK));
    bus_wait(WRITE_TICKS);
    TEST_ASSERT_EQUAL_HEX16(SCD, read_octets(0x0121u, 6u, octets) & (SCD | NACK | BB));
    TEST_ASSERT_EQUAL_HEX8_ARRAY(((const uint8_t[]){0xA1u, 0xA2u, 0xA3u, 0xA4u, 0xA5u, 0xFFu}), octets, 6u);
}

static void test_flags_fall_when_a_one_is_written(void)
{
    (void)write_octets(0u, 1u, 1u);
    TEST_ASSERT_EQUAL_HEX16(SCD, flags() & SCD);
    bus_write16(&I2CA->I2CSTR, ARDY);
    TEST_ASSERT_EQUAL_HEX16(SCD, flags() & SCD);
    bus_write16(&I2CA->I2CSTR, SCD);
    TEST_ASSERT_EQUAL_HEX16(0u, flags() & SCD);
}

static void test_a_missing_octet_holds_the_bus_until_it_comes(void)
{
    prepare(PLACE, 0u, 3u);
    bus_write16(&I2CA->I2CMDR, WRITE);
    bus_wait(100u * OCTET_TICKS);
    TEST_ASSERT_EQUAL_HEX16(BB, flags() & (BB | SCD | XSMT));
    bus_write16(&I2CA->I2CDXR, 0x77u);
    bus_wait(OCTET_TICKS + BIT_TICKS);
    TEST_ASSERT_EQUAL_HEX16(SCD | XSMT, flags() & (BB | SCD | XSMT));
    expect_octets(0u, (const uint8_t[]){0x77u}, 1u);
}

static void test_without_an_acknowledge_the_bus_is_held_until_stop(void)
{
    prepare(0x51u, 0u, 2u);
    bus_write16(&I2CA->I2CMDR, WRITE);
    bus_wait(20u * OCTET_TICKS);
    TEST_ASSERT_EQUAL_HEX16(BB | NACK, flags() & (BB | NACK | SCD));
    bus_write16(&I2CA->I2CMDR, STOP);
    bus_wait(BIT_TICKS);
    TEST_ASSERT_EQUAL_HEX16(NACK | SCD, flags() & (BB | NACK | SCD));
}

static void test_a_reset_of_the_module_ends_a_transfer(void)
{
    prepare(PLACE, 0u, 9u);
    bus_write16(&I2CA->I2CMDR, WRITE);
    bus_wait(3u * OCTET_TICKS);
    bus_write16(&I2CA->I2CMDR, 0u);
    TEST_ASSERT_EQUAL_HEX16(0x0410u, flags());
    bus_write16(&I2CA->I2CMDR, IDLE);
    TEST_ASSERT_EQUAL_HEX16(SCD, write_octets(0u, 1u, 1u) & (SCD | NACK));
}

static void test_mistakes_are_reported(void)
{
    bus_write16(&I2CA->I2CCLKL, 11u); /* allowed only while the module is in reset; here it is not */
    TEST_ASSERT_EQUAL_UINT32(1u, reports(CHIP_I2C_MISUSE));
    TEST_ASSERT_EQUAL_UINT16(10u, I2CA->I2CCLKL);
    set_up(10u); /* a module clock of 13.6 MHz */
    (void)write_octets(0u, 1u, 1u);
    TEST_ASSERT_EQUAL_UINT32(2u, reports(CHIP_I2C_MISUSE));
    bus_write16(&I2CA->I2COAR, 1u);
    bus_write16(&I2CA->I2CIER, 1u);
    bus_write16(&I2CA->I2CMDR, IDLE | 0x0080u);
    TEST_ASSERT_EQUAL_UINT32(3u, reports(CHIP_UNKNOWN_REGISTER));
    bus_write16(&I2CA->I2CDRR, 0u);
    TEST_ASSERT_EQUAL_UINT32(1u, reports(CHIP_READ_ONLY));
    for (uint16_t n = 0; n < 17u; n++) {
        bus_write16(&I2CA->I2CDXR, n);
    }
    TEST_ASSERT_TRUE(reports(CHIP_SERIAL_LOST) > 0u);
    bus_write32((const volatile uint32_t *)&I2CA->I2COAR, 0u);
    TEST_ASSERT_EQUAL_UINT32(1u, reports(CHIP_BAD_WIDTH));
    bus_allow();
    bus_write16(&SYSCTRL->PCLKCR0, SYSCTRL->PCLKCR0 & 0xFFEFu);
    bus_protect();
    bus_write16(&I2CA->I2CSAR, 1u);
    TEST_ASSERT_EQUAL_UINT32(1u, reports(CHIP_CLOCK_OFF));
    TEST_ASSERT_EQUAL_STRING("I2CA.I2CMDR", chip_register_name(0x7909u));
}

/* ---- the memory ---- */

static void test_behind_the_end_of_a_page_writing_goes_on_at_its_beginning(void)
{
    TEST_ASSERT_EQUAL_HEX16(SCD, write_octets(0x7Cu, 1u, 6u) & (SCD | NACK));
    expect_octets(0x7Cu, (const uint8_t[]){1u, 2u, 3u, 4u, 0xFFu}, 5u);
    expect_octets(0x40u, (const uint8_t[]){5u, 6u, 0xFFu}, 3u);
    chip_attach_memory(&bench_chip, &fram);
    bus_wait(WRITE_TICKS);
    TEST_ASSERT_EQUAL_HEX16(SCD, write_octets(0x7Cu, 1u, 6u) & (SCD | NACK));
    expect_octets(0x7Cu, (const uint8_t[]){1u, 2u, 3u, 4u, 5u, 6u, 0xFFu}, 7u);
}

static void test_while_it_writes_it_acknowledges_nothing(void)
{
    uint8_t octet;
    (void)write_octets(0u, 0x55u, 1u);
    TEST_ASSERT_EQUAL_HEX16(NACK, write_octets(0u, 0x66u, 1u) & (SCD | NACK));
    bus_wait(WRITE_TICKS / 2u);
    TEST_ASSERT_EQUAL_HEX16(NACK, read_octets(0u, 1u, &octet));
    bus_wait(WRITE_TICKS / 2u);
    TEST_ASSERT_EQUAL_HEX16(SCD, read_octets(0u, 1u, &octet) & (SCD | NACK));
    TEST_ASSERT_EQUAL_HEX8(0x55u, octet);
    chip_attach_memory(&bench_chip, &fram);
    TEST_ASSERT_EQUAL_HEX16(SCD, write_octets(0u, 0x77u, 1u) & (SCD | NACK));
    TEST_ASSERT_EQUAL_HEX16(SCD, write_octets(0u, 0x78u, 1u) & (SCD | NACK));
}

static void test_a_start_in_place_of_stop_forgets_a_page(void)
{
    prepare(PLACE, 0u, 3u);
    bus_write16(&I2CA->I2CDXR, 0x12u);
    bus_write16(&I2CA->I2CMDR, SEEK);
    bus_wait(6u * OCTET_TICKS);
    TEST_ASSERT_EQUAL_HEX16(ARDY, flags() & ARDY);
    bus_write16(&I2CA->I2CCNT, 1u);
    bus_write16(&I2CA->I2CMDR, READ);
    bus_wait(6u * OCTET_TICKS);
    expect_octets(0u, (const uint8_t[]){0xFFu}, 1u);
}

/* Octets of the address are operations too: octets that arrive before STOP change nothing in an EEPROM. */
static void test_a_cut_of_the_power_leaves_octets_old_new_or_between(void)
{
    for (uint32_t cut = 0; cut < 20u; cut++) {
        setUp();
        chip_cut_power(&bench_chip, cut);
        (void)write_octets(0x80u, 0u, 8u);
        const uint8_t *octet = chip_memory_octets(&bench_chip) + 0x80u;
        uint32_t done = 0;
        uint32_t old = 0;
        for (uint8_t n = 0; n < 8u; n++) {
            done += octet[n] == n;
            old += octet[n] == 0xFFu;
            TEST_ASSERT_EQUAL_HEX8(n, octet[n] & n); /* a one of the new value is never lost */
        }
        TEST_ASSERT_EQUAL(cut < 18u, chip_halted(&bench_chip));
        TEST_ASSERT_TRUE(cut >= 10u || old == 8u);
        TEST_ASSERT_TRUE(cut < 18u || done == 8u);
        TEST_ASSERT_TRUE(done + old >= 7u);
        TEST_ASSERT_TRUE(cut < 10u || done >= (cut < 18u ? cut - 10u : 8u));
        chip_power_cycle(&bench_chip);
        TEST_ASSERT_EQUAL_HEX8(octet[3], chip_memory_octets(&bench_chip)[0x83u]);
    }
}

static void test_a_memory_that_holds_the_data_line_lets_go_after_its_clocks(void)
{
    chip_hold_data(&bench_chip, 3u);
    prepare(PLACE, 0u, 2u);
    bus_write16(&I2CA->I2CMDR, WRITE);
    bus_wait(100u * OCTET_TICKS);
    TEST_ASSERT_EQUAL_HEX16(0u, flags() & (BB | SCD | NACK)); /* the START condition never occurs */
    connect(0u);
    for (uint32_t n = 0; n < 3u; n++) {
        TEST_ASSERT_EQUAL_HEX32(2u, GPIO_DATA(1u)->DAT & 3u);
        bus_allow();
        bus_write32(&GPIO_CONTROL(1u)->DIR, 2u);
        TEST_ASSERT_EQUAL_HEX32(0u, GPIO_DATA(1u)->DAT & 3u);
        bus_write32(&GPIO_CONTROL(1u)->DIR, 0u);
        bus_protect();
    }
    TEST_ASSERT_EQUAL_HEX32(3u, GPIO_DATA(1u)->DAT & 3u);
}
