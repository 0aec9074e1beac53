/* The state machine, states by their DS-402 names: which of them the drive is in, what the gates shall do,
 * and why a wish is not obeyed. One transition at most per period.
 *
 *   not ready           current offsets are being measured, gates off
 *   ready               gates off, waiting for `enable` = on
 *   switched on         two periods: control preset to the turning rotor, gates coming on
 *   operation enabled   the motor follows the references
 *   quick stop          speed reference zero until standstill, then ready
 *   fault               gates off until fault_reset, then not ready */
#ifndef DRIVE_SEQUENCE_H
#define DRIVE_SEQUENCE_H

#include <stdbool.h>
#include <stdint.h>

#include "drive/measure.h"
#include "drive/requests.h"

typedef enum {
    DRIVE_NOT_READY,
    DRIVE_READY,
    DRIVE_SWITCHED_ON,
    DRIVE_OPERATION_ENABLED,
    DRIVE_QUICK_STOP,
    DRIVE_FAULT
} drive_state_t;
#define DRIVE_STATE_NAMES "not_ready|ready|switched_on|operation_enabled|quick_stop|fault"

typedef enum {
    GATES_KEEP, /* leave the trip zone as it is */
    GATES_ON,   /* release the trip, this once */
    GATES_OFF   /* trip by software */
} drive_gates_t;

/* What the rest of the drive shall do now: drive_gates_t, and these bits. */
#define SEQUENCE_GATES  UINT32_C(3) /* drive_gates_t */
#define SEQUENCE_PRESET UINT32_C(4) /* control and manoeuvre start anew */
#define SEQUENCE_TRACK  UINT32_C(8) /* the estimator starts */

/* Mechanical speed below which the rotor stands: a quick stop ends [rad/s]. */
#define SEQUENCE_STANDSTILL 2.0f

typedef struct {
    float dc_undervoltage; /* [V] below it the bridge stays off */
} sequence_tuning_t;

typedef struct {
    sequence_tuning_t tuning;
    int32_t state;            /* [-] drive_state_t */
    int32_t refusal;          /* [-] reason_t: why a wish is not obeyed now */
    int32_t fault_reason;     /* [-] reason_t of the latched fault; REASON_NONE: none since start or reset */
    uint32_t faults_later;    /* [-] bits of the fault table, beside its own, that came after it */
    uint32_t coming_on;       /* [periods] in switched on */
    uint32_t quiet_periods;   /* [periods] without a fault or its line, up to what a reset asks for */
    int32_t fault_reset_seen; /* [-] last value of the request, for its edge */
    uint32_t stopped;         /* [-] 1: quick stop is done; `enable` must go off before the next start */
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

/* The state of this period, from what is asked for, what was measured, the bits of the fault table that open
 * the bridge, whether the rotor is known to stand and, while not ready, the calibration. Returns what follows
 * from it: SEQUENCE_... */
uint32_t sequence_step(sequence_t *sequence, const requests_t *requests, const measured_t *measured,
                       uint32_t faults, bool standing, calibration_t calibration);

/* Into fault at once, with this reason. */
void sequence_fault(sequence_t *sequence, int32_t reason);

/* Are the gates on, or coming on? */
static inline bool sequence_bridge_on(const sequence_t *sequence)
{
    return sequence->state >= (int32_t)DRIVE_SWITCHED_ON && sequence->state <= (int32_t)DRIVE_QUICK_STOP;
}

#endif
