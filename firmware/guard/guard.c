#include "guard/guard.h"

#include <string.h>

#include "guard/guard_quantities.h"
#include "settings/reasons.h"

const fault_row_t fault_rows[FAULTS] = {
#define FAULT_ROW(number, NAME, name, quantity, comparison, limit_row, margin, rate, debounce, when,         \
                  reaction, text, remedy)                                                                    \
    {number, name,         #quantity, #comparison,  limit_row,                                               \
     margin, FAULT_##rate, debounce,  FAULT_##when, FAULT_##reaction},
    DRIVE_FAULTS(FAULT_ROW)
#undef FAULT_ROW
};

/* The rows of a rate with one condition (fault_when_t), and the rows with one reaction. */
static inline fault_set_t rows_at(fault_when_t asked, fault_rate_t of)
{
#define FAULT_IF_WHEN(number, NAME, name, quantity, comparison, limit_row, margin, rate, debounce, when,     \
                      reaction, text, remedy)                                                                \
    set.word[FAULT_WORD(FAULT_##NAME)] |=                                                                    \
        FAULT_##when == asked && FAULT_##rate == of ? FAULT_BIT(FAULT_##NAME) : UINT32_C(0);
    fault_set_t set = fault_set_none();
    DRIVE_FAULTS(FAULT_IF_WHEN)
#undef FAULT_IF_WHEN
    return set;
}

static inline fault_set_t rows_with(fault_reaction_t asked)
{
#define FAULT_IF_REACTION(number, NAME, name, quantity, comparison, limit_row, margin, rate, debounce, when, \
                          reaction, text, remedy)                                                            \
    set.word[FAULT_WORD(FAULT_##NAME)] |= FAULT_##reaction == asked ? FAULT_BIT(FAULT_##NAME) : UINT32_C(0);
    fault_set_t set = fault_set_none();
    DRIVE_FAULTS(FAULT_IF_REACTION)
#undef FAULT_IF_REACTION
    return set;
}

void guard_init(guard_t *guard)
{
    memset(guard, 0, sizeof *guard);
}

/* The rows with this condition and rate if the condition is met, i.e. `met` is not zero. */
static inline fault_set_t rows_if(uint32_t met, fault_when_t when, fault_rate_t of)
{
    return met != 0u ? rows_at(when, of) : fault_set_none();
}

/* The rows of a rate whose condition (fault_when_t) is met now. */
static inline fault_set_t counting(uint32_t now, fault_rate_t of)
{
    const fault_set_t encoder = rows_if(now & GUARD_ENCODER, FAULT_ENCODER, of);
    const fault_set_t tracking = rows_if(now & GUARD_TRACKING, FAULT_TRACKING, of);
    const fault_set_t running = rows_if(now & GUARD_RUNNING, FAULT_RUNNING, of);
    const fault_set_t supplied = rows_if(now & GUARD_SUPPLIED, FAULT_SUPPLIED, of);
    const fault_set_t on = fault_set_both(running, supplied);
    const fault_set_t turning = fault_set_both(encoder, tracking);
    return fault_set_both(rows_at(FAULT_ALWAYS, of), fault_set_both(on, turning));
}

/* The rows of a rate that hold in this period, whether they count or not. */
static inline fault_set_t rows_that_hold(const guard_tuning_t *tuning, const guard_input_t *input,
                                         fault_rate_t asked)
{
#define FAULT_HOLDS(number, NAME, name, quantity, comparison, limit_row, margin, rate, debounce, when,       \
                    reaction, text, remedy)                                                                  \
    if (FAULT_##rate == asked && GUARD_IF_##comparison(tuning, guard_##quantity(input), NAME)) {             \
        all.word[FAULT_WORD(FAULT_##NAME)] |= FAULT_BIT(FAULT_##NAME);                                       \
    }
    fault_set_t all = fault_set_none();
    DRIVE_FAULTS(FAULT_HOLDS)
#undef FAULT_HOLDS
    return all;
}

/* Counts for how long a row that is judged once in `periods` has held at least. true: this is still shorter
 * than its debounce. */
static inline bool waits(uint32_t *held, uint32_t debounce, uint32_t periods, bool holds)
{
    if (!holds) {
        *held = 0u;
        return false;
    }
    const uint32_t now = *held == 0u ? 1u : *held + periods;
    if (now >= debounce) {
        return false;
    }
    *held = now;
    return true;
}

/* The rows of a rate that have held for their debounce, of those that hold `now`; the counts of the others
 * are cleared. */
static inline fault_set_t rows_that_fail(guard_t *guard, fault_set_t now, fault_rate_t asked)
{
#define FAULT_COUNTED(number, NAME, name, quantity, comparison, limit_row, margin, rate, debounce, when,     \
                      reaction, text, remedy)                                                                \
    if (FAULT_##rate == asked && (debounce) > 1u &&                                                          \
        waits(&guard->held[FAULT_##NAME], debounce, periods, fault_set_has(now, FAULT_##NAME))) {            \
        failed.word[FAULT_WORD(FAULT_##NAME)] &= ~FAULT_BIT(FAULT_##NAME);                                   \
    }
    const uint32_t periods = asked == FAULT_SLOW ? DRIVE_WINDOW : UINT32_C(1);
    fault_set_t failed = now;
    DRIVE_FAULTS(FAULT_COUNTED)
#undef FAULT_COUNTED
    return failed;
}

/* The rows of a rate that hold and count. */
static inline fault_set_t rows_now(const guard_tuning_t *tuning, const guard_input_t *input,
                                   fault_rate_t asked)
{
    return fault_set_common(rows_that_hold(tuning, input, asked), counting(input->now, asked));
}

/* A row with the rate EACH has no other reaction than OPEN. */
#define FAULT_DOES_NOT_OPEN(number, NAME, name, quantity, comparison, limit_row, margin, rate, debounce,     \
                            when, reaction, text, remedy)                                                    \
    || (FAULT_##rate == FAULT_EACH && FAULT_##reaction != FAULT_OPEN)
extern const char guard_each_opens[(false DRIVE_FAULTS(FAULT_DOES_NOT_OPEN)) ? -1 : 1];
#undef FAULT_DOES_NOT_OPEN

/* Two functions, so that neither computes the quantities of the other's rows. */
void guard_step_each(guard_t *guard, const guard_tuning_t *tuning, const guard_input_t *input)
{
    const fault_set_t now = rows_now(tuning, input, FAULT_EACH);
    const fault_set_t failed = rows_that_fail(guard, now, FAULT_EACH);
    guard->holding = now;
    guard->failed = failed;
    guard->faults = failed;
}

void guard_step_slow(guard_t *guard, const guard_tuning_t *tuning, const guard_input_t *input)
{
    const fault_set_t now = rows_now(tuning, input, FAULT_SLOW);
    const fault_set_t failed = rows_that_fail(guard, now, FAULT_SLOW);
    guard->holding = now;
    guard->failed = failed;
    guard->faults = fault_set_common(failed, rows_with(FAULT_OPEN));
    guard->stops = fault_set_common(failed, rows_with(FAULT_STOP));
    guard->losses = fault_set_common(failed, rows_with(FAULT_CATCH));
    guard->warnings = fault_set_common(failed, rows_with(FAULT_WARN));
}

int32_t guard_reason(fault_set_t faults)
{
    for (uint32_t n = 0; n < (uint32_t)FAULTS; n++) {
        if (fault_set_has(faults, (fault_bit_t)n)) {
            return fault_rows[n].reason;
        }
    }
    return REASON_NONE;
}

fault_set_t guard_fault_of(int32_t reason)
{
    for (uint32_t n = 0; n < (uint32_t)FAULTS; n++) {
        if (fault_rows[n].reason == reason) {
            return fault_set_of((fault_bit_t)n);
        }
    }
    return fault_set_none();
}
