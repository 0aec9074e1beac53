/* The simulation, or one of its two parts (host_sim/rig/rig_part.h), as a functional mock-up unit of FMI 2.0
 * for co-simulation: its variables and its model description. The library that computes them is
 * host_sim/fmu/fmu.c; the archive is written by `lagless fmu`.
 *
 * A variable is a row of a table: its name is that of recordings, its value reference the row's permanent id.
 * Inputs are requests and the rows of plant and rig; parameters of the drive are tunable parameters; signals
 * and truth are outputs. A part has only the rows of its own, and those of the exchange with the other part:
 * inputs of the one are outputs of the other. Floats and unsigned numbers are Real, because FMI's Integer has
 * 32 bits with a sign; signed numbers are Integer, choices an Enumeration. Reference 0 is time. */
#ifndef HOST_SIM_LAB_FMU_MODEL_H
#define HOST_SIM_LAB_FMU_MODEL_H

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

#include "contract/table.h"
#include "host_sim/lab/scenario.h"
#include "host_sim/rig/rig_part.h"

#define FMU_IDENTIFIER "lagless" /* name of the library in the archive */
#define FMU_TIME       0u        /* value reference */
#define FMU_ID_END     6100u     /* [-] every id is below this */

/* Names of the parts: "ring", "drive", "plant". fmu_part_of: false: no part has this name. */
#define FMU_PARTS 3u
const char *fmu_part_name(rig_part_t part);
bool fmu_part_of(const char *name, rig_part_t *part);

/* Row of a value reference; NULL: no variable of the part has this reference. */
const table_row_t *fmu_row(rig_part_t part, uint32_t reference);

/* The variables of a part in the order of the description, without time. Returns their number. */
#define FMU_VARIABLES_MAX 512u
uint32_t fmu_variables(rig_part_t part, const table_row_t *rows[FMU_VARIABLES_MAX]);

bool fmu_is_exchange(const table_row_t *row); /* a row of rig_exchange_table() */
bool fmu_is_output(rig_part_t part, const table_row_t *row);
bool fmu_is_real(const table_row_t *row);

/* Value of a row that can be set, at t = 0 of the scenario. */
double fmu_initial(const scenario_t *scenario, const table_row_t *row);

/* Identifies version, tables and part; it must be the same in description and library. Returns `to`. */
#define FMU_GUID_SIZE 64u
const char *fmu_guid(rig_part_t part, char to[FMU_GUID_SIZE]);

/* Writes modelDescription.xml of this scenario. Returns the number of variables, including time. */
uint32_t fmu_describe(FILE *file, rig_part_t part, const scenario_t *scenario, const char *commit);

#endif
