/* Forces of the action qualifier, dead band and trip zone of ePWM, up to the pins. SYSCLK = TBCLK = 150
 * MHz, so that a count is a tick. */
#include <unity.h>

#include "bench.h"

static uint64_t start;
static uint32_t trips;

void setUp(void)
{
    bench_power_on();
    bench_clock();
    bench_allowed32(&GPIO_CONTROL(0u)->MUX1, 0x01000555u);
    trips = 0u;
}

/* ePWM1 counts up and down with a period of 2000; A is high from 1700 to 2300 in every 4000 counts. */
static void go(uint16_t dbctl, uint16_t red, uint16_t fed)
{
    bus_write16(&EPWM(1u)->TBCTL, TBCTL_UPDOWN);
    bus_write16(&EPWM(1u)->TBPRD, 1000u);
    bus_write16(&EPWM(1u)->CMPA, 300u);
    bus_write16(&EPWM(1u)->AQCTLA, AQCTL_CAU(AQ_CLEAR) | AQCTL_CAD(AQ_SET));
    bus_write16(&EPWM(1u)->DBRED, red);
    bus_write16(&EPWM(1u)->DBFED, fed);
    bus_write16(&EPWM(1u)->DBCTL, dbctl);
    bench_allowed16(&SYSCTRL->PCLKCR0, PCLKCR0_ADC | PCLKCR0_TBCLKSYNC);
    start = chip_now(&bench_chip);
    chip_run(start + 2000u);
    bench_forget();
}

/* Before the dead band A is high from 1700 to 2300, and B (output B of the action qualifier) is low. The
 * expected edges are in counts from the start. */
typedef struct {
    uint32_t tick, level;
} step_t;

static void expect(const step_t *step, uint32_t count)
{
    chip_run(start + 4000u);
    TEST_ASSERT_EQUAL_UINT32(count, bench.edges);
    for (uint32_t i = 0u; i < count; i++) {
        TEST_ASSERT_EQUAL_UINT64(start + step[i].tick, bench.edge[i].tick);
        TEST_ASSERT_EQUAL_HEX32(step[i].level, bench.edge[i].level & 3u);
    }
}

static void test_bypass(void)
{
    go(0u, 50u, 80u);
    expect((const step_t[]){{2300u, 0u}, {3700u, 1u}}, 2u);
}

static void test_active_high_complementary(void)
{
    go(DBCTL_OUT_BOTH | DBCTL_POLSEL_AHC, 50u, 80u);
    expect((const step_t[]){{2300u, 0u}, {2380u, 2u}, {3700u, 0u}, {3750u, 1u}}, 4u);
}

static void test_active_low_complementary(void)
{
    go(DBCTL_OUT_BOTH | DBCTL_POLSEL_ALC, 50u, 80u);
    expect((const step_t[]){{2300u, 3u}, {2380u, 1u}, {3700u, 3u}, {3750u, 2u}}, 4u);
}

static void test_active_high(void)
{
    go(DBCTL_OUT_BOTH, 50u, 80u);
    expect((const step_t[]){{2300u, 2u}, {2380u, 0u}, {3700u, 2u}, {3750u, 3u}}, 4u);
}

static void test_active_low(void)
{
    go(DBCTL_OUT_BOTH | DBCTL_POLSEL_AL, 50u, 80u);
    expect((const step_t[]){{2300u, 1u}, {2380u, 3u}, {3700u, 1u}, {3750u, 0u}}, 4u);
}

static void test_only_one_delay(void)
{
    go(2u, 50u, 80u); /* A has the rising-edge delay, B is direct (low) */
    expect((const step_t[]){{2300u, 0u}, {3750u, 1u}}, 2u);
    setUp();
    go(1u, 50u, 80u); /* A is direct, B is A with a delayed falling edge */
    expect((const step_t[]){{2300u, 2u}, {2380u, 0u}, {3700u, 3u}}, 3u);
}

static void test_input_mode_feeds_from_b(void)
{
    bus_write16(&EPWM(1u)->AQCTLB, AQCTL_CAU(AQ_SET) | AQCTL_CAD(AQ_CLEAR)); /* B is the inverse of A */
    go(DBCTL_OUT_BOTH | (1u << 4), 50u, 80u); /* the rising path uses B, the falling path A */
    expect((const step_t[]){{2350u, 3u}, {2380u, 1u}, {3700u, 2u}}, 3u);
}

static void test_pulse_shorter_than_the_delay_vanishes(void)
{
    /* A is high for 600, and the delay is 600: the rise and the fall coincide. */
    go(DBCTL_OUT_BOTH | DBCTL_POLSEL_AHC, 600u, 80u);
    expect((const step_t[]){{2380u, 2u}, {3700u, 0u}}, 2u);
    setUp();
    go(DBCTL_OUT_BOTH | DBCTL_POLSEL_AHC, 599u, 80u); /* a pulse of one tick remains */
    expect((const step_t[]){{2299u, 1u}, {2300u, 0u}, {2380u, 2u}, {3700u, 0u}}, 4u);
}

static void test_dead_band_of_zero_is_a_plain_complement(void)
{
    go(DBCTL_OUT_BOTH | DBCTL_POLSEL_AHC, 0u, 0u);
    expect((const step_t[]){{2300u, 2u}, {3700u, 1u}}, 2u);
}

static void test_dead_band_registers_have_ten_bits(void)
{
    bus_write16(&EPWM(1u)->DBRED, 1023u + 1024u);
    TEST_ASSERT_EQUAL_UINT16(1023u, EPWM(1u)->DBRED);
}

static void test_dead_band_counts_divided_clock(void)
{
    go(DBCTL_OUT_BOTH | DBCTL_POLSEL_AHC, 50u, 80u);
    bus_write16(&EPWM(1u)->TBCTL, TBCTL_UPDOWN | TBCTL_HSPCLKDIV(1));
    chip_run(start + 10000u);
    uint32_t i = 0u;
    while (i + 1u < bench.edges && !(bench.edge[i].tick > start + 4000u && bench.edge[i].level == 0u)) {
        i++;
    }
    uint64_t delay = bench.edge[i + 1u].tick - bench.edge[i].tick;
    TEST_ASSERT_EQUAL_UINT64((bench.edge[i + 1u].level & 3u) == 1u ? 100u : 160u, delay);
}

static void test_continuous_force_loads_at_zero_and_holds(void)
{
    go(0u, 0u, 0u);
    bus_write16(&EPWM(1u)->AQCSFRC, 0x0009u); /* A low, B high */
    expect((const step_t[]){{2300u, 0u}, {3700u, 1u}}, 2u);
    chip_run(start + 4001u);
    TEST_ASSERT_EQUAL_HEX32(2u, bench.edge[2].level);
    TEST_ASSERT_EQUAL_UINT64(start + 4000u, bench.edge[2].tick);
    chip_run(start + 12000u);
    TEST_ASSERT_EQUAL_UINT32(3u, bench.edges);
}

static void test_continuous_force_immediate(void)
{
    go(0u, 0u, 0u);
    bus_write16(&EPWM(1u)->AQSFRC, 3u << 6);
    chip_run(start + 2100u);
    bus_write16(&EPWM(1u)->AQCSFRC, 0x0001u);
    expect((const step_t[]){{2100u, 0u}}, 1u);
}

static void test_one_shot_force(void)
{
    go(0u, 0u, 0u);
    chip_run(start + 2500u);
    bus_write16(&EPWM(1u)->AQSFRC, (1u << 2) | AQ_SET | (1u << 5) | (AQ_TOGGLE << 3));
    expect((const step_t[]){{2300u, 0u}, {2500u, 3u}}, 2u);
}

static void trip_setup(uint16_t tzsel, uint16_t tzctl)
{
    bus_allow();
    bus_write16(&EPWM(1u)->TZSEL, tzsel);
    bus_write16(&EPWM(1u)->TZCTL, tzctl);
    bus_protect();
    go(DBCTL_OUT_BOTH | DBCTL_POLSEL_AHC, 50u, 80u);
}

static void clear(uint16_t flags)
{
    bench_allowed16(&EPWM(1u)->TZCLR, flags);
}

static void test_trip_forces_low_at_the_tick_of_the_pin(void)
{
    trip_setup(TZSEL_OSHT1, 0x000Au);
    chip_run(start + 2100u);
    chip_set_pin(&bench_chip, 12u, false);
    TEST_ASSERT_EQUAL_HEX16(TZ_OST, EPWM(1u)->TZFLG);
    TEST_ASSERT_TRUE(chip_tripped(&bench_chip, 1u));
    chip_set_pin(&bench_chip, 12u, true);
    expect((const step_t[]){{2100u, 0u}}, 1u);
}

static void test_trip_reactions(void)
{
    trip_setup(TZSEL_OSHT1, TZCTL_TZA(0) | TZCTL_TZB(1)); /* A becomes high-impedance, B high */
    chip_run(start + 2100u);
    chip_set_pin(&bench_chip, 12u, false);
    TEST_ASSERT_EQUAL_HEX32(2u, bench.edge[0].level & 3u);
    TEST_ASSERT_EQUAL_HEX32(2u, bench.edge[0].driven & 3u);
    setUp();
    trip_setup(TZSEL_OSHT1, TZCTL_TZA(3) | TZCTL_TZB(3)); /* no action: the outputs continue to switch */
    chip_set_pin(&bench_chip, 12u, false);
    chip_run(start + 4000u);
    TEST_ASSERT_EQUAL_UINT32(4u, bench.edges);
}

static void test_one_shot_cannot_be_cleared_while_the_pin_is_low(void)
{
    trip_setup(TZSEL_OSHT1, 0x000Au);
    chip_set_pin(&bench_chip, 12u, false);
    clear(TZ_OST);
    TEST_ASSERT_EQUAL_HEX16(TZ_OST, EPWM(1u)->TZFLG & TZ_OST);
    chip_set_pin(&bench_chip, 12u, true);
    TEST_ASSERT_EQUAL_HEX16(TZ_OST, EPWM(1u)->TZFLG & TZ_OST);
    chip_run(start + 2500u);
    bench_forget();
    clear(TZ_OST);
    TEST_ASSERT_EQUAL_HEX16(0u, EPWM(1u)->TZFLG);
    /* Returns to the state of the dead band, with the lower gate on. */
    TEST_ASSERT_EQUAL_UINT32(1u, bench.edges);
    TEST_ASSERT_EQUAL_HEX32(2u, bench.edge[0].level & 3u);
}

static void test_clearing_other_flags_keeps_the_trip(void)
{
    trip_setup(TZSEL_OSHT1, 0x000Au);
    chip_set_pin(&bench_chip, 12u, false);
    chip_set_pin(&bench_chip, 12u, true);
    clear(TZ_INT | TZ_CBC);
    TEST_ASSERT_TRUE(chip_tripped(&bench_chip, 1u));
    clear(0u);
    TEST_ASSERT_TRUE(chip_tripped(&bench_chip, 1u));
}

static void test_cycle_by_cycle_ends_at_zero(void)
{
    trip_setup(1u << 0, 0x000Au);
    chip_run(start + 2100u);
    chip_set_pin(&bench_chip, 12u, false);
    chip_run(start + 2200u);
    chip_set_pin(&bench_chip, 12u, true);
    chip_run(start + 4500u);
    TEST_ASSERT_EQUAL_UINT64(start + 2100u, bench.edge[0].tick);
    TEST_ASSERT_EQUAL_HEX32(0u, bench.edge[0].level & 3u);
    TEST_ASSERT_EQUAL_UINT64(start + 4000u, bench.edge[1].tick); /* A is high at this tick */
    TEST_ASSERT_EQUAL_HEX32(1u, bench.edge[1].level & 3u);
    TEST_ASSERT_EQUAL_HEX16(TZ_CBC, EPWM(1u)->TZFLG); /* the flag remains set */
    clear(TZ_CBC);
    TEST_ASSERT_EQUAL_HEX16(0u, EPWM(1u)->TZFLG);
}

static void test_software_trip(void)
{
    trip_setup(0u, 0x000Au);
    chip_run(start + 2100u);
    bench_allowed16(&EPWM(1u)->TZFRC, TZ_OST);
    expect((const step_t[]){{2100u, 0u}}, 1u);
}

static void test_unmuxed_trip_pin_is_inactive(void)
{
    bench_allowed32(&GPIO_CONTROL(0u)->MUX1, 0x00000555u);
    trip_setup(TZSEL_OSHT1, 0x000Au);
    chip_set_pin(&bench_chip, 12u, false);
    TEST_ASSERT_FALSE(chip_tripped(&bench_chip, 1u));
    bus_allow();
    bus_write32(&GPIO_CONTROL(0u)->MUX1, 0x01000555u); /* assigning a pin that is low trips at once */
    bus_protect();
    TEST_ASSERT_TRUE(chip_tripped(&bench_chip, 1u));
}

static void test_every_trip_input_has_its_pin(void)
{
    static const uint32_t pin[6] = {12u, 13u, 14u, 15u, 16u, 17u};
    for (uint32_t n = 0u; n < 6u; n++) {
        setUp();
        bus_allow();
        bus_write32(&GPIO_CONTROL(0u)->MUX1, 0x55000555u);
        bus_write32(&GPIO_CONTROL(0u)->MUX2, 0x0000000Fu);
        bus_protect();
        trip_setup((uint16_t)(TZSEL_OSHT1 << n), 0x000Au);
        for (uint32_t other = 0u; other < 6u; other++) {
            chip_set_pin(&bench_chip, pin[other], other == n);
        }
        TEST_ASSERT_FALSE(chip_tripped(&bench_chip, 1u));
        chip_set_pin(&bench_chip, pin[n], false);
        TEST_ASSERT_TRUE(chip_tripped(&bench_chip, 1u));
    }
}

/* Each TZ pin trips every module. */
static void test_every_module_listens_to_every_trip_input(void)
{
    bus_allow();
    bus_write16(&SYSCTRL->PCLKCR1, 0x003Fu);
    bus_write32(&GPIO_CONTROL(0u)->MUX1, 0x55000555u);
    bus_write32(&GPIO_CONTROL(0u)->MUX2, 0x0000000Fu);
    for (uint32_t m = 1u; m <= 6u; m++) {
        for (uint32_t n = 0u; n < 6u; n++) {
            bus_write16(&EPWM(m)->TZSEL, (uint16_t)(TZSEL_OSHT1 << n));
            bus_write16(&EPWM(m)->TZCLR, TZ_OST | TZ_INT);
            TEST_ASSERT_FALSE(chip_tripped(&bench_chip, m));
            chip_set_pin(&bench_chip, 12u + n, false);
            chip_set_pin(&bench_chip, 12u + n, true);
            TEST_ASSERT_TRUE(chip_tripped(&bench_chip, m));
        }
    }
    bus_protect();
}

static void on_trip(void)
{
    trips++;
    bus_write16(&PIE->PIEACK, 1u << 1);
}

static void test_trip_interrupt_asks_again_only_after_INT_was_cleared(void)
{
    trip_setup(TZSEL_OSHT1, 0x000Au);
    bus_allow();
    bus_write16(&EPWM(1u)->TZEINT, TZ_OST);
    bus_write32(&PIE_VECTORS->vector[PIE_EPWM1_TZ], bus_vector(on_trip));
    bus_protect();
    bus_write16(&PIE->PIECTRL, PIECTRL_ENPIE);
    bus_write16(&PIE->group[1].IER, 1u);
    bus_enable_group(2u);
    bus_interrupts_enable();
    chip_set_pin(&bench_chip, 12u, false);
    chip_run(start + 2500u);
    TEST_ASSERT_EQUAL_UINT32(1u, trips);
    TEST_ASSERT_EQUAL_HEX16(TZ_OST | TZ_INT, EPWM(1u)->TZFLG);
    chip_set_pin(&bench_chip, 12u, true);
    chip_set_pin(&bench_chip, 12u, false);
    chip_run(start + 3000u);
    TEST_ASSERT_EQUAL_UINT32(1u, trips);
    clear(TZ_INT); /* OST is still set, so that another pulse follows */
    chip_run(start + 3500u);
    TEST_ASSERT_EQUAL_UINT32(2u, trips);
    chip_set_pin(&bench_chip, 12u, true);
    clear(TZ_OST | TZ_INT);
    chip_run(start + 4000u);
    TEST_ASSERT_EQUAL_UINT32(2u, trips);
    TEST_ASSERT_EQUAL_HEX16(0u, EPWM(1u)->TZFLG);
}
