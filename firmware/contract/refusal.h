/* Why a set of parameters was refused: the first violated rule, as data. Text is made outside, so that a
 * calibration tool can show it in its own way. */
#ifndef CONTRACT_REFUSAL_H
#define CONTRACT_REFUSAL_H

#include <stdbool.h>
#include <stdint.h>

typedef struct {
    const char *field; /* name of the offending parameter */
    const char *rule;  /* the rule in words, for a reader: "dc_undervoltage < dc_overvoltage" */
    float value;       /* what was asked for, in the unit of the field */
    float min, max;    /* what would have been accepted, given all other parameters; min > max: nothing */
    uint32_t id;       /* of the field in the parameter table; 0 below the drive */
    int32_t reason;    /* of the drive's reason table; 0 below the drive */
    uint32_t change;   /* row to change: `id`, or another one where nothing is accepted; 0 below the drive */
    float advice;      /* what the rule of thumb gives for that row, in its unit; 0: there is none */
} params_error_t;

#define PARAMS_RANGE "range of the parameter"

/* Would no value of this field have been accepted, whatever it is? */
static inline bool params_none_accepted(const params_error_t *why)
{
    return !(why->min <= why->max);
}

/* False, with the refusal in `why` (ids and reason 0, no advice). */
bool params_refuse(params_error_t *why, const char *field, const char *rule, float value, float min,
                   float max);

/* True if min <= value <= max (inside: min < value < max), never for a NaN; else the refusal. */
bool params_within(params_error_t *why, const char *field, const char *rule, float value, float min,
                   float max);
bool params_inside(params_error_t *why, const char *field, const char *rule, float value, float min,
                   float max);

#endif
