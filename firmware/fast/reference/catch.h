/* Catch: detects from the back-EMF whether the rotor rotates, in which direction and at which angle, with the
 * gates on and almost no current, in the stationary frame.
 *
 *     voltage     the EMF itself, so that almost no current flows, rotated by 1.5 T omega for the delay. For
 *                 a rotor faster than 500 rad/s it acts as soon as the observer has found the EMF: until then
 *                 the winding is shorted, with a current of at most 2 psi_f/L
 *     current     a small current along phase a, which is outside the zone of the dead time in all three
 *                 legs; once a rotor is detected, more, along its d axis, where it makes no torque
 *     direction   sign of the sum of  e x <e>,  <e>: the EMF low-passed: a vector that rotates leads its
 *                 own low-pass in its direction of rotation
 *     speed       <|e|>/psi_f,  a low-pass that begins with the value after 2 ms: the observer, which
 *                 starts from zero, has converged by then, and its earlier error is left out; and the
 *                 slip: the difference between the speed of the EMF and that of a frame with this speed,
 *                 independent of psi_f. At first, for a rotor faster than 500 rad/s, it follows from the
 *                 rotation of the EMF in a period, on which a constant lag has no effect, from 0.6 ms on, or
 *                 from the third period on if it is more than 0.1 rad; after 4 ms it
 *                 follows from a tracking loop whose natural frequency is not above the rotor's speed. The
 *                 slip of a slow rotor, whose EMF is too noisy, is not measured: the estimator corrects it
 *     angle       of the d axis, from the EMF: the EMF leads it by a quarter turn, or lags it in reverse;
 *                 the EMF is low-passed in a frame that rotates with its speed, and so has no lag
 *
 * The catch ends when the rotor has rotated by 1 rad since its direction is known (4 ms at least), but not
 * earlier than 10 ms after its start. Without a rotating rotor it ends at the caller's time-out. A constant
 * voltage error does not count as a rotor: e x <e> has to be at least 0.4 of the value that a slow rotor with
 * this EMF makes, or 0.78 of the least value of a fast one.
 *
 * One step per T; the EMF is that of t_k, from the observer at the speed in catch_t. Does not handle: rotors
 * so slow that their EMF is smaller than the error of the dead time's voltage at zero current (they count as
 * standing); rotors that turn by more than 1.15 rad in a period. */
#ifndef FAST_REFERENCE_CATCH_H
#define FAST_REFERENCE_CATCH_H

#include <stdbool.h>
#include <stdint.h>

#include "estimator/position.h"
#include "math/frames.h"

typedef struct {
    float flux_linkage; /* psi_f [Wb], > 0 */
    float speed_min;    /* rotors below this speed count as standing [rad/s], electrical */
    float doubtful;     /* current below which the loss of a leg is in doubt [A] */
    float current_d;    /* along the d axis of a detected rotor [A]; at least the current of phase a */
    bool salient;       /* L_q > L_d by so much that i_d has to be negative */
    float reach;  /* longest EMF against which current control can work, over the largest voltage of the link
                     [-], >= 1 */
    float period; /* T [s] */
} catch_params_t;

typedef struct {
    float trail_share;    /* of <e> [-] */
    float trail_time;     /* 1/its cutoff [s] */
    float length_share;   /* of <|e|> [-] */
    float emf_share;      /* of the EMF in its own frame [-] */
    float turn_share;     /* of the turn of the EMF in a period [-] */
    float period;         /* T [s] */
    float frequency;      /* 1/T [1/s] */
    float speed_per_volt; /* 1/psi_f [rad/s/V] */
    float speed_min;      /* [rad/s] electrical */
    float emf_min_square; /* of the EMF in its own frame [V^2] */
    float current;        /* along phase a [A] */
    float current_d;      /* along the d axis, once it is detected [A] */
    float lead;           /* 1.5 T [s] */
    float reach;          /* largest EMF, divided by the largest voltage of the link [-] */
    uint32_t early;       /* [periods] before the turn of the EMF is valid */
    uint32_t seen;        /* [periods] before the mean of the length begins */
    uint32_t settled;     /* [periods] before speed and rotation are valid */
    uint32_t sure;        /* [periods] after which a rotor that has rotated far enough is caught at once */
    float turn_sure;      /* this rotation over T [rad/s] */
    uint32_t beyond;      /* [periods] for which the EMF must be too large */
} catch_tuning_t;

/* The part of the state that the medium task judges. */
typedef struct {
    ab_t emf;                /* e at t_k, low-passed in a frame that turns with it [V] */
    float cross;             /* sum of e x <e> [V^2] */
    float cross_min;         /* least amount of this sum [V^2] */
    float length;            /* <|e|> [V] */
    uint32_t turning;        /* [-] 1: a rotating rotor is detected */
    uint32_t periods_beyond; /* [periods] in succession in which the EMF was too large */
} catch_seen_t;

typedef struct {
    ab_t trail; /* <e> [V] */
    ab_t turn;  /* scalar and cross product of the EMF of two periods, low-passed [V^2] */
    catch_seen_t seen;
    float slip;       /* difference of the EMF's speed from <|e|>/psi_f [rad/s] */
    float omega_e;    /* [rad/s] electrical, that of the start until it is measured */
    float turned;     /* sum of |omega_e| since the direction is known [rad/s] */
    uint32_t periods; /* [periods] so far */
    uint32_t wanted;  /* [periods] of the whole catch */
    uint32_t found;   /* [-] 1: a step has ended with CATCH_TURNING */
} catch_t;

typedef enum { CATCH_GOES_ON, CATCH_TURNING, CATCH_STANDING, CATCH_TOO_FAST } catch_outcome_t;

/* The current along the d axis while a rotor is caught [A]: `current_d`, or more where the dead-time loss is
 * uncertain, which is up to `doubtful` [A]. It is negative for a salient rotor, where it increases the active
 * flux. */
float catch_current_along(float doubtful, float current_d, bool salient);

/* Computes the coefficients. It has divisions and exponentials and runs in the background. */
catch_tuning_t catch_prepare(const catch_params_t *params);

/* Begins a catch of at most `periods`; omega_e [rad/s] is the speed until one is measured. Sets the whole
 * state. */
void catch_enter(catch_t *catching, uint32_t periods, float omega_e);

/* One period. `emf` is the EMF at t_k and `length` its amount [V], `voltage_max` the largest voltage that the
 * link allows [V]. CATCH_TOO_FAST: `length` is above `reach` times `voltage_max`. No division. */
catch_outcome_t catch_step(catch_t *catching, const catch_tuning_t *tuning, ab_t emf, float length,
                           float voltage_max);

/* Once a rotor is found: rotates its EMF by one period with its speed. */
void catch_turn(catch_t *catching, const catch_tuning_t *tuning);

/* The current reference [A]: along phase a, or along the d axis of a detected rotor. No division. */
ab_t catch_current(const catch_t *catching, const catch_tuning_t *tuning);

/* The voltage to command now: it equals this EMF [V], rotated to the time when the voltage acts. */
ab_t catch_voltage(const catch_t *catching, const catch_tuning_t *tuning, ab_t emf);

/* Angle and speed of the caught rotor at t_k. No division. */
frame_t catch_rotor(const catch_t *catching);

/* Amount of the EMF, averaged over some periods [V]. No division. */
float catch_length(const catch_t *catching);

/* Angle of the d axis [rad] for this EMF [V], whose speed has the sign of omega_e. No division. */
float catch_angle(ab_t emf, float omega_e);

#endif
