#include "app/talk_values.h"

#include "app/app.h"
#include "app/talk_texts.h"
#include "contract/line.h"
#include "settings/reasons.h"
#include "settings/signals.h"

/* ---- slots ---- */

/* The struct of a table; for the parameters the set of the client's page. */
static const void *base_of(uint32_t table)
{
    const void *params = app->talk.xcp.page == XCP_PAGE_ACTIVE ? &app->active : &app->staged;
    const void *const bases[APP_TABLES] = {
        [APP_TABLE_SIGNALS] = &app->drive,
        [APP_TABLE_PARAMS] = params,
        [APP_TABLE_REQUESTS] = &app->drive.requests,
        [APP_TABLE_SERVICES] = &app->services,
    };
    return bases[table];
}

/* The key is shown only to a client that has unlocked the drive with it. */
static bool is_hidden(uint32_t number, const table_row_t *row)
{
    const size_t line_key = offsetof(params_t, line_key);
    return number == (uint32_t)APP_TABLE_PARAMS && row->offset == line_key && app->talk.xcp.locked != 0u;
}

/* The octets of a slot that starts at `at`, as far as they are in a block of `count` octets from `address`
 * on. */
static void put_slot(uint32_t at, uint32_t bits, uint32_t address, uint32_t count, uint16_t *octets)
{
    for (uint32_t n = 0u; n < 4u; n++) {
        if (at + n >= address && at + n < address + count) {
            octets[at + n - address] = (uint16_t)(bits >> 8u * n & 0xFFu);
        }
    }
}

/* A block of a table, in one pass over its rows. Numbers between the first and the last id that are no ids
 * read as 0, so that a client may read a table in one block. */
static uint32_t read_rows(uint32_t number, uint32_t address, uint32_t count, uint16_t *octets)
{
    const table_t *table = app_tables[number];
    const void *base = base_of(number);
    const uint32_t first = address / 4u;
    const uint32_t last = (address + count - 1u) / 4u;
    bool begun = false;
    bool ends = false;
    for (uint32_t n = 0u; n < count; n++) {
        octets[n] = 0u;
    }
    for (uint32_t n = 0u; n < table->count; n++) {
        const table_row_t *row = &table->rows[n];
        begun = begun || row->id <= first;
        ends = ends || row->id >= last;
        if (row->id >= first && row->id <= last && !is_hidden(number, row)) {
            put_slot(4u * row->id, line_bits(row, table_bits(row, base)), address, count, octets);
        }
    }
    return begun && ends ? XCP_OK : XCP_OUT_OF_RANGE;
}

/* Two slots per fault, the newest first: reason and period. */
static bool fault_bits(uint32_t place, uint32_t *bits)
{
    const drive_fault_log_t *log = &app->drive.log;
    const uint32_t ago = place / 2u;
    if (ago >= FAULT_LOG_LENGTH) {
        return false;
    }
    *bits = 0u;
    if (ago < log->count) {
        const drive_fault_t *fault = &log->faults[(log->count - 1u - ago) % FAULT_LOG_LENGTH];
        *bits = place % 2u == 0u ? (uint32_t)fault->reason : fault->period;
    }
    return true;
}

static bool slot_bits(uint32_t extension, uint32_t number, uint32_t *bits)
{
    return (extension == TALK_FAULTS && fault_bits(number, bits)) ||
           (extension == TALK_CAPTURE && capturing_slot(number, bits));
}

static uint32_t read_slots(uint32_t extension, uint32_t address, uint32_t count, uint16_t *octets)
{
    const uint32_t end = address + count;
    for (uint32_t at = address & ~UINT32_C(3); at < end; at += 4u) {
        uint32_t bits = 0u;
        if (!slot_bits(extension, at / 4u, &bits)) {
            return XCP_OUT_OF_RANGE;
        }
        put_slot(at, bits, address, count, octets);
    }
    return XCP_OK;
}

#define EPK_SLOTS 4u

/* A description contains the address of the identification, but not its extension: it can also be read at
 * extension 0, where no signal has this address. */
static bool is_epk(uint32_t extension, uint32_t address)
{
    return extension == (uint32_t)APP_TABLE_SIGNALS && address < 4u * EPK_SLOTS;
}

static uint32_t read(uint32_t extension, uint32_t address, uint32_t count, uint16_t *octets)
{
    if (is_epk(extension, address)) {
        return talk_read_text(XCP_EXTENSION_EPK, address, count, octets);
    }
    if (extension < (uint32_t)APP_TABLES) {
        return read_rows(extension, address, count, octets);
    }
    return talk_is_text(extension) ? talk_read_text(extension, address, count, octets)
                                   : read_slots(extension, address, count, octets);
}

/* ---- writing ---- */

static uint32_t write_params(uint32_t first, uint32_t count, const uint32_t *slots)
{
    params_t next = app->staged;
    if (app->talk.xcp.page != XCP_PAGE_STAGED) {
        return XCP_WRITE_PROTECTED;
    }
    for (uint32_t n = 0; n < count; n++) {
        const table_row_t *row = table_by_id(&params_table, first + n);
        if (row == NULL || !table_accepts_bits(row, slots[n])) {
            return XCP_OUT_OF_RANGE;
        }
        table_set_bits(row, &next, slots[n]);
    }
    app->staged = next;
    return XCP_OK;
}

static uint32_t write_requests(uint32_t first, uint32_t count, const uint32_t *slots)
{
    talk_t *talk = &app->talk;
    requests_t next = app->drive.requests;
    params_error_t why;
    const size_t enable = offsetof(requests_t, enable);
    bool enables = false;
    for (uint32_t n = 0; n < count; n++) {
        const table_row_t *row = table_by_id(&requests_table, first + n);
        uint32_t bits;
        if (row == NULL || !line_bits_back(row, slots[n], &bits)) {
            return XCP_OUT_OF_RANGE;
        }
        table_set_bits(row, &next, bits);
        enables = enables || row->offset == enable;
    }
    if (!app_request(&next, &why)) {
        return XCP_OUT_OF_RANGE;
    }
    if (enables) {
        talk->silent = 0u;
        talk->steered = next.enable == (int32_t)REQUEST_ON ? UINT32_C(1) : UINT32_C(0);
    }
    return XCP_OK;
}

/* Converts a service's bits from those on the serial link. */
static bool service_bits(uint32_t id, uint32_t on_line, uint32_t *bits)
{
    const table_row_t *row = table_by_id(&services_table, id);
    *bits = on_line;
    return row == NULL || line_bits_back(row, on_line, bits);
}

static uint32_t write_services(uint32_t first, uint32_t count, const uint32_t *slots)
{
    params_error_t why;
    uint32_t bits;
    for (uint32_t n = 0; n < count; n++) {
        if (!service_bits(first + n, slots[n], &bits)) {
            return XCP_OUT_OF_RANGE;
        }
        if (!services_accepts(first + n, bits, &why)) {
            return why.reason == (int32_t)REASON_READ_ONLY ? XCP_WRITE_PROTECTED : XCP_OUT_OF_RANGE;
        }
    }
    for (uint32_t n = 0; n < count; n++) {
        (void)service_bits(first + n, slots[n], &bits);
        if (!services_write(first + n, bits, &why)) {
            return XCP_OUT_OF_RANGE;
        }
    }
    return XCP_OK;
}

static bool writable(uint32_t extension)
{
    return extension == (uint32_t)APP_TABLE_PARAMS || extension == (uint32_t)APP_TABLE_REQUESTS ||
           extension == (uint32_t)APP_TABLE_SERVICES;
}

/* True if all these slots have codes. */
static bool coded(uint32_t extension, uint32_t address, uint32_t count, const uint32_t *slots)
{
    const table_t *table = extension == (uint32_t)APP_TABLE_REQUESTS   ? &requests_table
                           : extension == (uint32_t)APP_TABLE_SERVICES ? &services_table
                                                                       : NULL;
    for (uint32_t n = 0; n < count; n++) {
        const table_row_t *row = table != NULL ? table_by_id(table, address / 4u + n) : NULL;
        uint32_t bits;
        if (row == NULL || !line_has_codes(row) || !line_bits_back(row, slots[n], &bits)) {
            return false;
        }
    }
    return true;
}

/* Only a quick stop. Off is not accepted, because the motor would coast. */
static bool stops(uint32_t extension, uint32_t address, uint32_t slot)
{
    const table_row_t *row =
        extension == (uint32_t)APP_TABLE_REQUESTS ? table_by_id(&requests_table, address / 4u) : NULL;
    const size_t enable = offsetof(requests_t, enable);
    uint32_t bits;
    return row != NULL && row->offset == enable && line_bits_back(row, slot, &bits) &&
           bits == (uint32_t)REQUEST_QUICK_STOP;
}

static uint32_t write(uint32_t extension, uint32_t address, uint32_t count, const uint32_t *slots)
{
    const uint32_t first = address / 4u;
    switch (extension) {
    case APP_TABLE_PARAMS:
        return write_params(first, count, slots);
    case APP_TABLE_REQUESTS:
        return write_requests(first, count, slots);
    case APP_TABLE_SERVICES:
        return write_services(first, count, slots);
    case APP_TABLE_SIGNALS:
    case TALK_CAPTURE:
    case TALK_FAULTS:
        return XCP_WRITE_PROTECTED;
    default:
        return talk_is_text(extension) ? XCP_WRITE_PROTECTED : XCP_OUT_OF_RANGE;
    }
}

/* ---- the rest ---- */

/* The copy in the interrupt has its base at the drive: only signals can be measured. */
static uint32_t measurable(uint32_t extension, uint32_t address, uint32_t *offset)
{
    const table_row_t *row = NULL;
    if (extension == (uint32_t)APP_TABLE_SIGNALS && address % 4u == 0u) {
        row = table_by_id(&signals_table, address / 4u);
    }
    *offset = row != NULL ? (uint32_t)row->offset : 0u;
    return row != NULL ? XCP_OK : XCP_OUT_OF_RANGE;
}

static xcp_segment_t segment(void)
{
    uint32_t lowest = params_table.rows[0].id;
    uint32_t highest = lowest;
    for (uint32_t n = 1; n < params_table.count; n++) {
        const uint32_t id = params_table.rows[n].id;
        lowest = id < lowest ? id : lowest;
        highest = id > highest ? id : highest;
    }
    return (xcp_segment_t){(uint32_t)APP_TABLE_PARAMS, 4u * lowest, 4u * (highest + 1u - lowest)};
}

static uint32_t apply(void)
{
    params_error_t why;
    return services_write(SERVICE_ORDER, (uint32_t)ORDER_APPLY, &why) ? XCP_OK : XCP_OUT_OF_RANGE;
}

static bool applied(void)
{
    for (uint32_t n = 0; n < params_table.count; n++) {
        const table_row_t *row = &params_table.rows[n];
        if (table_bits(row, &app->staged) != table_bits(row, &app->active)) {
            return false;
        }
    }
    return true;
}

static uint32_t now(void)
{
    return app->drive.fast.period;
}

static uint32_t key(void)
{
    return (uint32_t)app->active.line_key;
}

const xcp_access_t talk_access = {
    .read = read,
    .write = write,
    .writable = writable,
    .coded = coded,
    .stops = stops,
    .measurable = measurable,
    .text_length = talk_text_length,
    .segment = segment,
    .apply = apply,
    .applied = applied,
    .clock = now,
    .key = key,
    .period = (uint32_t)(DRIVE_PERIOD * 1e9f + 0.5f),
};
