#include "drive/drive.h"

#include "math/bounds.h"
#include "math/trig.h"

/* The offsets of the current sensors, while the bridge is off. Below dc_undervoltage a rotor that turns
 * slowly may feed the link with what seems to be one. */
static calibration_t calibrate(drive_t *drive, const drive_samples_t *samples)
{
    const ab_t none = {0.0f, 0.0f};
    measure_t *measure = &drive->measure;
    if (drive->sequence.state == (int32_t)DRIVE_NOT_READY) {
        offset_trim_reset(&drive->offset_trim, none);
        return measure_calibrate(measure, samples);
    }
    if (drive->sequence.state != (int32_t)DRIVE_READY) {
        return CALIBRATION_GOES_ON;
    }
    if (measure->measured.u_dc < drive->sequence.tuning.dc_undervoltage) {
        measure_begin_rest(measure);
    } else if (measure_rest(measure, samples, drive->offset_trim.offset)) {
        offset_trim_reset(&drive->offset_trim, none);
    }
    return (calibration_t)measure->rest.found;
}

static uint32_t sequence(drive_t *drive, const drive_samples_t *samples)
{
    const bool was_fault = drive->sequence.state == (int32_t)DRIVE_FAULT;
    const sequence_input_t input = {
        .requests = &drive->requests,
        .measured = &drive->measure.measured,
        .faults = drive->guard.faults,
        .stops = drive->guard.stops,
        .standing =
            manoeuvres_knows(&drive->manoeuvres) && bounds_within(drive->omega_m, SEQUENCE_STANDSTILL),
        .calibration = drive_bridge_on(drive) ? CALIBRATION_GOES_ON : calibrate(drive, samples),
    };
    const uint32_t order = sequence_step(&drive->sequence, &input);
    const bool is_fault = drive->sequence.state == (int32_t)DRIVE_FAULT;
    if (is_fault && !was_fault) {
        drive_note_fault(drive);
    } else if (was_fault && !is_fault) {
        capture_reset(&drive->capture);
    }
    return order;
}

static void start(drive_t *drive, uint32_t order)
{
    const bool sensorless = drive->manoeuvres.sensorless != 0u;
    const position_t unknown = {0.0f, 0.0f};
    if ((order & SEQUENCE_PRESET) != 0u) {
        measure_begin_rest(&drive->measure);
        current_control_reset(&drive->current_control, (dq_t){0.0f, 0.0f});
        manoeuvres_begin(&drive->manoeuvres, drive->omega_m);
    }
    if ((order & SEQUENCE_TRACK) != 0u) {
        const position_t from = sensorless ? unknown : drive->encoder_position;
        chosen_reset(&drive->estimator, from, drive->measure.measured.current);
        flux_reset(&drive->flux, from.omega_e);
        offset_trim_reset(&drive->offset_trim, drive->offset_trim.offset);
        current_watch_begin(&drive->current_watch);
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
        wish.mode = RUN_STOP;
    } else if (requests->mode == (int32_t)MODE_CURRENT) {
        wish.mode = RUN_CURRENT;
    }
    return wish;
}

/* What the manoeuvre asks for. Where it locks the loop, the next step goes on from there. */
static void manoeuvre(drive_t *drive)
{
    const manoeuvres_input_t input = {
        .current = drive->measure.measured.current,
        .voltage_max = FRAMES_ONE_OVER_SQRT_3 * drive->measure.measured.u_dc,
        .estimate = &drive->estimator.estimate,
        .encoder = &drive->encoder_frame,
        .omega_m = drive->omega_m,
        .wish = wish(drive),
        .estimating = drive->estimating,
        .losses = drive->guard.losses.word[0] | drive->guard.losses.word[1],
    };
    const frame_t last = drive->demand.frame;
    manoeuvres_step(&drive->manoeuvres, &input, &drive->demand);
    if (drive->manoeuvres.locking != 0u) {
        chosen_lock(&drive->estimator, drive->manoeuvres.locked, drive->manoeuvres.locked_emf);
        flux_reset(&drive->flux, drive->manoeuvres.locked.omega_e);
        offset_trim_reset(&drive->offset_trim, drive->offset_trim.offset);
    }
    const rotation_t now = drive->demand.frame.rotation;
    if (drive->demand.change == (int32_t)FRAME_TURNS) {
        const rotation_t before = trig_advance(last.rotation, DRIVE_PERIOD * last.omega_e);
        current_control_turn(&drive->current_control, frames_between(before, now));
    } else if (drive->demand.change == (int32_t)FRAME_ANEW) {
        current_control_reset(&drive->current_control, (dq_t){0.0f, 0.0f});
    }
    drive->current = frames_park(drive->measure.measured.current, now);
}

/* A locked loop without encoder is shaken a little, to learn from its answer. */
static void shake(drive_t *drive)
{
    if (manoeuvres_steady(&drive->manoeuvres)) {
        drive->demand.current.d += drive->inductance.dither.d;
        drive->demand.current.q += drive->inductance.dither.q;
    }
}

/* Field-oriented control: a demand in, duties out. */
static abc_t control(drive_t *drive)
{
    const frame_t *frame = &drive->demand.frame;
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
    drive->demand = (demand_t){drive->rotor, (int32_t)FRAME_GOES_ON, none, none, 0.0f};
    manoeuvres_end(&drive->manoeuvres);
    drive_learn_pause(drive);
    current_control_reset(&drive->current_control, none);
    drive->current = frames_park(drive->measure.measured.current, drive->rotor.rotation);
    drive->voltage = none;
    drive->command.duty = (abc_t){0.5f, 0.5f, 0.5f};
    drive->estimating = 0u;
}

void drive_step(drive_t *drive, const drive_samples_t *samples, drive_command_t *command)
{
    if (drive->offered != 0u) {
        drive_take(drive, samples->encoder);
    }
    if (drive->period == 0u) {
        encoder_reset(&drive->encoder, samples->encoder);
    }
    drive->period++;

    measure_step(&drive->measure, samples, drive->offset_trim.offset);
    drive_locate(drive);
    drive_protect(drive);
    const uint32_t order = sequence(drive, samples);
    start(drive, order);
    if (drive_bridge_on(drive)) {
        manoeuvre(drive);
        shake(drive);
        drive->command.duty = control(drive);
        if ((order & SEQUENCE_CHARGE) != 0u) {
            drive->command.duty = (abc_t){0.0f, 0.0f, 0.0f};
        }
    } else {
        rest(drive);
    }
    drive->command.gates = (int32_t)(order & SEQUENCE_GATES);
    inverter_remember(&drive->inverter, drive->command.duty, drive->measure.measured.current,
                      drive->measure.measured.u_dc);
    capture_step(&drive->capture, drive, drive->period);
    *command = drive->command;
}
