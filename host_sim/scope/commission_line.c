#include "host_sim/scope/commission_line.h"

#include <stdio.h>
#include <time.h>

#define PAUSE       0.01 /* [s] between two questions for the time */
#define STAND_STILL 2.0  /* [s] without a step of the drive's time */

static double now(void)
{
    struct timespec time;
    clock_gettime(CLOCK_MONOTONIC, &time);
    return (double)time.tv_sec + 1e-9 * (double)time.tv_nsec;
}

static bool get(void *context, const table_row_t *row, double *value)
{
    commission_line_t *line = context;
    return master_get(line->master, row, value, &line->error);
}

static bool put(void *context, const table_row_t *row, double value)
{
    commission_line_t *line = context;
    return master_set(line->master, row, value, &line->error);
}

static bool apply(void *context)
{
    commission_line_t *line = context;
    master_refusal_t refusal = {0};
    return master_order(line->master, "apply", &refusal, &line->error);
}

/* Continues the drive's own count of periods, which wraps. */
static bool look_at_time(commission_line_t *line)
{
    double value = 0.0;
    if (!get(line, rig_row_by_name("period"), &value)) {
        return false;
    }
    const uint32_t period = (uint32_t)value;
    line->passed += line->begun ? (double)(period - line->period) : 0.0;
    line->period = period;
    line->begun = true;
    return true;
}

static bool pump(commission_line_t *line, double seconds)
{
    return line->pump != NULL ? line->pump(line->context, seconds) : master_wait(line->master, seconds);
}

static bool wait(void *context, double seconds)
{
    commission_line_t *line = context;
    const double begin = line->passed;
    double moved_at = now();
    bool good = line->begun || look_at_time(line);
    for (double left = seconds; good && left > 0.0;
         left = seconds - (line->passed - begin) * RIG_PERIOD_SECONDS) {
        const double before = line->passed;
        good = pump(line, left < PAUSE ? left : PAUSE) && look_at_time(line);
        moved_at = line->passed > before ? now() : moved_at;
        if (good && now() - moved_at > STAND_STILL) {
            snprintf(line->error.text, sizeof line->error.text,
                     "the drive's time has stopped; a debugger may have halted it");
            good = false;
        }
    }
    return good;
}

static double seconds(void *context)
{
    const commission_line_t *line = context;
    return line->passed * RIG_PERIOD_SECONDS;
}

static const char *why(void *context)
{
    const commission_line_t *line = context;
    return line->error.text;
}

commission_drive_t commission_line_drive(commission_line_t *line)
{
    line->begun = false;
    line->passed = 0.0;
    line->error.text[0] = '\0';
    return (commission_drive_t){.get = get,
                                .put = put,
                                .apply = apply,
                                .wait = wait,
                                .seconds = seconds,
                                .why = why,
                                .context = line};
}
