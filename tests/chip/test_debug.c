/* A debugger halts the chip, runs it, uses the real-time mode and restarts the program. The emulation bits
 * in the guide of each peripheral state which peripherals stop and which continue. SYSCLK is 150 MHz, so
 * that a cycle is a tick. */
#include <unity.h>

#include "bench.h"

#define TBCTL_LEADER   0x0012u /* with FREE_SOFT = 0 */
#define TBCTL_FOLLOWER 0x2006u

static uint64_t start;
static uint32_t calls;

void setUp(void)
{
    bench_power_on();
    calls = 0u;
}

static void start_with(uint32_t free_soft)
{
    bench_compare[0] = 3000u;
    bench_compare[1] = 3750u;
    bench_compare[2] = 5000u;
    bench_start(0u);
    for (uint32_t n = 1u; n <= 3u; n++) {
        bus_write16(&EPWM(n)->TBCTL, (uint16_t)((n == 1u ? TBCTL_LEADER : TBCTL_FOLLOWER) | free_soft << 14));
    }
    start = chip_now(&bench_chip);
    /* The upper gate of the first leg is off, the edges of the others follow. */
    chip_run(start + 5u * CARRIER + 4000u);
    TEST_ASSERT_TRUE(chip_carrier_plain(&bench_chip));
}

static uint32_t level(void)
{
    return bench.edge[bench.edges - 1u].level;
}

static void test_legs_stop_in_one_zero_vector_at_the_end_of_the_cycle(void)
{
    start_with(1u);
    uint64_t at = start + 5u * CARRIER + 4000u;
    chip_debug_halt(&bench_chip);
    chip_run(at + 10u * CARRIER);
    chip_look(&bench_chip);
    for (uint32_t n = 1u; n <= 3u; n++) {
        TEST_ASSERT_EQUAL_UINT16(0u, EPWM(n)->TBCTR);
    }
    TEST_ASSERT_EQUAL_HEX32(0x15u, level()); /* all upper gates on: output A is high at counter zero */
    TEST_ASSERT_TRUE(bench.edge[bench.edges - 1u].tick < start + 6u * CARRIER);
    TEST_ASSERT_EQUAL_UINT64(start + 6u * CARRIER, chip_carrier_tick(&bench_chip));
    /* From this tick it continues, synchronous as before. */
    uint64_t from = chip_now(&bench_chip);
    chip_debug_run(&bench_chip);
    bench_forget();
    chip_run(from + CARRIER + 1u);
    TEST_ASSERT_TRUE(chip_carrier_plain(&bench_chip));
    TEST_ASSERT_EQUAL_UINT64(from + CARRIER, chip_carrier_tick(&bench_chip));
    TEST_ASSERT_EQUAL_UINT64(from + 3000u, bench.edge[0].tick);
    TEST_ASSERT_EQUAL_HEX32(0x14u, bench.edge[0].level);
    TEST_ASSERT_EQUAL_UINT32(12u, bench.edges); /* the edges of a whole period of three legs */
}

static void test_counters_stop_at_the_next_count(void)
{
    start_with(0u);
    uint64_t at = start + 5u * CARRIER + 4000u;
    TEST_ASSERT_EQUAL_HEX32(0x12u, level());
    chip_debug_halt(&bench_chip);
    chip_run(at + 10u * CARRIER);
    chip_look(&bench_chip);
    for (uint32_t n = 1u; n <= 3u; n++) {
        TEST_ASSERT_EQUAL_UINT16(4001u, EPWM(n)->TBCTR);
    }
    TEST_ASSERT_EQUAL_HEX32(0x1Au, level()); /* the dead band of the second leg ended at 4200 */
    TEST_ASSERT_EQUAL_UINT64(start + 5u * CARRIER + 4200u, bench.edge[bench.edges - 1u].tick);
    uint64_t from = chip_now(&bench_chip);
    chip_debug_run(&bench_chip);
    chip_run(from + 999u); /* the third leg falls 999 counts later, at 5000 */
    TEST_ASSERT_EQUAL_HEX32(0x1Au, level());
    chip_run(from + 1000u);
    TEST_ASSERT_EQUAL_HEX32(0x0Au, level());
    chip_run(from + 3u * CARRIER);
    TEST_ASSERT_TRUE(chip_carrier_plain(&bench_chip));
    TEST_ASSERT_EQUAL_UINT64(from + 2u * CARRIER + CARRIER - 4001u, chip_carrier_tick(&bench_chip));
}

static void test_free_counters_run_on(void)
{
    for (uint32_t free_soft = 2u; free_soft <= 3u; free_soft++) {
        setUp();
        start_with(free_soft);
        chip_debug_halt(&bench_chip);
        uint32_t entered = bench_samples;
        chip_run(start + 9u * CARRIER + 4000u);
        TEST_ASSERT_TRUE(chip_carrier_plain(&bench_chip));
        TEST_ASSERT_EQUAL_UINT64(start + 9u * CARRIER, chip_carrier_tick(&bench_chip));
        TEST_ASSERT_EQUAL_UINT32(4u, bench_edges_of(0u, start + 7u * CARRIER, start + 9u * CARRIER));
        TEST_ASSERT_EQUAL_UINT32(entered, bench_samples);
    }
}

/* A counter that drives no leg stops while the legs continue; it continues together with the CPU. */
static void test_a_stopped_neighbour_of_free_legs_goes_on_after_the_halt(void)
{
    start_with(2u);
    bench_allowed16(&SYSCTRL->PCLKCR1, 0x003Fu);
    bus_write16(&EPWM(5u)->TBPRD, 60000u);
    bus_write16(&EPWM(5u)->TBCTL, 0u); /* counts up and stops at the next count */
    uint64_t from = chip_now(&bench_chip);
    chip_run(from + 20000u);
    chip_debug_halt(&bench_chip);
    chip_run(from + 200000u);
    chip_look(&bench_chip);
    TEST_ASSERT_EQUAL_UINT16(20001u, EPWM(5u)->TBCTR);
    TEST_ASSERT_TRUE(chip_carrier_plain(&bench_chip));
    chip_debug_run(&bench_chip);
    chip_run(from + 201000u);
    chip_look(&bench_chip);
    TEST_ASSERT_EQUAL_UINT16(21001u, EPWM(5u)->TBCTR);
    TEST_ASSERT_EQUAL_UINT64(start + 18u * CARRIER, chip_carrier_tick(&bench_chip));
}

static void test_up_counter_stops_at_its_period(void)
{
    bench_clock();
    bus_write16(&EPWM(1u)->TBPRD, 999u);
    bus_write16(&EPWM(1u)->TBCTL, (uint16_t)TBCTL_FREE_SOFT(1u));
    bus_allow();
    bus_write16(&SYSCTRL->PCLKCR0, PCLKCR0_TBCLKSYNC);
    start = chip_now(&bench_chip);
    chip_run(start + 2500u);
    chip_debug_halt(&bench_chip);
    chip_run(start + 12345u);
    chip_look(&bench_chip);
    TEST_ASSERT_EQUAL_UINT16(999u, EPWM(1u)->TBCTR);
    chip_debug_run(&bench_chip);
    chip_run(start + 12345u + 101u);
    chip_look(&bench_chip);
    TEST_ASSERT_EQUAL_UINT16(100u, EPWM(1u)->TBCTR);
}

static void test_a_trip_still_shuts_a_halted_chip(void)
{
    start_with(1u);
    chip_debug_halt(&bench_chip);
    chip_run(start + 9u * CARRIER);
    chip_set_pin(&bench_chip, 12u, false);
    TEST_ASSERT_EQUAL_HEX32(0u, level());
    TEST_ASSERT_TRUE(chip_tripped(&bench_chip, 1u));
}

static void test_averaged_period_shows_its_edges_when_the_counters_stop(void)
{
    start_with(1u);
    chip_set_averaged(&bench_chip, true);
    chip_run(start + 8u * CARRIER + 4000u);
    TEST_ASSERT_EQUAL_UINT32(3u, bench.averages);
    bench_forget();
    chip_debug_halt(&bench_chip);
    TEST_ASSERT_EQUAL_UINT64(start + 8u * CARRIER + 4000u, bench.edge[0].tick);
    TEST_ASSERT_EQUAL_HEX32(0x12u, bench.edge[0].level);
    chip_run(start + 12u * CARRIER);
    TEST_ASSERT_EQUAL_UINT32(0u, bench.averages);
    TEST_ASSERT_EQUAL_HEX32(0x15u, level());
    chip_debug_run(&bench_chip);
    chip_run(start + 14u * CARRIER + 1u);
    TEST_ASSERT_EQUAL_UINT32(2u, bench.averages);
}

static void test_requests_wait_until_the_CPU_runs(void)
{
    start_with(2u);
    uint32_t entered = bench_samples;
    chip_debug_halt(&bench_chip);
    TEST_ASSERT_TRUE(chip_debug_halted(&bench_chip));
    TEST_ASSERT_FALSE(chip_halted(&bench_chip));
    chip_run(start + 20u * CARRIER + 4000u);
    TEST_ASSERT_EQUAL_UINT32(entered, bench_samples);
    chip_debug_run(&bench_chip);
    chip_run(start + 20u * CARRIER + 4000u + 15u);
    TEST_ASSERT_EQUAL_UINT32(entered + 1u,
                             bench_samples); /* one request was pending, the others found their flag set */
    chip_run(start + 23u * CARRIER + 4000u);
    TEST_ASSERT_EQUAL_UINT32(entered + 4u, bench_samples);
}

static void on_trip(void)
{
    calls++;
    bus_write16(&PIE->PIEACK, 2u);
}

static void enable_trip_interrupt(void)
{
    bench_allowed32(&PIE_VECTORS->vector[PIE_EPWM1_TZ], bus_vector(on_trip));
    bus_write16(&PIE->group[1].IER, 1u);
    bus_enable_group(2u);
}

static void test_real_time_mode_serves_the_groups_of_DBGIER(void)
{
    start_with(2u);
    enable_trip_interrupt();
    bus_debug_groups(1u << 0); /* only INT1 is a time-critical interrupt */
    bus_interrupts_disable();  /* INTM has no effect in a real-time halt */
    chip_debug_realtime(&bench_chip, true);
    chip_debug_halt(&bench_chip);
    uint32_t entered = bench_samples;
    chip_run(start + 15u * CARRIER + 4000u);
    TEST_ASSERT_EQUAL_UINT32(entered + 10u, bench_samples);
    bus_write16(&PIE->group[1].IFR, 1u);
    chip_run(start + 16u * CARRIER);
    TEST_ASSERT_EQUAL_UINT32(0u, calls);
    bus_debug_groups(1u << 0 | 1u << 1);
    chip_run(start + 16u * CARRIER + 15u);
    TEST_ASSERT_EQUAL_UINT32(1u, calls);
    chip_debug_run(&bench_chip);
    entered = bench_samples;
    chip_run(start + 19u * CARRIER);
    TEST_ASSERT_EQUAL_UINT32(entered, bench_samples); /* INTM was kept */
    bus_interrupts_enable();
    chip_run(start + 19u * CARRIER + 20u);
    TEST_ASSERT_EQUAL_UINT32(entered + 1u, bench_samples);
}

static void test_real_time_mode_needs_the_group_in_IER_too(void)
{
    start_with(2u);
    bus_debug_groups(0xFFFFu);
    bus_disable_groups();
    chip_debug_realtime(&bench_chip, true);
    chip_debug_halt(&bench_chip);
    uint32_t entered = bench_samples;
    chip_run(start + 15u * CARRIER);
    TEST_ASSERT_EQUAL_UINT32(entered, bench_samples);
}

static bool seen_inside;

static void look_inside(void)
{
    seen_inside = chip_debug_can_look(&bench_chip);
}

static void test_DBGM_keeps_the_debugger_out_while_the_CPU_runs(void)
{
    TEST_ASSERT_FALSE(chip_debug_can_look(&bench_chip)); /* the reset has set DBGM */
    chip_debug_halt(&bench_chip);
    TEST_ASSERT_TRUE(chip_debug_can_look(&bench_chip));
    chip_debug_run(&bench_chip);
    TEST_ASSERT_FALSE(chip_debug_can_look(&bench_chip));
    bench_start(0u);
    bus_debug_allow();
    TEST_ASSERT_TRUE(chip_debug_can_look(&bench_chip));
    seen_inside = true;
    bench_in_interrupt = look_inside;
    chip_run(chip_now(&bench_chip) + 3u * CARRIER);
    TEST_ASSERT_FALSE(seen_inside); /* the entry of the interrupt has set DBGM */
    TEST_ASSERT_TRUE(chip_debug_can_look(&bench_chip));
    bus_allow();
    bus_write16(&SYSCTRL->WDKEY, 1u);
    chip_boot(&bench_chip);
    TEST_ASSERT_FALSE(chip_debug_can_look(&bench_chip));
}

static void encoder(uint32_t free_soft)
{
    setUp();
    bench_clock();
    bench_allowed32(&GPIO_CONTROL(0u)->MUX2, 0x00000500u);
    bus_write32(&EQEP(1u)->QPOSMAX, 999u);
    bus_write32(&EQEP(1u)->QUPRD, 10000u);
    bus_write16(&EQEP(1u)->QEPCTL, (uint16_t)(QEPCTL_QPEN | QEPCTL_PCRM(1) | QEPCTL_UTE | free_soft << 14));
    start = chip_now(&bench_chip);
    bench.encoder_offset += 700;
    chip_run(start + 4000u);
    chip_debug_halt(&bench_chip);
    bench.encoder_offset += 200;
    chip_run(start + 7000u);
    chip_look(&bench_chip);
}

static void test_encoder_stops_at_once(void)
{
    encoder(0u);
    TEST_ASSERT_EQUAL_UINT32(700u, EQEP(1u)->QPOSCNT);
    TEST_ASSERT_EQUAL_UINT32(4000u, EQEP(1u)->QUTMR);
    chip_debug_run(&bench_chip);
    bench.encoder_offset += 5;
    chip_run(start + 7100u);
    chip_look(&bench_chip);
    TEST_ASSERT_EQUAL_UINT32(705u, EQEP(1u)->QPOSCNT);
    TEST_ASSERT_EQUAL_UINT32(4100u, EQEP(1u)->QUTMR);
    TEST_ASSERT_EQUAL_HEX16(0u, EQEP(1u)->QFLG & QEP_PHE);
}

static void test_encoder_stops_at_its_roll_over(void)
{
    encoder(1u);
    TEST_ASSERT_EQUAL_UINT32(900u, EQEP(1u)->QPOSCNT);
    TEST_ASSERT_EQUAL_UINT32(7000u, EQEP(1u)->QUTMR);
    bench.encoder_offset += 100;
    chip_run(start + 9000u);
    chip_look(&bench_chip);
    bench.encoder_offset += 50;
    chip_run(start + 25000u);
    chip_look(&bench_chip);
    TEST_ASSERT_EQUAL_UINT32(0u, EQEP(1u)->QPOSCNT);
    TEST_ASSERT_EQUAL_UINT32(0u, EQEP(1u)->QUTMR);
    TEST_ASSERT_EQUAL_HEX16(QEP_UTO, EQEP(1u)->QFLG & QEP_UTO);
    chip_debug_run(&bench_chip);
    chip_run(start + 25300u);
    chip_look(&bench_chip);
    TEST_ASSERT_EQUAL_UINT32(300u, EQEP(1u)->QUTMR);
}

static void test_free_encoder_goes_on(void)
{
    encoder(2u);
    bench.encoder_offset += 150;
    chip_run(start + 22000u);
    chip_look(&bench_chip);
    TEST_ASSERT_EQUAL_UINT32(50u, EQEP(1u)->QPOSCNT);
    TEST_ASSERT_EQUAL_UINT32(2000u, EQEP(1u)->QUTMR);
}

static void timer(uint16_t emulation)
{
    setUp();
    bench_clock();
    bus_write32(&CPU_TIMER(1u)->PRD, 9999u);
    bus_write16(&CPU_TIMER(1u)->TCR, TCR_TRB | emulation);
    start = chip_now(&bench_chip);
    chip_run(start + 3000u);
    chip_debug_halt(&bench_chip);
    chip_run(start + 25000u);
    chip_look(&bench_chip);
}

static void test_timer_stops_at_once(void)
{
    timer(0u);
    TEST_ASSERT_EQUAL_UINT32(6999u, CPU_TIMER(1u)->TIM);
    TEST_ASSERT_EQUAL_HEX16(0u, CPU_TIMER(1u)->TCR & TCR_TIF);
    chip_debug_run(&bench_chip);
    chip_run(start + 26000u);
    chip_look(&bench_chip);
    TEST_ASSERT_EQUAL_UINT32(5999u, CPU_TIMER(1u)->TIM);
}

static void test_soft_timer_stops_at_its_reload(void)
{
    timer(TCR_SOFT);
    TEST_ASSERT_EQUAL_UINT32(9999u, CPU_TIMER(1u)->TIM);
    TEST_ASSERT_EQUAL_HEX16(TCR_TIF, CPU_TIMER(1u)->TCR & TCR_TIF);
    chip_debug_run(&bench_chip);
    chip_run(start + 25500u);
    chip_look(&bench_chip);
    TEST_ASSERT_EQUAL_UINT32(9499u, CPU_TIMER(1u)->TIM);
}

static void test_free_timer_goes_on(void)
{
    timer(TCR_FREE);
    TEST_ASSERT_EQUAL_UINT32(4999u, CPU_TIMER(1u)->TIM);
}

static void conversions(uint32_t mode, bool at_start)
{
    setUp();
    bench_clock();
    bench_adc(SKIP_SOC);
    bus_write16(&ADC->ADCTRL1, (uint16_t)(0x0410u | ADCTRL1_SUSMOD(mode)));
    bench_forget();
    start = chip_now(&bench_chip);
    if (at_start) {
        chip_debug_halt(&bench_chip);
    }
    bus_write16(&ADC->ADCTRL2, 0x0900u | ADCTRL2_SOC_SEQ1);
    chip_run(start + 50u); /* the first pair is held at 45 */
    chip_debug_halt(&bench_chip);
    chip_run(start + 1050u);
}

static void test_adc_follows_its_suspend_mode(void)
{
    for (uint32_t mode = 0u; mode < 4u; mode++) {
        conversions(mode, false);
        TEST_ASSERT_EQUAL_UINT32(mode < 2u ? 8u : 2u, bench.samples);
        TEST_ASSERT_EQUAL_HEX16(mode < 2u ? ADCST_INT_SEQ1 : ADCST_SEQ1_BSY, ADC->ADCST);
        chip_debug_run(&bench_chip);
        chip_run(start + 1500u);
        TEST_ASSERT_EQUAL_UINT32(8u, bench.samples);
        TEST_ASSERT_EQUAL_UINT64(start + 45u + 42u + (mode < 2u ? 0u : 1000u), bench.sample[2].tick);
        TEST_ASSERT_EQUAL_HEX16(ADCST_INT_SEQ1, ADC->ADCST);
        conversions(mode, true); /* the conversion starts during the halt */
        TEST_ASSERT_EQUAL_UINT32(mode == 0u ? 8u : 0u, bench.samples);
        chip_debug_run(&bench_chip);
        chip_run(start + 2000u);
        TEST_ASSERT_EQUAL_UINT32(mode == 0u ? 8u : 0u, bench.samples);
    }
}

static void test_carrier_starts_no_conversion_while_the_adc_is_suspended(void)
{
    start_with(2u);
    bus_write16(&ADC->ADCTRL1, 0x0410u | ADCTRL1_SUSMOD(1));
    chip_debug_halt(&bench_chip);
    bench_forget();
    chip_run(start + 10u * CARRIER + 4000u);
    TEST_ASSERT_EQUAL_UINT32(0u, bench.samples);
    chip_debug_run(&bench_chip);
    chip_run(start + 12u * CARRIER + 4000u);
    TEST_ASSERT_EQUAL_UINT32(16u, bench.samples);
    TEST_ASSERT_EQUAL_UINT32(0u, chip_report_total(&bench_chip));
}

static void test_watchdog_does_not_count_during_a_halt(void)
{
    const uint64_t bite = 256u * 512u * 5u;
    chip_run(400000u);
    chip_debug_halt(&bench_chip);
    chip_look(&bench_chip);
    uint16_t count = SYSCTRL->WDCNTR;
    TEST_ASSERT_EQUAL_UINT16(400000u / 2560u, count);
    chip_run(5000000u);
    chip_look(&bench_chip);
    TEST_ASSERT_EQUAL_UINT16(count, SYSCTRL->WDCNTR);
    chip_debug_run(&bench_chip);
    chip_run(5000000u + bite - 400000u);
    TEST_ASSERT_FALSE(chip_halted(&bench_chip));
    chip_run(5000000u + bite - 400000u + 1u);
    TEST_ASSERT_TRUE(chip_halted(&bench_chip));
}

/* The registers that a debugger's restart does not change, and the three bits that it changes. */
static void test_restart_without_reset_keeps_everything(void)
{
    start_with(1u);
    enable_trip_interrupt();
    chip_set_pin(&bench_chip, 12u, false);
    chip_set_pin(&bench_chip, 12u, true);
    bus_debug_allow();
    bus_allow();
    bus_interrupts_disable();
    bus_write16(&PIE->group[1].IFR, 1u); /* the request goes to the CPU and waits there */
    chip_look(&bench_chip);
    static f28335_t before;
    before = bench_chip.registers;
    chip_debug_halt(&bench_chip);
    bus_interrupts_enable();
    chip_restart(&bench_chip);
    chip_debug_run(&bench_chip);
    TEST_ASSERT_EQUAL_UINT32(150000000u, chip_sysclk_hz(&bench_chip));
    TEST_ASSERT_TRUE(chip_tripped(&bench_chip, 1u));
    TEST_ASSERT_EQUAL_MEMORY(&before, &bench_chip.registers, sizeof before);
    TEST_ASSERT_FALSE(chip_debug_can_look(&bench_chip));
    bus_write16(&EPWM(1u)->TZCLR, TZ_OST);
    TEST_ASSERT_EQUAL_UINT32(1u, chip_report_count(&bench_chip, CHIP_PROTECTED_WRITE));
    uint32_t entered = bench_samples;
    chip_run(start + 9u * CARRIER);
    TEST_ASSERT_EQUAL_UINT32(entered, bench_samples); /* INTM is set */
    TEST_ASSERT_EQUAL_UINT64(start + 8u * CARRIER, chip_carrier_tick(&bench_chip));
    bus_interrupts_enable(); /* the old requests are taken: IER, IFR and the vectors are unchanged */
    chip_run(start + 9u * CARRIER + 100u);
    TEST_ASSERT_EQUAL_UINT32(entered + 1u, bench_samples);
    TEST_ASSERT_EQUAL_UINT32(1u, calls);
}

static void test_restart_revives_a_lost_CPU(void)
{
    bench_start(SKIP_VECTOR);
    chip_run(chip_now(&bench_chip) + 2u * CARRIER);
    TEST_ASSERT_TRUE(chip_halted(&bench_chip));
    chip_restart(&bench_chip);
    TEST_ASSERT_FALSE(chip_halted(&bench_chip));
    bus_write16(&EPWM(1u)->CMPA, 1234u);
    TEST_ASSERT_EQUAL_UINT16(1234u, EPWM(1u)->CMPA);
}
