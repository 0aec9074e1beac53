/* The simulation as a functional mock-up unit of FMI 2.0 for co-simulation: its variables and its model
 * description. The library that computes them is host_sim/fmu/fmu.c; the archive is written by `lagless fmu`.
 *
 * A variable is a row of a table: its name is that of recordings, its value reference the row's permanent id.
 * Inputs are requests and the rows of plant and rig; parameters of the drive are tunable parameters; signals
 * and truth are outputs. Floats and unsigned numbers are Real, because FMI's Integer has 32 bits with a sign;
 * signed numbers are Integer, choices an Enumeration. Reference 0 is time. */
#ifndef HOST_SIM_LAB_FMU_MODEL_H
#define HOST_SIM_LAB_FMU_MODEL_H

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

#include "contract/table.h"
#include "host_sim/lab/scenario.h"

#define FMU_IDENTIFIER "lagless" /* name of the library in the archive */
#define FMU_TIME       0u        /* value reference */
#define FMU_ID_END     6000u     /* [-] every id is below this */

/* Row of a value reference; NULL: no variable has this reference. */
const table_row_t *fmu_row(uint32_t reference);

/* The n-th variable in the order of the description, without time; NULL: n is too large. */
const table_row_t *fmu_variable(uint32_t n);

bool fmu_is_output(const table_row_t *row);
bool fmu_is_real(const table_row_t *row);

/* Identifies version and tables; it must be the same in description and library. Returns `to`. */
#define FMU_GUID_SIZE 64u
const char *fmu_guid(char to[FMU_GUID_SIZE]);

/* Writes modelDescription.xml of this scenario. Returns the number of variables, including time. */
uint32_t fmu_describe(FILE *file, const scenario_t *scenario, const char *commit);

#endif
