/* eQEP1: position counter, unit timer and latch, flags. SYSCLK is 150 MHz, so that a cycle is a tick. */
#include <unity.h>

#include "bench.h"

static uint64_t start;

void setUp(void)
{
    bench_power_on();
    bench_clock();
    bench_allowed32(&GPIO_CONTROL(0u)->MUX2, 0x00000500u);
    bus_write32(&EQEP(1u)->QPOSMAX, 9999u);
    bench.encoder_rate = 0;
}

static void enable(uint16_t more)
{
    bus_write16(&EQEP(1u)->QEPCTL, (uint16_t)(QEPCTL_QPEN | QEPCTL_PCRM(1) | more));
    start = chip_now(&bench_chip);
}

static uint32_t count_after(uint64_t ticks)
{
    chip_run(start + ticks);
    chip_look(&bench_chip);
    return EQEP(1u)->QPOSCNT;
}

static void test_counts_the_way_since_enabling(void)
{
    bench.encoder_offset = 123456; /* the count does not depend on the position of the shaft at rest */
    enable(0u);
    TEST_ASSERT_EQUAL_UINT32(0u, count_after(1000u));
    bench.encoder_offset += 17;
    TEST_ASSERT_EQUAL_UINT32(17u, count_after(2000u));
    TEST_ASSERT_EQUAL_HEX16(QEPSTS_QDF, EQEP(1u)->QEPSTS & QEPSTS_QDF);
    bench.encoder_offset -= 5;
    TEST_ASSERT_EQUAL_UINT32(12u, count_after(3000u));
    TEST_ASSERT_EQUAL_HEX16(0u, EQEP(1u)->QEPSTS & QEPSTS_QDF);
}

static void test_wraps_at_the_maximum_both_ways(void)
{
    enable(0u);
    bench.encoder_offset -= 1;
    TEST_ASSERT_EQUAL_UINT32(9999u, count_after(1000u));
    TEST_ASSERT_EQUAL_HEX16(1u << 5, EQEP(1u)->QFLG & (3u << 5)); /* the underflow flag */
    bench.encoder_offset += 1;
    TEST_ASSERT_EQUAL_UINT32(0u, count_after(2000u));
    TEST_ASSERT_EQUAL_HEX16(3u << 5, EQEP(1u)->QFLG & (3u << 5));
    bench.encoder_offset += 9999;
    TEST_ASSERT_EQUAL_UINT32(9999u, count_after(20000u));
    bus_write16(&EQEP(1u)->QCLR, 0x0FFFu);
    TEST_ASSERT_EQUAL_HEX16(0u, EQEP(1u)->QFLG);
    bench.encoder_offset += 20001;
    TEST_ASSERT_EQUAL_UINT32(0u, count_after(60000u));
}

static void test_swap_reverses_and_XCR_halves(void)
{
    bus_write16(&EQEP(1u)->QDECCTL, QDECCTL_SWAP);
    enable(0u);
    bench.encoder_offset += 10;
    TEST_ASSERT_EQUAL_UINT32(9990u, count_after(1000u));
    bus_write16(&EQEP(1u)->QDECCTL, QDECCTL_XCR);
    bus_write32(&EQEP(1u)->QPOSCNT, 100u);
    bench.encoder_offset += 10;
    TEST_ASSERT_EQUAL_UINT32(105u, count_after(2000u));
    bench.encoder_offset -= 31;
    TEST_ASSERT_EQUAL_UINT32(89u, count_after(3000u)); /* floor((20 - 31) / 2) - 10 = -16 */
}

static void test_not_enabled_not_muxed_or_not_clocked_does_not_count(void)
{
    bench.encoder_offset += 10;
    start = chip_now(&bench_chip);
    TEST_ASSERT_EQUAL_UINT32(0u, count_after(1000u));
    bench_allowed32(&GPIO_CONTROL(0u)->MUX2, 0u);
    enable(0u);
    bench.encoder_offset += 10;
    TEST_ASSERT_EQUAL_UINT32(0u, count_after(1000u));
    bus_allow();
    /* Selects the other pins. */
    bus_write32(&GPIO_CONTROL(1u)->MUX2, GPIO_FIELD(50u, 1u) | GPIO_FIELD(51u, 1u));
    bench.encoder_offset += 10;
    TEST_ASSERT_EQUAL_UINT32(10u, count_after(2000u));
    bus_write16(&SYSCTRL->PCLKCR1, 0u);
    bus_protect();
    bench.encoder_offset += 10;
    TEST_ASSERT_EQUAL_UINT32(10u, count_after(3000u));
}

/* eQEP2 on GPIO24 and 25 (multiplexer value 2) with its own clock and INT5.2. */
static void test_second_module_has_its_own_pins_clock_and_interrupt(void)
{
    bus_allow();
    bus_write32(&GPIO_CONTROL(0u)->MUX2, GPIO_FIELD(24u, 2u) | GPIO_FIELD(25u, 2u));
    bus_write16(&SYSCTRL->PCLKCR1, PCLKCR1_EQEP1 | PCLKCR1_EQEP2);
    bus_protect();
    bus_write32(&EQEP(2u)->QPOSMAX, 3999u);
    bus_write32(&EQEP(2u)->QUPRD, 10000u);
    bus_write16(&EQEP(2u)->QEINT, QEP_UTO);
    bus_write16(&EQEP(2u)->QEPCTL, QEPCTL_QPEN | QEPCTL_PCRM(1) | QEPCTL_UTE | QEPCTL_QCLM);
    enable(0u); /* enables eQEP1 too, but it has no pins */
    bench.encoder_offset -= 10;
    chip_run(start + 10001u);
    TEST_ASSERT_EQUAL_UINT32(3990u, EQEP(2u)->QPOSLAT);
    TEST_ASSERT_EQUAL_UINT32(3990u, EQEP(2u)->QPOSCNT);
    TEST_ASSERT_EQUAL_UINT32(0u, EQEP(1u)->QPOSCNT);
    TEST_ASSERT_EQUAL_HEX16(2u, PIE->group[4].IFR);
    bench.encoder_offset += 10;
    chip_run(start + 15000u);
    chip_look(&bench_chip);
    TEST_ASSERT_EQUAL_UINT32(0u, EQEP(2u)->QPOSCNT);
    TEST_ASSERT_EQUAL_UINT32(5000u, EQEP(2u)->QUTMR);
    bench_allowed16(&SYSCTRL->PCLKCR1, PCLKCR1_EQEP1);
    bus_write16(&EQEP(2u)->QEPCTL, 0u);
    TEST_ASSERT_EQUAL_UINT32(1u, chip_report_count(&bench_chip, CHIP_CLOCK_OFF));
    bench.encoder_offset += 10;
    chip_run(start + 40000u);
    chip_look(&bench_chip);
    TEST_ASSERT_EQUAL_UINT32(0u, EQEP(2u)->QPOSCNT);
}

static void test_unit_timers_of_both_modules_run_side_by_side(void)
{
    bench_allowed16(&SYSCTRL->PCLKCR1, PCLKCR1_EQEP1 | PCLKCR1_EQEP2);
    bus_write32(&EQEP(1u)->QUPRD, 3000u);
    bus_write32(&EQEP(2u)->QUPRD, 7000u);
    bus_write16(&EQEP(2u)->QEPCTL, QEPCTL_UTE);
    enable(QEPCTL_UTE);
    chip_run(start + 10000u);
    chip_look(&bench_chip);
    TEST_ASSERT_EQUAL_UINT32(1000u, EQEP(1u)->QUTMR);
    TEST_ASSERT_EQUAL_UINT32(3000u, EQEP(2u)->QUTMR);
}

static void test_software_initialisation(void)
{
    bus_write32(&EQEP(1u)->QPOSINIT, 4321u);
    enable(QEPCTL_SWI);
    TEST_ASSERT_EQUAL_UINT32(4321u, EQEP(1u)->QPOSCNT);
    TEST_ASSERT_EQUAL_HEX16(0u, EQEP(1u)->QEPCTL & QEPCTL_SWI);
}

static void test_latch_is_the_position_at_the_tick_of_the_time_out(void)
{
    bench.encoder_rate = 104858; /* 0.1 counts a tick */
    bus_write32(&EQEP(1u)->QUPRD, 15000u);
    enable(QEPCTL_UTE | QEPCTL_QCLM);
    uint32_t began = (uint32_t)((int64_t)start * bench.encoder_rate >> 20);
    for (uint32_t k = 1u; k < 5u; k++) {
        chip_run(start + k * 15000u);
        TEST_ASSERT_EQUAL_HEX16(0u, EQEP(1u)->QFLG & QEP_UTO); /* the unit time has not ended yet */
        chip_run(start + k * 15000u + 1u);
        TEST_ASSERT_EQUAL_HEX16(QEP_UTO, EQEP(1u)->QFLG & QEP_UTO);
        uint32_t there = (uint32_t)((int64_t)(start + k * 15000u) * bench.encoder_rate >> 20);
        TEST_ASSERT_EQUAL_UINT32((there - began) % 10000u, EQEP(1u)->QPOSLAT);
        bus_write16(&EQEP(1u)->QCLR, QEP_UTO);
        chip_run(start + k * 15000u + 7000u);
        TEST_ASSERT_EQUAL_UINT32((there - began) % 10000u, EQEP(1u)->QPOSLAT);
    }
}

static void test_unit_timer_can_be_set(void)
{
    bus_write32(&EQEP(1u)->QUPRD, 15000u);
    enable(QEPCTL_UTE);
    bus_write32(&EQEP(1u)->QUTMR, 14000u);
    chip_run(start + 600u);
    chip_look(&bench_chip);
    TEST_ASSERT_EQUAL_UINT32(14600u, EQEP(1u)->QUTMR);
    chip_run(start + 1000u);
    TEST_ASSERT_EQUAL_HEX16(0u, EQEP(1u)->QFLG & QEP_UTO);
    chip_run(start + 1001u);
    chip_look(&bench_chip);
    TEST_ASSERT_EQUAL_HEX16(QEP_UTO, EQEP(1u)->QFLG & QEP_UTO);
    TEST_ASSERT_EQUAL_UINT32(1u, EQEP(1u)->QUTMR);
    bus_write16(&EQEP(1u)->QEPCTL, QEPCTL_QPEN); /* stops the counter */
    chip_run(start + 9000u);
    chip_look(&bench_chip);
    TEST_ASSERT_EQUAL_UINT32(1u, EQEP(1u)->QUTMR);
}

static void test_position_reset_by_unit_time_out(void)
{
    bus_write32(&EQEP(1u)->QUPRD, 15000u);
    bus_write16(&EQEP(1u)->QEPCTL, QEPCTL_QPEN | QEPCTL_PCRM(3) | QEPCTL_UTE);
    start = chip_now(&bench_chip);
    bench.encoder_offset += 7;
    chip_run(start + 15001u);
    TEST_ASSERT_EQUAL_UINT32(7u, EQEP(1u)->QPOSLAT);
    TEST_ASSERT_EQUAL_UINT32(0u, EQEP(1u)->QPOSCNT);
}

static void test_jump_of_the_shaft_is_a_phase_error(void)
{
    enable(0u);
    TEST_ASSERT_EQUAL_UINT32(0u, count_after(100u));
    bench.encoder_offset += 10;
    TEST_ASSERT_EQUAL_UINT32(10u, count_after(110u)); /* one count per cycle is still possible */
    TEST_ASSERT_EQUAL_HEX16(0u, EQEP(1u)->QFLG & QEP_PHE);
    bench.encoder_offset += 11;
    TEST_ASSERT_EQUAL_UINT32(9u, count_after(120u)); /* 11 is 3 modulo 4, which equals one count back */
    TEST_ASSERT_EQUAL_HEX16(QEP_PHE, EQEP(1u)->QFLG & QEP_PHE);
    bus_write16(&EQEP(1u)->QCLR, QEP_PHE);
    TEST_ASSERT_EQUAL_HEX16(0u, EQEP(1u)->QFLG & QEP_PHE);
}

static uint32_t calls;

static void on_eqep(void)
{
    calls++;
    bus_write16(&EQEP(1u)->QCLR, QEP_UTO | 1u);
    bus_write16(&PIE->PIEACK, 1u << 4);
}

/* Sets the count to that of an index pulse in any turn; the motion continues from there. */
static void test_alignment_sets_the_count_and_is_no_edge(void)
{
    enable(0u);
    bench.encoder_offset += 17;
    (void)count_after(1000u);
    chip_align_encoder(&bench_chip, 1u, -3);
    TEST_ASSERT_EQUAL_UINT32(9997u, EQEP(1u)->QPOSCNT);
    chip_align_encoder(&bench_chip, 1u, 20004);
    TEST_ASSERT_EQUAL_UINT32(4u, EQEP(1u)->QPOSCNT);
    TEST_ASSERT_EQUAL_UINT32(4u, count_after(2000u));
    TEST_ASSERT_EQUAL_HEX16(0u, EQEP(1u)->QFLG & QEP_PHE);
    bench.encoder_offset += 5;
    TEST_ASSERT_EQUAL_UINT32(9u, count_after(3000u));
}

static void test_interrupt(void)
{
    calls = 0u;
    bench_allowed32(&PIE_VECTORS->vector[PIE_VECTOR(5u, 1u)], bus_vector(on_eqep));
    bus_write16(&PIE->PIECTRL, 1u);
    bus_write16(&PIE->group[4].IER, 1u);
    bus_enable_group(5u);
    bus_interrupts_enable();
    bus_write32(&EQEP(1u)->QUPRD, 1000u);
    bus_write16(&EQEP(1u)->QEINT, QEP_UTO);
    enable(QEPCTL_UTE);
    chip_run(start + 5500u);
    TEST_ASSERT_EQUAL_UINT32(5u, calls);
}

static void test_what_is_not_modelled_is_reported(void)
{
    bus_write16(&EQEP(1u)->QCAPCTL, 0u);
    TEST_ASSERT_NULL(chip_last_report(&bench_chip));
    bus_write16(&EQEP(1u)->QCAPCTL, 0x8000u);
    bus_write16(&EQEP(1u)->QDECCTL, 1u << 8);
    bus_write16(&EQEP(1u)->QEPCTL, 1u);
    TEST_ASSERT_EQUAL_UINT32(3u, chip_report_count(&bench_chip, CHIP_UNKNOWN_REGISTER));
    bus_write16(&EQEP(1u)->QFLG, 0u);
    bus_write32(&EQEP(1u)->QPOSLAT, 0u);
    TEST_ASSERT_EQUAL_UINT32(2u, chip_report_count(&bench_chip, CHIP_READ_ONLY));
}
