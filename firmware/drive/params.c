#include "drive/params.h"

#include "drive/reasons.h"

static const table_row_t rows[] = {
#define ROW_FLOAT(id, name, unit, initial, min, max, access, text)                                           \
    {id, SLOT_FLOAT, access, offsetof(params_t, name), #name, unit, text, "", initial, min, max},
#define ROW_INT(id, name, unit, initial, min, max, access, text)                                             \
    {id, SLOT_INT, access, offsetof(params_t, name), #name, unit, text, "", initial, min, max},
    DRIVE_PARAMS(ROW_FLOAT, ROW_INT)
#undef ROW_FLOAT
#undef ROW_INT
};

const table_t params_table = {"params", rows, sizeof rows / sizeof rows[0]};

void params_defaults(params_t *params)
{
    table_defaults(&params_table, params);
}

float params_duty_min(const params_t *params)
{
    return (params->dead_time + params->minimum_pulse) / DRIVE_PERIOD;
}

static bool refuse(params_error_t *why, const table_row_t *row, reason_t reason, const char *rule,
                   float value, float min, float max)
{
    why->field = row->name;
    why->rule = rule;
    why->value = value;
    why->min = min;
    why->max = max;
    why->id = row->id;
    why->reason = reason;
    return false;
}

bool params_check_range(const table_row_t *row, const void *base, params_error_t *why)
{
    const float value = table_get(row, base);
    if (table_accepts(row, value)) {
        return true;
    }
    return refuse(why, row, REASON_OUT_OF_RANGE, "range of the parameter", value, row->min, table_max(row));
}

bool params_check_rule(const table_t *table, const char *field, const char *rule, float value, float min,
                       float max, params_error_t *why)
{
    if (value >= min && value <= max) {
        return true;
    }
    return refuse(why, table_by_name(table, field), REASON_CROSS_RULE, rule, value, min, max);
}

static bool rule_holds(params_error_t *why, const char *field, const char *rule, float value, float min,
                       float max)
{
    return params_check_rule(&params_table, field, rule, value, min, max, why);
}

bool params_check(const params_t *params, params_error_t *why)
{
    for (uint32_t n = 0; n < params_table.count; n++) {
        if (!params_check_range(&rows[n], params, why)) {
            return false;
        }
    }

    const float counts = 4.0f * (float)params->encoder_lines;
    return rule_holds(why, "overcurrent_trip", "overcurrent_trip >= 1.2 current_limit",
                      params->overcurrent_trip, 1.2f * params->current_limit, 0.95f * DRIVE_CURRENT_RANGE) &&
           rule_holds(why, "dc_undervoltage", "dc_undervoltage <= dc_overvoltage - 10 V",
                      params->dc_undervoltage, 0.0f, params->dc_overvoltage - 10.0f) &&
           rule_holds(why, "turn_off_delay",
                      "turn_off_delay <= dead_time + turn_on_delay, else the legs shoot through",
                      params->turn_off_delay, 0.0f, params->dead_time + params->turn_on_delay) &&
           /* Below 256 counts a pole pair the angle steps by more than 25 mrad and the current control hears
              it. */
           rule_holds(why, "motor_pole_pairs", "256 motor_pole_pairs <= 4 encoder_lines",
                      (float)params->motor_pole_pairs, 1.0f, counts / 256.0f) &&
           /* One sample must not turn the frame by more than half a radian: the delays of the loop are made
            * up for to first order only. */
           rule_holds(why, "overspeed_trip", "overspeed_trip motor_pole_pairs T_s <= 0.5 rad",
                      params->overspeed_trip, 1.0f, 0.5f / ((float)params->motor_pole_pairs * DRIVE_PERIOD));
}

bool params_check_live(const params_t *active, const params_t *next, params_error_t *why)
{
    for (uint32_t n = 0; n < params_table.count; n++) {
        const table_row_t *row = &rows[n];
        const float value = table_get(row, next);
        const float now = table_get(row, active);
        if (row->access == TABLE_OFF && value != now) {
            return refuse(why, row, REASON_BRIDGE_ON, "changes only while the bridge is off", value, now,
                          now);
        }
    }
    return true;
}
