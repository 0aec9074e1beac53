/* The record for a replay (`lagless replay`): with the parameter fault_record = replay, the memory of the
 * capture contains the raw samples of the last periods (drive/record.h), the changes that came from the
 * background, and two snapshots of the drive's state. A replay begins with a snapshot and runs the drive's
 * two tasks on the samples that follow it.
 *
 *     capture.slots   RECORDING_ROWS rows of RECORD_COLUMNS slots, the ring of the capture
 *                     RECORDING_EVENTS events: period, what, bits
 *                     2 snapshots: number of events so far, state, parameters, assumed values
 *
 * The state is everything in drive_t before the tunings, which follow from the parameters and the assumed
 * values. The background copies it while the interrupts run: the state of the medium task does not change
 * from the end of this task to the end of the window, and the rest of the state does not change from one
 * sample to the next. A copy during which the period has changed is repeated. The older snapshot is only
 * replaced when the newer one is old enough, so that whenever a fault comes, a complete snapshot of some
 * milliseconds before it exists, with all samples since then. */
#ifndef APP_RECORDING_H
#define APP_RECORDING_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "contract/capture.h"
#include "drive/drive.h"
#include "settings/params.h"

/* Every member of these structs has the size of a slot (tests/cli/test_replay.py), so that the slots have the
 * same content on the chip and on the host. */
#define RECORDING_STATE    ((uint32_t)(offsetof(drive_t, tunings) / sizeof(uint32_t)))
#define RECORDING_PARAMS   ((uint32_t)(sizeof(params_t) / sizeof(uint32_t)))
#define RECORDING_SNAPSHOT (1u + RECORDING_STATE + RECORDING_PARAMS + ASSUMED_SLOTS) /* [slots] */
#define RECORDING_EVENTS   UINT32_C(64)                                              /* newest kept */
#define RECORDING_EVENT    3u                                                        /* [slots] of one */
#define RECORDING_ROWS                                                                                       \
    ((CAPTURE_SLOTS - RECORDING_EVENT * RECORDING_EVENTS - 2u * RECORDING_SNAPSHOT) / RECORD_COLUMNS)
#define RECORDING_AFTER UINT32_C(16) /* [periods] recorded after the trigger */

/* Places in capture.slots. */
#define RECORDING_EVENTS_AT (RECORD_COLUMNS * RECORDING_ROWS)
#define RECORDING_SNAPSHOT_AT(n)                                                                             \
    (RECORDING_EVENTS_AT + RECORDING_EVENT * RECORDING_EVENTS + (n)*RECORDING_SNAPSHOT)

/* Subject of an event: the id of a parameter or a request that has these bits from now on, or one of these
 * constants. A parameter acts with the next offer. */
#define RECORDING_WITHDRAWN  UINT32_C(10000) /* the offered tuning, and the parameters for it */
#define RECORDING_OFFERED    UINT32_C(10001) /* a tuning of the parameters and assumed values */
#define RECORDING_REPORTED   UINT32_C(10002) /* the results of the background, GUARD_CORRUPT_... */
#define RECORDING_ASSUMED_AT UINT32_C(10010) /* and following: the assumed values, in their order */

/* What a client reads: a head, the rows from the oldest to the newest, events and snapshots. */
typedef enum {
    RECORDING_HEAD_FORMAT,  /* RECORDING_FORMAT */
    RECORDING_HEAD_SLOTS,   /* [slots] of all that can be read, this head included */
    RECORDING_HEAD_VERSION, /* APP_VERSION */
    RECORDING_HEAD_LAYOUT,  /* recording_layout() */
    RECORDING_HEAD_STATE,   /* [slots] */
    RECORDING_HEAD_PARAMS,  /* [slots] */
    RECORDING_HEAD_ROWS,    /* [periods] recorded */
    RECORDING_HEAD_NEWEST,  /* [periods] of the newest row */
    RECORDING_HEAD_AT,      /* [periods] of the trigger */
    RECORDING_HEAD_EVENTS,  /* [-] events so far */
    RECORDING_HEAD_WHOLE,   /* [-] bits: complete snapshots */
    RECORDING_HEAD_REASON,  /* [-] reason_t of the fault; REASON_NONE: another trigger */
    RECORDING_HEAD_PERIOD,  /* [periods] of the fault */
    RECORDING_HEAD_CARRIER, /* [ns] period */
    RECORDING_HEAD_BOARD,   /* and following: name, four characters a slot, the first in the low octet */
    RECORDING_HEAD = RECORDING_HEAD_BOARD + 6
} recording_head_t;
#define RECORDING_FORMAT UINT32_C(1)

typedef struct {
    uint32_t events;    /* [-] since the start */
    uint32_t next;      /* [-] snapshot that is replaced next */
    uint32_t whole[2];  /* [-] 1: the snapshot is complete */
    uint32_t period[2]; /* [periods] of the snapshot */
} recording_t;

/* The tuning of the capture for this record. */
capture_tuning_t recording_tuning(void);

/* From the background list: a new snapshot, if one is due. */
void recording_step(void);

/* Changes from outside, for the record; before they act, with interrupts off. The parameters of an offer need
 * not have interrupts off. */
void recording_event(uint32_t what, uint32_t bits);
void recording_requests(const requests_t *next);
void recording_offer(const params_t *params, const assumed_t *assumed);

/* Identity of the structs: a hash of the places of all signals and parameters, and of the sizes. */
uint32_t recording_layout(void);

/* A slot of a held record, by its number. false: it does not exist. */
bool recording_slot(uint32_t number, uint32_t *bits);

#endif
