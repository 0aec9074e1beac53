/* The scenario's inside: what reading a file and judging a scenario share. */
#ifndef HOST_SIM_LAB_SCENARIO_PARTS_H
#define HOST_SIM_LAB_SCENARIO_PARTS_H

#include "host_sim/lab/names.h"
#include "host_sim/lab/scenario.h"
#include "host_sim/lab/toml_reader.h"
#include "host_sim/lab/units.h"

typedef struct scenario_block {
    struct scenario_block *next;
} scenario_block_t;

struct scenario_memory {
    toml_file_t *file; /* the texts that the scenario points to */
    scenario_block_t *blocks;
};

/* The tables whose rows a scenario may set, in the order of rig_table. */
#define SCENARIO_SETTABLE 4u
extern const char *const scenario_settable[SCENARIO_SETTABLE];
const table_t *scenario_table(const char *name); /* NULL: no such table */

/* Zeroed memory that goes with the scenario; NULL: there is none. */
void *scenario_take(scenario_t *scenario, size_t octets);

/* Fills all but the file; returns false. Control characters become spaces. */
bool scenario_fail(scenario_error_t *error, scenario_place_t place, const char *name, const char *format, ...)
    __attribute__((format(printf, 4, 5)));

bool scenario_no_memory(scenario_error_t *error);

/* Rows that were meant and rows of other tables with this name: "; nearest: i_q". "" if nothing helps. */
typedef struct {
    char text[320];
} scenario_hint_t;
scenario_hint_t scenario_near_row(const char *name, const table_t *table);

/* The accepted range or choices of a row. */
typedef struct {
    char text[256];
} scenario_accepted_t;
scenario_accepted_t scenario_accepted(const table_row_t *row);

/* What a text means for a row; false: not this row's kind of value (name and place are given for the
 * message). */
bool scenario_row_text_value(const table_row_t *row, const char *text, double *value, scenario_place_t place,
                             scenario_error_t *error);

/* May the row have this value, as far as the row alone can say? */
bool scenario_row_accepts(const table_row_t *row, double value, scenario_place_t place,
                          scenario_error_t *error);

/* A number [unit] in its range. */
bool scenario_in_range(double value, double min, double max, const char *unit, scenario_place_t place,
                       const char *name, scenario_error_t *error);

#endif
