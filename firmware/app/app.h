/* The only place where firmware meets hal: reset, the three interrupts, the background loop.
 *
 * `app` is the application of the chip that runs: one on silicon, one per thread on the desk, where the rig
 * points it at the chip whose turn it is. */
#ifndef APP_APP_H
#define APP_APP_H

#include <stdbool.h>
#include <stdint.h>

#include "app/self_watch.h"
#include "app/services.h"
#include "app/talk.h"
#include "drive/drive.h"
#include "hal/hal.h"

/* What the background knows of the drive: copied whole between two interrupts. */
typedef struct {
    uint32_t period;      /* [periods] */
    int32_t state;        /* [-] drive_state_t */
    int32_t fault_reason; /* [-] reason_t */
    learnt_t learnt;
    uint32_t bridge_on; /* [-] 1 */
} app_seen_t;

typedef struct {
    drive_t drive;
    params_t staged;      /* written value by value from outside; app_apply makes it the active set */
    params_t active;      /* what the drive runs on, or takes with the end of its window */
    believed_t believed;  /* of motor and inverter, what the newest tuning was made with */
    uint32_t believed_at; /* [periods] of the drive when that was */
    int32_t board_status; /* [-] hal_status_t of the start */
    app_seen_t seen;      /* of the last look */
    uint32_t task;        /* [-] of the background list: the next one's number */
    uint32_t fed_period;  /* [periods] of the drive when the watchdog was last fed */
    uint32_t watched_at;  /* [periods] of the drive when memory was last looked at */
    self_watch_t watch;
    services_t services;
    talk_t talk;
} app_t;

extern HAL_PER_CHIP app_t *app;

/* After reset: stored parameters, or the defaults (app/parameters.h), board up, watchdog started; from here
 * on the interrupt runs every period and app_background must be called again and again, each task of its list
 * at least every 100 ms. If the board does not come up, the drive is in fault. */
void app_start(void);

/* The background: the next task of its list, each of bounded work. The watchdog is fed when the list has come
 * round and the interrupt with it: a drive whose interrupt or background has stopped is reset, and with it
 * the gates open. */
void app_background(void);

/* The interrupts: of the sample, every period; of the medium task, once in a window, which the other two may
 * interrupt; and of the power module's fault line. */
HAL_INTERRUPT void app_interrupt(void);
HAL_INTERRUPT void app_medium(void);
HAL_INTERRUPT void app_trip(void);

/* The two ends of the sample interrupt; the drive's step goes between them. A caller with better samples than
 * the board's (the simulation's ideal sensors) makes the same three calls and changes the samples after the
 * first. app_read: this period's conversions, encoder and flags, turned from counts into SI; once per period,
 * for it clears what the flags tell of. app_write: duties, rounded to whole counts, to the compare registers,
 * where they wait for the next carrier zero; gates; and the interrupt is acknowledged, so it comes last. */
void app_read(drive_samples_t *samples);
void app_write(const drive_command_t *command);

/* From the background: judge the staged set, prepare its tuning and offer that to the interrupt, which takes
 * it with the end of its window. Interrupts are off only for the offer. false: the old set runs on, `why`
 * says what was wrong. */
bool app_apply(params_error_t *why);

/* From the background: judge a set of requests and take it over between two interrupts. */
bool app_request(const requests_t *requests, params_error_t *why);

#endif
