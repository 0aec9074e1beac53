#include "app/talk_modbus.h"

#include "app/app.h"
#include "app/talk_values.h"
#include "contract/line.h"

#define ID_OF_HASH UINT32_C(0) /* no row has this id */

/* The table that contains this id; APP_TABLES: none. */
static uint32_t table_of(uint32_t id)
{
    uint32_t number = 0u;
    while (number < (uint32_t)APP_TABLES && table_by_id(app_tables[number], id) == NULL) {
        number++;
    }
    return number;
}

/* Numbers between the first and the last id of a table that are no ids read as 0, so that a client may read a
 * block. */
static uint32_t read_gap(uint32_t id, uint32_t *slot)
{
    uint16_t octets[4];
    *slot = 0u;
    for (uint32_t number = 0; number < (uint32_t)APP_TABLES; number++) {
        if (talk_access.read(number, 4u * id, 4u, octets) == XCP_OK) {
            return MODBUS_OK;
        }
    }
    return MODBUS_ILLEGAL_ADDRESS;
}

static uint32_t bits_of(const uint16_t *octets)
{
    return (uint32_t)octets[0] | (uint32_t)octets[1] << 8 | (uint32_t)octets[2] << 16 |
           (uint32_t)octets[3] << 24;
}

/* A named value is the number of its choice. */
static uint32_t row_slot(uint32_t id, uint32_t *slot)
{
    uint16_t octets[4];
    const uint32_t number = table_of(id);
    if (id == ID_OF_HASH) {
        *slot = app_tables_hash();
        return MODBUS_OK;
    }
    if (number == (uint32_t)APP_TABLES) {
        return read_gap(id, slot);
    }
    if (talk_access.read(number, 4u * id, 4u, octets) != XCP_OK) {
        return MODBUS_ILLEGAL_ADDRESS;
    }
    (void)line_bits_back(table_by_id(app_tables[number], id), bits_of(octets), slot);
    return MODBUS_OK;
}

static bool whole(uint32_t id)
{
    const uint32_t number = table_of(id);
    return number < (uint32_t)APP_TABLES && table_by_id(app_tables[number], id)->kind != SLOT_FLOAT;
}

bool talk_modbus_locked(void)
{
    const uint32_t key = talk_access.key();
    return key != 0u && app->talk.modbus_key != key;
}

/* What a locked drive accepts of one slot: its key, written to the parameter line_key, and a quick stop. */
static uint32_t write_locked(const table_row_t *row, uint32_t number, uint32_t slot)
{
    const size_t line_key = offsetof(params_t, line_key);
    if (number == (uint32_t)APP_TABLE_PARAMS && row->offset == line_key) {
        app->talk.modbus_key = slot;
        return talk_modbus_locked() ? MODBUS_ILLEGAL_FUNCTION : MODBUS_OK;
    }
    const uint32_t coded = line_bits(row, slot);
    if (!talk_access.stops(number, 4u * row->id, coded)) {
        return MODBUS_ILLEGAL_FUNCTION;
    }
    return talk_access.write(number, 4u * row->id, 1u, &coded) == XCP_OK ? MODBUS_OK : MODBUS_FAILURE;
}

static uint32_t write_rows(uint32_t id, uint32_t count, const uint32_t *slots)
{
    uint32_t coded[MODBUS_WRITE_MOST / 2u];
    const uint32_t number = table_of(id);
    if (number == (uint32_t)APP_TABLES || number == (uint32_t)APP_TABLE_SIGNALS) {
        return MODBUS_ILLEGAL_ADDRESS;
    }
    for (uint32_t n = 0; n < count; n++) {
        const table_row_t *row = table_by_id(app_tables[number], id + n);
        if (row == NULL || row->access == TABLE_READ) {
            return MODBUS_ILLEGAL_ADDRESS;
        }
        if (!table_accepts_bits(row, slots[n])) {
            return MODBUS_ILLEGAL_VALUE;
        }
        coded[n] = line_bits(row, slots[n]);
    }
    if (talk_modbus_locked()) {
        return count == 1u ? write_locked(table_by_id(app_tables[number], id), number, slots[0])
                           : MODBUS_ILLEGAL_FUNCTION;
    }
    return talk_access.write(number, 4u * id, count, coded) == XCP_OK ? MODBUS_OK : MODBUS_FAILURE;
}

const modbus_access_t talk_modbus_access = {.read = row_slot, .write = write_rows, .whole = whole};
