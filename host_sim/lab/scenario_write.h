/* A scenario as it was resolved, written as a scenario again: without its motor's file, its profiles and what
 * the command line replaced, whose values stand in it as numbers. Read again it runs the same bits. Not
 * written: expectations, measures, what is recorded. */
#ifndef HOST_SIM_LAB_SCENARIO_WRITE_H
#define HOST_SIM_LAB_SCENARIO_WRITE_H

#include <stdio.h>

#include "host_sim/lab/scenario.h"

void scenario_write(FILE *file, const scenario_t *scenario, uint64_t seed);

#endif
