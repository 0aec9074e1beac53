/* A DC link between 200 V and 400 V for the tests of its limits and supply, and its usual parameters. */
#ifndef TESTS_UNIT_LINK_BENCH_H
#define TESTS_UNIT_LINK_BENCH_H

#include <string.h>

#include "fast/protect/link_limit.h"
#include "medium/protect/link_watch.h"

#define LOOK   1.6e-3 /* [s] between two runs of the medium task */
#define PERIOD 1e-4   /* [s] */
#define OVER   400.0
#define UNDER  200.0
#define MOST   10.0   /* [A] current limit */
#define TORQUE 1.098  /* [N m/A] */
#define OMEGA  157.08 /* [rad/s] 1500 r/min */

static link_limit_t limit;
static link_limit_tuning_t limit_tuning;
static link_watch_t watch;
static link_watch_tuning_t watch_tuning;

static void prepare(double ride_time, double current_max)
{
    const link_limit_params_t params = {
        .overvoltage = (float)OVER,
        .undervoltage = (float)UNDER,
        .rides = ride_time > 0.0,
        .current_max = (float)current_max,
        .resistance = 0.97f,
        .torque = (float)TORQUE,
    };
    limit_tuning = link_limit_prepare(&params);
    const link_watch_params_t watched = {
        .undervoltage = (float)UNDER,
        .hold = (float)(1.15 * UNDER),
        .band = (float)(0.12 * UNDER),
        .driving_from = ride_time > 0.0 ? (float)(1.27 * UNDER) : 0.0f,
        .ride_time = (float)ride_time,
        .period = (float)LOOK,
    };
    watch_tuning = link_watch_prepare(&watched);
}

static void begin(double ride_time)
{
    prepare(ride_time, MOST);
    memset(&limit, 0x55, sizeof limit);
    link_limit_init(&limit, &limit_tuning);
    memset(&watch, 0, sizeof watch);
}

static bool is_near(double u_dc)
{
    return link_limit_is_near(&limit, &limit_tuning, (float)u_dc);
}

static void limit_at(double u_dc, double omega_m)
{
    link_limit_step(&limit, &limit_tuning, (float)u_dc, (float)omega_m);
}

/* Runs the supply detection once, and the limits that follow from it. */
static void look(double u_dc)
{
    const link_watch_input_t input = {.u_dc = (float)u_dc, .slow = limit.slow, .limits = limit.limits};
    link_watch_step(&watch, &watch_tuning, &input);
    limit.sunk = watch.sunk;
    limit.low = watch.low;
}

static bool excuses(void)
{
    return link_watch_excuses(&watch, &watch_tuning);
}

#endif
