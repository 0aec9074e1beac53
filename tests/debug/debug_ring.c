/* The program for the tests of the debugger: the simulation with fixed settings, stepped by one period at a
 * time as in the run of a scenario. It obeys LAGLESS_STOP.
 *
 * usage: debug_ring PERIODS [FAULT_PERIOD] [exact]
 *
 * The drive is commanded to turn at 600 r/min from the start, with a load of 2 N m from period 4000 on.
 * The power module reports a fault from FAULT_PERIOD on. With `exact` the sensors are ideal, which use
 * another interrupt function. */
#include <errno.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host_sim/rig/rig.h"
#include "settings/reasons.h"

#define SEED        UINT64_C(20240607)
#define SPEED       62.831853 /* [rad/s] 600 r/min */
#define LOAD_PERIOD 4000u
#define LOAD        2.0 /* [N m] */

static bool read_period(const char *text, uint32_t *period)
{
    char *end;
    errno = 0;
    const unsigned long value = strtoul(text, &end, 10);
    *period = (uint32_t)value;
    return errno == 0 && end != text && *end == '\0' && text[0] != '-' && value < UINT32_MAX;
}

static void put(rig_t *rig, const char *name, double value)
{
    if (!rig_put(rig, name, value)) {
        fprintf(stderr, "debug_ring: %s\n", rig_error(rig));
        exit(3);
    }
}

int main(int argc, char **argv)
{
    uint32_t periods = 0;
    uint32_t fault = UINT32_MAX;
    uint32_t stop = 0;
    const char *const stop_text = getenv("LAGLESS_STOP");
    const bool exact = argc > 2 && strcmp(argv[argc - 1], "exact") == 0;
    argc -= exact;
    if (argc < 2 || argc > 3 || !read_period(argv[1], &periods) ||
        (argc == 3 && !read_period(argv[2], &fault)) ||
        (stop_text != NULL && !read_period(stop_text, &stop))) {
        fputs("usage: [LAGLESS_STOP=PERIOD] debug_ring PERIODS [FAULT_PERIOD] [exact]\n", stderr);
        return 2;
    }

    rig_t *rig = rig_create(SEED);
    if (rig == NULL) {
        return 3;
    }
    put(rig, "sensors", exact ? 1.0 : 0.0);
    put(rig, "speed_request", SPEED);
    put(rig, "enable", 1.0);
    if (stop_text != NULL) {
        rig_stop_before(rig, stop);
    }
    for (uint32_t period = 0; period < periods; period++) {
        if (period == LOAD_PERIOD) {
            put(rig, "load_torque", LOAD);
        }
        if (period == fault) {
            put(rig, "force_fault", 1.0);
        }
        rig_step(rig);
    }
    const reason_row_t *reason = reason_by_number((int32_t)rig_value(rig, "fault_reason"));
    printf("%" PRIu32 " periods, state %016" PRIx64 ", fault %s\n", rig_period(rig), rig_hash(rig),
           reason != NULL ? reason->name : "unknown");
    rig_free(rig);
    return 0;
}
