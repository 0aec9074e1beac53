/* Values by the ids of their rows: tables, get and set, and what a refusal has to say. */
#include <assert.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "drive/reasons.h"
#include "drive/signals.h"
#include "host_sim/rig/rig_parts.h"

static const table_t *const tables[TABLES] = {
    [PARAMS] = &params_table, [REQUESTS] = &requests_table, [SIGNALS] = &signals_table,
    [TRUTH] = &truth_table,   [PLANT] = &plant_table,       [CONDITIONS] = &conditions_table,
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
    snprintf(rig->error, sizeof rig->error, "%s", text);
    return false;
}

/* " ohm"; nothing for pure numbers. */
static const char *unit_after(const table_row_t *row, char text[24])
{
    snprintf(text, 24, " %s", row->unit);
    return strcmp(row->unit, "-") == 0 ? "" : text;
}

static bool refuse_value(rig_t *rig, const params_error_t *why)
{
    char text[sizeof rig->error];
    char buffer[24];
    const char *unit = unit_after(rig_row(why->id), buffer);
    if (why->reason == REASON_BRIDGE_ON) {
        snprintf(text, sizeof text, "%s = %.7g%s: it changes only while the bridge is off; now %.7g%s",
                 why->field, (double)why->value, unit, (double)why->min, unit);
    } else {
        snprintf(text, sizeof text, "%s = %.7g%s: accepted %.7g to %.7g%s (%s)", why->field,
                 (double)why->value, unit, (double)why->min, (double)why->max, unit, why->rule);
    }
    return rig_refuse(rig, why->id, why->reason, text);
}

static bool refuse_range(rig_t *rig, const table_row_t *row, double value)
{
    char text[sizeof rig->error];
    char buffer[24];
    const char *unit = unit_after(row, buffer);
    snprintf(text, sizeof text, "%s = %.7g%s: accepted %s%.7g to %.7g%s", row->name, value, unit,
             row->kind == SLOT_FLOAT ? "" : "whole numbers ", (double)row->min, (double)table_max(row), unit);
    return rig_refuse(rig, row->id, REASON_OUT_OF_RANGE, text);
}

bool rig_find(const rig_t *rig, uint32_t id, place_t *place)
{
    const rig_state_t *state = &rig->state;
    const void *const bases[TABLES] = {
        [PARAMS] = &state->app.active,  [REQUESTS] = &state->app.drive.requests,
        [SIGNALS] = &state->app.drive,  [TRUTH] = &state->truth,
        [PLANT] = &state->plant_values, [CONDITIONS] = &state->conditions,
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

static double number_at(const place_t *place)
{
    const uint32_t bits = table_bits(place->row, place->base);
    switch (place->row->kind) {
    case SLOT_UINT:
        return (double)bits;
    case SLOT_INT:
    case SLOT_ENUM:
        return (double)(int32_t)bits;
    case SLOT_FLOAT:
    case SLOT_KINDS:
        break;
    }
    return (double)table_get(place->row, place->base);
}

bool rig_get(rig_t *rig, uint32_t id, double *value)
{
    place_t place;
    if (!rig_find(rig, id, &place)) {
        return rig_refuse_id(rig, id);
    }
    *value = number_at(&place);
    return true;
}

static bool set_request(rig_t *rig, const table_row_t *row, float value)
{
    requests_t next = rig->state.app.drive.requests;
    params_error_t why;
    table_set(row, &next, value);
    return app_request(&next, &why) || refuse_value(rig, &why);
}

static bool set_plant(rig_t *rig, const table_row_t *row, float value)
{
    rig_state_t *state = &rig->state;
    rig_plant_t next = state->plant_values;
    table_set(row, &next, value);
    const plant_params_t params = rig_plant_params(&next);
    plant_params_error_t why;
    if (!plant_params_check(&params, &why)) {
        /* A rule between rows may speak of another one than was set. */
        const table_row_t *named = table_by_name(&plant_table, why.field);
        char text[sizeof rig->error];
        char buffer[24];
        const char *unit = unit_after(named, buffer);
        snprintf(text, sizeof text, "%s = %.7g%s: accepted %.7g to %.7g%s (%s)", named->name, why.value, unit,
                 why.minimum, why.maximum, unit, why.rule);
        return rig_refuse(rig, named->id, REASON_CROSS_RULE, text);
    }
    plant_advance(&state->plant, chip_now(&state->chip)); /* until now the old ones act */
    state->plant_values = next;
    plant_set_params(&state->plant, &params);
    rig_follow_fault_line(rig);
    return true;
}

static void set_condition(rig_t *rig, const table_row_t *row, float value)
{
    rig_state_t *state = &rig->state;
    rig_conditions_t *now = &state->conditions;
    table_set(row, now, value);
    chip_set_averaged(&state->chip, now->fidelity != 0);
    chip_set_interrupt_delay(&state->chip, (uint32_t)((double)now->interrupt_delay * 150e6 + 0.5));
    chip_stick_adc(&state->chip, BOARD_CURRENT_A_INPUT, (int32_t)now->stuck_current_a);
    chip_stick_adc(&state->chip, BOARD_CURRENT_B_INPUT, (int32_t)now->stuck_current_b);
    if (BOARD_CURRENT_SENSORS == 3) {
        chip_stick_adc(&state->chip, BOARD_CURRENT_C_INPUT, (int32_t)now->stuck_current_c);
    }
    chip_stick_adc(&state->chip, BOARD_DC_INPUT, (int32_t)now->stuck_dc_link);
    if (row->offset == offsetof(rig_conditions_t, metering)) {
        plant_set_metering(&state->plant, now->metering != 0);
    }
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
        snprintf(text, sizeof text, "%s: it is shown, not set", row->name);
        return rig_refuse(rig, id, REASON_READ_ONLY, text);
    }
    if (!(fabs(value) <= 3.4e38) || !table_accepts(row, (float)value)) {
        return refuse_range(rig, row, value);
    }

    rig_bind(rig);
    switch (place.table) {
    case PARAMS:
        table_set(row, &rig->state.app.staged, (float)value);
        return true;
    case REQUESTS:
        return set_request(rig, row, (float)value);
    case PLANT:
        return set_plant(rig, row, (float)value);
    case CONDITIONS:
        set_condition(rig, row, (float)value);
        return true;
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
