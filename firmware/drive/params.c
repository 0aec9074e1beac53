#include "drive/params.h"

#include <string.h>

#include "drive/reasons.h"
#include "estimator/chosen.h"

/* Speed of the EMF below which the detector is divided by a constant [rad/s] electrical: 2 V of the paper's
 * motor, what its dead time leaves after compensation. */
#define FLOOR_SPEED 11.0f

static const table_row_t rows[] = {
#define ROW_FLOAT(id, name, unit, initial, min, max, access, text)                                           \
    {id, SLOT_FLOAT, access, offsetof(params_t, name), #name, unit, text, "", initial, min, max},
#define ROW_INT(id, name, unit, initial, min, max, access, text)                                             \
    {id, SLOT_INT, access, offsetof(params_t, name), #name, unit, text, "", initial, min, max},
#define ROW_ENUM(id, name, choices, initial, access, text)                                                   \
    {id,   SLOT_ENUM, access, offsetof(params_t, name), #name, "-", text, choices, (float)(initial),         \
     0.0f, 0.0f},
    DRIVE_PARAMS(ROW_FLOAT, ROW_INT, ROW_ENUM)
#undef ROW_FLOAT
#undef ROW_INT
#undef ROW_ENUM
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

float params_duty_max(const params_t *params)
{
    const float settled = 2.0f * (params->dead_time + BOARD_SECONDS(BOARD_SHUNT_SETTLED_NS)) / DRIVE_PERIOD;
    const float short_of = params_duty_min(params);
    return 1.0f - (BOARD_SAMPLES_AT == BOARD_LOWER_ZERO_VECTOR && settled > short_of ? settled : short_of);
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

believed_t params_believed(const params_t *params)
{
    return (believed_t){
        .resistance = params->motor_resistance + params->device_resistance,
        .inductance_d = params->motor_inductance_d,
        .inductance_q = params->motor_inductance_q,
        .flux_linkage = params->motor_flux_linkage,
        .inertia = params->motor_inertia,
    };
}

void params_estimator(const params_t *params, const believed_t *believed, estimator_params_t *estimator)
{
    const float pole_pairs = (float)params->motor_pole_pairs;
    const float psi_f = believed->flux_linkage;
    *estimator = (estimator_params_t){
        .smo =
            {
                .resistance = believed->resistance,
                .inductance = believed->inductance_q,
                .gain = params->observer_gain,
                .slope = params->observer_slope,
                .emf_cutoff = params->observer_emf_cutoff,
                .period = DRIVE_PERIOD,
                .switching = (smo_switching_t)params->observer_switching,
            },
        .lag = (lag_mode_t)params->lag_compensation,
        .pll = {.amplitude_floor = psi_f * FLOOR_SPEED},
        .flux_linkage = psi_f,
        .flux_adaptation = params->flux_adaptation,
        .torque_feedforward =
            params->torque_feedforward * 1.5f * pole_pairs * pole_pairs * psi_f / believed->inertia,
        .validity =
            {
                .amplitude_min = params->estimate_amplitude_min,
                .amplitude_max =
                    params->estimate_amplitude_max > 1.0f ? params->estimate_amplitude_max : 0.0f,
                .amplitude_time = params->estimate_time,
                .detector_max = params->estimate_detector_max,
                .detector_time = params->estimate_time,
                .current_max = params->estimate_current_max,
                .current_time = params->estimate_time,
                .speed_min = pole_pairs * params->estimate_speed_min,
                .speed_max = pole_pairs * params->overspeed_trip,
                .speed_time = params->estimate_time,
            },
    };
    (void)pll_design(&estimator->pll, params->pll_bandwidth, params->pll_damping, params->feedforward_cutoff,
                     DRIVE_PERIOD);
}

/* The row that stands behind a field of the estimator's set, and whether it holds the field's value itself.
 */
typedef struct {
    const char *field;
    const char *row;
    bool same;
} origin_t;

static origin_t origin_of(const char *field)
{
    static const origin_t origins[] = {
        {"gain", "observer_gain", true},
        {"slope", "observer_slope", true},
        {"emf_cutoff", "observer_emf_cutoff", true},
        {"inductance", "motor_inductance_q", true},
        {"flux_linkage", "motor_flux_linkage", true},
        {"resistance", "motor_resistance", false},
        {"amplitude_floor", "motor_flux_linkage", false},
        {"torque_feedforward", "torque_feedforward", false},
        {"speed_max", "overspeed_trip", false},
    };
    for (uint32_t n = 0; n < sizeof origins / sizeof origins[0]; n++) {
        if (strcmp(origins[n].field, field) == 0) {
            return origins[n];
        }
    }
    return (origin_t){field, "pll_bandwidth", false};
}

/* A rule of the estimator, in terms of the row behind it; where that is in another unit, with the row's own
 * range. */
static bool refuse_for_estimator(const params_t *params, params_error_t *why)
{
    const origin_t origin = origin_of(why->field);
    const table_row_t *row = table_by_name(&params_table, origin.row);
    return origin.same ? refuse(why, row, REASON_CROSS_RULE, why->rule, why->value, why->min, why->max)
                       : refuse(why, row, REASON_CROSS_RULE, why->rule, table_get(row, params), row->min,
                                table_max(row));
}

static bool estimator_holds(const params_t *params, params_error_t *why)
{
    estimator_params_t estimator;
    const believed_t believed = params_believed(params);
    params_estimator(params, &believed, &estimator);
    const float pole_pairs = (float)params->motor_pole_pairs;
    const float share_max = ESTIMATOR_TORQUE_FEEDFORWARD_MAX * params->motor_inertia /
                            (1.5f * pole_pairs * pole_pairs * params->motor_flux_linkage);
    if (!rule_holds(why, "motor_resistance",
                    "motor_resistance + device_resistance <= motor_inductance_q / (2 T_s)",
                    params->motor_resistance, 1e-3f,
                    0.5f * params->motor_inductance_q / DRIVE_PERIOD - params->device_resistance) ||
        !rule_holds(why, "feedforward_cutoff", "feedforward_cutoff <= 0.95 pll_bandwidth",
                    params->feedforward_cutoff, 0.0f, 0.95f * params->pll_bandwidth) ||
        !rule_holds(why, "torque_feedforward",
                    "0 with feedforward_cutoff = 0, else nothing forgets its error",
                    params->torque_feedforward, 0.0f, params->feedforward_cutoff > 0.0f ? 2.0f : 0.0f) ||
        !rule_holds(why, "torque_feedforward",
                    "torque_feedforward 1.5 p^2 psi_f / motor_inertia <= 1e7 rad/s^2 per A",
                    params->torque_feedforward, 0.0f, share_max)) {
        return false;
    }
    if (!(params->estimate_speed_min < params->overspeed_trip)) {
        return refuse(why, table_by_name(&params_table, "estimate_speed_min"), REASON_CROSS_RULE,
                      "estimate_speed_min < overspeed_trip", params->estimate_speed_min, 0.0f,
                      params->overspeed_trip);
    }
    return chosen_params_check(&estimator, why) || refuse_for_estimator(params, why);
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
                      params->overspeed_trip, 1.0f,
                      0.5f / ((float)params->motor_pole_pairs * DRIVE_PERIOD)) &&
           estimator_holds(params, why);
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
