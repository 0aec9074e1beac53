/* The reason for which a set of parameters was rejected: the first violated rule, as data. The caller makes
 * the text, so that a calibration tool can display it in its own form. */
#ifndef CONTRACT_REFUSAL_H
#define CONTRACT_REFUSAL_H

#include <stdbool.h>
#include <stdint.h>

typedef struct {
    const char *field; /* name of the rejected parameter */
    const char *rule;  /* the rule in words for the user: "dc_undervoltage < dc_overvoltage" */
    float value;       /* requested value, in the unit of the field */
    float min, max;  /* accepted range for the present values of all other parameters; min > max: no value is
                        accepted */
    uint32_t id;     /* of the field in the parameter table; 0 below the drive */
    int32_t reason;  /* of the drive's reason table; 0 below the drive */
    uint32_t change; /* row to change: `id`, or another one if no value is accepted; 0 below the drive */
    float advice;    /* value by the rule of thumb for that row, in its unit; 0: no rule */
} params_error_t;

#define PARAMS_RANGE "range of the parameter"

/* true: no value of this field would have been accepted. */
static inline bool params_none_accepted(const params_error_t *why)
{
    return !(why->min <= why->max);
}

/* Returns false and the refusal in `why` (ids and reason 0, no advice). */
bool params_refuse(params_error_t *why, const char *field, const char *rule, float value, float min,
                   float max);

/* true if min <= value <= max (inside: min < value < max), never for a NaN; else the refusal. */
bool params_within(params_error_t *why, const char *field, const char *rule, float value, float min,
                   float max);
bool params_inside(params_error_t *why, const char *field, const char *rule, float value, float min,
                   float max);

#endif
