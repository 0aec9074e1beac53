#include "drive/tuning.h"

believed_t drive_believed(const params_t *params, const learnt_t *learnt)
{
    believed_t believed = params_believed(params);
    if (learnt->inductance_q.from == params->motor_inductance_q) {
        const float ratio = learnt->inductance_q.value / params->motor_inductance_q;
        believed.inductance_d = ratio * params->motor_inductance_d;
        believed.inductance_q = learnt->inductance_q.value;
    }
    if (learnt->inertia.from == params->motor_inertia) {
        believed.inertia = learnt->inertia.value;
        if (learnt->inertia_known != 0u) {
            believed.inertia_known = 1u;
        }
    }
    return believed;
}

bool drive_may_believe(const params_t *params, const believed_t *believed)
{
    params_error_t ignored;
    estimator_params_t estimator;
    params_estimator(params, believed, &estimator);
    return chosen_params_check(&estimator, &ignored);
}

static void prepare_position(drive_tuning_t *tuning, const params_t *params, const believed_t *believed)
{
    const encoder_params_t encoder = {
        .count_per_turn = 4.0f * (float)params->encoder_lines,
        .pole_pairs = (float)params->motor_pole_pairs,
        .offset = params->encoder_offset,
        .bandwidth = params->encoder_bandwidth,
        .period = DRIVE_PERIOD,
    };
    encoder_prepare(&tuning->encoder, &encoder);

    estimator_params_t estimator;
    params_estimator(params, believed, &estimator);
    chosen_prepare(&tuning->estimator, &estimator);
}

static void prepare_adaptation(drive_tuning_t *tuning, const params_t *params, const believed_t *believed)
{
    const flux_params_t flux = {
        .flux_linkage = believed->flux_linkage,
        .adaptation = params->flux_adaptation,
        .period = DRIVE_PERIOD,
    };
    flux_prepare(&tuning->flux, &flux);
    const offset_trim_params_t trim = {.gain = params->offset_trim, .period = DRIVE_PERIOD};
    tuning->offset_trim = offset_trim_prepare(&trim);
    const inductance_params_t inductance = {
        .inductance_d = believed->inductance_d,
        .inductance_q = believed->inductance_q,
        .from = params->motor_inductance_q,
        .flux_linkage = believed->flux_linkage,
        .current_max = params->current_limit,
        .rate = params->inductance_adaptation,
        .period = DRIVE_PERIOD,
        .every = DRIVE_LEARN_PERIODS,
    };
    tuning->inductance = inductance_prepare(&inductance);
    const inertia_params_t inertia = {
        .from = params->motor_inertia,
        .flux_linkage = believed->flux_linkage,
        .pole_pairs = (float)params->motor_pole_pairs,
        .current_max = params->current_limit,
        .period = DRIVE_PERIOD,
        .on = params->inertia_adaptation == (int32_t)INERTIA_ON,
    };
    tuning->inertia = inertia_prepare(&inertia);
}

static void prepare_inverter(drive_tuning_t *tuning, const params_t *params, const believed_t *believed)
{
    const inverter_params_t inverter = {
        .dead_time =
            {
                .dead_time = params->dead_time,
                .turn_on_delay = params->turn_on_delay,
                .turn_off_delay = params->turn_off_delay,
                .drop = params->device_drop,
                .current_zone = params->current_zone,
                .gain = params->compensation_gain,
                .period = DRIVE_PERIOD,
            },
        .inductance = 0.5f * (believed->inductance_d + believed->inductance_q),
        .sampled_upper = BOARD_SAMPLES_AT == BOARD_UPPER_ZERO_VECTOR,
        .duty_min = params_duty_min(params),
        .duty_max = params_duty_max(params),
        .duty_counts = DRIVE_DUTY_COUNTS,
    };
    tuning->inverter = inverter_prepare(&inverter);
    const dead_time_learn_params_t learn = {
        .rate = params->dead_time_adaptation,
        .effective = tuning->inverter.lost.volt_per_volt,
        .band = params->dead_time / DRIVE_PERIOD,
        .flux_linkage = believed->flux_linkage,
        .zone = params->current_zone,
        .period = DRIVE_PERIOD,
        .every = DRIVE_LEARN_PERIODS,
    };
    tuning->dead_time_learn = dead_time_learn_prepare(&learn);
    const float pole_pairs = (float)params->motor_pole_pairs;
    const doubt_params_t doubt = {
        .current = params->doubtful_current,
        .emf_cutoff = params->observer_emf_cutoff,
        .acceleration_known = params->torque_feedforward > 0.0f && believed->inertia_known != 0u,
        .acceleration = 1.5f * pole_pairs * pole_pairs * believed->flux_linkage * params->current_limit /
                        believed->inertia,
        .period = DRIVE_PERIOD,
    };
    tuning->doubt = doubt_prepare(&doubt);
}

static void prepare_control(drive_tuning_t *tuning, const params_t *params, const believed_t *believed)
{
    const current_control_params_t current = {
        .resistance = believed->resistance,
        .inductance_d = believed->inductance_d,
        .inductance_q = believed->inductance_q,
        .bandwidth = params->current_bandwidth,
        .period = DRIVE_PERIOD,
    };
    tuning->current_control = current_control_prepare(&current);
    tuning->manoeuvres = manoeuvres_prepare(params, believed);
}

void drive_prepare(drive_tuning_t *tuning, const params_t *params, const believed_t *believed)
{
    tuning->measure = measure_prepare(params);
    tuning->guard = guard_prepare(params);
    tuning->sequence = sequence_prepare(params);
    prepare_position(tuning, params, believed);
    prepare_adaptation(tuning, params, believed);
    prepare_inverter(tuning, params, believed);
    prepare_control(tuning, params, believed);
}
