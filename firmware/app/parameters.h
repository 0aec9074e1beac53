/* Non-volatile parameters: the store (talk/store.h) in the board's memory, and its use
 * by the start and by the orders. */
#ifndef APP_PARAMETERS_H
#define APP_PARAMETERS_H

#include <stdbool.h>
#include <stdint.h>

#include "contract/refusal.h"

typedef enum {
    PARAMETERS_EMPTY,
    PARAMETERS_LOADED,
    PARAMETERS_SAVED,
    PARAMETERS_MIGRATED,
    PARAMETERS_CORRUPT,
    PARAMETERS_FOREIGN
} parameters_state_t;
#define PARAMETERS_STATE_NAMES "empty|loaded|saved|migrated|corrupt|foreign"

#define APP_STORE_SERVICES(F, I, U, E)                                                                       \
    E(1940, store_state, PARAMETERS_STATE_NAMES, TABLE_READ,                                                 \
      "last event of the stored parameters; corrupt: the defaults are active, and the bridge is refused "    \
      "until a reset; foreign: the defaults are active, and the memory holds data of another "               \
      "program, which order erase removes")                                                                  \
    U(1941, store_saves, "-", 0, 0, 0, TABLE_READ, "times that parameters were saved since the start")       \
    U(1942, store_unknown, "-", 0, 0, 0, TABLE_READ,                                                         \
      "number of stored rows that this program does not have")                                               \
    U(1943, store_defaulted, "-", 0, 0, 0, TABLE_READ,                                                       \
      "number of stored rows with values that this program rejects; they got their defaults")

/* At the start: loads the stored set into app->staged, or the defaults. false: the stored data cannot be
 * trusted, or its values break a rule; then app->staged has the defaults. */
bool parameters_start(void);

/* From the background: loads the stored set into app->staged, to be applied; the defaults if none is stored.
 * false: the data cannot be trusted; the staged set is unchanged. */
bool parameters_load(params_error_t *why);

/* From the background: stores the active set. false: `why`; the previous stored set is kept. During this
 * call, some seconds if a page is erased, no interrupt runs: the bridge must be off. */
bool parameters_save(params_error_t *why);

/* From the background: erases all stored parameters, or what another program has left in their place; the
 * active set stays. It takes some seconds like parameters_save(). false: `why`. */
bool parameters_erase(params_error_t *why);

#endif
