/* Interrupts the medium task at any place. The test runs a recording through the drive on the host. In
 * each window it stops the medium task at a randomly chosen block of its code, runs up to seven periods of
 * the fast task, and continues the medium task. Commands and all outputs of the fast task must equal the
 * recording bit for bit. The compiler inserts a call of __sanitizer_cov_trace_pc() into each block of the
 * firmware (-fsanitize-coverage=trace-pc). A window in which the medium task opens the bridge is not
 * interrupted, because that order takes effect when it is written. */
#include <stdlib.h>

#include "tools/target/recorded_drive.h"

#define LOWEST 1000u /* smallest accepted number of interruptions */

static uint32_t windows, cuts, spared;

/* ---- interruption of the medium task ---- */

static bool in_medium;
static uint32_t block;   /* [-] blocks since the begin of the medium task */
static uint32_t cut_at;  /* [-] number of the block at which it is interrupted */
static uint32_t between; /* [periods] of the fast task that run there */

void __sanitizer_cov_trace_pc(void);
void __sanitizer_cov_trace_pc(void)
{
    if (in_medium && block++ == cut_at) {
        in_medium = false;
        for (; between > 0u && left > 0u; between--) {
            take_period();
            TEST_ASSERT_FALSE(fast_period());
        }
        in_medium = true;
    }
}

/* [-] The number of blocks of the medium task in this window, counted with a copy of the drive; 0 if it
 * opens the bridge. */
static uint32_t blocks_of_window(void)
{
    drive_t *copy = malloc(sizeof *copy);
    TEST_ASSERT_NOT_NULL(copy);
    *copy = drive;
    block = 0u;
    cut_at = UINT32_MAX;
    in_medium = true;
    drive_medium_step(copy);
    in_medium = false;
    const uint32_t count = copy->opens != drive.opens ? 0u : block;
    free(copy);
    return count;
}

static void medium(void)
{
    const uint32_t blocks = blocks_of_window();
    windows++;
    if (blocks == 0u) {
        spared++;
        drive_medium_step(&drive);
        return;
    }
    block = 0u;
    cut_at = (uint32_t)rand() % blocks;
    between = 1u + (uint32_t)rand() % (DRIVE_WINDOW - 1u);
    in_medium = true;
    drive_medium_step(&drive);
    in_medium = false;
    TEST_ASSERT_EQUAL_UINT32(blocks, block);
    cuts++;
}

/* ---- the recording ---- */

static void part(void)
{
    while (left > 0u) {
        take_period();
        bring();
        if (fast_period()) {
            medium();
        }
    }
}

static void test_the_medium_task_may_be_interrupted_anywhere(void)
{
    play_parts(part);
    printf("%u windows, %u cut, %u in which the bridge opens, %u values compared\n", (unsigned)windows,
           (unsigned)cuts, (unsigned)spared, (unsigned)values);
    TEST_ASSERT_TRUE(cuts > LOWEST && spared < windows / 10u);
}

void setUp(void)
{
    srand(1);
}
