/* One state: chip, plant, drive, generators, clock. Copyable with memcpy, no pointers, no padding but a word
 * at the end where the slots are odd in number, zero from creation on: what is in here decides every bit of
 * the future; what is not (tap, stop condition, texts) belongs to who looks on. */
#ifndef HOST_SIM_RIG_RIG_STATE_H
#define HOST_SIM_RIG_RIG_STATE_H

#include "app/app.h"
#include "host_sim/chip/chip.h"
#include "host_sim/plant/plant.h"
#include "host_sim/rig/rig.h"
#include "host_sim/rig/rig_tables.h"

/* [periods] that an interrupt may run over, the present one among them: 20 times its tracked cost at 75 MHz
 * is 440 us, on a carrier of 20 kHz nine periods */
#define RIG_AHEAD 16u

typedef struct {
    chip_t chip;
    plant_t plant;
    uint64_t start;           /* [ticks] t_0: carrier zero of period 0; */
    uint64_t background_next; /* [ticks] the background may come round again */
    uint64_t medium_begin;    /* [ticks] the medium task began */
    uint64_t medium_until;    /* [ticks] the medium task is not through before; 0: it is */
    uint32_t medium_done;     /* [windows] its drive_t.done from then on */
    int32_t medium_opens;     /* [-] its drive_t.opens from then on */
    int64_t encoder_moved;    /* [counts] by rig_set_motion, of which the tracks show nothing */
    app_t app;
    rig_plant_t plant_values; /* what plant_set_params was last given */
    rig_conditions_t conditions;
    rig_truth_t truth;            /* at t_k of the last period */
    rig_truth_t ahead[RIG_AHEAD]; /* at t_k of period k, in k mod RIG_AHEAD */
    uint32_t begun;               /* [periods] whose t_k is in `ahead` or before it */
    uint32_t period;              /* [periods] run so far */
    uint32_t fault_line;          /* [-] 1: the power module pulls the trip pin low */
} rig_state_t;

/* For tests that look into or sabotage the inside. */
rig_state_t *rig_state(rig_t *rig);

/* Runs the first ticks of the next period, at most all of them; the next rig_step runs the rest. For
 * what happens between two t_k. */
void rig_step_part(rig_t *rig, uint64_t ticks);

/* Make this rig's chip and application the ones that registers and firmware of this thread mean. rig_step
 * does it. */
void rig_bind(rig_t *rig);

/* What follows power-on, and a debugger's restart: variables zero, main() up to its loop. Period 0 begins
 * when this returns. rig_create does it. */
void rig_start(rig_t *rig);

#endif
