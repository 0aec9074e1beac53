/* Scenarios by what a user calls them. */
#ifndef HOST_SIM_CLI_LIBRARY_H
#define HOST_SIM_CLI_LIBRARY_H

#include "host_sim/lab/scenario.h"

/* A file, or the name of a scenario that comes with the program. NULL: said why on stderr. */
scenario_t *library_read(const char *name);

#endif
