/* The drive: a fast task every PWM period, a medium task once in a window of DRIVE_WINDOW of them. Pure: no
 * registers, no globals.
 *
 *     samples --> fast (fast/fast.h): measure, estimator, frame, current control, duties; trips
 *                   |  window_t                                   ^
 *                   v                                             |  setpoint_t
 *                 medium (medium/medium.h): learn, watch, guard, sequence, manoeuvre
 *
 * Two structs go from the one to the other and nothing else: the window, closed at its last period, and the
 * setpoint that was made of it, which acts from the first period of the window after the next on, whenever it
 * was ready.
 *
 * Timing (docs/theory.md, 2): the step of period k gets the currents and the encoder at t_k; the duties it
 * returns act on [t_{k+1}, t_{k+2}). The dq voltage is therefore turned into the stationary frame at theta_e
 * + 1.5 T_s omega_e of the frame in force, and the estimator gets the voltage that the duties of two steps
 * ago made (fast/inverter/inverter.h).
 *
 * Position: the encoder or the estimator, as position_source says. With the encoder the estimator runs beside
 * it from the encoder's angle; without, nothing of the encoder is used, and a manoeuvre brings the rotor to
 * where its EMF can be tracked (medium/manoeuvre/manoeuvres.h). Control turns with the frame that the
 * setpoint names.
 *
 * Parameters change by a flip: of two tunings the one is in force, and the background prepares a new set in
 * the other and offers it; at the end of a window the fast task turns one index, and what was in force is
 * idle. */
#ifndef DRIVE_DRIVE_H
#define DRIVE_DRIVE_H

#include <stdbool.h>
#include <stdint.h>

#include "contract/capture.h"
#include "fast/fast.h"
#include "medium/medium.h"
#include "settings/requests.h"
#include "settings/tuning.h"

/* The last faults, through resets. */
#define FAULT_LOG_LENGTH 16u
typedef struct {
    uint32_t count;                         /* [-] since power-on */
    drive_fault_t faults[FAULT_LOG_LENGTH]; /* number n from 0 in n mod FAULT_LOG_LENGTH */
} drive_fault_log_t;

typedef struct {
    fast_t fast;
    medium_t medium;

    /* what goes from the one to the other, beside the setpoint, which is the medium task's */
    window_t window;         /* the newest that is closed; the medium task reads it until it is done */
    uint32_t handed;         /* [windows] closed and handed over, by the fast task */
    uint32_t done;           /* [windows] whose setpoint is ready, by the medium task */
    setpoint_t setpoints[2]; /* what the medium task has made: the one in force, and the next */
    uint32_t acting;         /* [-] index of the one in force, by the fast task */
    int32_t opens; /* [-] reason_t by which the medium task opens the bridge before its setpoint acts */

    /* what is shown of the state machine: as the medium task has left it, from where its setpoint acts, and
     * at once what has opened the bridge */
    int32_t state;        /* [-] drive_state_t */
    int32_t manoeuvre;    /* [-] manoeuvre_t whose setpoint acts */
    int32_t fault_reason; /* [-] reason_t of the latched fault; REASON_NONE: there is none */
    drive_fault_t fault;  /* the last one */

    /* from outside */
    requests_t requests;
    uint32_t offered;  /* [-] 1: the background offers a tuning, which is taken with the end of the window */
    uint32_t taken;    /* [-] 1: the medium task has not seen the tuning in force yet */
    uint32_t in_force; /* [-] index of the tuning in force, by the fast task */
    drive_tuning_t tunings[2];

    drive_fault_log_t log;
    capture_t capture; /* unless armed for something else: the rows of signals_history; a fault holds it, its
                          own period is the newest; a reset empties it */
} drive_t;

/* All state zero, in not ready, requests off. The set must be good (checked). */
void drive_init(drive_t *drive, const params_t *params);

/* The tuning that is not in force: while none is offered it is the background's to write. */
static inline drive_tuning_t *drive_idle_tuning(drive_t *drive)
{
    return &drive->tunings[drive->in_force ^ 1u];
}

/* Between two periods: the tuning that the background has prepared in drive_idle_tuning() is taken with the
 * end of the window under way. Control states are kept, so a running drive goes on smoothly. While one is
 * offered it must not be written: drive_withdraw() first. */
void drive_offer(drive_t *drive);
void drive_withdraw(drive_t *drive);

/* What it has learnt so far, between two periods. */
learnt_t drive_learnt(const drive_t *drive);

/* The background has come round, between two periods; `reported`: what it has found. */
static inline void drive_heartbeat(drive_t *drive, uint32_t reported)
{
    drive->medium.background.unattended = 1u;
    drive->medium.background.reported = reported;
}

/* Take over a set of requests between two periods; it must be good (requests_check). */
void drive_request(drive_t *drive, const requests_t *next);

/* The fast task: one period, in the interrupt of the sample. true: a window is closed, and the medium task
 * has to run, which this interrupt may interrupt. */
bool drive_step(drive_t *drive, const drive_samples_t *samples, drive_command_t *command);

/* The medium task: makes the setpoint of the window that was closed last. */
void drive_medium_step(drive_t *drive);

/* From the trip interrupt: the hardware has shut the gates. The bridge stays off, and the next window leads
 * to fault, if it was on; a power module that pulls its line while the gates are off anyway (its supply comes
 * up) is no fault. */
void drive_trip(drive_t *drive);

/* Latch a fault from outside the step: the board did not come up. */
void drive_stop(drive_t *drive, int32_t reason);

/* Are the gates on, coming on, or not off yet? */
static inline bool drive_bridge_on(const drive_t *drive)
{
    return (drive->state >= (int32_t)DRIVE_SWITCHED_ON && drive->state <= (int32_t)DRIVE_QUICK_STOP) ||
           (fast_bridge_on(&drive->fast) && drive->fast.bridge.open == 0u);
}

#endif
