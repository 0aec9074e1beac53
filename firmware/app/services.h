/* Services: functions of the drive for a client, apart from the control of the motor, as rows of a table like
 * parameters and requests. Writing a row acts at once; `order` is executed or refused before the write
 * returns. */
#ifndef APP_SERVICES_H
#define APP_SERVICES_H

#include <stdbool.h>
#include <stdint.h>

#include "app/capturing.h"
#include "app/parameters.h"
#include "contract/refusal.h"
#include "contract/table.h"

#define SERVICE_ORDERS                                                                                       \
    "none|apply|save|load|defaults|restart|capture_arm|capture_trigger|capture_release|erase"
typedef enum {
    ORDER_NONE,
    ORDER_APPLY,
    ORDER_SAVE,
    ORDER_LOAD,
    ORDER_DEFAULTS,
    ORDER_RESTART,
    ORDER_CAPTURE_ARM,
    ORDER_CAPTURE_TRIGGER,
    ORDER_CAPTURE_RELEASE,
    ORDER_ERASE
} order_t;

/* F(id, name, unit, default, min, max, access, text): float
 * I(id, name, unit, default, min, max, access, text): int32_t
 * U(id, name, unit, default, min, max, access, text): uint32_t
 * E(id, name, choices, access, text): int32_t with named values, default the first
 * Rows that are only displayed have the access TABLE_READ, and default and range 0. */
#define APP_SERVICES(F, I, U, E)                                                                             \
    E(1900, order, SERVICE_ORDERS, TABLE_LIVE,                                                               \
      "acts when written: apply activates the staged parameters, save stores the active ones, load and "     \
      "defaults stage those stored and the program's defaults, restart resets the controller, "              \
      "erase removes all stored parameters")                                                                 \
    I(1901, order_refusal, "-", 0, 0, 0, TABLE_READ, "reason why the last order was refused; 0: executed")   \
    U(1902, order_row, "-", 0, 0, 0, TABLE_READ, "id of the row of that refusal; 0: none")                   \
    APP_CAPTURE_SERVICES(F, I, U, E)                                                                         \
    APP_STORE_SERVICES(F, I, U, E)                                                                           \
    U(1950, line_frames, "-", 0, 0, 0, TABLE_READ, "good frames received since the start")                   \
    U(1951, line_errors, "-", 0, 0, 0, TABLE_READ, "frames lost on the link or dropped since the start")     \
    U(1952, daq_lost, "-", 0, 0, 0, TABLE_READ, "samples lost to a full queue since the start")

typedef struct {
#define SERVICES_FLOAT(id, name, unit, initial, min, max, access, text) float name;   /* [unit of its row] */
#define SERVICES_INT(id, name, unit, initial, min, max, access, text)   int32_t name; /* [unit of its row] */
#define SERVICES_UINT(id, name, unit, initial, min, max, access, text)                                       \
    uint32_t name;                                                   /* [unit of its row]                    \
                                                                      */
#define SERVICES_ENUM(id, name, choices, access, text) int32_t name; /* [-] */
    APP_SERVICES(SERVICES_FLOAT, SERVICES_INT, SERVICES_UINT, SERVICES_ENUM)
#undef SERVICES_FLOAT
#undef SERVICES_INT
#undef SERVICES_UINT
#undef SERVICES_ENUM
} services_t;

extern const table_t services_table;

/* The tables that can be reached over the serial link, in the order of their address
 * extensions (and of APP_TABLE_...), and the hash over all of them: in two programs with the
 * same hash an id has the same meaning. */
typedef enum {
    APP_TABLE_SIGNALS,
    APP_TABLE_PARAMS,
    APP_TABLE_REQUESTS,
    APP_TABLE_SERVICES,
    APP_TABLES
} app_table_t;
extern const table_t *const app_tables[APP_TABLES];
uint32_t app_tables_hash(void);

/* Sets every row to its default. */
void services_defaults(services_t *services);

#define SERVICE_ORDER 1900u /* id of the row that executes orders */

/* True if the row accepts these bits; an order is always accepted, whether it is
 * executed or not. false: `why`. */
bool services_accepts(uint32_t id, uint32_t bits, params_error_t *why);

/* From the background: writes the bits of a row's slot into app->services; an order is executed. false:
 * refused; for an order order_refusal and order_row also give the reason. */
bool services_write(uint32_t id, uint32_t bits, params_error_t *why);

#endif
