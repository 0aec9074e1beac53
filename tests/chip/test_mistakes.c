/* The start-up of a drive with one mistake fails in the same way as on silicon. The first test has the
 * correct start-up, each other test one mistake. */
#include <unity.h>

#include "bench.h"

static uint64_t start;

void setUp(void)
{
    bench_power_on();
}

/* Runs the start-up and then ten carrier periods (1 ms). */
static void ten_periods(uint32_t skip, uint32_t isr_skips)
{
    bench_isr_skips = isr_skips;
    bench_compare[0] = 3000u;
    bench_start(skip);
    start = chip_now(&bench_chip);
    chip_run(start + 10u * CARRIER + 1000u);
}

static bool shoot_through(void)
{
    for (uint32_t i = 0u; i < bench.edges; i++) {
        if ((bench.edge[i].level & (bench.edge[i].level >> 1) & 0x15u) != 0u) {
            return true;
        }
    }
    return false;
}

static void test_nothing_wrong(void)
{
    ten_periods(0u, 0u);
    TEST_ASSERT_EQUAL_UINT32(10u, bench_samples);
    TEST_ASSERT_NULL(chip_last_report(&bench_chip));
    TEST_ASSERT_FALSE(shoot_through());
    TEST_ASSERT_EQUAL_UINT32(4u, bench_edges_of(0u, start + 5u * CARRIER, start + 7u * CARRIER));
    TEST_ASSERT_EQUAL_UINT64(6000u - 450u, bench_high_of(0u, start + 5u * CARRIER, start + 6u * CARRIER));
    TEST_ASSERT_EQUAL_UINT32(0u, bench.out_of_order);
}

static void test_HSPCLKDIV_left_at_reset_gives_five_kilohertz(void)
{
    ten_periods(SKIP_HSPCLKDIV, 0u);
    TEST_ASSERT_EQUAL_UINT32(5u, bench_samples);
    TEST_ASSERT_EQUAL_UINT64(2u * CARRIER, bench_sample_at[2] - bench_sample_at[1]);
    TEST_ASSERT_EQUAL_UINT32(2u, bench_edges_of(0u, start + 4u * CARRIER, start + 6u * CARRIER));
}

static void test_missing_SOC_means_no_interrupt(void)
{
    ten_periods(SKIP_SOC, 0u);
    TEST_ASSERT_EQUAL_UINT32(0u, bench_samples);
    TEST_ASSERT_EQUAL_UINT32(0u, bench.samples);
    TEST_ASSERT_EQUAL_UINT32(
        4u, bench_edges_of(0u, start + 5u * CARRIER, start + 7u * CARRIER)); /* the leg continues to switch */
}

static void test_missing_PIEACK_stops_after_the_first(void)
{
    ten_periods(0u, SKIP_PIEACK);
    TEST_ASSERT_EQUAL_UINT32(1u, bench_samples);
    TEST_ASSERT_EQUAL_HEX16(1u, PIE->PIEACK);
}

static void test_missing_INT_SEQ1_CLR_stops_after_the_first(void)
{
    ten_periods(0u, SKIP_INT_CLR);
    TEST_ASSERT_EQUAL_UINT32(1u, bench_samples);
    TEST_ASSERT_EQUAL_HEX16(ADCST_INT_SEQ1, ADC->ADCST & ADCST_INT_SEQ1);
}

static void test_missing_RST_SEQ1_reads_other_channels(void)
{
    for (uint32_t channel = 0u; channel < 16u; channel++) {
        bench.volts[channel] = 0.1 * (double)channel;
    }
    bench_isr_skips = SKIP_RST_SEQ1;
    bench_start(0u);
    start = chip_now(&bench_chip);
    chip_run(start + CARRIER + 1000u);
    TEST_ASSERT_EQUAL_UINT16(136u, bench_codes[4]); /* channel A1: 4096 x 0.1 / 3 */
    bench.volts[1] = 2.0;
    chip_run(start + 2u * CARRIER +
             1000u); /* states 4..7 convert A0, so that the first eight results do not change */
    TEST_ASSERT_EQUAL_UINT32(2u, bench_samples);
    TEST_ASSERT_EQUAL_UINT16(136u, bench_codes[4]);
    chip_run(start + 3u * CARRIER + 1000u); /* the sequencer begins again */
    TEST_ASSERT_EQUAL_UINT16(2730u, bench_codes[4]);
}

static void test_wrong_dead_band_polarity_is_a_shoot_through(void)
{
    ten_periods(WRONG_POLARITY, 0u);
    TEST_ASSERT_TRUE(shoot_through());
    TEST_ASSERT_TRUE_MESSAGE(bench_high_of(0u, start + 5u * CARRIER, start + 6u * CARRIER) > 5000u,
                             "upper on");
    TEST_ASSERT_TRUE_MESSAGE(bench_high_of(1u, start + 5u * CARRIER, start + 6u * CARRIER) > 5000u,
                             "lower on too");
}

static void test_missing_EALLOW_leaves_the_trip_zone_unset(void)
{
    ten_periods(SKIP_EALLOW_PWM, 0u);
    TEST_ASSERT_EQUAL_UINT32(9u,
                             bench_reports(CHIP_PROTECTED_WRITE)); /* TZSEL, TZCTL, TZFRC of three modules */
    TEST_ASSERT_EQUAL_HEX16(0u, EPWM(1u)->TZSEL);
    uint32_t before = bench.edges;
    chip_set_pin(&bench_chip, 12u, false); /* the fault line of the module turns off no gate */
    TEST_ASSERT_EQUAL_UINT32(before, bench.edges);
    TEST_ASSERT_FALSE(chip_tripped(&bench_chip, 1u));
}

static void test_module_clock_off_leaves_a_leg_dead(void)
{
    ten_periods(SKIP_CLOCK_PWM2, 0u);
    TEST_ASSERT_TRUE_MESSAGE(bench_reports(CHIP_CLOCK_OFF) >= 10u, "writes to ePWM2 reported");
    TEST_ASSERT_EQUAL_UINT32(0u, bench_edges_of(2u, start, start + 10u * CARRIER));
    TEST_ASSERT_EQUAL_UINT32(4u, bench_edges_of(0u, start + 5u * CARRIER, start + 7u * CARRIER));
}

static void test_missing_vector_loses_the_CPU_while_the_legs_switch_on(void)
{
    ten_periods(SKIP_VECTOR, 0u);
    TEST_ASSERT_TRUE(chip_halted(&bench_chip));
    TEST_ASSERT_EQUAL_UINT32(1u, bench_reports(CHIP_NO_VECTOR));
    TEST_ASSERT_EQUAL_UINT32(4u, bench_edges_of(0u, start + 5u * CARRIER, start + 7u * CARRIER));
}

static void test_unpowered_adc_reads_zero(void)
{
    for (uint32_t channel = 0u; channel < 16u; channel++) {
        bench.volts[channel] = 1.5;
    }
    ten_periods(SKIP_ADC_POWER, 0u);
    TEST_ASSERT_EQUAL_UINT32(10u, bench_samples);
    TEST_ASSERT_EQUAL_UINT16(0u, bench_codes[2]);
    TEST_ASSERT_EQUAL_UINT32(10u, bench_reports(CHIP_ADC_NOT_POWERED));
}

static void test_missing_TBCLKSYNC_stops_the_counters(void)
{
    ten_periods(SKIP_TBCLKSYNC, 0u);
    TEST_ASSERT_EQUAL_UINT32(0u, bench_samples);
    TEST_ASSERT_EQUAL_UINT32(0u, bench_edges_of(0u, start, start + 10u * CARRIER));
}

static void test_trip_never_released_keeps_all_off(void)
{
    ten_periods(SKIP_RELEASE, 0u);
    TEST_ASSERT_EQUAL_UINT32(10u, bench_samples);
    for (uint32_t i = 0u; i < bench.edges; i++) {
        TEST_ASSERT_EQUAL_HEX32(0u, bench.edge[i].level);
    }
}

static void test_PLL_written_with_divider_set_stays_at_fifteen_megahertz(void)
{
    bus_allow();
    bus_write16(&SYSCTRL->WDCR, WDCR_WDDIS | WDCR_WDCHK);
    bus_write16(&SYSCTRL->PLLCR, 10u);
    bus_wait(100000u);
    bus_write16(&SYSCTRL->HISPCP, 0u);
    bus_write16(&SYSCTRL->PCLKCR0, PCLKCR0_ADC);
    bus_write16(&SYSCTRL->PCLKCR1, PCLKCR1_EPWM1 | PCLKCR1_EPWM2 | PCLKCR1_EPWM3);
    bench_pwm(0u);
    bench_adc(0u);
    bench_interrupts(0u);
    bus_allow();
    bus_write16(&SYSCTRL->PCLKCR0, PCLKCR0_ADC | PCLKCR0_TBCLKSYNC);
    start = chip_now(&bench_chip);
    chip_run(start + 35u * CARRIER);
    TEST_ASSERT_EQUAL_UINT32(1u, bench_reports(CHIP_PLL_MISUSE));
    TEST_ASSERT_EQUAL_UINT32(3u, bench_samples); /* 1 kHz instead of 10 kHz */
    TEST_ASSERT_EQUAL_UINT64(10u * CARRIER, bench_sample_at[1] - bench_sample_at[0]);
}

static void test_watchdog_forgotten_resets_before_the_PLL_locks(void)
{
    bus_allow();
    bus_write16(&SYSCTRL->PLLSTS, 0u);
    bus_write16(&SYSCTRL->PLLCR, 10u);
    bus_wait(40000u);
    TEST_ASSERT_TRUE(chip_halted(&bench_chip));
    TEST_ASSERT_EQUAL_UINT32(1u, bench_reports(CHIP_WATCHDOG_RESET));
}

static void test_interrupt_delayed_past_zero_loads_a_period_late(void)
{
    bench_start(0u);
    start = chip_now(&bench_chip);
    chip_run(start + 3u * CARRIER + 1000u);
    chip_set_interrupt_delay(&bench_chip, CARRIER);
    bench_compare[0] = 2000u;
    chip_run(start + 8u * CARRIER);
    /* The request comes at 4, the entry at 5, and the value is loaded at 6 instead of 5. */
    TEST_ASSERT_EQUAL_UINT64(7500u - 450u, bench_high_of(0u, start + 5u * CARRIER, start + 6u * CARRIER));
    TEST_ASSERT_EQUAL_UINT64(4000u - 450u, bench_high_of(0u, start + 7u * CARRIER, start + 8u * CARRIER));
    TEST_ASSERT_TRUE_MESSAGE(bench_high_of(0u, start + 6u * CARRIER, start + 7u * CARRIER) == 4000u - 450u,
                             "late");
}
