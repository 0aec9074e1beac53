#include "contract/table.h"

#include <string.h>

#include "math/float_bits.h"

const table_row_t *table_by_id(const table_t *table, uint32_t id)
{
    for (uint32_t n = 0; n < table->count; n++) {
        if (table->rows[n].id == id) {
            return &table->rows[n];
        }
    }
    return NULL;
}

const table_row_t *table_by_name(const table_t *table, const char *name)
{
    for (uint32_t n = 0; n < table->count; n++) {
        if (strcmp(table->rows[n].name, name) == 0) {
            return &table->rows[n];
        }
    }
    return NULL;
}

static const void *slot_of(const table_row_t *row, const void *base)
{
    return (const char *)base + row->offset;
}

int64_t table_whole(const table_row_t *row, const void *base)
{
    const void *slot = slot_of(row, base);
    return row->kind == SLOT_UINT ? (int64_t) * (const uint32_t *)slot : (int64_t) * (const int32_t *)slot;
}

void table_set_whole(const table_row_t *row, void *base, int64_t value)
{
    void *slot = (char *)base + row->offset;
    if (row->kind == SLOT_UINT) {
        *(uint32_t *)slot = (uint32_t)value;
    } else {
        *(int32_t *)slot = (int32_t)value;
    }
}

float table_get(const table_row_t *row, const void *base)
{
    return row->kind == SLOT_FLOAT ? *(const float *)slot_of(row, base) : (float)table_whole(row, base);
}

void table_set(const table_row_t *row, void *base, float value)
{
    void *slot = (char *)base + row->offset;
    if (row->kind == SLOT_FLOAT) {
        *(float *)slot = value;
    } else {
        table_set_whole(row, base, (int64_t)(value + (value < 0.0f ? -0.5f : 0.5f)));
    }
}

uint32_t table_bits(const table_row_t *row, const void *base)
{
    uint32_t bits;
    memcpy(&bits, slot_of(row, base), sizeof bits);
    return bits;
}

void table_set_bits(const table_row_t *row, void *base, uint32_t bits)
{
    memcpy((char *)base + row->offset, &bits, sizeof bits);
}

static int64_t whole_of_bits(const table_row_t *row, uint32_t bits)
{
    const int64_t value = (int64_t)bits;
    return row->kind == SLOT_UINT || bits <= UINT32_C(0x7FFFFFFF) ? value : value - INT64_C(0x100000000);
}

float table_value_of_bits(const table_row_t *row, uint32_t bits)
{
    return row->kind == SLOT_FLOAT ? float_of_bits(bits) : (float)whole_of_bits(row, bits);
}

int32_t table_whole_max(const table_row_t *row)
{
    if (row->kind != SLOT_ENUM) {
        return row->whole.max;
    }
    int32_t last = 0;
    for (const char *c = row->choices; *c != '\0'; c++) {
        last += *c == '|' ? 1 : 0;
    }
    return last;
}

float table_min(const table_row_t *row)
{
    return row->kind == SLOT_FLOAT ? row->min : (float)row->whole.min;
}

float table_max(const table_row_t *row)
{
    return row->kind == SLOT_FLOAT ? row->max : (float)table_whole_max(row);
}

bool table_accepts_whole(const table_row_t *row, int64_t value)
{
    return value >= row->whole.min && value <= table_whole_max(row);
}

bool table_accepts(const table_row_t *row, float value)
{
    if (!(value >= table_min(row) && value <= table_max(row))) { /* also rejects NaN */
        return false;
    }
    return row->kind == SLOT_FLOAT || value == (float)(int32_t)value;
}

bool table_accepts_bits(const table_row_t *row, uint32_t bits)
{
    return row->kind == SLOT_FLOAT ? table_accepts(row, float_of_bits(bits))
                                   : table_accepts_whole(row, whole_of_bits(row, bits));
}

bool table_holds(const table_row_t *row, const void *base)
{
    return row->kind == SLOT_FLOAT ? table_accepts(row, table_get(row, base))
                                   : table_accepts_whole(row, table_whole(row, base));
}

void table_default(const table_row_t *row, void *base)
{
    if (row->kind == SLOT_FLOAT) {
        table_set(row, base, row->initial);
    } else {
        table_set_whole(row, base, row->whole.initial);
    }
}

void table_defaults(const table_t *table, void *base)
{
    for (uint32_t n = 0; n < table->count; n++) {
        table_default(&table->rows[n], base);
    }
}

int32_t table_choice(const table_row_t *row, const char *name)
{
    const size_t length = strlen(name);
    const char *choice = row->choices;
    int32_t value = 0;
    while (*choice != '\0') {
        const char *bar = strchr(choice, '|');
        const size_t size = bar != NULL ? (size_t)(bar - choice) : strlen(choice);
        if (size == length && strncmp(choice, name, size) == 0) {
            return value;
        }
        if (bar == NULL) {
            break;
        }
        choice = bar + 1;
        value++;
    }
    return -1;
}

static uint32_t hash_octet(uint32_t hash, uint32_t octet)
{
    return (hash ^ (octet & 0xFFu)) * UINT32_C(16777619);
}

static uint32_t hash_text(uint32_t hash, const char *text)
{
    for (; *text != '\0'; text++) {
        hash = hash_octet(hash, (uint32_t)*text);
    }
    return hash_octet(hash, 0u);
}

uint32_t table_hash(const table_t *table, uint32_t seed)
{
    uint32_t hash = seed ^ UINT32_C(2166136261);
    for (uint32_t n = 0; n < table->count; n++) {
        const table_row_t *row = &table->rows[n];
        for (uint32_t shift = 0u; shift < 32u; shift += 8u) {
            hash = hash_octet(hash, row->id >> shift);
        }
        hash = hash_octet(hash, (uint32_t)row->kind);
        hash = hash_text(hash, row->name);
        hash = hash_text(hash, row->unit);
        hash = hash_text(hash, row->choices);
    }
    return hash;
}
