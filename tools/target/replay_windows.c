/* Runs the state machine of commissioning on a simulated target, with the recorded windows
 * (recording_windows.h), and compares the hash of its state after each window with that of the host.
 * tools/cost counts the instructions. The exit code is 0 if no hash differs. */
#include <stdio.h>

#include "tools/target/recording_windows.h"
#include "tools/target/target_in.h"

static commission_t commission;

/* One window. false: the state differs from that of the host. */
static bool window(void)
{
    static commission_tuning_t tuning;
    static excite_seen_t seen;
    commission_window_t given = {.standing = {.seen = &seen}};
    const int32_t requested = (int32_t)take();
    if (take() != 0u) {
        take_words(&tuning, WINDOWS_WORDS(commission_tuning_t));
    }
    take_words(&seen, WINDOWS_WORDS(excite_seen_t));
    take_words(&given.standing.current_abc, WINDOWS_WORDS(abc_t));
    take_words(&given.standing.current, WINDOWS_WORDS(ab_t));
    take_words(&given.standing.u_dc, 1u);
    given.standing.tripped = take();
    take_words(&given.turning, WINDOWS_WORDS(turning_input_t));
    given.bridge_on = take() != 0u;
    commission_window(&commission, &tuning, requested, &given);
    return take() == windows_hash(&commission);
}

int main(void)
{
    uint32_t windows = 0u;
    uint32_t differ = 0u;
    if (!target_opens("replay_windows")) {
        return 2;
    }
#ifndef REPLAY_FILE
    (void)take(); /* seed and share of a grid */
    (void)take();
#endif
    if (take() != WINDOWS_MAGIC || take() != WINDOWS_WORDS(commission_t)) {
        printf("replay_windows: this is no recording of the windows, or one of another state\n");
        return 2;
    }
    uint32_t record = take();
    for (; record == WINDOWS_INIT || record == WINDOWS_NEXT; record = take()) {
        if (record == WINDOWS_INIT) {
            commission_init(&commission);
            continue;
        }
        windows++;
        if (!window() && differ++ < 10u) {
            printf("window %lu, step %ld: the state differs\n", (unsigned long)windows,
                   (long)commission.step);
        }
    }
    printf("%lu windows of commissioning, %lu states differ\n", (unsigned long)windows,
           (unsigned long)differ);
    if (record != WINDOWS_END) {
        printf("replay_windows: the recording has no end\n");
        return 2;
    }
    return windows > 0u && differ == 0u ? 0 : 1;
}
