/* The state machine, states by their DS-402 names: which of them the drive is in, what the gates shall do,
 * and why a wish is not obeyed. One transition at most per window.
 *
 * not ready: current offsets are being measured, gates off.
 *
 * ready: gates off, waiting for `enable` = on.
 *
 * switched on: control preset to the turning rotor, gates coming on; then for as long as the board's gate
 * supplies need it the lower switches stay on.
 *
 * operation enabled: the motor follows the references.
 *
 * quick stop: speed reference zero until standstill, then ready; or, where a fault stops the motor, fault.
 *
 * fault: gates off until fault_reset, then not ready.
 *
 * `enable` = on means run: again after a quick stop too, once that has ended. A reset alone starts nothing:
 * if `enable` is on then, it has to go to off once (EN 60204-1, 9.2). Where it is on and nothing runs, a
 * refusal says why, in every state. */
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

/* What the rest of the drive shall do now. */
#define SEQUENCE_ON    UINT32_C(1) /* the bridge */
#define SEQUENCE_BEGIN UINT32_C(2) /* control, manoeuvre and estimator start anew */

/* Mechanical speed below which the rotor stands: a quick stop ends [rad/s]. */
#define SEQUENCE_STANDSTILL 2.0f

typedef struct {
    float dc_undervoltage; /* [V] below it the bridge stays off */
    uint32_t stop_windows; /* [windows] that a stop for a fault may take until the bridge opens anyway */
    uint32_t retries;      /* [-] how often a fault of the power module resets itself */
} sequence_tuning_t;

typedef struct {
    sequence_tuning_t tuning;
    int32_t state;         /* [-] drive_state_t */
    int32_t refusal;       /* [-] reason_t: why a wish is not obeyed now */
    int32_t fault_reason;  /* [-] reason_t of the latched fault; REASON_NONE: none since start or reset */
    int32_t stop_reason;   /* [-] reason_t of the fault for which the motor is being stopped; REASON_NONE */
    int32_t fault_present; /* [-] reason_t: why the last reset was refused; REASON_NONE: none was */
    fault_set_t faults_later; /* beside its own, what came after it */
    uint32_t stopping;        /* [windows] of the stop for a fault so far */
    uint32_t retried;         /* [-] resets by itself since `enable` was off, or since a quiet minute */
    uint32_t retry_windows;   /* [windows] since the fault, or of operation */
    uint32_t quiet_windows;   /* [windows] without a fault or its line, up to what a reset asks for */
    int32_t fault_reset_seen; /* [-] last value of the request, for its edge */
    uint32_t held;            /* [-] 1: `enable` was on over a reset; it must go off before the next start */
} sequence_t;

/* The limits of this set. */
sequence_tuning_t sequence_prepare(const params_t *params);

/* With these limits: not ready, nothing wished for yet. */
void sequence_init(sequence_t *sequence, const sequence_tuning_t *tuning);

/* New limits; the state stays. */
static inline void sequence_take(sequence_t *sequence, const sequence_tuning_t *tuning)
{
    sequence->tuning = *tuning;
}

/* What the machine decides by, of one window. */
typedef struct {
    const requests_t *requests;
    const measured_t *measured;
    fault_set_t faults;        /* of the fault table, that open the bridge */
    fault_set_t stops;         /* that ask for a stop */
    bool standing;             /* the rotor is known to stand */
    bridge_t bridge;           /* as the last sample shows it */
    calibration_t calibration; /* while not ready, and what is known of the offsets while ready */
} sequence_input_t;

/* The state from here on. Returns what follows from it: SEQUENCE_... */
uint32_t sequence_step(sequence_t *sequence, const sequence_input_t *input);

/* The bridge opens without a fault: ready, from where `enable` brings it on again when nothing refuses. */
void sequence_coast(sequence_t *sequence);

/* Into fault at once, with this reason. */
void sequence_fault(sequence_t *sequence, int32_t reason);

/* Are the gates on, or coming on? */
static inline bool sequence_bridge_on(const sequence_t *sequence)
{
    return sequence->state >= (int32_t)DRIVE_SWITCHED_ON && sequence->state <= (int32_t)DRIVE_QUICK_STOP;
}

#endif
