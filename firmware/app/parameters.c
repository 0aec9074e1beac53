#include "app/parameters.h"

#include "app/app.h"
#include "app/keeping.h"
#include "settings/reasons.h"

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
    const store_found_t found = store_load(&keeping_memory, &params_table, params, &told);
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

static void tell_failed(void)
{
    tell(PARAMETERS_FAILED, 0u, 0u);
    app->services.store_error = (int32_t)keeping_error();
}

bool parameters_start(void)
{
    keeping_open();
    if (keeping_error() != (uint32_t)MIRROR_GOOD) {
        params_defaults(&app->staged);
        tell_failed();
        return true;
    }
    return load(&app->staged);
}

/* False, with `why`, while the memory cannot be used: it has failed since the start, or changes of it are
 * in progress. */
static bool memory_is_free(params_error_t *why)
{
    if (keeping_error() != (uint32_t)MIRROR_GOOD) {
        return refuse(REASON_STORE_FAILED, "the memory must answer; its error is store_error", why);
    }
    return !keeping_busy() ||
           refuse(REASON_STORE_BUSY, "the order before must be complete in the memory", why);
}

/* A change that is complete, or that parameters_step() will find complete. */
static void changed(parameters_state_t state)
{
    const bool complete = !keeping_busy();
    app->services.store_saves += complete && state == PARAMETERS_SAVED ? 1u : 0u;
    tell(complete ? state : PARAMETERS_BUSY, 0u, 0u);
}

bool parameters_busy(void)
{
    return keeping_busy();
}

bool parameters_load(params_error_t *why)
{
    params_t stored;
    if (!memory_is_free(why)) {
        return false;
    }
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
    if (!memory_is_free(why)) {
        return false;
    }
    if (store_look(&keeping_memory) == STORE_FOREIGN) {
        return refuse(REASON_STORE_FOREIGN, "the store must be erased before the first save", why);
    }
    if (!store_save(&keeping_memory, &params_table, &app->active)) {
        return refuse(REASON_STORE_FAILED, "the memory must take all words", why);
    }
    changed(PARAMETERS_SAVED);
    return true;
}

bool parameters_erase(params_error_t *why)
{
    if (drive_bridge_on(&app->drive)) {
        return refuse(REASON_BRIDGE_ON, "the bridge must be off to erase", why);
    }
    if (!memory_is_free(why)) {
        return false;
    }
    if (!store_erase(&keeping_memory)) {
        return refuse(REASON_STORE_FAILED, "the memory must become blank", why);
    }
    changed(PARAMETERS_EMPTY);
    return true;
}

#if BOARD_STORE == BOARD_STORE_I2C
void parameters_step(void)
{
    if (!keeping_busy()) {
        return;
    }
    keeping_step();
    if (keeping_error() != (uint32_t)MIRROR_GOOD) {
        tell_failed();
    } else if (!keeping_busy()) {
        changed(store_look(&keeping_memory) == STORE_EMPTY ? PARAMETERS_EMPTY : PARAMETERS_SAVED);
    }
}
#endif
