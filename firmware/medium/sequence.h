/* The state machine, with the states of DS-402: it defines the present state, the gates, and the reason why a
 * request is refused. At most one transition per window.
 *
 * not ready: current offsets are being measured, gates off.
 *
 * ready: gates off, waiting for `enable` = on.
 *
 * switched on: control preset to the turning rotor, gates being switched on; then the lower switches stay on
 * for as long as the board's gate supplies need it.
 *
 * operation enabled: the motor follows the references.
 *
 * quick stop: speed reference zero until standstill, then ready; or, if a fault stops the motor, fault.
 *
 * With a holding brake `enable` = off stops a motor in operation like a quick stop. When a stop has ended,
 * the brake is set, and the motor holds the shaft until the brake does. Only then the bridge opens.
 *
 * fault: gates off until fault_reset, then not ready.
 *
 * The enable input of the board is a second condition in addition to `enable`: without it the bridge does not
 * come on. If it is lost, a running motor is braked for at most SEQUENCE_INPUT_STOP, or until the input is
 * lost for a second time; then the bridge opens, and the fault is latched. An input that comes back starts
 * nothing: `enable` has to go to off once.
 *
 * `enable` = on means run, also after a quick stop has ended. A reset alone starts nothing: if `enable` is on
 * then, it has to go to off once (EN 60204-1, 9.2). While `enable` is on and the motor does not run, a
 * refusal gives the reason, in every state. */
#ifndef MEDIUM_SEQUENCE_H
#define MEDIUM_SEQUENCE_H

#include <stdbool.h>
#include <stdint.h>

#include "fast/measure.h"
#include "fast/window.h"
#include "guard/fault_set.h"
#include "settings/requests.h"

typedef enum {
    DRIVE_NOT_READY,
    DRIVE_READY,
    DRIVE_SWITCHED_ON,
    DRIVE_OPERATION_ENABLED,
    DRIVE_QUICK_STOP,
    DRIVE_FAULT
} drive_state_t;
#define DRIVE_STATE_NAMES "not_ready|ready|switched_on|operation_enabled|quick_stop|fault"

/* The orders to the other modules. */
#define SEQUENCE_ON    UINT32_C(1) /* the bridge */
#define SEQUENCE_BEGIN UINT32_C(2) /* control, manoeuvre and estimator restart */

/* Longest stop after a loss of the enable input [s]. */
#define SEQUENCE_INPUT_STOP 50e-3f

/* Mechanical speed below which the rotor stands [rad/s]. A quick stop ends there, or for a fast motor at a
 * share of overspeed_trip: the speed control of a light rotor takes long to remove the last of its speed. */
#define SEQUENCE_STANDSTILL       2.0f
#define SEQUENCE_STANDSTILL_SHARE 2.5e-3f /* [-] */

typedef struct {
    float dc_undervoltage; /* [V] below it the bridge stays off */
    float standstill;      /* [rad/s] mechanical speed at which a quick stop ends */
    uint32_t stop_windows; /* [windows] longest stop for a fault; then the bridge opens */
    uint32_t retries;      /* [-] number of automatic resets of a fault of the power module */
    uint32_t brakes;       /* [-] 1: there is a holding brake */
    uint32_t debounce;     /* [windows] for which the enable input must have its new level */
} sequence_tuning_t;

typedef struct {
    sequence_tuning_t tuning;
    int32_t state;         /* [-] drive_state_t */
    int32_t refusal;       /* [-] reason_t: why a request is refused now */
    int32_t fault_reason;  /* [-] reason_t of the latched fault; REASON_NONE: none since start or reset */
    int32_t stop_reason;   /* [-] reason_t of the fault for which the motor is being stopped; REASON_NONE */
    int32_t fault_present; /* [-] reason_t: why the last reset was refused; REASON_NONE: none was */
    fault_set_t faults_later; /* faults that occurred after the latched one */
    uint32_t setting;         /* [-] 1: the stop has ended, and the holding brake is being set */
    uint32_t stopping;        /* [windows] of the present stop for a fault */
    uint32_t retried; /* [-] automatic resets since `enable` was off, or since a minute without faults */
    uint32_t retry_windows;   /* [windows] since the fault, or of operation */
    uint32_t quiet_windows;   /* [windows] without a fault or its line, up to the number that a reset needs */
    int32_t fault_reset_seen; /* [-] last value of the request, for its edge */
    uint32_t held;       /* [-] 1: `enable` was on during a reset, or without the enable input; it must go off
                            before the next start */
    uint32_t input_lost; /* [-] 1: the enable input is not active, debounced */
    uint32_t input_differs; /* [windows] for which its level has differed from the debounced one */
    uint32_t input_losses;  /* [-] since the bridge came on */
    uint32_t input_stop;    /* [windows] since its first loss with the bridge on */
} sequence_t;

/* The limits of this set. */
sequence_tuning_t sequence_prepare(const params_t *params);

/* Takes these limits: not ready, no request yet. */
void sequence_init(sequence_t *sequence, const sequence_tuning_t *tuning);

/* Takes over new limits; the state is kept. */
static inline void sequence_take(sequence_t *sequence, const sequence_tuning_t *tuning)
{
    sequence->tuning = *tuning;
}

/* The inputs of the state machine for one window. */
typedef struct {
    const requests_t *requests;
    const measured_t *measured;
    fault_set_t faults;        /* rows of the fault table that open the bridge */
    fault_set_t stops;         /* rows that require a stop */
    bool standing;             /* the rotor is known to be at standstill */
    bool overspeed;            /* the encoder shows a speed near or above overspeed_trip */
    bool brake_set;            /* the holding brake is set; true without one */
    bridge_t bridge;           /* state in the last sample */
    calibration_t calibration; /* result while not ready, state of the offsets while ready */
} sequence_input_t;

/* One step of the state machine. Returns the orders: SEQUENCE_... */
uint32_t sequence_step(sequence_t *sequence, const sequence_input_t *input);

/* The bridge opens without a fault: state ready, from which `enable` switches
 * it on again if nothing refuses. */
void sequence_coast(sequence_t *sequence);

/* Changes to fault at once, with this reason. */
void sequence_fault(sequence_t *sequence, int32_t reason);

/* True if the gates are on, or being switched on. */
static inline bool sequence_bridge_on(const sequence_t *sequence)
{
    return sequence->state >= (int32_t)DRIVE_SWITCHED_ON && sequence->state <= (int32_t)DRIVE_QUICK_STOP;
}

#endif
