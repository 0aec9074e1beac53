/* A replay: a recorded state of the drive in a new rig, whose interrupts run on the recorded samples. Chip
 * and plant do not advance during the replay.
 *
 * Between two samples the drive of the record had its medium task, if a window was handed over, then the
 * background. Here the medium task computes at once, and the same step as in the record gets its results.
 * Therefore its duration, and the interrupts during it, agree with the record. */
#include <stdio.h>
#include <string.h>

#include "app/version.h"
#include "contract/tap.h"
#include "host_sim/rig/rig_parts.h"
#include "settings/reasons.h"
#include "settings/signals.h"

/* ---- the record of a rig ---- */

uint32_t rig_record_count(rig_t *rig)
{
    const drive_t *drive = &rig->state.app.drive;
    uint32_t count = 0u;
    rig_bind(rig);
    if (drive->record.on != 0u && drive->capture.state == (uint32_t)CAPTURE_HELD) {
        (void)recording_slot(RECORDING_HEAD_SLOTS, &count);
    }
    return count;
}

void rig_record(rig_t *rig, uint32_t *slots, uint32_t count)
{
    rig_bind(rig);
    for (uint32_t n = 0; n < count; n++) {
        slots[n] = 0u;
        (void)recording_slot(n, &slots[n]);
    }
}

void rig_record_head(const uint32_t *slots, rig_record_t *record)
{
    *record = (rig_record_t){
        .format = slots[RECORDING_HEAD_FORMAT],
        .slots = slots[RECORDING_HEAD_SLOTS],
        .version = slots[RECORDING_HEAD_VERSION],
        .layout = slots[RECORDING_HEAD_LAYOUT],
        .rows = slots[RECORDING_HEAD_ROWS],
        .newest = slots[RECORDING_HEAD_NEWEST],
        .at = slots[RECORDING_HEAD_AT],
        .reason = (int32_t)slots[RECORDING_HEAD_REASON],
        .fault_period = slots[RECORDING_HEAD_PERIOD],
        .carrier_ns = slots[RECORDING_HEAD_CARRIER],
    };
    for (uint32_t n = 0; n < sizeof record->board - 1u; n++) {
        record->board[n] = (char)(slots[RECORDING_HEAD_BOARD + n / 4u] >> 8u * (n % 4u) & 0xFFu);
    }
}

_Static_assert(RIG_RECORD_HEAD == (uint32_t)RECORDING_HEAD, "slots of the head");
_Static_assert(sizeof((rig_record_t *)NULL)->board == 4u * (RECORDING_HEAD - RECORDING_HEAD_BOARD) + 1u,
               "length of a board's name");

/* ---- its parts ---- */

static uint32_t events_at(const rig_record_t *record)
{
    return RECORDING_HEAD + RECORD_COLUMNS * record->rows;
}

static const uint32_t *snapshot(const rig_replay_t *replay, uint32_t number)
{
    return replay->slots + events_at(&replay->record) + RECORDING_EVENT * RECORDING_EVENTS +
           number * RECORDING_SNAPSHOT;
}

static uint32_t period_of(const uint32_t *snapshot_slots)
{
    return snapshot_slots[1u + offsetof(drive_t, fast.period) / sizeof(uint32_t)];
}

/* The row of a period; NULL: it is not recorded. */
static const uint32_t *row_of(const rig_replay_t *replay, uint32_t period)
{
    const uint32_t ago = replay->record.newest - period;
    return ago < replay->record.rows
               ? replay->slots + RECORDING_HEAD + RECORD_COLUMNS * (replay->record.rows - 1u - ago)
               : NULL;
}

/* True if a replay can begin with this snapshot: it is complete and from before the trigger, and all samples
 * and events since then are in the record. */
static bool is_usable(const rig_replay_t *replay, uint32_t number)
{
    const uint32_t *slots = snapshot(replay, number);
    const uint32_t period = period_of(slots);
    return (replay->slots[RECORDING_HEAD_WHOLE] >> number & 1u) != 0u &&
           replay->record.at - period <= replay->record.rows && row_of(replay, period + 1u) != NULL &&
           replay->slots[RECORDING_HEAD_EVENTS] - slots[0] <= RECORDING_EVENTS;
}

/* ---- begin ---- */

static bool refuse(rig_t *rig, const char *text)
{
    return rig_refuse(rig, 0u, REASON_OUT_OF_RANGE, text);
}

static bool is_of_this_program(rig_t *rig, const rig_record_t *record)
{
    char text[sizeof rig->error];
    rig_bind(rig);
    if (record->format != RECORDING_FORMAT) {
        snprintf(text, sizeof text, "format %lu of the record: accepted: %lu", (unsigned long)record->format,
                 (unsigned long)RECORDING_FORMAT);
        return refuse(rig, text);
    }
    if (record->version != APP_VERSION) {
        snprintf(
            text, sizeof text,
            "firmware %lu.%lu.%lu: accepted: %lu.%lu.%lu, which is this program's; build lagless from the "
            "sources of the drive's firmware",
            (unsigned long)(record->version >> 16), (unsigned long)(record->version >> 8 & 0xFFu),
            (unsigned long)(record->version & 0xFFu), (unsigned long)APP_VERSION_MAJOR,
            (unsigned long)APP_VERSION_MINOR, (unsigned long)APP_VERSION_PATCH);
        return refuse(rig, text);
    }
    if (strcmp(record->board, BOARD_NAME) != 0) {
        snprintf(text, sizeof text,
                 "board %.24s: accepted: %s, the board of this program; give --board %.24s", record->board,
                 BOARD_NAME, record->board);
        return refuse(rig, text);
    }
    if (record->carrier_ns != (uint32_t)(DRIVE_PERIOD * 1e9f + 0.5f)) {
        snprintf(text, sizeof text,
                 "carrier with a period of %lu ns: accepted: %lu ns, those of the board file; build lagless "
                 "with the board file of the drive's firmware",
                 (unsigned long)record->carrier_ns, (unsigned long)(DRIVE_PERIOD * 1e9f + 0.5f));
        return refuse(rig, text);
    }
    if (record->layout != recording_layout()) {
        snprintf(text, sizeof text,
                 "layout %08lx of the state: accepted: %08lx, that of this program; build lagless from the "
                 "sources of the drive's firmware",
                 (unsigned long)record->layout, (unsigned long)recording_layout());
        return refuse(rig, text);
    }
    return true;
}

/* [slots] that a record with this head has. */
static uint32_t slots_of(const rig_record_t *record)
{
    return events_at(record) + RECORDING_EVENT * RECORDING_EVENTS + 2u * RECORDING_SNAPSHOT;
}

/* false: the slots do not have the sizes that they state. */
static bool is_complete(rig_t *rig, const rig_record_t *record, uint32_t count)
{
    char text[sizeof rig->error];
    const uint32_t needed = slots_of(record);
    if (record->rows <= RECORDING_ROWS && record->slots == needed && count == needed) {
        return true;
    }
    snprintf(text, sizeof text, "%lu slots with %lu periods: accepted: %lu slots, with at most %lu periods",
             (unsigned long)count, (unsigned long)record->rows, (unsigned long)needed,
             (unsigned long)RECORDING_ROWS);
    return refuse(rig, text);
}

static void restore(rig_t *rig, const uint32_t *slots)
{
    app_t *to = &rig->state.app;
    rig_replay_t *replay = &rig->replay;
    memcpy(&to->drive, &slots[1], sizeof(uint32_t) * RECORDING_STATE);
    memcpy(&to->active, &slots[1u + RECORDING_STATE], sizeof to->active);
    memcpy(&to->assumed, &slots[1u + RECORDING_STATE + RECORDING_PARAMS], sizeof to->assumed);
    to->staged = to->active;
    drive_prepare(&to->drive.tunings[to->drive.in_force], &to->active, &to->assumed);
    to->drive.log.count = to->drive.medium.faults;
    capture_tuning_t history; /* the signals of the last periods, for a debugger */
    (void)capture_prepare(&signals_history, &signals_table, &history);
    capture_init(&to->drive.capture, &history);
    to->drive.record.on = 1u; /* the checksum of the parameters continues to be checked */
    rig->state.period = to->drive.fast.period;
    replay->on = true;
    replay->begin = to->drive.fast.period;
    replay->event = slots[0];
    replay->done = to->drive.done;
    replay->opens = to->drive.opens;
}

/* The snapshot with which a replay begins: the older one, if it is usable. NULL: none is. */
static const uint32_t *first_snapshot(const rig_replay_t *replay)
{
    const bool usable[2] = {is_usable(replay, 0u), is_usable(replay, 1u)};
    const uint32_t older =
        period_of(snapshot(replay, 0u)) - period_of(snapshot(replay, 1u)) < UINT32_MAX / 2u ? 1u : 0u;
    return usable[older] ? snapshot(replay, older) : usable[older ^ 1u] ? snapshot(replay, older ^ 1u) : NULL;
}

bool rig_record_value(const uint32_t *slots, uint32_t count, const table_row_t *row, double *value)
{
    rig_replay_t replay = {.slots = slots};
    rig_record_head(slots, &replay.record);
    const bool whole = replay.record.layout == recording_layout() && replay.record.rows <= RECORDING_ROWS &&
                       count == slots_of(&replay.record);
    const uint32_t *from = whole ? first_snapshot(&replay) : NULL;
    if (from == NULL || table_by_id(&params_table, row->id) != row ||
        row->offset == offsetof(params_t, line_key)) {
        return false;
    }
    *value = rig_row_get(row, &from[1u + RECORDING_STATE]);
    return true;
}

bool rig_replay_begin(rig_t *rig, const uint32_t *slots, uint32_t count)
{
    rig_replay_t *replay = &rig->replay;
    *replay = (rig_replay_t){.slots = slots};
    rig_bind(rig);
    if (count < (uint32_t)RECORDING_HEAD) {
        return refuse(rig, "a record without head: it is cut");
    }
    rig_record_head(slots, &replay->record);
    if (!is_of_this_program(rig, &replay->record) || !is_complete(rig, &replay->record, count)) {
        return false;
    }
    const uint32_t *from = first_snapshot(replay);
    if (from == NULL) {
        return refuse(rig,
                      "no complete snapshot of the state before the trigger: the trigger came within some "
                      "milliseconds of the start or of a reset, or more than 64 values were changed; a "
                      "replay cannot begin");
    }
    params_error_t why;
    params_t params;
    memcpy(&params, &from[1u + RECORDING_STATE], sizeof params);
    if (!params_check(&params, &why)) {
        return refuse(rig,
                      "the recorded parameters are not a set that the drive accepts: the record is damaged");
    }
    restore(rig, from);
    return true;
}

/* ---- one period ---- */

static void offer(rig_t *rig)
{
    app_t *to = &rig->state.app;
    drive_prepare(drive_idle_tuning(&to->drive), &to->staged, &to->assumed);
    drive_offer(&to->drive);
    to->active = to->staged;
    rig->replay.tunings++;
}

static void change(rig_t *rig, uint32_t what, uint32_t bits)
{
    app_t *to = &rig->state.app;
    const table_row_t *row = table_by_id(&params_table, what);
    if (what == RECORDING_WITHDRAWN) {
        drive_withdraw(&to->drive);
        to->staged = to->active;
    } else if (what == RECORDING_OFFERED) {
        offer(rig);
    } else if (what == RECORDING_REPORTED) {
        to->drive.medium.background.reported = bits;
    } else if (what - RECORDING_ASSUMED_AT < ASSUMED_SLOTS) {
        memcpy((char *)&to->assumed + sizeof bits * (what - RECORDING_ASSUMED_AT), &bits, sizeof bits);
    } else if (row != NULL) {
        table_set_bits(row, &to->staged, bits);
    } else if ((row = table_by_id(&requests_table, what)) != NULL) {
        table_set_bits(row, &to->drive.requests, bits);
        rig->replay.requests++;
    }
}

/* The external changes after the sample of this period. */
static void change_after(rig_t *rig, uint32_t period)
{
    rig_replay_t *replay = &rig->replay;
    while (replay->event != replay->slots[RECORDING_HEAD_EVENTS]) {
        const uint32_t *event =
            replay->slots + events_at(&replay->record) + RECORDING_EVENT * (replay->event % RECORDING_EVENTS);
        if (event[0] != period && event[0] - replay->begin < UINT32_MAX / 2u) {
            return;
        }
        change(rig, event[1], event[2]);
        replay->event++;
    }
}

/* Runs the medium task at once. Its results are passed to the same step as in the record. */
static void run_medium(rig_t *rig)
{
    drive_t *drive = &rig->state.app.drive;
    rig_replay_t *replay = &rig->replay;
    const uint32_t done = drive->done;
    const int32_t opens = drive->opens;
    drive_medium_step(drive);
    replay->done = drive->done;
    replay->opens = drive->opens;
    replay->windows++;
    drive->done = done;
    drive->opens = opens;
}

static void show_medium(rig_t *rig)
{
    drive_t *drive = &rig->state.app.drive;
    if (drive->done != rig->replay.done) {
        drive->done = rig->replay.done;
        drive->opens = rig->replay.opens;
    }
}

bool rig_replay_step(rig_t *rig)
{
    rig_replay_t *replay = &rig->replay;
    rig_state_t *state = &rig->state;
    drive_t *drive = &state->app.drive;
    const uint32_t before = drive->fast.period;
    const uint32_t *row = row_of(replay, before + 1u);
    if (row == NULL) {
        return false;
    }
    const uint32_t came = row[0] >> RECORD_CAME_PLACE;
    rig_bind(rig);
    if ((came & RECORD_CAME_SETPOINT) != 0u) {
        show_medium(rig);
    }
    change_after(rig, before);
    if ((came & RECORD_CAME_BACKGROUND) != 0u) {
        drive_heartbeat(drive, drive->medium.background.reported);
    }
    if ((came & RECORD_CAME_TRIP) != 0u) {
        app_trip();
    }
    /* the chip's clock does not move: each period begins now */
    state->start = chip_now(&state->chip) - RIG_PERIOD_TICKS * state->period;
    if (rig->stop_hook_set && rig->stop_hook_period == state->period) {
        rig_stop_at(rig, state->period);
    }
    app_read_again(row, &replay->samples);
    app_interrupt();
    if (replay->due) {
        run_medium(rig);
    }
    replay->periods++;
    if (!replay->differs && drive->record.slots[RECORD_CODES] != row[RECORD_CODES]) {
        replay->differs = true;
        replay->wrong = drive->fast.period;
    }
    state->period++;
    if (rig->tap_sink != NULL && (state->period - 1u) % rig->tap_every == 0u) {
        uint32_t slots[RIG_TAP_MAX];
        tap_copy(rig->tap_offsets, rig->tap_count, state, slots);
        rig->tap_sink(rig->tap_context, state->period - 1u, slots, rig->tap_count);
    }
    return true;
}

rig_replayed_t rig_replayed(const rig_t *rig)
{
    const rig_replay_t *replay = &rig->replay;
    const drive_t *drive = &rig->state.app.drive;
    const bool fault = drive->fault.reason != (int32_t)REASON_NONE;
    return (rig_replayed_t){
        .begin = replay->begin,
        .periods = replay->periods,
        .windows = replay->windows,
        .tunings = replay->tunings,
        .requests = replay->requests,
        .differs = replay->differs,
        .wrong = replay->wrong,
        .reason = fault ? drive->fault.reason : (int32_t)REASON_NONE,
        .fault_period = fault ? drive->fault.period : 0u,
    };
}
