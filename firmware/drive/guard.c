#include "drive/guard.h"

#include <string.h>

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

/* Bits of the rows that count only while the gates shall be on, and of those that open the bridge. */
#define FAULT_IF_RUNNING(number, NAME, name, quantity, comparison, limit, margin, debounce, when, reaction,  \
                         text, remedy)                                                                       \
    | (uint32_t)FAULT_##when << (uint32_t)FAULT_##NAME
#define FAULT_IF_OPEN(number, NAME, name, quantity, comparison, limit, margin, debounce, when, reaction,     \
                      text, remedy)                                                                          \
    | (uint32_t)FAULT_##reaction << (uint32_t)FAULT_##NAME
#define RUNNING_ROWS (0u DRIVE_FAULTS(FAULT_IF_RUNNING))
#define OPEN_ROWS    (0u DRIVE_FAULTS(FAULT_IF_OPEN))

#define FAULT_MASK(bit) (UINT32_C(1) << (uint32_t)(bit))

/* The comparisons of the table. */
#define IS_ABOVE(quantity, limit) ((quantity) > (limit))
#define IS_BELOW(quantity, limit) ((quantity) < (limit))
#define IS_HOLDS(quantity, limit) ((quantity) != 0u)

guard_tuning_t guard_prepare(const params_t *params)
{
    guard_tuning_t tuning;
    memset(&tuning, 0, sizeof tuning);
    for (uint32_t n = 0; n < (uint32_t)FAULTS; n++) {
        const table_row_t *limit = table_by_name(&params_table, fault_rows[n].limit);
        tuning.limit[n] = fault_rows[n].margin + (limit != NULL ? table_get(limit, params) : 0.0f);
    }
    return tuning;
}

void guard_init(guard_t *guard, const guard_tuning_t *tuning)
{
    memset(guard, 0, sizeof *guard);
    guard_take(guard, tuning);
}

/* The quantities of the table. */
typedef struct {
    float phase_current;         /* [A] the largest amount of the three, offsets removed */
    float u_dc;                  /* [V] */
    float sink_temperature;      /* [degC] */
    float motor_temperature;     /* [degC] */
    float speed;                 /* [rad/s] amount, mechanical */
    uint32_t tripped;            /* [-] not 0: the trip zone holds the gates off; conditions likewise: */
    uint32_t bad_sample;         /* [-] not a number, or a current sensor at its rail */
    uint32_t late;               /* [-] this interrupt came too late for its period */
    uint32_t encoder_error;      /* [-] quadrature phase error since the last sample */
    uint32_t estimate_amplitude; /* [-] the estimate in use is lost by this criterion */
    uint32_t estimate_detector;  /* [-] likewise */
    uint32_t estimate_current;   /* [-] likewise */
    uint32_t estimate_speed;     /* [-] likewise */
} quantities_t;

static quantities_t quantities_of(const measured_t *measured, float omega_m, uint32_t invalid)
{
    const abc_t i = measured->current_abc;
    return (quantities_t){
        .phase_current =
            bounds_span(bounds_magnitude(i.a), bounds_magnitude(i.b), bounds_magnitude(i.c)).largest,
        .u_dc = measured->u_dc,
        .sink_temperature = measured->sink_temperature,
        .motor_temperature = measured->motor_temperature,
        .speed = bounds_magnitude(omega_m),
        .tripped = measured->flags & DRIVE_SAMPLE_TRIPPED,
        .bad_sample = measured->good == 0u,
        .late = measured->flags & DRIVE_SAMPLE_LATE,
        .encoder_error = measured->flags & DRIVE_SAMPLE_ENCODER,
        .estimate_amplitude = invalid & ESTIMATOR_AMPLITUDE,
        .estimate_detector = invalid & ESTIMATOR_DETECTOR,
        .estimate_current = invalid & ESTIMATOR_CURRENT,
        .estimate_speed = invalid & ESTIMATOR_SPEED,
    };
}

/* Bits of the rows that hold in this period. */
static uint32_t holding(const guard_t *guard, const quantities_t *now, bool running)
{
#define FAULT_HOLDS(number, NAME, name, quantity, comparison, limit_row, margin, debounce, when, reaction,   \
                    text, remedy)                                                                            \
    if (IS_##comparison(now->quantity, guard->tuning.limit[FAULT_##NAME])) {                                 \
        all |= FAULT_MASK(FAULT_##NAME);                                                                     \
    }
    uint32_t all = 0u;
    DRIVE_FAULTS(FAULT_HOLDS)
#undef FAULT_HOLDS
    return running ? all : all & ~RUNNING_ROWS;
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
    if ((debounce) > 1u &&                                                                                   \
        waits(&guard->held[FAULT_##NAME], debounce, (now & FAULT_MASK(FAULT_##NAME)) != 0u)) {               \
        failed &= ~FAULT_MASK(FAULT_##NAME);                                                                 \
    }
    uint32_t failed = now;
    DRIVE_FAULTS(FAULT_COUNTED)
#undef FAULT_COUNTED
    return failed;
}

void guard_step(guard_t *guard, const measured_t *measured, float omega_m, uint32_t estimate_invalid,
                bool running)
{
    const quantities_t quantities = quantities_of(measured, omega_m, estimate_invalid);
    const uint32_t now = holding(guard, &quantities, running);
    /* while nothing holds nor has held, nothing is counted */
    const uint32_t failed = (now | guard->holding) != 0u ? failing(guard, now) : 0u;
    guard->holding = now;
    guard->faults = failed & OPEN_ROWS;
    guard->warnings = failed & ~OPEN_ROWS;
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
