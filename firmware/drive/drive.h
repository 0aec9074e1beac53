/* The drive: one step per PWM period turns samples into a command. Pure: no registers, no globals.
 *
 *     samples --> measure --> estimate (encoder, estimator) --> guard --> sequence --> manoeuvre: demand
 *             --> current control --> inverter: duties
 *
 * each in a room of its own.
 *
 * Timing (docs/theory.md, 2): the step of period k gets the currents and the encoder at t_k; the duties it
 * returns act on [t_{k+1}, t_{k+2}). The dq voltage is therefore turned into the stationary frame at theta_e
 * + 1.5 T_s omega_e of the frame in force, and the estimator gets the voltage that the duties of two steps
 * ago made (inverter/inverter.h).
 *
 * Position: the encoder or the estimator, as position_source says. With the encoder the estimator runs beside
 * it from the encoder's angle; without, nothing of the encoder is used, and a manoeuvre brings the rotor to
 * where its EMF can be tracked (drive/manoeuvres.h). Control turns with the frame that the manoeuvre gives.
 *
 * Parameters change by a flip: the background prepares the tuning of a new set and offers it; the interrupt
 * takes it whole at the start of its next step. */
#ifndef DRIVE_DRIVE_H
#define DRIVE_DRIVE_H

#include <stdbool.h>
#include <stdint.h>

#include "contract/capture.h"
#include "drive/guard.h"
#include "drive/manoeuvres.h"
#include "drive/measure.h"
#include "drive/requests.h"
#include "drive/sequence.h"
#include "drive/tuning.h"
#include "estimator/estimate.h"
#include "manoeuvre/demand.h"
#include "math/frames.h"
#include "protect/encoder_watch.h"
#include "protect/motion_watch.h"
#include "protect/oscillation_watch.h"

typedef struct {
    abc_t duty;    /* [-] 0..1, high time of each leg over the period; acts from t_{k+1} */
    int32_t gates; /* [-] drive_gates_t */
} drive_command_t;

/* What the drive saw when it stopped: the first fault freezes it. */
typedef struct {
    int32_t reason;    /* [-] reason_t */
    uint32_t period;   /* [periods] when */
    int32_t manoeuvre; /* [-] manoeuvre_t: what it was about */
    float i_a, i_b;    /* [A] */
    float u_dc;        /* [V] */
    float theta_e;     /* [rad] */
    float omega_e;     /* [rad/s] */
} drive_fault_t;

/* The last of them, through resets. */
#define DRIVE_FAULT_LOG 16u
typedef struct {
    uint32_t count;                        /* [-] since power-on */
    drive_fault_t faults[DRIVE_FAULT_LOG]; /* number n from 0 in n mod DRIVE_FAULT_LOG */
} drive_fault_log_t;

typedef struct {
    /* what goes from room to room in a period; first, where an offset is short */
    uint32_t period;             /* [periods] the one clock */
    position_t encoder_position; /* at t_k, of the encoder */
    frame_t encoder_frame;       /* the same, while control turns with it */
    uint32_t estimating;         /* [-] 1: the estimator runs */
    ab_t acted;                  /* [V] on the winding in [t_{k-1}, t_k) */
    float emf_shape_voltage; /* [V] amplitude of the EMF's shape, which the estimator does not get of it */
    float dead_voltage;      /* [V] that a leg loses at the link of that time */
    frame_t rotor;           /* as it is believed at t_k */
    float omega_m;           /* [rad/s] mechanical, of the rotor */
    demand_t demand;         /* with the frame in force */
    dq_t current;            /* [A] in that frame */
    dq_t voltage;            /* [V] what the inverter will really apply, dead time accounted for */
    drive_command_t command;
    drive_fault_t fault;
    uint32_t learns; /* [-] 1: something is learnt by drive_learn() */

    /* from outside */
    requests_t requests;

    /* rooms */
    measure_t measure;
    encoder_t encoder;
    inverter_t inverter;
    doubt_t doubt;
    flux_t flux;
    offset_trim_t offset_trim;
    current_control_t current_control;
    sequence_t sequence;
    chosen_t estimator;
    manoeuvres_t manoeuvres;
    guard_t guard;
    sums_t sums;
    means_t means;
    inductance_t inductance;
    inertia_t inertia;
    dead_time_learn_t dead_time_learn;
    emf_shape_t emf_shape;
    unequal_legs_t unequal_legs;
    float emf_shape_share; /* [-] of the shape learnt that emf_shape_voltage is */
    encoder_watch_t encoder_watch;
    motion_watch_t motion_watch;
    oscillation_watch_t oscillation_watch;
    uint32_t encoder_wrong; /* [-] ENCODER_WATCH_... bits of the last look */
    uint32_t moves_wrong;   /* [-] MOTION_... bits likewise */
    current_watch_t current_watch;
    uint32_t current_faults; /* [-] CURRENT_WATCH_... bits of the last window */
    thermal_t thermal;
    link_t link;
    uint32_t coasting; /* [-] 1: the bridge is off because the supply is lost, and comes on again with it */

    /* offered by the background: taken at the start of the next step */
    uint32_t offered; /* [-] 1: there is one */
    drive_tuning_t offer;

    uint32_t
        unattended; /* [periods] since the background came round, from its first time on; 0: it never did */
    uint32_t unattended_max; /* [periods] that it may stay away */
    uint32_t reported;       /* [-] GUARD_CORRUPT_... and other bits, as the background has found */
    drive_fault_log_t log;
    capture_t capture; /* unless armed for something else: the rows of signals_history; a fault holds it, its
                          own period is the newest; a reset empties it */
} drive_t;

/* All state zero, in not ready, requests off. The set must be good (checked). */
void drive_init(drive_t *drive, const params_t *params);

/* Between two periods: the tuning that the background has prepared in drive->offer is taken at the start of
 * the next step. Control states are kept, so a running drive goes on smoothly. While one is offered, `offer`
 * must not be written: drive_withdraw() first. */
void drive_offer(drive_t *drive);
void drive_withdraw(drive_t *drive);

/* The rotor at t_k, from encoder and estimator. While the bridge is off nothing is known of the voltage: the
 * estimator rests. */
void drive_locate(drive_t *drive);

/* drive->rotor and drive->omega_m, after the source of the angle has changed. */
void drive_believe(drive_t *drive);

/* Which of GUARD_LOOK_PERIODS motion is looked at in: none in which something is learnt, shortly before the
 * slow rows are judged. */
#define DRIVE_MOTION_SLOT 1u

/* What the motion of the rotor says of encoder and shaft: drive->encoder_wrong and moves_wrong. An encoder
 * that is wrong is left here. In the slot, and wherever the encoder's angle has jumped. */
void drive_watch_motion(drive_t *drive, bool in_slot, bool jumped);

/* The same of what is learnt, where something is: sums in every period, means in every
 * DRIVE_LEARN_PERIODS-th, of periods in which this acted. No division but at the end of a cycle of the
 * dither or of a way. */
/* What is learnt of the legs, for the voltage that acts from now on. */
void drive_set_legs(drive_t *drive);

void drive_learn(drive_t *drive, const inverter_acted_t *acted);

/* Nothing is known of what acts. */
void drive_learn_pause(drive_t *drive);

/* The rows of the fault table that hold in this period. */
void drive_protect(drive_t *drive);

/* Likewise, where one may hold; `look`: of the slow ones, too. */
void drive_judge(drive_t *drive, bool look);

/* What heat and DC link leave of i_q; `look`: in a period in which the slow rows are judged, where in turn
 * the squares of the currents and the supply are looked at. */
void drive_limit(drive_t *drive, bool look);

/* The start of a step with an offer, whose sample has this encoder count, and the end of one that has led
 * into fault. */
void drive_take(drive_t *drive, uint32_t encoder_count);
void drive_note_fault(drive_t *drive);

/* What it has learnt so far, between two periods. */
learnt_t drive_learnt(const drive_t *drive);

/* The background has come round, between two periods; `reported`: what it has found. */
static inline void drive_attend(drive_t *drive, uint32_t reported)
{
    drive->unattended = 1u;
    drive->reported = reported;
}

/* Take over a set of requests between two periods; it must be good (requests_check). */
void drive_request(drive_t *drive, const requests_t *next);

/* One period, in the interrupt. Bounded, no libm; one division each of observer and modulator, one more when
 * the voltage is limited. */
void drive_step(drive_t *drive, const drive_samples_t *samples, drive_command_t *command);

/* From the trip interrupt: the hardware has shut the gates. Goes to fault at once if the bridge was on; a
 * power module that pulls its line while the gates are off anyway (its supply comes up) is no fault. */
void drive_trip(drive_t *drive);

/* Latch a fault from outside the step: the board did not come up. */
void drive_stop(drive_t *drive, int32_t reason);

/* Are the gates on, or coming on? */
static inline bool drive_bridge_on(const drive_t *drive)
{
    return sequence_bridge_on(&drive->sequence);
}

#endif
