/* Runs both tasks at the same time, in two threads, under ThreadSanitizer. The test runs a recording
 * through the drive on the host; while the medium task works on a window, the next seven periods of the
 * fast task run in parallel. As on the chip, the two meet only where a window ends: there the medium task
 * must have finished, and receives the next window. Any other word that one task writes and the other one
 * reads or writes is a race, which ends the program. Commands and all outputs of the fast task must equal
 * the recording bit for bit. A window in which the medium task opens the bridge runs alone, because that
 * order takes effect when it is written. */
#include <pthread.h>
#include <semaphore.h>
#include <stdlib.h>

#include "tools/target/recorded_drive.h"

#define LOWEST 1000u /* smallest accepted number of windows in which both tasks run */

static uint32_t windows, together;
static sem_t handed, done;
static bool works;   /* the medium task has a window */
static bool no_more; /* the medium task has received the last window */

/* The function that the compiler calls in each block of the firmware; only test_cut.c uses it. */
void __sanitizer_cov_trace_pc(void);
__attribute__((no_sanitize_thread)) void __sanitizer_cov_trace_pc(void)
{
}

static void *medium_thread(void *unused)
{
    for (;;) {
        while (sem_wait(&handed) != 0) {
        }
        if (no_more) {
            return unused;
        }
        drive_medium_step(&drive);
        TEST_ASSERT_EQUAL_INT(0, sem_post(&done));
    }
}

static void wait_for_medium(void)
{
    if (works) {
        while (sem_wait(&done) != 0) {
        }
        works = false;
    }
}

/* Returns true if the medium task opens the bridge in this window, according to a copy of the drive. */
static bool opens(void)
{
    drive_t *copy = malloc(sizeof *copy);
    TEST_ASSERT_NOT_NULL(copy);
    *copy = drive;
    drive_medium_step(copy);
    const bool does = copy->opens != drive.opens;
    free(copy);
    return does;
}

static void part(void)
{
    while (left > 0u) {
        take_period();
        if (drive.fast.sum.periods + 1u == DRIVE_WINDOW) {
            wait_for_medium();
        }
        if (!works) {
            bring();
        }
        if (!fast_period()) {
            continue;
        }
        windows++;
        if (opens()) {
            drive_medium_step(&drive);
        } else {
            together++;
            works = true;
            TEST_ASSERT_EQUAL_INT(0, sem_post(&handed));
        }
    }
    wait_for_medium();
}

static void test_both_tasks_at_once_meet_only_where_a_window_ends(void)
{
    pthread_t thread;
    TEST_ASSERT_EQUAL_INT(0, sem_init(&handed, 0, 0u));
    TEST_ASSERT_EQUAL_INT(0, sem_init(&done, 0, 0u));
    TEST_ASSERT_EQUAL_INT(0, pthread_create(&thread, NULL, medium_thread, NULL));
    play_parts(part);
    no_more = true;
    TEST_ASSERT_EQUAL_INT(0, sem_post(&handed));
    TEST_ASSERT_EQUAL_INT(0, pthread_join(thread, NULL));
    printf("%u windows, %u with both tasks at once, %u values compared\n", (unsigned)windows,
           (unsigned)together, (unsigned)values);
    TEST_ASSERT_TRUE(together > LOWEST);
}
