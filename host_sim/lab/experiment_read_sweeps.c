/* Reading the sweeps of an experiment. */
#include "host_sim/lab/experiment_read.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static bool read_point(const file_t *file, const toml_entry_t *entry, point_t *point)
{
    const reading_t *reading = &file->reading;
    if (!reading_is_type(reading, entry, TOML_TABLE) ||
        !reading_only_keys(reading, entry, "name|text|number|only|use|begin|at|params|requests|plant|rig",
                           "name, text, number, only, use, begin, at, and rows as params.ROW, requests.ROW, "
                           "plant.ROW, rig.ROW") ||
        !file_needed(file, entry, "name", "name = \"ideal\"", &point->name)) {
        return false;
    }
    const toml_entry_t *number = reading_find(reading, entry, "number");
    point->text = point->name;
    point->entry = (uint32_t)(entry - reading->file->entries);
    point->number = (double)NAN;
    return (number == NULL || file_number(file, number, &point->number, NULL)) &&
           file_text(file, entry, "text", &point->text) && file_read_uses(file, entry, point) &&
           file_read_begin(file, entry, true, point);
}

/* Names of the points of a row over values. */
static bool name_points(const file_t *file, const toml_entry_t *entry, sweep_t *sweep)
{
    const toml_entry_t *names = reading_find(&file->reading, entry, "names");
    if (names == NULL) {
        return true;
    }
    const toml_entry_t **list = file_take(file, sweep->count, sizeof *list);
    if (list == NULL) {
        return false;
    }
    const uint32_t count = file_list(file, names, list, sweep->count);
    if (count != sweep->count) {
        return count != 0u &&
               scenario_fail(file->reading.error, reading_place(names), "names",
                             "there are %u names and %u values; accepted: one name for each value",
                             (unsigned)count, (unsigned)sweep->count);
    }
    for (uint32_t n = 0; n < count; n++) {
        sweep->points[n].name = list[n]->text;
    }
    return true;
}

/* A value as it is written; of a seed: row NULL. */
static const char *written(const file_t *file, const toml_entry_t *entry, const table_row_t *row,
                           double value)
{
    if (entry != NULL && entry->type == TOML_TEXT) {
        return entry->text;
    }
    char *text = file_take(file, UNITS_TEXT_SIZE, 1u);
    if (text != NULL && row == NULL) {
        snprintf(text, UNITS_TEXT_SIZE, "%.0f", value);
        return text;
    }
    return text != NULL ? units_row_text(text, value, row) : "";
}

static bool set_point(const file_t *file, const toml_entry_t *entry, const toml_entry_t *place,
                      const table_row_t *row, double value, point_t *point)
{
    point->setting = (scenario_setting_t){row, value, reading_place(place)};
    point->name = written(file, entry, row, value);
    point->text = point->name;
    point->number = value;
    point->settle = (double)NAN;
    if (row == NULL) {
        return value == floor(value) ||
               file_fail(file, place, "a step is no whole number; accepted: seeds, as 1, 2, 3");
    }
    return scenario_row_accepts(row, value, reading_place(place), file->reading.error);
}

#define SEED_MAX (INT64_C(1) << 53) /* that a double distinguishes from its neighbours */

static bool read_one(const file_t *file, const toml_entry_t *entry, const table_row_t *row, double *value)
{
    if (row != NULL) {
        return reading_row_value(&file->reading, entry, row, value);
    }
    *value = entry->number;
    return reading_is_whole(&file->reading, entry, 0, SEED_MAX);
}

static bool read_values(const file_t *file, const toml_entry_t *values, const table_row_t *row,
                        sweep_t *sweep)
{
    if (!reading_is_type(&file->reading, values, TOML_ARRAY)) {
        return false;
    }
    sweep->points = file_take(file, reading_count(&file->reading, values), sizeof *sweep->points);
    for (const toml_entry_t *entry = reading_first(&file->reading, values);
         entry != NULL && sweep->points != NULL; entry = reading_next(&file->reading, values, entry)) {
        double value = 0.0;
        if (!read_one(file, entry, row, &value) ||
            !set_point(file, entry, entry, row, value, &sweep->points[sweep->count++])) {
            return false;
        }
    }
    return sweep->points != NULL &&
           (sweep->count > 0u || file_fail(file, values, "it is empty; accepted: values of the row"));
}

static bool read_steps(const file_t *file, const toml_entry_t *entry, const table_row_t *row, sweep_t *sweep)
{
    const reading_t *reading = &file->reading;
    const toml_entry_t *from = reading_find(reading, entry, "from");
    const toml_entry_t *to = reading_find(reading, entry, "to");
    const toml_entry_t *steps = reading_find(reading, entry, "steps");
    double first = 0.0;
    double last = 0.0;
    if (from == NULL || to == NULL || steps == NULL) {
        return reading_missing(reading, entry, "values",
                               "values = [1, 2, 3], or from = 1, to = 3, steps = 3");
    }
    if (row != NULL && row->kind == SLOT_ENUM) {
        return file_fail(file, from, "the row has choices; accepted: values = [...] of them");
    }
    if (!read_one(file, from, row, &first) || !read_one(file, to, row, &last) ||
        !reading_is_whole(reading, steps, 2, EXPERIMENT_RUNS_MAX)) {
        return false;
    }
    const uint32_t count = (uint32_t)steps->integer;
    sweep->points = file_take(file, count, sizeof *sweep->points);
    while (sweep->points != NULL && sweep->count < count) {
        const double value = first + (last - first) * sweep->count / (count - 1u);
        if (!set_point(file, NULL, from, row, value, &sweep->points[sweep->count++])) {
            return false;
        }
    }
    return sweep->points != NULL;
}

static bool read_sweep(const file_t *file, const toml_entry_t *entry, sweep_t *sweep)
{
    const reading_t *reading = &file->reading;
    sweep->place = reading_place(entry);
    if (!reading_is_type(reading, entry, TOML_TABLE) ||
        !reading_only_keys(reading, entry, "name|row|values|from|to|steps|names|point",
                           "name; row with values or with from, to, steps; names; [[sweep.point]]") ||
        !file_needed(file, entry, "name", "name = \"load\"", &sweep->name)) {
        return false;
    }
    const toml_entry_t *row = reading_find(reading, entry, "row");
    const toml_entry_t *values = reading_find(reading, entry, "values");
    const toml_entry_t *points = reading_find(reading, entry, "point");
    if ((row == NULL) == (points == NULL)) {
        return file_fail(file, entry,
                         "accepted: either row with its values, or [[sweep.point]], as often as needed");
    }
    if (row != NULL) {
        const table_row_t *of = NULL;
        sweep->of_seed = row->type == TOML_TEXT && strcmp(row->text, "run.seed") == 0;
        return (sweep->of_seed || reading_signal(reading, row, &of)) &&
               (values != NULL ? read_values(file, values, of, sweep) : read_steps(file, entry, of, sweep)) &&
               name_points(file, entry, sweep);
    }
    uint32_t count;
    bool good;
    (void)reading_tables(reading, entry, "point", &count, &good);
    sweep->points = good ? file_take(file, count, sizeof *sweep->points) : NULL;
    for (const toml_entry_t *point = reading_first(reading, points); point != NULL && sweep->points != NULL;
         point = reading_next(reading, points, point)) {
        if (!read_point(file, point, &sweep->points[sweep->count++])) {
            return false;
        }
    }
    return sweep->points != NULL;
}

uint32_t sweep_point(const sweep_t *sweep, const char *name)
{
    uint32_t n = 0;
    while (n < sweep->count && strcmp(sweep->points[n].name, name) != 0) {
        n++;
    }
    return n;
}

/* only = {SWEEP = POINTS}: the points of other sweeps with which this point runs. */
static bool read_only(const file_t *file, const toml_entry_t *only, const sweep_t *own, point_t *point)
{
    const experiment_t *experiment = file->experiment;
    if (!reading_is_type(&file->reading, only, TOML_TABLE)) {
        return false;
    }
    for (const toml_entry_t *entry = reading_first(&file->reading, only); entry != NULL;
         entry = reading_next(&file->reading, only, entry)) {
        uint32_t s = 0;
        while (s < experiment->sweep_count && strcmp(experiment->sweeps[s].name, entry->key) != 0) {
            s++;
        }
        const sweep_t *sweep = &experiment->sweeps[s];
        if (s == experiment->sweep_count || sweep == own) {
            return file_fail(file, entry,
                             "accepted: names of the other sweeps, each with names of its points");
        }
        const toml_entry_t **names = file_take(file, sweep->count, sizeof *names);
        point->only[s] = file_take(file, sweep->count, sizeof *point->only[s]);
        if (names == NULL || point->only[s] == NULL) {
            return false;
        }
        const uint32_t count = file_list(file, entry, names, sweep->count);
        for (uint32_t n = 0; n < count; n++) {
            const uint32_t with = sweep_point(sweep, names[n]->text);
            if (with == sweep->count) {
                return file_no_point(file, names[n], sweep);
            }
            point->only[s][with] = true;
        }
        if (count == 0u) {
            return false;
        }
    }
    return true;
}

/* Called when all sweeps are known. */
static bool read_onlies(const file_t *file)
{
    const experiment_t *experiment = file->experiment;
    for (uint32_t s = 0; s < experiment->sweep_count; s++) {
        const sweep_t *sweep = &experiment->sweeps[s];
        for (uint32_t n = 0; n < sweep->count; n++) {
            const toml_entry_t *entry = &file->reading.file->entries[sweep->points[n].entry];
            const toml_entry_t *only =
                sweep->points[n].entry != 0u ? reading_find(&file->reading, entry, "only") : NULL;
            if (only != NULL && !read_only(file, only, sweep, &sweep->points[n])) {
                return false;
            }
        }
    }
    return true;
}

bool file_read_sweeps(const file_t *file)
{
    experiment_t *experiment = file->experiment;
    bool good;
    uint32_t count;
    size_t runs = 1;
    const toml_entry_t *array = reading_tables(&file->reading, file_top(file), "sweep", &count, &good);
    experiment->sweeps = good ? file_take(file, count, sizeof *experiment->sweeps) : NULL;
    if (experiment->sweeps == NULL || array == NULL) {
        return experiment->sweeps != NULL;
    }
    if (count > SWEEPS_MAX) {
        return scenario_fail(file->reading.error, reading_place(array), "sweep",
                             "there are %u sweeps; accepted: up to %u", (unsigned)count, SWEEPS_MAX);
    }
    for (const toml_entry_t *entry = reading_first(&file->reading, array); entry != NULL;
         entry = reading_next(&file->reading, array, entry)) {
        sweep_t *sweep = &experiment->sweeps[experiment->sweep_count++];
        if (!read_sweep(file, entry, sweep) || !file_is_first(file, array, entry, "name")) {
            return false;
        }
        for (uint32_t n = 0; n < sweep->count; n++) {
            if (sweep_point(sweep, sweep->points[n].name) < n) {
                return scenario_fail(file->reading.error, reading_place(entry), "sweep",
                                     "two of its points are called \"%.60s\"; accepted: each name once",
                                     sweep->points[n].name);
            }
        }
        runs *= sweep->count;
        if (runs > EXPERIMENT_RUNS_MAX) {
            return scenario_fail(file->reading.error, reading_place(entry), "sweep",
                                 "the points of all sweeps make more than %u runs; accepted: at most that "
                                 "many, remove points or sweeps",
                                 EXPERIMENT_RUNS_MAX);
        }
    }
    return read_onlies(file);
}

bool file_no_point(const file_t *file, const toml_entry_t *entry, const sweep_t *sweep)
{
    char choices[200] = "";
    for (uint32_t n = 0; n < sweep->count; n++) {
        const size_t used = strlen(choices);
        snprintf(choices + used, sizeof choices - used, "%s%s", n > 0u ? "|" : "", sweep->points[n].name);
    }
    return file_no_such(file, entry, "point of the sweep", choices);
}
