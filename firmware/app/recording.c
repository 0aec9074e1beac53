#include "app/recording.h"

#include "app/app.h"
#include "app/version.h"
#include "contract/tap.h"
#include "settings/reasons.h"
#include "settings/signals.h"

#define TRIES  UINT32_C(3) /* tries of a copy between two samples */
#define MARGIN UINT32_C(8) /* [periods] from the time at which a snapshot is due until it is complete */
#define DUE_AFTER                                                                                            \
    ((RECORDING_ROWS - RECORDING_AFTER) / 2u - MARGIN) /* [periods] age of the newer snapshot                \
                                                        */

/* The ring is long enough for a useful time before the fault. */
typedef char recording_fits[(CAPTURE_SLOTS >= 2u * RECORDING_SNAPSHOT + RECORDING_EVENT * RECORDING_EVENTS +
                                                  RECORD_COLUMNS * 96u)
                                ? 1
                                : -1];

static uint32_t now_of(const volatile uint32_t *slot)
{
    return *slot;
}

/* The record is being made: its capture waits for the trigger. */
static bool is_waiting(void)
{
    return app->drive.record.on != 0u && now_of(&app->drive.capture.state) == (uint32_t)CAPTURE_IDLE;
}

capture_tuning_t recording_tuning(void)
{
    const capture_tuning_t tuning = {.on = (uint32_t)CAPTURE_ON_FAULT,
                                     .after = RECORDING_AFTER,
                                     .columns = RECORD_COLUMNS,
                                     .width = RECORD_COLUMNS,
                                     .periods = RECORDING_ROWS,
                                     .ring = RECORD_COLUMNS * RECORDING_ROWS,
                                     .place = {(uint32_t)offsetof(drive_t, record.slots[0]),
                                               (uint32_t)offsetof(drive_t, record.slots[1]),
                                               (uint32_t)offsetof(drive_t, record.slots[2]),
                                               (uint32_t)offsetof(drive_t, record.slots[3])}};
    return tuning;
}

/* ---- snapshots ---- */

/* Copies the slots `from` to `to` of a struct, four at a time, because the copy has to end before the next
 * sample.
 */
static void copy_slots(uint32_t *slots, const void *base, uint32_t from, uint32_t to)
{
    uint32_t n = from;
    for (; to - n >= 4u; n += 4u) {
        slots[n] = tap_slot(base, n);
        slots[n + 1u] = tap_slot(base, n + 1u);
        slots[n + 2u] = tap_slot(base, n + 2u);
        slots[n + 3u] = tap_slot(base, n + 3u);
    }
    for (uint32_t left = (to - from) & 3u; left != 0u; left--) {
        slots[n] = tap_slot(base, n);
        n++;
    }
}

#define SLOT_OF(member) ((uint32_t)(offsetof(drive_t, member) / sizeof(uint32_t)))

/* The medium task has made the setpoint of the last window, and nothing waits to be taken over. */
static bool is_settled(const drive_t *drive)
{
    return now_of(&drive->done) == now_of(&drive->handed) && now_of(&drive->offered) == 0u &&
           now_of(&drive->in_force) == drive->medium_has && drive->opens == (int32_t)REASON_NONE;
}

/* Copies the data that the sample interrupt writes, between two samples. false: a sample interrupted every
 * try. */
static bool copy_fast(uint32_t *slots, uint32_t *period)
{
    const drive_t *drive = &app->drive;
    for (uint32_t n = 0; n < TRIES; n++) {
        const uint32_t before = now_of(&drive->fast.period);
        copy_slots(slots, drive, 0u, SLOT_OF(medium));
        copy_slots(slots, drive, SLOT_OF(handed), RECORDING_STATE);
        if (now_of(&drive->fast.period) == before) {
            *period = before;
            return true;
        }
    }
    return false;
}

/* The key of the serial link is no part of the record, which any client may read. */
static void hide_key(uint32_t *params)
{
    params[offsetof(params_t, line_key) / sizeof(uint32_t)] = 0u;
}

/* false: the data has changed during the copy. */
static bool take(uint32_t number)
{
    const drive_t *drive = &app->drive;
    uint32_t *slots = &app->drive.capture.slots[RECORDING_SNAPSHOT_AT(number)];
    uint32_t *state = &slots[1];
    const uint32_t handed = now_of(&drive->handed);
    if (!is_settled(drive)) {
        return false;
    }
    slots[0] = app->recording.events;
    copy_slots(&state[RECORDING_STATE], &app->active, 0u, RECORDING_PARAMS);
    copy_slots(&state[RECORDING_STATE + RECORDING_PARAMS], &app->assumed, 0u, ASSUMED_SLOTS);
    hide_key(&state[RECORDING_STATE]);
    copy_slots(state, drive, SLOT_OF(medium), SLOT_OF(handed));
    /* a trip between the samples does not change the period: it triggers the capture */
    return copy_fast(state, &app->recording.period[number]) && now_of(&drive->handed) == handed &&
           is_waiting();
}

void recording_step(void)
{
    recording_t *recording = &app->recording;
    const uint32_t next = recording->next;
    const uint32_t newer = next ^ 1u;
    const uint32_t age = now_of(&app->drive.fast.period) - recording->period[newer];
    if (!is_waiting() || (recording->whole[newer] != 0u && age < DUE_AFTER)) {
        return;
    }
    recording->whole[next] = 0u;
    if (take(next)) {
        recording->whole[next] = 1u;
        recording->next = newer;
    }
}

/* ---- events ---- */

void recording_event(uint32_t what, uint32_t bits)
{
    drive_t *drive = &app->drive;
    if (drive->record.on == 0u || drive->capture.state == (uint32_t)CAPTURE_HELD) {
        return;
    }
    uint32_t *event =
        &drive->capture
             .slots[RECORDING_EVENTS_AT + RECORDING_EVENT * (app->recording.events % RECORDING_EVENTS)];
    event[0] = drive->fast.period;
    event[1] = what;
    event[2] = bits;
    app->recording.events++;
}

/* The rows of a table that differ. */
static void note_rows(const table_t *table, const void *from, const void *to)
{
    for (uint32_t n = 0; n < table->count; n++) {
        const table_row_t *row = &table->rows[n];
        const uint32_t bits = table_bits(row, to);
        if (bits != table_bits(row, from)) {
            recording_event(row->id, bits);
        }
    }
}

void recording_requests(const requests_t *next)
{
    if (app->drive.record.on == 0u) {
        return;
    }
    note_rows(&requests_table, &app->drive.requests, next);
}

void recording_offer(const params_t *params, const assumed_t *assumed)
{
    if (app->drive.record.on == 0u) {
        return;
    }
    params_t next = *params;
    next.line_key = app->active.line_key;
    note_rows(&params_table, &app->active, &next);
    for (uint32_t n = 0; n < ASSUMED_SLOTS; n++) {
        recording_event(RECORDING_ASSUMED_AT + n, tap_slot(assumed, n));
    }
}

/* ---- what a client reads ---- */

/* A hash of the numbers of the rows' slots, which are the same on every target. */
static uint32_t hash_places(const table_t *table, uint32_t before)
{
    uint32_t hash = before;
    for (uint32_t n = 0; n < table->count; n++) {
        const table_row_t *row = &table->rows[n];
        hash = record_mix(hash, row->id);
        hash = record_mix(hash, (uint32_t)(row->offset / sizeof(uint32_t)));
    }
    return hash;
}

uint32_t recording_layout(void)
{
    uint32_t hash = record_mix(RECORDING_STATE, RECORDING_SNAPSHOT);
    hash = hash_places(&signals_table, hash);
    hash = hash_places(&requests_table, hash);
    return hash_places(&params_table, hash);
}

static uint32_t name_slot(uint32_t number)
{
    static const char board_name[] = BOARD_NAME;
    uint32_t bits = 0u;
    for (uint32_t n = 0; n < 4u; n++) {
        const uint32_t at = 4u * number + n;
        if (at < (uint32_t)sizeof board_name) {
            bits |= ((uint32_t)board_name[at] & 0xFFu) << 8u * n;
        }
    }
    return bits;
}

static uint32_t head_slot(uint32_t number)
{
    const drive_t *drive = &app->drive;
    const uint32_t count = capture_count(&drive->capture);
    const uint32_t head[RECORDING_HEAD_BOARD] = {
        [RECORDING_HEAD_FORMAT] = RECORDING_FORMAT,
        [RECORDING_HEAD_SLOTS] =
            RECORDING_HEAD + RECORD_COLUMNS * count + RECORDING_SNAPSHOT_AT(2u) - RECORDING_EVENTS_AT,
        [RECORDING_HEAD_VERSION] = APP_VERSION,
        [RECORDING_HEAD_LAYOUT] = recording_layout(),
        [RECORDING_HEAD_STATE] = RECORDING_STATE,
        [RECORDING_HEAD_PARAMS] = RECORDING_PARAMS,
        [RECORDING_HEAD_ROWS] = count,
        [RECORDING_HEAD_NEWEST] = drive->capture.newest,
        [RECORDING_HEAD_AT] = drive->capture.at,
        [RECORDING_HEAD_EVENTS] = app->recording.events,
        [RECORDING_HEAD_WHOLE] = app->recording.whole[0] | app->recording.whole[1] << 1,
        [RECORDING_HEAD_REASON] = (uint32_t)drive->fault_reason,
        [RECORDING_HEAD_PERIOD] = drive->fault.period,
        [RECORDING_HEAD_CARRIER] = (uint32_t)(DRIVE_PERIOD * 1e9f + 0.5f),
    };
    return number < (uint32_t)RECORDING_HEAD_BOARD ? head[number]
                                                   : name_slot(number - (uint32_t)RECORDING_HEAD_BOARD);
}

bool recording_slot(uint32_t number, uint32_t *bits)
{
    const capture_t *capture = &app->drive.capture;
    const uint32_t rows = RECORD_COLUMNS * capture_count(capture);
    if (number < (uint32_t)RECORDING_HEAD) {
        *bits = head_slot(number);
        return true;
    }
    const uint32_t at = number - (uint32_t)RECORDING_HEAD;
    if (at < rows) {
        *bits = capture_row(capture, at / RECORD_COLUMNS)[at % RECORD_COLUMNS];
        return true;
    }
    const uint32_t rest = RECORDING_EVENTS_AT + at - rows;
    if (rest >= RECORDING_SNAPSHOT_AT(2u)) {
        return false;
    }
    *bits = capture->slots[rest];
    return true;
}
