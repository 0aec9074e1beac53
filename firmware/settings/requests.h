/* Requests: the references and commands of the user. One table, the struct made from it, the judgement of a
 * set. Unlike parameters they are not staged: an accepted set acts in the next period. */
#ifndef SETTINGS_REQUESTS_H
#define SETTINGS_REQUESTS_H

#include <stdbool.h>
#include <stdint.h>

#include "contract/table.h"
#include "medium/commission/commission.h"
#include "settings/params.h"

/* F(id, name, unit, default, min, max, text): float
 * E(id, name, choices, text): int32_t with named values, default the first */
#define DRIVE_REQUESTS(F, E)                                                                                 \
    E(1000, enable, "off|on|quick_stop",                                                                     \
      "off: coast; on: run, also after a quick stop has ended; quick_stop: brake to standstill, then off")   \
    E(1001, fault_reset, "no|yes",                                                                           \
      "a change from no to yes resets a fault whose cause is gone, and starts nothing: if `enable` is on, "  \
      "it must go to off once")                                                                              \
    E(1002, mode, "speed|current|torque", "meaning of the references")                                       \
    F(1003, speed_request, "rad/s", 0.0f, -10000.0f, 10000.0f, "mechanical speed reference in mode speed")   \
    F(1004, i_d_request, "A", 0.0f, -DRIVE_CURRENT_LIMIT_MAX, DRIVE_CURRENT_LIMIT_MAX,                       \
      "direct-axis current reference")                                                                       \
    F(1005, i_q_request, "A", 0.0f, -DRIVE_CURRENT_LIMIT_MAX, DRIVE_CURRENT_LIMIT_MAX,                       \
      "quadrature-axis current reference in mode current")                                                   \
    F(1006, torque_request, "N m", 0.0f, -1e4f, 1e4f, "torque reference in mode torque")                     \
    E(1016, commission, COMMISSION_STEP_NAMES,                                                               \
      "step of commissioning in place of `mode`: it begins with the change of this value, and works while "  \
      "the bridge is on (board: off); turning steps use speed_request as their largest speed")

typedef enum { REQUEST_OFF, REQUEST_ON, REQUEST_QUICK_STOP } request_enable_t;
typedef enum { MODE_SPEED, MODE_CURRENT, MODE_TORQUE } request_mode_t;

typedef struct {
#define REQUEST_FLOAT(id, name, unit, initial, min, max, text) float name;   /* [unit of its row] */
#define REQUEST_ENUM(id, name, choices, text)                  int32_t name; /* [-] */
    DRIVE_REQUESTS(REQUEST_FLOAT, REQUEST_ENUM)
#undef REQUEST_FLOAT
#undef REQUEST_ENUM
} requests_t;

extern const table_t requests_table;

/* Off, no reset, speed mode, all references zero. */
void requests_defaults(requests_t *requests);

/* Judges whether the drive may follow this set with these parameters. false: `why` names the field, value and
 * accepted range. A speed reference must be below 0.95 overspeed_trip, a current reference within
 * current_limit, a torque within the largest torque at current_limit. */
bool requests_check(const requests_t *requests, const params_t *params, params_error_t *why);

#endif
