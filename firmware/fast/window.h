/* What the fast task tells the medium task: one struct for a window of periods, closed at its last one.
 * Nothing else goes from the one to the other (the way back is fast/reference/setpoint.h). Sums are those of
 * all its periods; all else is of the last one, t_k, unless it says otherwise. */
#ifndef FAST_WINDOW_H
#define FAST_WINDOW_H

#include <stdbool.h>
#include <stdint.h>

#include "contract/measured.h"
#include "estimator/estimate.h"
#include "estimator/position.h"
#include "guard/fault_set.h"
#include "math/bounds.h"
#include "math/frames.h"

/* From the window that a setpoint is made of to the one in which it acts, beyond the next [windows]. */
#define DRIVE_LATENCY 1u

/* What stopped the drive, and what it saw then. */
typedef struct {
    int32_t reason;    /* [-] reason_t; REASON_NONE: nothing has */
    uint32_t period;   /* [periods] when */
    float i_a, i_b;    /* [A] */
    float u_dc;        /* [V] */
    float theta_e;     /* [rad] */
    float omega_e;     /* [rad/s] */
    int32_t manoeuvre; /* [-] manoeuvre_t: what it was about */
} drive_fault_t;

/* A catch as it is seen. */
typedef struct {
    int32_t outcome;         /* [-] catch_outcome_t */
    uint32_t turning;        /* [-] 1: a rotor is seen turning */
    uint32_t periods_beyond; /* [periods] without a break with an EMF that the link cannot hold */
    float length;            /* <|e|> [V] */
    ab_t emf;                /* low-passed in a frame that turns with it [V] */
    float cross, cross_min;  /* sum of e x <e>, and the least that it must have [V^2] */
} window_catch_t;

/* The DC link. */
typedef struct {
    float mean;      /* of the last period [V] */
    uint32_t slow;   /* [-] 1: the rotor is too slow to feed it */
    uint32_t limits; /* [-] 1: it limits braking or driving */
} window_link_t;

/* The bridge, as the last sample shows it. */
typedef enum {
    BRIDGE_OFF,     /* or its gates have just been released */
    BRIDGE_CHARGES, /* the gates were released, the lower switches are on alone */
    BRIDGE_ON
} bridge_t;

/* What is summed in each period. */
typedef struct {
    uint32_t periods; /* [periods] so far */
    uint32_t tracked; /* [periods] of them in which the loop tracked */
    uint32_t unsound; /* [-] not 0: one of them may not be believed */
    uint32_t moved; /* [-] bits of the current sensors whose value has not stayed as it was at the end of the
                       window before */
    uint32_t limited; /* [-] 1: control has not got the voltage that it asked for */
    float scatter;    /* sum of the detector's square [-] */
    ab_t voltage;     /* that acted [V] */
    ab_t current;     /* [A] */
    ab_t emf;         /* at t_k, lag undone [V] */
    ab_t emf_hat;     /* with its lag [V] */
    dq_t reference;   /* what control asked for at t_k-1 [A] */
} window_sums_t;

typedef struct {
    uint32_t number;   /* [windows] since the start */
    uint32_t period;   /* [periods] the one clock */
    uint32_t setpoint; /* [windows] number of the setpoint in force */
    window_sums_t sum;
    measured_t measured;
    estimate_t estimate;
    position_t encoder;
    frame_t frame;     /* in which control works */
    frame_t rotor;     /* as it is believed */
    float omega_m;     /* [rad/s] mechanical, of the rotor */
    dq_t current;      /* in the frame [A] */
    dq_t reference;    /* what control asks for [A] */
    dq_t voltage;      /* likewise [V] */
    float omega_m_ref; /* speed reference in force [rad/s] */
    bounds_t bounds;   /* limits of i_q in force, by heat and DC link [A] */
    window_link_t link;
    window_catch_t catching;
    int32_t calibration; /* [-] calibration_t */
    uint32_t offsets;    /* [-] 1: the offsets of the sensors have been measured anew in this window */
    uint32_t estimating; /* [-] 1: the estimator runs */
    uint32_t tracking;   /* [-] 1: its loop tracks, or coasts for a while */
    int32_t bridge;      /* [-] bridge_t */
    fault_set_t failed;  /* fast rows of the fault table that have failed in this window */
    int32_t left;        /* [-] jump_reaction_t by which the encoder was left, JUMP_IGNORED: it was not */
    drive_fault_t stop;  /* by which the fast task has opened the bridge, or the trip interrupt */
} window_t;

#endif
