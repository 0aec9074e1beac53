/* What the files that read an experiment share. */
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

/* ---- texts and names; each: false: the error says what is wrong and what is accepted ---- */

const toml_entry_t *file_top(const file_t *file);
bool file_fail(const file_t *file, const toml_entry_t *entry, const char *message);

/* Zeroed memory of the experiment, room for one more; NULL: there is none, as the error says. */
void *file_take(const file_t *file, size_t count, size_t size);

/* An optional text in one line, and one that must be there. */
bool file_text(const file_t *file, const toml_entry_t *table, const char *key, const char **to);
bool file_needed(const file_t *file, const toml_entry_t *table, const char *key, const char *example,
                 const char **to);

/* A list of names, or one name: how many; 0: wrong. */
uint32_t file_list(const file_t *file, const toml_entry_t *entry, const toml_entry_t **names, uint32_t most);

/* A number, or an expression unless text is NULL. */
bool file_number(const file_t *file, const toml_entry_t *entry, double *number, const char **text);

/* Returns false: none of these choices, "a|b", is called so. */
bool file_no_such(const file_t *file, const toml_entry_t *entry, const char *what, const char *choices);
bool file_no_point(const file_t *file, const toml_entry_t *entry, const sweep_t *sweep);

/* May the text be part of the name of a file and of rows? */
bool file_is_name(const file_t *file, const toml_entry_t *entry);

/* Can an expression have this name? */
bool file_is_word(const file_t *file, const toml_entry_t *entry, const char *name);

/* Is this the first table of the array with this text of the key? */
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

/* Every expression and text, on runs that have not been made. */
bool file_check_lets(const file_t *file);
bool file_check_claims(const file_t *file);
bool file_check_table(const file_t *file);

/* The point of this name; count: none. */
uint32_t sweep_point(const sweep_t *sweep, const char *name);

#endif
