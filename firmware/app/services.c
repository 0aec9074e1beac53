#include "app/services.h"

#include "app/app.h"
#include "settings/reasons.h"
#include "settings/signals.h"

static const table_row_t rows[] = {
#define ROW_FLOAT(id, name, unit, initial, min, max, access, text)                                           \
    {id, SLOT_FLOAT, access, offsetof(services_t, name), #name, unit, text, "", initial, min, max, {0, 0, 0}},
#define ROW_WHOLE(kind, id, name, unit, initial, min, max, access, text)                                     \
    {id,   kind, access, offsetof(services_t, name), #name, unit, text, "",                                  \
     0.0f, 0.0f, 0.0f,   {initial, min, max}},
#define ROW_INT(id, name, unit, initial, min, max, access, text)                                             \
    ROW_WHOLE(SLOT_INT, id, name, unit, initial, min, max, access, text)
#define ROW_UINT(id, name, unit, initial, min, max, access, text)                                            \
    ROW_WHOLE(SLOT_UINT, id, name, unit, initial, min, max, access, text)
#define ROW_ENUM(id, name, choices, access, text)                                                            \
    {id,   SLOT_ENUM, access,   offsetof(services_t, name), #name, "-", text, choices, 0.0f,                 \
     0.0f, 0.0f,      {0, 0, 0}},
    APP_SERVICES(ROW_FLOAT, ROW_INT, ROW_UINT, ROW_ENUM)
#undef ROW_FLOAT
#undef ROW_WHOLE
#undef ROW_INT
#undef ROW_UINT
#undef ROW_ENUM
};

const table_t services_table = {"services", rows, sizeof rows / sizeof rows[0]};

const table_t *const app_tables[APP_TABLES] = {
    [APP_TABLE_SIGNALS] = &signals_table,
    [APP_TABLE_PARAMS] = &params_table,
    [APP_TABLE_REQUESTS] = &requests_table,
    [APP_TABLE_SERVICES] = &services_table,
};

uint32_t app_tables_hash(void)
{
    uint32_t hash = 0u;
    for (uint32_t n = 0; n < (uint32_t)APP_TABLES; n++) {
        hash = table_hash(app_tables[n], hash);
    }
    return hash;
}

void services_defaults(services_t *services)
{
    table_defaults(&services_table, services);
}

static bool refuse(const table_row_t *row, int32_t reason, const char *rule, float value, params_error_t *why)
{
    (void)params_refuse(why, row->name, rule, value, table_min(row), table_max(row));
    why->id = row->id;
    why->reason = reason;
    return false;
}

/* ---- orders ---- */

static bool restart(params_error_t *why)
{
    if (app->seen.bridge_on != 0u) {
        return refuse(table_by_id(&services_table, SERVICE_ORDER), REASON_BRIDGE_ON,
                      "the bridge must be off for a restart", (float)ORDER_RESTART, why);
    }
    if (parameters_busy()) {
        return refuse(table_by_id(&services_table, SERVICE_ORDER), REASON_STORE_BUSY,
                      "the save must be complete", (float)ORDER_RESTART, why);
    }
    talk_restart();
    return true;
}

static bool obey(order_t order, params_error_t *why)
{
    switch (order) {
    case ORDER_NONE:
        return true;
    case ORDER_APPLY:
        return app_apply(why);
    case ORDER_DEFAULTS:
        params_defaults(&app->staged);
        return true;
    case ORDER_RESTART:
        return restart(why);
    case ORDER_SAVE:
        return parameters_save(why);
    case ORDER_LOAD:
        return parameters_load(why);
    case ORDER_ERASE:
        return parameters_erase(why);
    case ORDER_CAPTURE_ARM:
        return capturing_arm(why);
    case ORDER_CAPTURE_TRIGGER:
        capturing_trigger();
        return true;
    case ORDER_CAPTURE_RELEASE:
        capturing_release();
        return true;
    }
    return false;
}

bool services_accepts(uint32_t id, uint32_t bits, params_error_t *why)
{
    const table_row_t *row = table_by_id(&services_table, id);
    if (row == NULL) {
        *why = (params_error_t){.field = "", .rule = "", .id = id, .reason = REASON_UNKNOWN_ID};
        return false;
    }
    if (row->access == TABLE_READ) {
        return refuse(row, REASON_READ_ONLY, "it is shown, not set", 0.0f, why);
    }
    return table_accepts_bits(row, bits) ||
           refuse(row, REASON_OUT_OF_RANGE, PARAMS_RANGE, table_value_of_bits(row, bits), why);
}

bool services_write(uint32_t id, uint32_t bits, params_error_t *why)
{
    services_t *services = &app->services;
    if (!services_accepts(id, bits, why)) {
        return false;
    }
    table_set_bits(table_by_id(&services_table, id), services, bits);
    if (id != SERVICE_ORDER) {
        return true;
    }
    const bool obeyed = obey((order_t)services->order, why);
    services->order_refusal = obeyed ? (int32_t)REASON_NONE : why->reason;
    services->order_row = obeyed ? 0u : why->id;
    return obeyed;
}
