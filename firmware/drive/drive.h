/* The drive: a fast task in every PWM period, a medium task once in a window of DRIVE_WINDOW periods. Pure:
 * no registers, no globals.
 *
 *     samples --> fast (fast/fast.h): measure, estimator, frame, current control, duties; trips
 *                   |  window_t                                   ^
 *                   v                                             |  setpoint_t
 *                 medium (medium/medium.h): learn, watch, guard, sequence, manoeuvre
 *
 * The tasks exchange two structs and no other data: the window, closed at its last period, and the setpoint
 * that was made of it. The setpoint acts from the first period of the window after the next on, independent
 * of the time at which it was ready.
 *
 * Timing (docs/theory.md, 2): the step of period k uses the currents and the encoder at t_k; the duties it
 * returns act in [t_{k+1}, t_{k+2}). The dq voltage is therefore transformed into the stationary frame at
 * theta_e + 1.5 T_s omega_e of the present frame, and the estimator receives the voltage from the duties of
 * two steps ago (fast/inverter/inverter.h).
 *
 * Position: the encoder or the estimator, as configured by position_source. With the encoder, the estimator
 * also runs, locked to the encoder's angle. Without it, nothing of the encoder is used, and a manoeuvre
 * accelerates the rotor to a speed where its EMF can be tracked (medium/manoeuvre/manoeuvres.h). Control uses
 * the frame that the setpoint names.
 *
 * Parameters change by a swap of two tunings: one is active, and the background prepares a new set in the
 * other and offers it. In the second period of the next window the fast task changes one index, the medium
 * task follows with its next window, and the previous tuning becomes idle. */
#ifndef DRIVE_DRIVE_H
#define DRIVE_DRIVE_H

#include <stdbool.h>
#include <stdint.h>

#include "contract/capture.h"
#include "drive/record.h"
#include "fast/fast.h"
#include "medium/medium.h"
#include "settings/requests.h"
#include "settings/tuning.h"

/* The last faults, kept through resets. */
#define FAULT_LOG_LENGTH 16u
typedef struct {
    uint32_t count;                         /* [-] since power-on */
    drive_fault_t faults[FAULT_LOG_LENGTH]; /* number n from 0 in n mod FAULT_LOG_LENGTH */
} drive_fault_log_t;

/* Execution times of a task, as the application measures them with the free-running timer. */
typedef struct {
    uint32_t last;    /* [CPU cycles] */
    uint32_t longest; /* [CPU cycles] since the start */
} drive_duration_t;

typedef struct {
    fast_t fast;
    medium_t medium;

    /* data between the tasks, in addition to the setpoint of the medium task */
    window_t window;          /* the newest closed one; the medium task reads it until it is done */
    setpoint_t setpoints[2];  /* of the medium task: the active one and the next */
    uint32_t handed;          /* [windows] closed and handed over, by the fast task */
    uint32_t done;            /* [windows] whose setpoint is ready, by the medium task */
    uint32_t acting;          /* [-] index of the active one, by the fast task */
    uint32_t medium_in_force; /* [-] index of the tuning of the medium task, by the fast task */
    uint32_t medium_has;      /* [-] the same, once the medium task has taken it over */
    int32_t opens; /* [-] reason_t by which the medium task opens the bridge before its setpoint acts */

    /* displayed state of the state machine: that of the medium task, from the time when its setpoint acts; a
     * reason that has opened the bridge is displayed at once */
    int32_t state;        /* [-] drive_state_t */
    int32_t manoeuvre;    /* [-] manoeuvre_t whose setpoint acts */
    int32_t fault_reason; /* [-] reason_t of the latched fault; REASON_NONE: no fault */
    drive_fault_t fault;  /* the last one */

    drive_duration_t fast_took;   /* the sample interrupt, from its entry until its writes */
    drive_duration_t medium_took; /* the medium task, with the interrupts during it */

    drive_record_t record; /* of the newest period, for a replay */

    /* inputs */
    requests_t requests;
    uint32_t offered;  /* [-] 1: the background offers a tuning */
    uint32_t due;      /* [-] 1: it offered one at the end of the last window */
    uint32_t in_force; /* [-] index of the active tuning, by the fast task */

    drive_tuning_t tunings[2]; /* all before this one is the state that a replay begins with */

    drive_fault_log_t log;
    capture_t capture; /* by default the rows of signals_history; a fault stops it, with the period of the
                          fault as the newest; a reset clears it */
} drive_t;

/* Clears all state: not ready, requests off. The set must be valid (checked). */
void drive_init(drive_t *drive, const params_t *params);

/* The idle tuning. The background may write it while no tuning is offered. */
static inline drive_tuning_t *drive_idle_tuning(drive_t *drive)
{
    return &drive->tunings[drive->in_force ^ 1u];
}

/* Called between two periods: the fast task takes over the tuning that the background has prepared in
 * drive_idle_tuning() in the second period of the next window, no matter in which period of the present one
 * it is offered, and the medium task with the window after it. The states of control are kept, so a running
 * drive continues without a step. An offered tuning must not be written: call drive_withdraw() first. */
void drive_offer(drive_t *drive);
void drive_withdraw(drive_t *drive);

/* The learnt values so far. Called between two periods. */
learnt_t drive_learnt(const drive_t *drive);

/* The background has completed a cycle. Called between two periods; `reported`: its results. */
static inline void drive_heartbeat(drive_t *drive, uint32_t reported)
{
    drive->medium.background.unattended = 1u;
    drive->record.came |= RECORD_CAME_BACKGROUND;
    drive->medium.background.reported = reported;
}

/* Takes over a set of requests between two periods; it must be valid (requests_check). */
void drive_request(drive_t *drive, const requests_t *next);

/* The fast task: one period, in the interrupt of the sample. true: a window is closed, and the medium task
 * has to run; this interrupt may interrupt the medium task. */
bool drive_step(drive_t *drive, const drive_samples_t *samples, drive_command_t *command);

/* The medium task: makes the setpoint of the window that was closed last. */
void drive_medium_step(drive_t *drive);

/* After a task: its duration [CPU cycles]. */
static inline void drive_took(drive_duration_t *duration, uint32_t cycles)
{
    duration->last = cycles;
    if (cycles > duration->longest) {
        duration->longest = cycles;
    }
}
void drive_medium_took(drive_t *drive, uint32_t cycles);

/* Called from the trip interrupt: the hardware has switched the gates off. The bridge stays off, and the next
 * window leads to the fault state if the bridge was on. If the gates were off already, an active fault line
 * of the power module is no fault, because its supply is rising. */
void drive_trip(drive_t *drive);

/* Latches a fault from outside the step, for example when the board did not start. */
void drive_stop(drive_t *drive, int32_t reason);

/* true: the gates are on, will come on, or are not off yet. */
static inline bool drive_bridge_on(const drive_t *drive)
{
    return (drive->state >= (int32_t)DRIVE_SWITCHED_ON && drive->state <= (int32_t)DRIVE_QUICK_STOP) ||
           (fast_bridge_on(&drive->fast) && drive->fast.bridge.open == 0u);
}

#endif
