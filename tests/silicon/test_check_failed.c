/* The effect of a failed check on the chip: the real app/main.c runs above a board that records its calls.
 * The loop of main() has no end; the board leaves it after several turns. */
#include "unity.h"
#include <setjmp.h>
#include <string.h>

int chip_main(void);
#define main chip_main
#include "app/main.c"
#undef main

#define TURNS 5u

HAL_PER_CHIP app_t *app;

static jmp_buf leave;
static char asked[64];
static uint32_t fed;
static bool starts;

static void ask(const char *what)
{
    strncat(asked, what, sizeof asked - strlen(asked) - 1u);
}

void hal_interrupts_off(void)
{
    ask("interrupts off, ");
}

void hal_gates_off(void)
{
    ask("gates off, ");
}

void hal_watchdog_feed(void)
{
    if (fed++ == 0u) {
        ask("feed");
    }
    if (fed == TURNS) {
        longjmp(leave, 1);
    }
}

void hal_boot(void)
{
    ask("boot, ");
}

void app_start(void)
{
    CHECK(starts);
}

void app_background(void)
{
    ask("background");
    longjmp(leave, 1);
}

void setUp(void)
{
    memset(asked, 0, sizeof asked);
    fed = 0u;
    starts = false;
}

static void test_the_gates_go_off_for_good_before_anything_else_and_the_watchdog_does_not_wipe_the_place(void)
{
    if (setjmp(leave) == 0) {
        check_failed("pll_prepare", 67u);
    }
    TEST_ASSERT_EQUAL_STRING("interrupts off, gates off, feed", asked);
    TEST_ASSERT_EQUAL_UINT32(TURNS, fed);
}

static void test_function_and_line_are_there_for_a_debugger(void)
{
    if (setjmp(leave) == 0) {
        check_failed("pll_prepare", 67u);
    }
    TEST_ASSERT_EQUAL_STRING("pll_prepare", check_failure.function);
    TEST_ASSERT_EQUAL_UINT(67u, check_failure.line);
}

static void test_a_check_that_fails_in_the_start_never_reaches_the_background(void)
{
    if (setjmp(leave) == 0) {
        (void)chip_main();
    }
    TEST_ASSERT_EQUAL_STRING("boot, interrupts off, gates off, feed", asked);
    TEST_ASSERT_EQUAL_STRING("app_start", check_failure.function);
}

static void test_a_check_is_evaluated_once_and_prints_nothing_if_it_holds(void)
{
    uint32_t n = 0u;
    if (setjmp(leave) == 0) {
        CHECK(++n == 1u);
        CHECK(n == 1u);
    }
    TEST_ASSERT_EQUAL_UINT32(1u, n);
    TEST_ASSERT_EQUAL_STRING("", asked);
}
