#include "settings/tuning.h"

#include "math/angle.h"
#include "math/bounds.h"
#include "math/filter.h"
#include "math/periods.h"
#include "math/root.h"

/* Standard deviation of a measured current over the range: three codes [-]. */
#define CURRENT_NOISE 1.5e-3f

/* [-] of the sensors' range: with smaller currents the current watch, which needs 2 % in a phase and a
 * quarter of the largest more, may not report a broken wire. */
#define UNSEEN_SHARE 0.04f

/* Multiple of the speed at which the EMF exceeds the errors of the voltage, from which it judges the encoder
 * [-]. The noise of the observed EMF in a period does not count: the watch uses means over windows and has
 * its own limit of the noise. */
#define ENCODER_JUDGED_FROM 1.0f

/* Braking in terms of the current limit, beyond which the encoder's speed is no motion [-]: twice for errors
 * of J and psi_f of 30 %, and twice for a load that helps to brake. */
#define BRAKING_MOST 4.0f

/* Rates over that of the dead time [-]; largest differences of the legs, and the effect of noise on them at
 * first, over the dead band's voltage and over R [-]. */
#define EMF_SHAPE_RATE         0.3f
#define LEGS_RATE              0.2f
#define LEGS_VOLTAGE_MAX       0.2f
#define LEGS_VOLTAGE_CHANCE    0.008f
#define LEGS_RESISTANCE_MAX    0.3f
#define LEGS_RESISTANCE_CHANCE 0.025f

/* [rad] largest swing of a rotor with all of the torque at six times its speed, at which more than the
 * dead time is learnt from its EMF. */
#define SWING_MAX 0.05f

/* The speed control that takes over the load of a holding brake: largest turn of the shaft by a wrong
 * pre-torque [rad]; phase of the delays at its bandwidth [rad]; current by the noise of the speed, over the
 * current limit [-]; time to take over, times its bandwidth [-]. */
#define BRAKE_SLIP  0.0873f
#define BRAKE_PHASE 0.5f
#define BRAKE_NOISE 0.2f
#define BRAKE_TAKE  8.0f

assumed_t drive_assumed(const params_t *params, const learnt_t *learnt)
{
    assumed_t assumed = params_configured(params);
    const bool stays = params_salient(&assumed) || assumed.bend != 0.0f;
    if (learnt->resistance.from == assumed.resistance) {
        assumed.resistance = learnt->resistance.value;
    }
    if (learnt->inductance_q.from == params->motor_inductance_q) {
        /* exactly 1 for a round rotor: the drive then treats it as round, because the estimator needs more
         * time for a salient rotor */
        const float ratio = params->motor_inductance_d / params->motor_inductance_q;
        assumed.inductance_d = stays ? assumed.inductance_d : ratio * learnt->inductance_q.value;
        assumed.inductance_q = learnt->inductance_q.value;
        if (assumed.bend != 0.0f) {
            assumed.inductance_q *= params_saturation_share(params);
        }
    }
    if (learnt->inertia.from == params->motor_inertia) {
        assumed.inertia = learnt->inertia.value;
    }
    /* A salient rotor swings in the forced frame, and is handed over as soon as possible. */
    assumed.noise =
        params_salient(&assumed) ? 0.0f : params_noise(params, &assumed, root_or_none(learnt->noise_square));
    return assumed;
}

bool drive_may_assume(const params_t *params, const assumed_t *assumed)
{
    params_error_t ignored;
    estimator_params_t estimator;
    params_estimator(params, assumed, &estimator);
    return chosen_params_check(&estimator, &ignored);
}

static void prepare_position(drive_tuning_t *tuning, const params_t *params, const assumed_t *assumed)
{
    const encoder_params_t encoder = {
        .count_per_turn = 4.0f * (float)params->encoder_lines,
        .pole_pairs = (float)params->motor_pole_pairs,
        .offset = params->encoder_offset,
        .bandwidth = params->encoder_bandwidth,
        .period = DRIVE_PERIOD,
    };
    encoder_prepare(&tuning->fast.encoder, &encoder);

    estimator_params_t estimator;
    params_estimator(params, assumed, &estimator);
    chosen_prepare(&tuning->fast.estimator, &estimator);
    validity_prepare(&tuning->medium.validity, &estimator.validity, DRIVE_WINDOW_PERIOD);
}

static void prepare_sigma(drive_tuning_t *tuning, const params_t *params, const assumed_t *assumed)
{
    estimator_params_t estimator;
    params_estimator(params, assumed, &estimator);
    const pll_params_t loop = estimator.pll;
    const angle_sigma_params_t sigma = {
        .data = params->motor_data_uncertainty,
        .resistance = assumed->resistance,
        .inductance_d = assumed->inductance_d,
        .inductance_q = assumed->inductance_q,
        .kp = loop.kp,
        .ki = loop.ki,
        .band = params->dead_time / DRIVE_PERIOD,
        .zone = params->current_zone,
        .leg_rate = params->dead_time_adaptation,
        .inductance_rate = tuning->medium.inductance.rate,
        .encoder = 0.5f * ANGLE_PI * (float)params->motor_pole_pairs / (float)params->encoder_lines,
        .period = DRIVE_PERIOD,
        .window = DRIVE_WINDOW_PERIOD,
    };
    tuning->medium.angle_sigma = angle_sigma_prepare(&sigma);
    tuning->fast.lean = loop_lean_prepare(params->motor_data_uncertainty, assumed->inductance_q,
                                          assumed->flux_linkage, &loop);
}

static void prepare_adaptation(drive_tuning_t *tuning, const params_t *params, const assumed_t *assumed)
{
    const flux_params_t flux = {
        .flux_linkage = assumed->flux_linkage,
        .adaptation = params->flux_adaptation,
        .period = DRIVE_WINDOW_PERIOD,
    };
    flux_prepare(&tuning->medium.flux, &flux);
    const offset_trim_params_t trim = {
        .gain = params->offset_trim,
        .period = DRIVE_WINDOW_PERIOD,
        .saliency = assumed->inductance_q - assumed->inductance_d,
    };
    tuning->medium.offset_trim = offset_trim_prepare(&trim);
    const inductance_params_t inductance = {
        .inductance_d = assumed->inductance_d,
        .inductance_q = (1.0f + assumed->bend) * assumed->inductance_q,
        .observed_q = assumed->inductance_q,
        .saturation = params->motor_saturation_current,
        .from = params->motor_inductance_q,
        .resistance = assumed->resistance,
        .resistance_from = params_configured(params).resistance,
        .flux_linkage = assumed->flux_linkage,
        .current_max = params->current_limit,
        .acceleration = (float)params->motor_pole_pairs * params_acceleration(params, assumed),
        .noise = assumed->noise,
        .rate = params->inductance_adaptation,
        .period = DRIVE_PERIOD,
        .every = DRIVE_WINDOW,
        .ahead = DRIVE_LATENCY,
        .salient = params->motor_inductance_q > INDUCTANCE_SALIENT_MAX * params->motor_inductance_d,
        .salient_too = params->salient_adaptation == (int32_t)SALIENT_ADAPTATION_ON,
    };
    tuning->medium.inductance = inductance_prepare(&inductance);
    const inertia_params_t inertia = {
        .from = params->motor_inertia,
        .inertia = assumed->inertia,
        .flux_linkage = assumed->flux_linkage,
        .pole_pairs = (float)params->motor_pole_pairs,
        .current_max = params->current_limit,
        .period = DRIVE_WINDOW_PERIOD,
        .on = params->inertia_adaptation == (int32_t)INERTIA_ON,
    };
    tuning->medium.inertia = inertia_prepare(&inertia);
    prepare_sigma(tuning, params, assumed);
}

/* True if the rotor swings little with the sixth harmonic of the torque at the current limit, at the speed
 * whose EMF is the dead band's voltage: the angle of the swing over the share of that harmonic is below
 * SWING_MAX. The swing of a light rotor is neither a shape of its EMF, nor an effect of unequal legs. */
static bool is_heavy(const params_t *params, const assumed_t *assumed)
{
    const float pole_pairs = (float)params->motor_pole_pairs;
    const float acceleration =
        1.5f * pole_pairs * pole_pairs * assumed->flux_linkage * params->current_limit / assumed->inertia;
    const float sixth =
        6.0f * params->dead_time / DRIVE_PERIOD * params->dc_overvoltage / assumed->flux_linkage;
    return acceleration < SWING_MAX * sixth * sixth;
}

static void prepare_shape_and_legs(drive_tuning_t *tuning, const params_t *params, const assumed_t *assumed)
{
    const float rate = is_heavy(params, assumed) ? params->dead_time_adaptation : 0.0f;
    const float per_rate = rate > 0.0f ? 1.0f / rate : 0.0f;
    const float band = params->dead_time / DRIVE_PERIOD * params->dc_overvoltage;
    tuning->medium.emf_shape = (emf_shape_tuning_t){
        .rate = EMF_SHAPE_RATE * rate,
        .per_rate = per_rate / EMF_SHAPE_RATE,
        .flux_linkage = assumed->flux_linkage,
    };
    tuning->medium.unequal_legs = (unequal_legs_tuning_t){
        .rate = LEGS_RATE * rate,
        .per_rate = per_rate / LEGS_RATE,
        .voltage_max = LEGS_VOLTAGE_MAX * band,
        .voltage_chance = LEGS_VOLTAGE_CHANCE * band,
        .resistance_max = LEGS_RESISTANCE_MAX * assumed->resistance,
        .resistance_chance = LEGS_RESISTANCE_CHANCE * assumed->resistance,
        .per_zone = tuning->fast.inverter.lost.per_zone,
    };
}

static void prepare_inverter(drive_tuning_t *tuning, const params_t *params, const assumed_t *assumed)
{
    const inverter_params_t inverter = {
        .dead_time =
            {
                .dead_time = params->dead_time,
                .turn_on_delay = params->turn_on_delay,
                .turn_off_delay = params->turn_off_delay,
                .drop = params->device_drop,
                .current_zone = params->current_zone,
                .period = DRIVE_PERIOD,
            },
        .compensated = params->compensation_gain,
        .inductance = 0.5f * (assumed->inductance_d + assumed->inductance_q),
        .sampled_upper = BOARD_SAMPLES_AT == BOARD_UPPER_ZERO_VECTOR,
        .duty_min = params_duty_min(params),
        .duty_max = params_duty_max(params),
        .duty_counts = DRIVE_DUTY_COUNTS,
        .over_modulation = params->over_modulation == (int32_t)OVER_MODULATION_ON,
    };
    tuning->fast.inverter = inverter_prepare(&inverter);
    const dead_time_learn_params_t learn = {
        .rate = params->dead_time_adaptation,
        .effective = tuning->fast.inverter.lost.volt_per_volt,
        .band = params->dead_time / DRIVE_PERIOD,
        .flux_linkage = assumed->flux_linkage,
        .zone = params->current_zone,
        .inductance = assumed->inductance_q,
        .period = DRIVE_PERIOD,
        .every = DRIVE_WINDOW,
    };
    tuning->medium.dead_time_learn = dead_time_learn_prepare(&learn);
    prepare_shape_and_legs(tuning, params, assumed);
    const float pole_pairs = (float)params->motor_pole_pairs;
    const doubt_params_t doubt = {
        .current = params->doubtful_current,
        .emf_cutoff = params->observer_emf_cutoff,
        .acceleration_known = params->torque_feedforward > 0.0f,
        .acceleration =
            1.5f * pole_pairs * pole_pairs * assumed->flux_linkage * params->current_limit / assumed->inertia,
        .current_max = params->current_limit,
        .period = DRIVE_PERIOD,
    };
    tuning->fast.doubt = doubt_prepare(&doubt);
    tuning->medium.load = (inertia_shares_t){
        .follows = lowpass_share(INERTIA_LOAD_CUTOFF, DRIVE_PERIOD),
        .settles = lowpass_share(INERTIA_LOAD_SETTLES, DRIVE_PERIOD),
        .most = tuning->fast.doubt.load_most,
    };
}

static void prepare_control(drive_tuning_t *tuning, const params_t *params, const assumed_t *assumed)
{
    const current_control_params_t current = params_current_control(params, assumed);
    tuning->fast.current_control = current_control_prepare(&current);
    tuning->medium.manoeuvres = manoeuvres_prepare(params, assumed);
    tuning->fast.reference = reference_prepare(params, assumed);
}

static float encoder_step_of(const params_t *params)
{
    return 2.0f * ANGLE_PI / (4.0f * (float)params->encoder_lines);
}

/* Speed noise of the encoder [rad/s]: 0.75 times its bandwidth times the half step, mechanical
 * (docs/theory.md, 18). */
static float speed_noise(const params_t *params)
{
    return 0.75f * params->encoder_bandwidth * 0.5f * encoder_step_of(params);
}

static void prepare_motion(drive_tuning_t *tuning, const params_t *params, const assumed_t *assumed)
{
    const float pole_pairs = (float)params->motor_pole_pairs;
    const float step = encoder_step_of(params);
    const start_params_t start = params_start(params, assumed);
    const encoder_watch_params_t encoder = {
        .resistance = assumed->resistance,
        .inductance = assumed->inductance_q,
        .saliency = assumed->inductance_q - assumed->inductance_d,
        .flux_linkage = assumed->flux_linkage,
        .speed_least = pole_pairs * ENCODER_JUDGED_FROM * start.visible_speed,
        .noise = CURRENT_NOISE * DRIVE_CURRENT_RANGE,
        .doubtful = 2.0f * MEASURE_MOVED,
        .unseen = UNSEEN_SHARE * DRIVE_CURRENT_RANGE,
        .step = pole_pairs * step,
        .period = DRIVE_PERIOD,
        .every = DRIVE_WINDOW,
    };
    tuning->medium.encoder_watch = encoder_watch_prepare(&encoder);
    const motion_watch_params_t motion = {
        .per_ampere = params_acceleration(params, assumed),
        .current_limit = params->current_limit,
        .noise = speed_noise(params),
        .standing = SEQUENCE_STANDSTILL,
        .stall_time = params->stall_time,
        .speed_error_time = params->speed_error_time,
        .period = DRIVE_PERIOD,
        .every = DRIVE_WINDOW,
    };
    tuning->medium.motion_watch = motion_watch_prepare(&motion);
    const loop_params_t loop = params_loop(params, assumed);
    const oscillation_watch_params_t oscillation = {
        .slow = loop.speed,
        .fast = loop.bandwidth,
        .current_limit = params->current_limit,
        .period = DRIVE_PERIOD,
        .every = DRIVE_WINDOW,
    };
    tuning->medium.oscillation_watch = oscillation_watch_prepare(&oscillation);
    const float acceleration = pole_pairs * motion.per_ampere * params->current_limit;
    tuning->fast.limits = (fast_limits_t){
        .jump = tuning->medium.encoder_watch.leap,
        .settled = encoder_missed_most(&tuning->fast.encoder, BRAKING_MOST * acceleration),
        .pole_pairs_inverse = 1.0f / pole_pairs,
        .dc_undervoltage = params->dc_undervoltage,
        .charge_periods = DRIVE_CHARGE_PERIODS,
    };
}

static void prepare_current_watch(drive_tuning_t *tuning, const params_t *params)
{
    const assumed_t configured = params_configured(params);
    const current_watch_params_t current = {
        .resistance = params->motor_resistance + params->device_resistance,
        .inductance_d = params->motor_inductance_d,
        .inductance_q = configured.inductance_q,
        .least = params_inductance_least(params, &configured),
        .flux_linkage = params->motor_flux_linkage,
        .per_ampere = 1.5f * (float)params->motor_pole_pairs * (float)params->motor_pole_pairs *
                      params->motor_flux_linkage / params->motor_inertia,
        .dead_time = params->dead_time,
        .drop = params->device_drop,
        .range = DRIVE_CURRENT_RANGE,
        .three_sensors = DRIVE_CURRENT_SENSORS == 3,
        .judged = params->current_judged == (int32_t)CURRENT_JUDGED,
        .period = DRIVE_PERIOD,
    };
    tuning->medium.current_watch = current_watch_prepare(&current);
    const float l_d = current.inductance_d;
    const float l_q = params->motor_inductance_q;
    const still_watch_params_t still = {
        .range = current.range,
        .inductance = l_d > l_q ? l_d : l_q,
        .gain = params->current_bandwidth * (l_d < l_q ? l_d : l_q),
        .dead_time = current.dead_time,
        .drop = current.drop,
        .period = current.period,
        .three_sensors = current.three_sensors,
        .judged = current.judged,
    };
    tuning->fast.still_watch = still_watch_prepare(&still);
}

static void prepare_commission(drive_tuning_t *tuning, const params_t *params, const assumed_t *assumed)
{
    tuning->medium.commission = (commission_tuning_t){
        .current_max = params->current_limit,
        .current_hold = params->motor_current_continuous > 0.0f ? params->motor_current_continuous
                                                                : params->current_limit,
        .pole_pairs = (float)params->motor_pole_pairs,
        .undervoltage = params->dc_undervoltage,
        .noise_max = CURRENT_NOISE * DRIVE_CURRENT_RANGE,
        .period = DRIVE_PERIOD,
        .window = DRIVE_WINDOW_PERIOD,
        .inductance_d = params->motor_inductance_d,
        .inductance_q = params->motor_inductance_q,
        .observed_q = assumed->inductance_q,
        .saturation = params->motor_saturation_current,
        .flux_linkage = params->motor_flux_linkage,
        .inertia = params->motor_inertia,
        .loop_gain = params->current_bandwidth * DRIVE_PERIOD,
        /* the dead time delays one of the edges */
        .edge_delay = 0.5f * (params->dead_time + params->turn_on_delay + params->turn_off_delay),
    };
}

static void prepare_limits(drive_tuning_t *tuning, const params_t *params, const assumed_t *assumed)
{
    const thermal_params_t thermal = {
        .current_max = params->current_limit,
        .motor_continuous = params->motor_current_continuous,
        .motor_time = params->motor_time_constant,
        .module_continuous = params->module_current_continuous,
        .module_time = params->module_time_constant,
        .sink_hot = params->sink_temperature_max,
        .motor_hot = params->motor_temperature_max,
        .period = DRIVE_WINDOW_PERIOD,
    };
    tuning->medium.thermal = thermal_prepare(&thermal);
    const link_limit_params_t limit = {
        .overvoltage = params->dc_overvoltage,
        .undervoltage = params->dc_undervoltage,
        .rides = periods_of(params->ride_through_time, DRIVE_WINDOW_PERIOD) != 0u,
        .current_max = params->current_limit,
        .resistance = assumed->resistance,
        .torque = 1.5f * (float)params->motor_pole_pairs * assumed->flux_linkage,
    };
    tuning->fast.link = link_limit_prepare(&limit);
    const link_watch_params_t watch = {
        .undervoltage = params->dc_undervoltage,
        .hold = tuning->fast.link.hold,
        .band = LINK_HOLD_BAND * params->dc_undervoltage,
        .driving_from = tuning->fast.link.driving_from,
        .ride_time = params->ride_through_time,
        .period = DRIVE_WINDOW_PERIOD,
    };
    tuning->medium.link = link_watch_prepare(&watch);
    const supply_limit_params_t supply = {
        .drawn = params->supply_current_max,
        .back = params->supply_current_regen_max,
        .current_max = params->current_limit,
        .resistance = assumed->resistance,
        .torque = limit.torque,
        .drop = params->device_drop,
        .free_emf = LINK_FREE * assumed->resistance * params->current_limit,
        .period = DRIVE_WINDOW_PERIOD,
    };
    tuning->medium.supply = supply_limit_prepare(&supply);
}

/* The speed control while the holding brake is released: by how much its bandwidth has to be higher so that a
 * pre-torque that is wrong by the whole current limit turns the shaft by BRAKE_SLIP, i/ki. It is limited by
 * the delays of the loop, and by the noise of the encoder's speed, which k_p converts to a current. */
static float brake_stiffness(const drive_tuning_t *tuning, const params_t *params, float per_ampere)
{
    const pi_tuning_t *pi = &tuning->medium.manoeuvres.run.speed.pi;
    const float slip = BRAKE_SLIP * pi->ki_period / DRIVE_WINDOW_PERIOD;
    const float delay =
        2.0f / params->encoder_bandwidth + 1.0f / params->current_bandwidth + 1.5f * DRIVE_PERIOD;
    const float wanted = root_or_none(params->current_limit / slip);
    const float stable = BRAKE_PHASE / (delay * per_ampere * pi->kp);
    const float quiet = BRAKE_NOISE * params->current_limit / (speed_noise(params) * pi->kp);
    return bounds_more(bounds_less(wanted, bounds_less(stable, quiet)), 1.0f);
}

static void prepare_outputs(drive_tuning_t *tuning, const params_t *params, const assumed_t *assumed)
{
    const float per_ampere = params_acceleration(params, assumed);
    const float stiff = brake_stiffness(tuning, params, per_ampere);
    const float bandwidth = stiff * tuning->medium.manoeuvres.run.speed.pi.kp * per_ampere;
    tuning->fast.chopper = chopper_prepare(params->chopper_voltage);
    const chopper_watch_params_t resistor = {
        .voltage = params->chopper_voltage,
        .below = tuning->fast.chopper.below,
        .resistance = params->chopper_resistance,
        .continuous = params->chopper_power,
        .time = params->chopper_time_constant,
        .period = DRIVE_WINDOW_PERIOD,
        .periods = (float)DRIVE_WINDOW,
    };
    tuning->medium.outputs.chopper = chopper_watch_prepare(&resistor);
    const holding_brake_params_t brake = {
        .on = params->holding_brake == (int32_t)BRAKE_HOLDING,
        .release_time = params->brake_release_time,
        .take_time = BRAKE_TAKE / bandwidth,
        .apply_time = params->brake_apply_time,
        .preload = tuning->medium.manoeuvres.run.per_torque * params->brake_preload,
        .current_limit = params->current_limit,
        .period = DRIVE_WINDOW_PERIOD,
    };
    tuning->medium.outputs.brake = holding_brake_prepare(&brake);
    tuning->medium.outputs.preload = params->brake_preload;
    tuning->medium.outputs.stiff = stiff;
}

void drive_prepare(drive_tuning_t *tuning, const params_t *params, const assumed_t *assumed)
{
    tuning->fast.measure = measure_prepare(params);
    tuning->medium.guard = guard_prepare(params);
    tuning->fast.guard = tuning->medium.guard;
    tuning->medium.unattended_max =
        params->background_time_max > 0.0f ? DRIVE_PERIODS(params->background_time_max) : UINT32_MAX;
    tuning->medium.sequence = sequence_prepare(params);
    prepare_position(tuning, params, assumed);
    prepare_adaptation(tuning, params, assumed);
    prepare_inverter(tuning, params, assumed);
    prepare_control(tuning, params, assumed);
    prepare_motion(tuning, params, assumed);
    prepare_current_watch(tuning, params);
    prepare_commission(tuning, params, assumed);
    prepare_limits(tuning, params, assumed);
    prepare_outputs(tuning, params, assumed);
    tuning->medium.in_force = params_in_force(params, assumed);
}
