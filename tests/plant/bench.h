/* The plant of a test and the control loop that drives it. Both are created for each test. */
#ifndef TESTS_PLANT_BENCH_H
#define TESTS_PLANT_BENCH_H

#include <string.h>

#include "tests/plant/loop.h"

static plant_t plant;

/* Creates the plant with these parameters, and returns it. */
static inline plant_params_t begin(plant_params_t params)
{
    plant_init(&plant, &params, 1);
    return params;
}

static inline plant_truth_t truth(void)
{
    plant_truth_t now;
    plant_truth(&plant, &now);
    return now;
}

static inline plant_truth_t truth_at(uint64_t tick)
{
    plant_advance(&plant, tick);
    return truth();
}

static loop_t loop;

void setUp(void)
{
    memset(&loop, 0, sizeof loop);
    loop.dead = 375;
}

#endif
