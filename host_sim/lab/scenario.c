#include "host_sim/lab/scenario.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host_sim/lab/scenario_parts.h"

const char *const scenario_settable[SCENARIO_SETTABLE] = {"params", "requests", "plant", "rig"};

static const scenario_place_t nowhere = {0u, 0u};

/* ---- memory and messages ---- */

/* The content of a block needs the same alignment that malloc gives its header. */
typedef union {
    scenario_block_t block;
    max_align_t alignment;
} block_head_t;

void *scenario_take(scenario_t *scenario, size_t octets)
{
    block_head_t *head = calloc(1, sizeof *head + octets);
    if (head == NULL) {
        return NULL;
    }
    head->block.next = scenario->memory->blocks;
    scenario->memory->blocks = &head->block;
    return head + 1;
}

void scenario_free(scenario_t *scenario)
{
    if (scenario == NULL) {
        return;
    }
    if (scenario->memory != NULL) {
        scenario_block_t *block = scenario->memory->blocks;
        while (block != NULL) {
            scenario_block_t *next = block->next;
            free(block);
            block = next;
        }
        toml_free(scenario->memory->file);
        free(scenario->memory);
    }
    free(scenario);
}

/* Makes the quoted text a single line. */
static void flatten(char *text)
{
    for (; *text != '\0'; text++) {
        const unsigned char c = (unsigned char)*text;
        *text = c < 0x20u || c == 0x7Fu ? ' ' : *text;
    }
}

bool scenario_fail(scenario_error_t *error, scenario_place_t place, const char *name, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(error->message, sizeof error->message, format, arguments);
    va_end(arguments);
    snprintf(error->name, sizeof error->name, "%s", name[0] != '\0' ? name : "\"\"");
    error->place = place;
    error->board[0] = '\0';
    flatten(error->message);
    flatten(error->name);
    return false;
}

bool scenario_no_memory(scenario_error_t *error)
{
    return scenario_fail(error, nowhere, TOML_WHOLE_FILE, "there is not enough memory to read it");
}

const char *scenario_error_text(const scenario_error_t *error, char *to, size_t size)
{
    if (error->place.line != 0u) {
        snprintf(to, size, "%s:%lu:%lu: %s: %s", error->file, (unsigned long)error->place.line,
                 (unsigned long)error->place.column, error->name, error->message);
    } else if (strcmp(error->name, TOML_WHOLE_FILE) == 0) {
        snprintf(to, size, "%s: %s", error->file, error->message);
    } else {
        snprintf(to, size, "%s: %s: %s", error->file, error->name, error->message);
    }
    return to;
}

static void name_file(scenario_error_t *error, const char *file)
{
    snprintf(error->file, sizeof error->file, "%s", file);
    flatten(error->file);
}

const char *statistic_text(statistic_t statistic)
{
    static const char *const names[STATISTICS] = {"mean", "min", "max", "peak", "sd", "rms", "last"};
    return statistic < STATISTICS ? names[statistic] : "";
}

/* ---- rows ---- */

const table_t *scenario_table(const char *name)
{
    for (uint32_t n = 0; n < rig_table_count(); n++) {
        if (strcmp(rig_table(n)->name, name) == 0) {
            return rig_table(n);
        }
    }
    return NULL;
}

const table_t *scenario_table_of(const table_row_t *row)
{
    for (uint32_t n = 0; n < rig_table_count(); n++) {
        const table_t *table = rig_table(n);
        if (row >= table->rows && row < table->rows + table->count) {
            return table;
        }
    }
    return NULL;
}

static bool is_settable_table(const table_t *table)
{
    for (size_t n = 0; n < SCENARIO_SETTABLE; n++) {
        if (strcmp(scenario_settable[n], table->name) == 0) {
            return true;
        }
    }
    return false;
}

bool scenario_is_param(const table_row_t *row)
{
    return scenario_table_of(row) == scenario_table("params");
}

/* How many tables have a row of this name; the first such row, and the names of these tables ("params,
 * plant"). */
static uint32_t count_rows(const char *name, bool settable, const table_row_t **first, char *tables,
                           size_t size)
{
    uint32_t count = 0;
    *first = NULL;
    tables[0] = '\0';
    for (uint32_t n = 0; n < rig_table_count(); n++) {
        const table_t *table = rig_table(n);
        const table_row_t *row = settable && !is_settable_table(table) ? NULL : table_by_name(table, name);
        if (row == NULL) {
            continue;
        }
        const size_t used = strlen(tables);
        snprintf(tables + used, size - used, "%s%s.%s", used > 0u ? " or " : "", table->name, name);
        *first = *first == NULL ? row : *first;
        count++;
    }
    return count;
}

void scenario_file_name(const char *path, char *to, size_t size)
{
    const char *slash = strrchr(path, '/');
    const char *begin = slash != NULL ? slash + 1 : path;
    size_t length = strlen(begin);
    length -= length > 5u && strcmp(begin + length - 5u, ".toml") == 0 ? 5u : 0u;
    snprintf(to, size, "%.*s", (int)length, begin);
}

void scenario_row_name(const table_row_t *row, char *to, size_t size)
{
    char tables[NAMES_LENGTH_MAX * 4u];
    const table_row_t *first;
    const bool alone = count_rows(row->name, false, &first, tables, sizeof tables) == 1u;
    snprintf(to, size, "%s%s%s", alone ? "" : scenario_table_of(row)->name, alone ? "" : ".", row->name);
}

scenario_hint_t scenario_near_row(const char *name, const table_t *table)
{
    scenario_hint_t hint = {""};
    char tables[NAMES_LENGTH_MAX * 4u];
    const table_row_t *first;
    if (table != NULL && count_rows(name, false, &first, tables, sizeof tables) > 0u) {
        const bool shown = scenario_table_of(first) != NULL && !is_settable_table(scenario_table_of(first));
        snprintf(hint.text, sizeof hint.text, "; it is %s%s", tables,
                 shown ? ", which can be read, not set" : "");
        return hint;
    }
    names_search_t search = names_search(name);
    for (uint32_t n = 0; n < rig_table_count(); n++) {
        if (table == NULL || table == rig_table(n)) {
            names_consider_table(&search, rig_table(n));
        }
    }
    if (names_found(&search) != NULL) {
        snprintf(hint.text, sizeof hint.text, "; nearest: %s", names_found(&search));
    }
    return hint;
}

/* Splits "table.row". false: no dot, or the table's name is too long for any. */
static bool split(const char *name, char table[NAMES_LENGTH_MAX + 1u], const char **row)
{
    const char *dot = strchr(name, '.');
    if (dot == NULL || (size_t)(dot - name) > NAMES_LENGTH_MAX) {
        return false;
    }
    snprintf(table, NAMES_LENGTH_MAX + 1u, "%.*s", (int)(dot - name), name);
    *row = dot + 1;
    return true;
}

/* settable: only rows that a scenario may set count, and the others are refused as such. */
static const table_row_t *find_row(const char *name, bool settable, scenario_error_t *error)
{
    char table_name[NAMES_LENGTH_MAX + 1u];
    char tables[NAMES_LENGTH_MAX * 4u];
    const char *row_name;
    const table_row_t *row;
    if (split(name, table_name, &row_name)) {
        const table_t *table = scenario_table(table_name);
        if (table == NULL) {
            names_search_t search = names_search(table_name);
            for (uint32_t n = 0; n < rig_table_count(); n++) {
                names_consider(&search, rig_table(n)->name);
            }
            const char *near = names_found(&search);
            scenario_fail(error, nowhere, name, "no table is called %s%s%s; accepted: %s", table_name,
                          near != NULL ? "; nearest: " : "", near != NULL ? near : "",
                          settable ? "params, requests, plant, rig"
                                   : "params, requests, signals, truth, plant, rig");
            return NULL;
        }
        row = table_by_name(table, row_name);
        if (row == NULL) {
            scenario_fail(error, nowhere, name, "no such row in %s%s", table->name,
                          scenario_near_row(row_name, table).text);
            return NULL;
        }
    } else {
        const uint32_t count = count_rows(name, settable, &row, tables, sizeof tables);
        if (count == 0u && settable) {
            (void)count_rows(name, false, &row, tables, sizeof tables);
        }
        if (count > 1u) {
            scenario_fail(error, nowhere, name, "more than one table has this row; write %s", tables);
            return NULL;
        }
        if (row == NULL) {
            scenario_fail(error, nowhere, name, "no table has a row of this name%s",
                          scenario_near_row(name, NULL).text);
            return NULL;
        }
    }
    if (settable && !is_settable_table(scenario_table_of(row))) {
        scenario_fail(error, nowhere, name,
                      "it can be read, not set; accepted: rows of params, requests, plant, rig");
        return NULL;
    }
    return row;
}

const table_row_t *scenario_settable_row(const char *name, scenario_error_t *error)
{
    return find_row(name, true, error);
}

const table_row_t *scenario_row(const char *name, scenario_error_t *error)
{
    error->file[0] = '\0';
    return find_row(name, false, error);
}

scenario_accepted_t scenario_accepted(const table_row_t *row)
{
    scenario_accepted_t accepted = {""};
    if (row->kind == SLOT_ENUM) {
        size_t used = 0;
        for (const char *choice = row->choices; *choice != '\0' && used < sizeof accepted.text;) {
            const size_t length = strcspn(choice, "|");
            used += (size_t)snprintf(accepted.text + used, sizeof accepted.text - used, "%s%.*s",
                                     used > 0u ? ", " : "", (int)length, choice);
            choice += length + (choice[length] == '|' ? 1u : 0u);
        }
        return accepted;
    }
    char si[RIG_RANGE_SIZE];
    char readable[UNITS_TEXT_SIZE] = "";
    rig_range_text(si, row, rig_min(row), rig_max(row));
    if (strcmp(units_of_row(row), UNITS_SPEED) == 0) {
        units_range_text(readable, rig_min(row), rig_max(row), UNITS_SPEED);
        snprintf(accepted.text, sizeof accepted.text, "%s (%s)", si, readable);
    } else {
        snprintf(accepted.text, sizeof accepted.text, "%s", si);
    }
    return accepted;
}

static bool is_spaces(const char *text)
{
    return text[strspn(text, " \t")] == '\0';
}

bool scenario_row_text_value(const table_row_t *row, const char *text, double *value, scenario_place_t place,
                             scenario_error_t *error)
{
    if (row->kind == SLOT_ENUM) {
        const int32_t choice = table_choice(row, text);
        if (choice < 0) {
            names_search_t search = names_search(text);
            names_consider_choices(&search, row->choices);
            const char *near = names_found(&search);
            return scenario_fail(
                error, place, row->name, "\"%.60s\" is not one of its choices%s%s; accepted: %s", text,
                near != NULL ? "; nearest: " : "", near != NULL ? near : "", scenario_accepted(row).text);
        }
        *value = (double)choice;
        return true;
    }
    if (rig_is_flux_map(row)) {
        char message[sizeof error->message];
        *value = (double)rig_read_flux_map(text, message, sizeof message);
        return *value > 0.0 || scenario_fail(error, place, row->name, "%s", message);
    }
    units_error_t why;
    if (!units_read(text, units_of_row(row), value, &why)) {
        return scenario_fail(error, place, row->name, "%s; range %s", why.text, scenario_accepted(row).text);
    }
    return true;
}

bool scenario_row_accepts(const table_row_t *row, double value, scenario_place_t place,
                          scenario_error_t *error)
{
    if (row->access == TABLE_READ) {
        return scenario_fail(error, place, row->name,
                             "it can be read, not set; accepted: rows of params, requests, plant, rig");
    }
    if (!isfinite(value)) {
        return scenario_fail(error, place, row->name, "%s is not a finite number; accepted: %s",
                             scenario_not_finite(value), scenario_accepted(row).text);
    }
    if (!rig_accepts(row, value)) {
        char given[UNITS_TEXT_SIZE];
        return scenario_fail(error, place, row->name, "%s is outside its range; accepted: %s",
                             units_row_text(given, value, row), scenario_accepted(row).text);
    }
    return true;
}

bool scenario_in_range(double value, double min, double max, const char *unit, scenario_place_t place,
                       const char *name, scenario_error_t *error)
{
    if (value >= min && value <= max) {
        return true;
    }
    char given[UNITS_TEXT_SIZE];
    char accepted[UNITS_TEXT_SIZE];
    return scenario_fail(error, place, name, "%s is %s; accepted: %s", units_text(given, value, unit),
                         isfinite(value) ? "outside its range" : "not a finite number",
                         units_range_text(accepted, min, max, unit));
}

/* ---- values on a rig ---- */

double scenario_initial(const scenario_t *scenario, const table_row_t *row)
{
    const scenario_event_t *initial = &scenario->events[0];
    for (uint32_t n = 0; n < initial->count; n++) {
        if (initial->settings[n].row == row) {
            return (double)(float)initial->settings[n].value;
        }
    }
    return rig_initial(row);
}

bool scenario_set(rig_t *rig, const scenario_setting_t *settings, uint32_t count)
{
    for (uint32_t n = 0; n < count; n++) {
        if (!rig_set(rig, settings[n].row->id, settings[n].value)) {
            return false;
        }
        const bool last_param = scenario_is_param(settings[n].row) &&
                                (n + 1u == count || !scenario_is_param(settings[n + 1u].row));
        if (last_param && !rig_apply(rig)) {
            return false;
        }
    }
    return true;
}

void scenario_refused(const scenario_t *scenario, rig_t *rig, const scenario_setting_t *settings,
                      uint32_t count, scenario_error_t *error)
{
    const scenario_setting_t *guilty = &settings[0];
    for (uint32_t n = 0; n < count; n++) {
        guilty = settings[n].row->id == rig_error_id(rig) ? &settings[n] : guilty;
    }
    const table_row_t *row = rig_row(rig_error_id(rig));
    const char *name = row != NULL ? row->name : guilty->row->name;
    const char *text = rig_error(rig);
    const size_t length = strlen(name);
    if (strncmp(text, name, length) == 0 && strncmp(text + length, " = ", 3) == 0) {
        text += length + 3u;
    }
    char given[UNITS_TEXT_SIZE];
    char accepted[UNITS_TEXT_SIZE];
    double value = 0.0;
    double min = 0.0;
    double max = 0.0;
    if (row != NULL && strcmp(units_of_row(row), UNITS_SPEED) == 0 &&
        rig_error_range(rig, &value, &min, &max)) {
        scenario_fail(error, guilty->place, name, "%s; that is %s, accepted: %s", text,
                      units_row_text(given, value, row), units_range_text(accepted, min, max, UNITS_SPEED));
    } else {
        scenario_fail(error, guilty->place, name, "%s", text);
    }
    name_file(error, scenario->path);
}

/* ---- judging the whole ---- */

/* A range of settings that the rig takes as one set: one row, or all parameters of an event. */
typedef struct {
    uint32_t first, count; /* [-] of the event's settings */
    bool done;
} unit_t;

/* Moves all parameters to the place of the first one; the rest stays in the order of the file. Returns how
 * many units there are. */
static uint32_t make_units(scenario_setting_t *settings, uint32_t count, scenario_setting_t *sorted,
                           unit_t *units)
{
    uint32_t used = 0;
    uint32_t unit_count = 0;
    bool params_taken = false;
    for (uint32_t n = 0; n < count; n++) {
        if (!scenario_is_param(settings[n].row)) {
            units[unit_count++] = (unit_t){used, 1u, false};
            sorted[used++] = settings[n];
            continue;
        }
        if (params_taken) {
            continue;
        }
        params_taken = true;
        unit_t *unit = &units[unit_count++];
        *unit = (unit_t){used, 0u, false};
        for (uint32_t m = n; m < count; m++) {
            if (scenario_is_param(settings[m].row)) {
                sorted[used++] = settings[m];
                unit->count++;
            }
        }
    }
    return unit_count;
}

/* Sets an event on the rig, unit by unit; one that is refused waits until others have changed what it depends
 * on (a current reference and its limit, a load and its kind). The accepted order is written back to
 * `settings`. */
static bool settle(const scenario_t *scenario, rig_t *rig, scenario_setting_t *settings, uint32_t count,
                   scenario_error_t *error)
{
    if (count == 0u) {
        return true;
    }
    scenario_setting_t *sorted = calloc(count, sizeof *sorted);
    unit_t *units = calloc(count, sizeof *units);
    bool good = sorted != NULL && units != NULL;
    if (!good) {
        scenario_no_memory(error);
        name_file(error, scenario->path);
    }
    const uint32_t unit_count = good ? make_units(settings, count, sorted, units) : 0u;
    uint32_t placed = 0;
    bool progress = true;
    while (good && placed < count && progress) {
        progress = false;
        for (uint32_t n = 0; n < unit_count; n++) {
            if (!units[n].done && scenario_set(rig, &sorted[units[n].first], units[n].count)) {
                memcpy(&settings[placed], &sorted[units[n].first], units[n].count * sizeof *settings);
                placed += units[n].count;
                units[n].done = true;
                progress = true;
            }
        }
    }
    const unit_t *stuck = NULL;
    for (uint32_t n = 0; n < unit_count; n++) {
        /* the others most likely wait for a limit that the parameters did not change */
        const bool params = scenario_is_param(sorted[units[n].first].row);
        stuck = !units[n].done && (stuck == NULL || params) ? &units[n] : stuck;
    }
    if (stuck != NULL) {
        good = scenario_set(rig, &sorted[stuck->first],
                            stuck->count); /* tried once more to get the message of the refusal */
        scenario_refused(scenario, rig, &sorted[stuck->first], stuck->count, error);
    }
    free(sorted);
    free(units);
    return good;
}

/* With a ramp each float row has values between the end points. One such value, which is no round number, is
 * tried on a rig with the final values. Whole numbers in float rows fail here. The rig is unchanged
 * afterwards. */
static bool check_ramp(const scenario_t *scenario, rig_t *rig, const scenario_setting_t *before,
                       const scenario_event_t *event, scenario_error_t *error)
{
    for (uint32_t n = 0; n < event->count; n++) {
        const scenario_setting_t *end = &event->settings[n];
        const scenario_setting_t *start = before;
        while (start->row != end->row) {
            start++;
        }
        if (end->row->kind != SLOT_FLOAT || start->value == end->value) {
            continue;
        }
        scenario_setting_t between = *end;
        between.value = start->value + 0.381966 * (end->value - start->value);
        if (!rig_set(rig, between.row->id, between.value)) {
            scenario_refused(scenario, rig, &between, 1u, error);
            char reason[sizeof error->message];
            snprintf(reason, sizeof reason, "%s", error->message);
            return scenario_fail(error, between.place, between.row->name,
                                 "a ramp passes values that it refuses: %.400s", reason);
        }
        double kept = end->value;
        if (!rig_set(rig, end->row->id, end->value) || !rig_get(rig, end->row->id, &kept) ||
            (float)kept != (float)end->value) {
            return scenario_fail(error, end->place, end->row->name,
                                 "it acts once and keeps no value; accepted: an event without ramp");
        }
    }
    return true;
}

static bool check_event(const scenario_t *scenario, rig_t *rig, scenario_event_t *event,
                        scenario_error_t *error)
{
    if (event->ramp_periods == 0u) {
        return settle(scenario, rig, event->settings, event->count, error);
    }
    scenario_setting_t *before = calloc(event->count, sizeof *before);
    if (before == NULL) {
        return scenario_no_memory(error);
    }
    memcpy(before, event->settings, event->count * sizeof *before);
    for (uint32_t n = 0; n < event->count; n++) {
        (void)rig_get(rig, before[n].row->id, &before[n].value);
    }
    const bool good = settle(scenario, rig, event->settings, event->count, error) &&
                      check_ramp(scenario, rig, before, event, error);
    free(before);
    return good;
}

static bool check_times(scenario_t *scenario, scenario_error_t *error)
{
    const double duration = scenario->duration;
    scenario->periods = rig_periods(duration);
    for (uint32_t n = 1; n < scenario->event_count; n++) {
        scenario_event_t *event = &scenario->events[n];
        if (!scenario_in_range(event->time, 0.0, duration, "s", event->time_place, "time", error)) {
            return false;
        }
        event->period = rig_periods(event->time);
        if (event->period >= scenario->periods) {
            char text[UNITS_TEXT_SIZE];
            return scenario_fail(
                error, event->time_place, "time",
                "the run ends before this event; accepted: 0 s to less than the duration, %s",
                units_text(text, duration, "s"));
        }
        /* After rounding the run may be shorter than its times: a ramp up to the end has the periods that
         * remain. */
        const uint32_t left = scenario->periods - event->period;
        const double most = fmax(left * RIG_PERIOD_SECONDS, duration - event->time);
        if (!scenario_in_range(event->ramp, 0.0, most, "s", event->ramp_place, "ramp", error)) {
            return false;
        }
        event->ramp_periods = rig_periods(event->ramp);
        event->ramp_periods = event->ramp_periods < left ? event->ramp_periods : left;
    }
    for (uint32_t n = 0; n < scenario->expect_count; n++) {
        scenario_expect_t *expect = &scenario->expects[n];
        if (!scenario_in_range(expect->from, 0.0, duration, "s", expect->from_place, "from", error)) {
            return false;
        }
        if (expect->to_the_end) {
            expect->to = duration;
        }
        if (!scenario_in_range(expect->to, 0.0, duration, "s", expect->to_place, "to", error)) {
            return false;
        }
        expect->begin = rig_periods(expect->from);
        expect->end = rig_periods(expect->to);
        if (expect->begin >= expect->end) {
            char from[UNITS_TEXT_SIZE];
            char to[UNITS_TEXT_SIZE];
            char least[UNITS_TEXT_SIZE];
            return scenario_fail(error, expect->from_place, "from",
                                 "the window from %s to %s contains no period; accepted: at least %s",
                                 units_text(from, expect->from, "s"), units_text(to, expect->to, "s"),
                                 units_text(least, SCENARIO_SECONDS_MIN, "s"));
        }
    }
    return true;
}

static bool check_values(scenario_t *scenario, scenario_error_t *error)
{
    rig_t *rig = rig_create(0);
    if (rig == NULL) {
        return scenario_no_memory(error);
    }
    bool good = true;
    for (uint32_t n = 0; n < scenario->event_count && good; n++) {
        good = check_event(scenario, rig, &scenario->events[n], error);
        if (good && n == 0u && scenario->has_start_speed && rig_value(rig, "shaft_locked") != 0.0) {
            good = scenario_fail(
                error, scenario->start_place, "start",
                "plant.shaft_locked holds the shaft at plant.shaft_locked_speed; set that instead");
        }
    }
    rig_free(rig);
    return good;
}

bool scenario_check(scenario_t *scenario, scenario_error_t *error)
{
    if (scenario->memory->refused != NULL) {
        *error = scenario->memory->refused->error;
        name_file(error, scenario->path);
        return false;
    }
    const bool good = scenario_in_range(scenario->duration, SCENARIO_SECONDS_MIN, SCENARIO_SECONDS_MAX, "s",
                                        scenario->duration_place, "duration", error) &&
                      check_times(scenario, error) && check_values(scenario, error);
    if (!good) {
        name_file(error, scenario->path);
    }
    return good;
}

/* ---- from the command line ---- */

/* A number in the SI unit without one, or a quantity. */
static bool read_quantity(const char *text, const char *unit, double *value, units_error_t *why)
{
    units_error_t ignored;
    if (strchr(text, '%') == NULL && units_read(text, "-", value, &ignored)) {
        return true;
    }
    return units_read(text, unit, value, why);
}

/* A whole number without sign; false: none, or beyond the largest. */
static bool read_whole(const char *text, uint64_t max, uint64_t *value)
{
    text += strspn(text, " \t");
    uint64_t result = 0;
    const size_t digits = strspn(text, "0123456789");
    if (digits == 0u || !is_spaces(text + digits)) {
        return false;
    }
    for (size_t n = 0; n < digits; n++) {
        const uint64_t digit = (uint64_t)(text[n] - '0');
        if (result > (max - digit) / 10u) {
            return false;
        }
        result = 10u * result + digit;
    }
    *value = result;
    return true;
}

static bool override_quantity(const char *name, const char *text, const char *unit, double min, double max,
                              double *value, scenario_error_t *error)
{
    units_error_t why;
    double result;
    if (!read_quantity(text, unit, &result, &why)) {
        char accepted[UNITS_TEXT_SIZE];
        return scenario_fail(error, nowhere, name, "%s; range %s", why.text,
                             units_range_text(accepted, min, max, unit));
    }
    if (!scenario_in_range(result, min, max, unit, nowhere, name, error)) {
        return false;
    }
    *value = result;
    return true;
}

static bool override_whole(const char *name, const char *text, uint64_t min, uint64_t max, uint64_t *value,
                           scenario_error_t *error)
{
    uint64_t result;
    if (!read_whole(text, max, &result) || result < min) {
        return scenario_fail(error, nowhere, name, "\"%.60s\": accepted: whole numbers %llu to %llu", text,
                             (unsigned long long)min, (unsigned long long)max);
    }
    *value = result;
    return true;
}

/* The value of the file is no longer used. */
static void mend(scenario_t *scenario, const table_row_t *row, const char *key)
{
    scenario_refusal_t **at = &scenario->memory->refused;
    while (*at != NULL) {
        const bool same =
            key != NULL ? (*at)->row == NULL && strcmp((*at)->key, key) == 0 : (*at)->row == row;
        if (same) {
            *at = (*at)->next;
        } else {
            at = &(*at)->next;
        }
    }
}

/* Keys of [run] and [start]. *known: the name was one of them. */
static bool override_run(scenario_t *scenario, const char *name, const char *text, bool *known,
                         scenario_error_t *error)
{
    static const char *const names[] = {"run.duration", "run.seed", "run.every", "start.speed",
                                        "start.angle"};
    *known = true;
    if (strcmp(name, "run.duration") == 0) {
        return override_quantity(name, text, "s", SCENARIO_SECONDS_MIN, SCENARIO_SECONDS_MAX,
                                 &scenario->duration, error);
    }
    if (strcmp(name, "run.seed") == 0) {
        return override_whole(name, text, 0u, UINT64_MAX, &scenario->seed, error);
    }
    if (strcmp(name, "run.every") == 0) {
        uint64_t every = scenario->every;
        const bool good = override_whole(name, text, 1u, SCENARIO_EVERY_MAX, &every, error);
        scenario->every = (uint32_t)every;
        return good;
    }
    if (strcmp(name, "start.speed") == 0 &&
        override_quantity(name, text, UNITS_SPEED, -SCENARIO_SPEED_MAX, SCENARIO_SPEED_MAX,
                          &scenario->start_speed, error)) {
        scenario->has_start = true;
        scenario->has_start_speed = true;
        return true;
    }
    if (strcmp(name, "start.angle") == 0 &&
        override_quantity(name, text, "rad", -SCENARIO_ANGLE_MAX, SCENARIO_ANGLE_MAX, &scenario->start_angle,
                          error)) {
        scenario->has_start = true;
        return true;
    }
    if (strcmp(name, "start.speed") == 0 || strcmp(name, "start.angle") == 0) {
        return false;
    }
    if (strcmp(name, "run.decimation") == 0) {
        return scenario_fail(error, nowhere, name, "this key is now called run.every");
    }
    *known = strncmp(name, "run.", 4) == 0 || strncmp(name, "start.", 6) == 0;
    if (*known) {
        names_search_t search = names_search(name);
        for (size_t n = 0; n < sizeof names / sizeof names[0]; n++) {
            names_consider(&search, names[n]);
        }
        const char *near = names_found(&search);
        return scenario_fail(
            error, nowhere, name,
            "no such key%s%s; accepted: run.duration, run.seed, run.every, start.speed, start.angle",
            near != NULL ? "; nearest: " : "", near != NULL ? near : "");
    }
    return true;
}

static bool override_row(scenario_t *scenario, const char *name, const char *text, scenario_error_t *error)
{
    const table_row_t *row = find_row(name, true, error);
    double value = 0.0;
    if (row == NULL) {
        return false;
    }
    units_error_t ignored;
    const bool pure =
        row->kind != SLOT_ENUM && strchr(text, '%') == NULL && units_read(text, "-", &value, &ignored);
    if ((!pure && !scenario_row_text_value(row, text, &value, nowhere, error)) ||
        !scenario_row_accepts(row, value, nowhere, error)) {
        return false;
    }
    scenario_event_t *initial = &scenario->events[0];
    uint32_t at = 0;
    while (at < initial->count && initial->settings[at].row != row) {
        at++;
    }
    initial->count += at == initial->count; /* there is room for every settable row */
    initial->settings[at] = (scenario_setting_t){row, value, nowhere};
    mend(scenario, row, NULL);
    return true;
}

bool scenario_override(scenario_t *scenario, const char *assignment, scenario_error_t *error)
{
    char name[NAMES_LENGTH_MAX * 2u];
    const char *equals = strchr(assignment, '=');
    snprintf(error->file, sizeof error->file, "--set %.200s", assignment);
    flatten(error->file);
    if (equals == NULL || equals == assignment) {
        return scenario_fail(error, nowhere, equals == NULL ? assignment : "=",
                             "accepted: NAME=VALUE, such as load_torque=\"5 N m\"");
    }
    const char *begin = assignment + strspn(assignment, " \t");
    size_t length = (size_t)(equals - begin);
    while (length > 0u && (begin[length - 1u] == ' ' || begin[length - 1u] == '\t')) {
        length--;
    }
    if (length == 0u || length >= sizeof name) {
        return scenario_fail(error, nowhere, "=", "accepted: NAME=VALUE, such as load_torque=\"5 N m\"");
    }
    snprintf(name, sizeof name, "%.*s", (int)length, begin);
    const char *value = equals + 1 + strspn(equals + 1, " \t");

    bool known;
    const bool good = override_run(scenario, name, value, &known, error);
    if (known && good) {
        mend(scenario, NULL, name);
    }
    return known ? good : override_row(scenario, name, value, error);
}
