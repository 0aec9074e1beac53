/* The state of a rig: chip, plant, drive, random generators, clock. It determines every later bit. It can be
 * copied with memcpy, and has no pointers; its only padding is a word at the end if the number of slots is
 * odd, which is always zero. Tap, stop condition and texts are not part of it. */
#ifndef HOST_SIM_RIG_RIG_STATE_H
#define HOST_SIM_RIG_RIG_STATE_H

#include "app/app.h"
#include "host_sim/chip/chip.h"
#include "host_sim/plant/plant.h"
#include "host_sim/rig/rig.h"
#include "host_sim/rig/rig_tables.h"

/* [periods] largest duration of an interrupt, including the present period: 20 times its tracked cost at 75
 * MHz is 440 us, nine periods of a carrier of 20 kHz */
#define RIG_AHEAD 16u

typedef struct {
    chip_t chip;
    plant_t plant;
    uint64_t start;           /* [ticks] t_0: carrier zero of period 0; */
    uint64_t background_next; /* [ticks] earliest next run of the background */
    uint64_t medium_begin;    /* [ticks] the medium task began */
    uint64_t medium_until;    /* [ticks] earliest end of the medium task; 0: it has ended */
    uint32_t medium_done;     /* [windows] its drive_t.done from then on */
    int32_t medium_opens;     /* [-] its drive_t.opens from then on */
    int64_t encoder_moved;    /* [counts] changed by rig_set_motion, without edges of the tracks */
    double supplied;          /* [A s] `supplied` of the plant at the last t_k */
    app_t app;
    rig_plant_t plant_values; /* last argument of plant_set_params */
    rig_conditions_t conditions;
    rig_truth_t truth;            /* at t_k of the last period */
    rig_truth_t ahead[RIG_AHEAD]; /* at t_k of period k, in k mod RIG_AHEAD */
    uint32_t begun;               /* [periods] number of periods whose t_k has been stored in `ahead` */
    uint32_t period;              /* [periods] run so far */
    uint32_t fault_line;          /* [-] 1: the power module pulls the trip pin low */
} rig_state_t;

/* For tests that read or change the state. */
rig_state_t *rig_state(rig_t *rig);

/* Runs the first ticks of the next period, at most all of them; the next rig_step runs the rest. For events
 * between two t_k. */
void rig_step_part(rig_t *rig, uint64_t ticks);

/* Connects the registers and the firmware of this thread to the chip and the application of this rig.
 * rig_step does this. */
void rig_bind(rig_t *rig);

/* The start after power-on, or after a debugger's restart: variables zero, main() up to its loop. Period 0
 * begins when the function returns. rig_create does this. */
void rig_start(rig_t *rig);

#endif
