#include "contract/refusal.h"

bool params_refuse(params_error_t *why, const char *field, const char *rule, float value, float min,
                   float max)
{
    *why = (params_error_t){.field = field, .rule = rule, .value = value, .min = min, .max = max};
    return false;
}

bool params_within(params_error_t *why, const char *field, const char *rule, float value, float min,
                   float max)
{
    return (value >= min && value <= max) || params_refuse(why, field, rule, value, min, max);
}

bool params_inside(params_error_t *why, const char *field, const char *rule, float value, float min,
                   float max)
{
    return (value > min && value < max) || params_refuse(why, field, rule, value, min, max);
}
