/* Reading an experiment's file: what it has beyond a scenario. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host_sim/lab/experiment_parts.h"

#define KEYS                                                                                                 \
    "schema|title|text|run|start|motor|params|requests|plant|rig|at|profile|expect|experiment|begin|sweep|"  \
    "measure|claim|trace"
#define ACCEPTED "those of a scenario, and [experiment], [begin], [[sweep]], [[measure]], [[claim]], [trace]"

typedef struct {
    reading_t reading;
    experiment_t *experiment;
} file_t;

static const toml_entry_t *top_of(const file_t *file)
{
    return &file->reading.file->entries[0];
}

static bool fail(const file_t *file, const toml_entry_t *entry, const char *message)
{
    return scenario_fail(file->reading.error, reading_place(entry), reading_key(entry), "%s", message);
}

static void *take(const file_t *file, size_t count, size_t size)
{
    void *memory = scenario_take(file->experiment->base, (count + 1u) * size);
    if (memory == NULL) {
        scenario_no_memory(file->reading.error);
    }
    return memory;
}

/* An optional text in one line. */
static bool read_text(const file_t *file, const toml_entry_t *table, const char *key, const char **to)
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

static bool read_needed(const file_t *file, const toml_entry_t *table, const char *key, const char *example,
                        const char **to)
{
    if (reading_find(&file->reading, table, key) == NULL) {
        return reading_missing(&file->reading, table, key, example);
    }
    return read_text(file, table, key, to);
}

/* A list of names, or one name. */
static uint32_t list_of(const file_t *file, const toml_entry_t *entry, const toml_entry_t **names,
                        uint32_t most)
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
        fail(file, entry, "the list is empty; accepted: a name or a list of names");
    }
    return count;
}

static bool no_such(const file_t *file, const toml_entry_t *entry, const char *what, const char *choices)
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

/* ---- [begin], and what a point has alike ---- */

static bool read_uses(const file_t *file, const toml_entry_t *table, point_t *point)
{
    const toml_entry_t *use = reading_find(&file->reading, table, "use");
    const toml_entry_t *names[4];
    if (use == NULL) {
        return true;
    }
    point->use_count = list_of(file, use, names, 4u);
    for (uint32_t n = 0; n < point->use_count; n++) {
        point->uses[n] = experiment_set(names[n]->text);
        if (point->uses[n] == NULL) {
            return no_such(file, names[n], "set of rows", experiment_set_names);
        }
    }
    return point->use_count > 0u;
}

static bool read_begin(const file_t *file, const toml_entry_t *table, bool of_point, point_t *to)
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
            return no_such(file, by, "beginning", "dynamometer|power_on");
        }
    }
    return (settle == NULL ||
            reading_in_range(&file->reading, settle, "s", 0.0, SCENARIO_SECONDS_MAX, &to->settle)) &&
           reading_sections(&file->reading, begin, &to->ready, 0u);
}

/* ---- [[sweep]] ---- */

static bool read_point(const file_t *file, const toml_entry_t *entry, point_t *point)
{
    const reading_t *reading = &file->reading;
    if (!reading_is_type(reading, entry, TOML_TABLE) ||
        !reading_only_keys(
            reading, entry, "name|text|use|begin|at|params|requests|plant|rig",
            "name, text, use, begin, at, and rows as params.ROW, requests.ROW, plant.ROW, rig.ROW") ||
        !read_needed(file, entry, "name", "name = \"ideal\"", &point->name)) {
        return false;
    }
    point->text = point->name;
    point->entry = (uint32_t)(entry - reading->file->entries);
    return read_text(file, entry, "text", &point->text) && read_uses(file, entry, point) &&
           read_begin(file, entry, true, point);
}

/* Names of the points of a row over values. */
static bool name_points(const file_t *file, const toml_entry_t *entry, sweep_t *sweep)
{
    const toml_entry_t *names = reading_find(&file->reading, entry, "names");
    if (names == NULL) {
        return true;
    }
    const toml_entry_t **list = take(file, sweep->count, sizeof *list);
    if (list == NULL) {
        return false;
    }
    const uint32_t count = list_of(file, names, list, sweep->count);
    if (count != sweep->count) {
        return count != 0u && scenario_fail(file->reading.error, reading_place(names), "names",
                                            "they are %u, the values are %u; accepted: as many as values",
                                            (unsigned)count, (unsigned)sweep->count);
    }
    for (uint32_t n = 0; n < count; n++) {
        sweep->points[n].name = list[n]->text;
    }
    return true;
}

/* The value as it is written. */
static const char *written(const file_t *file, const toml_entry_t *entry, const table_row_t *row,
                           double value)
{
    if (entry != NULL && entry->type == TOML_TEXT) {
        return entry->text;
    }
    char *text = take(file, UNITS_TEXT_SIZE, 1u);
    return text != NULL ? units_row_text(text, value, row) : "";
}

static bool set_point(const file_t *file, const toml_entry_t *entry, const toml_entry_t *place,
                      const table_row_t *row, double value, point_t *point)
{
    point->setting = (scenario_setting_t){row, value, reading_place(place)};
    point->name = written(file, entry, row, value);
    point->text = point->name;
    point->settle = (double)NAN;
    return scenario_row_accepts(row, value, reading_place(place), file->reading.error);
}

static bool read_values(const file_t *file, const toml_entry_t *values, const table_row_t *row,
                        sweep_t *sweep)
{
    if (!reading_is_type(&file->reading, values, TOML_ARRAY)) {
        return false;
    }
    sweep->points = take(file, reading_count(&file->reading, values), sizeof *sweep->points);
    for (const toml_entry_t *entry = reading_first(&file->reading, values);
         entry != NULL && sweep->points != NULL; entry = reading_next(&file->reading, values, entry)) {
        double value = 0.0;
        if (!reading_row_value(&file->reading, entry, row, &value) ||
            !set_point(file, entry, entry, row, value, &sweep->points[sweep->count++])) {
            return false;
        }
    }
    return sweep->points != NULL &&
           (sweep->count > 0u || fail(file, values, "it is empty; accepted: values of the row"));
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
    if (row->kind == SLOT_ENUM) {
        return fail(file, from, "the row has choices; accepted: values = [...] of them");
    }
    if (!reading_row_value(reading, from, row, &first) || !reading_row_value(reading, to, row, &last) ||
        !reading_is_whole(reading, steps, 2, EXPERIMENT_RUNS_MAX)) {
        return false;
    }
    const uint32_t count = (uint32_t)steps->integer;
    sweep->points = take(file, count, sizeof *sweep->points);
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
        !read_needed(file, entry, "name", "name = \"load\"", &sweep->name)) {
        return false;
    }
    const toml_entry_t *row = reading_find(reading, entry, "row");
    const toml_entry_t *values = reading_find(reading, entry, "values");
    const toml_entry_t *points = reading_find(reading, entry, "point");
    if ((row == NULL) == (points == NULL)) {
        return fail(file, entry,
                    "accepted: either row with its values, or [[sweep.point]], as often as needed");
    }
    if (row != NULL) {
        const table_row_t *of = NULL;
        return reading_signal(reading, row, &of) &&
               (values != NULL ? read_values(file, values, of, sweep) : read_steps(file, entry, of, sweep)) &&
               name_points(file, entry, sweep);
    }
    uint32_t count;
    bool good;
    (void)reading_tables(reading, entry, "point", &count, &good);
    sweep->points = good ? take(file, count, sizeof *sweep->points) : NULL;
    for (const toml_entry_t *point = reading_first(reading, points); point != NULL && sweep->points != NULL;
         point = reading_next(reading, points, point)) {
        if (!read_point(file, point, &sweep->points[sweep->count++])) {
            return false;
        }
    }
    return sweep->points != NULL;
}

static uint32_t point_of(const sweep_t *sweep, const char *name)
{
    uint32_t n = 0;
    while (n < sweep->count && strcmp(sweep->points[n].name, name) != 0) {
        n++;
    }
    return n;
}

static bool read_sweeps(const file_t *file)
{
    experiment_t *experiment = file->experiment;
    bool good;
    uint32_t count;
    size_t runs = 1;
    const toml_entry_t *array = reading_tables(&file->reading, top_of(file), "sweep", &count, &good);
    experiment->sweeps = good ? take(file, count, sizeof *experiment->sweeps) : NULL;
    if (experiment->sweeps == NULL || array == NULL) {
        return experiment->sweeps != NULL;
    }
    if (count > SWEEPS_MAX) {
        return scenario_fail(file->reading.error, reading_place(array), "sweep",
                             "they are %u; accepted: up to %u", (unsigned)count, SWEEPS_MAX);
    }
    for (const toml_entry_t *entry = reading_first(&file->reading, array); entry != NULL;
         entry = reading_next(&file->reading, array, entry)) {
        sweep_t *sweep = &experiment->sweeps[experiment->sweep_count++];
        if (!read_sweep(file, entry, sweep)) {
            return false;
        }
        for (sweep_t *other = experiment->sweeps; other < sweep; other++) {
            if (strcmp(other->name, sweep->name) == 0) {
                return fail(file, reading_find(&file->reading, entry, "name"),
                            "another [[sweep]] has this name; accepted: each name once");
            }
        }
        for (uint32_t n = 0; n < sweep->count; n++) {
            if (point_of(sweep, sweep->points[n].name) < n) {
                return scenario_fail(file->reading.error, reading_place(entry), "sweep",
                                     "two of its points are called \"%.60s\"; accepted: each name once",
                                     sweep->points[n].name);
            }
        }
        runs *= sweep->count;
        if (runs > EXPERIMENT_RUNS_MAX) {
            return scenario_fail(file->reading.error, reading_place(entry), "sweep",
                                 "the points of all sweeps make more than %u runs; accepted: up to that",
                                 EXPERIMENT_RUNS_MAX);
        }
    }
    return true;
}

static bool no_point(const file_t *file, const toml_entry_t *entry, const sweep_t *sweep)
{
    char choices[200] = "";
    for (uint32_t n = 0; n < sweep->count; n++) {
        const size_t used = strlen(choices);
        snprintf(choices + used, sizeof choices - used, "%s%s", n > 0u ? "|" : "", sweep->points[n].name);
    }
    return no_such(file, entry, "point of the sweep", choices);
}

/* ---- [experiment] ---- */

/* What is part of the name of a file and of rows. */
static bool is_name(const file_t *file, const toml_entry_t *entry)
{
    return (strpbrk(entry->text, "./\\ ") == NULL && entry->text[0] != '\0') ||
           scenario_fail(
               file->reading.error, reading_place(entry), reading_key(entry),
               "\"%.60s\" cannot be part of a row's name; accepted: a word without . / \\ and blanks",
               entry->text);
}

static bool read_each(const file_t *file, const toml_entry_t *each)
{
    experiment_t *experiment = file->experiment;
    const toml_entry_t *names[EACH_MAX];
    experiment->each_sweep = experiment->sweep_count;
    experiment->each_count = 1u;
    if (each == NULL) {
        return true;
    }
    experiment->each_count = list_of(file, each, names, EACH_MAX);
    for (uint32_t s = 0; s < experiment->sweep_count && experiment->each_count > 0u; s++) {
        if (point_of(&experiment->sweeps[s], names[0]->text) < experiment->sweeps[s].count) {
            experiment->each_sweep = s;
        }
    }
    if (experiment->each_count > 0u && experiment->each_sweep == experiment->sweep_count) {
        return fail(file, names[0],
                    "no sweep has a point of this name; accepted: names of points of one sweep");
    }
    for (uint32_t n = 0; n < experiment->each_count; n++) {
        const sweep_t *sweep = &experiment->sweeps[experiment->each_sweep];
        if (!is_name(file, names[n])) {
            return false;
        }
        experiment->each[n] = point_of(sweep, names[n]->text);
        if (experiment->each[n] == sweep->count) {
            return no_point(file, names[n], sweep);
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
    char *id = take(file, strlen(name), 1u);
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
    const toml_entry_t *table = reading_find(&file->reading, top_of(file), "experiment");
    experiment->claim = "";
    experiment->condition = "";
    if (table == NULL) {
        return name_by_file(file) && read_each(file, NULL);
    }
    if (!reading_is_type(&file->reading, table, TOML_TABLE) ||
        !reading_only_keys(&file->reading, table, "id|claim|source|use|each|condition|curve",
                           "id, claim, source, use, each, condition, curve") ||
        !read_text(file, table, "id", &experiment->id) ||
        (experiment->id != NULL && !is_name(file, reading_find(&file->reading, table, "id"))) ||
        !read_text(file, table, "claim", &experiment->claim) ||
        !read_text(file, table, "source", &experiment->source) ||
        !read_text(file, table, "condition", &experiment->condition) ||
        !read_uses(file, table, &experiment->begin)) {
        return false;
    }
    const toml_entry_t *curve = reading_find(&file->reading, table, "curve");
    if (curve != NULL) {
        if (!reading_is_text(&file->reading, curve, false)) {
            return false;
        }
        experiment->curve = experiment_curve(curve->text);
        if (experiment->curve == NULL) {
            return no_such(file, curve, "curve", experiment_curve_names);
        }
    }
    return (experiment->id != NULL || name_by_file(file)) &&
           read_each(file, reading_find(&file->reading, table, "each"));
}

/* ---- what is looked at ---- */

static bool read_unit(const file_t *file, const toml_entry_t *unit, const char *of, look_t *look)
{
    char one[80];
    units_error_t why;
    look->unit = strcmp(of, UNITS_SPEED) == 0          ? "rad/s"
                 : strcmp(of, UNITS_ACCELERATION) == 0 ? "rad/s^2"
                                                       : of;
    look->scale = 1.0;
    if (unit == NULL) {
        return true;
    }
    if (!reading_is_text(&file->reading, unit, false)) {
        return false;
    }
    snprintf(one, sizeof one, "1 %.70s", unit->text);
    look->unit = unit->text;
    return units_read(one, of, &look->scale, &why) || fail(file, unit, why.text);
}

/* signal, minus, through, unit. */
static bool read_look(const file_t *file, const toml_entry_t *entry, look_t *look)
{
    const reading_t *reading = &file->reading;
    const toml_entry_t *signal = reading_find(reading, entry, "signal");
    const toml_entry_t *minus = reading_find(reading, entry, "minus");
    const toml_entry_t *through = reading_find(reading, entry, "through");
    if (signal == NULL) {
        return reading_missing(reading, entry, "signal", "signal = \"true_omega_m\"");
    }
    if (!reading_signal(reading, signal, &look->row) ||
        (minus != NULL && !reading_signal(reading, minus, &look->minus)) ||
        (through != NULL && !reading_is_text(reading, through, false))) {
        return false;
    }
    if (look->minus != NULL && strcmp(units_of_row(look->minus), units_of_row(look->row)) != 0) {
        return scenario_fail(reading->error, reading_place(minus), minus->text,
                             "its unit is %s, that of %s is %s; accepted: rows of one unit",
                             look->minus->unit, signal->text, look->row->unit);
    }
    if (through != NULL) {
        look->through = experiment_through(through->text);
        if (look->through == NULL) {
            return no_such(file, through, "function of a signal", experiment_through_names);
        }
    }
    return read_unit(file, reading_find(reading, entry, "unit"),
                     look->through != NULL ? look->through->unit : units_of_row(look->row), look);
}

/* A name that an expression can have. */
static bool is_word(const file_t *file, const toml_entry_t *table, const char *name)
{
    const size_t length = strspn(name, "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_");
    return (length > 0u && name[length] == '\0' && !(name[0] >= '0' && name[0] <= '9')) ||
           scenario_fail(file->reading.error, reading_place(reading_find(&file->reading, table, "name")),
                         "name", "\"%.60s\" is no plain word; accepted: letters, digits, _, a letter first",
                         name);
}

static bool read_between(const file_t *file, const toml_entry_t *entry, measure_t *measure)
{
    const reading_t *reading = &file->reading;
    if (!reading_is_type(reading, entry, TOML_TABLE) ||
        !reading_only_keys(reading, entry, "signal|begin|end", "signal, begin, end")) {
        return false;
    }
    const toml_entry_t *signal = reading_find(reading, entry, "signal");
    const toml_entry_t *begin = reading_find(reading, entry, "begin");
    const toml_entry_t *end = reading_find(reading, entry, "end");
    if (signal == NULL || begin == NULL || end == NULL) {
        return reading_missing(
            reading, entry,
            signal == NULL  ? "signal"
            : begin == NULL ? "begin"
                            : "end",
            "between = {signal = \"true_omega_m\", begin = \"1150 r/min\", end = \"1290 r/min\"}");
    }
    if (!reading_signal(reading, signal, &measure->progress) ||
        !reading_quantity(reading, begin, units_of_row(measure->progress), &measure->past) ||
        !reading_quantity(reading, end, units_of_row(measure->progress), &measure->until)) {
        return false;
    }
    return measure->past != measure->until ||
           fail(file, end, "it is the same as begin; accepted: another value");
}

static bool read_measure(const file_t *file, const toml_entry_t *entry, measure_t *measure)
{
    const reading_t *reading = &file->reading;
    if (!reading_is_type(reading, entry, TOML_TABLE) ||
        !reading_only_keys(reading, entry, "name|signal|minus|through|unit|from|to|between",
                           "name, signal, minus, through, unit, from, to, between") ||
        !read_needed(file, entry, "name", "name = \"up\"", &measure->look.name) ||
        !is_word(file, entry, measure->look.name) || !read_look(file, entry, &measure->look)) {
        return false;
    }
    const toml_entry_t *from = reading_find(reading, entry, "from");
    const toml_entry_t *to = reading_find(reading, entry, "to");
    const toml_entry_t *between = reading_find(reading, entry, "between");
    measure->place = reading_place(entry);
    measure->to = file->experiment->base->duration;
    if ((from != NULL && !reading_time(reading, from, &measure->from)) ||
        (to != NULL && !reading_time(reading, to, &measure->to)) ||
        !scenario_in_range(measure->from, 0.0, file->experiment->base->duration, "s",
                           reading_place(from != NULL ? from : entry), "from", reading->error) ||
        !scenario_in_range(measure->to, 0.0, file->experiment->base->duration, "s",
                           reading_place(to != NULL ? to : entry), "to", reading->error) ||
        (between != NULL && !read_between(file, between, measure))) {
        return false;
    }
    measure->begin = rig_periods(measure->from);
    measure->end = rig_periods(measure->to);
    return measure->begin < measure->end ||
           fail(file, entry, "its window holds no period; accepted: from below to, within the duration");
}

static bool read_measures(const file_t *file)
{
    experiment_t *experiment = file->experiment;
    bool good;
    uint32_t count;
    const toml_entry_t *array = reading_tables(&file->reading, top_of(file), "measure", &count, &good);
    experiment->measures = good ? take(file, count, sizeof *experiment->measures) : NULL;
    const toml_entry_t *entry =
        array != NULL && experiment->measures != NULL ? reading_first(&file->reading, array) : NULL;
    for (; entry != NULL; entry = reading_next(&file->reading, array, entry)) {
        measure_t *measure = &experiment->measures[experiment->measure_count];
        if (!read_measure(file, entry, measure)) {
            return false;
        }
        const char *name = measure->look.name;
        if (experiment_measure_of(experiment, name, strlen(name)) < experiment->measure_count) {
            return fail(file, reading_find(&file->reading, entry, "name"),
                        "another [[measure]] has this name; accepted: each name once");
        }
        experiment->measure_count++;
    }
    return experiment->measures != NULL;
}

static bool read_trace(const file_t *file)
{
    const reading_t *reading = &file->reading;
    experiment_t *experiment = file->experiment;
    const toml_entry_t *trace = reading_find(reading, top_of(file), "trace");
    bool good;
    uint32_t count;
    experiment->every = 1u;
    if (trace == NULL) {
        return true;
    }
    if (!reading_is_type(reading, trace, TOML_TABLE) ||
        !reading_only_keys(reading, trace, "every|column|reference", "every, column, reference")) {
        return false;
    }
    const toml_entry_t *every = reading_find(reading, trace, "every");
    const toml_entry_t *reference = reading_find(reading, trace, "reference");
    const toml_entry_t *columns = reading_tables(reading, trace, "column", &count, &good);
    if (every != NULL && !reading_is_whole(reading, every, 1, SCENARIO_EVERY_MAX)) {
        return false;
    }
    experiment->every = every != NULL ? (uint32_t)every->integer : 1u;
    if (good && (columns == NULL || count == 0u || count > COLUMNS_MAX)) {
        return scenario_fail(reading->error, reading_place(trace), "column", "they are %u; accepted: 1 to %u",
                             (unsigned)count, COLUMNS_MAX);
    }
    for (const toml_entry_t *entry = good ? reading_first(reading, columns) : NULL; entry != NULL;
         entry = reading_next(reading, columns, entry)) {
        look_t *look = &experiment->columns[experiment->column_count++];
        if (!reading_is_type(reading, entry, TOML_TABLE) ||
            !reading_only_keys(reading, entry, "name|signal|minus|through|unit",
                               "name, signal, minus, through, unit") ||
            !read_needed(file, entry, "name", "name = \"speed\"", &look->name) ||
            !read_look(file, entry, look)) {
            return false;
        }
    }
    if (reference == NULL || !good) {
        return good;
    }
    return reading_is_type(reading, reference, TOML_TABLE) &&
           reading_only_keys(reading, reference, "name|signal|unit", "name, signal, unit") &&
           read_needed(file, reference, "name", "name = \"speed_ref\"", &experiment->reference.name) &&
           read_look(file, reference, &experiment->reference) &&
           (experiment->reference.row->access != TABLE_READ ||
            fail(file, reference,
                 "its signal is shown, not set; accepted: a row of params, requests, plant, rig"));
}

/* ---- [[claim]] ---- */

/* A number, or an expression. */
static bool read_number(const file_t *file, const toml_entry_t *entry, double *number, const char **text)
{
    if (entry->type == TOML_INTEGER || entry->type == TOML_FLOAT) {
        *number = entry->number;
        return isfinite(*number) || fail(file, entry, "it is no finite number");
    }
    if (text == NULL) {
        return fail(file, entry, "accepted: a number in the unit of the claim");
    }
    if (!reading_is_text(&file->reading, entry, false)) {
        return false;
    }
    *text = entry->text;
    return true;
}

static bool read_tolerance(const file_t *file, const toml_entry_t *table, claim_t *claim)
{
    const experiment_t *experiment = file->experiment;
    const toml_entry_t *tolerance = reading_find(&file->reading, table, "tolerance");
    for (uint32_t n = 0; n < experiment->each_count && tolerance != NULL; n++) {
        const toml_entry_t *entry = tolerance;
        if (tolerance->type == TOML_TABLE && experiment->each_sweep < experiment->sweep_count) {
            const sweep_t *sweep = &experiment->sweeps[experiment->each_sweep];
            const char *name = sweep->points[experiment->each[n]].name;
            entry = reading_find(&file->reading, tolerance, name);
            if (entry == NULL) {
                return reading_missing(&file->reading, tolerance, name, "tolerance = {real = 4, ideal = 1}");
            }
        }
        if (!read_number(file, entry, &claim->tolerance[n], NULL)) {
            return false;
        }
        if (claim->tolerance[n] < 0.0) {
            return fail(file, entry, "it is negative; accepted: 0 or more");
        }
    }
    return true;
}

/* The points of one sweep: as `at` says, else the only one, else that of the flavour. */
static bool read_at(const file_t *file, const toml_entry_t *table, uint32_t s, claim_t *claim)
{
    const experiment_t *experiment = file->experiment;
    const sweep_t *sweep = &experiment->sweeps[s];
    const toml_entry_t *at = reading_find(&file->reading, table, "at");
    const toml_entry_t *entry = at != NULL ? reading_find(&file->reading, at, sweep->name) : NULL;
    claim->at[s] = take(file, sweep->count, sizeof *claim->at[s]);
    const toml_entry_t **names = take(file, sweep->count, sizeof *names);
    if (claim->at[s] == NULL || names == NULL) {
        return false;
    }
    claim->at_count[s] = 1u;
    if (s == experiment->each_sweep) {
        return entry == NULL || fail(file, entry, "this sweep is that of `each`; accepted: the other sweeps");
    }
    if (entry == NULL) {
        return sweep->count == 1u ||
               scenario_fail(file->reading.error, reading_place(table), "at",
                             "it says nothing of the sweep %s; write for example at = {%s = \"%s\"}",
                             sweep->name, sweep->name, sweep->points[0].name);
    }
    claim->at_count[s] = list_of(file, entry, names, sweep->count);
    for (uint32_t n = 0; n < claim->at_count[s]; n++) {
        claim->at[s][n] = point_of(sweep, names[n]->text);
        if (claim->at[s][n] == sweep->count) {
            return no_point(file, names[n], sweep);
        }
    }
    return claim->at_count[s] > 0u;
}

/* All sweeps, and nothing else. */
static bool read_points(const file_t *file, const toml_entry_t *table, claim_t *claim)
{
    const experiment_t *experiment = file->experiment;
    const toml_entry_t *at = reading_find(&file->reading, table, "at");
    char names[200] = "";
    for (uint32_t s = 0; s < experiment->sweep_count; s++) {
        const size_t used = strlen(names);
        snprintf(names + used, sizeof names - used, "%s%s", s > 0u ? "|" : "", experiment->sweeps[s].name);
    }
    if (at != NULL &&
        (!reading_is_type(&file->reading, at, TOML_TABLE) ||
         !reading_only_keys(&file->reading, at, names, names[0] != '\0' ? names : "nothing: no [[sweep]]"))) {
        return false;
    }
    for (uint32_t s = 0; s < experiment->sweep_count; s++) {
        if (!read_at(file, table, s, claim)) {
            return false;
        }
    }
    return true;
}

/* What is measured: value, or `of` a measure. */
static bool read_value(const file_t *file, const toml_entry_t *table, claim_t *claim)
{
    const reading_t *reading = &file->reading;
    const toml_entry_t *measure = reading_find(reading, table, "measure");
    const toml_entry_t *of = reading_find(reading, table, "of");
    const toml_entry_t *value = reading_find(reading, table, "value");
    if ((value == NULL) == (measure == NULL) || (measure == NULL) != (of == NULL)) {
        return fail(file, table, "accepted: measure and of, or value");
    }
    if (value != NULL) {
        claim->value = value->text;
        return reading_is_text(reading, value, false);
    }
    if (!reading_is_text(reading, measure, false) || !reading_statistic(reading, of, &claim->of)) {
        return false;
    }
    claim->measure = experiment_measure_of(file->experiment, measure->text, strlen(measure->text));
    if (claim->measure == file->experiment->measure_count) {
        names_search_t search = names_search(measure->text);
        for (uint32_t n = 0; n < file->experiment->measure_count; n++) {
            names_consider(&search, file->experiment->measures[n].look.name);
        }
        const char *near = names_found(&search);
        return scenario_fail(reading->error, reading_place(measure), "measure",
                             "no [[measure]] is called \"%.60s\"%s%s", measure->text,
                             near != NULL ? "; nearest: " : "", near != NULL ? near : "");
    }
    return true;
}

static bool read_claim(const file_t *file, const toml_entry_t *entry, claim_t *claim)
{
    const reading_t *reading = &file->reading;
    if (!reading_is_type(reading, entry, TOML_TABLE) ||
        !reading_only_keys(
            reading, entry,
            "id|text|unit|measure|of|value|at|printed|theory|tolerance|holds_if|why_not|where",
            "id, text, unit, measure, of, value, at, printed, theory, tolerance, holds_if, why_not, "
            "where")) {
        return false;
    }
    const toml_entry_t *printed = reading_find(reading, entry, "printed");
    const toml_entry_t *theory = reading_find(reading, entry, "theory");
    const toml_entry_t *const expressions[] = {reading_find(reading, entry, "value"), theory,
                                               reading_find(reading, entry, "holds_if")};
    scenario_place_t *const places[] = {&claim->value_place, &claim->theory_place, &claim->holds_if_place};
    for (size_t n = 0; n < 3u; n++) {
        *places[n] = reading_place(expressions[n] != NULL ? expressions[n] : entry);
    }
    claim->why_not = printed != NULL ? "the number is another" : "the source has no number";
    claim->where = "";
    claim->printed = (double)NAN;
    claim->theory_number = (double)INFINITY;
    if (!read_needed(file, entry, "id", "id = \"accelerating\"", &claim->id) ||
        !read_needed(file, entry, "text", "text = \"error while accelerating\"", &claim->text) ||
        !read_needed(file, entry, "unit", "unit = \"mrad\"", &claim->unit) ||
        !read_value(file, entry, claim) ||
        (printed != NULL && !read_number(file, printed, &claim->printed, NULL)) ||
        (theory != NULL && !read_number(file, theory, &claim->theory_number, &claim->theory)) ||
        !read_text(file, entry, "holds_if", &claim->holds_if) ||
        !read_text(file, entry, "why_not", &claim->why_not) ||
        !read_text(file, entry, "where", &claim->where)) {
        return false;
    }
    if (printed != NULL && theory != NULL) {
        return fail(file, theory, "the claim has a printed number; accepted: one of them");
    }
    if (printed == NULL && theory == NULL && claim->holds_if == NULL) {
        return reading_missing(reading, entry, "printed",
                               "printed = 355, or theory = 350, or holds_if = \"...\"");
    }
    if ((printed != NULL || theory != NULL) && reading_find(reading, entry, "tolerance") == NULL) {
        return reading_missing(reading, entry, "tolerance", "tolerance = 10");
    }
    return read_tolerance(file, entry, claim) && read_points(file, entry, claim);
}

static bool read_claims(const file_t *file)
{
    experiment_t *experiment = file->experiment;
    bool good;
    uint32_t count;
    const toml_entry_t *array = reading_tables(&file->reading, top_of(file), "claim", &count, &good);
    experiment->claims = good ? take(file, count, sizeof *experiment->claims) : NULL;
    if (good && array == NULL) {
        return reading_missing(&file->reading, top_of(file), "claim",
                               "[[claim]] with id, text, measure, of, printed");
    }
    for (const toml_entry_t *entry = experiment->claims != NULL ? reading_first(&file->reading, array) : NULL;
         entry != NULL; entry = reading_next(&file->reading, array, entry)) {
        claim_t *claim = &experiment->claims[experiment->claim_count];
        if (!read_claim(file, entry, claim)) {
            return false;
        }
        for (uint32_t n = 0; n < experiment->claim_count; n++) {
            if (strcmp(experiment->claims[n].id, claim->id) == 0) {
                return fail(file, reading_find(&file->reading, entry, "id"),
                            "another [[claim]] has this id; accepted: each id once");
            }
        }
        experiment->claim_count++;
        if (experiment_row_count(experiment) > EXPERIMENT_ROWS_MAX) {
            return scenario_fail(file->reading.error, reading_place(entry), "claim",
                                 "claims of all flavours make more than %u rows; accepted: up to that",
                                 EXPERIMENT_ROWS_MAX);
        }
    }
    return experiment->claims != NULL;
}

/* ---- the grid ---- */

/* Points but for the flavour, as one name. */
static void name_run(const experiment_t *experiment, experiment_run_t *run)
{
    for (uint32_t s = 0; s < experiment->sweep_count; s++) {
        const char *name = experiment->sweeps[s].points[run->point[s]].name;
        if (s == experiment->each_sweep) {
            run->flavour = name;
        } else {
            const size_t used = strlen(run->name);
            snprintf(run->name + used, sizeof run->name - used, "%s%s", used > 0u ? "_" : "", name);
        }
    }
}

/* The uses of a point and its own rows. */
static void add_layers(const point_t *point, bool under, scenario_layer_t *layers, uint32_t *count)
{
    for (uint32_t n = 0; n < point->use_count; n++) {
        layers[(*count)++] = (scenario_layer_t){under, 0u, point->uses[n]->settings, point->uses[n]->count};
    }
    if (point->entry != 0u) {
        layers[(*count)++] = (scenario_layer_t){.entry = point->entry};
    } else if (point->setting.row != NULL) {
        layers[(*count)++] = (scenario_layer_t){.settings = &point->setting, .count = 1u};
    }
}

static bool add_ready(const file_t *file, experiment_run_t *run)
{
    const experiment_t *experiment = file->experiment;
    const point_t *points[SWEEPS_MAX + 1u] = {&experiment->begin};
    uint32_t all = experiment->begin.ready.count;
    for (uint32_t s = 0; s < experiment->sweep_count; s++) {
        points[s + 1u] = &experiment->sweeps[s].points[run->point[s]];
        all += points[s + 1u]->ready.count;
    }
    run->ready.settings = take(file, all, sizeof *run->ready.settings);
    for (uint32_t n = 0; n <= experiment->sweep_count && run->ready.settings != NULL; n++) {
        run->settle = isnan(points[n]->settle) ? run->settle : points[n]->settle;
        for (uint32_t k = 0; k < points[n]->ready.count; k++) {
            run->ready.settings[run->ready.count++] = points[n]->ready.settings[k];
        }
    }
    return run->ready.settings != NULL;
}

static bool read_run(const file_t *file, experiment_run_t *run)
{
    const experiment_t *experiment = file->experiment;
    scenario_layer_t layers[(SWEEPS_MAX + 1u) * 5u];
    scenario_more_t more = {.keys = KEYS, .accepted = ACCEPTED, .layers = layers};
    for (uint32_t s = 0; s < experiment->sweep_count; s++) {
        add_layers(&experiment->sweeps[s].points[run->point[s]], false, layers, &more.layer_count);
    }
    add_layers(&experiment->begin, true, layers, &more.layer_count);
    name_run(experiment, run);
    const toml_file_t *whole = file->reading.file;
    run->scenario =
        scenario_read_more(experiment->base->path, whole->source, whole->octets, &more, file->reading.error);
    if (run->scenario == NULL) {
        scenario_error_t *error = file->reading.error;
        const size_t used = strlen(error->message);
        if (run->name[0] != '\0' || run->flavour[0] != '\0') {
            snprintf(error->message + used, sizeof error->message - used, " (at %s%s%s)", run->name,
                     run->name[0] != '\0' && run->flavour[0] != '\0' ? ", " : "", run->flavour);
        }
        return false;
    }
    run->tallies = take(file, experiment->measure_count, sizeof *run->tallies);
    for (uint32_t n = 0; n < experiment->measure_count && run->tallies != NULL; n++) {
        run->tallies[n] = tally_empty();
    }
    return run->tallies != NULL && add_ready(file, run);
}

static bool read_runs(const file_t *file)
{
    experiment_t *experiment = file->experiment;
    uint32_t count = 1;
    for (uint32_t s = 0; s < experiment->sweep_count; s++) {
        count *= experiment->sweeps[s].count;
    }
    experiment->runs = take(file, count, sizeof *experiment->runs);
    while (experiment->runs != NULL && experiment->run_count < count) {
        experiment_run_t *run = &experiment->runs[experiment->run_count];
        uint32_t rest = experiment->run_count++;
        run->flavour = "";
        for (uint32_t s = 0; s < experiment->sweep_count; s++) {
            run->point[s] = rest % experiment->sweeps[s].count;
            rest /= experiment->sweeps[s].count;
        }
        if (!read_run(file, run)) {
            return false;
        }
    }
    return experiment->runs != NULL;
}

/* Every expression and condition, on runs that have not been made. */
static bool check_claims(const file_t *file)
{
    const experiment_t *experiment = file->experiment;
    for (uint32_t n = 0; n < experiment->claim_count; n++) {
        const claim_t *claim = &experiment->claims[n];
        const char *const texts[] = {claim->value, claim->theory, claim->holds_if};
        static const char *const keys[] = {"value", "theory", "holds_if"};
        const scenario_place_t places[] = {claim->value_place, claim->theory_place, claim->holds_if_place};
        uint32_t point[SWEEPS_MAX] = {0};
        char condition[640];
        for (uint32_t s = 0; s < experiment->sweep_count; s++) {
            point[s] = s == experiment->each_sweep ? experiment->each[0] : claim->at[s][0];
        }
        for (size_t t = 0; t < 3u; t++) {
            value_t value = {.experiment = experiment, .point = point, .own = 1.0};
            if (texts[t] != NULL) {
                (void)experiment_evaluate(&value, texts[t]);
            }
            if (value.why[0] != '\0') {
                return scenario_fail(file->reading.error, places[t], keys[t], "of claim %s: %s", claim->id,
                                     value.why);
            }
        }
        char why[WHY_MAX];
        if (!experiment_condition(experiment, point, condition, sizeof condition, why)) {
            const toml_entry_t *table = reading_find(&file->reading, top_of(file), "experiment");
            return fail(file, reading_find(&file->reading, table, "condition"), why);
        }
    }
    return true;
}

static bool read_all(const file_t *file)
{
    return read_begin(file, top_of(file), false, &file->experiment->begin) && read_sweeps(file) &&
           read_experiment(file) && read_measures(file) && read_trace(file) && read_claims(file) &&
           read_runs(file) && check_claims(file);
}

/* ---- the file ---- */

static experiment_t *read_file(const char *path, const char *text, size_t octets, scenario_error_t *error)
{
    const scenario_more_t more = {.keys = KEYS, .accepted = ACCEPTED, .unchecked = true};
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
