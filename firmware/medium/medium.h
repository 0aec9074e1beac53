/* The medium task, once per window of DRIVE_WINDOW periods, 1.25 kHz: it reads
 * a window and writes a setpoint.
 *
 *     window --> learn --> watch --> limit --> guard --> sequence --> commission --> manoeuvre --> setpoint
 *
 * It reads the window and writes its own setpoint, and uses nothing else of the fast task. The setpoint of
 * window n acts from the first period of window n + 2 on, for any execution time: the result does not depend
 * on when the task runs, and it may be interrupted anywhere. */
#ifndef MEDIUM_MEDIUM_H
#define MEDIUM_MEDIUM_H

#include <stdbool.h>
#include <stdint.h>

#include "estimator/validity.h"
#include "fast/window.h"
#include "guard/guard.h"
#include "medium/adapt/angle_sigma.h"
#include "medium/adapt/assumed.h"
#include "medium/adapt/dead_time_learn.h"
#include "medium/adapt/emf_shape.h"
#include "medium/adapt/flux.h"
#include "medium/adapt/inductance.h"
#include "medium/adapt/inertia.h"
#include "medium/adapt/leg_zone.h"
#include "medium/adapt/offset_trim.h"
#include "medium/adapt/sums.h"
#include "medium/adapt/unequal_legs.h"
#include "medium/commission/commission.h"
#include "medium/manoeuvre/manoeuvres.h"
#include "medium/protect/chopper_watch.h"
#include "medium/protect/current_watch.h"
#include "medium/protect/encoder_watch.h"
#include "medium/protect/holding_brake.h"
#include "medium/protect/link_watch.h"
#include "medium/protect/motion_watch.h"
#include "medium/protect/oscillation_watch.h"
#include "medium/protect/supply_limit.h"
#include "medium/protect/thermal.h"
#include "medium/sequence.h"
#include "settings/requests.h"

/* Brake chopper and holding brake. */
typedef struct {
    chopper_watch_tuning_t chopper;
    holding_brake_tuning_t brake;
    float preload; /* torque before the brake is released [N m] */
    float stiff;   /* factor on the bandwidth of the speed control while it is released [-] */
} medium_outputs_tuning_t;

typedef struct {
    guard_tuning_t guard;
    uint32_t unattended_max; /* [periods] longest time without the background while the motor runs */
    sequence_tuning_t sequence;
    validity_tuning_t validity;
    flux_tuning_t flux;
    offset_trim_tuning_t offset_trim;
    inductance_tuning_t inductance;
    inertia_tuning_t inertia;
    dead_time_learn_tuning_t dead_time_learn;
    emf_shape_tuning_t emf_shape;
    unequal_legs_tuning_t unequal_legs;
    angle_sigma_tuning_t angle_sigma;
    inertia_shares_t load; /* how the load of the fast task follows i_q */
    manoeuvres_tuning_t manoeuvres;
    encoder_watch_tuning_t encoder_watch;
    motion_watch_tuning_t motion_watch;
    oscillation_watch_tuning_t oscillation_watch;
    current_watch_tuning_t current_watch;
    thermal_tuning_t thermal;
    link_watch_tuning_t link;
    supply_limit_tuning_t supply;
    medium_outputs_tuning_t outputs;
    commission_tuning_t commission;
    params_in_force_t in_force;
} medium_tuning_t;

/* The results of the watches in the last window. */
typedef struct {
    uint32_t encoder_wrong;  /* [-] ENCODER_WATCH_... bits */
    uint32_t moves_wrong;    /* [-] MOTION_... bits */
    uint32_t current_faults; /* [-] CURRENT_WATCH_... bits */
    uint32_t coasting; /* [-] 1: the bridge is off during a supply loss, and is switched on again after it */
} medium_found_t;

/* How far the estimate may be trusted, judged at the window's end. */
typedef struct {
    validity_t validity;
    angle_sigma_t sigma;
} medium_trust_t;

/* The difference of the EMF to that of a round rotor on equal legs. */
typedef struct {
    emf_shape_t emf_shape;
    unequal_legs_t unequal_legs;
    ab_t spared; /* part that is subtracted for the estimator, for the setpoint [V] */
} medium_ripple_t;

/* Brake chopper and holding brake. */
typedef struct {
    chopper_watch_t chopper;
    holding_brake_t brake;
} medium_outputs_t;

/* The DC link and its supply. */
typedef struct {
    link_watch_t watch;
    supply_limit_t supply;
} medium_link_t;

/* The state of the background. */
typedef struct {
    uint32_t unattended;        /* [periods] since its last pass; 0: none yet */
    uint32_t reported;          /* [-] GUARD_CORRUPT_... and other bits that it has reported */
    params_in_force_t in_force; /* of the parameter set, for the signals */
} medium_background_t;

/* State of the mechanical speed and of its control. */
typedef struct {
    float trip;      /* overspeed limit of the tuning [rad/s] */
    float reference; /* of the last setpoint [rad/s] */
    uint32_t still;  /* [windows] since the reference changed, until a window contains the new one */
    oscillation_watch_t oscillation;
} medium_speed_t;

typedef struct {
    sequence_t sequence;
    manoeuvres_t manoeuvres;
    guard_t guard; /* the rows of the fault table that are judged here */

    flux_t flux;
    offset_trim_t offset_trim;
    means_t means;
    medium_trust_t trust;
    estimate_t estimate; /* at the window's end; its EMF is the mean of the window, rotated to its end */
    inductance_t inductance;
    inertia_t inertia;
    dead_time_learn_t dead_time_learn;
    medium_ripple_t ripple;
    medium_speed_t speed;

    encoder_watch_t encoder_watch;
    motion_watch_t motion_watch;
    current_watch_t current_watch;
    medium_found_t found;
    thermal_t thermal;
    medium_link_t link;
    medium_outputs_t outputs;
    commission_t commission;

    medium_background_t background;
    drive_fault_t fault; /* the last fault: measurements when the drive stopped */
    uint32_t faults;     /* [-] since power-on */
    setpoint_t setpoint; /* the newest */
} medium_t;

/* Sets all state to zero, state not ready, with these coefficients. */
void medium_init(medium_t *medium, const medium_tuning_t *tuning);

/* Takes over new coefficients between two windows; the state is kept. */
void medium_set_tuning(medium_t *medium, const medium_tuning_t *tuning);

/* Computes medium->setpoint from this window and the requests, with these coefficients. */
void medium_step(medium_t *medium, const medium_tuning_t *tuning, const window_t *window,
                 const requests_t *requests);

/* Latches a fault, with the measurements at that time; `window`: the newest. */
void medium_stop(medium_t *medium, const window_t *window, drive_fault_t stop);

/* What the drive has learnt. `noise_square`: of a current sensor, mean square [A^2]; it is valid after the
 * calibration. */
learnt_t medium_learnt(const medium_t *medium, float noise_square);

#endif
