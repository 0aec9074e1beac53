/* Values by the ids of their rows: tables, get and set, and the texts of refusals. */
#include <assert.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "host_sim/plant/flux_map_file.h"
#include "host_sim/rig/rig_parts.h"
#include "settings/reasons.h"
#include "settings/rules.h"
#include "settings/signals.h"

#define OTHERS_OF 4 /* [-] largest number of rows of a rule whose values a refusal prints */

static const table_t *const tables[TABLES] = {
    [PARAMS] = &params_table,         [REQUESTS] = &requests_table, [SIGNALS] = &signals_table,
    [SERVICES] = &services_table,     [TRUTH] = &truth_table,       [PLANT] = &plant_table,
    [CONDITIONS] = &conditions_table,
};

/* ---- tables ---- */

uint32_t rig_table_count(void)
{
    return TABLES;
}

const table_t *rig_table(uint32_t index)
{
    return index < TABLES ? tables[index] : NULL;
}

const table_row_t *rig_row(uint32_t id)
{
    for (uint32_t n = 0; n < TABLES; n++) {
        const table_row_t *row = table_by_id(tables[n], id);
        if (row != NULL) {
            return row;
        }
    }
    return NULL;
}

const table_row_t *rig_row_by_name(const char *name)
{
    const char *dot = strchr(name, '.');
    for (uint32_t n = 0; n < TABLES; n++) {
        const table_row_t *row = NULL;
        if (dot == NULL) {
            row = table_by_name(tables[n], name);
        } else if (strlen(tables[n]->name) == (size_t)(dot - name) &&
                   strncmp(tables[n]->name, name, (size_t)(dot - name)) == 0) {
            row = table_by_name(tables[n], dot + 1);
        }
        if (row != NULL) {
            return row;
        }
    }
    return NULL;
}

uint32_t rig_tables_hash(void)
{
    uint32_t hash = 0;
    for (uint32_t n = 0; n < TABLES; n++) {
        hash = table_hash(tables[n], hash);
    }
    return hash;
}

/* ---- values ---- */

bool rig_refuse(rig_t *rig, uint32_t id, int32_t reason, const char *text)
{
    rig->error_id = id;
    rig->error_reason = reason;
    rig->error_min = 1.0;
    rig->error_max = 0.0;
    snprintf(rig->error, sizeof rig->error, "%s", text);
    return false;
}

/* "inertia = 3 kg m^2: accepted: 1e-07 to 1 kg m^2" and the text after it. */
static bool refuse_in_favour(rig_t *rig, const table_row_t *row, int32_t reason, double value, double min,
                             double max, const char *behind)
{
    char text[sizeof rig->error];
    char number[RIG_NUMBER_SIZE];
    char range[RIG_RANGE_SIZE];
    const bool pure = strcmp(row->unit, "-") == 0;
    snprintf(text, sizeof text, "%.48s = %s%s%.24s: accepted: %s%.280s", row->name,
             rig_value_text(number, value), pure ? "" : " ", pure ? "" : row->unit,
             rig_range_text(range, row, min, max), behind);
    rig_refuse(rig, row->id, reason, text);
    rig->error_value = value;
    rig->error_min = min;
    rig->error_max = max;
    return false;
}

/* "; advised 281.8 V"; if no value of the row is accepted, the row to change. */
static void advice_text(char *to, size_t size, const params_error_t *why)
{
    const table_row_t *row = rig_row(why->change);
    char number[RIG_NUMBER_SIZE];
    if (row == NULL) {
        snprintf(to, size, "; a change of one row is not enough");
        return;
    }
    const bool own = why->change == why->id;
    const bool pure = strcmp(row->unit, "-") == 0;
    const size_t used = (size_t)snprintf(to, size, "%s%s", own ? "" : "; change ", own ? "" : row->name);
    if (why->advice != 0.0f) {
        snprintf(to + used, size - used, "%s advised %s%s%s", own ? ";" : ",",
                 rig_advice_text(number, (double)why->advice, own ? (double)why->min : rig_min(row),
                                 own ? (double)why->max : rig_max(row)),
                 pure ? "" : " ", pure ? "" : row->unit);
    }
}

/* "; with motor_inductance_d = 0.0052 H": the further values that a rule reads, if there are few.
 */
static void others_text(char *to, size_t size, const rig_t *rig, const params_error_t *why)
{
    size_t used = 0;
    to[0] = '\0';
    for (int32_t rule = 0; rule < (int32_t)RULES; rule++) {
        const bool told = why->rule == rules[rule].text && rules[rule].count <= OTHERS_OF;
        for (int32_t n = 0; told && n < rules[rule].count; n++) {
            const table_row_t *row = &params_table.rows[rules[rule].levers[n].row];
            const bool pure = strcmp(row->unit, "-") == 0;
            char number[RIG_NUMBER_SIZE];
            if (row->id != why->id && row->kind == SLOT_FLOAT && used < size) {
                used += (size_t)snprintf(to + used, size - used, "%s%s = %s%s%s",
                                         used > 0u ? ", " : "; with ", row->name,
                                         rig_value_text(number, rig_row_get(row, &rig->state.app.staged)),
                                         pure ? "" : " ", pure ? "" : row->unit);
            }
        }
    }
}

static bool refuse_value(rig_t *rig, const params_error_t *why)
{
    const table_row_t *row = rig_row(why->id);
    char text[sizeof rig->error];
    char numbers[2][RIG_NUMBER_SIZE];
    if (why->reason == REASON_BRIDGE_ON) {
        const bool pure = strcmp(row->unit, "-") == 0;
        const char *space = pure ? "" : " ";
        const char *unit = pure ? "" : row->unit;
        snprintf(text, sizeof text, "%s = %s%s%s: it changes only while the bridge is off; now %s%s%s",
                 row->name, rig_value_text(numbers[0], (double)why->value), space, unit,
                 rig_value_text(numbers[1], (double)why->min), space, unit);
        return rig_refuse(rig, why->id, why->reason, text);
    }
    char advice[128];
    char others[160];
    advice_text(advice, sizeof advice, why);
    others_text(others, sizeof others, rig, why);
    snprintf(text, sizeof text, " (%s)%s%s", why->rule, others, advice);
    return refuse_in_favour(rig, row, why->reason, (double)why->value, (double)why->min, (double)why->max,
                            text);
}

static bool refuse_range(rig_t *rig, const table_row_t *row, double value)
{
    return refuse_in_favour(rig, row, REASON_OUT_OF_RANGE, value, rig_min(row), rig_max(row), "");
}

bool rig_find(const rig_t *rig, uint32_t id, place_t *place)
{
    const rig_state_t *state = &rig->state;
    const void *const bases[TABLES] = {
        [PARAMS] = &state->app.active,     [REQUESTS] = &state->app.drive.requests,
        [SIGNALS] = &state->app.drive,     [SERVICES] = &state->app.services,
        [TRUTH] = &state->truth,           [PLANT] = &state->plant_values,
        [CONDITIONS] = &state->conditions,
    };
    for (table_number_t n = PARAMS; n < TABLES; n++) {
        place->row = table_by_id(tables[n], id);
        if (place->row != NULL) {
            place->table = n;
            place->base = bases[n];
            return true;
        }
    }
    return false;
}

bool rig_refuse_id(rig_t *rig, uint32_t id)
{
    char text[64];
    snprintf(text, sizeof text, "id %lu: no table has it", (unsigned long)id);
    return rig_refuse(rig, id, REASON_UNKNOWN_ID, text);
}

bool rig_get(rig_t *rig, uint32_t id, double *value)
{
    place_t place;
    if (!rig_find(rig, id, &place)) {
        return rig_refuse_id(rig, id);
    }
    *value = rig_row_get(place.row, place.base);
    return true;
}

static bool set_request(rig_t *rig, const table_row_t *row, double value)
{
    requests_t next = rig->state.app.drive.requests;
    params_error_t why;
    rig_row_put(row, &next, value);
    return app_request(&next, &why) || refuse_value(rig, &why);
}

/* The row of a refusal by an order may be in another table, or there may be no such row. */
static bool set_service(rig_t *rig, const table_row_t *row, double value)
{
    services_t next = rig->state.app.services;
    params_error_t why;
    rig_row_put(row, &next, value);
    if (services_write(row->id, table_bits(row, &next), &why)) {
        return true;
    }
    return rig_row(why.id) != NULL && why.id != SERVICE_ORDER ? refuse_value(rig, &why)
                                                              : rig_refuse(rig, why.id, why.reason, why.rule);
}

bool rig_is_flux_map(const table_row_t *row)
{
    return strcmp(row->name, "flux_map") == 0;
}

uint32_t rig_read_flux_map(const char *path, char *why, size_t size)
{
    return flux_map_file_read(path, why, size);
}

static bool set_plant(rig_t *rig, const table_row_t *row, double value)
{
    rig_state_t *state = &rig->state;
    rig_plant_t next = state->plant_values;
    rig_row_put(row, &next, value);
    const plant_params_t params = rig_plant_params(&next);
    plant_params_error_t why;
    if (!plant_params_check(&params, &why)) {
        /* A rule between rows may name another row than the one that was set. */
        const table_row_t *named = table_by_name(&plant_table, why.field);
        char behind[sizeof rig->error];
        snprintf(behind, sizeof behind, " (%s)", why.rule);
        return refuse_in_favour(rig, named, REASON_CROSS_RULE, why.value, why.minimum, why.maximum, behind);
    }
    const bool switches = row->offset == offsetof(rig_plant_t, open_switches) ||
                          row->offset == offsetof(rig_plant_t, shorted_switches);
    if (switches && value != 0.0 && state->conditions.fidelity != 0) {
        return refuse_in_favour(rig, row, REASON_CROSS_RULE, value, 0.0, 0.0,
                                " (fidelity = averaged has no single switches; use switched)");
    }
    plant_advance(&state->plant,
                  chip_now(&state->chip)); /* the plant advances to the present tick with the old values */
    state->plant_values = next;
    plant_set_params(&state->plant, &params);
    rig_follow_fault_line(rig);
    return true;
}

/* Flips a bit of the application's memory, as radiation or a disturbed supply may do. */
static void flip(app_t *at, uint32_t word, uint32_t bit)
{
    char *place = (char *)at + word * sizeof(uint32_t) % sizeof *at;
    uint32_t bits;
    memcpy(&bits, place, sizeof bits);
    bits ^= UINT32_C(1) << bit;
    memcpy(place, &bits, sizeof bits);
}

/* Actions at the moment when a row is set; the row then reads as before. */
static void happen_once(rig_t *rig, const table_row_t *row)
{
    rig_state_t *state = &rig->state;
    rig_conditions_t *now = &state->conditions;
    if (row->offset == offsetof(rig_conditions_t, estimate_jump)) {
        rig_turn_estimate(&state->app.drive.fast.estimator, now->estimate_jump);
        now->estimate_jump = 0.0f;
    }
    if (row->offset == offsetof(rig_conditions_t, missing_samples)) {
        chip_miss_samples(&state->chip, (uint32_t)now->missing_samples);
        now->missing_samples = 0.0f;
    }
    if (row->offset == offsetof(rig_conditions_t, flip_word) && now->flip_word >= 0.0f) {
        flip(&state->app, (uint32_t)now->flip_word, (uint32_t)now->flip_bit);
        now->flip_word = -1.0f;
    }
    if (row->offset == offsetof(rig_conditions_t, flip_memory) && now->flip_memory != 0) {
        const uint32_t memory = (uint32_t)now->flip_memory - 1u;
        const uint32_t bit = (uint32_t)now->flip_bit % 16u;
        if (memory < CHIP_MEMORY_REGIONS) {
            chip_flip_memory(&state->chip, memory, CHIP_MEMORY_WORDS / 2u, bit);
        } else {
            flip(&state->app, (uint32_t)(offsetof(app_t, active) / sizeof(uint32_t)), bit);
        }
        now->flip_memory = 0;
    }
}

/* Values of a row that the present state of the rig does not permit, in addition to its range. */
static bool refuse_condition(rig_t *rig, const table_row_t *row, double value)
{
    const rig_plant_t *plant = &rig->state.plant_values;
    const bool whole = row->offset == offsetof(rig_conditions_t, missing_samples) ||
                       row->offset == offsetof(rig_conditions_t, flip_bit) ||
                       row->offset == offsetof(rig_conditions_t, flip_word);
    if (whole && value != floor(value)) {
        return refuse_in_favour(rig, row, REASON_OUT_OF_RANGE, value, rig_min(row), rig_max(row),
                                " (must be a whole number)");
    }
    if (BOARD_ENABLE_INPUT == BOARD_NONE && row->offset == offsetof(rig_conditions_t, enable_input) &&
        value != 0.0) {
        return rig_refuse(rig, row->id, REASON_CROSS_RULE,
                          "enable_input = lost: this board has no enable input (BOARD_ENABLE_INPUT)");
    }
    if (row->offset == offsetof(rig_conditions_t, fidelity) && value != 0.0 &&
        (plant->open_switches != 0.0f || plant->shorted_switches != 0.0f)) {
        return rig_refuse(rig, row->id, REASON_CROSS_RULE,
                          "fidelity = averaged: a mean voltage has no single switches; open_switches and "
                          "shorted_switches must be 0");
    }
    return true;
}

static bool set_condition(rig_t *rig, const table_row_t *row, double value)
{
    rig_state_t *state = &rig->state;
    rig_conditions_t *now = &state->conditions;
    if (!refuse_condition(rig, row, value)) {
        return false;
    }
    rig_row_put(row, now, value);
    chip_set_averaged(&state->chip, now->fidelity != 0);
    chip_set_interrupt_delay(&state->chip, (uint32_t)((double)now->interrupt_delay * 150e6 + 0.5));
    chip_stick_adc(&state->chip, BOARD_CURRENT_A_INPUT, (int32_t)now->stuck_current_a);
    chip_stick_adc(&state->chip, BOARD_CURRENT_B_INPUT, (int32_t)now->stuck_current_b);
    if (BOARD_CURRENT_SENSORS == 3) {
        chip_stick_adc(&state->chip, BOARD_CURRENT_C_INPUT, (int32_t)now->stuck_current_c);
    }
    chip_stick_adc(&state->chip, BOARD_DC_INPUT, (int32_t)now->stuck_dc_link);
    if (row->offset == offsetof(rig_conditions_t, enable_input)) {
        rig_drive_enable_input(rig);
    }
    if (row->offset == offsetof(rig_conditions_t, metering)) {
        plant_set_metering(&state->plant, now->metering != 0);
    }
    if (row->offset == offsetof(rig_conditions_t, brake_torque)) {
        plant_advance(&state->plant, chip_now(&state->chip)); /* another source was active until now */
        plant_set_brake(&state->plant, (double)now->brake_torque);
    }
    happen_once(rig, row);
    return true;
}

bool rig_set(rig_t *rig, uint32_t id, double value)
{
    place_t place;
    if (!rig_find(rig, id, &place)) {
        return rig_refuse_id(rig, id);
    }
    const table_row_t *row = place.row;
    if (row->access == TABLE_READ) {
        char text[sizeof rig->error];
        snprintf(text, sizeof text, "%s: it can be read, not set", row->name);
        return rig_refuse(rig, id, REASON_READ_ONLY, text);
    }
    if (!rig_accepts(row, value)) {
        return refuse_range(rig, row, value);
    }

    rig_bind(rig);
    switch (place.table) {
    case PARAMS:
        rig_row_put(row, &rig->state.app.staged, value);
        return true;
    case REQUESTS:
        return set_request(rig, row, value);
    case SERVICES:
        return set_service(rig, row, value);
    case PLANT:
        return set_plant(rig, row, value);
    case CONDITIONS:
        return set_condition(rig, row, value);
    case SIGNALS:
    case TRUTH:
    case TABLES:
        break;
    }
    return false;
}

bool rig_apply(rig_t *rig)
{
    params_error_t why;
    rig_bind(rig);
    return app_apply(&why) || refuse_value(rig, &why);
}

double rig_value(rig_t *rig, const char *name)
{
    const table_row_t *row = rig_row_by_name(name);
    double value = 0.0;
    assert(row != NULL);
    (void)rig_get(rig, row->id, &value);
    return value;
}

bool rig_put(rig_t *rig, const char *name, double value)
{
    const table_row_t *row = rig_row_by_name(name);
    if (row == NULL) {
        char text[sizeof rig->error];
        snprintf(text, sizeof text, "%s: no table has a row of this name", name);
        return rig_refuse(rig, 0u, REASON_UNKNOWN_ID, text);
    }
    return rig_set(rig, row->id, value);
}

const char *rig_error(const rig_t *rig)
{
    return rig->error;
}

uint32_t rig_error_id(const rig_t *rig)
{
    return rig->error_id;
}

int32_t rig_error_reason(const rig_t *rig)
{
    return rig->error_reason;
}

bool rig_error_range(const rig_t *rig, double *value, double *min, double *max)
{
    if (!(rig->error_min <= rig->error_max)) {
        return false;
    }
    *value = rig->error_value;
    *min = rig->error_min;
    *max = rig->error_max;
    return true;
}
