#include "drive/drive.h"

#include "drive/signals.h"
#include "math/bounds.h"
#include "math/trig.h"

/* Is what acted too uncertain to track by? */
static inline bool doubtful(drive_t *drive, const inverter_acted_t *acted)
{
    const estimate_t *last = &drive->estimator.estimate;
    const doubt_input_t input = {
        .current = acted->current,
        .leg = acted->leg,
        .amplitude = last->amplitude,
        .detector = last->detector,
        .omega_e = last->frame.omega_e,
        .omega_m = drive->omega_m,
        .omega_m_miss = drive->demand.omega_m_ref - drive->omega_m,
    };
    return doubt_step(&drive->doubt, &input);
}

/* The estimate at t_k, and what can be learnt of it. */
static void estimate(drive_t *drive)
{
    const measured_t *measured = &drive->measure.measured;
    const inverter_acted_t acted = inverter_acted(&drive->inverter, measured->current, measured->u_dc);
    drive->acted = acted.voltage;
    if (doubtful(drive, &acted)) {
        (void)chosen_coast(&drive->estimator, drive->acted, measured->current);
    } else {
        (void)chosen_step(&drive->estimator, drive->acted, measured->current);
    }

    if (drive->flux.tuning.share > 0.0f && drive->estimator.estimate.coasted == 0u) {
        flux_step(&drive->flux, drive->estimator.estimate.amplitude, drive->estimator.estimate.omega_smooth,
                  drive->estimator.estimate.detector);
        chosen_set_flux(&drive->estimator, drive->flux.flux_linkage, drive->flux.speed_per_volt);
    }
    (void)offset_trim_step(&drive->offset_trim, drive->estimator.estimate.emf_hat,
                           drive->estimator.estimate.frame.theta_e, drive->estimator.estimate.omega_smooth,
                           &measured->current);
}

/* The frame in force at t_k. While the bridge is off nothing is known of the voltage: the estimator rests,
 * and the encoder shows the rotor. */
static void locate(drive_t *drive)
{
    drive->encoder_position = encoder_step(&drive->encoder, drive->measure.measured.encoder_count);
    if (drive->estimating != 0u) {
        estimate(drive);
    }
    if (drive->estimating != 0u && drive->sequence.tuning.sensorless != 0u) {
        drive->frame = drive->estimator.estimate.frame;
    } else {
        drive->frame = (frame_t){drive->encoder_position.theta_e, drive->encoder_position.omega_e,
                                 trig_turn(drive->encoder_position.theta_e)};
    }
    drive->omega_m = drive->frame.omega_e * drive->pole_pairs_inverse;
    drive->current = frames_park(drive->measure.measured.current, drive->frame.rotation);
}

static void judge(drive_t *drive)
{
    const bool running = drive_bridge_on(drive) && drive->sequence.state != (int32_t)DRIVE_SWITCHED_ON;
    guard_step(&drive->guard, &drive->measure.measured, drive->omega_m,
               drive->sequence.tuning.sensorless != 0u ? drive->estimator.estimate.invalid : 0u, running);
}

static uint32_t sequence(drive_t *drive, const drive_samples_t *samples)
{
    const bool was_fault = drive->sequence.state == (int32_t)DRIVE_FAULT;
    calibration_t calibration = CALIBRATION_GOES_ON;
    if (drive->sequence.state == (int32_t)DRIVE_NOT_READY) {
        offset_trim_reset(&drive->offset_trim, (ab_t){0.0f, 0.0f});
        calibration = measure_calibrate(&drive->measure, samples);
    }
    const uint32_t order = sequence_step(&drive->sequence, &drive->requests, &drive->measure.measured,
                                         drive->guard.faults, drive->omega_m, calibration);
    const bool is_fault = drive->sequence.state == (int32_t)DRIVE_FAULT;
    if (is_fault && !was_fault) {
        drive_note_fault(drive);
    } else if (was_fault && !is_fault) {
        tap_history_clear(&drive->history);
    }
    return order;
}

static void start(drive_t *drive, uint32_t order)
{
    if ((order & SEQUENCE_PRESET) != 0u) {
        current_control_reset(&drive->current_control, (dq_t){0.0f, 0.0f});
        run_reset(&drive->run);
    }
    if ((order & SEQUENCE_TRACK) != 0u) {
        chosen_reset(&drive->estimator, drive->encoder_position, drive->measure.measured.current);
        flux_reset(&drive->flux, drive->encoder_position.omega_e);
        drive->estimating = 1u;
    }
}

static run_wish_t wish(const drive_t *drive)
{
    const requests_t *requests = &drive->requests;
    run_wish_t wish = {RUN_SPEED, requests->speed_request, {requests->i_d_request, requests->i_q_request}};
    if (drive->sequence.state == (int32_t)DRIVE_SWITCHED_ON) {
        wish.mode = RUN_ZERO;
    } else if (drive->sequence.state == (int32_t)DRIVE_QUICK_STOP) {
        wish.omega_m_ref = 0.0f;
    } else if (requests->mode == (int32_t)MODE_CURRENT) {
        wish.mode = RUN_CURRENT;
    }
    return wish;
}

/* Field-oriented control: a demand in, duties out. */
static abc_t control(drive_t *drive)
{
    const frame_t *frame = &drive->frame;
    const rotation_t acting = trig_advance(frame->rotation, 1.5f * DRIVE_PERIOD * frame->omega_e);
    const dq_t asked = current_control_step(&drive->current_control, drive->demand.current, drive->current,
                                            frame->omega_e, drive->demand.emf);
    const inverter_made_t made =
        inverter_make(&drive->inverter, frames_inverse_park(asked, acting),
                      frames_inverse_park(drive->demand.current, acting), drive->measure.measured.u_dc);
    const dq_t missing = frames_park(made.missing, acting);
    drive->voltage = (dq_t){asked.d + missing.d, asked.q + missing.q};
    current_control_applied(&drive->current_control, drive->voltage);
    return made.duty;
}

static void rest(drive_t *drive)
{
    const dq_t none = {0.0f, 0.0f};
    drive->demand = (demand_t){none, none, 0.0f};
    current_control_reset(&drive->current_control, none);
    drive->voltage = none;
    drive->command.duty = (abc_t){0.5f, 0.5f, 0.5f};
    drive->estimating = 0u;
}

void drive_step(drive_t *drive, const drive_samples_t *samples, drive_command_t *command)
{
    if (drive->offered != 0u) {
        drive_take(drive);
    }
    if (drive->period == 0u) {
        encoder_reset(&drive->encoder, samples->encoder);
    }
    drive->period++;

    measure_step(&drive->measure, samples, drive->offset_trim.offset);
    locate(drive);
    judge(drive);
    const uint32_t order = sequence(drive, samples);
    start(drive, order);
    if (drive_bridge_on(drive)) {
        const run_wish_t wished = wish(drive);
        drive->demand = run_step(&drive->run, &wished, drive->frame.omega_e, drive->omega_m);
        drive->command.duty = control(drive);
    } else {
        rest(drive);
    }
    drive->command.gates = (int32_t)(order & SEQUENCE_GATES);
    inverter_remember(&drive->inverter, drive->command.duty, drive->measure.measured.current,
                      drive->measure.measured.u_dc);
    /* up to the fault's own period, which is this one unless a trip came between two steps */
    if (drive->sequence.state != (int32_t)DRIVE_FAULT || drive->fault.period == drive->period) {
        tap_history_keep(&drive->history, signals_history_places, drive);
    }
    *command = drive->command;
}
