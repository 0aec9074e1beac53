/* A drive in real time at a port of this machine, for the tests of `lagless connect`. Its board has its
 * memory on the I2C bus (pump325.h).
 *
 * usage: keeping_drive good|breaks|vanishes
 * breaks: from the first order to the memory on, the content of the memory does not change any more.
 * vanishes: the program ends while the memory works. */
#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <time.h>

#include "contract/table.h"
#include "host_sim/lab/wire.h"
#include "host_sim/rig/rig_state.h"

#define LOOK_PERIODS rig_periods(1e-3)

static const volatile sig_atomic_t stop;

static void keep_pace(const struct timespec *begin, double seconds)
{
    const double nanoseconds = (double)begin->tv_nsec + seconds * 1e9;
    const struct timespec then = {begin->tv_sec + (time_t)(nanoseconds / 1e9),
                                  (long)(nanoseconds - 1e9 * (double)(time_t)(nanoseconds / 1e9))};
    (void)clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &then, NULL);
}

int main(int argc, char **argv)
{
    const chip_memory_t eeprom = {BOARD_STORE_ADDRESS, 64u, (uint32_t)(CHIP_TICKS_PER_SECOND / 200u)};
    const bool breaks = argc == 2 && strcmp(argv[1], "breaks") == 0;
    const bool vanishes = argc == 2 && strcmp(argv[1], "vanishes") == 0;
    uint32_t worked = 0; /* [ms] time for which the memory has worked */
    struct timespec begin;
    wire_error_t error;
    rig_t *rig = rig_create(1u);
    wire_t *wire = wire_listen(0u, false, &stop, &error);
    if (rig == NULL || wire == NULL || argc != 2 || !rig_put(rig, "fidelity", 1.0)) {
        return 2;
    }
    chip_attach_memory(&rig_state(rig)->chip, &eeprom);
    rig_start(rig);
    const rig_line_t line = {wire_read, wire_write, wire};
    rig_line(rig, &line);
    printf("listening on %s\n", wire_name(wire));
    (void)fflush(stdout);
    const double busy = table_choice(rig_row_by_name("store_state"), "busy");
    (void)clock_gettime(CLOCK_MONOTONIC, &begin);
    for (uint32_t period = 0;; period++) {
        if (period % LOOK_PERIODS == 0u) {
            wire_poll(wire);
            keep_pace(&begin, period * RIG_PERIOD_SECONDS);
            const bool works = rig_value(rig, "store_state") == busy;
            chip_break_memory(&rig_state(rig)->chip, breaks && works);
            worked += works ? 1u : 0u;
            if (vanishes && worked > 100u) {
                return 0;
            }
        }
        rig_step(rig);
    }
}
