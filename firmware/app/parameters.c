#include "app/parameters.h"

#include "app/app.h"
#include "settings/reasons.h"
#include "talk/store.h"

/* Length used in each sector: several sets per erase, and a search at the
 * start that takes some ms at most. */
#define PAGE_WORDS UINT32_C(2048)

static const store_flash_t flash = {hal_store_word, hal_store_erase, hal_store_program, PAGE_WORDS};

static void tell(parameters_state_t state, uint32_t unknown, uint32_t defaulted)
{
    services_t *services = &app->services;
    services->store_state = (int32_t)state;
    services->store_unknown = unknown;
    services->store_defaulted = defaulted;
}

/* Rows that a set lacks get their defaults; without a set these are all rows. false: the data is corrupt,
 * and all rows have their defaults. */
static bool load(params_t *params)
{
    static const parameters_state_t states[(uint32_t)STORE_FOREIGN + 1u] = {
        [STORE_EMPTY] = PARAMETERS_EMPTY,       [STORE_LOADED] = PARAMETERS_LOADED,
        [STORE_MIGRATED] = PARAMETERS_MIGRATED, [STORE_CORRUPT] = PARAMETERS_CORRUPT,
        [STORE_FOREIGN] = PARAMETERS_FOREIGN,
    };
    store_told_t told;
    params_error_t why;
    const store_found_t found = store_load(&flash, &params_table, params, &told);
    tell(states[found], told.unknown, told.defaulted);
    if (found != STORE_CORRUPT && params_check(params, &why)) {
        return true;
    }
    params_defaults(params);
    tell(PARAMETERS_CORRUPT, told.unknown, params_table.count);
    return false;
}

static bool refuse(int32_t reason, const char *rule, params_error_t *why)
{
    (void)params_refuse(why, "order", rule, (float)app->services.order, 0.0f, -1.0f);
    why->id = SERVICE_ORDER;
    why->reason = reason;
    return false;
}

bool parameters_start(void)
{
    return load(&app->staged);
}

bool parameters_load(params_error_t *why)
{
    params_t stored;
    if (!load(&stored)) {
        return refuse(REASON_STORE_CORRUPT, "a stored set that can be trusted", why);
    }
    app->staged = stored;
    return true;
}

bool parameters_save(params_error_t *why)
{
    if (drive_bridge_on(&app->drive)) {
        return refuse(REASON_BRIDGE_ON, "the bridge must be off to save", why);
    }
    if (store_look(&flash) == STORE_FOREIGN) {
        return refuse(REASON_STORE_FOREIGN, "the store must be erased before the first save", why);
    }
    if (!store_save(&flash, &params_table, &app->active)) {
        return refuse(REASON_STORE_FAILED, "the flash must take all words", why);
    }
    tell(PARAMETERS_SAVED, 0u, 0u);
    app->services.store_saves++;
    return true;
}

bool parameters_erase(params_error_t *why)
{
    if (drive_bridge_on(&app->drive)) {
        return refuse(REASON_BRIDGE_ON, "the bridge must be off to erase", why);
    }
    if (!store_erase(&flash)) {
        return refuse(REASON_STORE_FAILED, "the flash must become blank", why);
    }
    tell(PARAMETERS_EMPTY, 0u, 0u);
    return true;
}
