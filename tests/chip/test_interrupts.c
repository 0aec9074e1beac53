/* Interrupt logic of PIE and CPU. An interrupt function is entered 14 SYSCLK cycles after the request (see
 * pie.c). */
#include <unity.h>

#include "bench.h"

#define LATENCY 14u

static uint64_t start;
static uint32_t order[16];
static uint64_t order_at[16];
static uint32_t calls;
static bool nest;

void setUp(void)
{
    bench_power_on();
    bench_clock();
    calls = 0u;
    nest = false;
}

static void note(uint32_t who)
{
    if (calls < 16u) {
        order[calls] = who;
        order_at[calls] = chip_now(&bench_chip);
    }
    calls++;
}

static void on_seq1(void)
{
    note(11u);
    bus_write16(&ADC->ADCST, ADCST_INT_SEQ1_CLR);
    bus_write16(&PIE->PIEACK, 1u);
}

static void on_timer0(void)
{
    note(17u);
    bus_write16(&PIE->PIEACK, 1u);
}

static void on_trip(void)
{
    note(21u);
    bus_write16(&PIE->PIEACK, 2u);
}

static void on_timer1(void)
{
    note(130u);
    if (nest) {
        nest = false;
        bus_interrupts_enable();
        bus_wait(200u);
        note(131u);
    }
}

static void on_timer2(void)
{
    note(140u);
}

static void vectors(void)
{
    bus_allow();
    bus_write32(&PIE_VECTORS->vector[PIE_SEQ1INT], bus_vector(on_seq1));
    bus_write32(&PIE_VECTORS->vector[PIE_VECTOR(1u, 7u)], bus_vector(on_timer0));
    bus_write32(&PIE_VECTORS->vector[PIE_EPWM1_TZ], bus_vector(on_trip));
    bus_write32(&PIE_VECTORS->vector[13], bus_vector(on_timer1));
    bus_write32(&PIE_VECTORS->vector[14], bus_vector(on_timer2));
    bus_protect();
    bus_write16(&PIE->PIECTRL, PIECTRL_ENPIE);
    bus_write16(&PIE->group[0].IER, 1u << 0 | 1u << 6);
    bus_write16(&PIE->group[1].IER, 1u);
    bus_enable_group(1u);
    bus_enable_group(2u);
    bus_enable_group(13u);
    bus_enable_group(14u);
}

/* A software write of PIEIFR is a request like that of a peripheral. */
static void request(uint32_t group, uint16_t lines)
{
    bus_write16(&PIE->group[group - 1u].IFR, lines);
}

static void test_entry_comes_after_the_latency(void)
{
    vectors();
    bus_interrupts_enable();
    start = chip_now(&bench_chip);
    request(2u, 1u);
    chip_run(start + LATENCY);
    TEST_ASSERT_EQUAL_UINT32(0u, calls);
    chip_run(start + LATENCY + 1u);
    TEST_ASSERT_EQUAL_UINT32(1u, calls);
    TEST_ASSERT_EQUAL_UINT64(start + LATENCY, order_at[0]);
    TEST_ASSERT_EQUAL_UINT32(1u, chip_interrupt_count(&bench_chip, PIE_EPWM1_TZ));
    TEST_ASSERT_EQUAL_HEX16((0x0D00u + 2u * PIE_EPWM1_TZ) | 1u, PIE->PIECTRL);
}

static void test_injected_delay(void)
{
    vectors();
    bus_interrupts_enable();
    chip_set_interrupt_delay(&bench_chip, 1000u);
    start = chip_now(&bench_chip);
    request(2u, 1u);
    chip_run(start + 5000u);
    TEST_ASSERT_EQUAL_UINT64(start + LATENCY + 1000u, order_at[0]);
}

static void test_priority_lower_group_and_lower_line_first(void)
{
    vectors();
    request(2u, 1u);
    request(1u, 1u << 6 | 1u << 0);
    start = chip_now(&bench_chip);
    bus_interrupts_enable();
    chip_run(start + 1000u);
    TEST_ASSERT_EQUAL_UINT32(3u, calls);
    TEST_ASSERT_EQUAL_UINT32(11u, order[0]);
    TEST_ASSERT_EQUAL_UINT32(17u, order[1]);
    TEST_ASSERT_EQUAL_UINT32(21u, order[2]);
    TEST_ASSERT_EQUAL_UINT64(start + 2u * LATENCY, order_at[1]);
}

static void test_masked_interrupts_wait(void)
{
    vectors();
    start = chip_now(&bench_chip);
    request(2u, 1u);
    chip_run(start + 1000u);
    TEST_ASSERT_EQUAL_UINT32(0u, calls); /* INTM is set */
    bus_interrupts_enable();
    chip_run(start + 2000u);
    TEST_ASSERT_EQUAL_UINT32(1u, calls);
    bus_interrupts_disable();
    request(2u, 1u);
    chip_run(start + 3000u);
    TEST_ASSERT_EQUAL_UINT32(1u, calls);
}

static void test_group_and_line_enables(void)
{
    vectors();
    bus_interrupts_enable();
    bus_write16(&PIE->group[1].IER, 0u);
    start = chip_now(&bench_chip);
    request(2u, 1u);
    chip_run(start + 1000u);
    TEST_ASSERT_EQUAL_UINT32(0u, calls);
    TEST_ASSERT_EQUAL_HEX16(1u, PIE->group[1].IFR);
    bus_write16(&PIE->group[1].IER, 1u);
    chip_run(start + 2000u);
    TEST_ASSERT_EQUAL_UINT32(1u, calls);
    TEST_ASSERT_EQUAL_HEX16(0u, PIE->group[1].IFR);
}

static void no_acknowledge(void)
{
    note(0u);
}

static void test_missing_acknowledge_blocks_its_group_only(void)
{
    vectors();
    bench_allowed32(&PIE_VECTORS->vector[PIE_SEQ1INT], bus_vector(no_acknowledge));
    bus_interrupts_enable();
    start = chip_now(&bench_chip);
    request(1u, 1u);
    chip_run(start + 1000u);
    TEST_ASSERT_EQUAL_HEX16(1u, PIE->PIEACK);
    request(1u, 1u << 0 | 1u << 6);
    chip_run(start + 2000u);
    TEST_ASSERT_EQUAL_UINT32(1u, calls);
    request(2u, 1u);
    chip_run(start + 3000u);
    TEST_ASSERT_EQUAL_UINT32(2u, calls);
    bus_write16(&PIE->PIEACK, 1u);
    chip_run(start + 4000u);
    TEST_ASSERT_EQUAL_UINT32(3u, calls);
}

static void test_flag_taken_back_gives_the_first_vector_of_the_group(void)
{
    vectors();
    start = chip_now(&bench_chip);
    request(1u, 1u << 6);
    request(1u, 0u); /* the CPU already has the request of the group */
    bus_interrupts_enable();
    chip_run(start + 1000u);
    TEST_ASSERT_EQUAL_UINT32(11u, order[0]);
}

static void test_missing_vector_loses_the_CPU(void)
{
    vectors();
    bus_interrupts_enable();
    bus_write16(&PIE->group[2].IER, 1u);
    bus_enable_group(3u);
    start = chip_now(&bench_chip);
    request(3u, 1u);
    chip_run(start + 1000u);
    TEST_ASSERT_TRUE(chip_halted(&bench_chip));
    TEST_ASSERT_EQUAL_UINT32(1u, chip_report_count(&bench_chip, CHIP_NO_VECTOR));
    TEST_ASSERT_EQUAL_UINT32(PIE_VECTOR(3u, 1u), chip_last_report(&bench_chip)->address);
    TEST_ASSERT_EQUAL_UINT64(start + LATENCY, chip_last_report(&bench_chip)->tick);
    bus_write16(&PIE->group[1].IFR, 1u); /* the program has ended */
    TEST_ASSERT_EQUAL_HEX16(0u, PIE->group[1].IFR);
}

/* Two groups request an interrupt. The CPU has received the first request before ENPIE was cleared; the
 * second waits in the PIE. */
static void test_without_ENPIE_nothing_goes_to_the_CPU(void)
{
    vectors();
    bus_write16(&PIE->PIECTRL, 0u);
    bus_interrupts_enable();
    start = chip_now(&bench_chip);
    request(2u, 1u);
    chip_run(start + 1000u);
    TEST_ASSERT_EQUAL_UINT32(0u, calls);
    TEST_ASSERT_FALSE(chip_halted(&bench_chip));
    TEST_ASSERT_EQUAL_HEX16(1u, PIE->group[1].IFR);
    TEST_ASSERT_EQUAL_HEX16(0u, PIE->PIEACK);
    bus_write16(&PIE->PIECTRL, PIECTRL_ENPIE);
    chip_run(start + 2000u);
    TEST_ASSERT_EQUAL_UINT32(1u, calls);
}

static void test_what_reached_the_CPU_before_ENPIE_was_cleared_loses_it(void)
{
    vectors();
    request(2u, 1u);
    bus_write16(&PIE->PIECTRL, 0u);
    bus_interrupts_enable();
    chip_run(chip_now(&bench_chip) + 1000u);
    TEST_ASSERT_TRUE(chip_halted(&bench_chip)); /* the vectors of the boot ROM point to no function */
}

/* The initialisation must remove the state that an earlier program has left: no group enabled, nothing
 * pending in the CPU, no flag in the PIE. */
static void test_leftovers_can_be_cleared(void)
{
    vectors();
    start = chip_now(&bench_chip);
    request(1u, 1u << 0 | 1u << 6);
    request(2u, 1u);
    bus_disable_groups();
    bus_write16(&PIE->PIECTRL, 0u);
    bus_write16(&PIE->group[0].IER, 0u);
    bus_write16(&PIE->group[0].IFR, 0u);
    bus_write16(&PIE->group[1].IFR, 0u);
    TEST_ASSERT_EQUAL_HEX16(0u, PIE->group[0].IFR | PIE->group[1].IFR);
    bus_clear_pending();
    bus_write16(&PIE->PIEACK, 0x0FFFu);
    bus_write16(&PIE->PIECTRL, PIECTRL_ENPIE);
    bus_write16(&PIE->group[0].IER, 1u);
    bus_interrupts_enable();
    bus_enable_group(1u);
    bus_enable_group(2u);
    chip_run(start + 1000u);
    TEST_ASSERT_EQUAL_UINT32(0u, calls);
    request(1u, 1u);
    chip_run(start + 2000u);
    TEST_ASSERT_EQUAL_UINT32(1u, calls);
}

static void test_disabled_groups_wait(void)
{
    vectors();
    bus_interrupts_enable();
    bus_disable_groups();
    start = chip_now(&bench_chip);
    request(2u, 1u);
    chip_run(start + 1000u);
    TEST_ASSERT_EQUAL_UINT32(0u, calls);
    bus_enable_group(2u);
    chip_run(start + 2000u);
    TEST_ASSERT_EQUAL_UINT32(1u, calls);
}

static void open_inside(void)
{
    note(0u);
    bus_write16(&EPWM(1u)->TZFRC, TZ_OST); /* EALLOW is clear here: the code outside had set it */
    bus_allow();
    bus_write16(&PIE->PIEACK, 2u);
}

static void test_EALLOW_is_closed_inside_and_restored_after(void)
{
    vectors();
    bus_allow();
    bus_write32(&PIE_VECTORS->vector[PIE_EPWM1_TZ], bus_vector(open_inside));
    bus_interrupts_enable();
    request(2u, 1u);
    chip_run(chip_now(&bench_chip) + 1000u);
    TEST_ASSERT_EQUAL_UINT32(1u, chip_report_count(&bench_chip, CHIP_PROTECTED_WRITE));
    bus_write16(&EPWM(1u)->TZFRC, TZ_OST);
    TEST_ASSERT_EQUAL_HEX16(TZ_OST, EPWM(1u)->TZFLG);
    bus_protect();
    request(2u, 1u);
    chip_run(chip_now(&bench_chip) + 1000u);
    bus_write16(&EPWM(2u)->TZFRC, TZ_OST); /* the function sets EALLOW, and the return clears it */
    TEST_ASSERT_EQUAL_HEX16(0u, EPWM(2u)->TZFLG);
}

static void test_interrupt_that_clears_INTM_can_be_interrupted(void)
{
    vectors();
    nest = true;
    bus_write32(&CPU_TIMER(1u)->PRD, 99u);
    bus_write16(&CPU_TIMER(1u)->TCR, TCR_TRB | TCR_TIE);
    bus_write32(&CPU_TIMER(2u)->PRD, 149u);
    bus_write16(&CPU_TIMER(2u)->TCR, TCR_TRB | TCR_TIE);
    start = chip_now(&bench_chip);
    bus_interrupts_enable();
    chip_run(start + 300u);
    TEST_ASSERT_EQUAL_UINT32(130u, order[0]); /* requested at 114, waits until 314 */
    TEST_ASSERT_EQUAL_UINT32(140u, order[1]);
    TEST_ASSERT_EQUAL_UINT64(start + 100u + LATENCY, order_at[0]);
    TEST_ASSERT_EQUAL_UINT64(start + 150u + LATENCY, order_at[1]);
    TEST_ASSERT_EQUAL_UINT32(131u, order[calls - 1u]);
    TEST_ASSERT_EQUAL_UINT64(start + 100u + LATENCY + 200u, chip_now(&bench_chip));
}

static void test_sample_interrupt_to_the_tick(void)
{
    setUp();
    bench_start(0u);
    start = chip_now(&bench_chip);
    chip_run(start + 5u * CARRIER + 1000u);
    TEST_ASSERT_EQUAL_UINT32(5u, bench_samples);
    /* The SOC comes 87 before zero, the last result 45 + 3 x 42 + 30 after the SOC. */
    for (uint32_t k = 0u; k < 5u; k++) {
        TEST_ASSERT_EQUAL_UINT64(start + (k + 1u) * (uint64_t)CARRIER - 87u + 201u + LATENCY,
                                 bench_sample_at[k]);
    }
    TEST_ASSERT_EQUAL_UINT64(bench_sample_at[4], chip_sample_tick(&bench_chip));
    TEST_ASSERT_EQUAL_UINT32(5u, chip_interrupt_count(&bench_chip, PIE_SEQ1INT));
}

static uint16_t counter_inside;

static void look_inside(void)
{
    counter_inside = EPWM(1u)->TBCTR;
}

static void test_registers_are_fresh_inside(void)
{
    setUp();
    bench_start(0u);
    bench_in_interrupt = look_inside;
    start = chip_now(&bench_chip);
    chip_run(start + CARRIER + 1000u);
    TEST_ASSERT_EQUAL_UINT16(201u - 87u + LATENCY, counter_inside);
}

static uint32_t epwm_calls;

static void on_epwm(void)
{
    epwm_calls++;
    bus_write16(&PIE->PIEACK, 4u);
}

static void test_epwm_interrupt_every_third_event_waits_for_its_flag(void)
{
    epwm_calls = 0u;
    bench_start(0u);
    bench_allowed32(&PIE_VECTORS->vector[PIE_VECTOR(3u, 2u)], bus_vector(on_epwm));
    bus_write16(&PIE->group[2].IER, 2u);
    bus_enable_group(3u);
    bus_write16(&EPWM(2u)->ETPS, ETPS_INTPRD(3));
    bus_write16(&EPWM(2u)->ETSEL, ETSEL_INTEN | ETSEL_INTSEL(ET_PERIOD));
    start = chip_now(&bench_chip);
    chip_run(start + 3u * CARRIER);
    TEST_ASSERT_EQUAL_UINT32(1u, epwm_calls);
    TEST_ASSERT_EQUAL_HEX16(ET_FLAG_INT, EPWM(2u)->ETFLG);
    chip_run(start + 9u * CARRIER);
    TEST_ASSERT_EQUAL_UINT32(1u, epwm_calls);
    bus_write16(&EPWM(2u)->ETCLR, ET_FLAG_INT); /* the request that waited is taken at once */
    chip_run(start + 9u * CARRIER + 20u);
    TEST_ASSERT_EQUAL_UINT32(2u, epwm_calls);
}
