#include "app/capturing.h"

#include "app/app.h"
#include "settings/reasons.h"

#define FIRST_ROW UINT32_C(1911) /* the writable rows, capture_on and the following ids in their order */
#define LAST_ROW  UINT32_C(1927)

static capture_wish_t wish_of(const services_t *services)
{
    return (capture_wish_t){
        .on = services->capture_on,
        .source = services->capture_source,
        .level = services->capture_level,
        .after = services->capture_after,
        .columns = services->capture_signals,
        .id = {services->capture_1, services->capture_2, services->capture_3, services->capture_4,
               services->capture_5, services->capture_6, services->capture_7, services->capture_8,
               services->capture_9, services->capture_10, services->capture_11, services->capture_12},
    };
}

/* The rows are in the order of the refusals. */
static bool refuse(uint32_t refusal, const capture_wish_t *wish, params_error_t *why)
{
    const table_row_t *row = table_by_id(&services_table, FIRST_ROW + refusal - (uint32_t)CAPTURE_BAD_ON);
    const bool late = refusal == (uint32_t)CAPTURE_BAD_AFTER;
    (void)params_refuse(why, row->name, late ? "capture_after < periods that fit" : "id of a signal",
                        table_get(row, &app->services), table_min(row),
                        late ? (float)(capture_room(wish->columns) - 1u) : table_max(row));
    why->id = row->id;
    why->reason = late ? REASON_CROSS_RULE : REASON_UNKNOWN_ID;
    return false;
}

bool capturing_arm(params_error_t *why)
{
    capture_tuning_t tuning;
    const capture_wish_t wish = wish_of(&app->services);
    const uint32_t refusal = capture_prepare(&wish, &signals_table, &tuning);
    if (refusal != (uint32_t)CAPTURE_GOOD) {
        return refuse(refusal, &wish, why);
    }
    hal_interrupts_off();
    app->drive.record.on = 0u;
    capture_arm(&app->drive.capture, &tuning);
    hal_interrupts_on();
    capturing_show();
    return true;
}

void capturing_trigger(void)
{
    hal_interrupts_off();
    capture_trigger(&app->drive.capture, app->drive.fast.period);
    hal_interrupts_on();
    capturing_show();
}

/* The content that fault_record selects. */
static capture_tuning_t usual(void)
{
    if (app->active.fault_record == (int32_t)FAULT_RECORD_REPLAY) {
        return recording_tuning();
    }
    capture_tuning_t tuning = app->drive.capture.tuning;
    (void)capture_prepare(&signals_history, &signals_table, &tuning);
    return tuning;
}

static void start_usual(const capture_tuning_t *tuning)
{
    app->recording.whole[0] = 0u;
    app->recording.whole[1] = 0u;
    app->drive.record.on =
        app->active.fault_record == (int32_t)FAULT_RECORD_REPLAY ? UINT32_C(1) : UINT32_C(0);
    capture_release(&app->drive.capture, tuning);
}

void capturing_start(void)
{
    const capture_tuning_t tuning = usual();
    start_usual(&tuning);
}

void capturing_restart(void)
{
    const capture_tuning_t tuning = usual();
    if (app->drive.capture.asked == 0u) {
        hal_interrupts_off();
        start_usual(&tuning);
        hal_interrupts_on();
    }
}

void capturing_release(void)
{
    const capture_tuning_t tuning = usual();
    hal_interrupts_off();
    start_usual(&tuning);
    hal_interrupts_on();
    for (uint32_t id = FIRST_ROW; id <= LAST_ROW; id++) {
        table_default(table_by_id(&services_table, id), &app->services);
    }
    capturing_show();
}

void capturing_show(void)
{
    const capture_t *capture = &app->drive.capture;
    services_t *services = &app->services;
    services->capture_state = (int32_t)capture->state; /* first: if "held", the other rows are final */
    services->capture_periods = capture_count(capture);
    services->capture_at = capture->at;
    services->capture_content = (int32_t)app->drive.record.on;
}

bool capturing_slot(uint32_t number, uint32_t *bits)
{
    const capture_t *capture = &app->drive.capture;
    const uint32_t columns = capture->tuning.columns;
    if (capture->state == (uint32_t)CAPTURE_HELD && app->drive.record.on != 0u) {
        return recording_slot(number, bits);
    }
    if (capture->state != (uint32_t)CAPTURE_HELD || number >= columns * capture_count(capture)) {
        return false;
    }
    *bits = capture_row(capture, number / columns)[number % columns];
    return true;
}
