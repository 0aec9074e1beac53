#include "drive/guard.h"

#include <string.h>

#include "drive/manoeuvres.h"
#include "drive/measure.h"
#include "drive/reasons.h"
#include "estimator/chosen.h"
#include "math/bounds.h"

const fault_row_t fault_rows[FAULTS] = {
#define FAULT_ROW(number, NAME, name, quantity, comparison, limit, margin, debounce, when, reaction, text,   \
                  remedy)                                                                                    \
    {number, name, #quantity, #comparison, limit, margin, debounce, FAULT_##when, FAULT_##reaction},
    DRIVE_FAULTS(FAULT_ROW)
#undef FAULT_ROW
};

/* Bits of the rows that count at a moment, and of those with a reaction. */
#define FAULT_BIT_OF(NAME) (UINT32_C(1) << (uint32_t)FAULT_##NAME)
#define FAULT_IF_WHEN(number, NAME, name, quantity, comparison, limit, margin, debounce, when, reaction,     \
                      text, remedy)                                                                          \
    | (FAULT_##when == moment ? FAULT_BIT_OF(NAME) : UINT32_C(0))
#define FAULT_IF_REACTION(number, NAME, name, quantity, comparison, limit, margin, debounce, when, reaction, \
                          text, remedy)                                                                      \
    | (FAULT_##reaction == asked ? FAULT_BIT_OF(NAME) : UINT32_C(0))

static inline uint32_t rows_at(fault_when_t moment)
{
    return 0u DRIVE_FAULTS(FAULT_IF_WHEN);
}

static inline uint32_t rows_with(fault_reaction_t asked)
{
    return 0u DRIVE_FAULTS(FAULT_IF_REACTION);
}

/* The comparisons of the table: a row's bit goes into `all` if it holds. A condition's bit is moved there;
 * those of neighbours move together. */
#define MARK_ABOVE(quantity, limit, row)                                                                     \
    if ((quantity) > (limit)) {                                                                              \
        all |= UINT32_C(1) << (uint32_t)(row);                                                               \
    }
#define MARK_BELOW(quantity, limit, row)                                                                     \
    if ((quantity) < (limit)) {                                                                              \
        all |= UINT32_C(1) << (uint32_t)(row);                                                               \
    }
#define MARK_HOLDS(quantity, limit, row) all |= (uint32_t)(quantity) << (uint32_t)(row);

float guard_limit(const fault_row_t *row, const params_t *params)
{
    const table_row_t *limit = table_by_name(&params_table, row->limit);
    return row->margin + (limit != NULL ? table_get(limit, params) : 0.0f);
}

#define PREPARE_ABOVE(NAME) tuning.limit[FAULT_LIMIT_##NAME] = guard_limit(&fault_rows[FAULT_##NAME], params);
#define PREPARE_BELOW(NAME) PREPARE_ABOVE(NAME)
#define PREPARE_HOLDS(NAME)

guard_tuning_t guard_prepare(const params_t *params)
{
#define FAULT_PREPARED(number, NAME, name, quantity, comparison, limit, margin, debounce, when, reaction,    \
                       text, remedy)                                                                         \
    PREPARE_##comparison(NAME)
    guard_tuning_t tuning;
    DRIVE_FAULTS(FAULT_PREPARED)
#undef FAULT_PREPARED
    return tuning;
}

void guard_init(guard_t *guard, const guard_tuning_t *tuning)
{
    memset(guard, 0, sizeof *guard);
    guard_take(guard, tuning);
}

/* The quantities of the table. */
typedef struct {
    float phase_current;     /* [A] the largest amount of the three, offsets removed */
    float u_dc;              /* [V] */
    float sink_temperature;  /* [degC] */
    float motor_temperature; /* [degC] */
    float speed;             /* [rad/s] amount, mechanical */
    bool tripped;            /* [-] true: the trip zone holds the gates off; conditions likewise: */
    bool bad_sample;         /* [-] not a number, or a current sensor at its rail */
    bool late;               /* [-] this interrupt came too late for its period */
    bool encoder_error;      /* [-] quadrature phase error since the last sample */
    bool estimate_amplitude; /* [-] the estimate in use is lost by this criterion */
    bool estimate_detector;  /* [-] likewise */
    bool estimate_current;   /* [-] likewise */
    bool estimate_speed;     /* [-] likewise */
    bool unlocked;           /* [-] a sign of a lost lock stands */
    bool lock_lost;          /* [-] the manoeuvre has failed by this, and the next three */
    bool start_stalled;      /* [-] likewise */
    bool start_unlocked;     /* [-] likewise */
    bool rotor_too_fast;     /* [-] likewise */
} quantities_t;

static quantities_t quantities_of(const guard_input_t *input)
{
    const measured_t *measured = input->measured;
    const uint32_t invalid = input->estimate_invalid;
    const abc_t i = measured->current_abc;
    return (quantities_t){
        .phase_current =
            bounds_span(bounds_magnitude(i.a), bounds_magnitude(i.b), bounds_magnitude(i.c)).largest,
        .u_dc = measured->u_dc,
        .sink_temperature = measured->sink_temperature,
        .motor_temperature = measured->motor_temperature,
        .speed = bounds_magnitude(input->omega_m),
        .tripped = (measured->flags & DRIVE_SAMPLE_TRIPPED) != 0u,
        .bad_sample = measured->good == 0u,
        .late = (measured->flags & DRIVE_SAMPLE_LATE) != 0u,
        .encoder_error = (measured->flags & DRIVE_SAMPLE_ENCODER) != 0u,
        .estimate_amplitude = (invalid & ESTIMATOR_AMPLITUDE) != 0u,
        .estimate_detector = (invalid & ESTIMATOR_DETECTOR) != 0u,
        .estimate_current = (invalid & ESTIMATOR_CURRENT) != 0u,
        .estimate_speed = (invalid & ESTIMATOR_SPEED) != 0u,
        .unlocked = input->unlocked != 0u,
        .lock_lost = (input->failed & MANOEUVRE_LOST) != 0u,
        .start_stalled = (input->failed & MANOEUVRE_STALLED) != 0u,
        .start_unlocked = (input->failed & MANOEUVRE_UNLOCKED) != 0u,
        .rotor_too_fast = (input->failed & MANOEUVRE_TOO_FAST) != 0u,
    };
}

/* Bits of the rows that count now. */
static inline uint32_t counting_rows(uint32_t now)
{
    return rows_at(FAULT_ALWAYS) | ((now & GUARD_RUNNING) != 0u ? rows_at(FAULT_RUNNING) : 0u) |
           ((now & GUARD_ENCODER) != 0u ? rows_at(FAULT_ENCODER) : 0u) |
           ((now & GUARD_TRACKING) != 0u ? rows_at(FAULT_TRACKING) : 0u);
}

/* Bits of the rows that hold in this period, whether they count or not. */
static uint32_t holding(const guard_t *guard, const quantities_t *now)
{
#define FAULT_HOLDS(number, NAME, name, quantity, comparison, limit_row, margin, debounce, when, reaction,   \
                    text, remedy)                                                                            \
    MARK_##comparison(now->quantity, guard->tuning.limit[FAULT_LIMIT_##NAME], FAULT_##NAME)
    uint32_t all = 0u;
    DRIVE_FAULTS(FAULT_HOLDS)
#undef FAULT_HOLDS
    return all;
}

/* Counts a row; is it still too soon for its debounce? */
static inline bool waits(uint32_t *held, uint32_t debounce, bool holds)
{
    if (!holds) {
        *held = 0u;
        return false;
    }
    if (*held + 1u >= debounce) {
        return false;
    }
    *held += 1u;
    return true;
}

/* Bits of the rows that have held for their debounce, of those that hold `now`; the others begin anew. */
static uint32_t failing(guard_t *guard, uint32_t now)
{
#define FAULT_COUNTED(number, NAME, name, quantity, comparison, limit, margin, debounce, when, reaction,     \
                      text, remedy)                                                                          \
    if ((debounce) > 1u && waits(&guard->held[FAULT_##NAME], debounce, (now & FAULT_BIT_OF(NAME)) != 0u)) {  \
        failed &= ~FAULT_BIT_OF(NAME);                                                                       \
    }
    uint32_t failed = now;
    DRIVE_FAULTS(FAULT_COUNTED)
#undef FAULT_COUNTED
    return failed;
}

void guard_step(guard_t *guard, const guard_input_t *input)
{
    const quantities_t quantities = quantities_of(input);
    const uint32_t all = holding(guard, &quantities);
    const uint32_t now = all != 0u ? all & counting_rows(input->now) : 0u;
    /* while nothing holds nor has held, nothing is counted */
    const uint32_t failed = (now | guard->holding) != 0u ? failing(guard, now) : 0u;
    guard->holding = now;
    guard->faults = failed & rows_with(FAULT_OPEN);
    guard->losses = failed & rows_with(FAULT_CATCH);
    guard->warnings = failed & rows_with(FAULT_WARN);
}

int32_t guard_reason(uint32_t faults)
{
    for (uint32_t n = 0; n < (uint32_t)FAULTS; n++) {
        if ((faults >> n & 1u) != 0u) {
            return fault_rows[n].reason;
        }
    }
    return REASON_NONE;
}

uint32_t guard_fault_of(int32_t reason)
{
    for (uint32_t n = 0; n < (uint32_t)FAULTS; n++) {
        if (fault_rows[n].reason == reason) {
            return UINT32_C(1) << n;
        }
    }
    return 0u;
}
