/* Runs the drive on a recording, period by period, and compares the command and all signals of the fast task
 * with the recorded ones, bit for bit. Signals of the medium task are left out, because it may be running
 * while they are read.
 *
 * Requests and offers come from the background, which does not run while the medium task runs: those of the
 * periods in between are applied after it. */
#ifndef TESTS_TARGET_RECORDED_DRIVE_H
#define TESTS_TARGET_RECORDED_DRIVE_H

#include <string.h>
#include <unity.h>

#include "tools/target/recording_in.h"

static FILE *input;
static drive_t drive;
static uint32_t values;
static char where[100];

static uint32_t take(void)
{
    return recording_word(input);
}

/* ---- a period ---- */

/* The changes by the background and the samples of the sensors for the period that was read last. */
static requests_t requests;
static bool offers; /* one of the periods since bring() has an offer: */
static params_t offered;
static assumed_t assumed;
static drive_samples_t samples;
static uint32_t left; /* [periods] of the part */

static void take_period(void)
{
    left--;
    if (take() != 0u) {
        take_table(&params_table, &offered);
        take_words(&assumed, ASSUMED_SLOTS);
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

/* Runs the fast task. Returns true if the medium task has a window to process. */
static bool fast_period(void)
{
    drive_command_t command;
    uint32_t words[RECORDING_COMMAND];
    const bool due = drive_step(&drive, &samples, &command);
    for (uint32_t row = 0; row < signals_table.count; row++) {
        const table_row_t *of = &signals_table.rows[row];
        const bool medium = is_medium(of);
        compare(of->name, medium ? 0u : table_bits(of, &drive), !medium);
    }
    memcpy(words, &command, sizeof words);
    for (uint32_t word = 0; word < RECORDING_COMMAND; word++) {
        compare("command", words[word], true);
    }
    return due;
}

/* The changes by the background in the periods that were read. */
static void bring(void)
{
    drive.requests = requests;
    if (offers) {
        drive_prepare(drive_idle_tuning(&drive), &offered, &assumed);
        drive_offer(&drive);
        offers = false;
    }
}

/* Calls `play` for each part of the recording, with the number of its periods; each part begins with a new
 * drive. */
static void play_parts(void (*play)(void))
{
    uint32_t periods[RECORDING_PARTS];
    input = fopen(RECORDING_FILE, "rb");
    TEST_ASSERT_NOT_NULL_MESSAGE(input, RECORDING_FILE);
    TEST_ASSERT_TRUE(take_head());
    const uint32_t parts = take_parts(periods);
    TEST_ASSERT_TRUE(parts > 0u && parts <= RECORDING_PARTS);
    for (uint32_t n = 0; n < parts; n++) {
        params_t params;
        left = periods[n];
        take_table(&params_table, &params);
        drive_init(&drive, &params);
        play();
    }
    fclose(input);
}

#endif
