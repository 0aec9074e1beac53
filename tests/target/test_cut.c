/* The medium task interrupted anywhere: takes a recording through the drive on the desk, and in each window
 * stops the medium task at a block of its code that is drawn, lets up to seven periods of the fast task come
 * in between, and goes on. Commands and all that the fast task shows are those of the recording, bit for bit.
 *
 * The compiler calls __sanitizer_cov_trace_pc() at each block of the firmware (-fsanitize-coverage=trace-pc).
 * Requests and offers are the background's, which does not run while the medium task does: those of the
 * periods in between come after it. A window in which the medium task opens the bridge is not cut: that word
 * acts when it is written. */
#include <stdlib.h>
#include <string.h>
#include <unity.h>

#include "tests/target/recording_in.h"

#define LOWEST 400u /* cuts that there must have been, at least */

static FILE *input;
static drive_t drive;
static uint32_t values, windows, cuts, spared;
static char where[100];

static uint32_t take(void)
{
    return recording_word(input);
}

/* ---- a period ---- */

/* What the background and the sensors have brought to the period that was taken last. */
static requests_t requests;
static bool offers; /* one of the periods since bring() has an offer: */
static params_t offered;
static believed_t believed;
static drive_samples_t samples;
static uint32_t left; /* [periods] of the part */

static void take_period(void)
{
    left--;
    if (take() != 0u) {
        take_table(&params_table, &offered);
        take_words(&believed, RECORDING_BELIEVED);
        offers = true;
    }
    take_table(&requests_table, &requests);
    take_words(&samples, RECORDING_SAMPLES);
}

static bool is_medium(const table_row_t *row)
{
    return row->offset >= offsetof(drive_t, medium) &&
           row->offset < offsetof(drive_t, medium) + sizeof drive.medium;
}

static void compare(const char *name, uint32_t here, bool counts)
{
    const uint32_t there = take();
    if (counts) {
        values++;
        if (here != there) {
            snprintf(where, sizeof where, "window %u, %s", (unsigned)drive.fast.report.number, name);
            TEST_ASSERT_EQUAL_HEX32_MESSAGE(there, here, where);
        }
    }
}

/* The fast task. true: the medium task has a window to work on. */
static bool fast_period(void)
{
    drive_command_t command;
    uint32_t words[RECORDING_COMMAND];
    const bool due = drive_step(&drive, &samples, &command);
    for (uint32_t row = 0; row < signals_table.count; row++) {
        const table_row_t *of = &signals_table.rows[row];
        compare(of->name, table_bits(of, &drive), !is_medium(of));
    }
    memcpy(words, &command, sizeof words);
    for (uint32_t word = 0; word < RECORDING_COMMAND; word++) {
        compare("command", words[word], true);
    }
    return due;
}

/* What the background has brought in the periods taken. */
static void bring(void)
{
    drive.requests = requests;
    if (offers) {
        drive_prepare(drive_idle_tuning(&drive), &offered, &believed);
        drive_offer(&drive);
        offers = false;
    }
}

/* ---- the cut ---- */

static bool in_medium;
static uint32_t block;   /* [-] since its begin */
static uint32_t cut_at;  /* [-] the block at which it is cut */
static uint32_t between; /* [periods] of the fast task that come there */

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

/* [-] blocks of the medium task in this window, by what a copy of the drive does; 0: it opens the bridge. */
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

static void part(uint32_t periods)
{
    params_t params;
    left = periods;
    take_table(&params_table, &params);
    drive_init(&drive, &params);
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
    uint32_t periods[RECORDING_PARTS];
    input = fopen(RECORDING_FILE, "rb");
    TEST_ASSERT_NOT_NULL_MESSAGE(input, RECORDING_FILE);
    TEST_ASSERT_TRUE(take_head());
    const uint32_t parts = take_parts(periods);
    TEST_ASSERT_TRUE(parts > 0u && parts <= RECORDING_PARTS);
    for (uint32_t n = 0; n < parts; n++) {
        part(periods[n]);
    }
    fclose(input);
    printf("%u windows, %u cut, %u in which the bridge opens, %u values compared\n", (unsigned)windows,
           (unsigned)cuts, (unsigned)spared, (unsigned)values);
    TEST_ASSERT_TRUE(cuts > LOWEST && spared < windows / 10u);
}

void setUp(void)
{
    srand(1);
}

void tearDown(void)
{
}
