/* The time of the interrupt on this machine. */
#include <time.h>

#include "host_sim/rig/rig_parts.h"

static __thread double timed_seconds; /* of the interrupts that this thread has timed */
static __thread double timed_since;   /* [s] clock at the begin of a measured part of an interrupt */

double rig_clock_seconds(void)
{
    struct timespec time;
    clock_gettime(CLOCK_MONOTONIC, &time);
    return (double)time.tv_sec + 1e-9 * (double)time.tv_nsec;
}

static void timed(void *context, uint32_t vector, void (*function)(void));

static bool timing(const rig_t *rig)
{
    return rig->world.interrupt == timed;
}

void rig_timing_pause(const rig_t *rig)
{
    if (timing(rig)) {
        timed_seconds += rig_clock_seconds() - timed_since;
    }
}

void rig_timing_go_on(const rig_t *rig)
{
    if (timing(rig)) {
        timed_since = rig_clock_seconds();
    }
}

static void timed(void *context, uint32_t vector, void (*function)(void))
{
    if (vector != PIE_SEQ1INT) {
        function();
        return;
    }
    rig_timing_go_on(context);
    function();
    rig_timing_pause(context);
}

/* The time that two readings of the clock take. The smallest of many measurements is used, because other work
 * of the machine makes some of them longer. */
static double empty_reading(void)
{
    double least = 1.0;
    for (uint32_t n = 0; n < 10000u; n++) {
        const double start = rig_clock_seconds();
        const double taken = rig_clock_seconds() - start;
        least = taken < least ? taken : least;
    }
    return least;
}

double rig_interrupt_seconds(rig_t *rig, uint32_t periods)
{
    const double empty = empty_reading();
    timed_seconds = 0.0;
    rig->world.interrupt = timed;
    rig_run(rig, periods);
    rig->world.interrupt = NULL;
    return timed_seconds / periods - 2.0 * empty; /* an interrupt consists of two measured parts */
}
