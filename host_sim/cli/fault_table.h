/* Rows of the drive's fault table (settings/faults.h) as text and as JSON. */
#ifndef HOST_SIM_CLI_FAULT_TABLE_H
#define HOST_SIM_CLI_FAULT_TABLE_H

#include "settings/faults.h"

#define FAULT_TABLE_TEXT_SIZE 160u

/* The row of a reason; NULL: the reason is not a row of the fault table. */
const fault_row_t *fault_table_row(int32_t reason);

/* "u_dc > dc_overvoltage", "sink_temperature > sink_temperature_max - 10", "tripped". Returns `to`. */
const char *fault_table_condition(char to[FAULT_TABLE_TEXT_SIZE], const fault_row_t *row);

/* Default limit of the quantity, including the margin, with its unit: "15 A"; "" without a limit. Returns
 * `to`. */
const char *fault_table_limit(char to[FAULT_TABLE_TEXT_SIZE], const fault_row_t *row);

/* "3 periods, 0.3 ms". Returns `to`. */
const char *fault_table_debounce(char to[FAULT_TABLE_TEXT_SIZE], const fault_row_t *row);

/* "always", "while the gates are commanded on" */
const char *fault_table_when(const fault_row_t *row);

/* "the bridge opens, the fault is latched", "shown in warnings while it holds" */
const char *fault_table_reaction(const fault_row_t *row);

/* The row as one JSON object on stdout, in SI units; null for NULL. */
void fault_table_print_json(const fault_row_t *row);

#endif
