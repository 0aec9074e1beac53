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

#include "contract/tap.h"
#include "drive/guard.h"
#include "drive/manoeuvres.h"
#include "drive/measure.h"
#include "drive/requests.h"
#include "drive/sequence.h"
#include "drive/tuning.h"
#include "estimator/estimate.h"
#include "manoeuvre/demand.h"
#include "math/frames.h"

typedef struct {
    abc_t duty;    /* [-] 0..1, high time of each leg over the period; acts from t_{k+1} */
    int32_t gates; /* [-] drive_gates_t */
} drive_command_t;

/* What the drive saw when it stopped: the first fault freezes it. */
typedef struct {
    uint32_t period; /* [periods] when */
    float i_a, i_b;  /* [A] */
    float u_dc;      /* [V] */
    float theta_e;   /* [rad] */
    float omega_e;   /* [rad/s] */
} drive_fault_t;

typedef struct {
    /* what goes from room to room in a period; first, where an offset is short */
    uint32_t period;             /* [periods] the one clock */
    position_t encoder_position; /* at t_k, of the encoder */
    frame_t encoder_frame;       /* the same, while control turns with it */
    uint32_t estimating;         /* [-] 1: the estimator runs */
    ab_t acted;                  /* [V] on the winding in [t_{k-1}, t_k), as the estimator got it */
    float dead_voltage;          /* [V] that a leg loses at the link of that time */
    frame_t rotor;               /* as it is believed at t_k */
    float omega_m;               /* [rad/s] mechanical, of the rotor */
    demand_t demand;             /* with the frame in force */
    dq_t current;                /* [A] in that frame */
    dq_t voltage;                /* [V] what the inverter will really apply, dead time accounted for */
    drive_command_t command;
    drive_fault_t fault;

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
    inductance_t inductance;
    inertia_t inertia;
    dead_time_learn_t dead_time_learn;

    /* offered by the background: taken at the start of the next step */
    uint32_t offered; /* [-] 1: there is one */
    drive_tuning_t offer;

    tap_history_t history; /* a fault holds it: its own period is the newest; a reset empties it */
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

/* The start of a step with an offer, whose sample has this encoder count, and the end of one that has led
 * into fault. */
void drive_take(drive_t *drive, uint32_t encoder_count);
void drive_note_fault(drive_t *drive);

/* What it has learnt so far, between two periods. */
learnt_t drive_learnt(const drive_t *drive);

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
