/* Software that takes time: time passes during an interrupt function, and in a part of the background with
 * INTM set. The tests check when an interrupt is taken and when the CPU returns to the background. */
#include <unity.h>

#include "bench.h"

#define LATENCY 14u /* [ticks] request to entry, see test_interrupts.c */
/* [ticks] from counter zero to the sample interrupt: the last result comes 201 after the SOC, which is 87
 * before zero. */
#define ENTRY 114u
#define WORK  2000u /* [ticks] */

static uint64_t start;
static chip_world_t world;
static uint64_t work;  /* [ticks] execution time of the sample interrupt before it writes */
static uint64_t wrote; /* tick of its last write */
static uint32_t vectors[8];
static uint32_t vector_count;
static uint64_t section; /* [ticks] duration of a part of the background with INTM set */
static uint64_t trip_at;
static uint64_t timer_at;

static void take(void *context, uint32_t vector, void (*function)(void))
{
    (void)context;
    vectors[vector_count++ % 8u] = vector;
    if (vector == PIE_SEQ1INT && work != 0u) {
        chip_run(chip_now(&bench_chip) + work);
        chip_look(&bench_chip);
    }
    function();
    if (vector == PIE_SEQ1INT) {
        wrote = chip_now(&bench_chip);
    }
}

static uint64_t section_of(void *context)
{
    (void)context;
    return section;
}

static void on_timer(void)
{
    timer_at = chip_now(&bench_chip);
    bus_write16(&PIE->PIEACK, 1u);
}

static void on_trip(void)
{
    trip_at = chip_now(&bench_chip);
    bus_write16(&PIE->PIEACK, 2u);
}

void setUp(void)
{
    bench_power_on();
    world = bench_world;
    world.interrupt = take;
    world.section = section_of;
    work = 0u;
    section = 0u;
    vector_count = 0u;
    chip_bind(&bench_chip, &world);
    bench_compare[0] = 3000u;
    bench_start(0u);
    bench_allowed32(&PIE_VECTORS->vector[PIE_EPWM1_TZ], bus_vector(on_trip));
    bus_write16(&PIE->group[1].IER, 1u);
    bus_enable_group(2u);
    start = chip_now(&bench_chip);
}

static uint64_t entry(uint32_t k)
{
    return start + (uint64_t)k * CARRIER + ENTRY + LATENCY;
}

static void test_the_hook_gets_every_interrupt_and_its_vector(void)
{
    chip_run(start + CARRIER + 1000u);
    bus_write16(&PIE->group[1].IFR, 1u);
    chip_run(start + 2u * CARRIER);
    TEST_ASSERT_EQUAL_UINT32(2u, vector_count);
    TEST_ASSERT_EQUAL_UINT32(PIE_SEQ1INT, vectors[0]);
    TEST_ASSERT_EQUAL_UINT32(PIE_EPWM1_TZ, vectors[1]);
    TEST_ASSERT_EQUAL_UINT32(1u, bench_samples);
}

static void test_what_is_written_after_the_work_is_written_then(void)
{
    work = WORK;
    chip_run(start + CARRIER + 5000u);
    TEST_ASSERT_EQUAL_UINT64(entry(1u) + WORK, wrote);
    TEST_ASSERT_EQUAL_UINT64(start + CARRIER + 5000u, chip_now(&bench_chip));
}

/* A write just before the zero of period 5 acts in period 5; a write just after it acts from the zero of
 * period 6 on. A leg is high for twice its compare value, which is 3000 before and 2000 after, less the
 * dead band of 450. */
static void high_after(uint64_t ticks, uint64_t high_5, uint64_t high_6)
{
    chip_run(start + 4u * CARRIER);
    work = ticks;
    bench_compare[0] = 2000u;
    chip_run(start + 5u * CARRIER - 500u);
    chip_run(start + 8u * CARRIER);
    TEST_ASSERT_EQUAL_UINT64(high_5 - 450u, bench_high_of(0u, start + 5u * CARRIER, start + 6u * CARRIER));
    TEST_ASSERT_EQUAL_UINT64(high_6 - 450u, bench_high_of(0u, start + 6u * CARRIER, start + 7u * CARRIER));
}

static void test_compare_values_written_before_the_zero_act_from_it(void)
{
    high_after(CARRIER - ENTRY - LATENCY - 1u, 4000u, 4000u);
}

static void test_compare_values_written_after_the_zero_act_a_period_later(void)
{
    high_after(CARRIER - ENTRY - LATENCY + 1u, 6000u, 4000u);
}

/* An interrupt of another group waits for the running function; the trip of the gates itself needs no
 * software. */
static void test_an_interrupt_waits_for_the_one_that_works(void)
{
    work = WORK;
    chip_run(start + CARRIER);
    chip_run(entry(1u));
    TEST_ASSERT_EQUAL_UINT32(0u, vector_count);
    bus_write16(&PIE->group[1].IFR, 1u);
    chip_run(start + 2u * CARRIER);
    /* Both requests wait when the first function is entered: group 1 is taken, and group 2 after its
     * return. */
    TEST_ASSERT_EQUAL_UINT64(entry(1u) + WORK + LATENCY, trip_at);
}

static void test_of_its_own_group_the_next_comes_after_return_and_acknowledge(void)
{
    bench_allowed32(&PIE_VECTORS->vector[PIE_VECTOR(1u, 7u)], bus_vector(on_timer));
    bus_write16(&PIE->group[0].IER, 1u | 1u << 6);
    work = WORK;
    chip_run(entry(1u));
    bus_write16(&PIE->group[0].IFR,
                1u | 1u << 6); /* the CPU has taken the first request and has not entered its function yet */
    chip_run(start + 2u * CARRIER);
    TEST_ASSERT_EQUAL_UINT64(entry(1u) + WORK + LATENCY, timer_at);
}

/* The sample interrupt clears its flag at its end. A sequence that ends before this finds the flag set,
 * and its interrupt is lost. */
static void test_longer_than_a_period_a_sample_is_lost(void)
{
    work = CARRIER + WORK;
    chip_run(start + 5u * CARRIER);
    TEST_ASSERT_EQUAL_UINT32(2u, bench_samples);
    TEST_ASSERT_EQUAL_UINT64(entry(1u) + CARRIER + WORK, bench_sample_at[0]);
    TEST_ASSERT_EQUAL_UINT64(entry(3u) + CARRIER + WORK, bench_sample_at[1]);
}

static void test_a_section_holds_interrupts_until_its_time_is_over(void)
{
    section = WORK;
    chip_run(start + CARRIER);
    bus_interrupts_disable();
    bus_interrupts_enable();
    chip_run(start + 2u * CARRIER);
    TEST_ASSERT_EQUAL_UINT64(start + CARRIER + WORK, bench_sample_at[0]);
}

static void test_sections_one_after_the_other_add_up(void)
{
    section = WORK;
    chip_run(start + CARRIER);
    for (uint32_t n = 0u; n < 3u; n++) {
        bus_interrupts_disable();
        bus_interrupts_enable();
    }
    chip_run(start + 2u * CARRIER);
    TEST_ASSERT_EQUAL_UINT64(start + CARRIER + 3u * WORK, bench_sample_at[0]);
}

static void test_a_section_that_ends_before_the_request_delays_nothing(void)
{
    section = ENTRY;
    chip_run(start + CARRIER);
    bus_interrupts_disable();
    bus_interrupts_enable();
    chip_run(start + 2u * CARRIER);
    TEST_ASSERT_EQUAL_UINT64(entry(1u), bench_sample_at[0]);
}

static void test_enabling_what_is_enabled_is_no_section(void)
{
    section = WORK;
    chip_run(start + CARRIER);
    bus_interrupts_enable();
    chip_run(start + 2u * CARRIER);
    TEST_ASSERT_EQUAL_UINT64(entry(1u), bench_sample_at[0]);
}

static void test_the_background_goes_on_where_the_interrupt_returns(void)
{
    work = WORK;
    TEST_ASSERT_FALSE(chip_run_to_background(start + CARRIER));
    TEST_ASSERT_EQUAL_UINT64(start + CARRIER, chip_now(&bench_chip));
    TEST_ASSERT_TRUE(chip_run_to_background(start + 2u * CARRIER));
    TEST_ASSERT_EQUAL_UINT64(entry(1u) + WORK, chip_now(&bench_chip));
    TEST_ASSERT_FALSE(chip_run_to_background(start + 2u * CARRIER));
}

static void test_the_background_does_not_go_on_while_another_interrupt_waits(void)
{
    work = WORK;
    chip_run(entry(1u));
    bus_write16(&PIE->group[1].IFR, 1u);
    TEST_ASSERT_TRUE(chip_run_to_background(start + 2u * CARRIER));
    TEST_ASSERT_EQUAL_UINT32(2u, vector_count);
    TEST_ASSERT_EQUAL_UINT64(entry(1u) + WORK + LATENCY, chip_now(&bench_chip));
}

static void test_a_halted_background_does_not_go_on(void)
{
    bus_debug_groups(1u);
    chip_debug_realtime(&bench_chip, true);
    for (uint32_t n = 1u; n <= 3u; n++) {
        bus_write16(&EPWM(n)->TBCTL, (uint16_t)(EPWM(n)->TBCTL | TBCTL_FREE_SOFT(2u)));
    }
    chip_run(start + CARRIER);
    chip_debug_halt(&bench_chip);
    TEST_ASSERT_FALSE(chip_run_to_background(start + 2u * CARRIER));
    TEST_ASSERT_EQUAL_UINT32(1u, bench_samples);
}
