/* Reads the parts of an experiment that evaluate and write: measures, trace, table. */
#include "host_sim/lab/experiment_read.h"

#include <stdio.h>
#include <string.h>

/* ---- intervals and signals ---- */

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
    return units_read(one, of, &look->scale, &why) || file_fail(file, unit, why.text);
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
            return file_no_such(file, through, "function of a signal", experiment_through_names);
        }
    }
    return read_unit(file, reading_find(reading, entry, "unit"),
                     look->through != NULL ? look->through->unit : units_of_row(look->row), look);
}

bool file_is_word(const file_t *file, const toml_entry_t *entry, const char *name)
{
    const size_t length = strspn(name, "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_");
    return (length > 0u && name[length] == '\0' && !(name[0] >= '0' && name[0] <= '9')) ||
           scenario_fail(file->reading.error, reading_place(entry), reading_key(entry),
                         "\"%.60s\" is no plain word; accepted: letters, digits, _, a letter first", name);
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
           file_fail(file, end, "it is the same as begin; accepted: another value");
}

static bool read_measure(const file_t *file, const toml_entry_t *entry, measure_t *measure)
{
    const reading_t *reading = &file->reading;
    if (!reading_is_type(reading, entry, TOML_TABLE) ||
        !reading_only_keys(reading, entry, "name|signal|minus|through|unit|from|to|between",
                           "name, signal, minus, through, unit, from, to, between") ||
        !file_needed(file, entry, "name", "name = \"up\"", &measure->look.name) ||
        !file_is_word(file, reading_find(reading, entry, "name"), measure->look.name) ||
        !read_look(file, entry, &measure->look)) {
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
    measure->end = to != NULL ? rig_periods(measure->to) : UINT32_MAX;
    return measure->begin < measure->end ||
           file_fail(file, entry,
                     "its window contains no period; accepted: from below to, within the duration");
}

bool file_read_measures(const file_t *file)
{
    experiment_t *experiment = file->experiment;
    bool good;
    uint32_t count;
    const toml_entry_t *array = reading_tables(&file->reading, file_top(file), "measure", &count, &good);
    experiment->measures = good ? file_take(file, count, sizeof *experiment->measures) : NULL;
    const toml_entry_t *entry =
        array != NULL && experiment->measures != NULL ? reading_first(&file->reading, array) : NULL;
    for (; entry != NULL; entry = reading_next(&file->reading, array, entry)) {
        measure_t *measure = &experiment->measures[experiment->measure_count];
        if (!read_measure(file, entry, measure) || !file_is_first(file, array, entry, "name")) {
            return false;
        }
        experiment->measure_count++;
    }
    return experiment->measures != NULL;
}

bool file_read_trace(const file_t *file)
{
    const reading_t *reading = &file->reading;
    experiment_t *experiment = file->experiment;
    const toml_entry_t *trace = reading_find(reading, file_top(file), "trace");
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
        return scenario_fail(reading->error, reading_place(trace), "column",
                             "there are %u columns; accepted: 1 to %u", (unsigned)count, COLUMNS_MAX);
    }
    for (const toml_entry_t *entry = good ? reading_first(reading, columns) : NULL; entry != NULL;
         entry = reading_next(reading, columns, entry)) {
        look_t *look = &experiment->columns[experiment->column_count++];
        if (!reading_is_type(reading, entry, TOML_TABLE) ||
            !reading_only_keys(reading, entry, "name|signal|minus|through|unit",
                               "name, signal, minus, through, unit") ||
            !file_needed(file, entry, "name", "name = \"speed\"", &look->name) ||
            !read_look(file, entry, look)) {
            return false;
        }
    }
    if (reference == NULL || !good) {
        return good;
    }
    return reading_is_type(reading, reference, TOML_TABLE) &&
           reading_only_keys(reading, reference, "name|signal|unit", "name, signal, unit") &&
           file_needed(file, reference, "name", "name = \"speed_ref\"", &experiment->reference.name) &&
           read_look(file, reference, &experiment->reference) &&
           (experiment->reference.row->access != TABLE_READ ||
            file_fail(file, reference,
                      "its signal can be read, not set; accepted: a row of params, requests, plant, rig"));
}

/* ---- [table] ---- */

/* A sweep by its name; sweep_count: wrong. */
static uint32_t find_sweep(const file_t *file, const toml_entry_t *name)
{
    const experiment_t *experiment = file->experiment;
    char names[200] = "";
    uint32_t s = 0;
    while (s < experiment->sweep_count && strcmp(experiment->sweeps[s].name, name->text) != 0) {
        const size_t used = strlen(names);
        snprintf(names + used, sizeof names - used, "%s%s", s > 0u ? "|" : "", experiment->sweeps[s].name);
        s++;
    }
    if (s == experiment->sweep_count) {
        (void)file_no_such(file, name, "sweep", names);
    }
    return s;
}

static bool read_cell(const file_t *file, const toml_entry_t *entry, cell_t *cell)
{
    const reading_t *reading = &file->reading;
    if (!reading_is_type(reading, entry, TOML_TABLE) ||
        !reading_only_keys(reading, entry, "name|unit|value|sweep", "name; unit and value, or sweep") ||
        !file_needed(file, entry, "name", "name = \"peak\"", &cell->name)) {
        return false;
    }
    const toml_entry_t *value = reading_find(reading, entry, "value");
    const toml_entry_t *sweep = reading_find(reading, entry, "sweep");
    cell->place = reading_place(value != NULL ? value : entry);
    if ((value == NULL) == (sweep == NULL)) {
        return file_fail(file, entry, "accepted: unit and value, or sweep");
    }
    if (value != NULL) {
        return file_needed(file, entry, "unit", "unit = \"mrad\"", &cell->unit) &&
               file_text(file, entry, "value", &cell->value);
    }
    cell->unit = "text";
    cell->sweep =
        reading_is_text(reading, sweep, false) ? find_sweep(file, sweep) : file->experiment->sweep_count;
    return cell->sweep < file->experiment->sweep_count;
}

/* The sweeps whose points make its lines. */
static bool read_lines(const file_t *file, const toml_entry_t *lines)
{
    experiment_t *experiment = file->experiment;
    const toml_entry_t *names[SWEEPS_MAX];
    for (uint32_t s = 0; s < experiment->sweep_count; s++) {
        experiment->lines[s] = lines == NULL;
    }
    const uint32_t count = lines != NULL ? file_list(file, lines, names, SWEEPS_MAX) : 0u;
    for (uint32_t n = 0; n < count; n++) {
        const uint32_t s = find_sweep(file, names[n]);
        if (s == experiment->sweep_count) {
            return false;
        }
        experiment->lines[s] = true;
    }
    return lines == NULL || count > 0u;
}

bool file_read_table(const file_t *file)
{
    const reading_t *reading = &file->reading;
    experiment_t *experiment = file->experiment;
    const toml_entry_t *table = reading_find(reading, file_top(file), "table");
    bool good;
    uint32_t count;
    if (table == NULL) {
        return true;
    }
    if (!reading_is_type(reading, table, TOML_TABLE) ||
        !reading_only_keys(reading, table, "lines|column", "lines, column")) {
        return false;
    }
    if (experiment->column_count > 0u) {
        return file_fail(file, table, "the file has a [trace]; accepted: one of them");
    }
    const toml_entry_t *columns = reading_tables(reading, table, "column", &count, &good);
    if (good && (columns == NULL || count == 0u || count > COLUMNS_MAX)) {
        return scenario_fail(reading->error, reading_place(table), "column",
                             "there are %u columns; accepted: 1 to %u", (unsigned)count, COLUMNS_MAX);
    }
    for (const toml_entry_t *entry = good ? reading_first(reading, columns) : NULL; entry != NULL;
         entry = reading_next(reading, columns, entry)) {
        if (!read_cell(file, entry, &experiment->cells[experiment->cell_count++])) {
            return false;
        }
    }
    return good && read_lines(file, reading_find(reading, table, "lines"));
}

bool file_check_table(const file_t *file)
{
    const experiment_t *experiment = file->experiment;
    for (uint32_t n = 0; n < experiment->cell_count; n++) {
        const cell_t *cell = &experiment->cells[n];
        value_t value = {.experiment = experiment, .point = experiment->runs[0].point, .unmeasured = true};
        if (cell->value != NULL) {
            (void)experiment_evaluate(&value, cell->value);
        }
        if (value.why[0] != '\0') {
            return scenario_fail(file->reading.error, cell->place, "value", "of the column %s: %s",
                                 cell->name, value.why);
        }
    }
    return true;
}
