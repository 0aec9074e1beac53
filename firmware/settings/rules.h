/* Rules between the rows of the parameters. For each rule: the rows that it reads, whether larger or smaller
 * values of a row help to keep it, and whether it is kept. params_check (judgement.c) evaluates them in this
 * order. */
#ifndef SETTINGS_RULES_H
#define SETTINGS_RULES_H

#include "settings/params.h"

/* Places of the rows in the table. */
typedef enum {
#define NUMBER_FLOAT(id, name, unit, initial, min, max, access, text) PARAM_##name,
#define NUMBER_INT(id, name, unit, initial, min, max, access, text)   PARAM_##name,
#define NUMBER_ENUM(id, name, choices, initial, access, text)         PARAM_##name,
    DRIVE_PARAMS(NUMBER_FLOAT, NUMBER_INT, NUMBER_ENUM)
#undef NUMBER_FLOAT
#undef NUMBER_INT
#undef NUMBER_ENUM
} param_t;

typedef enum {
    RULE_TRIP,
    RULE_LINK,
    RULE_DELAY,
    RULE_ENCODER,
    RULE_TURN,
    RULE_OPEN,
    RULE_SATURATION,
    RULE_WINDING,
    RULE_FEEDFORWARD,
    RULE_FORGETTING,
    RULE_TORQUE,
    RULE_SPEEDS,
    RULE_RINGING,
    RULE_LOOP,
    RULE_FILTER,
    RULE_SALIENT,
    RULE_REACH,
    RULE_START,
    RULE_LOW_SPEED,
    RULE_FALLBACK,
    RULE_CATCH,
    RULE_HANDOVER,
    RULE_RAMP,
    RULE_RIDE,
    RULE_CHOPPER,
    RULE_CHOPPER_CURRENT,
    RULE_BRAKE,
    RULES
} rule_number_t;

typedef enum { LESS_HELPS = -1, IS_READ = 0, MORE_HELPS = 1 } lever_sense_t;

typedef struct {
    param_t row;
    lever_sense_t sense;
} lever_t;

#define LEVERS 11

typedef struct {
    const char *text; /* in rows */
    int32_t count;    /* [-] of levers */
    lever_t levers[LEVERS];
} rule_t;

/* By rule_number_t. The first lever is the row that is named. No row here is negative. */
extern const rule_t rules[RULES];

/* True if the set keeps the rule. Every row that the rule reads is in its range. A rule that depends on
 * another one counts as kept where that one is broken. */
bool rules_hold(rule_number_t rule, const params_t *params);

/* For a row in which 0 means off, or a value by a rule: the least value above 0 that can be accepted [unit of
 * the row]; 0: the row has no such meaning. Values between 0 and this one may be refused although 0 is
 * accepted. */
float rules_least_above_zero(param_t param);

/* Dependence of a rule on a row; IS_READ: the rule reads the row, but no direction of change helps to keep
 * it. */
lever_sense_t rules_sense(rule_number_t rule, param_t param);

#endif
