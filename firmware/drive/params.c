#include "drive/params.h"

/* Speed of the EMF below which the detector is divided by a constant [rad/s] electrical: 2 V of the paper's
 * motor, what its dead time leaves after compensation. */
#define FLOOR_SPEED 11.0f

static const table_row_t rows[] = {
#define ROW_FLOAT(id, name, unit, initial, min, max, access, text)                                           \
    {id, SLOT_FLOAT, access, offsetof(params_t, name), #name, unit, text, "", initial, min, max, {0, 0, 0}},
#define ROW_INT(id, name, unit, initial, min, max, access, text)                                             \
    {id,   SLOT_INT, access, offsetof(params_t, name), #name, unit, text, "",                                \
     0.0f, 0.0f,     0.0f,   {initial, min, max}},
#define ROW_ENUM(id, name, choices, initial, access, text)                                                   \
    {id,   SLOT_ENUM, access, offsetof(params_t, name), #name, "-", text, choices,                           \
     0.0f, 0.0f,      0.0f,   {initial, 0, 0}},
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
