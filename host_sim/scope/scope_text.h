/* The messages of the scope to its pages, as JSON. */
#ifndef HOST_SIM_SCOPE_SCOPE_TEXT_H
#define HOST_SIM_SCOPE_SCOPE_TEXT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include "contract/table.h"

/* The rows that are accessible on the line, by ascending id, and the known values of their slots. */
#define SCOPE_ROWS_MAX 512u
typedef struct {
    const table_row_t *rows[SCOPE_ROWS_MAX];
    const char *tables[SCOPE_ROWS_MAX]; /* names of their tables */
    uint32_t bits[SCOPE_ROWS_MAX];
    bool known[SCOPE_ROWS_MAX];
    bool news[SCOPE_ROWS_MAX]; /* not sent yet */
    uint32_t count;
} scope_values_t;

void scope_values_init(scope_values_t *values);
uint32_t scope_values_place(const scope_values_t *values, uint32_t id); /* count: no such row */

/* A slot, as it is on the line, as a number. */
double scope_number(const table_row_t *row, uint32_t on_line);

/* [{"id": 1, "table": "params", "name": .., "kind": "float", "unit": "rad/s", "shown": "r/min",
 * "factor": 9.549, "choices": [..], "text": .., "access": "live", "min": .., "max": .., "initial": ..}, ..]:
 * `shown` is the displayed unit; a displayed number divided by `factor` is in `unit`. */
void scope_rows_text(FILE *to, const scope_values_t *values);

/* {"12": {"name": .., "text": .., "remedy": ..}, ..} of all reasons, and [12, ..] of the warnings' bits. */
void scope_reasons_text(FILE *to);
void scope_warnings_text(FILE *to);

/* {"2001": 3, ..}: all known values, or only the changes since the last call. Returns their number. */
uint32_t scope_values_text(FILE *to, scope_values_t *values, bool all);

/* Octets as base64. */
void scope_base64(FILE *to, const uint8_t *octets, size_t count);

/* Converts the user's text for this row: a number in its SI unit, "500 r/min", or the name of a choice.
 * false: *why has the message. */
bool scope_read(const table_row_t *row, const char *text, double *value, char *why, size_t size);

#endif
