/* CPU timers: TIM counts down, the period is (PRD + 1)(TDDR + 1) SYSCLK cycles, and the interrupt is
 * requested when TIM changes from 0 to PRD. */
#include <unity.h>

#include "bench.h"

static uint64_t start;
static uint64_t called_at[8];
static uint32_t calls;

void setUp(void)
{
    bench_power_on();
    bench_clock();
    calls = 0u;
}

static void run(uint64_t ticks)
{
    chip_run(start + ticks);
    chip_look(&bench_chip);
}

static void load(uint32_t n, uint32_t period, uint16_t tddr, uint16_t more)
{
    bus_write32(&CPU_TIMER(n)->PRD, period);
    bus_write16(&CPU_TIMER(n)->TPR, tddr & 0xFFu);
    bus_write16(&CPU_TIMER(n)->TPRH, tddr >> 8);
    bus_write16(&CPU_TIMER(n)->TCR, (uint16_t)(TCR_TRB | TCR_TIF | more));
    start = chip_now(&bench_chip);
}

static void test_runs_after_reset(void)
{
    bench_power_on();
    TEST_ASSERT_EQUAL_UINT32(0xFFFFu, CPU_TIMER(0u)->TIM);
    chip_run(1000u); /* 15 MHz: a tenth of the counts */
    chip_look(&bench_chip);
    TEST_ASSERT_EQUAL_UINT32(0xFFFFu - 100u, CPU_TIMER(0u)->TIM);
}

static void test_free_running_counts_down_every_cycle(void)
{
    load(0u, 0xFFFFFFFFu, 0u, 0u);
    TEST_ASSERT_EQUAL_UINT32(0xFFFFFFFFu, CPU_TIMER(0u)->TIM);
    run(123456789u);
    TEST_ASSERT_EQUAL_UINT32(0xFFFFFFFFu - 123456789u, CPU_TIMER(0u)->TIM);
    run(UINT64_C(0x100000000));
    TEST_ASSERT_EQUAL_UINT32(0xFFFFFFFFu, CPU_TIMER(0u)->TIM);
    TEST_ASSERT_EQUAL_HEX16(TCR_TIF, CPU_TIMER(0u)->TCR & TCR_TIF);
}

static void test_period_and_flag(void)
{
    load(1u, 99u, 0u, 0u);
    run(99u);
    TEST_ASSERT_EQUAL_UINT32(0u, CPU_TIMER(1u)->TIM);
    TEST_ASSERT_EQUAL_HEX16(0u, CPU_TIMER(1u)->TCR & TCR_TIF);
    run(100u);
    TEST_ASSERT_EQUAL_UINT32(99u, CPU_TIMER(1u)->TIM);
    TEST_ASSERT_EQUAL_HEX16(TCR_TIF, CPU_TIMER(1u)->TCR & TCR_TIF);
    bus_write16(&CPU_TIMER(1u)->TCR, 0u); /* writing zero does not clear the flag */
    TEST_ASSERT_EQUAL_HEX16(TCR_TIF, CPU_TIMER(1u)->TCR & TCR_TIF);
    bus_write16(&CPU_TIMER(1u)->TCR, TCR_TIF);
    TEST_ASSERT_EQUAL_HEX16(0u, CPU_TIMER(1u)->TCR & TCR_TIF);
    run(12345u);
    TEST_ASSERT_EQUAL_UINT32(99u - 45u, CPU_TIMER(1u)->TIM);
}

static void test_prescaler(void)
{
    load(0u, 9u, 299u, 0u);
    run(299u);
    TEST_ASSERT_EQUAL_UINT32(9u, CPU_TIMER(0u)->TIM);
    run(300u);
    TEST_ASSERT_EQUAL_UINT32(8u, CPU_TIMER(0u)->TIM);
    TEST_ASSERT_EQUAL_HEX16(0x2Bu, CPU_TIMER(0u)->TPR >> 8); /* PSC starts again at 299 = 0x12B */
    TEST_ASSERT_EQUAL_HEX16(0x01u, CPU_TIMER(0u)->TPRH >> 8);
    run(2999u);
    TEST_ASSERT_EQUAL_UINT32(0u, CPU_TIMER(0u)->TIM);
    run(3000u);
    TEST_ASSERT_EQUAL_UINT32(9u, CPU_TIMER(0u)->TIM);
}

static void test_new_prescale_acts_from_the_next_count(void)
{
    load(0u, 99u, 0u, 0u);
    run(10u);
    bus_write16(&CPU_TIMER(0u)->TPR, 9u); /* 89 follows at 11, then each count takes 10 */
    run(11u);
    TEST_ASSERT_EQUAL_UINT32(88u, CPU_TIMER(0u)->TIM);
    run(20u);
    TEST_ASSERT_EQUAL_UINT32(88u, CPU_TIMER(0u)->TIM);
    run(21u);
    TEST_ASSERT_EQUAL_UINT32(87u, CPU_TIMER(0u)->TIM);
}

static void test_stop_and_go_on(void)
{
    load(0u, 999u, 0u, 0u);
    run(100u);
    bus_write16(&CPU_TIMER(0u)->TCR, TCR_TSS);
    run(5000u);
    TEST_ASSERT_EQUAL_UINT32(899u, CPU_TIMER(0u)->TIM);
    bus_write16(&CPU_TIMER(0u)->TCR, 0u);
    run(5010u);
    TEST_ASSERT_EQUAL_UINT32(889u, CPU_TIMER(0u)->TIM);
    bus_allow();
    bus_write16(&SYSCTRL->PCLKCR3, PCLKCR3_GPIOIN);
    run(9000u);
    TEST_ASSERT_EQUAL_UINT32(889u, CPU_TIMER(0u)->TIM);
}

static void test_written_count(void)
{
    load(0u, 999u, 0u, 0u);
    bus_write32(&CPU_TIMER(0u)->TIM, 10u);
    run(10u);
    TEST_ASSERT_EQUAL_UINT32(0u, CPU_TIMER(0u)->TIM);
    run(11u);
    TEST_ASSERT_EQUAL_UINT32(999u, CPU_TIMER(0u)->TIM);
}

static void test_new_period_acts_at_the_reload(void)
{
    load(0u, 999u, 0u, 0u);
    run(100u);
    bus_write32(&CPU_TIMER(0u)->PRD, 49u);
    run(999u);
    TEST_ASSERT_EQUAL_UINT32(0u, CPU_TIMER(0u)->TIM);
    run(1000u);
    TEST_ASSERT_EQUAL_UINT32(49u, CPU_TIMER(0u)->TIM);
}

static void on_timer(void)
{
    if (calls < 8u) {
        called_at[calls] = chip_now(&bench_chip);
    }
    calls++;
    bus_write16(&PIE->PIEACK, 1u);
}

static void test_interrupts_of_all_three(void)
{
    static const uint32_t vector[3] = {PIE_VECTOR(1u, 7u), 13u, 14u};
    static const uint16_t group[3] = {1u, 13u, 14u};
    for (uint32_t n = 0u; n < 3u; n++) {
        setUp();
        bench_allowed32(&PIE_VECTORS->vector[vector[n]], bus_vector(on_timer));
        bus_write16(&PIE->PIECTRL, 1u);
        bus_write16(&PIE->group[0].IER, 1u << 6);
        bus_enable_group(group[n]);
        bus_interrupts_enable();
        load(n, 999u, 0u, TCR_TIE);
        run(3500u);
        TEST_ASSERT_EQUAL_UINT32(3u, calls);
        TEST_ASSERT_EQUAL_UINT64(start + 1014u, called_at[0]);
        TEST_ASSERT_EQUAL_UINT64(start + 3014u, called_at[2]);
        TEST_ASSERT_EQUAL_UINT32(3u, chip_interrupt_count(&bench_chip, vector[n]));
    }
}
