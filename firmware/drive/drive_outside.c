#include "drive/drive.h"

#include <string.h>

#include "drive/reasons.h"
#include "math/check.h"

void drive_take(drive_t *drive, uint32_t encoder_count)
{
    const drive_tuning_t *tuning = &drive->offer;
    measure_take(&drive->measure, &tuning->measure);
    guard_take(&drive->guard, &tuning->guard);
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
    drive->doubt.tuning = tuning->doubt;
    current_control_take(&drive->current_control, &tuning->current_control);
    manoeuvres_take(&drive->manoeuvres, &tuning->manoeuvres);
    sequence_take(&drive->sequence, &tuning->sequence);
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
    drive_take(drive, 0u);
    chosen_reset(&drive->estimator, drive->encoder_position, drive->measure.measured.current);
    requests_defaults(&drive->requests);
    tap_history_clear(&drive->history);
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
        .inductance_q = drive->inductance.learnt,
        .inertia = drive->inertia.learnt,
        .inertia_known = inertia_is_known(&drive->inertia) ? 1u : 0u,
    };
}

void drive_request(drive_t *drive, const requests_t *next)
{
    drive->requests = *next;
}

void drive_note_fault(drive_t *drive)
{
    measure_begin_calibration(&drive->measure);
    drive->fault = (drive_fault_t){
        .period = drive->period,
        .i_a = drive->measure.measured.current_abc.a,
        .i_b = drive->measure.measured.current_abc.b,
        .u_dc = drive->measure.measured.u_dc,
        .theta_e = drive->rotor.theta_e,
        .omega_e = drive->rotor.omega_e,
    };
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
