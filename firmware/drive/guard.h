/* The guard: which rows of the fault table (faults.h) hold, each with its own debounce. Comparing and
 * counting, straight line, no division; counted is only while something holds.
 *
 * The gates themselves are shut by the trip zone without software; this is the reaction of the software, and
 * the protection against all that the power module cannot see. */
#ifndef DRIVE_GUARD_H
#define DRIVE_GUARD_H

#include <stdbool.h>
#include <stdint.h>

#include "contract/measured.h"
#include "drive/faults.h"

/* The rows that have a limit. */
#define FAULT_LIMIT_IF_ABOVE(NAME) FAULT_LIMIT_##NAME,
#define FAULT_LIMIT_IF_BELOW(NAME) FAULT_LIMIT_##NAME,
#define FAULT_LIMIT_IF_HOLDS(NAME)
typedef enum {
#define FAULT_LIMIT(number, NAME, name, quantity, comparison, limit, margin, debounce, when, reaction, text, \
                    remedy)                                                                                  \
    FAULT_LIMIT_IF_##comparison(NAME)
    DRIVE_FAULTS(FAULT_LIMIT)
#undef FAULT_LIMIT
        FAULT_LIMITS
} fault_limit_t;

typedef struct {
    float limit[FAULT_LIMITS]; /* [unit of the quantity] by fault_limit_t, margin added */
} guard_tuning_t;

/* What is judged in a period. */
typedef struct {
    const measured_t *measured;
    float omega_m;             /* [rad/s] mechanical */
    uint32_t estimate_invalid; /* [-] ESTIMATOR_... bits, the criteria by which the estimate has failed */
    uint32_t unlocked;         /* [-] 1: a sign of a lost lock stands */
    uint32_t failed;           /* [-] MANOEUVRE_... bits */
    uint32_t now;              /* [-] GUARD_... bits: which rows count */
} guard_input_t;

/* Bits of the moments of fault_when_t. */
#define GUARD_MOMENT(when) (UINT32_C(1) << (uint32_t)(when))
#define GUARD_ALWAYS       GUARD_MOMENT(FAULT_ALWAYS)
#define GUARD_RUNNING      GUARD_MOMENT(FAULT_RUNNING)
#define GUARD_ENCODER      GUARD_MOMENT(FAULT_ENCODER)
#define GUARD_TRACKING     GUARD_MOMENT(FAULT_TRACKING)

typedef struct {
    guard_tuning_t tuning;
    uint32_t held[FAULTS]; /* [periods] for how long a row has held without a break before this one, until it
                              fails; of those that do not fail at once */
    uint32_t holding;      /* [-] bits of the rows that held in the last period */
    uint32_t faults;       /* [-] bits of the rows with reaction OPEN that have held for their debounce */
    uint32_t losses;       /* [-] bits of those with reaction CATCH */
    uint32_t warnings;     /* [-] bits of those with reaction WARN */
} guard_t;

/* Limit of a row in this set, margin added [unit of the quantity]; 0 for a condition. */
float guard_limit(const fault_row_t *row, const params_t *params);

/* The limits of this set. */
guard_tuning_t guard_prepare(const params_t *params);

/* These limits; nothing holds. */
void guard_init(guard_t *guard, const guard_tuning_t *tuning);

/* New limits; what is being counted goes on. */
static inline void guard_take(guard_t *guard, const guard_tuning_t *tuning)
{
    guard->tuning = *tuning;
}

/* guard->faults, losses and warnings of this period. */
void guard_step(guard_t *guard, const guard_input_t *input);

/* Reason number of the gravest of these bits; REASON_NONE for 0. */
int32_t guard_reason(uint32_t faults);

/* Bit of the row with this reason number; 0: none of the table's. */
uint32_t guard_fault_of(int32_t reason);

#endif
