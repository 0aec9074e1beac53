/* The code outside the interrupts: the start, the background list, changes by clients. */
#include "app/app.h"

#include "settings/reasons.h"

#define LEARN_PERIODS DRIVE_PERIODS(10e-3f)  /* least time from one tuning to the next */
#define WATCH_PERIODS DRIVE_PERIODS(0.4e-3f) /* least time from one slice of memory to the next */

/* Whole cycles, not less than the configured value. An excess of a thousandth of a cycle is ignored, because
 * the float may be too large by that. */
static uint16_t dead_band_of(const params_t *params)
{
    return (uint16_t)(params->dead_time * (float)HAL_CLOCK_HZ + 0.999f);
}

static uint32_t encoder_max_of(const params_t *params)
{
    return 4u * (uint32_t)params->encoder_lines - 1u;
}

void app_start(void)
{
    services_defaults(&app->services);
    const bool trusted = parameters_start();
    app->active = app->staged;
    app->assumed = params_configured(&app->active);
    self_watch_accept(&app->watch, &app->active);
    drive_init(&app->drive, &app->active);
    capturing_start();
    if (!trusted) { /* latched: the bridge stays off until a user has reset the fault */
        drive_stop(&app->drive, REASON_STORE_CORRUPT);
    }
    talk_start();
    const hal_config_t config = {
        .dead_band_count = dead_band_of(&app->staged),
        .encoder_count_max = encoder_max_of(&app->staged),
        .on_sample = app_interrupt,
        .on_medium = app_medium,
        .on_trip = app_trip,
        .on_serial = app_serial,
    };
    app->board_status = (int32_t)hal_init(&config);
    if (app->board_status != (int32_t)HAL_OK) {
        drive_stop(&app->drive, REASON_BOARD_FAILED);
        return;
    }
    hal_watchdog_start();
}

/* ---- the background list ---- */

static void look(void)
{
    const uint32_t reported = app->watch.found | (app->talk.silent != 0u ? GUARD_MASTER_SILENT : 0u);
    hal_interrupts_off();
    app->seen = (app_seen_t){
        .period = app->drive.fast.period,
        .state = app->drive.state,
        .fault_reason = app->drive.fault_reason,
        .learnt = drive_learnt(&app->drive),
        .bridge_on = drive_bridge_on(&app->drive) ? 1u : 0u,
    };
    if (reported != app->drive.medium.background.reported) {
        recording_event(RECORDING_REPORTED, reported);
    }
    drive_heartbeat(&app->drive, reported);
    hal_interrupts_on();
}

/* The store itself is a single access. Interrupts are off so that the change and its recorded event belong to
 * the same period. */
static void hold_for_record(void)
{
    if (app->drive.record.on != 0u) {
        hal_interrupts_off();
    }
}

static void go_on_for_record(void)
{
    if (app->drive.record.on != 0u) {
        hal_interrupts_on();
    }
}

/* Computes the tuning of a set with the assumed values and offers it: the only function that writes it. An
 * earlier tuning that has not been taken over yet is withdrawn. */
static void tune(const params_t *params, const assumed_t *assumed)
{
    app->assumed = *assumed;
    app->assumed_at = app->seen.period;
    hold_for_record();
    recording_event(RECORDING_WITHDRAWN, 0u);
    drive_withdraw(&app->drive); /* from here on the interrupt ignores the offer */
    go_on_for_record();
    recording_offer(params, assumed);
    drive_prepare(drive_idle_tuning(&app->drive), params, assumed);
}

/* The tuning is complete: the interrupt takes it over. With interrupts off. */
static void offer(void)
{
    recording_event(RECORDING_OFFERED, 0u);
    drive_offer(&app->drive);
}

/* The assumed values for a set: the learnt ones, or the set's own if it cannot run with the learnt ones. */
static assumed_t assumption(const params_t *params)
{
    const assumed_t learnt = drive_assumed(params, &app->seen.learnt);
    return drive_may_assume(params, &learnt) ? learnt : params_configured(params);
}

/* Makes a tuning from the learnt values if they have changed enough, and not too often. */
static void learn(void)
{
    const assumed_t next = drive_assumed(&app->active, &app->seen.learnt);
    if (app->seen.period - app->assumed_at >= LEARN_PERIODS && assumed_moved(&app->assumed, &next) &&
        drive_may_assume(&app->active, &next)) {
        tune(&app->active, &next);
        hal_interrupts_off();
        offer();
        hal_interrupts_on();
    }
}

static void watch(void)
{
    if (app->seen.period - app->watched_at >= WATCH_PERIODS) {
        app->watched_at = app->seen.period;
        self_watch_step(&app->watch, &app->active);
    }
}

static void show(void)
{
    hal_leds(app->seen.bridge_on != 0u, app->seen.state == (int32_t)DRIVE_FAULT);
    capturing_show();
    recording_step();
}

/* The last task: when it runs, all others have run, and the interrupt has run since the last time. */
static void feed(void)
{
    if (app->seen.period != app->fed_period) {
        app->fed_period = app->seen.period;
        hal_watchdog_feed();
    }
}

void app_background(void)
{
#if BOARD_STORE == BOARD_STORE_I2C
    static void (*const tasks[])(void) = {look, learn, watch, show, parameters_step, feed};
#else
    static void (*const tasks[])(void) = {look, learn, watch, show, feed};
#endif
    tasks[app->task]();
    app->task = (app->task + 1u) % (uint32_t)(sizeof tasks / sizeof tasks[0]);
    talk_step();
}

/* ---- changes by clients ---- */

bool app_apply(params_error_t *why)
{
    const params_t *next = &app->staged;
    if (!params_check(next, why)) {
        return false;
    }
    const bool live = params_check_live(&app->active, next, why);
    if ((!live && drive_bridge_on(&app->drive)) || !requests_check(&app->drive.requests, next, why)) {
        return false;
    }
    const uint16_t dead_band = dead_band_of(next);
    const uint32_t encoder_max = encoder_max_of(next);

    const assumed_t assumed = assumption(next);
    tune(next, &assumed);
    hal_interrupts_off();
    const bool bridge_on = drive_bridge_on(&app->drive);
    const bool taken = live || !bridge_on;
    if (taken) {
        offer();
        if (!bridge_on) { /* parameters that are written to registers change only while the bridge is off */
            (void)hal_set_dead_band(dead_band);
            (void)hal_set_encoder(encoder_max);
        }
    }
    hal_interrupts_on();
    if (taken) {
        const bool other = next->fault_record != app->active.fault_record;
        app->active = *next;
        self_watch_accept(&app->watch, &app->active);
        if (other) {
            capturing_restart();
        }
    } else {
        const assumed_t before = assumption(&app->active);
        tune(&app->active, &before); /* offers the active set again: an earlier offer may be withdrawn */
        hold_for_record();
        offer();
        go_on_for_record();
    }
    return taken;
}

bool app_request(const requests_t *requests, params_error_t *why)
{
    if (!requests_check(requests, &app->active, why)) {
        return false;
    }
    hal_interrupts_off();
    recording_requests(requests);
    drive_request(&app->drive, requests);
    hal_interrupts_on();
    return true;
}
