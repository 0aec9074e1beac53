/* Writes a scenario with all its values as numbers: those of the motor's file, of the profiles and of the
 * command line are included. Read again, it runs with the same bits. Expectations, measures and the recorded
 * rows are not written. */
#ifndef HOST_SIM_LAB_SCENARIO_WRITE_H
#define HOST_SIM_LAB_SCENARIO_WRITE_H

#include <stdio.h>

#include "host_sim/lab/scenario.h"

void scenario_write(FILE *file, const scenario_t *scenario, uint64_t seed);

#endif
