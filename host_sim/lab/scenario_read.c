#include "host_sim/lab/scenario.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host_sim/lab/boards.h"
#include "host_sim/lab/motor.h"
#include "host_sim/lab/scenario_parts.h"
#include "host_sim/lab/tune.h"

/* A value is wrong; the error has the reason. true: the error is kept, and reading continues. */
static bool refuse_later(const reading_t *reading, const table_row_t *row, const char *key)
{
    if (!reading->to_mend) {
        return false;
    }
    scenario_refusal_t *refusal = scenario_take(reading->scenario, sizeof *refusal);
    if (refusal == NULL) {
        return scenario_no_memory(reading->error);
    }
    *refusal = (scenario_refusal_t){.row = row, .key = key, .error = *reading->error};
    scenario_refusal_t **at = &reading->scenario->memory->refused;
    while (*at != NULL) {
        at = &(*at)->next;
    }
    *at = refusal;
    return true;
}

/* ---- entries ---- */

scenario_place_t reading_place(const toml_entry_t *entry)
{
    return (scenario_place_t){entry->line, entry->column};
}

static uint32_t index_of(const reading_t *reading, const toml_entry_t *entry)
{
    return (uint32_t)(entry - reading->file->entries);
}

/* First of a table's or array's entries, and from one to the next; NULL: there is none. */
const toml_entry_t *reading_first(const reading_t *reading, const toml_entry_t *parent)
{
    return parent->end > index_of(reading, parent) + 1u ? parent + 1 : NULL;
}

const toml_entry_t *reading_next(const reading_t *reading, const toml_entry_t *parent,
                                 const toml_entry_t *entry)
{
    return entry->end < parent->end ? &reading->file->entries[entry->end] : NULL;
}

uint32_t reading_count(const reading_t *reading, const toml_entry_t *parent)
{
    uint32_t count = 0;
    for (const toml_entry_t *entry = reading_first(reading, parent); entry != NULL;
         entry = reading_next(reading, parent, entry)) {
        count++;
    }
    return count;
}

const toml_entry_t *reading_find(const reading_t *reading, const toml_entry_t *table, const char *key)
{
    for (const toml_entry_t *entry = reading_first(reading, table); entry != NULL;
         entry = reading_next(reading, table, entry)) {
        if (strcmp(entry->key, key) == 0) {
            return entry;
        }
    }
    return NULL;
}

const char *reading_key(const toml_entry_t *entry)
{
    return entry->key[0] != '\0' ? entry->key : entry->path;
}

/* ---- types ---- */

bool reading_is_type(const reading_t *reading, const toml_entry_t *entry, toml_type_t type)
{
    return entry->type == type ||
           scenario_fail(reading->error, reading_place(entry), reading_key(entry), "it is %s; accepted: %s",
                         toml_type_text(entry->type), toml_type_text(type));
}

/* Text in one line unless `lines`. */
bool reading_is_text(const reading_t *reading, const toml_entry_t *entry, bool lines)
{
    if (!reading_is_type(reading, entry, TOML_TEXT)) {
        return false;
    }
    if (strlen(entry->text) != entry->text_octets) {
        return scenario_fail(reading->error, reading_place(entry), reading_key(entry),
                             "the text contains a NUL character; accepted: text without");
    }
    for (const char *c = entry->text; *c != '\0' && !lines; c++) {
        if ((unsigned char)*c < 0x20u || *c == 0x7F) {
            return scenario_fail(reading->error, reading_place(entry), reading_key(entry),
                                 "accepted: text in one line");
        }
    }
    return true;
}

bool reading_is_whole(const reading_t *reading, const toml_entry_t *entry, int64_t min, int64_t max)
{
    if (!reading_is_type(reading, entry, TOML_INTEGER)) {
        return false;
    }
    return (entry->integer >= min && entry->integer <= max) ||
           scenario_fail(reading->error, reading_place(entry), reading_key(entry),
                         "%lld is outside its range; accepted: whole numbers %lld to %lld",
                         (long long)entry->integer, (long long)min, (long long)max);
}

/* A number [unit], or text with a unit that fits. */
bool reading_quantity(const reading_t *reading, const toml_entry_t *entry, const char *unit, double *value)
{
    units_error_t why;
    if (entry->type == TOML_INTEGER || entry->type == TOML_FLOAT) {
        *value = entry->number;
        return true;
    }
    if (entry->type != TOML_TEXT) {
        return scenario_fail(reading->error, reading_place(entry), reading_key(entry),
                             "it is %s; accepted: a number in %s, or text with a unit",
                             toml_type_text(entry->type), strcmp(unit, UNITS_SPEED) == 0 ? "rad/s" : unit);
    }
    return reading_is_text(reading, entry, false) &&
           (units_read(entry->text, unit, value, &why) ||
            scenario_fail(reading->error, reading_place(entry), reading_key(entry), "%s", why.text));
}

bool reading_in_range(const reading_t *reading, const toml_entry_t *entry, const char *unit, double min,
                      double max, double *value)
{
    return reading_quantity(reading, entry, unit, value) &&
           scenario_in_range(*value, min, max, unit, reading_place(entry), reading_key(entry),
                             reading->error);
}

/* Value of a row, by its kind. */
bool reading_row_value(const reading_t *reading, const toml_entry_t *entry, const table_row_t *row,
                       double *value)
{
    switch (entry->type) {
    case TOML_TEXT:
        return reading_is_text(reading, entry, false) &&
               scenario_row_text_value(row, entry->text, value, reading_place(entry), reading->error);
    case TOML_INTEGER:
    case TOML_FLOAT:
        if (row->kind == SLOT_ENUM) {
            return scenario_fail(reading->error, reading_place(entry), row->name,
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
    return scenario_fail(reading->error, reading_place(entry), row->name, "it is %s; accepted: %s%s",
                         toml_type_text(entry->type), row->kind == SLOT_ENUM ? "text, one of " : "",
                         scenario_accepted(row).text);
}

/* ---- keys ---- */

/* True if an entry's key is one of these ("a|b|c"). */
static bool is_one_of(const toml_entry_t *entry, const char *keys)
{
    const size_t length = strlen(entry->key);
    for (const char *key = keys; *key != '\0';) {
        const size_t size = strcspn(key, "|");
        if (size == length && strncmp(key, entry->key, size) == 0) {
            return true;
        }
        key += size + (key[size] == '|' ? 1u : 0u);
    }
    return false;
}

/* Refuses an entry whose key is not accepted. If the key is the name of a row, the message names its table.
 * */
static bool refuse_key(const reading_t *reading, const toml_entry_t *entry, const char *keys,
                       const char *accepted)
{
    names_search_t search = names_search(entry->key);
    names_consider_choices(&search, keys);
    const char *near = names_found(&search);
    scenario_error_t ignored;
    const table_row_t *row = near == NULL ? scenario_row(entry->key, &ignored) : NULL;
    if (row != NULL) {
        return scenario_fail(reading->error, reading_place(entry), entry->key, "no such %s here%s",
                             entry->type == TOML_TABLE ? "table" : "key",
                             scenario_near_row(entry->key, rig_table(0)).text);
    }
    return scenario_fail(reading->error, reading_place(entry), entry->key, "no such %s%s%s; accepted: %s",
                         entry->type == TOML_TABLE ? "table" : "key", near != NULL ? "; nearest: " : "",
                         near != NULL ? near : "", accepted);
}

/* Refuses an entry whose key is not in the list ("a|b|c"). */
bool reading_only_keys(const reading_t *reading, const toml_entry_t *table, const char *keys,
                       const char *accepted)
{
    for (const toml_entry_t *entry = reading_first(reading, table); entry != NULL;
         entry = reading_next(reading, table, entry)) {
        if (!is_one_of(entry, keys)) {
            return refuse_key(reading, entry, keys, accepted);
        }
    }
    return true;
}

bool reading_missing(const reading_t *reading, const toml_entry_t *table, const char *key,
                     const char *example)
{
    return scenario_fail(reading->error, reading_place(table), key, "it is missing; write for example %s",
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

/* `flux_map = "map.csv"`, in the folder of the scenario: returns the number of the map. */
static bool read_flux_map(const reading_t *reading, const toml_entry_t *entry, const table_row_t *row,
                          double *value)
{
    char path[4096];
    const char *slash = strrchr(reading->scenario->path, '/');
    const int folder =
        entry->text[0] != '/' && slash != NULL ? (int)(slash + 1 - reading->scenario->path) : 0;
    snprintf(path, sizeof path, "%.*s%s", folder, reading->scenario->path, entry->text);
    return reading_is_text(reading, entry, false) &&
           scenario_row_text_value(row, path, value, reading_place(entry), reading->error);
}

/* The value of a row, appended to an event that has room for it. */
static bool read_row(const reading_t *reading, const toml_entry_t *entry, const table_row_t *row,
                     scenario_event_t *event)
{
    const bool initial = event == &reading->scenario->events[0];
    double value = 0.0;
    const bool is_map = rig_is_flux_map(row) && entry->type == TOML_TEXT;
    if ((!(is_map ? read_flux_map(reading, entry, row, &value)
                  : reading_row_value(reading, entry, row, &value)) ||
         !scenario_row_accepts(row, value, reading_place(entry), reading->error)) &&
        !(initial && refuse_later(reading, row, NULL))) {
        return false;
    }
    event->settings[event->count++] = (scenario_setting_t){row, value, reading_place(entry)};
    return true;
}

static bool read_rows(const reading_t *reading, const toml_entry_t *section, scenario_event_t *event)
{
    const table_t *table = scenario_table(section->key);
    for (const toml_entry_t *entry = reading_first(reading, section); entry != NULL;
         entry = reading_next(reading, section, entry)) {
        const table_row_t *row = table_by_name(table, entry->key);
        if (row == NULL) {
            return scenario_fail(reading->error, reading_place(entry), entry->key, "no such row in %s%s",
                                 table->name, scenario_near_row(entry->key, table).text);
        }
        if (!read_row(reading, entry, row, event)) {
            return false;
        }
    }
    return true;
}

/* Reads the sections among a table's entries into an event. The event gets space for `room` settings, or for
 * one setting of each entry if that is more. */
bool reading_sections(const reading_t *reading, const toml_entry_t *table, scenario_event_t *event,
                      uint32_t room)
{
    uint32_t count = reading_count(reading, table);
    for (size_t n = 0; n < SCENARIO_SETTABLE; n++) {
        const toml_entry_t *section = reading_find(reading, table, scenario_settable[n]);
        if (section != NULL && !reading_is_type(reading, section, TOML_TABLE)) {
            return false;
        }
        count += section != NULL ? reading_count(reading, section) : 0u;
    }
    event->settings =
        scenario_take(reading->scenario, (count > room ? count : room) * sizeof *event->settings);
    if (event->settings == NULL) {
        return scenario_no_memory(reading->error);
    }
    for (size_t n = 0; n < SCENARIO_SETTABLE; n++) {
        const toml_entry_t *section = reading_find(reading, table, scenario_settable[n]);
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

/* A scenario for another board is read by that board's program. */
static bool read_board(const reading_t *reading, const toml_entry_t *board)
{
    char why[BOARDS_TEXT_SIZE];
    if (!reading_is_text(reading, board, false)) {
        return false;
    }
    if (strcmp(board->text, rig_board) == 0) {
        return true;
    }
    const board_facts_t *other = boards_find(board->text, why);
    if (other == NULL) {
        return scenario_fail(reading->error, reading_place(board), "board", "%s", why);
    }
    scenario_fail(reading->error, reading_place(board), "board",
                  "the scenario is for board %s, and %s is chosen; accepted: the same board in both, or only "
                  "one of them",
                  other->name, rig_board);
    snprintf(reading->error->board, sizeof reading->error->board, "%s", other->name);
    return false;
}

static bool read_head(const reading_t *reading, const toml_entry_t *top)
{
    scenario_t *scenario = reading->scenario;
    const toml_entry_t *schema = reading_find(reading, top, "schema");
    const toml_entry_t *title = reading_find(reading, top, "title");
    const toml_entry_t *text = reading_find(reading, top, "text");
    if (schema == NULL) {
        return reading_missing(reading, top, "schema", "schema = 1");
    }
    if (!reading_is_type(reading, schema, TOML_INTEGER)) {
        return false;
    }
    if (schema->integer != 1) {
        return scenario_fail(reading->error, reading_place(schema), "schema",
                             "%lld is not known to this program; accepted: 1", (long long)schema->integer);
    }
    if (title == NULL) {
        return reading_missing(reading, top, "title", "title = \"Load step at 500 r/min\"");
    }
    if (!reading_is_text(reading, title, false) || (text != NULL && !reading_is_text(reading, text, true))) {
        return false;
    }
    if (title->text_octets == 0u || title->text_octets > SCENARIO_TITLE_MAX) {
        return scenario_fail(reading->error, reading_place(title), "title",
                             "it has %llu octets; accepted: 1 to %u", (unsigned long long)title->text_octets,
                             SCENARIO_TITLE_MAX);
    }
    scenario->title = title->text;
    scenario->text = text != NULL ? text->text : "";
    scenario->unsuited = "";
    const toml_entry_t *board = reading_find(reading, top, "board");
    return board == NULL || read_board(reading, board);
}

static bool read_record(const reading_t *reading, const toml_entry_t *record)
{
    scenario_t *scenario = reading->scenario;
    if (!reading_is_type(reading, record, TOML_ARRAY)) {
        return false;
    }
    for (const toml_entry_t *entry = reading_first(reading, record); entry != NULL;
         entry = reading_next(reading, record, entry)) {
        if (!reading_is_text(reading, entry, false)) {
            return false;
        }
        const table_row_t *row = scenario_row(entry->text, reading->error);
        if (row == NULL) {
            reading->error->place = reading_place(entry);
            return false;
        }
        for (uint32_t n = 0; n < scenario->record_count; n++) {
            if (scenario->record[n] == row->id) {
                return scenario_fail(reading->error, reading_place(entry), entry->text,
                                     "it is in the list already; accepted: each row once");
            }
        }
        if (scenario->record_count == RIG_TAP_MAX) {
            return scenario_fail(reading->error, reading_place(entry), entry->text,
                                 "too many rows; accepted: up to %u", RIG_TAP_MAX);
        }
        scenario->record[scenario->record_count++] = row->id;
    }
    return true;
}

static bool read_run(const reading_t *reading, const toml_entry_t *top)
{
    scenario_t *scenario = reading->scenario;
    const toml_entry_t *run = reading_find(reading, top, "run");
    if (run == NULL && reading->more->keys != NULL && reading_find(reading, top, "measure") == NULL) {
        /* without a run nothing is measured */
        scenario->duration = SCENARIO_SECONDS_MIN;
        scenario->every = 1u;
        scenario->seed = 1u;
        return true;
    }
    if (run == NULL) {
        return reading_missing(reading, top, "run", "[run] with duration = \"2 s\"");
    }
    const toml_entry_t *old =
        reading_is_type(reading, run, TOML_TABLE) ? reading_find(reading, run, "decimation") : NULL;
    if (old != NULL) {
        return scenario_fail(reading->error, reading_place(old), old->key, "this key is now called every");
    }
    if (!reading_is_type(reading, run, TOML_TABLE) ||
        !reading_only_keys(reading, run, "duration|seed|record|every", "duration, seed, record, every")) {
        return false;
    }
    const toml_entry_t *duration = reading_find(reading, run, "duration");
    const toml_entry_t *seed = reading_find(reading, run, "seed");
    const toml_entry_t *record = reading_find(reading, run, "record");
    const toml_entry_t *every = reading_find(reading, run, "every");
    scenario->duration_place = reading_place(duration != NULL ? duration : run);
    const bool timed = duration != NULL ? reading_in_range(reading, duration, "s", SCENARIO_SECONDS_MIN,
                                                           SCENARIO_SECONDS_MAX, &scenario->duration)
                                        : reading_missing(reading, run, "duration", "duration = \"2 s\"");
    if ((!timed && !refuse_later(reading, NULL, "run.duration")) ||
        (seed != NULL && !reading_is_whole(reading, seed, 0, INT64_MAX) &&
         !refuse_later(reading, NULL, "run.seed")) ||
        (every != NULL && !reading_is_whole(reading, every, 1, SCENARIO_EVERY_MAX) &&
         !refuse_later(reading, NULL, "run.every")) ||
        (record != NULL && !read_record(reading, record))) {
        return false;
    }
    scenario->seed = seed != NULL ? (uint64_t)seed->integer : 1u;
    scenario->every = every != NULL ? (uint32_t)every->integer : 1u;
    return true;
}

static bool read_start(const reading_t *reading, const toml_entry_t *top)
{
    scenario_t *scenario = reading->scenario;
    const toml_entry_t *start = reading_find(reading, top, "start");
    if (start == NULL) {
        return true;
    }
    if (!reading_is_type(reading, start, TOML_TABLE) ||
        !reading_only_keys(reading, start, "speed|angle", "speed, angle")) {
        return false;
    }
    const toml_entry_t *speed = reading_find(reading, start, "speed");
    const toml_entry_t *angle = reading_find(reading, start, "angle");
    scenario->has_start = speed != NULL || angle != NULL;
    scenario->has_start_speed = speed != NULL;
    scenario->start_place = reading_place(start);
    return (speed == NULL ||
            reading_in_range(reading, speed, UNITS_SPEED, -SCENARIO_SPEED_MAX, SCENARIO_SPEED_MAX,
                             &scenario->start_speed) ||
            refuse_later(reading, NULL, "start.speed")) &&
           (angle == NULL ||
            reading_in_range(reading, angle, "rad", -SCENARIO_ANGLE_MAX, SCENARIO_ANGLE_MAX,
                             &scenario->start_angle) ||
            refuse_later(reading, NULL, "start.angle"));
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
bool reading_time(const reading_t *reading, const toml_entry_t *entry, double *seconds)
{
    return reading_quantity(reading, entry, "s", seconds) &&
           (isfinite(*seconds) ||
            scenario_in_range(*seconds, 0.0, reading->scenario->duration, "s", reading_place(entry),
                              reading_key(entry), reading->error));
}

#define EVENT_KEYS "time|ramp|params|requests|plant|rig"
#define EVENT_ROWS "rows by their names (speed_request) or as params.ROW, requests.ROW, plant.ROW, rig.ROW"

/* The rows that an event sets by their names alone. A row that is also set in its section is refused. */
static bool read_named_rows(const reading_t *reading, const toml_entry_t *table, scenario_event_t *event)
{
    const uint32_t in_sections = event->count;
    for (const toml_entry_t *entry = reading_first(reading, table); entry != NULL;
         entry = reading_next(reading, table, entry)) {
        if (is_one_of(entry, EVENT_KEYS)) {
            continue;
        }
        const table_row_t *row = scenario_settable_row(entry->key, reading->error);
        if (row == NULL) {
            names_search_t search = names_search(entry->key);
            names_consider_choices(&search, EVENT_KEYS);
            reading->error->place = reading_place(entry);
            return names_found(&search) != NULL &&
                   refuse_key(reading, entry, EVENT_KEYS, "time, ramp, and " EVENT_ROWS);
        }
        for (uint32_t n = 0; n < in_sections; n++) {
            if (event->settings[n].row == row) {
                return scenario_fail(reading->error, reading_place(entry), entry->key,
                                     "line %" PRIu32 " sets this row too; accepted: once in an event",
                                     event->settings[n].place.line);
            }
        }
        if (!read_row(reading, entry, row, event)) {
            return false;
        }
    }
    return true;
}

static bool read_event(const reading_t *reading, const toml_entry_t *entry, scenario_event_t *event)
{
    if (!reading_is_type(reading, entry, TOML_TABLE)) {
        return false;
    }
    const toml_entry_t *time = reading_find(reading, entry, "time");
    const toml_entry_t *ramp = reading_find(reading, entry, "ramp");
    if (time == NULL) {
        return reading_missing(reading, entry, "time", "time = \"0.5 s\"");
    }
    event->time_place = reading_place(time);
    event->ramp_place = reading_place(ramp != NULL ? ramp : time);
    if (!reading_time(reading, time, &event->time) ||
        (ramp != NULL && !reading_time(reading, ramp, &event->ramp)) ||
        !reading_sections(reading, entry, event, 0u) || !read_named_rows(reading, entry, event)) {
        return false;
    }
    if (event->count == 0u) {
        return scenario_fail(reading->error, reading_place(entry), "at",
                             "it sets nothing; accepted: " EVENT_ROWS);
    }
    if (event->count > 1u) {
        qsort(event->settings, event->count, sizeof *event->settings, by_place);
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
const toml_entry_t *reading_tables(const reading_t *reading, const toml_entry_t *top, const char *key,
                                   uint32_t *count, bool *good)
{
    const toml_entry_t *array = reading_find(reading, top, key);
    *count = 0;
    *good = true;
    if (array == NULL) {
        return NULL;
    }
    if (array->type != TOML_ARRAY) {
        *good =
            scenario_fail(reading->error, reading_place(array), key,
                          "it is %s; accepted: [[%s]], as often as needed", toml_type_text(array->type), key);
        return NULL;
    }
    *count = reading_count(reading, array);
    return array;
}

/* ---- profiles ---- */

static bool read_point(const reading_t *reading, const toml_entry_t *point, const table_row_t *row,
                       scenario_event_t *event, double *value)
{
    const toml_entry_t *time = point->type == TOML_ARRAY ? reading_first(reading, point) : NULL;
    const toml_entry_t *to = time != NULL ? reading_next(reading, point, time) : NULL;
    if (to == NULL || reading_next(reading, point, to) != NULL) {
        return scenario_fail(reading->error, reading_place(point), "points",
                             "a point is a time and a value; accepted: [\"0.5 s\", \"2 N m\"]");
    }
    event->time_place = reading_place(point);
    event->ramp_place = reading_place(point);
    return reading_time(reading, time, &event->time) &&
           scenario_in_range(event->time, 0.0, reading->scenario->duration, "s", reading_place(time),
                             "points", reading->error) &&
           reading_row_value(reading, to, row, value) &&
           scenario_row_accepts(row, *value, reading_place(to), reading->error);
}

/* Appends an event of one row to the scenario's. */
static bool add_event(const reading_t *reading, const scenario_event_t *like, const table_row_t *row,
                      double value)
{
    scenario_event_t *event = &reading->scenario->events[reading->scenario->event_count++];
    *event = *like;
    event->settings = scenario_take(reading->scenario, sizeof *event->settings);
    event->count = 1u;
    if (event->settings == NULL) {
        return scenario_no_memory(reading->error);
    }
    event->settings[0] = (scenario_setting_t){row, value, like->time_place};
    return true;
}

/* Is the shape "steps"? */
static bool read_shape(const reading_t *reading, const toml_entry_t *shape, bool *steps)
{
    *steps = false;
    if (shape == NULL) {
        return true;
    }
    if (!reading_is_text(reading, shape, false)) {
        return false;
    }
    *steps = strcmp(shape->text, "steps") == 0;
    return *steps || strcmp(shape->text, "linear") == 0 ||
           scenario_fail(reading->error, reading_place(shape), "shape", "\"%.60s\"; accepted: linear, steps",
                         shape->text);
}

/* A row can have only one profile: a second one is refused. */
static bool is_first(const reading_t *reading, const toml_entry_t *profiles, const toml_entry_t *profile,
                     const table_row_t *row, const toml_entry_t *name)
{
    scenario_error_t ignored;
    const toml_entry_t *before = reading_first(reading, profiles);
    for (; before != profile; before = reading_next(reading, profiles, before)) {
        const toml_entry_t *other = reading_find(reading, before, "row");
        if (scenario_settable_row(other->text, &ignored) == row) {
            return scenario_fail(reading->error, reading_place(name), name->text,
                                 "line %" PRIu32 " has a profile of this row; accepted: one for each row",
                                 other->line);
        }
    }
    return true;
}

static bool read_profile(const reading_t *reading, const toml_entry_t *profiles, const toml_entry_t *profile)
{
    if (!reading_is_type(reading, profile, TOML_TABLE) ||
        !reading_only_keys(reading, profile, "row|shape|points", "row, shape, points")) {
        return false;
    }
    const toml_entry_t *name = reading_find(reading, profile, "row");
    const toml_entry_t *points = reading_find(reading, profile, "points");
    bool steps;
    if (name == NULL || points == NULL) {
        return reading_missing(reading, profile, name == NULL ? "row" : "points",
                               name == NULL ? "row = \"plant.load_torque\""
                                            : "points = [[\"0 s\", \"1 N m\"], [\"2 s\", \"5 N m\"]]");
    }
    if (!reading_is_text(reading, name, false) || !reading_is_type(reading, points, TOML_ARRAY) ||
        !read_shape(reading, reading_find(reading, profile, "shape"), &steps)) {
        return false;
    }
    const table_row_t *row = scenario_settable_row(name->text, reading->error);
    if (row == NULL) {
        reading->error->place = reading_place(name);
        return false;
    }
    if (!is_first(reading, profiles, profile, row, name)) {
        return false;
    }
    if (!steps && row->kind != SLOT_FLOAT) {
        return scenario_fail(reading->error, reading_place(name), name->text,
                             "it has no values between; accepted: shape = \"steps\"");
    }
    scenario_event_t before = {.count = 0u};
    double last = 0.0;
    for (const toml_entry_t *point = reading_first(reading, points); point != NULL;
         point = reading_next(reading, points, point)) {
        const bool first = point == reading_first(reading, points);
        scenario_event_t event = {.count = 0u};
        double value;
        if (!read_point(reading, point, row, &event, &value)) {
            return false;
        }
        if (!first && event.time < before.time) {
            return scenario_fail(
                reading->error, reading_place(point), "points",
                "%g s is before the previous point, %g s; accepted: times that do not decrease", event.time,
                before.time);
        }
        scenario_event_t change = event;
        if (!first && !steps) { /* from the previous point to this one */
            change = before;
            change.ramp = event.time - before.time;
            change.time_place = event.time_place; /* after the previous point, if both have the same time */
        }
        if ((first || value != last) && !add_event(reading, &change, row, value)) {
            return false;
        }
        before = event;
        last = value;
    }
    return true;
}

/* The largest number of events that the [[at]] and [[profile]] of a table make. */
static bool count_events(const reading_t *reading, const toml_entry_t *table, uint32_t *all)
{
    bool good;
    uint32_t count;
    const toml_entry_t *profiles = reading_tables(reading, table, "profile", &count, &good);
    if (good) {
        (void)reading_tables(reading, table, "at", &count, &good);
    }
    if (!good) {
        return false;
    }
    *all += count;
    const toml_entry_t *profile = profiles != NULL ? reading_first(reading, profiles) : NULL;
    for (; profile != NULL; profile = reading_next(reading, profiles, profile)) {
        const toml_entry_t *list =
            profile->type == TOML_TABLE ? reading_find(reading, profile, "points") : NULL;
        *all += list != NULL && list->type == TOML_ARRAY ? reading_count(reading, list) : 0u;
    }
    return true;
}

/* Adds the events of [[at]] and [[profile]] after the present ones. */
static bool read_more_events(const reading_t *reading, const toml_entry_t *table)
{
    scenario_t *scenario = reading->scenario;
    const toml_entry_t *array = reading_find(reading, table, "at");
    const toml_entry_t *entry = array != NULL ? reading_first(reading, array) : NULL;
    for (; entry != NULL; entry = reading_next(reading, array, entry)) {
        if (!read_event(reading, entry, &scenario->events[scenario->event_count])) {
            return false;
        }
        scenario->event_count++;
    }
    array = reading_find(reading, table, "profile");
    entry = array != NULL ? reading_first(reading, array) : NULL;
    for (; entry != NULL; entry = reading_next(reading, array, entry)) {
        if (!read_profile(reading, array, entry)) {
            return false;
        }
    }
    return true;
}

/* There is room for every settable row at t = 0. */
static void put_over(scenario_event_t *initial, const scenario_setting_t *settings, uint32_t count,
                     bool under)
{
    for (uint32_t n = 0; n < count; n++) {
        uint32_t at = 0;
        while (at < initial->count && initial->settings[at].row != settings[n].row) {
            at++;
        }
        if (at == initial->count || !under) {
            initial->count += at == initial->count;
            initial->settings[at] = settings[n];
        }
    }
}

static bool read_layer(const reading_t *reading, const scenario_layer_t *layer)
{
    const toml_entry_t *entry = &reading->file->entries[layer->entry];
    scenario_event_t *initial = &reading->scenario->events[0];
    if (layer->entry == 0u) {
        put_over(initial, layer->settings, layer->count, layer->under);
        return true;
    }
    scenario_event_t of = {.count = 0};
    if (!reading_sections(reading, entry, &of, 0u) || !read_more_events(reading, entry)) {
        return false;
    }
    put_over(initial, of.settings, of.count, layer->under);
    return true;
}

static bool read_events(const reading_t *reading, const toml_entry_t *top)
{
    scenario_t *scenario = reading->scenario;
    const scenario_more_t *more = reading->more;
    uint32_t all = 0;
    if (!count_events(reading, top, &all)) {
        return false;
    }
    for (uint32_t n = 0; n < more->layer_count; n++) {
        if (more->layers[n].entry != 0u &&
            !count_events(reading, &reading->file->entries[more->layers[n].entry], &all)) {
            return false;
        }
    }
    scenario->events = scenario_take(scenario, (1u + all) * sizeof *scenario->events);
    if (scenario->events == NULL) {
        return scenario_no_memory(reading->error);
    }
    scenario->event_count = 1u;
    if (!reading_sections(reading, top, &scenario->events[0], settable_rows()) ||
        !read_more_events(reading, top)) {
        return false;
    }
    for (uint32_t n = 0; n < more->layer_count; n++) {
        if (!read_layer(reading, &more->layers[n])) {
            return false;
        }
    }
    if (scenario->event_count > 2u) {
        qsort(&scenario->events[1], scenario->event_count - 1u, sizeof *scenario->events, by_time);
    }
    return true;
}

/* ---- the motor ---- */

/* "my_motor.toml" is in the folder of the scenario. */
static bool read_motor_file(const reading_t *reading, const toml_entry_t *entry, motor_sheet_t *sheet)
{
    char path[4096];
    const char *slash = strrchr(reading->scenario->path, '/');
    const int folder =
        entry->text[0] != '/' && slash != NULL ? (int)(slash + 1 - reading->scenario->path) : 0;
    snprintf(path, sizeof path, "%.*s%s", folder, reading->scenario->path, entry->text);
    if (motor_read_file(path, sheet, reading->error)) {
        return true;
    }
    char inside[sizeof reading->error->message];
    char name[sizeof reading->error->name];
    const scenario_place_t at = reading->error->place;
    snprintf(inside, sizeof inside, "%s", reading->error->message);
    snprintf(name, sizeof name, "%s", reading->error->name);
    return scenario_fail(reading->error, reading_place(entry), name, "%s:%lu: %.500s", path,
                         (unsigned long)at.line, inside);
}

/* `motor = "NAME"`, or [motor] with name, file or further keys, which replace those of name or file. */
static bool read_sheet(const reading_t *reading, const toml_entry_t *motor, motor_sheet_t *sheet)
{
    *sheet = (motor_sheet_t){.name = "motor", .whole = reading_place(motor)};
    if (motor->type == TOML_TEXT) {
        return reading_is_text(reading, motor, false) &&
               motor_read_library(motor->text, sheet, reading->error);
    }
    if (!reading_is_type(reading, motor, TOML_TABLE)) {
        return false;
    }
    const toml_entry_t *name = reading_find(reading, motor, "name");
    const toml_entry_t *file = reading_find(reading, motor, "file");
    if (name != NULL && file != NULL) {
        return scenario_fail(reading->error, reading_place(file), "file",
                             "`name` already selects the motor; accepted: one of the two");
    }
    if ((name != NULL && (!reading_is_text(reading, name, false) ||
                          !motor_read_library(name->text, sheet, reading->error))) ||
        (file != NULL &&
         (!reading_is_text(reading, file, false) || !read_motor_file(reading, file, sheet)))) {
        return false;
    }
    return motor_read_table(reading->file, motor, "name|file", sheet, reading->error);
}

/* Fills the rows of params and plant that the file does not set itself. The file alone decides whether the
 * motor runs with an encoder; the drive refuses a motor that it cannot run without one, with the reason. */
static bool read_motor(const reading_t *reading, const toml_entry_t *top)
{
    const toml_entry_t *entry = reading_find(reading, top, "motor");
    scenario_event_t *initial = &reading->scenario->events[0];
    motor_sheet_t sheet;
    motor_t motor;
    tune_t tune;
    if (entry == NULL) {
        return true;
    }
    if (!read_sheet(reading, entry, &sheet) || !motor_make(&sheet, &motor, reading->error) ||
        !tune_motor(&motor, &tune, reading->error)) {
        if (reading->error->place.line == 0u || entry->type == TOML_TEXT) {
            reading->error->place = reading_place(entry);
        }
        return false;
    }
    char unsuited[BOARDS_TEXT_SIZE];
    if (boards_unsuited(unsuited, &motor)[0] != '\0') {
        char *kept = scenario_take(reading->scenario, sizeof unsuited);
        if (kept == NULL) {
            return scenario_no_memory(reading->error);
        }
        memcpy(kept, unsuited, sizeof unsuited);
        reading->scenario->unsuited = kept;
    }
    const table_row_t *source = rig_row_by_name("position_source");
    for (uint32_t n = 0; n < tune.count; n++) {
        uint32_t at = 0;
        if (tune.rows[n].row == source) {
            continue;
        }
        while (at < initial->count && initial->settings[at].row != tune.rows[n].row) {
            at++;
        }
        if (at == initial->count) { /* there is room for every settable row */
            initial->settings[initial->count++] =
                (scenario_setting_t){tune.rows[n].row, tune.rows[n].value, reading_place(entry)};
        }
    }
    return true;
}

/* ---- expectations ---- */

bool reading_signal(const reading_t *reading, const toml_entry_t *entry, const table_row_t **row)
{
    if (!reading_is_text(reading, entry, false)) {
        return false;
    }
    *row = scenario_row(entry->text, reading->error);
    reading->error->place = reading_place(entry);
    return *row != NULL;
}

bool reading_statistic(const reading_t *reading, const toml_entry_t *entry, statistic_t *statistic)
{
    if (!reading_is_text(reading, entry, false)) {
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
    return scenario_fail(reading->error, reading_place(entry), "statistic",
                         "there is no \"%.60s\"%s%s; accepted: mean, min, max, peak, sd, rms, last",
                         entry->text, near != NULL ? "; nearest: " : "", near != NULL ? near : "");
}

/* A limit has the form of the signal's values, but the limit of a mean of choices is a number. */
static bool read_limit(const reading_t *reading, const toml_entry_t *entry, const table_row_t *row,
                       double *limit)
{
    double value = 0.0;
    if (entry->type == TOML_TEXT && row->kind == SLOT_ENUM) {
        if (!reading_row_value(reading, entry, row, &value)) {
            snprintf(reading->error->name, sizeof reading->error->name, "%s", entry->key);
            return false;
        }
    } else if (!reading_quantity(reading, entry, row->kind == SLOT_ENUM ? "-" : units_of_row(row), &value)) {
        return false;
    }
    if (!isfinite(value)) {
        return scenario_fail(reading->error, reading_place(entry), entry->key,
                             "%s is not a finite number; leave a limit out to have none",
                             scenario_not_finite(value));
    }
    *limit = value;
    return true;
}

static bool read_limits(const reading_t *reading, const toml_entry_t *entry, scenario_expect_t *expect)
{
    const toml_entry_t *at_least = reading_find(reading, entry, "at_least");
    const toml_entry_t *at_most = reading_find(reading, entry, "at_most");
    expect->at_least = -(double)INFINITY;
    expect->at_most = (double)INFINITY;
    if (at_least == NULL && at_most == NULL) {
        return scenario_fail(reading->error, reading_place(entry), "at_least",
                             "it is missing; give at_least, at_most or both");
    }
    if ((at_least != NULL && !read_limit(reading, at_least, expect->row, &expect->at_least)) ||
        (at_most != NULL && !read_limit(reading, at_most, expect->row, &expect->at_most))) {
        return false;
    }
    if (expect->at_least > expect->at_most) {
        char low[UNITS_TEXT_SIZE];
        char high[UNITS_TEXT_SIZE];
        return scenario_fail(
            reading->error, reading_place(at_least), "at_least",
            "%s is above at_most, %s, so that no value satisfies both; accepted: at_least up to at_most",
            units_row_text(low, expect->at_least, expect->row),
            units_row_text(high, expect->at_most, expect->row));
    }
    return true;
}

static bool read_window(const reading_t *reading, const toml_entry_t *entry, scenario_expect_t *expect)
{
    const toml_entry_t *from = reading_find(reading, entry, "from");
    const toml_entry_t *to = reading_find(reading, entry, "to");
    expect->to_the_end = to == NULL;
    expect->from_place = reading_place(from != NULL ? from : entry);
    expect->to_place = reading_place(to != NULL ? to : entry);
    return (from == NULL || reading_time(reading, from, &expect->from)) &&
           (to == NULL || reading_time(reading, to, &expect->to));
}

static bool read_needs(const reading_t *reading, const toml_entry_t *entry, scenario_expect_t *expect)
{
    const toml_entry_t *needs = reading_find(reading, entry, "needs_drive");
    expect->needs_drive = expect->row->kind == SLOT_FLOAT;
    if (needs == NULL) {
        return true;
    }
    if (!reading_is_text(reading, needs, false)) {
        return false;
    }
    expect->needs_drive = strcmp(needs->text, "yes") == 0;
    expect->needs_none = !expect->needs_drive;
    return expect->needs_drive || strcmp(needs->text, "no") == 0 ||
           scenario_fail(reading->error, reading_place(needs), needs->key, "\"%.60s\": accepted: yes, no",
                         needs->text);
}

/* The quantity, interval and statistic of [[expect]] and [[measure]]. */
static bool read_quantity_of(const reading_t *reading, const toml_entry_t *entry, scenario_expect_t *expect)
{
    const toml_entry_t *name = reading_find(reading, entry, "name");
    const toml_entry_t *signal = reading_find(reading, entry, "signal");
    const toml_entry_t *minus = reading_find(reading, entry, "minus");
    const toml_entry_t *statistic = reading_find(reading, entry, "statistic");
    expect->place = reading_place(entry);
    if (signal == NULL) {
        return reading_missing(reading, entry, "signal", "signal = \"true_omega_m\"");
    }
    if (statistic == NULL) {
        return reading_missing(reading, entry, "statistic", "statistic = \"mean\"");
    }
    if ((name != NULL && !reading_is_text(reading, name, false)) ||
        !reading_signal(reading, signal, &expect->row) ||
        (minus != NULL && !reading_signal(reading, minus, &expect->minus)) ||
        !reading_statistic(reading, statistic, &expect->statistic) || !read_window(reading, entry, expect)) {
        return false;
    }
    expect->name = name != NULL ? name->text : "";
    if (expect->minus != NULL && strcmp(units_of_row(expect->minus), units_of_row(expect->row)) != 0) {
        return scenario_fail(reading->error, reading_place(minus), minus->text,
                             "its unit is %s, that of %s is %s; accepted: rows of one unit%s",
                             expect->minus->unit, signal->text, expect->row->unit,
                             strcmp(expect->minus->unit, expect->row->unit) == 0 ? " (one is mechanical)"
                                                                                 : "");
    }
    return true;
}

static bool read_expect(const reading_t *reading, const toml_entry_t *entry, scenario_expect_t *expect)
{
    if (!reading_is_type(reading, entry, TOML_TABLE) ||
        !reading_only_keys(reading, entry, "name|signal|minus|statistic|from|to|at_least|at_most|needs_drive",
                           "signal, minus, statistic, from, to, at_least, at_most, name, needs_drive")) {
        return false;
    }
    return read_quantity_of(reading, entry, expect) && read_needs(reading, entry, expect) &&
           read_limits(reading, entry, expect);
}

static bool read_measure(const reading_t *reading, const toml_entry_t *entry, scenario_expect_t *measure)
{
    measure->measure = true;
    measure->at_least = -(double)INFINITY;
    measure->at_most = (double)INFINITY;
    return reading_is_type(reading, entry, TOML_TABLE) &&
           reading_only_keys(reading, entry, "name|signal|minus|statistic|from|to",
                             "signal, minus, statistic, from, to, name; [[expect]] has limits") &&
           read_quantity_of(reading, entry, measure);
}

/* Appends the quantities of [[key]]. */
static bool read_list(const reading_t *reading, const toml_entry_t *array,
                      bool (*read)(const reading_t *, const toml_entry_t *, scenario_expect_t *))
{
    scenario_t *scenario = reading->scenario;
    const toml_entry_t *entry = array != NULL ? reading_first(reading, array) : NULL;
    for (; entry != NULL; entry = reading_next(reading, array, entry)) {
        if (!read(reading, entry, &scenario->expects[scenario->expect_count])) {
            return false;
        }
        scenario->expect_count++;
    }
    return true;
}

static bool read_expects(const reading_t *reading, const toml_entry_t *top)
{
    scenario_t *scenario = reading->scenario;
    bool good;
    uint32_t expects;
    uint32_t measures = 0;
    const toml_entry_t *expect = reading_tables(reading, top, "expect", &expects, &good);
    /* A claim of an experiment has further keys and its own measurement. */
    const toml_entry_t *measure = good && reading->more->keys == NULL
                                      ? reading_tables(reading, top, "measure", &measures, &good)
                                      : NULL;
    if (!good || expects + measures == 0u) {
        return good;
    }
    scenario->expects = scenario_take(scenario, (expects + measures) * sizeof *scenario->expects);
    if (scenario->expects == NULL) {
        return scenario_no_memory(reading->error);
    }
    return read_list(reading, expect, read_expect) && read_list(reading, measure, read_measure);
}

/* ---- the file ---- */

/* Limit of the tap: rows of `record` and of [[expect]] together. */
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
    const bool known = reading->more->keys != NULL
                           ? reading_only_keys(reading, top, reading->more->keys, reading->more->accepted)
                           : reading_only_keys(reading, top,
                                               "schema|title|text|board|run|start|motor|params|requests|"
                                               "plant|rig|at|profile|expect|measure",
                                               "schema, title, text, board, [run], [start], [motor], "
                                               "[params], [requests], [plant], [rig], "
                                               "[[at]], [[profile]], [[expect]], [[measure]]");
    return known && read_head(reading, top) && read_run(reading, top) && read_start(reading, top) &&
           read_events(reading, top) && read_motor(reading, top) && read_expects(reading, top) &&
           check_tap(reading) &&
           (reading->to_mend || reading->more->unchecked ||
            scenario_check(reading->scenario, reading->error));
}

static scenario_t *scenario_of(const char *path, toml_file_t *file, const toml_error_t *why, bool to_mend,
                               const scenario_more_t *more, scenario_error_t *error)
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
    const reading_t reading = {file, scenario, error, to_mend, more};
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

/* The message of every error names the file. */
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

static const scenario_more_t no_more = {.keys = NULL};

static scenario_t *read_file(const char *path, bool to_mend, scenario_error_t *error)
{
    toml_error_t why;
    toml_file_t *file = toml_read(path, &why);
    return in_file(path, scenario_of(path, file, &why, to_mend, &no_more, error), error);
}

static scenario_t *read_memory(const char *path, const char *text, size_t octets, bool to_mend,
                               scenario_error_t *error)
{
    toml_error_t why;
    toml_file_t *file = toml_read_text(text, octets, &why);
    return in_file(path, scenario_of(path, file, &why, to_mend, &no_more, error), error);
}

scenario_t *scenario_read(const char *path, scenario_error_t *error)
{
    return read_file(path, false, error);
}

scenario_t *scenario_read_to_mend(const char *path, scenario_error_t *error)
{
    return read_file(path, true, error);
}

scenario_t *scenario_read_text(const char *path, const char *text, size_t octets, scenario_error_t *error)
{
    return read_memory(path, text, octets, false, error);
}

scenario_t *scenario_read_text_to_mend(const char *path, const char *text, size_t octets,
                                       scenario_error_t *error)
{
    return read_memory(path, text, octets, true, error);
}

scenario_t *scenario_read_more(const char *path, const char *text, size_t octets, const scenario_more_t *more,
                               scenario_error_t *error)
{
    toml_error_t why;
    toml_file_t *file = toml_read_text(text, octets, &why);
    return in_file(path, scenario_of(path, file, &why, false, more, error), error);
}
