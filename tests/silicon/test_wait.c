/* The unchanged bus_wait() of the chip, hal/f28335/wait.c, with a CPU timer that counts down by several
 * cycles between two reads, because running code takes time. */
#include "unity.h"

#include "hal/f28335/bus.h"

static cpu_timer_regs_t timer;
static uint32_t step;  /* [cycles] between two reads */
static uint32_t looks; /* [-] number of reads */

static const volatile cpu_timer_regs_t *look(uint32_t number)
{
    TEST_ASSERT_EQUAL_UINT32(0u, number); /* the timer that hal_init has started */
    timer.TIM -= looks > 0u ? step : 0u;
    looks++;
    return &timer;
}

#undef CPU_TIMER
#define CPU_TIMER(n) look(n)
#include "hal/f28335/wait.c"

/* The counts of the timer until bus_wait returns, if the timer begins at this count. */
static uint32_t waited(uint32_t cycles, uint32_t from, uint32_t cycles_a_look)
{
    timer.TIM = from;
    step = cycles_a_look;
    looks = 0;
    bus_wait(cycles);
    return from - timer.TIM;
}

static const uint32_t lengths[] = {1u, 2u, 9u, 10u, 11u, 1000u, 150000u};

static void test_it_waits_at_least_so_many_cycles_and_hardly_more(void)
{
    for (size_t n = 0; n < sizeof lengths / sizeof lengths[0]; n++) {
        for (uint32_t turn = 2u; turn <= 12u; turn++) {
            const uint32_t passed = waited(lengths[n], UINT32_MAX, turn);
            TEST_ASSERT_TRUE(passed >= lengths[n]);
            TEST_ASSERT_TRUE(passed < lengths[n] + turn);
        }
    }
}

/* The timer of hal_time() passes zero every 28 s. */
static void test_a_timer_that_goes_through_zero_during_this_time_makes_no_difference(void)
{
    for (uint32_t from = 0u; from < 40u; from++) {
        TEST_ASSERT_EQUAL_UINT32(102u, waited(100u, from, 6u));
    }
}

/* The timer is stopped before hal_init has started it, or later. A turn of the loop takes at least a
 * cycle. */
static void test_with_a_stopped_timer_it_ends_after_the_same_number_of_turns(void)
{
    for (size_t n = 0; n < sizeof lengths / sizeof lengths[0]; n++) {
        (void)waited(lengths[n], 1234u, 0u);
        TEST_ASSERT_EQUAL_UINT32(1u + lengths[n], looks);
    }
}

static void test_zero_cycles_are_no_wait(void)
{
    TEST_ASSERT_EQUAL_UINT32(0u, waited(0u, 77u, 5u));
}
