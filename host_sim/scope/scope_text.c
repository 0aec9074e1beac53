#include "host_sim/scope/scope_text.h"

#include <stdlib.h>
#include <string.h>

#include "contract/line.h"
#include "host_sim/lab/json.h"
#include "host_sim/lab/units.h"
#include "host_sim/line/master.h"
#include "host_sim/rig/rig.h"
#include "settings/faults.h"
#include "settings/reasons.h"

#define RPM_PER_RAD_S 9.549296585513721 /* 30/pi */

/* ---- rows ---- */

static void insert(scope_values_t *values, const table_t *table, const table_row_t *row)
{
    uint32_t at = values->count;
    while (at > 0u && values->rows[at - 1u]->id > row->id) {
        values->rows[at] = values->rows[at - 1u];
        values->tables[at] = values->tables[at - 1u];
        at--;
    }
    values->rows[at] = row;
    values->tables[at] = table->name;
    values->count++;
}

void scope_values_init(scope_values_t *values)
{
    memset(values, 0, sizeof *values);
    for (uint32_t t = 0; t < rig_table_count(); t++) {
        const table_t *table = rig_table(t);
        for (uint32_t n = 0; n < table->count && values->count < SCOPE_ROWS_MAX; n++) {
            master_extension_t extension;
            uint32_t address;
            if (master_place(&table->rows[n], &extension, &address)) {
                insert(values, table, &table->rows[n]);
            }
        }
    }
}

uint32_t scope_values_place(const scope_values_t *values, uint32_t id)
{
    uint32_t n = 0;
    while (n < values->count && values->rows[n]->id != id) {
        n++;
    }
    return n;
}

double scope_number(const table_row_t *row, uint32_t on_line)
{
    float number;
    uint32_t bits = 0;
    (void)line_bits_back(row, on_line, &bits);
    switch (row->kind) {
    case SLOT_UINT:
        return (double)bits;
    case SLOT_INT:
    case SLOT_ENUM:
        return (double)(int32_t)bits;
    case SLOT_FLOAT:
    case SLOT_KINDS:
        break;
    }
    memcpy(&number, &bits, sizeof number);
    return (double)number;
}

static void choices_text(FILE *to, const char *choices)
{
    char name[64];
    fputc('[', to);
    for (const char *at = choices; *at != '\0'; at += strspn(at, "|")) {
        const size_t length = strcspn(at, "|");
        snprintf(name, sizeof name, "%.*s", (int)length, at);
        fputs(at == choices ? "" : ",", to);
        json_text(to, name);
        at += length;
    }
    fputc(']', to);
}

static void number_text(FILE *to, const char *key, double number)
{
    fprintf(to, ",\"%s\":", key);
    json_number(to, number);
}

static void row_text(FILE *to, const char *table, const table_row_t *row)
{
    static const char *const kinds[] = {"float", "int", "uint", "enum"};
    static const char *const accesses[] = {"read", "live", "off"};
    const char *unit = units_of_row(row);
    const bool speed = strcmp(unit, UNITS_SPEED) == 0;
    const bool acceleration = strcmp(unit, UNITS_ACCELERATION) == 0;
    fprintf(to, "{\"id\":%u,\"table\":\"%s\",\"name\":", (unsigned)row->id, table);
    json_text(to, row->name);
    fprintf(to, ",\"kind\":\"%s\",\"access\":\"%s\",\"unit\":", kinds[row->kind], accesses[row->access]);
    json_text(to, row->unit);
    fprintf(to, ",\"shown\":");
    json_text(to, speed ? "r/min" : acceleration ? "r/min/s" : row->unit);
    number_text(to, "factor", speed || acceleration ? RPM_PER_RAD_S : 1.0);
    fprintf(to, ",\"choices\":");
    choices_text(to, row->choices);
    fprintf(to, ",\"text\":");
    json_text(to, row->text);
    if (row->access != TABLE_READ) {
        number_text(to, "min", rig_min(row));
        number_text(to, "max", rig_max(row));
        number_text(to, "initial", rig_initial(row));
    }
    fputc('}', to);
}

void scope_rows_text(FILE *to, const scope_values_t *values)
{
    fputc('[', to);
    for (uint32_t n = 0; n < values->count; n++) {
        fputs(n == 0u ? "" : ",", to);
        row_text(to, values->tables[n], values->rows[n]);
    }
    fputc(']', to);
}

/* ---- reasons ---- */

void scope_reasons_text(FILE *to)
{
    fputc('{', to);
    for (uint32_t n = 0; n < reasons_count; n++) {
        fprintf(to, "%s\"%d\":{\"name\":", n == 0u ? "" : ",", (int)reasons[n].number);
        json_text(to, reasons[n].name);
        fputs(",\"text\":", to);
        json_text(to, reasons[n].text);
        fputs(",\"remedy\":", to);
        json_text(to, reasons[n].remedy);
        fputc('}', to);
    }
    fputc('}', to);
}

void scope_warnings_text(FILE *to)
{
    fputc('[', to);
    for (uint32_t bit = 0; bit < (uint32_t)FAULTS; bit++) {
        fprintf(to, "%s%d", bit == 0u ? "" : ",", (int)fault_rows[bit].reason);
    }
    fputc(']', to);
}

/* ---- values ---- */

uint32_t scope_values_text(FILE *to, scope_values_t *values, bool all)
{
    uint32_t told = 0;
    fputc('{', to);
    for (uint32_t n = 0; n < values->count; n++) {
        if (values->known[n] && (all || values->news[n])) {
            fprintf(to, "%s\"%u\":", told++ == 0u ? "" : ",", (unsigned)values->rows[n]->id);
            const double number = scope_number(values->rows[n], values->bits[n]);
            if (values->rows[n]->kind == SLOT_FLOAT) {
                json_number(to, number);
            } else {
                fprintf(to, "%.0f", number);
            }
        }
        values->news[n] = values->news[n] && all;
    }
    fputc('}', to);
    return told;
}

void scope_base64(FILE *to, const uint8_t *octets, size_t count)
{
    static const char letters[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    for (size_t n = 0; n < count; n += 3u) {
        const size_t left = count - n;
        const uint32_t three = (uint32_t)octets[n] << 16 | (left > 1u ? (uint32_t)octets[n + 1u] << 8 : 0u) |
                               (left > 2u ? (uint32_t)octets[n + 2u] : 0u);
        fputc(letters[three >> 18], to);
        fputc(letters[three >> 12 & 63u], to);
        fputc(left > 1u ? letters[three >> 6 & 63u] : '=', to);
        fputc(left > 2u ? letters[three & 63u] : '=', to);
    }
}

bool scope_read(const table_row_t *row, const char *text, double *value, char *why, size_t size)
{
    char *end = NULL;
    units_error_t error;
    const double number = strtod(text, &end);
    if (row->kind == SLOT_ENUM) {
        const int32_t choice = table_choice(row, text);
        *value = (double)choice;
        if (choice < 0) {
            snprintf(why, size, "%s: %s is none of %s", row->name, text, row->choices);
        }
        return choice >= 0;
    }
    if (end != text && *end == '\0') {
        *value = number;
        return true;
    }
    if (!units_read(text, units_of_row(row), value, &error)) {
        snprintf(why, size, "%s: %s", row->name, error.text);
        return false;
    }
    return true;
}
