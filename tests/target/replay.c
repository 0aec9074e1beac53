/* Runs a recording through the drive on this target, interrupt by interrupt, and compares every signal and
 * the command with those of the host, bit for bit. Where floats are computed in software, only the
 * beginning of each part runs, and of the parts only the share of the day. The exit code is 0 if no bit
 * differs. */
#include <stdio.h>
#include <string.h>

#include "tools/target/recording_in.h"
#include "tools/target/target_in.h"

#ifndef REPLAY_MOST
#define REPLAY_MOST UINT32_MAX /* [periods] of a part, from its power-on */
#endif

static drive_t drive;
/* Number of compared values, of values that differ, and of bits that differ. */
static uint32_t values, unequal, differing;

static void compare(const char *name, uint32_t here)
{
    const uint32_t there = take();
    values++;
    if (here == there) {
        return;
    }
    if (unequal++ < 10u) {
        printf("period %lu, %s: %08lX, on the host %08lX\n", (unsigned long)drive.fast.period, name,
               (unsigned long)here, (unsigned long)there);
    }
    for (uint32_t bits = here ^ there; bits != 0u; bits &= bits - 1u) {
        differing++;
    }
}

static void leave_out(uint32_t words)
{
    for (uint32_t n = 0; n < words; n++) {
        (void)take();
    }
}

/* Skips periods of the recording that this target does not run. */
static void pass_over(uint32_t periods)
{
    for (uint32_t n = 0; n < periods; n++) {
        if (take() != 0u) {
            leave_out(params_table.count + ASSUMED_SLOTS);
        }
        leave_out(requests_table.count + RECORDING_SAMPLES + signals_table.count + RECORDING_COMMAND);
    }
}

/* Runs a part: a power-on and its periods. */
static void replay(uint32_t periods)
{
    params_t params;
    take_table(&params_table, &params);
    drive_init(&drive, &params);
    for (uint32_t n = 0; n < periods; n++) {
        drive_samples_t samples;
        drive_command_t command;
        uint32_t words[RECORDING_COMMAND];
        if (take() != 0u) { /* as app_apply does it */
            take_table(&params_table, &params);
            assumed_t assumed;
            take_words(&assumed, ASSUMED_SLOTS);
            drive_prepare(drive_idle_tuning(&drive), &params, &assumed);
            drive_offer(&drive);
        }
        take_table(&requests_table, &drive.requests);
        take_words(&samples, RECORDING_SAMPLES);
        const bool due = drive_step(&drive, &samples, &command);
        for (uint32_t row = 0; row < signals_table.count; row++) {
            compare(signals_table.rows[row].name, table_bits(&signals_table.rows[row], &drive));
        }
        memcpy(words, &command, sizeof words);
        for (uint32_t word = 0; word < RECORDING_COMMAND; word++) {
            compare("command", words[word]);
        }
        if (due) {
            drive_medium_step(&drive);
        }
    }
}

int main(void)
{
    if (!target_opens("replay")) {
        return 2;
    }
    uint32_t seed = 0u, share = 1u, left_out = 0u;
#ifndef REPLAY_FILE /* the words of the simulator before the recording */
    seed = take();
    share = take();
    share = share == 0u ? 1u : share;
#endif
    if (!take_head()) {
        printf("replay: this is no recording with the " RECORDING_ESTIMATOR ", or one of other tables\n");
        return 2;
    }
    uint32_t periods[RECORDING_PARTS];
    uint32_t all = 0u;
    const uint32_t parts = take_parts(periods);
    if (parts > RECORDING_PARTS) {
        printf("replay: %lu parts, more than there is room for\n", (unsigned long)parts);
        return 2;
    }
    for (uint32_t part = 0; part < parts; part++) {
        uint32_t count = periods[part] < REPLAY_MOST ? periods[part] : REPLAY_MOST;
        if ((part + seed) % share != 0u) {
            count = 0u;
            left_out++;
        }
        if (count != 0u) {
            replay(count);
        } else {
            leave_out(params_table.count); /* skips the parameters of the power-on */
        }
        pass_over(periods[part] - count);
        all += count;
    }
    if (left_out != 0u) {
        printf("%lu of %lu parts left to other days\n", (unsigned long)left_out, (unsigned long)parts);
    }
    printf("%lu interrupts, " RECORDING_ESTIMATOR ", %lu values compared, %lu bits differ\n",
           (unsigned long)all, (unsigned long)values, (unsigned long)differing);
    return differing == 0u && all != 0u ? 0 : 1;
}
