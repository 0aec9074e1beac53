#include "contract/capture.h"

#include "contract/tap.h"
#include "math/float_bits.h"

static bool is_edge(int32_t on)
{
    return on == (int32_t)CAPTURE_ON_ABOVE || on == (int32_t)CAPTURE_ON_BELOW;
}

uint32_t capture_prepare(const capture_wish_t *wish, const table_t *table, capture_tuning_t *tuning)
{
    capture_tuning_t next = {.on = (uint32_t)wish->on, .level = wish->level, .after = wish->after};
    if (wish->on < (int32_t)CAPTURE_ON_FAULT || wish->on > (int32_t)CAPTURE_ON_COMMAND) {
        return CAPTURE_BAD_ON;
    }
    if (is_edge(wish->on)) {
        const table_row_t *row = table_by_id(table, wish->source);
        if (row == NULL) {
            return CAPTURE_BAD_SOURCE;
        }
        if (!(wish->level == wish->level)) {
            return CAPTURE_BAD_LEVEL;
        }
        next.source = (uint32_t)row->offset;
        next.kind = (uint32_t)row->kind;
    }
    if (wish->columns < 1u || wish->columns > CAPTURE_COLUMNS) {
        return CAPTURE_BAD_COLUMNS;
    }
    next.columns = wish->columns;
    next.width = capture_width(wish->columns);
    next.periods = capture_room(wish->columns);
    next.ring = next.width * next.periods;
    if (wish->after >= next.periods) {
        return CAPTURE_BAD_AFTER;
    }
    for (uint32_t n = 0; n < wish->columns; n++) {
        const table_row_t *row = table_by_id(table, wish->id[n]);
        if (row == NULL) {
            return (uint32_t)CAPTURE_BAD_ID + n;
        }
        next.id[n] = row->id;
        next.place[n] = (uint32_t)row->offset;
    }
    *tuning = next;
    return CAPTURE_GOOD;
}

static void begin(capture_t *capture, capture_state_t state)
{
    capture->state = (uint32_t)state;
    capture->asked = state == CAPTURE_ARMED ? UINT32_C(1) : UINT32_C(0);
    capture->next = 0u;
    capture->full = 0u;
    capture->at = 0u;
    capture->beyond = 1u; /* a value that is beyond the level from the start is no edge */
}

void capture_init(capture_t *capture, const capture_tuning_t *tuning)
{
    capture->tuning = *tuning;
    begin(capture, CAPTURE_IDLE);
    capture->newest = 0u;
    for (uint32_t n = 0; n < CAPTURE_SLOTS; n++) {
        capture->slots[n] = 0u;
    }
}

void capture_release(capture_t *capture, const capture_tuning_t *tuning)
{
    capture->tuning = *tuning;
    begin(capture, CAPTURE_IDLE);
}

void capture_arm(capture_t *capture, const capture_tuning_t *tuning)
{
    capture->tuning = *tuning;
    begin(capture, CAPTURE_ARMED);
}

void capture_trigger(capture_t *capture, uint32_t period)
{
    if (capture->state < (uint32_t)CAPTURE_TRIGGERED) {
        capture->at = period;
        capture->state = capture->newest == period && capture->tuning.after == 0u
                             ? (uint32_t)CAPTURE_HELD
                             : (uint32_t)CAPTURE_TRIGGERED;
    }
}

void capture_reset(capture_t *capture)
{
    if (capture->asked == 0u) {
        begin(capture, CAPTURE_IDLE);
    }
}

/* The source as a number; whole ones beyond +-2^24 lose their last bits. */
static inline float value_of(uint32_t kind, uint32_t bits)
{
    float value = float_of_bits(bits);
    if (kind == (uint32_t)SLOT_UINT) {
        value = (float)bits;
    } else if (kind != (uint32_t)SLOT_FLOAT) {
        value = (float)(int32_t)bits;
    }
    return value;
}

static void watch(capture_t *capture, const void *base, uint32_t period)
{
    const capture_tuning_t *tuning = &capture->tuning;
    const float value = value_of(tuning->kind, tap_slot_at(base, (size_t)tuning->source));
    const bool is_beyond =
        tuning->on == (uint32_t)CAPTURE_ON_ABOVE ? value > tuning->level : value < tuning->level;
    if (is_beyond && capture->beyond == 0u) {
        capture_trigger(capture, period);
    }
    capture->beyond = is_beyond ? UINT32_C(1) : UINT32_C(0);
}

/* Continues with the armed tuning, or after the trigger. */
static void follow(capture_t *capture, const void *base, uint32_t period)
{
    if (capture->state == (uint32_t)CAPTURE_ARMED && is_edge((int32_t)capture->tuning.on)) {
        watch(capture, base, period);
    }
    if (capture->state == (uint32_t)CAPTURE_TRIGGERED && period - capture->at >= capture->tuning.after) {
        capture->state = (uint32_t)CAPTURE_HELD;
    }
}

void capture_step(capture_t *capture, const void *base, uint32_t period)
{
    const uint32_t state = capture->state;
    if (state == (uint32_t)CAPTURE_HELD) {
        return;
    }
    const uint32_t *place = capture->tuning.place;
    const uint32_t next = capture->next + capture->tuning.width;
    uint32_t *slot = &capture->slots[capture->next];
    const uint32_t *const end = &capture->slots[next];
    do {
        slot[0] = tap_slot_at(base, (size_t)place[0]);
        slot[1] = tap_slot_at(base, (size_t)place[1]);
        slot[2] = tap_slot_at(base, (size_t)place[2]);
        slot[3] = tap_slot_at(base, (size_t)place[3]);
        slot = &slot[4];
        place = &place[4];
    } while (slot != end);
    capture->next = next;
    capture->newest = period;
    if (next == capture->tuning.ring) {
        capture->next = 0u;
        capture->full = 1u;
    }
    if (state != (uint32_t)CAPTURE_IDLE) {
        follow(capture, base, period);
    }
}

uint32_t capture_count(const capture_t *capture)
{
    return capture->full != 0u ? capture->tuning.periods : capture->next / capture->tuning.width;
}

const uint32_t *capture_row(const capture_t *capture, uint32_t n)
{
    const uint32_t oldest = capture->full != 0u ? capture->next : 0u;
    const uint32_t at = oldest + capture->tuning.width * n;
    return &capture->slots[at < capture->tuning.ring ? at : at - capture->tuning.ring];
}
