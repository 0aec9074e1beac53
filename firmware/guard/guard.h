/* The guard: finds which rows of the fault table (faults.h) hold, each with its own debounce, by comparisons
 * and counts, without a loop or a division. The fast task has a guard for the rows that are judged in each
 * period, the medium task one for all others.
 *
 * The trip zone switches the gates off without software. The guard is the reaction of the software, and the
 * protection against faults that the power module cannot detect. */
#ifndef GUARD_GUARD_H
#define GUARD_GUARD_H

#include <stdbool.h>
#include <stdint.h>

#include "contract/measured.h"
#include "guard/fault_set.h"
#include "settings/faults.h"

/* The rows that have a limit. */
#define FAULT_LIMIT_IF_ABOVE(NAME) FAULT_LIMIT_##NAME,
#define FAULT_LIMIT_IF_BELOW(NAME) FAULT_LIMIT_##NAME,
#define FAULT_LIMIT_IF_HOLDS(NAME)
typedef enum {
#define FAULT_LIMIT(number, NAME, name, quantity, comparison, limit, margin, rate, debounce, when, reaction, \
                    text, remedy)                                                                            \
    FAULT_LIMIT_IF_##comparison(NAME)
    DRIVE_FAULTS(FAULT_LIMIT)
#undef FAULT_LIMIT
        FAULT_LIMITS
} fault_limit_t;

typedef struct {
    float limit[FAULT_LIMITS]; /* [unit of the quantity] by fault_limit_t, margin added */
} guard_tuning_t;

/* Results of the background. The first bits are the memories of app/self_watch.h, in their order: 1 if the
 * content has changed. The other bits are the state of the serial link. */
#define GUARD_CORRUPT_PROGRAM        UINT32_C(1)
#define GUARD_CORRUPT_INTERRUPT_CODE UINT32_C(2)
#define GUARD_CORRUPT_STACK_END      UINT32_C(4)
#define GUARD_CORRUPT_PARAMS         UINT32_C(8)
#define GUARD_MASTER_SILENT          UINT32_C(0x10000)

/* Problems of the control loops. */
#define GUARD_LOOP_SLOW       UINT32_C(1) /* the tracking loop is configured too slow */
#define GUARD_LOOP_OSCILLATED UINT32_C(2) /* the speed loop oscillated and was slowed down */

/* Results of the medium task. */
typedef struct {
    uint32_t estimate_invalid; /* [-] ESTIMATOR_... bits, the criteria by which the estimate has failed */
    uint32_t unlocked;         /* [-] 1: there is a sign of a lost lock */
    uint32_t failed;           /* [-] MANOEUVRE_... bits, without that of `too_fast` */
    uint32_t too_fast;         /* [-] 1: the EMF of the rotor exceeds the link */
    uint32_t unattended;       /* [-] 1: the background has not run for too long */
    uint32_t reported;         /* [-] GUARD_CORRUPT_... and other bits, results of the background */
    uint32_t moves_wrong;      /* [-] MOTION_... bits */
    uint32_t encoder_lost;     /* [-] 1: control has left the encoder */
    uint32_t current_faults;   /* [-] CURRENT_WATCH_... bits */
    uint32_t heat;             /* [-] THERMAL_... bits */
    uint32_t link;             /* [-] LINK_... bits */
    uint32_t loops;            /* [-] GUARD_LOOP_... bits */
    uint32_t chopper;          /* [-] CHOPPER_... bits */
    uint32_t brake_torque;     /* [-] 1: the torque for releasing the brake is missing */
} guard_found_t;

/* Inputs of the guard. */
typedef struct {
    const measured_t *measured;
    float omega_m;              /* [rad/s] mechanical */
    uint32_t encoder_wrong;     /* [-] ENCODER_WATCH_... bits */
    uint32_t medium_late;       /* [-] 1: the medium task has missed two consecutive windows */
    uint32_t now;               /* [-] GUARD_... bits: which rows count */
    const guard_found_t *found; /* NULL for the guard with the rate EACH: its rows do not use it */
} guard_input_t;

/* Bits of fault_when_t: conditions under which a row counts. */
#define GUARD_MOMENT(when) (UINT32_C(1) << (uint32_t)(when))
#define GUARD_ALWAYS       GUARD_MOMENT(FAULT_ALWAYS)
#define GUARD_RUNNING      GUARD_MOMENT(FAULT_RUNNING)
#define GUARD_ENCODER      GUARD_MOMENT(FAULT_ENCODER)
#define GUARD_TRACKING     GUARD_MOMENT(FAULT_TRACKING)
#define GUARD_SUPPLIED     GUARD_MOMENT(FAULT_SUPPLIED)

typedef struct {
    uint32_t held[FAULTS]; /* [periods] for which a row has held without a break before this period; for rows
                              with a debounce time */
    fault_set_t holding;   /* rows that held when they were last judged */
    fault_set_t failed;    /* those of `holding` that have held for their debounce */
    fault_set_t faults;    /* those of `failed` with reaction OPEN */
    fault_set_t stops;     /* those with STOP */
    fault_set_t losses;    /* those with CATCH */
    fault_set_t warnings;  /* those with WARN */
} guard_t;

/* Limit of a row in this set, margin added [unit of the quantity]; 0 for a condition. */
float guard_limit(const fault_row_t *row, const params_t *params);

/* The limits of this set. */
guard_tuning_t guard_prepare(const params_t *params);

/* Starts with no row that holds. */
void guard_init(guard_t *guard);

/* Updates guard->faults, stops, losses and warnings by these limits, for the rows of one rate:
 * guard_step_each in each period, guard_step_slow once per window. A guard is for one rate only. While
 * guard_is_calm() is true, the call changes nothing and may be omitted. */
void guard_step_each(guard_t *guard, const guard_tuning_t *tuning, const guard_input_t *input);
void guard_step_slow(guard_t *guard, const guard_tuning_t *tuning, const guard_input_t *input);

/* Reason number of the first of these rows; REASON_NONE: the set is empty. */
int32_t guard_reason(fault_set_t faults);

/* The row with this reason number; empty: the reason is not in the table. */
fault_set_t guard_fault_of(int32_t reason);

#endif
