/* Data and functions that the reading and the checking of a scenario share. */
#ifndef HOST_SIM_LAB_SCENARIO_PARTS_H
#define HOST_SIM_LAB_SCENARIO_PARTS_H

#include "host_sim/lab/names.h"
#include "host_sim/lab/scenario.h"
#include "host_sim/lab/toml_reader.h"
#include "host_sim/lab/units.h"

typedef struct scenario_block {
    struct scenario_block *next;
} scenario_block_t;

/* A wrong value of the file, which an override may replace. */
typedef struct scenario_refusal {
    struct scenario_refusal *next; /* in the order of the file */
    const table_row_t *row;        /* NULL: `key` */
    const char *key;               /* "run.duration" */
    scenario_error_t error;
} scenario_refusal_t;

struct scenario_memory {
    scenario_refusal_t *refused;
    toml_file_t *file; /* the texts that the scenario points to */
    scenario_block_t *blocks;
};

/* The tables whose rows a scenario may set, in the order of rig_table. */
#define SCENARIO_SETTABLE 4u
extern const char *const scenario_settable[SCENARIO_SETTABLE];
const table_t *scenario_table(const char *name); /* NULL: no such table */

/* Memory, set to zero, that is freed with the scenario. NULL: there is not enough memory. */
void *scenario_take(scenario_t *scenario, size_t octets);

/* Fills the members of `error` except the file and returns false. Control characters become spaces. */
bool scenario_fail(scenario_error_t *error, scenario_place_t place, const char *name, const char *format, ...)
    __attribute__((format(printf, 4, 5)));

bool scenario_no_memory(scenario_error_t *error);

/* Rows with a similar name, or rows of other tables with this name: "; nearest: i_q". "": there are none. */
typedef struct {
    char text[320];
} scenario_hint_t;
scenario_hint_t scenario_near_row(const char *name, const table_t *table);

/* The accepted range or choices of a row. */
typedef struct {
    char text[256];
} scenario_accepted_t;
scenario_accepted_t scenario_accepted(const table_row_t *row);

/* A row that a scenario may set, by "row" or "table.row". NULL: there is none; `error` has a message (without
 * place and file). */
const table_row_t *scenario_settable_row(const char *name, scenario_error_t *error);

/* Converts a text to the value of a row. false: the text is not a value of this row; name and place are for
 * the message. */
bool scenario_row_text_value(const table_row_t *row, const char *text, double *value, scenario_place_t place,
                             scenario_error_t *error);

/* "nan", "inf" or "-inf" of a number that is not finite. */
static inline const char *scenario_not_finite(double value)
{
    return value != value ? "nan" : value < 0.0 ? "-inf" : "inf";
}

/* true: the row accepts this value; rules between rows are not judged. */
bool scenario_row_accepts(const table_row_t *row, double value, scenario_place_t place,
                          scenario_error_t *error);

/* ---- reading ---- */

/* Additional rows at t = 0. They replace those of the file; with `under` those of the file replace them. */
typedef struct {
    bool under;
    uint32_t entry; /* a table of the file with sections and [[at]]; 0: `settings` */
    const scenario_setting_t *settings;
    uint32_t count;
} scenario_layer_t;

/* A scenario that is a part of a larger file: the other keys of the file, and rows that replace those of the
 * scenario. */
typedef struct {
    const char *keys, *accepted; /* all accepted keys; NULL: those of a scenario */
    const scenario_layer_t *layers;
    uint32_t layer_count;
    bool unchecked; /* only read; the caller must call scenario_check */
} scenario_more_t;

scenario_t *scenario_read_more(const char *path, const char *text, size_t octets, const scenario_more_t *more,
                               scenario_error_t *error);

typedef struct {
    const toml_file_t *file;
    scenario_t *scenario;
    scenario_error_t *error;
    bool to_mend; /* wrong values that an override can replace are refused later */
    const scenario_more_t *more;
} reading_t;

/* Entries of the file. NULL: there is none. */
scenario_place_t reading_place(const toml_entry_t *entry);
const toml_entry_t *reading_first(const reading_t *reading, const toml_entry_t *parent);
const toml_entry_t *reading_next(const reading_t *reading, const toml_entry_t *parent,
                                 const toml_entry_t *entry);
uint32_t reading_count(const reading_t *reading, const toml_entry_t *parent);
const toml_entry_t *reading_find(const reading_t *reading, const toml_entry_t *table, const char *key);
const char *reading_key(const toml_entry_t *entry);

/* Each function returns false if the entry is wrong; `error` has the cause and the accepted values. */
bool reading_is_type(const reading_t *reading, const toml_entry_t *entry, toml_type_t type);
bool reading_is_text(const reading_t *reading, const toml_entry_t *entry, bool lines);
bool reading_is_whole(const reading_t *reading, const toml_entry_t *entry, int64_t min, int64_t max);
bool reading_quantity(const reading_t *reading, const toml_entry_t *entry, const char *unit, double *value);
bool reading_in_range(const reading_t *reading, const toml_entry_t *entry, const char *unit, double min,
                      double max, double *value);
bool reading_row_value(const reading_t *reading, const toml_entry_t *entry, const table_row_t *row,
                       double *value);
bool reading_only_keys(const reading_t *reading, const toml_entry_t *table, const char *keys,
                       const char *accepted);
bool reading_missing(const reading_t *reading, const toml_entry_t *table, const char *key,
                     const char *example);
bool reading_sections(const reading_t *reading, const toml_entry_t *table, scenario_event_t *event,
                      uint32_t room);
bool reading_time(const reading_t *reading, const toml_entry_t *entry, double *seconds);
const toml_entry_t *reading_tables(const reading_t *reading, const toml_entry_t *top, const char *key,
                                   uint32_t *count, bool *good);
bool reading_signal(const reading_t *reading, const toml_entry_t *entry, const table_row_t **row);
bool reading_statistic(const reading_t *reading, const toml_entry_t *entry, statistic_t *statistic);

/* A number [unit] in its range. */
bool scenario_in_range(double value, double min, double max, const char *unit, scenario_place_t place,
                       const char *name, scenario_error_t *error);

#endif
