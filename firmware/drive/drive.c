#include "drive/drive.h"

#include <string.h>

#include "drive/reasons.h"
#include "drive/signals.h"
#include "math/check.h"

/* ---- the tasks ---- */

void drive_show_fault(drive_t *drive, const drive_fault_t *fault)
{
    drive->state = (int32_t)DRIVE_FAULT;
    drive->fault_reason = fault->reason;
    drive->fault = *fault;
    capture_trigger(&drive->capture, fault->period);
}

/* The state machine as the medium task has left it; a fault that it has latched goes into the log. */
static void show(drive_t *drive)
{
    const medium_t *medium = &drive->medium;
    if (medium->faults != drive->log.count) {
        drive->log.faults[drive->log.count % DRIVE_FAULT_LOG] = medium->fault;
        drive->log.count = medium->faults;
        if (drive->state != (int32_t)DRIVE_FAULT) {
            drive_show_fault(drive, &medium->fault);
        }
        drive->fault = medium->fault;
    }
    drive->state = medium->sequence.state;
    drive->fault_reason = medium->sequence.fault_reason;
}

/* The bridge has been opened: that is a fault, which the medium task latches with this window. */
static void show_stop(drive_t *drive)
{
    drive_fault_t fault = drive->fast.stop;
    fault.manoeuvre = drive->medium.manoeuvres.now;
    if (drive->state != (int32_t)DRIVE_FAULT) {
        drive_show_fault(drive, &fault);
    }
}

static void medium(drive_t *drive)
{
    const bool was_fault = drive->medium.sequence.state == (int32_t)DRIVE_FAULT;
    medium_step(&drive->medium, &drive->window, &drive->requests);
    show(drive);
    if (!was_fault && drive->state == (int32_t)DRIVE_FAULT) {
        drive->fast.open = 1u; /* one word, for which no setpoint is waited */
    }
    if (was_fault && drive->state != (int32_t)DRIVE_FAULT) {
        capture_reset(&drive->capture);
    }
}

static void take(drive_t *drive, uint32_t encoder_count)
{
    medium_set_tuning(&drive->medium, &drive->offer.medium);
    const setpoint_t *newest = &drive->medium.setpoint;
    setpoint_set_models(&drive->next, newest);
    setpoint_set_models(&drive->fast.setpoint, newest);
    fast_set_tuning(&drive->fast, &drive->offer.fast, encoder_count);
    drive->offered = 0u;
}

void drive_step(drive_t *drive, const drive_samples_t *samples, drive_command_t *command)
{
    if (drive->offered != 0u) {
        take(drive, samples->encoder);
    }
    if (drive->fast.sum.periods == 0u) {
        fast_take(&drive->fast, &drive->next);
    }
    fast_step(&drive->fast, samples, command);
    if (drive->fast.stop.reason != (int32_t)REASON_NONE) {
        show_stop(drive);
    }
    if (drive->fast.sum.periods == DRIVE_WINDOW) {
        drive->next = drive->medium.setpoint;
        fast_close(&drive->fast, &drive->window);
        medium(drive);
        if (DRIVE_LATENCY == 0u) {
            drive->next = drive->medium.setpoint;
        }
    }
    capture_step(&drive->capture, drive, drive->fast.period);
}

/* ---- from outside ---- */

void drive_init(drive_t *drive, const params_t *params)
{
    params_error_t why;
    CHECK(params_check(params, &why));
    memset(drive, 0, sizeof *drive);
    const believed_t believed = params_believed(params);
    drive_prepare(&drive->offer, params, &believed);
    medium_init(&drive->medium, &drive->offer.medium);
    drive->next = drive->medium.setpoint;
    fast_init(&drive->fast, &drive->offer.fast, &drive->next);
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
        .resistance = drive->medium.inductance.resistance,
        .inductance_q = drive->medium.inductance.learnt,
        .inertia = drive->medium.inertia.learnt,
    };
}

void drive_request(drive_t *drive, const requests_t *next)
{
    drive->requests = *next;
}

void drive_stop(drive_t *drive, int32_t reason)
{
    fast_stop(&drive->fast, reason);
    medium_stop(&drive->medium, &drive->window, drive->fast.stop);
    drive->fast.stop.reason = (int32_t)REASON_NONE;
    show(drive);
}

void drive_trip(drive_t *drive)
{
    if (drive_bridge_on(drive)) {
        fast_stop(&drive->fast, REASON_MODULE_FAULT);
        show_stop(drive);
    }
}
