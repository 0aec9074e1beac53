/* Non-volatile parameters: the store (talk/store.h) in the board's memory, and its use
 * by the start and by the orders. */
#ifndef APP_PARAMETERS_H
#define APP_PARAMETERS_H

#include <stdbool.h>
#include <stdint.h>

#include "contract/refusal.h"
#include "hal/board.h"
#include "talk/mirror.h"

typedef enum {
    PARAMETERS_EMPTY,
    PARAMETERS_LOADED,
    PARAMETERS_SAVED,
    PARAMETERS_MIGRATED,
    PARAMETERS_CORRUPT,
    PARAMETERS_FOREIGN,
    PARAMETERS_BUSY,
    PARAMETERS_FAILED
} parameters_state_t;
#define PARAMETERS_STATE_NAMES "empty|loaded|saved|migrated|corrupt|foreign|busy|failed"

#define APP_STORE_SERVICES(F, I, U, E)                                                                       \
    E(1940, store_state, PARAMETERS_STATE_NAMES, TABLE_READ,                                                 \
      "last event of the stored parameters; corrupt: the defaults are active, and the bridge is refused "    \
      "until a reset; foreign: the defaults are active, and the memory holds data of another "               \
      "program, which order erase removes; busy: a change of the memory is in progress; failed: the memory " \
      "does not work (store_error), nothing is saved until a restart, and a set that was saved before it "   \
      "failed stays")                                                                                        \
    U(1941, store_saves, "-", 0, 0, 0, TABLE_READ, "times that parameters were saved since the start")       \
    U(1942, store_unknown, "-", 0, 0, 0, TABLE_READ,                                                         \
      "number of stored rows that this program does not have")                                               \
    U(1943, store_defaulted, "-", 0, 0, 0, TABLE_READ,                                                       \
      "number of stored rows with values that this program rejects; they got their defaults")                \
    E(2400, store_error, MIRROR_ERROR_NAMES, TABLE_READ,                                                     \
      "why a memory on the I2C bus failed: there is no acknowledge at its address, a line of the bus stays " \
      "low "                                                                                                 \
      "or a transfer does not end, or it does not hold what was written")

/* At the start, before hal_init: loads the stored set into app->staged, or the defaults. false: the stored
 * data cannot be trusted, or its values break a rule; then app->staged has the defaults. If the memory does
 * not answer, app->staged has the defaults as well and store_error is set, but the result is true, because
 * nothing shows that a set was stored. */
bool parameters_start(void);

/* From the background: loads the stored set into app->staged, to be applied; the defaults if none is stored.
 * false: the data cannot be trusted; the staged set is unchanged. */
bool parameters_load(params_error_t *why);

/* From the background: stores the active set. false: `why`; the previous stored set is kept. With flash
 * no interrupt runs during this call, some seconds if a page is erased: the bridge must be off. With a memory
 * on the I2C bus the call returns at once, and parameters_step() does the rest: store_state is busy, then
 * saved or failed. */
bool parameters_save(params_error_t *why);

/* From the background: erases all stored parameters, or what another program has left in their place; the
 * active set stays. It proceeds like parameters_save(). false: `why`. */
bool parameters_erase(params_error_t *why);

/* True while a change of the memory is in progress. */
bool parameters_busy(void);

#if BOARD_STORE == BOARD_STORE_I2C
/* From the background list: one short step of what an order began. */
void parameters_step(void);
#endif

#endif
