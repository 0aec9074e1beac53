/* What the medium task sets for the fast task: one struct for a window of periods. Nothing else goes from the
 * one to the other (the way back is fast/window.h). It is taken whole at the first period of a window; what
 * is a reference is reached on a straight line at the window's end, what is an order is obeyed once, in the
 * first period. */
#ifndef FAST_REFERENCE_SETPOINT_H
#define FAST_REFERENCE_SETPOINT_H

#include <stdint.h>

#include "fast/reference/demand.h"
#include "math/frames.h"

/* Where the frame comes from in which control works. */
typedef enum {
    SOURCE_NONE,     /* the stationary frame, nothing is known of the rotor */
    SOURCE_ENCODER,  /* the encoder */
    SOURCE_ESTIMATE, /* the tracking loop */
    SOURCE_FORCED,   /* a frame that turns by itself and takes the rotor along */
    SOURCE_CATCH     /* the stationary frame, until the fast task has locked the loop to what it has caught */
} frame_source_t;

/* What becomes of the tracking loop in the first period. */
typedef enum {
    LOCK_KEEP,       /* it tracks or rests, as before */
    LOCK_RELEASE,    /* it rests: the observer alone is stepped */
    LOCK_TO_EMF,     /* it is locked to where the EMF is, at the forced frame's speed */
    LOCK_TO_ENCODER, /* it is locked to where the encoder is */
    LOCK_FOLLOWS     /* it goes on as it is, and counts as tracking */
} lock_order_t;

/* What the fast task does by itself where the encoder's angle jumps as no rotor does. */
typedef enum {
    JUMP_IGNORED,
    JUMP_OPENS,       /* the row of the fault table opens the bridge */
    JUMP_TO_ESTIMATE, /* control goes on with the tracking loop */
    JUMP_TO_CATCH     /* the rotor is caught */
} jump_reaction_t;

/* What is done about the offsets of the current sensors. */
typedef enum {
    CALIBRATE_NOT,   /* nothing; the next calibration begins anew */
    CALIBRATE_ALL,   /* they are measured */
    CALIBRATE_BLOCKS /* they are measured again and again, block by block */
} calibrate_t;

/* A forced frame. */
typedef struct {
    float speed;   /* at the window's end [rad/s], electrical */
    float current; /* at the window's end, along its d axis [A] */
    float ahead;   /* where it begins: ahead of the estimate [rad]; with FRAME_ANEW from zero [rad] */
    float begin;   /* speed with which it begins [rad/s], electrical */
} setpoint_forced_t;

/* A catch. */
typedef struct {
    uint32_t periods; /* [periods] that it may take */
    float speed;      /* until it has seen one [rad/s], electrical */
} setpoint_catch_t;

/* What estimator and inverter's model receive about motor and load. */
typedef struct {
    float load_share;     /* with which what of i_q carries the load follows it, a period [-]; 0: it is held;
                             1: all of it does */
    float load_seen;      /* the same as far as it is known, for the doubt [A] */
    float gained;         /* speed since its reference moved [rad/s], electrical */
    float foreseen;       /* the same from the current [rad/s] */
    float flux_linkage;   /* psi_f [Wb] */
    float speed_per_volt; /* 1/psi_f [rad/s/V] */
    float dead_time;      /* T_e/T of the legs [-] */
    ab_t spared;          /* of the voltage that acts, which the estimator does not get: shape of the EMF and
                             differences of the legs, mean of the window [V] */
} setpoint_models_t;

/* What is known of the supply. */
typedef struct {
    float sunk;   /* by which the voltage has sunk at which the rotor holds the link [V] */
    uint32_t low; /* [-] 1: the supply is low, and delivers */
} setpoint_link_t;

typedef struct {
    uint32_t number;       /* [windows] of the window that it was made from */
    uint32_t gates;        /* [-] 1: the bridge shall be on */
    int32_t calibrate;     /* [-] calibrate_t, while they are off */
    ab_t trim;             /* what the trim has found of the sensors' offsets [A] */
    uint32_t moments;      /* [-] GUARD_... bits: which fast rows of the fault table count */
    int32_t jump;          /* [-] jump_reaction_t */
    uint32_t jump_periods; /* [periods] that a catch after it may take */
    int32_t source;        /* [-] frame_source_t; it counts where it is not that of the last setpoint */
    uint32_t enter;        /* [-] 1: a catch or a forced frame begins here, even if the source is the same */
    int32_t change;        /* [-] frame_change_t, of the first period */
    int32_t lock;          /* [-] lock_order_t, of the first period */
    dq_t current;          /* reference in this frame, at the window's end [A]; q: at speed zero */
    float stiffness;       /* by which i_q falls with the speed of each period [A s/rad], mechanical */
    dq_t dither;           /* beside it, from the first period on [A] */
    float omega_m_ref;     /* speed reference in force [rad/s], mechanical */
    float current_limit;   /* of i_q [A], by heat and beside what a hand-over has left of i_d */
    uint32_t only_brakes;  /* [-] 1: a quick stop, in which nothing drives the rotor on */

    setpoint_forced_t forced;
    setpoint_catch_t catching;
    setpoint_models_t models;
    setpoint_link_t link;
} setpoint_t;

#endif
