/* Functions that the sources for reading an experiment share. */
#ifndef HOST_SIM_LAB_EXPERIMENT_READ_H
#define HOST_SIM_LAB_EXPERIMENT_READ_H

#include "host_sim/lab/experiment_parts.h"

#define EXPERIMENT_KEYS                                                                                      \
    "schema|title|text|board|run|start|motor|params|requests|plant|rig|at|profile|expect|experiment|begin|"  \
    "sweep|"                                                                                                 \
    "let|measure|claim|trace|table"
#define EXPERIMENT_ACCEPTED                                                                                  \
    "those of a scenario, and [experiment], [begin], [[sweep]], [let], [[measure]], [[claim]], [trace], "    \
    "[table]"

typedef struct {
    reading_t reading;
    experiment_t *experiment;
} file_t;

/* ---- texts and names: each function returns false if the entry is wrong; the error has the accepted values
 * ---- */

const toml_entry_t *file_top(const file_t *file);
bool file_fail(const file_t *file, const toml_entry_t *entry, const char *message);

/* Memory for `count` elements and one more, set to zero, which is freed with the experiment. NULL: there is
 * not enough memory, and the error says so. */
void *file_take(const file_t *file, size_t count, size_t size);

/* Reads an optional, or a required, text of one line. */
bool file_text(const file_t *file, const toml_entry_t *table, const char *key, const char **to);
bool file_needed(const file_t *file, const toml_entry_t *table, const char *key, const char *example,
                 const char **to);

/* Reads a list of names, or one name. Returns their number; 0: wrong. */
uint32_t file_list(const file_t *file, const toml_entry_t *entry, const toml_entry_t **names, uint32_t most);

/* Reads a number, or an expression if `text` is not NULL. */
bool file_number(const file_t *file, const toml_entry_t *entry, double *number, const char **text);

/* Reports that no choice of "a|b", or no point of the sweep, has this name. Returns false. */
bool file_no_such(const file_t *file, const toml_entry_t *entry, const char *what, const char *choices);
bool file_no_point(const file_t *file, const toml_entry_t *entry, const sweep_t *sweep);

/* true: the text can be part of the names of files and rows. */
bool file_is_name(const file_t *file, const toml_entry_t *entry);

/* true: an expression can contain this name. */
bool file_is_word(const file_t *file, const toml_entry_t *entry, const char *name);

/* true: in no earlier table of the array this key has the same text. */
bool file_is_first(const file_t *file, const toml_entry_t *array, const toml_entry_t *table, const char *key);

/* ---- parts of the file ---- */

bool file_read_uses(const file_t *file, const toml_entry_t *table, point_t *point);
bool file_read_begin(const file_t *file, const toml_entry_t *table, bool of_point, point_t *to);
bool file_read_sweeps(const file_t *file);
bool file_read_measures(const file_t *file);
bool file_read_trace(const file_t *file);
bool file_read_table(const file_t *file);
bool file_read_lets(const file_t *file);
bool file_read_claims(const file_t *file);
bool file_read_runs(const file_t *file);

/* Check every expression and text before the runs. */
bool file_check_lets(const file_t *file);
bool file_check_claims(const file_t *file);
bool file_check_table(const file_t *file);

/* Index of the point with this name; count: none. */
uint32_t sweep_point(const sweep_t *sweep, const char *name);

#endif
