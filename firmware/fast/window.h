/* Data from the fast task to the medium task: one struct for a window of periods, closed at its last one, and
 * no other data in this direction (fast/reference/setpoint.h is the opposite direction). Sums are those of
 * all periods of the window; all other values are those of the last one, t_k, unless stated otherwise. */
#ifndef FAST_WINDOW_H
#define FAST_WINDOW_H

#include <stdbool.h>
#include <stdint.h>

#include "contract/measured.h"
#include "estimator/estimate.h"
#include "estimator/position.h"
#include "fast/control/excite.h"
#include "fast/reference/catch.h"
#include "guard/fault_set.h"
#include "math/bounds.h"
#include "math/frames.h"

/* [windows] between the window from which a setpoint is made and the window in which it acts. */
#define DRIVE_LATENCY 1u

/* The reason of a stop and the values at that time. */
typedef struct {
    int32_t reason;    /* [-] reason_t; REASON_NONE: no stop */
    uint32_t period;   /* [periods] time of the stop */
    float i_a, i_b;    /* [A] */
    float u_dc;        /* [V] */
    float theta_e;     /* [rad] */
    float omega_e;     /* [rad/s] */
    int32_t manoeuvre; /* [-] manoeuvre_t at that time */
} drive_fault_t;

/* State of a catch. */
typedef struct {
    int32_t outcome; /* [-] catch_outcome_t */
    catch_seen_t seen;
} window_catch_t;

/* The DC link. */
typedef struct {
    float mean;      /* of the last period [V] */
    uint32_t slow;   /* [-] 1: the rotor is too slow to feed the link */
    uint32_t limits; /* [-] 1: the link limits braking or driving */
} window_link_t;

/* The bridge according to the last sample. */
typedef enum {
    BRIDGE_OFF,     /* or the gates have just been released */
    BRIDGE_CHARGES, /* the gates are released, and only the lower switches are on */
    BRIDGE_ON
} bridge_t;

/* The current sensors. */
typedef struct {
    int32_t calibration; /* [-] calibration_t */
    uint32_t offsets;    /* [-] 1: they were measured again in this window */
    uint32_t still[3];   /* [periods] for which the value of a sensor has not changed */
    float noise;         /* mean square of the noise of a sensor, in the last calibration [A^2] */
} window_sensors_t;

/* What the fast task has decided by itself. */
typedef struct {
    fault_set_t failed; /* fast rows of the fault table that failed in this window */
    int32_t left;       /* [-] jump_reaction_t by which control left the encoder; else JUMP_IGNORED */
    drive_fault_t stop; /* reason for which the fast task or the trip interrupt has opened the bridge */
    int32_t source;     /* [-] frame_source_t of the speed at this stop */
} window_report_t;

/* Sums over the periods. */
typedef struct {
    uint32_t periods; /* [periods] so far */
    uint32_t tracked; /* [periods] in which the loop tracked */
    uint32_t unsound; /* [-] not 0: at least one period is not reliable */
    uint32_t limited; /* [-] 1: the applied voltage was less than control required */
    uint32_t chopped; /* [periods] in which the chopper was on */
    float scatter;    /* sum of the detector's square [-] */
    ab_t voltage;     /* that was applied [V] */
    ab_t current;     /* [A] */
    ab_t emf;         /* at t_k, without lag [V] */
    ab_t emf_hat;     /* with its lag [V] */
    dq_t reference;   /* reference of control at t_k-1 [A] */
} window_sums_t;

typedef struct {
    uint32_t number;   /* [windows] since the start */
    uint32_t period;   /* [periods] the clock of the drive */
    uint32_t setpoint; /* [windows] number of the present setpoint */
    window_sums_t sum;
    measured_t measured;
    estimate_t estimate;
    ab_t current_err; /* observed minus measured current [A] */
    position_t encoder;
    frame_t frame;     /* of current control */
    frame_t rotor;     /* estimated */
    float omega_m;     /* [rad/s] mechanical, of the rotor */
    dq_t current;      /* in the frame [A] */
    dq_t reference;    /* of current control [A] */
    dq_t voltage;      /* required by current control [V] */
    float omega_m_ref; /* present speed reference [rad/s] */
    bounds_t bounds;   /* present limits of i_q by heat and DC link [A] */
    window_link_t link;
    window_catch_t catching;
    window_sensors_t sensors;
    uint32_t estimating; /* [-] 1: the estimator runs */
    uint32_t tracking;   /* [-] 1: the loop tracks, or coasts for a short time */
    int32_t bridge;      /* [-] bridge_t */
    window_report_t report;
    excite_seen_t excite; /* sums of an excitation; those of the last one if none acts */
} window_t;

#endif
