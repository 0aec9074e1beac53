#include "drive/drive.h"

#include <string.h>

#include "math/check.h"
#include "settings/reasons.h"
#include "settings/signals.h"

/* ---- display of the state ---- */

static void show_fault(drive_t *drive, const drive_fault_t *fault)
{
    if (drive->state != (int32_t)DRIVE_FAULT) {
        drive->state = (int32_t)DRIVE_FAULT;
        capture_trigger(&drive->capture, fault->period);
    }
    drive->fault_reason = fault->reason;
    drive->fault = *fault;
}

/* The fast task has opened the bridge, and the medium task latches this fault, if it is the first one. */
static void show_stop(drive_t *drive)
{
    drive_fault_t fault = drive->fast.report.window.stop;
    fault.manoeuvre = drive->manoeuvre;
    show_fault(drive, &fault);
}

/* Displays the state machine of the medium task, and logs a fault that it has latched. */
static void show(drive_t *drive)
{
    const medium_t *medium = &drive->medium;
    drive->manoeuvre = medium->manoeuvres.now;
    if (medium->faults != drive->log.count) {
        drive->log.faults[drive->log.count % FAULT_LOG_LENGTH] = medium->fault;
        drive->log.count = medium->faults;
        show_fault(drive, &medium->fault);
    }
    if (drive->fast.bridge.open != 0u && medium->sequence.state != (int32_t)DRIVE_FAULT) {
        return; /* the fault is in the window that has just been closed */
    }
    if (drive->state == (int32_t)DRIVE_FAULT && medium->sequence.state != (int32_t)DRIVE_FAULT) {
        capture_reset(&drive->capture);
    }
    drive->state = medium->sequence.state;
    drive->fault_reason = medium->sequence.fault_reason;
}

/* ---- the tasks ---- */

static fast_orders_t orders_of(const drive_t *drive)
{
    return (fast_orders_t){&drive->tunings[drive->in_force].fast, &drive->setpoints[drive->acting]};
}

/* The end of a window, at which a medium task that is in time does not run. The setpoint of the previous
 * window acts from the next period on, and the medium task begins with the tuning of the fast task. Without
 * a setpoint the last one continues to act, and the medium task keeps its window. true: it has a new one. */
static bool turn_window(drive_t *drive, const setpoint_t *before)
{
    if (drive->done != drive->handed) {
        fast_miss(&drive->fast);
        return false;
    }
    fast_close(&drive->fast, before, &drive->window);
    drive->acting ^= 1u;
    drive->medium_in_force = drive->in_force;
    drive->due = drive->offered;
    show(drive);
    drive->opens = (int32_t)REASON_NONE;
    fast_turn(&drive->fast, &drive->setpoints[drive->acting], before);
    drive->handed++;
    return true;
}

/* The fast task takes over an offered tuning; the medium task follows with its next window. */
static void turn_tuning(drive_t *drive)
{
    drive->due = 0u;
    if (drive->offered != 0u) {
        drive->in_force ^= 1u;
        drive->offered = 0u;
        fast_take_tuning(&drive->fast, orders_of(drive), &drive_idle_tuning(drive)->fast);
    }
}

bool drive_step(drive_t *drive, const drive_samples_t *samples, drive_command_t *command)
{
    if (drive->due != 0u && drive->fast.sum.periods == 1u) {
        turn_tuning(drive);
    }
    const fast_orders_t orders = orders_of(drive);
    fast_step(&drive->fast, orders, samples, drive->opens, command);
    if (drive->fast.report.window.stop.reason != (int32_t)REASON_NONE &&
        drive->state != (int32_t)DRIVE_FAULT) {
        show_stop(drive);
    } else if (drive->opens != (int32_t)REASON_NONE) {
        show_fault(drive, &drive->medium.fault);
    }
    const bool due = drive->fast.sum.periods >= DRIVE_WINDOW && turn_window(drive, orders.setpoint);
    if (drive->record.on != 0u) { /* if a window is handed over now, the medium task was ready */
        record_step(&drive->record, samples->codes, due || drive->done == drive->handed, command);
    }
    capture_step(&drive->capture, drive, drive->fast.period);
    return due;
}

void drive_medium_step(drive_t *drive)
{
    const bool was_fault = drive->medium.sequence.state == (int32_t)DRIVE_FAULT;
    const medium_tuning_t *tuning = &drive->tunings[drive->medium_in_force].medium;
    if (drive->medium_has != drive->medium_in_force) {
        medium_set_tuning(&drive->medium, tuning);
        drive->medium_has = drive->medium_in_force;
    }
    medium_step(&drive->medium, tuning, &drive->window, &drive->requests);
    drive->setpoints[drive->acting ^ 1u] = drive->medium.setpoint;
    if (!was_fault && drive->medium.sequence.state == (int32_t)DRIVE_FAULT) {
        drive->opens = drive->medium.sequence.fault_reason;
    }
    drive->done = drive->handed;
}

void drive_medium_took(drive_t *drive, uint32_t cycles)
{
    drive_took(&drive->medium_took, cycles);
}

/* ---- interface ---- */

/* Both tasks start with the active tuning. */
static void start(drive_t *drive)
{
    drive->medium_in_force = drive->in_force;
    drive->medium_has = drive->in_force;
    medium_init(&drive->medium, &drive->tunings[drive->in_force].medium);
    drive->setpoints[0] = drive->medium.setpoint;
    drive->setpoints[1] = drive->medium.setpoint;
    fast_init(&drive->fast, orders_of(drive));
}

void drive_init(drive_t *drive, const params_t *params)
{
    params_error_t why;
    CHECK(params_check(params, &why));
    memset(drive, 0, sizeof *drive);
    const assumed_t assumed = params_configured(params);
    drive_prepare(&drive->tunings[0], params, &assumed);
    start(drive);
    requests_defaults(&drive->requests);
    capture_tuning_t history;
    CHECK(capture_prepare(&signals_history, &signals_table, &history) == (uint32_t)CAPTURE_GOOD);
    capture_init(&drive->capture, &history);
}

void drive_offer(drive_t *drive)
{
    if (drive->fast.period == 0u) { /* before the first period there is no end of a window */
        drive->in_force ^= 1u;
        start(drive);
    } else {
        drive->offered = 1u;
    }
}

void drive_withdraw(drive_t *drive)
{
    drive->offered = 0u;
}

learnt_t drive_learnt(const drive_t *drive)
{
    return medium_learnt(&drive->medium, measure_noise(&drive->fast.measure));
}

void drive_request(drive_t *drive, const requests_t *next)
{
    drive->requests = *next;
}

void drive_stop(drive_t *drive, int32_t reason)
{
    fast_stop(&drive->fast, reason);
    medium_stop(&drive->medium, &drive->window, drive->fast.report.window.stop);
    drive->fast.report.window.stop.reason = (int32_t)REASON_NONE;
    show(drive);
}

void drive_trip(drive_t *drive)
{
    drive->record.came |= RECORD_CAME_TRIP;
    if (drive_bridge_on(drive)) {
        fast_stop(&drive->fast, REASON_MODULE_FAULT);
        show_stop(drive);
    }
}
