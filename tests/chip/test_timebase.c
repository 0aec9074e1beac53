/* Time base and counter compare of ePWM at register level. All ticks follow from SPRUG04: TBCLK = SYSCLK /
 * (HSPCLKDIV x CLKDIV), period TBPRD + 1 counting up or down, 2 TBPRD up-down. SYSCLK is 150 MHz, so a cycle
 * is a tick. */
#include <unity.h>

#include "bench.h"

static uint64_t start; /* tick of TBCLKSYNC */

void setUp(void)
{
    bench_power_on();
    bench_clock();
    bench_allowed32(&GPIO_CONTROL(0u)->MUX1, 0x00000555u);
}

static void set(uint32_t n, uint16_t tbctl, uint16_t period, uint16_t cmpa, uint16_t cmpb, uint16_t aqctla)
{
    bus_write16(&EPWM(n)->TBCTL, tbctl);
    bus_write16(&EPWM(n)->TBPRD, period);
    bus_write16(&EPWM(n)->CMPA, cmpa);
    bus_write16(&EPWM(n)->CMPB, cmpb);
    bus_write16(&EPWM(n)->AQCTLA, aqctla);
}

static void go(void)
{
    bench_allowed16(&SYSCTRL->PCLKCR0, PCLKCR0_ADC | PCLKCR0_TBCLKSYNC);
    start = chip_now(&bench_chip);
    bench_forget();
}

/* The edges of pin EPWM1A, relative to the start. */
static void expect_edges(const uint64_t *tick, uint32_t count, uint64_t until)
{
    chip_run(start + until);
    uint32_t level = 0u;
    uint32_t found = 0u;
    for (uint32_t i = 0u; i < bench.edges; i++) {
        if ((bench.edge[i].level & 1u) != level) {
            level ^= 1u;
            TEST_ASSERT_TRUE_MESSAGE(found < count, "more edges than expected");
            TEST_ASSERT_EQUAL_UINT64(start + tick[found], bench.edge[i].tick);
            found++;
        }
    }
    TEST_ASSERT_EQUAL_UINT32(count, found);
}

static void test_reset_values(void)
{
    bench_power_on();
    TEST_ASSERT_EQUAL_HEX16(0x0083u, EPWM(1u)->TBCTL);
    TEST_ASSERT_EQUAL_HEX16(0x0001u, EPWM(1u)->TBSTS);
    TEST_ASSERT_EQUAL_HEX16(0x0000u, EPWM(3u)->DBCTL);
}

static void test_up_count_period_is_one_more_than_TBPRD(void)
{
    set(1u, TBCTL_CTRMODE(0), 999u, 300u, 0u, AQCTL_ZRO(AQ_SET) | AQCTL_CAU(AQ_CLEAR));
    /* At the first zero CMPA still has its reset value 0; its clear has priority over the set at zero. */
    go();
    expect_edges((const uint64_t[]){1000u, 1300u, 2000u}, 3u, 2001u);
}

static void test_down_count_reloads_from_zero(void)
{
    /* The counter starts at zero, and the next count is 999. The down match with CMPA comes 699 counts
     * later, at 1 + 999 - 300. */
    set(1u, TBCTL_CTRMODE(1), 999u, 300u, 0u, AQCTL_PRD(AQ_SET) | AQCTL_CAD(AQ_CLEAR));
    go();
    expect_edges((const uint64_t[]){1u, 700u, 1001u, 1700u}, 4u, 2001u);
}

static void test_up_down_is_symmetric_about_zero(void)
{
    set(1u, TBCTL_UPDOWN, 1000u, 300u, 0u, AQCTL_CAU(AQ_CLEAR) | AQCTL_CAD(AQ_SET));
    go();
    expect_edges((const uint64_t[]){1700u, 2300u, 3700u, 4300u}, 4u, 5000u);
}

static void test_all_six_events_act(void)
{
    set(1u, TBCTL_UPDOWN, 1000u, 200u, 600u,
        AQCTL_ZRO(AQ_SET) | AQCTL_CAU(AQ_CLEAR) | AQCTL_CBU(AQ_SET) | AQCTL_PRD(AQ_CLEAR) |
            AQCTL_CBD(AQ_TOGGLE) | AQCTL_CAD(AQ_CLEAR));
    go();
    expect_edges((const uint64_t[]){0u, 200u, 600u, 1000u, 1400u, 1800u, 2000u}, 7u, 2001u);
}

static void test_output_b_has_its_own_actions(void)
{
    set(1u, TBCTL_UPDOWN, 1000u, 200u, 600u, 0u);
    bus_write16(&EPWM(1u)->AQCTLB, AQCTL_CBU(AQ_SET) | AQCTL_CBD(AQ_CLEAR));
    go();
    chip_run(start + 2000u);
    TEST_ASSERT_EQUAL_UINT64(800u, bench_high_of(1u, start, start + 2000u));
    TEST_ASSERT_EQUAL_UINT64(0u, bench_high_of(0u, start, start + 2000u));
}

static void test_clock_dividers_multiply(void)
{
    /* HSPCLKDIV 3 divides by 6, CLKDIV 2 by 4: a count is 24 ticks. */
    set(1u, TBCTL_CTRMODE(0) | TBCTL_HSPCLKDIV(3) | TBCTL_CLKDIV(2), 99u, 50u, 0u,
        AQCTL_ZRO(AQ_SET) | AQCTL_CAU(AQ_CLEAR));
    go();
    expect_edges((const uint64_t[]){2400u, 3600u}, 2u, 4000u);
}

static void test_compare_shadow_waits_for_zero(void)
{
    set(1u, TBCTL_UPDOWN, 1000u, 300u, 0u, AQCTL_CAU(AQ_CLEAR) | AQCTL_CAD(AQ_SET));
    go();
    chip_run(start + 400u);
    /* Written after the up match and before the down match with the old value. */
    bus_write16(&EPWM(1u)->CMPA, 500u);
    expect_edges((const uint64_t[]){1700u, 2500u, 3500u}, 3u, 4000u);
}

static void test_compare_shadow_at_period(void)
{
    bus_write16(&EPWM(1u)->CMPCTL, CMPCTL_LOADAMODE(1));
    set(1u, TBCTL_UPDOWN, 1000u, 300u, 0u, AQCTL_CAU(AQ_CLEAR) | AQCTL_CAD(AQ_SET));
    go(); /* the active CMPA is 0 until the first period match */
    chip_run(start + 1100u);
    bus_write16(&EPWM(1u)->CMPA, 500u);
    expect_edges((const uint64_t[]){1700u, 2300u, 3500u}, 3u, 4000u);
}

static void test_compare_load_frozen(void)
{
    set(1u, TBCTL_UPDOWN, 1000u, 300u, 0u, AQCTL_CAU(AQ_CLEAR) | AQCTL_CAD(AQ_SET));
    go();
    chip_run(start + 100u);
    bus_write16(&EPWM(1u)->CMPCTL, CMPCTL_LOADAMODE(3));
    bus_write16(&EPWM(1u)->CMPA, 500u);
    expect_edges((const uint64_t[]){1700u, 2300u, 3700u}, 3u, 4000u);
}

static void test_compare_immediate(void)
{
    set(1u, TBCTL_UPDOWN, 1000u, 300u, 0u, AQCTL_CAU(AQ_CLEAR) | AQCTL_CAD(AQ_SET));
    bus_write16(&EPWM(1u)->CMPCTL, CMPCTL_SHDWAMODE);
    go();
    chip_run(start + 1100u);
    bus_write16(&EPWM(1u)->CMPA, 500u);
    expect_edges((const uint64_t[]){1500u, 2500u}, 2u, 3000u);
}

static void test_compare_of_zero_loaded_at_zero_misses_that_zero(void)
{
    set(1u, TBCTL_UPDOWN, 1000u, 300u, 0u, AQCTL_CAU(AQ_CLEAR) | AQCTL_CAD(AQ_SET));
    go();
    chip_run(start + 100u);
    bus_write16(&EPWM(1u)->CMPA, 0u); /* loaded at 2000; high for a whole period, cleared at 4000 */
    expect_edges((const uint64_t[]){1700u, 4000u}, 2u, 9000u);
}

static void test_compare_at_and_above_period_acts_at_the_period_match(void)
{
    for (uint16_t cmpa = 1000u; cmpa <= 1001u; cmpa++) {
        setUp();
        set(1u, TBCTL_UPDOWN, 1000u, cmpa, 0u, AQCTL_CAU(AQ_CLEAR) | AQCTL_CAD(AQ_SET));
        go(); /* both events occur at the period match, where the event of counting down has priority */
        expect_edges((const uint64_t[]){1000u}, 1u, 9000u);
    }
}

static void test_compare_one_below_period_is_a_pulse_of_two(void)
{
    set(1u, TBCTL_UPDOWN, 1000u, 999u, 0u, AQCTL_CAU(AQ_CLEAR) | AQCTL_CAD(AQ_SET));
    go();
    expect_edges((const uint64_t[]){1001u, 2999u, 3001u}, 3u, 4000u);
}

static void test_up_count_compare_above_period_never_acts(void)
{
    set(1u, TBCTL_CTRMODE(0), 999u, 1000u, 0u, AQCTL_ZRO(AQ_SET) | AQCTL_CAU(AQ_CLEAR));
    go();
    expect_edges((const uint64_t[]){1000u}, 1u, 5000u);
}

static void test_up_count_priorities(void)
{
    /* At 0 the zero event coincides with CAU, which has priority; at the period the period event coincides
     * with CBU, and the period event has priority. */
    set(1u, TBCTL_CTRMODE(0), 999u, 0u, 999u,
        AQCTL_ZRO(AQ_CLEAR) | AQCTL_CAU(AQ_SET) | AQCTL_CBU(AQ_SET) | AQCTL_PRD(AQ_CLEAR));
    go();
    chip_run(start + 1u);
    bus_write16(&EPWM(1u)->CMPA, 0u);
    expect_edges((const uint64_t[]){0u, 999u, 1000u, 1999u}, 4u, 2000u);
}

static void test_period_shadow_waits_for_zero_and_immediate_does_not(void)
{
    set(1u, TBCTL_CTRMODE(0), 999u, 0u, 0u, AQCTL_ZRO(AQ_TOGGLE));
    go();
    chip_run(start + 100u);
    bus_write16(&EPWM(1u)->TBPRD, 499u);
    expect_edges((const uint64_t[]){0u, 1000u, 1500u, 2000u}, 4u, 2001u);
    setUp();
    set(1u, TBCTL_CTRMODE(0) | TBCTL_PRDLD, 999u, 0u, 0u, AQCTL_ZRO(AQ_TOGGLE));
    go();
    chip_run(start + 100u);
    bus_write16(&EPWM(1u)->TBPRD, 499u);
    expect_edges((const uint64_t[]){0u, 500u, 1000u, 1500u}, 4u, 1501u);
}

static void test_counter_past_its_period_runs_to_the_top(void)
{
    set(1u, TBCTL_CTRMODE(0) | TBCTL_PRDLD, 999u, 0u, 0u, AQCTL_ZRO(AQ_TOGGLE));
    go();
    chip_run(start + 600u);
    bus_write16(&EPWM(1u)->TBPRD, 499u);
    expect_edges((const uint64_t[]){0u, 65536u, 66036u}, 3u, 66100u);
    chip_look(&bench_chip);
    TEST_ASSERT_EQUAL_HEX16(0x0004u, EPWM(1u)->TBSTS & 0x0004u);
    bus_write16(&EPWM(1u)->TBSTS, 0x0004u);
    TEST_ASSERT_EQUAL_HEX16(0x0000u, EPWM(1u)->TBSTS & 0x0004u);
}

static void test_counter_registers_follow(void)
{
    set(1u, TBCTL_UPDOWN, 1000u, 300u, 0u, 0u);
    go();
    static const uint16_t count[] = {0u, 1u, 999u, 1000u, 999u, 1u, 0u};
    static const uint16_t up[] = {1u, 1u, 1u, 0u, 0u, 0u, 1u};
    static const uint64_t at[] = {0u, 1u, 999u, 1000u, 1001u, 1999u, 2000u};
    for (uint32_t i = 0u; i < 7u; i++) {
        chip_run(start + at[i]);
        chip_look(&bench_chip);
        TEST_ASSERT_EQUAL_UINT16(count[i], EPWM(1u)->TBCTR);
        TEST_ASSERT_EQUAL_UINT16(up[i], EPWM(1u)->TBSTS & 1u);
    }
}

static void test_written_counter_counts_on(void)
{
    set(1u, TBCTL_UPDOWN, 1000u, 300u, 0u, AQCTL_CAU(AQ_CLEAR) | AQCTL_CAD(AQ_SET));
    go();
    chip_run(start + 100u);
    /* Counts up; the period match follows at 200, the CMPA down match 700 later. */
    bus_write16(&EPWM(1u)->TBCTR, 900u);
    expect_edges((const uint64_t[]){900u}, 1u, 1000u);
}

static void test_freeze_mode_keeps_the_count(void)
{
    set(1u, TBCTL_UPDOWN, 1000u, 300u, 0u, AQCTL_CAU(AQ_CLEAR) | AQCTL_CAD(AQ_SET));
    go();
    chip_run(start + 600u);
    bus_write16(&EPWM(1u)->TBCTL, TBCTL_CTRMODE(3));
    chip_run(start + 1600u);
    chip_look(&bench_chip);
    TEST_ASSERT_EQUAL_UINT16(600u, EPWM(1u)->TBCTR);
    bus_write16(&EPWM(1u)->TBCTL, TBCTL_UPDOWN);
    expect_edges((const uint64_t[]){2700u, 3300u}, 2u, 4000u); /* all edges come 1000 later */
}

static void test_TBCLKSYNC_stops_and_starts_all(void)
{
    set(1u, TBCTL_UPDOWN, 1000u, 300u, 0u, AQCTL_CAU(AQ_CLEAR) | AQCTL_CAD(AQ_SET));
    go();
    chip_run(start + 600u);
    bus_allow();
    bus_write16(&SYSCTRL->PCLKCR0, PCLKCR0_ADC);
    chip_run(start + 1600u);
    bus_write16(&SYSCTRL->PCLKCR0, PCLKCR0_ADC | PCLKCR0_TBCLKSYNC);
    bus_protect();
    expect_edges((const uint64_t[]){2700u, 3300u}, 2u, 4000u);
}

static void test_slave_lags_two_cycles_and_TBPHS_2_hides_it(void)
{
    for (uint16_t phase = 0u; phase <= 2u; phase += 2u) {
        setUp();
        for (uint32_t n = 1u; n <= 3u; n++) {
            set(n, n == 1u ? TBCTL_UPDOWN | TBCTL_SYNCOSEL(1) : TBCTL_UPDOWN | TBCTL_PHSEN | TBCTL_PHSDIR_UP,
                1000u, 300u, 0u, AQCTL_CAU(AQ_CLEAR) | AQCTL_CAD(AQ_SET));
            bus_write16(&EPWM(n)->TBPHS, n == 1u ? 0u : phase);
        }
        go();
        bus_write16(&EPWM(2u)->TBCTR, 500u); /* out of phase until the next synchronisation */
        bus_write16(&EPWM(3u)->TBCTR, 600u);
        chip_run(start + 2500u);
        chip_look(&bench_chip);
        TEST_ASSERT_EQUAL_UINT16(500u, EPWM(1u)->TBCTR);
        TEST_ASSERT_EQUAL_UINT16(500u - 2u + phase, EPWM(2u)->TBCTR);
        TEST_ASSERT_EQUAL_UINT16(500u - 2u + phase, EPWM(3u)->TBCTR);
    }
}

static void test_sync_with_divided_clock_lags_one_count(void)
{
    set(1u, TBCTL_UPDOWN | TBCTL_SYNCOSEL(1) | TBCTL_CLKDIV(2), 1000u, 0u, 0u, 0u);
    set(2u, TBCTL_UPDOWN | TBCTL_PHSEN | TBCTL_PHSDIR_UP | TBCTL_CLKDIV(2), 1000u, 0u, 0u, 0u);
    bus_write16(&EPWM(2u)->TBPHS, 1u);
    go();
    chip_run(start + 40u);
    bus_write16(&EPWM(2u)->TBCTR, 700u);
    chip_run(start + 4u * 2300u);
    chip_look(&bench_chip);
    TEST_ASSERT_EQUAL_UINT16(300u, EPWM(1u)->TBCTR);
    TEST_ASSERT_EQUAL_UINT16(300u, EPWM(2u)->TBCTR);
}

static void test_phase_direction_down(void)
{
    set(1u, TBCTL_UPDOWN | TBCTL_SYNCOSEL(1), 1000u, 0u, 0u, 0u);
    set(2u, TBCTL_UPDOWN | TBCTL_PHSEN, 1000u, 0u, 0u, 0u);
    bus_write16(&EPWM(2u)->TBPHS, 800u);
    go();
    chip_run(start + 102u);
    chip_look(&bench_chip);
    TEST_ASSERT_EQUAL_UINT16(700u, EPWM(2u)->TBCTR);
    TEST_ASSERT_EQUAL_UINT16(0u, EPWM(2u)->TBSTS & 1u);
}

static void test_software_sync(void)
{
    set(1u, TBCTL_UPDOWN, 1000u, 0u, 0u, 0u);
    set(2u, TBCTL_UPDOWN | TBCTL_PHSEN | TBCTL_PHSDIR_UP, 1000u, 0u, 0u, 0u);
    bus_write16(&EPWM(2u)->TBPHS, 50u);
    go();
    chip_run(start + 400u);
    bus_write16(&EPWM(1u)->TBCTL, TBCTL_UPDOWN | TBCTL_SWFSYNC);
    chip_run(start + 412u);
    chip_look(&bench_chip);
    TEST_ASSERT_EQUAL_UINT16(60u, EPWM(2u)->TBCTR);
    TEST_ASSERT_EQUAL_HEX16(0u, EPWM(1u)->TBCTL & TBCTL_SWFSYNC);
}

static void test_sync_out_off_and_at_compare_b(void)
{
    set(1u, TBCTL_UPDOWN | TBCTL_SYNCOSEL(3), 1000u, 0u, 600u, 0u);
    set(2u, TBCTL_UPDOWN | TBCTL_PHSEN | TBCTL_PHSDIR_UP, 1000u, 0u, 0u, 0u);
    bus_write16(&EPWM(2u)->TBPHS, 50u);
    go();
    chip_run(start + 700u);
    chip_look(&bench_chip);
    TEST_ASSERT_EQUAL_UINT16(700u, EPWM(2u)->TBCTR);
    bus_write16(&EPWM(1u)->TBCTL, TBCTL_UPDOWN | TBCTL_SYNCOSEL(2));
    chip_run(start + 1400u + 12u); /* CTR = CMPB counting down at 1400 */
    chip_look(&bench_chip);
    TEST_ASSERT_EQUAL_UINT16(60u, EPWM(2u)->TBCTR);
}

static void test_modules_4_to_6_count_too(void)
{
    bench_allowed16(&SYSCTRL->PCLKCR1, 0x003Fu);
    set(6u, TBCTL_UPDOWN, 1000u, 0u, 0u, 0u);
    go();
    chip_run(start + 1250u);
    chip_look(&bench_chip);
    TEST_ASSERT_EQUAL_UINT16(750u, EPWM(6u)->TBCTR);
}
