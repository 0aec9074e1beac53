/* SCI-A on a serial line; times by SPRUFZ5, with LSPCLK = SYSCLK/4. */
#include <string.h>

#include "bench.h"
#include "unity.h"

#define BRR_937500 4u                         /* 37.5 MHz / (8 x 5) */
#define BIT        160u                       /* [ticks] of 937500 bit/s at 150 MHz */
#define FRAME      (10u * BIT)                /* start bit, eight data bits, stop bit */
#define HEARD      (9u * BIT + 6u * BIT / 8u) /* at the third sample of the stop bit */

static void connect(uint32_t in, uint32_t out)
{
    bus_allow();
    for (uint32_t n = 0; n < 2u; n++) {
        const uint32_t pin = n == 0u ? in : out;
        const volatile gpio_control_regs_t *port = GPIO_CONTROL(pin / 32u);
        const volatile uint32_t *mux = (pin & 16u) != 0u ? &port->MUX2 : &port->MUX1;
        bus_write32(mux, *mux | GPIO_FIELD(pin, 1u));
    }
    bus_protect();
}

static void set_up(uint16_t brr)
{
    bench_allowed16(&SYSCTRL->PCLKCR0, PCLKCR0_ADC | PCLKCR0_SCIA);
    bus_write16(&SCIA->SCICCR, 7u);
    bus_write16(&SCIA->SCICTL1, 0x0003u);
    bus_write16(&SCIA->SCIHBAUD, brr >> 8);
    bus_write16(&SCIA->SCILBAUD, brr & 0xFFu);
    bus_write16(&SCIA->SCIFFTX, 0xE040u);
    bus_write16(&SCIA->SCIFFRX, 0x204Fu);
    bus_write16(&SCIA->SCIFFCT, 0u);
    bus_write16(&SCIA->SCICTL1, 0x0023u);
}

void setUp(void)
{
    bench_power_on();
    bench_clock();
    connect(28u, 29u);
    set_up(BRR_937500);
}

static void pass(uint64_t ticks)
{
    chip_run(chip_now(&bench_chip) + ticks);
}

static uint32_t level_in(void)
{
    return SCIFF_ST(bus_read16(&SCIA->SCIFFRX));
}

static uint32_t level_out(void)
{
    return SCIFF_ST(bus_read16(&SCIA->SCIFFTX));
}

static void put(uint8_t octet)
{
    TEST_ASSERT_EQUAL_UINT32(1u, chip_serial_put(&bench_chip, &octet, 1u));
}

static void put_row(uint32_t count)
{
    for (uint32_t n = 0; n < count; n++) {
        put((uint8_t)(0x40u + n));
    }
}

static uint32_t status(void)
{
    return bus_read16(&SCIA->SCIRXST);
}

/* ---- The interrupt of the receiving FIFO ---- */

static uint32_t raised;

static void on_octets(void)
{
    raised++;
    bus_write16(&PIE->PIEACK, 1u << 8);
}

static void enable_interrupt(uint16_t level)
{
    raised = 0u;
    bench_allowed32(&PIE_VECTORS->vector[96], bus_vector(on_octets));
    bus_write16(&PIE->PIECTRL, PIECTRL_ENPIE);
    bus_write16(&PIE->group[8].IER, 1u);
    bus_enable_group(9u);
    bus_interrupts_enable();
    bus_write16(&SCIA->SCIFFRX, (uint16_t)(0x2060u | level));
}

/* RXFFINT is bit 7, RXFFIENA bit 5, RXFFINTCLR bit 6. No software reads the module during this test. */
static void test_the_interrupt_comes_when_the_level_is_reached_and_once_until_it_is_cleared(void)
{
    enable_interrupt(4u);
    put_row(12u);
    pass(3u * FRAME + HEARD - 1u);
    TEST_ASSERT_EQUAL_UINT32(0u, raised);
    pass(20u);
    TEST_ASSERT_EQUAL_UINT32(1u, raised);
    pass(2u * FRAME);
    TEST_ASSERT_EQUAL_UINT32(1u, raised);
    TEST_ASSERT_EQUAL_HEX16(0x0080u, bus_read16(&SCIA->SCIFFRX) & 0x0080u);
    for (uint32_t n = 0; n < 6u; n++) {
        TEST_ASSERT_EQUAL_HEX16(0x40u + n, bus_read16(&SCIA->SCIRXBUF));
    }
    bus_write16(&SCIA->SCIFFRX, 0x2064u);
    TEST_ASSERT_EQUAL_HEX16(0u, bus_read16(&SCIA->SCIFFRX) & 0x0080u);
    pass(3u * FRAME);
    TEST_ASSERT_EQUAL_UINT32(1u, raised);
    pass(FRAME);
    TEST_ASSERT_EQUAL_UINT32(2u, raised);
    TEST_ASSERT_EQUAL_UINT32(0u, bench_chip.report_total);
}

static void test_without_its_enable_only_the_flag_rises(void)
{
    enable_interrupt(2u);
    bus_write16(&SCIA->SCIFFRX, 0x2042u);
    put_row(3u);
    pass(4u * FRAME);
    TEST_ASSERT_EQUAL_UINT32(0u, raised);
    TEST_ASSERT_EQUAL_HEX16(0x0080u, bus_read16(&SCIA->SCIFFRX) & 0x0080u);
}

/* ---- Receiving ---- */

static void test_an_octet_is_in_the_fifo_when_its_stop_bit_has_been_sampled(void)
{
    put(0xA5u);
    pass(HEARD - 1u);
    TEST_ASSERT_EQUAL_UINT32(0u, level_in());
    TEST_ASSERT_EQUAL_UINT32(0u, status() & SCIRXST_RXRDY);
    pass(1u);
    TEST_ASSERT_EQUAL_UINT32(1u, level_in());
    TEST_ASSERT_EQUAL_UINT32(SCIRXST_RXRDY, status());
    TEST_ASSERT_EQUAL_HEX16(0xA5u, bus_read16(&SCIA->SCIRXBUF));
    TEST_ASSERT_EQUAL_UINT32(0u, level_in());
    TEST_ASSERT_EQUAL_UINT32(0u, status());
}

static void test_octets_follow_each_other_at_line_rate_and_come_out_in_order(void)
{
    put_row(10u);
    for (uint32_t n = 0; n < 10u; n++) {
        pass(n == 0u ? HEARD - 1u : FRAME - 1u);
        TEST_ASSERT_EQUAL_UINT32(n, level_in());
        pass(1u);
        TEST_ASSERT_EQUAL_UINT32(n + 1u, level_in());
    }
    for (uint32_t n = 0; n < 10u; n++) {
        TEST_ASSERT_EQUAL_HEX16(0x40u + n, bus_read16(&SCIA->SCIRXBUF));
    }
}

static void test_every_octet_passes_at_every_rate(void)
{
    static const uint16_t brr[] = {1u, 2u, 3u, 4u, 40u, 487u};
    for (uint32_t r = 0; r < sizeof brr / sizeof brr[0]; r++) {
        set_up(brr[r]);
        for (uint32_t octet = 0; octet < 256u; octet++) {
            put((uint8_t)octet);
            pass(10u * 8u * 4u * (brr[r] + 1u));
            TEST_ASSERT_EQUAL_HEX16(octet, bus_read16(&SCIA->SCIRXBUF));
        }
    }
    TEST_ASSERT_EQUAL_UINT32(0u, status());
}

/* BRR 0 divides by 16, as 1 does (SPRUFZ5, SCIHBAUD). */
static void test_the_divider_of_zero_is_sixteen(void)
{
    set_up(0u);
    put(0x5Au);
    pass(9u * 64u + 48u - 1u);
    TEST_ASSERT_EQUAL_UINT32(0u, level_in());
    pass(1u);
    TEST_ASSERT_EQUAL_UINT32(1u, level_in());
}

/* Frames follow without a gap. The last sample of the stop bit is 9.75 receiver bits after the falling
 * edge. The next start bit begins 10 bits of the sender after that edge, and the sample must come before
 * it; otherwise each frame is received a little later than the one before. The second sample, at 9.625
 * bits, must come after the begin of the stop bit, 9 bits of the sender. The accepted error of the rate is
 * therefore -2.5 % to +6.9 %. */
static void test_another_rate_at_the_other_end_is_understood_within_limits(void)
{
    static const struct {
        double factor;
        bool good;
    } cases[] = {{0.94, false}, {0.98, true}, {1.0, true}, {1.06, true}, {1.08, false}};
    for (uint32_t c = 0; c < sizeof cases / sizeof cases[0]; c++) {
        set_up(BRR_937500);
        bus_write16(&SCIA->SCIFFRX, 0u);
        bus_write16(&SCIA->SCIFFRX, 0x6000u);
        chip_serial_speed(&bench_chip, (uint32_t)(937500.0 / cases[c].factor));
        uint32_t wrong = 0u;
        for (uint32_t n = 0; n < 60u; n++) {
            put(0x00u);
        }
        for (uint32_t n = 0; n < 200u; n++) {
            pass(FRAME / 2u);
            while (level_in() > 0u) {
                wrong += bus_read16(&SCIA->SCIRXBUF) != 0u;
            }
        }
        chip_serial_speed(&bench_chip, 0u);
        TEST_ASSERT_EQUAL(cases[c].good, wrong == 0u);
    }
}

static void test_more_than_sixteen_octets_lose_the_oldest_and_report_it(void)
{
    put_row(16u);
    pass(17u * FRAME);
    TEST_ASSERT_EQUAL_UINT32(16u, level_in());
    TEST_ASSERT_EQUAL_UINT32(0u, SCIA->SCIFFRX & SCIFFRX_RXFFOVF);
    put(0x77u);
    pass(FRAME);
    TEST_ASSERT_EQUAL_UINT32(16u, level_in());
    TEST_ASSERT_EQUAL_UINT32(SCIFFRX_RXFFOVF, SCIA->SCIFFRX & SCIFFRX_RXFFOVF);
    TEST_ASSERT_EQUAL_HEX16(0x41u, bus_read16(&SCIA->SCIRXBUF));
    bus_write16(&SCIA->SCIFFRX, 0x6000u);
    TEST_ASSERT_EQUAL_UINT32(0u, SCIA->SCIFFRX & SCIFFRX_RXFFOVF);
    TEST_ASSERT_EQUAL_UINT32(15u, level_in());
}

static void test_a_missing_stop_bit_marks_its_octet_and_the_next_one_is_whole(void)
{
    TEST_ASSERT_TRUE(chip_serial_levels(&bench_chip, 0x55u << 1, 10u));
    put(0x66u);
    pass(3u * FRAME);
    TEST_ASSERT_EQUAL_HEX16(SCIRXBUF_SCIFFFE | 0x55u, bus_read16(&SCIA->SCIRXBUF));
    TEST_ASSERT_EQUAL_HEX16(0x66u, bus_read16(&SCIA->SCIRXBUF));
    TEST_ASSERT_EQUAL_UINT32(SCIRXST_FE | SCIRXST_RXERROR, status());
}

/* A break is detected 9.625 bits after the sample of the missing stop bit. */
static void test_a_break_stops_the_receiver_until_a_software_reset(void)
{
    TEST_ASSERT_TRUE(chip_serial_levels(&bench_chip, 0u, 21u));
    put(0x66u);
    pass(HEARD + 77u * BIT / 8u - 1u);
    TEST_ASSERT_EQUAL_UINT32(0u, status() & SCIRXST_BRKDT);
    pass(1u);
    TEST_ASSERT_EQUAL_UINT32(SCIRXST_BRKDT, status() & SCIRXST_BRKDT);
    pass(5u * FRAME);
    put(0x67u);
    pass(2u * FRAME);
    TEST_ASSERT_EQUAL_UINT32(1u, level_in());
    TEST_ASSERT_EQUAL_HEX16(SCIRXBUF_SCIFFFE, bus_read16(&SCIA->SCIRXBUF));

    bus_write16(&SCIA->SCICTL1, 0x0003u);
    TEST_ASSERT_EQUAL_UINT32(0u, status());
    bus_write16(&SCIA->SCICTL1, 0x0023u);
    put(0x68u);
    pass(FRAME);
    TEST_ASSERT_EQUAL_HEX16(0x68u, bus_read16(&SCIA->SCIRXBUF));
}

static void test_a_low_line_of_nineteen_bits_is_no_break(void)
{
    TEST_ASSERT_TRUE(chip_serial_levels(&bench_chip, 0u, 19u));
    put(0x66u);
    pass(4u * FRAME);
    TEST_ASSERT_EQUAL_UINT32(0u, status() & SCIRXST_BRKDT);
    TEST_ASSERT_EQUAL_UINT32(2u, level_in());
}

static void test_a_spike_shorter_than_half_a_bit_is_no_start(void)
{
    chip_serial_speed(&bench_chip, 937500u * 4u);
    TEST_ASSERT_TRUE(chip_serial_levels(&bench_chip, 0u, 1u));
    chip_run(chip_now(&bench_chip) + FRAME);
    TEST_ASSERT_EQUAL_UINT32(0u, level_in());
    chip_serial_speed(&bench_chip, 0u);
    put(0x12u);
    pass(FRAME);
    TEST_ASSERT_EQUAL_HEX16(0x12u, bus_read16(&SCIA->SCIRXBUF));
}

static void test_the_line_towards_the_chip_takes_so_many_frames_and_no_more(void)
{
    uint8_t octets[2u * CHIP_LINE_FRAMES] = {0};
    TEST_ASSERT_EQUAL_UINT32(CHIP_LINE_FRAMES, chip_serial_put(&bench_chip, octets, (uint32_t)sizeof octets));
    TEST_ASSERT_FALSE(chip_serial_levels(&bench_chip, 0u, 1u));
    pass(2u * FRAME);
    TEST_ASSERT_EQUAL_UINT32(1u, chip_serial_put(&bench_chip, octets, 2u));
}

static uint32_t random_bits(uint32_t *seed)
{
    *seed = *seed * 1664525u + 1013904223u;
    return *seed >> 8;
}

/* All received octets with their flags, if the module is read every `often` ticks. */
static uint32_t what_came(uint64_t until, uint64_t often, uint16_t words[16])
{
    while (chip_now(&bench_chip) < until) {
        const uint64_t next = chip_now(&bench_chip) + often;
        chip_run(next < until ? next : until);
        (void)status();
    }
    const uint32_t count = level_in();
    for (uint32_t n = 0; n < count; n++) {
        words[n] = bus_read16(&SCIA->SCIRXBUF);
    }
    return count;
}

/* The octets and the rates of reading are random: reading changes no other state, and the transfer ends. */
static void test_random_levels_give_the_same_octets_for_any_rate_of_reading(void)
{
    uint32_t seed = 1u, octets = 0u, marked = 0u;
    for (uint32_t round = 0; round < 2000u; round++) {
        setUp();
        chip_serial_speed(&bench_chip, 300000u + random_bits(&seed) % 3000000u);
        for (uint32_t n = 0; n < 12u; n++) {
            const uint32_t bits = random_bits(&seed) % 4u == 0u ? 1u + random_bits(&seed) % 31u : 10u;
            const uint32_t levels =
                bits == 10u ? (random_bits(&seed) & 0xFFu) << 1 | 1u << 9 : random_bits(&seed);
            TEST_ASSERT_TRUE(chip_serial_levels(&bench_chip, levels, bits));
        }
        const chip_t before = bench_chip;
        const uint64_t until = chip_now(&bench_chip) + 200u * FRAME;
        uint16_t seldom[16], often[16];
        const uint32_t count = what_came(until, 200u * FRAME, seldom);
        const uint32_t flags = status();
        bench_chip = before;
        TEST_ASSERT_EQUAL_UINT32(count, what_came(until, 1u + random_bits(&seed) % 300u, often));
        TEST_ASSERT_EQUAL_HEX32(flags, status());
        for (uint32_t n = 0; n < count; n++) {
            TEST_ASSERT_EQUAL_HEX16(seldom[n], often[n]);
            marked += (seldom[n] & SCIRXBUF_SCIFFFE) != 0u;
        }
        octets += count;
    }
    TEST_ASSERT_TRUE(octets > 4000u && marked > 400u);
}

/* ---- Sending ---- */

static void test_an_octet_is_out_after_ten_bits(void)
{
    uint8_t got[4];
    bus_write16(&SCIA->SCITXBUF, 0xC3u);
    TEST_ASSERT_EQUAL_UINT32(0u, level_out()); /* the octet is already in the shift register */
    TEST_ASSERT_EQUAL_HEX16(SCICTL2_TXRDY, SCIA->SCICTL2);
    pass(FRAME - 1u);
    TEST_ASSERT_EQUAL_UINT32(0u, chip_serial_get(&bench_chip, got, 4u));
    pass(1u);
    TEST_ASSERT_EQUAL_UINT32(1u, chip_serial_get(&bench_chip, got, 4u));
    TEST_ASSERT_EQUAL_HEX8(0xC3u, got[0]);
    TEST_ASSERT_EQUAL_HEX16(SCICTL2_TXRDY | SCICTL2_TXEMPTY, SCIA->SCICTL2);
}

static void test_seventeen_octets_find_room_and_go_out_without_a_gap(void)
{
    uint8_t got[32];
    for (uint32_t n = 0; n < 17u; n++) {
        bus_write16(&SCIA->SCITXBUF, (uint16_t)(0x20u + n));
    }
    TEST_ASSERT_EQUAL_UINT32(16u, level_out());
    TEST_ASSERT_EQUAL_UINT32(0u, bench_reports(CHIP_SERIAL_LOST));
    bus_write16(&SCIA->SCITXBUF, 0xFFu);
    TEST_ASSERT_EQUAL_UINT32(1u, bench_reports(CHIP_SERIAL_LOST));
    for (uint32_t n = 1u; n <= 17u; n++) {
        pass(FRAME - 1u);
        TEST_ASSERT_EQUAL_UINT32(17u - n, level_out());
        TEST_ASSERT_EQUAL_UINT32(0u, chip_serial_get(&bench_chip, got, 32u));
        pass(1u);
        TEST_ASSERT_EQUAL_UINT32(1u, chip_serial_get(&bench_chip, got, 32u));
        TEST_ASSERT_EQUAL_HEX8(0x20u + n - 1u, got[0]);
    }
    pass(10u * FRAME);
    TEST_ASSERT_EQUAL_UINT32(0u, chip_serial_get(&bench_chip, got, 32u));
}

static void test_a_software_reset_takes_the_octet_that_is_on_its_way(void)
{
    uint8_t got[4];
    bus_write16(&SCIA->SCITXBUF, 0x11u);
    bus_write16(&SCIA->SCITXBUF, 0x22u);
    pass(FRAME / 2u);
    bus_write16(&SCIA->SCICTL1, 0x0003u);
    bus_write16(&SCIA->SCICTL1, 0x0023u);
    pass(3u * FRAME);
    TEST_ASSERT_EQUAL_UINT32(1u, chip_serial_get(&bench_chip, got, 4u));
    TEST_ASSERT_EQUAL_HEX8(0x22u, got[0]);
}

static void test_octets_that_are_not_read_are_kept_up_to_a_limit(void)
{
    uint8_t got[CHIP_LINE_SENT + 8u];
    for (uint32_t n = 0; n < CHIP_LINE_SENT + 3u; n++) {
        bus_write16(&SCIA->SCITXBUF, (uint16_t)(n & 0xFFu));
        pass(FRAME);
    }
    TEST_ASSERT_EQUAL_UINT32(CHIP_LINE_SENT, chip_serial_get(&bench_chip, got, (uint32_t)sizeof got));
    TEST_ASSERT_EQUAL_HEX8(3u, got[0]);
}

/* ---- Clock, pins, set-up ---- */

static void test_without_a_clock_nothing_is_heard_and_writes_are_reported(void)
{
    bench_allowed16(&SYSCTRL->PCLKCR0, PCLKCR0_ADC);
    put(0x31u);
    pass(2u * FRAME);
    TEST_ASSERT_EQUAL_UINT32(0u, level_in());
    bus_write16(&SCIA->SCITXBUF, 0x31u);
    TEST_ASSERT_EQUAL_UINT32(1u, bench_reports(CHIP_CLOCK_OFF));
    bench_allowed16(&SYSCTRL->PCLKCR0, PCLKCR0_ADC | PCLKCR0_SCIA);
    pass(FRAME);
    TEST_ASSERT_EQUAL_UINT32(0u, level_in());
    put(0x32u);
    pass(FRAME);
    TEST_ASSERT_EQUAL_HEX16(0x32u, bus_read16(&SCIA->SCIRXBUF));
}

static void test_only_pins_that_belong_to_it_are_its_line(void)
{
    uint8_t got[4];
    bench_allowed32(&GPIO_CONTROL(0u)->MUX2, 0u);
    put(0x31u);
    bus_write16(&SCIA->SCITXBUF, 0x41u);
    pass(2u * FRAME);
    TEST_ASSERT_EQUAL_UINT32(0u, level_in());
    TEST_ASSERT_EQUAL_UINT32(0u, chip_serial_get(&bench_chip, got, 4u));
    connect(36u, 35u);
    put(0x32u);
    bus_write16(&SCIA->SCITXBUF, 0x42u);
    pass(2u * FRAME);
    TEST_ASSERT_EQUAL_HEX16(0x32u, bus_read16(&SCIA->SCIRXBUF));
    TEST_ASSERT_EQUAL_UINT32(1u, chip_serial_get(&bench_chip, got, 4u));
    TEST_ASSERT_EQUAL_HEX8(0x42u, got[0]);
}

static void test_the_rate_follows_the_prescaler(void)
{
    bus_allow();
    bus_write16(&SYSCTRL->LOSPCP, 0u); /* LSPCLK = SYSCLK */
    bus_protect();
    set_up(19u); /* 150 MHz / (8 x 20) */
    put(0x31u);
    pass(HEARD - 1u);
    TEST_ASSERT_EQUAL_UINT32(0u, level_in());
    pass(1u);
    TEST_ASSERT_EQUAL_UINT32(1u, level_in());
}

static void test_what_the_model_does_not_have_is_reported(void)
{
    const struct {
        const volatile uint16_t *reg;
        uint16_t value;
        chip_report_kind_t kind;
    } cases[] = {
        {&SCIA->SCICCR, 0x27u, CHIP_UNKNOWN_REGISTER},
        {&SCIA->SCICTL1, 0x63u, CHIP_UNKNOWN_REGISTER},
        {&SCIA->SCICTL2, 0x03u, CHIP_UNKNOWN_REGISTER},
        {&SCIA->SCIFFTX, 0xE060u, CHIP_UNKNOWN_REGISTER},
        {&SCIA->SCIFFCT, 0x2000u, CHIP_UNKNOWN_REGISTER},
        {&SCIA->SCIPRI, 0x10u, CHIP_UNKNOWN_REGISTER},
        {&SCIA->SCIRXST, 0u, CHIP_READ_ONLY},
        {&SCIA->SCIRXBUF, 0u, CHIP_READ_ONLY},
    };
    for (uint32_t n = 0; n < sizeof cases / sizeof cases[0]; n++) {
        const uint32_t before = bench_reports(cases[n].kind);
        bus_write16(cases[n].reg, cases[n].value);
        TEST_ASSERT_EQUAL_UINT32(before + 1u, bench_reports(cases[n].kind));
    }
    bus_write32((const volatile uint32_t *)(const volatile void *)&SCIA->SCICCR, 7u);
    TEST_ASSERT_EQUAL_UINT32(1u, bench_reports(CHIP_BAD_WIDTH));
    TEST_ASSERT_EQUAL_STRING("SCIA.SCIFFRX", chip_register_name(0x705Bu));
    TEST_ASSERT_EQUAL_STRING("?", chip_register_name(0x7058u));
}

/* ---- Reset, halt ---- */

static void test_a_reset_leaves_the_registers_of_the_manual(void)
{
    put_row(3u);
    pass(4u * FRAME);
    bench_allowed16(&SYSCTRL->WDCR, 0u);
    chip_boot(&bench_chip);
    TEST_ASSERT_EQUAL_HEX16(0u, SCIA->SCICCR);
    TEST_ASSERT_EQUAL_HEX16(0u, SCIA->SCICTL1);
    TEST_ASSERT_EQUAL_HEX16(0x00C0u, SCIA->SCICTL2);
    TEST_ASSERT_EQUAL_HEX16(0xA000u, SCIA->SCIFFTX);
    TEST_ASSERT_EQUAL_HEX16(0x201Fu, SCIA->SCIFFRX);
    TEST_ASSERT_EQUAL_HEX16(0u, bus_read16(&SCIA->SCIRXST));
}

static void test_a_debugger_s_halt_stops_the_line_unless_it_runs_free(void)
{
    uint8_t got[4];
    bus_write16(&SCIA->SCITXBUF, 0x51u);
    pass(FRAME / 2u);
    chip_debug_halt(&bench_chip);
    put(0x31u);
    pass(5u * FRAME);
    chip_debug_run(&bench_chip);
    TEST_ASSERT_EQUAL_UINT32(0u, level_in());
    pass(FRAME / 2u - 1u);
    TEST_ASSERT_EQUAL_UINT32(0u, chip_serial_get(&bench_chip, got, 4u));
    pass(1u);
    TEST_ASSERT_EQUAL_UINT32(1u, chip_serial_get(&bench_chip, got, 4u));

    bus_write16(&SCIA->SCIPRI, SCIPRI_FREE);
    bus_write16(&SCIA->SCITXBUF, 0x52u);
    chip_debug_halt(&bench_chip);
    put(0x32u);
    pass(FRAME);
    TEST_ASSERT_EQUAL_UINT32(1u, chip_serial_get(&bench_chip, got, 4u));
    chip_debug_run(&bench_chip);
    TEST_ASSERT_EQUAL_UINT32(1u, level_in());
}

static void test_an_unused_line_is_no_event_and_leaves_the_state_alone(void)
{
    const chip_sci_t before = bench_chip.sci;
    pass(100u * CARRIER);
    TEST_ASSERT_EQUAL_MEMORY(&before, &bench_chip.sci, sizeof before);
}
