/* Flux maps in CSV files: a first line with the names i_d, i_q, psi_d and psi_q in any order, in A and Wb,
 * then a line for each point of a full grid, in any order. Lines that begin with # are skipped. */
#ifndef HOST_SIM_PLANT_FLUX_MAP_FILE_H
#define HOST_SIM_PLANT_FLUX_MAP_FILE_H

#include <stddef.h>
#include <stdint.h>

/* Number of the map in this file (plant/flux_map.h); 0: `why` has the cause, line and column, and the
 * accepted values. */
uint32_t flux_map_file_read(const char *path, char *why, size_t size);

#endif
