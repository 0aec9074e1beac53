/* Data from the medium task to the fast task: one struct for a window of periods, and no other data in this
 * direction (fast/window.h is the opposite direction). The fast task takes over the whole struct in the first
 * period of a window. References are reached on a straight line at the end of the window, and orders are
 * executed once, in the first period. */
#ifndef FAST_REFERENCE_SETPOINT_H
#define FAST_REFERENCE_SETPOINT_H

#include <stdint.h>

#include "fast/control/excite.h"
#include "fast/reference/demand.h"
#include "math/frames.h"

/* Source of the frame in which control works. */
typedef enum {
    SOURCE_NONE,     /* the stationary frame, with an unknown rotor */
    SOURCE_ENCODER,  /* the encoder */
    SOURCE_ESTIMATE, /* the tracking loop */
    SOURCE_FORCED,   /* a frame that rotates independently and takes the rotor along */
    SOURCE_CATCH     /* the stationary frame, until the fast task has locked the loop to the caught rotor */
} frame_source_t;

/* Order to the tracking loop for the first period. */
typedef enum {
    LOCK_KEEP,       /* no change: it continues to track or to rest */
    LOCK_RELEASE,    /* it rests: only the observer runs */
    LOCK_TO_EMF,     /* it is locked to the angle of the EMF, at the speed of the forced frame */
    LOCK_TO_ENCODER, /* it is locked to the angle of the encoder */
    LOCK_FOLLOWS     /* it continues and counts as tracking */
} lock_order_t;

/* Reaction of the fast task to a step of the encoder's angle that no rotor can make. */
typedef enum {
    JUMP_IGNORED,
    JUMP_OPENS,       /* the row of the fault table opens the bridge */
    JUMP_TO_ESTIMATE, /* control continues with the tracking loop */
    JUMP_TO_CATCH     /* the rotor is caught */
} jump_reaction_t;

/* Measurement of the offsets of the current sensors. */
typedef enum {
    CALIBRATE_NOT,   /* none; the next calibration begins again */
    CALIBRATE_ALL,   /* one calibration */
    CALIBRATE_BLOCKS /* repeated measurement, block by block */
} calibrate_t;

/* The outputs of the board other than the gates: bits. Without them the chopper is off and the brake is set.
 */
#define DRIVE_OUTPUT_CHOPPER UINT32_C(1) /* the brake resistor is connected to the link */
#define DRIVE_OUTPUT_BRAKE   UINT32_C(2) /* the holding brake is released */

/* A forced frame. */
typedef struct {
    float speed;   /* at the end of the window [rad/s], electrical */
    float current; /* at the end of the window, along its d axis [A] */
    float ahead;   /* initial angle ahead of the estimate [rad]; with FRAME_ANEW ahead of zero [rad] */
    float begin;   /* initial speed [rad/s], electrical */
} setpoint_forced_t;

/* A catch. */
typedef struct {
    uint32_t periods; /* [periods] longest duration */
    float speed;      /* speed until one is measured [rad/s], electrical */
} setpoint_catch_t;

/* Values of motor and load for the estimator and the model of the inverter. */
typedef struct {
    float load_share;   /* low-pass share per period of the part of i_q that carries the load [-]; 0: the load
                           is held; 1: no low-pass */
    float load_seen;    /* the known load, for the doubt [A] */
    float gained;       /* speed since its reference moved [rad/s], electrical */
    float foreseen;     /* the same, computed from the current [rad/s] */
    float flux_linkage; /* psi_f [Wb] */
    float speed_per_volt; /* 1/psi_f [rad/s/V] */
    float dead_time;      /* T_e/T of the legs [-] */
    float per_zone;       /* one over the half width of the zone in which an edge loses a part of it [1/A] */
    ab_t spared; /* part of the voltage that acts, removed for the estimator: harmonics of the EMF and
                    differences of the legs, mean of the window [V] */
} setpoint_models_t;

/* State of the supply. */
typedef struct {
    float sunk;   /* reduction of the voltage at which the rotor holds the link [V] */
    uint32_t low; /* [-] 1: the supply is low and delivers power */
} setpoint_link_t;

typedef struct {
    uint32_t number;       /* [windows] number of the window from which it was made */
    uint32_t gates;        /* [-] 1: the bridge has to be on */
    int32_t calibrate;     /* [-] calibrate_t, while the gates are off */
    ab_t trim;             /* change of the sensors' offsets that the trim has found [A] */
    uint32_t outputs;      /* [-] DRIVE_OUTPUT_... bits: the chopper is permitted, the brake is released */
    uint32_t moments;      /* [-] GUARD_... bits: which fast rows of the fault table count */
    int32_t jump;          /* [-] jump_reaction_t */
    uint32_t jump_periods; /* [periods] longest duration of a catch after such a step */
    int32_t source;        /* [-] frame_source_t; it acts if it differs from that of the last setpoint */
    uint32_t enter;        /* [-] 1: a catch or a forced frame begins here, even if the source is the same */
    int32_t change;        /* [-] frame_change_t, of the first period */
    int32_t lock;          /* [-] lock_order_t, of the first period */
    dq_t current;          /* reference in this frame, at the end of the window [A]; q: for speed zero */
    float stiffness;       /* decrease of i_q with the speed of each period [A s/rad], mechanical */
    uint32_t smooth;       /* [-] 1: the speed is the one without the proportional part of the loop */
    dq_t dither;           /* added to the reference from the first period on [A] */
    float omega_m_ref;     /* present speed reference [rad/s], mechanical */
    float driving_limit; /* of i_q in the direction of the speed [A], by heat, by the i_d that a hand-over has
                            left, and by the current of the supply */
    float braking_limit; /* the same against the direction of the speed [A] */
    uint32_t only_brakes; /* [-] 1: a quick stop, in which no current drives the rotor */

    setpoint_forced_t forced;
    setpoint_catch_t catching;
    setpoint_models_t models;
    setpoint_link_t link;
    excite_order_t excite; /* in place of current control; EXCITE_NONE: none */
} setpoint_t;

#endif
