/* The only place where the firmware uses hal: reset, the three interrupts, the background loop.
 *
 * `app` is the application of the chip that runs: one on the target, one per thread in the host simulation,
 * where the rig sets it to the chip that is executed. */
#ifndef APP_APP_H
#define APP_APP_H

#include <stdbool.h>
#include <stdint.h>

#include "app/keeping.h"
#include "app/recording.h"
#include "app/self_watch.h"
#include "app/services.h"
#include "app/talk.h"
#include "drive/drive.h"
#include "hal/hal.h"

/* The state of the drive for the background: copied as a whole between two interrupts. */
typedef struct {
    uint32_t period;      /* [periods] */
    int32_t state;        /* [-] drive_state_t */
    int32_t fault_reason; /* [-] reason_t */
    learnt_t learnt;
    uint32_t bridge_on; /* [-] 1 */
} app_seen_t;

typedef struct {
    drive_t drive;
    params_t staged;      /* clients write single values into it; app_apply makes it the active set */
    params_t active;      /* the set in use, or the one that the drive takes over at the end of its window */
    assumed_t assumed;    /* assumed values of motor and inverter with which the newest tuning was made */
    uint32_t assumed_at;  /* [periods] time of the drive when `assumed` was made */
    int32_t board_status; /* [-] hal_status_t of the board's start */
    app_seen_t seen;      /* at the time of the last copy */
    uint32_t task;        /* [-] number of the next task in the background list */
    uint32_t fed_period;  /* [periods] time of the drive when the watchdog was last served */
    uint32_t watched_at;  /* [periods] time of the drive when memory was last checked */
    self_watch_t watch;
    recording_t recording;
    services_t services;
    talk_t talk;
#if BOARD_STORE == BOARD_STORE_I2C
    keeping_t keeping;
#endif
} app_t;

extern HAL_PER_CHIP app_t *app;

/* After reset: loads the stored parameters or the defaults (app/parameters.h), initialises the board,
 * starts the watchdog; from here on the interrupt runs every period and app_background must be called
 * continuously, so that each task of its list runs at least every 100 ms. If the board's
 * initialisation fails, the drive is in fault. */
void app_start(void);

/* The background: the next task of its list, each with a bounded duration. The watchdog is served when all
 * tasks of the list have run and the interrupt has run since then: if the interrupt or the background stops,
 * the controller is reset and the gates open. */
void app_background(void);

/* The interrupts: one for the sample, in every period; one for the medium task, once per window, which the
 * others may interrupt; one for the fault line of the power module; and one for octets on the serial line. */
HAL_INTERRUPT void app_interrupt(void);
HAL_INTERRUPT void app_medium(void);
HAL_INTERRUPT void app_trip(void);
HAL_INTERRUPT void app_serial(void);

/* The two ends of the sample interrupt; the drive's step runs between them. A caller with better samples than
 * the board's (the simulation's ideal sensors) makes the same three calls and changes the samples after the
 * first. app_read: this period's conversions, encoder and flags, converted from counts to SI units; call it
 * once per period, because it clears the causes of the flags. app_write: writes the duties, rounded to whole
 * counts, to the compare registers, where they wait for the next carrier zero, and the gates; it acknowledges
 * the interrupt, so it comes last. */
void app_read(drive_samples_t *samples);
void app_write(const drive_command_t *command);

/* The sample of a recorded period (drive/record.h), converted as app_read does it. For a replay. */
void app_read_again(const uint32_t codes[RECORD_CODES], drive_samples_t *samples);

/* From the background: judges the staged set, prepares its tuning and offers the tuning to the interrupt,
 * which takes it over at the end of its window. Interrupts are off only for the offer. false: the old set
 * stays in use, `why` gives the error. */
bool app_apply(params_error_t *why);

/* From the background: judges a set of requests and takes it over between two interrupts. */
bool app_request(const requests_t *requests, params_error_t *why);

#endif
