/* A DC link between 200 V and 400 V for the tests of medium/protect/link.h, and its usual parameters. */
#ifndef TESTS_UNIT_LINK_BENCH_H
#define TESTS_UNIT_LINK_BENCH_H

#include <string.h>

#include "medium/protect/link.h"

#define LOOK   1.6e-3 /* [s] */
#define PERIOD 1e-4   /* [s] */
#define OVER   400.0
#define UNDER  200.0
#define MOST   10.0   /* [A] */
#define TORQUE 1.098  /* [N m/A] */
#define OMEGA  157.08 /* [rad/s] 1500 r/min */

static link_t x;
static link_tuning_t tuning;

static link_params_t usual(double ride_time)
{
    return (link_params_t){
        .overvoltage = (float)OVER,
        .undervoltage = (float)UNDER,
        .ride_time = (float)ride_time,
        .current_max = (float)MOST,
        .resistance = 0.97f,
        .torque = (float)TORQUE,
        .period = (float)LOOK,
    };
}

static void begin(double ride_time)
{
    const link_params_t params = usual(ride_time);
    tuning = link_prepare(&params);
    memset(&x, 0x55, sizeof x);
    link_init(&x, &tuning);
}

#endif
