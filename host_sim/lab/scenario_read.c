#include "host_sim/lab/scenario.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host_sim/lab/scenario_parts.h"

typedef struct {
    const toml_file_t *file;
    scenario_t *scenario;
    scenario_error_t *error;
} reading_t;

/* ---- entries ---- */

static scenario_place_t place_of(const toml_entry_t *entry)
{
    return (scenario_place_t){entry->line, entry->column};
}

static uint32_t index_of(const reading_t *reading, const toml_entry_t *entry)
{
    return (uint32_t)(entry - reading->file->entries);
}

/* First of a table's or array's entries, and from one to the next; NULL: there is none. */
static const toml_entry_t *first_in(const reading_t *reading, const toml_entry_t *parent)
{
    return parent->end > index_of(reading, parent) + 1u ? parent + 1 : NULL;
}

static const toml_entry_t *next_in(const reading_t *reading, const toml_entry_t *parent,
                                   const toml_entry_t *entry)
{
    return entry->end < parent->end ? &reading->file->entries[entry->end] : NULL;
}

static uint32_t count_in(const reading_t *reading, const toml_entry_t *parent)
{
    uint32_t count = 0;
    for (const toml_entry_t *entry = first_in(reading, parent); entry != NULL;
         entry = next_in(reading, parent, entry)) {
        count++;
    }
    return count;
}

static const toml_entry_t *find_in(const reading_t *reading, const toml_entry_t *table, const char *key)
{
    for (const toml_entry_t *entry = first_in(reading, table); entry != NULL;
         entry = next_in(reading, table, entry)) {
        if (strcmp(entry->key, key) == 0) {
            return entry;
        }
    }
    return NULL;
}

static const char *key_of(const toml_entry_t *entry)
{
    return entry->key[0] != '\0' ? entry->key : entry->path;
}

/* ---- types ---- */

static bool is_type(const reading_t *reading, const toml_entry_t *entry, toml_type_t type)
{
    return entry->type == type ||
           scenario_fail(reading->error, place_of(entry), key_of(entry), "it is %s; accepted: %s",
                         toml_type_text(entry->type), toml_type_text(type));
}

/* Text in one line unless `lines`. */
static bool is_text(const reading_t *reading, const toml_entry_t *entry, bool lines)
{
    if (!is_type(reading, entry, TOML_TEXT)) {
        return false;
    }
    if (strlen(entry->text) != entry->text_octets) {
        return scenario_fail(reading->error, place_of(entry), key_of(entry),
                             "the text holds a NUL; accepted: text without");
    }
    for (const char *c = entry->text; *c != '\0' && !lines; c++) {
        if ((unsigned char)*c < 0x20u || *c == 0x7F) {
            return scenario_fail(reading->error, place_of(entry), key_of(entry),
                                 "accepted: text in one line");
        }
    }
    return true;
}

static bool is_whole(const reading_t *reading, const toml_entry_t *entry, int64_t min, int64_t max)
{
    if (!is_type(reading, entry, TOML_INTEGER)) {
        return false;
    }
    return (entry->integer >= min && entry->integer <= max) ||
           scenario_fail(reading->error, place_of(entry), key_of(entry),
                         "%lld is outside its range; accepted: whole numbers %lld to %lld",
                         (long long)entry->integer, (long long)min, (long long)max);
}

/* A number [unit], or text with a unit that fits. */
static bool read_quantity(const reading_t *reading, const toml_entry_t *entry, const char *unit,
                          double *value)
{
    units_error_t why;
    if (entry->type == TOML_INTEGER || entry->type == TOML_FLOAT) {
        *value = entry->number;
        return true;
    }
    if (entry->type != TOML_TEXT) {
        return scenario_fail(reading->error, place_of(entry), key_of(entry),
                             "it is %s; accepted: a number in %s, or text with a unit",
                             toml_type_text(entry->type), strcmp(unit, UNITS_SPEED) == 0 ? "rad/s" : unit);
    }
    return is_text(reading, entry, false) &&
           (units_read(entry->text, unit, value, &why) ||
            scenario_fail(reading->error, place_of(entry), key_of(entry), "%s", why.text));
}

static bool read_in_range(const reading_t *reading, const toml_entry_t *entry, const char *unit, double min,
                          double max, double *value)
{
    return read_quantity(reading, entry, unit, value) &&
           scenario_in_range(*value, min, max, unit, place_of(entry), key_of(entry), reading->error);
}

/* Value of a row, by its kind. */
static bool read_row_value(const reading_t *reading, const toml_entry_t *entry, const table_row_t *row,
                           double *value)
{
    switch (entry->type) {
    case TOML_TEXT:
        return is_text(reading, entry, false) &&
               scenario_row_text_value(row, entry->text, value, place_of(entry), reading->error);
    case TOML_INTEGER:
    case TOML_FLOAT:
        if (row->kind == SLOT_ENUM) {
            return scenario_fail(reading->error, place_of(entry), row->name,
                                 "it is a number; accepted: text, one of %s", scenario_accepted(row).text);
        }
        *value = entry->number;
        return true;
    case TOML_TABLE:
    case TOML_ARRAY:
    case TOML_BOOL:
    case TOML_TIME:
        break;
    }
    return scenario_fail(reading->error, place_of(entry), row->name, "it is %s; accepted: %s%s",
                         toml_type_text(entry->type), row->kind == SLOT_ENUM ? "text, one of " : "",
                         scenario_accepted(row).text);
}

/* ---- keys ---- */

/* Refuses what is none of the keys ("a|b|c"). A row's name tells in which table it belongs. */
static bool only_keys(const reading_t *reading, const toml_entry_t *table, const char *keys,
                      const char *accepted)
{
    for (const toml_entry_t *entry = first_in(reading, table); entry != NULL;
         entry = next_in(reading, table, entry)) {
        const size_t length = strlen(entry->key);
        bool known = false;
        for (const char *key = keys; *key != '\0' && !known;) {
            const size_t size = strcspn(key, "|");
            known = size == length && strncmp(key, entry->key, size) == 0;
            key += size + (key[size] == '|' ? 1u : 0u);
        }
        if (known) {
            continue;
        }
        names_search_t search = names_search(entry->key);
        names_consider_choices(&search, keys);
        const char *near = names_found(&search);
        scenario_error_t ignored;
        const table_row_t *row = near == NULL ? scenario_row(entry->key, &ignored) : NULL;
        if (row != NULL) {
            return scenario_fail(reading->error, place_of(entry), entry->key, "no such %s here%s",
                                 entry->type == TOML_TABLE ? "table" : "key",
                                 scenario_near_row(entry->key, rig_table(0)).text);
        }
        return scenario_fail(reading->error, place_of(entry), entry->key, "no such %s%s%s; accepted: %s",
                             entry->type == TOML_TABLE ? "table" : "key", near != NULL ? "; nearest: " : "",
                             near != NULL ? near : "", accepted);
    }
    return true;
}

static bool missing(const reading_t *reading, const toml_entry_t *table, const char *key, const char *example)
{
    return scenario_fail(reading->error, place_of(table), key, "it is missing; write for example %s",
                         example);
}

/* ---- rows of params, requests, plant, rig ---- */

static int compare_places(const scenario_place_t *a, const scenario_place_t *b)
{
    if (a->line != b->line) {
        return a->line < b->line ? -1 : 1;
    }
    return (a->column > b->column) - (a->column < b->column);
}

static int by_place(const void *a, const void *b)
{
    const scenario_setting_t *x = a;
    const scenario_setting_t *y = b;
    return compare_places(&x->place, &y->place);
}

static bool read_rows(const reading_t *reading, const toml_entry_t *section, scenario_event_t *event)
{
    const table_t *table = scenario_table(section->key);
    for (const toml_entry_t *entry = first_in(reading, section); entry != NULL;
         entry = next_in(reading, section, entry)) {
        const table_row_t *row = table_by_name(table, entry->key);
        double value = 0.0;
        if (row == NULL) {
            return scenario_fail(reading->error, place_of(entry), entry->key, "no such row in %s%s",
                                 table->name, scenario_near_row(entry->key, table).text);
        }
        if (!read_row_value(reading, entry, row, &value) ||
            !scenario_row_accepts(row, value, place_of(entry), reading->error)) {
            return false;
        }
        event->settings[event->count++] = (scenario_setting_t){row, value, place_of(entry)};
    }
    return true;
}

/* The sections among a table's entries, into an event with room for `room` settings or for all of these. */
static bool read_sections(const reading_t *reading, const toml_entry_t *table, scenario_event_t *event,
                          uint32_t room)
{
    uint32_t count = 0;
    for (size_t n = 0; n < SCENARIO_SETTABLE; n++) {
        const toml_entry_t *section = find_in(reading, table, scenario_settable[n]);
        if (section != NULL && !is_type(reading, section, TOML_TABLE)) {
            return false;
        }
        count += section != NULL ? count_in(reading, section) : 0u;
    }
    event->settings =
        scenario_take(reading->scenario, (count > room ? count : room) * sizeof *event->settings);
    if (event->settings == NULL) {
        return scenario_no_memory(reading->error);
    }
    for (size_t n = 0; n < SCENARIO_SETTABLE; n++) {
        const toml_entry_t *section = find_in(reading, table, scenario_settable[n]);
        if (section != NULL && !read_rows(reading, section, event)) {
            return false;
        }
    }
    if (event->count > 1u) {
        qsort(event->settings, event->count, sizeof *event->settings, by_place);
    }
    return true;
}

/* ---- the parts of a file ---- */

static bool read_head(const reading_t *reading, const toml_entry_t *top)
{
    scenario_t *scenario = reading->scenario;
    const toml_entry_t *schema = find_in(reading, top, "schema");
    const toml_entry_t *title = find_in(reading, top, "title");
    const toml_entry_t *text = find_in(reading, top, "text");
    if (schema == NULL) {
        return missing(reading, top, "schema", "schema = 1");
    }
    if (!is_type(reading, schema, TOML_INTEGER)) {
        return false;
    }
    if (schema->integer != 1) {
        return scenario_fail(reading->error, place_of(schema), "schema",
                             "%lld is not known to this program; accepted: 1", (long long)schema->integer);
    }
    if (title == NULL) {
        return missing(reading, top, "title", "title = \"Load step at 500 r/min\"");
    }
    if (!is_text(reading, title, false) || (text != NULL && !is_text(reading, text, true))) {
        return false;
    }
    if (title->text_octets == 0u || title->text_octets > SCENARIO_TITLE_MAX) {
        return scenario_fail(reading->error, place_of(title), "title",
                             "it has %llu octets; accepted: 1 to %u", (unsigned long long)title->text_octets,
                             SCENARIO_TITLE_MAX);
    }
    scenario->title = title->text;
    scenario->text = text != NULL ? text->text : "";
    return true;
}

static bool read_record(const reading_t *reading, const toml_entry_t *record)
{
    scenario_t *scenario = reading->scenario;
    if (!is_type(reading, record, TOML_ARRAY)) {
        return false;
    }
    for (const toml_entry_t *entry = first_in(reading, record); entry != NULL;
         entry = next_in(reading, record, entry)) {
        if (!is_text(reading, entry, false)) {
            return false;
        }
        const table_row_t *row = scenario_row(entry->text, reading->error);
        if (row == NULL) {
            reading->error->place = place_of(entry);
            return false;
        }
        for (uint32_t n = 0; n < scenario->record_count; n++) {
            if (scenario->record[n] == row->id) {
                return scenario_fail(reading->error, place_of(entry), entry->text,
                                     "it is in the list already; accepted: each row once");
            }
        }
        if (scenario->record_count == RIG_TAP_MAX) {
            return scenario_fail(reading->error, place_of(entry), entry->text,
                                 "too many rows; accepted: up to %u", RIG_TAP_MAX);
        }
        scenario->record[scenario->record_count++] = row->id;
    }
    return true;
}

static bool read_run(const reading_t *reading, const toml_entry_t *top)
{
    scenario_t *scenario = reading->scenario;
    const toml_entry_t *run = find_in(reading, top, "run");
    if (run == NULL) {
        return missing(reading, top, "run", "[run] with duration = \"2 s\"");
    }
    if (!is_type(reading, run, TOML_TABLE) ||
        !only_keys(reading, run, "duration|seed|record|decimation", "duration, seed, record, decimation")) {
        return false;
    }
    const toml_entry_t *duration = find_in(reading, run, "duration");
    const toml_entry_t *seed = find_in(reading, run, "seed");
    const toml_entry_t *record = find_in(reading, run, "record");
    const toml_entry_t *decimation = find_in(reading, run, "decimation");
    if (duration == NULL) {
        return missing(reading, run, "duration", "duration = \"2 s\"");
    }
    scenario->duration_place = place_of(duration);
    if (!read_in_range(reading, duration, "s", SCENARIO_SECONDS_MIN, SCENARIO_SECONDS_MAX,
                       &scenario->duration) ||
        (seed != NULL && !is_whole(reading, seed, 0, INT64_MAX)) ||
        (decimation != NULL && !is_whole(reading, decimation, 1, SCENARIO_DECIMATION_MAX)) ||
        (record != NULL && !read_record(reading, record))) {
        return false;
    }
    scenario->seed = seed != NULL ? (uint64_t)seed->integer : 1u;
    scenario->decimation = decimation != NULL ? (uint32_t)decimation->integer : 1u;
    return true;
}

static bool read_start(const reading_t *reading, const toml_entry_t *top)
{
    scenario_t *scenario = reading->scenario;
    const toml_entry_t *start = find_in(reading, top, "start");
    if (start == NULL) {
        return true;
    }
    if (!is_type(reading, start, TOML_TABLE) || !only_keys(reading, start, "speed|angle", "speed, angle")) {
        return false;
    }
    const toml_entry_t *speed = find_in(reading, start, "speed");
    const toml_entry_t *angle = find_in(reading, start, "angle");
    scenario->has_start = speed != NULL || angle != NULL;
    scenario->has_start_speed = speed != NULL;
    scenario->start_place = place_of(start);
    return (speed == NULL || read_in_range(reading, speed, UNITS_SPEED, -SCENARIO_SPEED_MAX,
                                           SCENARIO_SPEED_MAX, &scenario->start_speed)) &&
           (angle == NULL || read_in_range(reading, angle, "rad", -SCENARIO_ANGLE_MAX, SCENARIO_ANGLE_MAX,
                                           &scenario->start_angle));
}

static uint32_t settable_rows(void)
{
    uint32_t count = 0;
    for (size_t n = 0; n < SCENARIO_SETTABLE; n++) {
        count += scenario_table(scenario_settable[n])->count;
    }
    return count;
}

/* Its range is judged later, when the duration is final. */
static bool read_time(const reading_t *reading, const toml_entry_t *entry, double *seconds)
{
    return read_quantity(reading, entry, "s", seconds) &&
           (isfinite(*seconds) || scenario_in_range(*seconds, 0.0, reading->scenario->duration, "s",
                                                    place_of(entry), key_of(entry), reading->error));
}

static bool read_event(const reading_t *reading, const toml_entry_t *entry, scenario_event_t *event)
{
    if (!is_type(reading, entry, TOML_TABLE) ||
        !only_keys(reading, entry, "time|ramp|params|requests|plant|rig",
                   "time, ramp, and rows as params.ROW, requests.ROW, plant.ROW, rig.ROW")) {
        return false;
    }
    const toml_entry_t *time = find_in(reading, entry, "time");
    const toml_entry_t *ramp = find_in(reading, entry, "ramp");
    if (time == NULL) {
        return missing(reading, entry, "time", "time = \"0.5 s\"");
    }
    event->time_place = place_of(time);
    event->ramp_place = place_of(ramp != NULL ? ramp : time);
    if (!read_time(reading, time, &event->time) ||
        (ramp != NULL && !read_time(reading, ramp, &event->ramp)) ||
        !read_sections(reading, entry, event, 0u)) {
        return false;
    }
    if (event->count == 0u) {
        return scenario_fail(
            reading->error, place_of(entry), "at",
            "it sets nothing; accepted: rows as params.ROW, requests.ROW, plant.ROW, rig.ROW");
    }
    return true;
}

/* Events of one time stay in the order of the file. */
static int by_time(const void *a, const void *b)
{
    const scenario_event_t *x = a;
    const scenario_event_t *y = b;
    return x->time != y->time ? (x->time < y->time ? -1 : 1) : compare_places(&x->time_place, &y->time_place);
}

/* An array of tables; NULL and *count 0: there is none. false in *good: it is something else. */
static const toml_entry_t *tables_of(const reading_t *reading, const toml_entry_t *top, const char *key,
                                     uint32_t *count, bool *good)
{
    const toml_entry_t *array = find_in(reading, top, key);
    *count = 0;
    *good = true;
    if (array == NULL) {
        return NULL;
    }
    if (array->type != TOML_ARRAY) {
        *good =
            scenario_fail(reading->error, place_of(array), key,
                          "it is %s; accepted: [[%s]], as often as needed", toml_type_text(array->type), key);
        return NULL;
    }
    *count = count_in(reading, array);
    return array;
}

static bool read_events(const reading_t *reading, const toml_entry_t *top)
{
    scenario_t *scenario = reading->scenario;
    bool good;
    uint32_t count;
    const toml_entry_t *array = tables_of(reading, top, "at", &count, &good);
    if (!good) {
        return false;
    }
    scenario->events = scenario_take(scenario, (1u + count) * sizeof *scenario->events);
    if (scenario->events == NULL) {
        return scenario_no_memory(reading->error);
    }
    scenario->event_count = 1u;
    if (!read_sections(reading, top, &scenario->events[0], settable_rows())) {
        return false;
    }
    const toml_entry_t *entry = array != NULL ? first_in(reading, array) : NULL;
    for (; entry != NULL; entry = next_in(reading, array, entry)) {
        if (!read_event(reading, entry, &scenario->events[scenario->event_count])) {
            return false;
        }
        scenario->event_count++;
    }
    if (count > 1u) {
        qsort(&scenario->events[1], count, sizeof *scenario->events, by_time);
    }
    return true;
}

/* ---- expectations ---- */

static bool read_signal(const reading_t *reading, const toml_entry_t *entry, const table_row_t **row)
{
    if (!is_text(reading, entry, false)) {
        return false;
    }
    *row = scenario_row(entry->text, reading->error);
    reading->error->place = place_of(entry);
    return *row != NULL;
}

static bool read_statistic(const reading_t *reading, const toml_entry_t *entry, statistic_t *statistic)
{
    if (!is_text(reading, entry, false)) {
        return false;
    }
    for (statistic_t n = STATISTIC_MEAN; n < STATISTICS; n++) {
        if (strcmp(entry->text, statistic_text(n)) == 0) {
            *statistic = n;
            return true;
        }
    }
    names_search_t search = names_search(entry->text);
    names_consider_choices(&search, STATISTIC_NAMES);
    const char *near = names_found(&search);
    return scenario_fail(reading->error, place_of(entry), "statistic",
                         "there is no \"%.60s\"%s%s; accepted: mean, min, max, peak, sd, rms, last",
                         entry->text, near != NULL ? "; nearest: " : "", near != NULL ? near : "");
}

/* A limit is a value of the signal, but a mean of choices is a number. */
static bool read_limit(const reading_t *reading, const toml_entry_t *entry, const table_row_t *row,
                       double *limit)
{
    double value = 0.0;
    if (entry->type == TOML_TEXT && row->kind == SLOT_ENUM) {
        if (!read_row_value(reading, entry, row, &value)) {
            snprintf(reading->error->name, sizeof reading->error->name, "%s", entry->key);
            return false;
        }
    } else if (!read_quantity(reading, entry, row->kind == SLOT_ENUM ? "-" : units_of_row(row), &value)) {
        return false;
    }
    if (!isfinite(value)) {
        return scenario_fail(reading->error, place_of(entry), entry->key,
                             "%s is no finite number; leave a limit out to have none",
                             isnan(value) ? "nan" : "inf");
    }
    *limit = value;
    return true;
}

static bool read_limits(const reading_t *reading, const toml_entry_t *entry, scenario_expect_t *expect)
{
    const toml_entry_t *at_least = find_in(reading, entry, "at_least");
    const toml_entry_t *at_most = find_in(reading, entry, "at_most");
    expect->at_least = -(double)INFINITY;
    expect->at_most = (double)INFINITY;
    if (at_least == NULL && at_most == NULL) {
        return scenario_fail(reading->error, place_of(entry), "at_least",
                             "it is missing; give at_least, at_most or both");
    }
    if ((at_least != NULL && !read_limit(reading, at_least, expect->row, &expect->at_least)) ||
        (at_most != NULL && !read_limit(reading, at_most, expect->row, &expect->at_most))) {
        return false;
    }
    if (expect->at_least > expect->at_most) {
        char low[UNITS_TEXT_SIZE];
        char high[UNITS_TEXT_SIZE];
        return scenario_fail(reading->error, place_of(at_least), "at_least",
                             "%s is above at_most, %s: no value is both",
                             units_row_text(low, expect->at_least, expect->row),
                             units_row_text(high, expect->at_most, expect->row));
    }
    return true;
}

static bool read_window(const reading_t *reading, const toml_entry_t *entry, scenario_expect_t *expect)
{
    const toml_entry_t *from = find_in(reading, entry, "from");
    const toml_entry_t *to = find_in(reading, entry, "to");
    expect->to_the_end = to == NULL;
    expect->from_place = place_of(from != NULL ? from : entry);
    expect->to_place = place_of(to != NULL ? to : entry);
    return (from == NULL || read_time(reading, from, &expect->from)) &&
           (to == NULL || read_time(reading, to, &expect->to));
}

static bool read_expect(const reading_t *reading, const toml_entry_t *entry, scenario_expect_t *expect)
{
    if (!is_type(reading, entry, TOML_TABLE) ||
        !only_keys(reading, entry, "name|signal|minus|statistic|from|to|at_least|at_most",
                   "signal, minus, statistic, from, to, at_least, at_most, name")) {
        return false;
    }
    const toml_entry_t *name = find_in(reading, entry, "name");
    const toml_entry_t *signal = find_in(reading, entry, "signal");
    const toml_entry_t *minus = find_in(reading, entry, "minus");
    const toml_entry_t *statistic = find_in(reading, entry, "statistic");
    expect->place = place_of(entry);
    if (signal == NULL) {
        return missing(reading, entry, "signal", "signal = \"true_omega_m\"");
    }
    if (statistic == NULL) {
        return missing(reading, entry, "statistic", "statistic = \"mean\"");
    }
    if ((name != NULL && !is_text(reading, name, false)) || !read_signal(reading, signal, &expect->row) ||
        (minus != NULL && !read_signal(reading, minus, &expect->minus)) ||
        !read_statistic(reading, statistic, &expect->statistic) || !read_window(reading, entry, expect)) {
        return false;
    }
    expect->name = name != NULL ? name->text : "";
    if (expect->minus != NULL && strcmp(units_of_row(expect->minus), units_of_row(expect->row)) != 0) {
        return scenario_fail(reading->error, place_of(minus), minus->text,
                             "its unit is %s, that of %s is %s; accepted: rows of one unit%s",
                             expect->minus->unit, signal->text, expect->row->unit,
                             strcmp(expect->minus->unit, expect->row->unit) == 0 ? " (one is mechanical)"
                                                                                 : "");
    }
    return read_limits(reading, entry, expect);
}

static bool read_expects(const reading_t *reading, const toml_entry_t *top)
{
    scenario_t *scenario = reading->scenario;
    bool good;
    uint32_t count;
    const toml_entry_t *array = tables_of(reading, top, "expect", &count, &good);
    if (!good || array == NULL) {
        return good;
    }
    scenario->expects = scenario_take(scenario, count * sizeof *scenario->expects);
    if (scenario->expects == NULL) {
        return scenario_no_memory(reading->error);
    }
    for (const toml_entry_t *entry = first_in(reading, array); entry != NULL;
         entry = next_in(reading, array, entry)) {
        if (!read_expect(reading, entry, &scenario->expects[scenario->expect_count])) {
            return false;
        }
        scenario->expect_count++;
    }
    return true;
}

/* ---- the file ---- */

/* What the tap can carry at once: rows of `record` and of [[expect]] together. */
static bool check_tap(const reading_t *reading)
{
    const scenario_t *scenario = reading->scenario;
    uint32_t ids[RIG_TAP_MAX];
    uint32_t count = scenario->record_count;
    memcpy(ids, scenario->record, sizeof ids);
    for (uint32_t n = 0; n < scenario->expect_count; n++) {
        const scenario_expect_t *expect = &scenario->expects[n];
        const table_row_t *rows[2] = {expect->row, expect->minus};
        for (size_t side = 0; side < 2u && rows[side] != NULL; side++) {
            uint32_t at = 0;
            while (at < count && ids[at] != rows[side]->id) {
                at++;
            }
            if (at == RIG_TAP_MAX) {
                return scenario_fail(
                    reading->error, expect->place, rows[side]->name,
                    "too many rows in record and [[expect]] together; accepted: up to %u different ones",
                    RIG_TAP_MAX);
            }
            if (at == count) {
                ids[count++] = rows[side]->id;
            }
        }
    }
    return true;
}

static bool read_all(const reading_t *reading)
{
    const toml_entry_t *top = &reading->file->entries[0];
    return only_keys(reading, top, "schema|title|text|run|start|params|requests|plant|rig|at|expect",
                     "schema, title, text, [run], [start], [params], [requests], [plant], [rig], [[at]], "
                     "[[expect]]") &&
           read_head(reading, top) && read_run(reading, top) && read_start(reading, top) &&
           read_events(reading, top) && read_expects(reading, top) && check_tap(reading) &&
           scenario_check(reading->scenario, reading->error);
}

static scenario_t *scenario_of(const char *path, toml_file_t *file, const toml_error_t *why,
                               scenario_error_t *error)
{
    if (file == NULL) {
        scenario_fail(error, (scenario_place_t){why->line, why->column}, why->name, "%s", why->message);
        return NULL;
    }
    scenario_t *scenario = calloc(1, sizeof *scenario);
    struct scenario_memory *memory = calloc(1, sizeof *memory);
    if (scenario == NULL || memory == NULL) {
        free(scenario);
        free(memory);
        toml_free(file);
        scenario_no_memory(error);
        return NULL;
    }
    scenario->memory = memory;
    memory->file = file;
    scenario->source = file->source;

    const size_t length = strlen(path);
    char *own_path = scenario_take(scenario, length + 1u);
    const reading_t reading = {file, scenario, error};
    if (own_path != NULL) {
        memcpy(own_path, path, length + 1u);
        scenario->path = own_path;
    }
    if (own_path != NULL ? read_all(&reading) : scenario_no_memory(error)) {
        return scenario;
    }
    scenario_free(scenario);
    return NULL;
}

/* Whatever went wrong below, the message names the file. */
static scenario_t *in_file(const char *path, scenario_t *scenario, scenario_error_t *error)
{
    if (scenario == NULL) {
        size_t n = 0;
        for (; path[n] != '\0' && n + 1u < sizeof error->file; n++) {
            error->file[n] = (unsigned char)path[n] < 0x20u || path[n] == 0x7F ? ' ' : path[n];
        }
        error->file[n] = '\0';
    }
    return scenario;
}

scenario_t *scenario_read(const char *path, scenario_error_t *error)
{
    toml_error_t why;
    toml_file_t *file = toml_read(path, &why);
    return in_file(path, scenario_of(path, file, &why, error), error);
}

scenario_t *scenario_read_text(const char *path, const char *text, size_t octets, scenario_error_t *error)
{
    toml_error_t why;
    toml_file_t *file = toml_read_text(text, octets, &why);
    return in_file(path, scenario_of(path, file, &why, error), error);
}
