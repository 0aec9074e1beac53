/* Reads an experiment's file: the parts that a scenario does not have. */
#include "host_sim/lab/experiment_read.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

const toml_entry_t *file_top(const file_t *file)
{
    return &file->reading.file->entries[0];
}

bool file_fail(const file_t *file, const toml_entry_t *entry, const char *message)
{
    return scenario_fail(file->reading.error, reading_place(entry), reading_key(entry), "%s", message);
}

void *file_take(const file_t *file, size_t count, size_t size)
{
    void *memory = scenario_take(file->experiment->base, (count + 1u) * size);
    if (memory == NULL) {
        scenario_no_memory(file->reading.error);
    }
    return memory;
}

/* An optional text in one line. */
bool file_text(const file_t *file, const toml_entry_t *table, const char *key, const char **to)
{
    const toml_entry_t *entry = reading_find(&file->reading, table, key);
    if (entry == NULL) {
        return true;
    }
    if (!reading_is_text(&file->reading, entry, false)) {
        return false;
    }
    *to = entry->text;
    return true;
}

bool file_needed(const file_t *file, const toml_entry_t *table, const char *key, const char *example,
                 const char **to)
{
    if (reading_find(&file->reading, table, key) == NULL) {
        return reading_missing(&file->reading, table, key, example);
    }
    return file_text(file, table, key, to);
}

/* A list of names, or one name. */
uint32_t file_list(const file_t *file, const toml_entry_t *entry, const toml_entry_t **names, uint32_t most)
{
    uint32_t count = 0;
    if (entry->type == TOML_TEXT) {
        names[count++] = entry;
        return count;
    }
    if (!reading_is_type(&file->reading, entry, TOML_ARRAY)) {
        return 0;
    }
    for (const toml_entry_t *each = reading_first(&file->reading, entry); each != NULL;
         each = reading_next(&file->reading, entry, each)) {
        if (!reading_is_text(&file->reading, each, false)) {
            return 0;
        }
        if (count == most) {
            scenario_fail(file->reading.error, reading_place(entry), reading_key(entry),
                          "too many names; accepted: up to %u", (unsigned)most);
            return 0;
        }
        names[count++] = each;
    }
    if (count == 0u) {
        file_fail(file, entry, "the list is empty; accepted: a name or a list of names");
    }
    return count;
}

bool file_no_such(const file_t *file, const toml_entry_t *entry, const char *what, const char *choices)
{
    char accepted[256];
    size_t used = 0;
    names_search_t search = names_search(entry->text);
    names_consider_choices(&search, choices);
    for (const char *c = choices; *c != '\0' && used + 3u < sizeof accepted; c++) {
        accepted[used++] = *c == '|' ? ',' : *c;
        if (*c == '|') {
            accepted[used++] = ' ';
        }
    }
    accepted[used] = '\0';
    const char *near = names_found(&search);
    return scenario_fail(file->reading.error, reading_place(entry), reading_key(entry),
                         "no %s is called \"%.60s\"%s%s; accepted: %s", what, entry->text,
                         near != NULL ? "; nearest: " : "", near != NULL ? near : "", accepted);
}

bool file_is_first(const file_t *file, const toml_entry_t *array, const toml_entry_t *table, const char *key)
{
    const toml_entry_t *name = reading_find(&file->reading, table, key);
    for (const toml_entry_t *other = reading_first(&file->reading, array); other != table;
         other = reading_next(&file->reading, array, other)) {
        if (strcmp(reading_find(&file->reading, other, key)->text, name->text) == 0) {
            return scenario_fail(file->reading.error, reading_place(name), key,
                                 "another [[%s]] has this %s; accepted: each %s once", reading_key(array),
                                 key, key);
        }
    }
    return true;
}

/* Names that become parts of file names and row names. */
bool file_is_name(const file_t *file, const toml_entry_t *entry)
{
    return (strpbrk(entry->text, "./\\ ") == NULL && entry->text[0] != '\0') ||
           scenario_fail(
               file->reading.error, reading_place(entry), reading_key(entry),
               "\"%.60s\" cannot be part of a row's name; accepted: a word without . / \\ and blanks",
               entry->text);
}

/* ---- [begin], and the same keys of a point ---- */

bool file_read_uses(const file_t *file, const toml_entry_t *table, point_t *point)
{
    const toml_entry_t *use = reading_find(&file->reading, table, "use");
    const toml_entry_t *names[4];
    if (use == NULL) {
        return true;
    }
    point->use_count = file_list(file, use, names, 4u);
    for (uint32_t n = 0; n < point->use_count; n++) {
        point->uses[n] = experiment_set(names[n]->text);
        if (point->uses[n] == NULL) {
            return file_no_such(file, names[n], "set of rows", experiment_set_names);
        }
    }
    return point->use_count > 0u;
}

bool file_read_begin(const file_t *file, const toml_entry_t *table, bool of_point, point_t *to)
{
    const toml_entry_t *begin = reading_find(&file->reading, table, "begin");
    to->settle = (double)NAN;
    if (begin == NULL) {
        return true;
    }
    if (!reading_is_type(&file->reading, begin, TOML_TABLE) ||
        !reading_only_keys(&file->reading, begin,
                           of_point ? "settle|params|plant|rig" : "by|settle|params|plant|rig",
                           of_point ? "settle, and rows as params.ROW, plant.ROW, rig.ROW"
                                    : "by, settle, and rows as params.ROW, plant.ROW, rig.ROW")) {
        return false;
    }
    const toml_entry_t *by = reading_find(&file->reading, begin, "by");
    const toml_entry_t *settle = reading_find(&file->reading, begin, "settle");
    if (by != NULL) {
        if (!reading_is_text(&file->reading, by, false)) {
            return false;
        }
        file->experiment->dynamometer = strcmp(by->text, "dynamometer") == 0;
        if (!file->experiment->dynamometer && strcmp(by->text, "power_on") != 0) {
            return file_no_such(file, by, "beginning", "dynamometer|power_on");
        }
    }
    return (settle == NULL ||
            reading_in_range(&file->reading, settle, "s", 0.0, SCENARIO_SECONDS_MAX, &to->settle)) &&
           reading_sections(&file->reading, begin, &to->ready, 0u);
}

/* ---- [experiment] ---- */

static bool read_each(const file_t *file, const toml_entry_t *each)
{
    experiment_t *experiment = file->experiment;
    const toml_entry_t *names[EACH_MAX];
    experiment->each_sweep = experiment->sweep_count;
    experiment->each_count = 1u;
    if (each == NULL) {
        return true;
    }
    experiment->each_count = file_list(file, each, names, EACH_MAX);
    for (uint32_t s = 0; s < experiment->sweep_count && experiment->each_count > 0u; s++) {
        if (sweep_point(&experiment->sweeps[s], names[0]->text) < experiment->sweeps[s].count) {
            experiment->each_sweep = s;
        }
    }
    if (experiment->each_count > 0u && experiment->each_sweep == experiment->sweep_count) {
        return file_fail(file, names[0],
                         "no sweep has a point of this name; accepted: names of points of one sweep");
    }
    for (uint32_t n = 0; n < experiment->each_count; n++) {
        const sweep_t *sweep = &experiment->sweeps[experiment->each_sweep];
        if (!file_is_name(file, names[n])) {
            return false;
        }
        experiment->each[n] = sweep_point(sweep, names[n]->text);
        if (experiment->each[n] == sweep->count) {
            return file_no_point(file, names[n], sweep);
        }
    }
    return experiment->each_count > 0u;
}

/* The name of the file without its ending. */
static bool name_by_file(const file_t *file)
{
    const char *path = file->experiment->base->path;
    const char *slash = strrchr(path, '/');
    const char *name = slash != NULL ? slash + 1 : path;
    char *id = file_take(file, strlen(name), 1u);
    if (id != NULL) {
        snprintf(id, strlen(name) + 1u, "%s", name);
        id[strcspn(id, ".")] = '\0';
        file->experiment->id = id;
    }
    return id != NULL;
}

static bool read_experiment(const file_t *file)
{
    experiment_t *experiment = file->experiment;
    const toml_entry_t *table = reading_find(&file->reading, file_top(file), "experiment");
    experiment->claim = "";
    experiment->condition = "";
    if (table == NULL) {
        return name_by_file(file) && read_each(file, NULL);
    }
    if (!reading_is_type(&file->reading, table, TOML_TABLE) ||
        !reading_only_keys(&file->reading, table, "id|claim|source|use|each|condition|curve|whole_turns",
                           "id, claim, source, use, each, condition, curve, whole_turns") ||
        !file_text(file, table, "id", &experiment->id) ||
        (experiment->id != NULL && !file_is_name(file, reading_find(&file->reading, table, "id"))) ||
        !file_text(file, table, "claim", &experiment->claim) ||
        !file_text(file, table, "source", &experiment->source) ||
        !file_text(file, table, "condition", &experiment->condition) ||
        !file_read_uses(file, table, &experiment->begin)) {
        return false;
    }
    const toml_entry_t *curve = reading_find(&file->reading, table, "curve");
    if (curve != NULL) {
        if (!reading_is_text(&file->reading, curve, false)) {
            return false;
        }
        experiment->curve = experiment_curve(curve->text);
        if (experiment->curve == NULL) {
            return file_no_such(file, curve, "curve", experiment_curve_names);
        }
    }
    const toml_entry_t *turns = reading_find(&file->reading, table, "whole_turns");
    if (turns != NULL && !reading_is_type(&file->reading, turns, TOML_BOOL)) {
        return false;
    }
    experiment->whole_turns = turns != NULL && turns->integer != 0;
    return (experiment->id != NULL || name_by_file(file)) &&
           read_each(file, reading_find(&file->reading, table, "each"));
}

static bool read_all(const file_t *file)
{
    return file_read_begin(file, file_top(file), false, &file->experiment->begin) && file_read_sweeps(file) &&
           read_experiment(file) && file_read_measures(file) && file_read_trace(file) &&
           file_read_table(file) && file_read_lets(file) && file_read_claims(file) && file_read_runs(file) &&
           file_check_lets(file) && file_check_claims(file) && file_check_table(file);
}

/* ---- the file ---- */

static experiment_t *read_file(const char *path, const char *text, size_t octets, scenario_error_t *error)
{
    const scenario_more_t more = {
        .keys = EXPERIMENT_KEYS, .accepted = EXPERIMENT_ACCEPTED, .unchecked = true};
    scenario_t *base = scenario_read_more(path, text, octets, &more, error);
    if (base == NULL) {
        return NULL;
    }
    experiment_t *experiment = calloc(1, sizeof *experiment);
    if (experiment == NULL) {
        scenario_free(base);
        scenario_no_memory(error);
        return NULL;
    }
    experiment->base = base;
    const file_t file = {{base->memory->file, base, error, false, &more}, experiment};
    experiment->idle = reading_find(&file.reading, file_top(&file), "run") == NULL;
    if (!read_all(&file)) {
        snprintf(error->file, sizeof error->file, "%s", path);
        experiment_free(experiment);
        return NULL;
    }
    return experiment;
}

experiment_t *experiment_read(const char *path, scenario_error_t *error)
{
    toml_error_t why;
    toml_file_t *file = toml_read(path, &why);
    if (file == NULL) {
        scenario_fail(error, (scenario_place_t){why.line, why.column}, why.name, "%s", why.message);
        snprintf(error->file, sizeof error->file, "%s", path);
        return NULL;
    }
    experiment_t *experiment = read_file(path, file->source, file->octets, error);
    toml_free(file);
    return experiment;
}
