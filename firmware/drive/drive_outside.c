#include "drive/drive.h"

#include <string.h>

#include "drive/reasons.h"
#include "drive/signals.h"
#include "math/bounds.h"
#include "math/check.h"

/* [-] of the EMF that a rotor of the estimated speed has: psi_f wrong by a quarter, and an angle by 0.35 rad
 */
#define CONFIRMED_LEAST 0.7f
#define CONFIRMED_MOST  1.5f

/* [-] of the link, that the EMF of a rotor may have whose current through the diodes is not seen */
#define CONFIRMED_BEYOND 1.15f

void drive_take(drive_t *drive, uint32_t encoder_count)
{
    const drive_tuning_t *tuning = &drive->offer;
    measure_take(&drive->measure, &tuning->measure);
    guard_take(&drive->guard, &tuning->guard);
    drive->unattended_max = tuning->unattended_max;
    encoder_take(&drive->encoder, &tuning->encoder, encoder_count);
    chosen_take(&drive->estimator, &tuning->estimator);
    flux_take(&drive->flux, &tuning->flux);
    chosen_set_flux(&drive->estimator, drive->flux.flux_linkage, drive->flux.speed_per_volt);
    offset_trim_take(&drive->offset_trim, &tuning->offset_trim);
    inductance_take(&drive->inductance, &tuning->inductance);
    inertia_take(&drive->inertia, &tuning->inertia);
    chosen_set_load(&drive->estimator, drive->inertia.load);
    inverter_take(&drive->inverter, &tuning->inverter);
    dead_time_learn_take(&drive->dead_time_learn, &tuning->dead_time_learn);
    inverter_set_dead_time(&drive->inverter, drive->dead_time_learn.effective);
    unequal_legs_take(&drive->unequal_legs, &tuning->unequal_legs);
    drive_set_legs(drive);
    emf_shape_take(&drive->emf_shape, &tuning->emf_shape);
    if (tuning->emf_shape.rate == 0.0f) {
        drive->emf_shape_voltage = 0.0f;
        drive->emf_shape_share = 0.0f;
    }
    drive->learns =
        tuning->inductance.rate > 0.0f || tuning->dead_time_learn.rate > 0.0f || tuning->inertia.on != 0u;
    drive->doubt.tuning = tuning->doubt;
    current_control_take(&drive->current_control, &tuning->current_control);
    manoeuvres_take(&drive->manoeuvres, &tuning->manoeuvres);
    thermal_take(&drive->thermal, &tuning->thermal);
    link_take(&drive->link, &tuning->link);
    drive_limit(drive, false);
    sequence_take(&drive->sequence, &tuning->sequence);
    encoder_watch_take(&drive->encoder_watch, &tuning->encoder_watch);
    motion_watch_take(&drive->motion_watch, &tuning->motion_watch);
    oscillation_watch_take(&drive->oscillation_watch, &tuning->oscillation_watch);
    current_watch_take(&drive->current_watch, &tuning->current_watch);
    drive->offered = 0u;
}

void drive_init(drive_t *drive, const params_t *params)
{
    params_error_t why;
    CHECK(params_check(params, &why));
    memset(drive, 0, sizeof *drive);
    const believed_t believed = params_believed(params);
    drive_prepare(&drive->offer, params, &believed);
    const drive_tuning_t *tuning = &drive->offer;
    measure_init(&drive->measure, &tuning->measure);
    guard_init(&drive->guard, &tuning->guard);
    sequence_init(&drive->sequence, &tuning->sequence);
    inverter_init(&drive->inverter, &tuning->inverter);
    doubt_init(&drive->doubt, &tuning->doubt);
    current_control_init(&drive->current_control, &tuning->current_control);
    manoeuvres_init(&drive->manoeuvres, &tuning->manoeuvres);
    offset_trim_init(&drive->offset_trim, &tuning->offset_trim);
    inductance_init(&drive->inductance, &tuning->inductance);
    inertia_init(&drive->inertia, &tuning->inertia);
    encoder_watch_init(&drive->encoder_watch, &tuning->encoder_watch);
    motion_watch_init(&drive->motion_watch, &tuning->motion_watch);
    oscillation_watch_init(&drive->oscillation_watch, &tuning->oscillation_watch);
    thermal_init(&drive->thermal, &tuning->thermal);
    link_init(&drive->link, &tuning->link);
    drive_take(drive, 0u);
    chosen_reset(&drive->estimator, drive->encoder_position, drive->measure.measured.current);
    requests_defaults(&drive->requests);
    capture_tuning_t history;
    CHECK(capture_prepare(&signals_history, &signals_table, &history) == (uint32_t)CAPTURE_GOOD);
    capture_init(&drive->capture, &history);
}

void drive_offer(drive_t *drive)
{
    drive->offered = 1u;
}

void drive_withdraw(drive_t *drive)
{
    drive->offered = 0u;
}

learnt_t drive_learnt(const drive_t *drive)
{
    return (learnt_t){
        .resistance = drive->inductance.resistance,
        .inductance_q = drive->inductance.learnt,
        .inertia = drive->inertia.learnt,
    };
}

void drive_request(drive_t *drive, const requests_t *next)
{
    drive->requests = *next;
}

/* Does the EMF of a catch come from a rotor? Noise has a length, but no mean in a frame that turns, and no
 * direction. A rotor whose EMF is far beyond the link would have fed it before the gates came on. What has
 * been lost is no witness. */
static bool is_caught(const drive_t *drive)
{
    const catch_t *catching = &drive->manoeuvres.catching;
    const float least = CONFIRMED_LEAST * catching->length;
    const float most = CONFIRMED_BEYOND * FRAMES_ONE_OVER_SQRT_3 * drive->measure.measured.u_dc;
    const ab_t mean = catching->emf;
    return drive->manoeuvres.now == (int32_t)MANOEUVRE_CATCH &&
           mean.alpha * mean.alpha + mean.beta * mean.beta >= least * least &&
           !bounds_within(catching->cross, catching->cross_min) && catching->length <= most;
}

/* Does the EMF confirm the speed? A loop that tracks the rotor has it on its q axis, with its length. The
 * encoder needs no confirmation. */
static bool is_confirmed(const drive_t *drive)
{
    const manoeuvres_t *m = &drive->manoeuvres;
    if (m->sensorless == 0u) {
        return true;
    }
    if (m->tracking == 0u) {
        return is_caught(drive);
    }
    return m->lock.projection >= CONFIRMED_LEAST * m->lock.expected &&
           m->lock.projection <= CONFIRMED_MOST * m->lock.expected;
}

/* The speed of a catch is the EMF's length over psi_f: may a psi_f that is believed too small make it one
 * beyond the trip? A loop that tracks counts turns instead. */
static bool is_by_length(const drive_t *drive)
{
    const manoeuvres_t *m = &drive->manoeuvres;
    const float least = CONFIRMED_LEAST * drive->omega_m;
    return m->sensorless != 0u && m->tracking == 0u &&
           bounds_within(least, drive->guard.tuning.limit[FAULT_LIMIT_OVERSPEED]);
}

/* A fault that speaks of the shaft's speed, where only the estimate has one, names the estimate. */
static void name_estimate(drive_t *drive)
{
    sequence_t *sequence = &drive->sequence;
    const bool overspeed = sequence->fault_reason == (int32_t)REASON_OVERSPEED;
    const bool of_speed = overspeed || sequence->fault_reason == (int32_t)REASON_ROTOR_TOO_FAST;
    if (of_speed && (!is_confirmed(drive) || (overspeed && is_by_length(drive)))) {
        sequence->fault_reason = (int32_t)REASON_ESTIMATE_ASTRAY;
    }
}

void drive_note_fault(drive_t *drive)
{
    name_estimate(drive);
    measure_begin_calibration(&drive->measure);
    drive->fault = (drive_fault_t){
        .reason = drive->sequence.fault_reason,
        .period = drive->period,
        .manoeuvre = drive->manoeuvres.now,
        .i_a = drive->measure.measured.current_abc.a,
        .i_b = drive->measure.measured.current_abc.b,
        .u_dc = drive->measure.measured.u_dc,
        .theta_e = drive->rotor.theta_e,
        .omega_e = drive->rotor.omega_e,
    };
    drive->log.faults[drive->log.count % DRIVE_FAULT_LOG] = drive->fault;
    drive->log.count++;
    capture_trigger(&drive->capture, drive->period);
}

void drive_stop(drive_t *drive, int32_t reason)
{
    sequence_fault(&drive->sequence, reason);
    drive_note_fault(drive);
}

void drive_trip(drive_t *drive)
{
    if (drive_bridge_on(drive)) {
        drive_stop(drive, REASON_MODULE_FAULT);
    }
}
