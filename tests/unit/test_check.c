/* A failed check on the host prints a line with the place, and aborts. */
#include <setjmp.h>
#include <signal.h>

#include "math/check.h"
#include "tests/unit/compare.h"

#define TOLD "test_check.txt"

static jmp_buf back;
static char told[200];

static void aborted(int signal_number)
{
    (void)signal_number;
    longjmp(back, 1);
}

static void fails_in_line_1000(int positive)
{
#line 1000
    CHECK(positive > 0);
}

/* Returns true if the check has aborted; the global text contains its message. */
static bool aborts(int positive)
{
    volatile bool ended = true;
    TEST_ASSERT_NOT_NULL(freopen(TOLD, "w", stderr));
    (void)signal(SIGABRT, aborted);
    if (setjmp(back) == 0) {
        fails_in_line_1000(positive);
        ended = false;
    }
    (void)signal(SIGABRT, SIG_DFL);
    (void)fflush(stderr);
    FILE *file = fopen(TOLD, "r");
    TEST_ASSERT_NOT_NULL(file);
    told[fread(told, 1, sizeof told - 1u, file)] = '\0';
    (void)fclose(file);
    (void)remove(TOLD);
    return ended;
}

static void test_a_failed_check_prints_its_place_and_aborts(void)
{
    TEST_ASSERT_TRUE(aborts(0));
    TEST_ASSERT_EQUAL_STRING("fails_in_line_1000, line 1000: check failed\n", told);
}

static void test_a_check_that_holds_prints_nothing(void)
{
    TEST_ASSERT_FALSE(aborts(1));
    TEST_ASSERT_EQUAL_STRING("", told);
}
