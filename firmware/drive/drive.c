#include "drive/drive.h"

#include <string.h>

#include "drive/reasons.h"
#include "math/angle.h"
#include "math/bounds.h"
#include "math/check.h"
#include "math/trig.h"

/* A sensor that reads half a per cent less than its end, or more, is there or broken [A]. */
#define CURRENT_MIDDLE (0.5f * (DRIVE_CURRENT_MAX + DRIVE_CURRENT_MIN))
#define CURRENT_HALF   (0.4975f * (DRIVE_CURRENT_MAX - DRIVE_CURRENT_MIN))
/* What phase c may have of a sensor's range: without one of its own it is the sum of two, and within twice
 * that. */
#define CURRENT_C_SHARE      (DRIVE_CURRENT_SENSORS == 3 ? 1.0f : 3.0f)
#define CURRENT_CALM         (0.745f * DRIVE_CURRENT_RANGE) /* [A] no sensor is at its end, whatever its offset */
#define U_DC_LIMIT           1000.0f               /* [V] no sensor of the board reads this: not a number */
#define TEMPERATURE_LIMIT    1000.0f               /* [degC] likewise */
#define SETTLE_PERIODS       64u                   /* [periods] after the start before offsets are averaged */
#define REARM_PERIODS        DRIVE_PERIODS(20e-3f) /* fault line high for so long before a reset */
#define ESTIMATE_CRITERIA    (ESTIMATOR_AMPLITUDE | ESTIMATOR_DETECTOR | ESTIMATOR_CURRENT | ESTIMATOR_SPEED)
#define DOUBT_SHARE          0.2f /* [-] of the largest phase current that may be in doubt: else all of a turn is */
#define DOUBT_EMF            4.0f  /* [-] EMF over a leg loss above which even a wrong sign is tracked */
#define DOUBT_SHARE_FORESEEN 0.02f /* [-] likewise, while the speed changes */
#define DOUBT_SPEED_STEADY   30.0f /* [rad/s] slower, a current is near zero for too long to coast */
#define DOUBT_SPEED_FORESEEN 10.0f /* [rad/s] likewise, while the speed changes */
#define DOUBT_DETECTOR       0.03f /* [-] a loop with an error to work off shall work */
#define DOUBT_SPEED_SHARE                                                                                    \
    0.1f /* [-] of the speed that may be missing: further from it, nothing may be missed */
#define DOUBT_ANGLE      0.005f /* [rad] */
#define DOUBT_DECAY      2.0f /* [-] time constants of the EMF filter until a doubtful voltage is forgotten */
#define DOUBT_EMF_CUTOFF 200.0f /* [rad/s] a slower filter than this, or none, is not waited for */
#define DOUBT_LEAST      3.0f   /* [periods] that the observer itself remembers */
#define STANDSTILL       2.0f   /* [rad/s] mechanical: quick stop ends below */

static float smaller_of(float x, float y)
{
    return x < y ? x : y;
}

static void retune(drive_t *drive, const params_t *params)
{
    drive->params = *params;
    drive->calm = (drive_calm_t){
        .current = smaller_of(params->overcurrent_trip, CURRENT_CALM),
        .u_dc_middle = 0.5f * (params->dc_overvoltage + params->dc_undervoltage),
        .u_dc_half = 0.4999f * (params->dc_overvoltage - params->dc_undervoltage),
        .sink_temperature = DRIVE_SINK_SENSOR ? params->sink_temperature_max : TEMPERATURE_LIMIT,
        .motor_temperature = DRIVE_MOTOR_SENSOR ? params->motor_temperature_max : TEMPERATURE_LIMIT,
        .omega_m = params->overspeed_trip,
    };
    drive->duty_min = params_duty_min(params);
    drive->duty_max = params_duty_max(params);
    drive->pole_pairs = (float)params->motor_pole_pairs;
    drive->pole_pairs_inverse = 1.0f / drive->pole_pairs;
    drive->calibration_weight = 1.0f / (float)params->calibration_periods;
    drive->doubt_periods =
        (uint32_t)(DOUBT_LEAST + (params->observer_emf_cutoff > DOUBT_EMF_CUTOFF
                                      ? DOUBT_DECAY / (params->observer_emf_cutoff * DRIVE_PERIOD)
                                      : 0.0f));

    const encoder_params_t encoder = {
        .count_per_turn = 4.0f * (float)params->encoder_lines,
        .pole_pairs = drive->pole_pairs,
        .offset = params->encoder_offset,
        .bandwidth = params->encoder_bandwidth,
        .period = DRIVE_PERIOD,
    };
    encoder_tuning_t encoder_tuning;
    encoder_prepare(&encoder_tuning, &encoder);
    encoder_take(&drive->encoder, &encoder_tuning);

    const speed_control_params_t speed = {
        .kp = params->speed_kp,
        .ki = params->speed_ki,
        .current_limit = params->current_limit,
        .period = DRIVE_PERIOD,
    };
    speed_control_retune(&drive->speed_control, &speed);

    const current_control_params_t current = {
        .resistance = params_resistance(params),
        .inductance_d = params->motor_inductance_d,
        .inductance_q = params->motor_inductance_q,
        .flux_linkage = params->motor_flux_linkage,
        .bandwidth = params->current_bandwidth,
        .period = DRIVE_PERIOD,
    };
    current_control_retune(&drive->current_control, &current);

    dead_time_params_t dead_time = {
        .dead_time = params->dead_time,
        .turn_on_delay = params->turn_on_delay,
        .turn_off_delay = params->turn_off_delay,
        .drop = params->device_drop,
        .current_zone = params->current_zone,
        .gain = params->compensation_gain,
        .period = DRIVE_PERIOD,
    };
    dead_time_retune(&drive->dead_time, &dead_time);
    dead_time.gain = 1.0f;
    dead_time_retune(&drive->dead_time_model, &dead_time);

    const offset_trim_params_t trim = {.gain = params->offset_trim, .period = DRIVE_PERIOD};
    offset_trim_retune(&drive->offset_trim, &trim);

    estimator_params_t estimator;
    params_estimator(params, &estimator);
    chosen_tuning_t estimator_tuning;
    chosen_prepare(&estimator_tuning, &estimator);
    chosen_take(&drive->estimator, &estimator_tuning);

    const flux_params_t flux = {.flux_linkage = estimator.flux_linkage,
                                .adaptation = estimator.flux_adaptation,
                                .period = DRIVE_PERIOD};
    flux_tuning_t flux_tuning;
    flux_prepare(&flux_tuning, &flux);
    flux_take(&drive->flux, &flux_tuning);
    chosen_set_flux(&drive->estimator, drive->flux.flux_linkage, drive->flux.speed_per_volt);

    const protection_limits_t limits = {
        .overcurrent = params->overcurrent_trip,
        .overvoltage = params->dc_overvoltage,
        .undervoltage = params->dc_undervoltage,
        .sink_temperature_max = params->sink_temperature_max,
        .motor_temperature_max = params->motor_temperature_max,
        .overspeed = params->overspeed_trip,
    };
    protection_retune(&drive->protection, &limits);
}

void drive_init(drive_t *drive, const params_t *params)
{
    params_error_t why;
    CHECK(params_check(params, &why));
    memset(drive, 0, sizeof *drive);
    retune(drive, params);
    chosen_reset(&drive->estimator, drive->position, drive->current_ab);
    flux_reset(&drive->flux, drive->position.omega_e);
    requests_defaults(&drive->requests);
    drive->state = DRIVE_NOT_READY;
}

bool drive_bridge_on(const drive_t *drive)
{
    return drive->state == DRIVE_SWITCHED_ON || drive->state == DRIVE_OPERATION_ENABLED ||
           drive->state == DRIVE_QUICK_STOP;
}

bool drive_apply(drive_t *drive, const params_t *next, params_error_t *why)
{
    if (!params_check(next, why) ||
        (drive_bridge_on(drive) && !params_check_live(&drive->params, next, why)) ||
        !requests_check(&drive->requests, next, why)) {
        return false;
    }
    retune(drive, next);
    return true;
}

bool drive_request(drive_t *drive, const requests_t *next, params_error_t *why)
{
    if (!requests_check(next, &drive->params, why)) {
        return false;
    }
    drive->requests = *next;
    return true;
}

static abc_t without_offset(const drive_t *drive, const drive_samples_t *samples)
{
    return (abc_t){samples->i_a - drive->offset.a, samples->i_b - drive->offset.b,
                   samples->i_c - drive->offset.c};
}

/* Each phase by itself: of three sensors a broken one shows what all have in common, which their vector has
 * not. */
static bool currents_within(abc_t i, float limit)
{
    return bounds_within(i.a, limit) && bounds_within(i.b, limit) && bounds_within(i.c, limit);
}

/* Nothing to look at more closely in this sample, as in almost every period: one comparison for each value
 * does for what is no measurement and for what breaks a limit. */
static bool is_calm(const drive_t *drive, const drive_samples_t *samples)
{
    const drive_calm_t *calm = &drive->calm;
    return (samples->flags | drive->protection.counting) == 0u && drive->state == DRIVE_OPERATION_ENABLED &&
           currents_within(without_offset(drive, samples), calm->current) &&
           bounds_within(samples->u_dc - calm->u_dc_middle, calm->u_dc_half) &&
           bounds_within(samples->sink_temperature, calm->sink_temperature) &&
           bounds_within(samples->motor_temperature, calm->motor_temperature);
}

static bool is_measurement(const drive_samples_t *samples)
{
    return bounds_within(samples->i_a - CURRENT_MIDDLE, CURRENT_HALF) &&
           bounds_within(samples->i_b - CURRENT_MIDDLE, CURRENT_HALF) &&
           bounds_within(samples->i_c - CURRENT_MIDDLE, CURRENT_C_SHARE * CURRENT_HALF) &&
           bounds_within(samples->u_dc, U_DC_LIMIT) &&
           bounds_within(samples->sink_temperature, TEMPERATURE_LIMIT) &&
           bounds_within(samples->motor_temperature, TEMPERATURE_LIMIT);
}

/* A sample that is no measurement is replaced by the last good one. */
static void take_samples(drive_t *drive, const drive_samples_t *samples, bool good)
{
    if (good) {
        drive->current_abc = without_offset(drive, samples);
        drive->u_dc = samples->u_dc;
        drive->sink_temperature = samples->sink_temperature;
        drive->motor_temperature = samples->motor_temperature;
    }
    drive->encoder_count = samples->encoder;
    drive->sample_flags = samples->flags;
}

static bool sensorless(const drive_t *drive)
{
    return drive->params.position_source == (int32_t)POSITION_SENSORLESS;
}

static uint32_t judge_closely(drive_t *drive, uint32_t bad_sample)
{
    const uint32_t flags = drive->sample_flags;
    const uint32_t gates_expected = drive_bridge_on(drive) && drive->state != DRIVE_SWITCHED_ON;
    const protection_input_t input = {
        .current = drive->current_abc,
        .u_dc = drive->u_dc,
        .sink_temperature = drive->sink_temperature,
        .motor_temperature = drive->motor_temperature,
        .omega_m = drive->omega_m,
        .tripped = (flags & DRIVE_SAMPLE_TRIPPED) != 0u,
        .encoder_error = (flags & DRIVE_SAMPLE_ENCODER) != 0u,
        .late = (flags & DRIVE_SAMPLE_LATE) != 0u,
        .bad_sample = bad_sample,
        .estimate = sensorless(drive) ? drive->estimator.estimate.invalid & ESTIMATE_CRITERIA : 0u,
        .bridge_on = gates_expected,
    };
    const uint32_t faults = protection_step(&drive->protection, &input);
    const bool quiet = faults == 0u && (flags & DRIVE_SAMPLE_FAULT_LINE) == 0u;
    drive->clear_periods = quiet ? drive->clear_periods + (drive->clear_periods < REARM_PERIODS) : 0u;
    return faults;
}

/* The faults of this period. */
static uint32_t judge(drive_t *drive, bool calm, uint32_t bad_sample)
{
    if (calm && bounds_within(drive->omega_m, drive->calm.omega_m) &&
        (drive->estimator.estimate.invalid == 0u || !sensorless(drive))) {
        drive->clear_periods += drive->clear_periods < REARM_PERIODS;
        return 0u;
    }
    return judge_closely(drive, bad_sample);
}

static void enter(drive_t *drive, drive_state_t state)
{
    drive->state = (int32_t)state;
    drive->state_periods = 0u;
}

static void enter_fault(drive_t *drive, int32_t reason)
{
    drive->fault = (drive_fault_t){
        .reason = reason,
        .period = drive->period,
        .later = 0u,
        .i_a = drive->current_abc.a,
        .i_b = drive->current_abc.b,
        .u_dc = drive->u_dc,
        .theta_e = drive->position.theta_e,
        .omega_e = drive->position.omega_e,
    };
    enter(drive, DRIVE_FAULT);
}

void drive_stop(drive_t *drive, int32_t reason)
{
    enter_fault(drive, reason);
}

void drive_trip(drive_t *drive)
{
    if (drive_bridge_on(drive)) {
        enter_fault(drive, REASON_MODULE_FAULT);
    }
}

/* Mean of the currents while none flows. The first samples after the start are left out: the sensors settle.
 */
static void calibrate(drive_t *drive, const drive_samples_t *samples, uint32_t bad_sample)
{
    if (drive->state_periods == 0u) {
        drive->offset = (abc_t){0.0f, 0.0f, 0.0f};
        offset_trim_reset(&drive->offset_trim, (ab_t){0.0f, 0.0f});
    }
    if (bad_sample != 0u || drive->state_periods < SETTLE_PERIODS) {
        drive->state_periods += bad_sample == 0u;
        return;
    }
    drive->offset.a += drive->calibration_weight * samples->i_a;
    drive->offset.b += drive->calibration_weight * samples->i_b;
    drive->offset.c += drive->calibration_weight * samples->i_c;
    drive->state_periods++;
    if (drive->state_periods >= SETTLE_PERIODS + (uint32_t)drive->params.calibration_periods) {
        const float limit = drive->params.current_offset_max;
        if (bounds_within(drive->offset.a, limit) && bounds_within(drive->offset.b, limit) &&
            bounds_within(drive->offset.c, CURRENT_C_SHARE * limit)) {
            enter(drive, DRIVE_READY);
        } else {
            enter_fault(drive, REASON_CURRENT_OFFSET);
        }
    }
}

static int32_t why_not_on(const drive_t *drive)
{
    if (drive->clear_periods < REARM_PERIODS) {
        return REASON_FAULT_PRESENT;
    }
    if (drive->u_dc < drive->params.dc_undervoltage) {
        return REASON_DC_UNDERVOLTAGE;
    }
    if (sensorless(drive) && bounds_within(drive->omega_m, drive->params.start_speed)) {
        return REASON_TOO_SLOW;
    }
    return REASON_NONE;
}

static void preset_control(drive_t *drive)
{
    current_control_reset(&drive->current_control, (dq_t){0.0f, 0.0f});
    speed_control_reset(&drive->speed_control, 0.0f);
}

/* One transition at most per period. Returns what the gates shall do. */
static drive_gates_t transit(drive_t *drive, const drive_samples_t *samples, uint32_t faults,
                             uint32_t bad_sample)
{
    const int32_t enable = drive->requests.enable;
    const bool reset_edge = drive->requests.fault_reset != 0 && drive->fault_reset_seen == 0;
    drive->fault_reset_seen = drive->requests.fault_reset;
    drive->refusal = REASON_NONE;
    drive->stopped = enable == REQUEST_OFF ? 0u : drive->stopped;

    if (drive->state == DRIVE_FAULT) {
        drive->fault.later |= faults;
        drive->refusal = enable == REQUEST_OFF ? REASON_NONE : REASON_FAULT_LATCHED;
        if (reset_edge && drive->clear_periods >= REARM_PERIODS) {
            drive->fault.reason = REASON_NONE;
            enter(drive, DRIVE_NOT_READY);
        } else if (reset_edge || drive->clear_periods < REARM_PERIODS) {
            drive->refusal = REASON_FAULT_PRESENT;
        }
        return GATES_OFF;
    }
    if (faults != 0u) {
        enter_fault(drive, protection_reason(faults));
        return GATES_OFF;
    }

    switch ((drive_state_t)drive->state) {
    case DRIVE_NOT_READY:
        drive->refusal = enable == REQUEST_OFF ? REASON_NONE : REASON_NOT_READY;
        calibrate(drive, samples, bad_sample);
        return GATES_OFF;
    case DRIVE_READY:
        if (enable == REQUEST_ON && drive->stopped == 0u) {
            drive->refusal = why_not_on(drive);
            if (drive->refusal == REASON_NONE) {
                preset_control(drive);
                enter(drive, DRIVE_SWITCHED_ON);
            }
        }
        return GATES_OFF;
    case DRIVE_SWITCHED_ON:
        if (enable != REQUEST_ON) {
            enter(drive, DRIVE_READY);
            return GATES_OFF;
        }
        /* First period: the duties of the turning rotor go out; second: the gates come on with them; third:
         * they must. */
        drive->state_periods++;
        if (drive->state_periods < 2u) {
            return GATES_ON;
        }
        if ((drive->sample_flags & DRIVE_SAMPLE_TRIPPED) != 0u) {
            enter_fault(drive, REASON_GATES_REFUSED);
            return GATES_OFF;
        }
        preset_control(drive);
        chosen_reset(&drive->estimator, drive->encoder_position, drive->current_ab);
        flux_reset(&drive->flux, drive->encoder_position.omega_e);
        drive->estimating = 1u;
        enter(drive, DRIVE_OPERATION_ENABLED);
        return GATES_KEEP;
    case DRIVE_OPERATION_ENABLED:
        if (enable == REQUEST_OFF) {
            enter(drive, DRIVE_READY);
            return GATES_OFF;
        }
        if (enable == REQUEST_QUICK_STOP) {
            enter(drive, DRIVE_QUICK_STOP);
        }
        return GATES_KEEP;
    case DRIVE_QUICK_STOP:
        if (enable == REQUEST_OFF || bounds_within(drive->omega_m, STANDSTILL)) {
            drive->stopped = 1u;
            enter(drive, DRIVE_READY);
            return GATES_OFF;
        }
        return GATES_KEEP;
    case DRIVE_FAULT:
        break;
    }
    return GATES_OFF;
}

/* The state machine. A drive that runs and shall run goes the short way. */
static drive_gates_t advance(drive_t *drive, const drive_samples_t *samples, uint32_t faults,
                             uint32_t bad_sample)
{
    if (faults != 0u || drive->state != DRIVE_OPERATION_ENABLED || drive->requests.enable != REQUEST_ON) {
        return transit(drive, samples, faults, bad_sample);
    }
    drive->fault_reset_seen = drive->requests.fault_reset;
    drive->refusal = REASON_NONE;
    return GATES_KEEP;
}

/* References of this period, which requests_check keeps within the limits; in switched on they are zero, so
 * that the gates come on without a current. */
static dq_t references(drive_t *drive)
{
    const int32_t state = drive->state;
    const float i_d = drive->requests.i_d_request;
    if (state == DRIVE_SWITCHED_ON) {
        return (dq_t){0.0f, 0.0f};
    }
    if (drive->requests.mode == MODE_CURRENT && state != DRIVE_QUICK_STOP) {
        const float i_q = drive->requests.i_q_request;
        speed_control_reset(&drive->speed_control, i_q);
        drive->omega_m_ref = drive->omega_m;
        return (dq_t){i_d, i_q};
    }
    drive->omega_m_ref = state == DRIVE_QUICK_STOP ? 0.0f : drive->requests.speed_request;
    return (dq_t){i_d, speed_control_step(&drive->speed_control, drive->omega_m_ref, drive->omega_m)};
}

/* The nearest duty that the compare registers can hold: what the observer is told is then what acts. */
static float whole_counts(float duty)
{
    return (float)(int32_t)(duty * DRIVE_DUTY_COUNTS + 0.5f) * (1.0f / DRIVE_DUTY_COUNTS);
}

/* The rotation in the middle of the period in which the voltage acts. */
static rotation_t rotation_ahead(const drive_t *drive, rotation_t at)
{
    const float angle = 1.5f * DRIVE_PERIOD * drive->position.omega_e;
    return bounds_within(angle, TRIG_ADVANCE_LIMIT)
               ? trig_advance(at, angle)
               : trig_rotation(angle_wrap(drive->position.theta_e + angle));
}

/* Field-oriented control: references in, duties out. `at` is the rotation by theta_e. */
static abc_t control(drive_t *drive, rotation_t at)
{
    const float omega_e = drive->position.omega_e;
    const rotation_t applied_at = rotation_ahead(drive, at);

    const dq_t reference = references(drive);
    const dq_t asked = current_control_step(&drive->current_control, reference, drive->current, omega_e);

    /* The current at the instant the voltage acts is best known from its reference: the sampled one has the
     * wrong sign near its zero crossings. */
    const ab_t current_then = frames_inverse_park(reference, applied_at);
    const ab_t lost = dead_time_voltage(&drive->dead_time, current_then, drive->u_dc);
    const ab_t wanted = frames_inverse_park(asked, applied_at);
    const svpwm_t modulated = svpwm_modulate((ab_t){wanted.alpha + lost.alpha, wanted.beta + lost.beta},
                                             drive->u_dc, drive->duty_min, drive->duty_max);
    dq_t applied = asked;
    if (modulated.cut != 0u) {
        applied = frames_park(
            (ab_t){modulated.voltage.alpha - lost.alpha, modulated.voltage.beta - lost.beta}, applied_at);
    }
    current_control_applied(&drive->current_control, applied);
    drive->current_ref = reference;
    drive->voltage_ref = asked;
    drive->voltage = applied;
    return (abc_t){whole_counts(modulated.duty.a), whole_counts(modulated.duty.b),
                   whole_counts(modulated.duty.c)};
}

/* Is the voltage of the last period too uncertain to track by? Around a zero crossing of a phase current the
 * sign of its leg's loss hangs on the sensor's offset, for as long as the current takes to pass. That matters
 * while the flux lost in this time could turn that of the rotor by more than DOUBT_ANGLE, and the whole loss
 * is no small part of the EMF. Coasting needs a speed that stays, or large currents whose torque the tracking
 * loop is told of. */
static bool doubtful(drive_t *drive, ab_t current, float leg)
{
    const dead_time_range_t range = dead_time_range(current);
    const float missing = drive->omega_m_ref - drive->omega_m;
    const float zone = drive->params.doubtful_current;
    const float amplitude = drive->estimator.estimate.amplitude;
    const bool steady = bounds_within(drive->estimator.estimate.detector, DOUBT_DETECTOR) &&
                        bounds_within(missing, DOUBT_SPEED_SHARE * bounds_magnitude(drive->omega_m)) &&
                        !bounds_within(drive->estimate.omega_e, DOUBT_SPEED_STEADY);
    const bool foreseen = drive->params.torque_feedforward > 0.0f &&
                          zone < DOUBT_SHARE_FORESEEN * range.largest &&
                          !bounds_within(drive->estimate.omega_e, DOUBT_SPEED_FORESEEN);
    if (!steady && !foreseen) {
        drive->doubt = 0u;
    } else if (range.smallest < zone && zone < DOUBT_SHARE * range.largest && amplitude < DOUBT_EMF * leg &&
               leg * zone > DOUBT_ANGLE * amplitude * range.largest) {
        drive->doubt = drive->doubt_periods;
    } else if (drive->doubt > 0u) {
        drive->doubt--;
    }
    return drive->doubt > 0u;
}

/* Nothing is in doubt where the EMF is far above a leg's loss: the short way. */
static bool in_doubt(drive_t *drive, ab_t current, float leg)
{
    return (drive->estimator.estimate.amplitude < DOUBT_EMF * leg || drive->doubt != 0u) &&
           doubtful(drive, current, leg);
}

/* psi_f follows what the estimator sees in the periods that it tracks. */
static void adapt_flux(drive_t *drive)
{
    const estimate_t *seen = &drive->estimator.estimate;
    if (drive->params.flux_adaptation > 0.0f && seen->coasted == 0u) {
        flux_step(&drive->flux, seen->amplitude, seen->omega_smooth, seen->detector);
        chosen_set_flux(&drive->estimator, drive->flux.flux_linkage, drive->flux.speed_per_volt);
    }
}

/* The estimate at t_k from the voltage that the duties of two steps ago made. */
static void estimate(drive_t *drive)
{
    const float u_dc = 0.5f * (drive->u_dc + drive->u_dc_prev);
    const ab_t middle = {0.5f * (drive->current_ab.alpha + drive->current_ab_prev.alpha),
                         0.5f * (drive->current_ab.beta + drive->current_ab_prev.beta)};
    const ab_t lost = dead_time_voltage(&drive->dead_time_model, middle, u_dc);
    const ab_t voltage = {drive->duty_prev[1].alpha * u_dc - lost.alpha,
                          drive->duty_prev[1].beta * u_dc - lost.beta};
    drive->observer_voltage = voltage;
    if (in_doubt(drive, middle, dead_time_leg(&drive->dead_time_model, u_dc))) {
        drive->estimate = chosen_coast(&drive->estimator, voltage, drive->current_ab);
    } else {
        drive->estimate = chosen_step(&drive->estimator, voltage, drive->current_ab);
    }
    adapt_flux(drive);
    (void)offset_trim_step(&drive->offset_trim, drive->estimator.estimate.emf_hat, drive->estimate.theta_e,
                           drive->estimator.estimate.omega_smooth, drive->current_ab);
}

/* Position at t_k, and the rotation by its angle. While the bridge is off nothing is known of the voltage:
 * the estimator rests, and the encoder shows the rotor. */
static rotation_t locate(drive_t *drive)
{
    drive->encoder_position = encoder_step(&drive->encoder, drive->encoder_count);
    if (drive->estimating != 0u) {
        estimate(drive);
        if (sensorless(drive)) {
            drive->position = drive->estimate;
            return drive->estimator.estimate.rotation;
        }
    }
    drive->position = drive->encoder_position;
    return trig_turn(drive->position.theta_e);
}

/* What the next step will want to know of this one. */
static void remember(drive_t *drive)
{
    drive->current_ab_prev = drive->current_ab;
    drive->u_dc_prev = drive->u_dc;
    drive->duty_prev[1] = drive->duty_prev[0];
    drive->duty_prev[0] = frames_clarke(drive->command.duty);
}

void drive_step(drive_t *drive, const drive_samples_t *samples, drive_command_t *command)
{
    drive->period++;
    const bool calm = is_calm(drive, samples);
    uint32_t bad_sample = 0u;
    if (!calm) {
        bad_sample = !is_measurement(samples);
        if (drive->period == 1u) {
            encoder_reset(&drive->encoder, samples->encoder);
        }
    }
    take_samples(drive, samples, bad_sample == 0u);

    const ab_t measured = frames_clarke(drive->current_abc);
    drive->current_ab = (ab_t){measured.alpha - drive->offset_trim.offset.alpha,
                               measured.beta - drive->offset_trim.offset.beta};
    const rotation_t at = locate(drive);
    drive->omega_m = drive->position.omega_e * drive->pole_pairs_inverse;
    drive->current = frames_park(drive->current_ab, at);

    const uint32_t faults = judge(drive, calm, bad_sample);
    const drive_gates_t gates = advance(drive, samples, faults, bad_sample);

    if (drive_bridge_on(drive)) {
        drive->command.duty = control(drive, at);
    } else {
        drive->current_ref = (dq_t){0.0f, 0.0f};
        drive->voltage_ref = (dq_t){0.0f, 0.0f};
        drive->voltage = (dq_t){0.0f, 0.0f};
        drive->omega_m_ref = 0.0f;
        drive->command.duty = (abc_t){0.5f, 0.5f, 0.5f};
        drive->estimating = 0u;
    }
    remember(drive);
    drive->command.gates = (int32_t)gates;
    *command = drive->command;
}
