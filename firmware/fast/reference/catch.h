/* Catch: is the rotor turning, which way and where? With the gates on and next to no current, in the
 * stationary frame, the back-EMF tells.
 *
 *     voltage     the EMF itself, so that hardly a current flows, turned on by 1.5 T omega: it acts that late
 *     current     a little along phase a, which takes all three legs out of the dead time's zone; once a
 *                 rotor is seen, more and along its d axis, where it makes no torque
 *     direction   sign of the sum of  e x <e>,  <e>: the EMF low-passed: a vector that turns is ahead of its
 *                 own low-pass in the direction in which it turns
 *     speed       <|e|>/psi_f,  a low-pass that begins with what there is after 2 ms: the observer, which
 *                 starts from nothing, is on the EMF by then, and what it lacked before is left out; and
 *                 the slip: by so much the EMF turns faster than a frame with this speed, whatever psi_f. It
 *                 is found by a tracking loop that is no quicker than the rotor turns; that of a slow one,
 *                 whose EMF is too unsteady, is left to the estimator's
 *     angle       where the EMF puts the d axis: it lies a quarter turn ahead of it, or behind in reverse;
 *                 the EMF low-passed in a frame that turns with its speed, and so without a lag
 *
 * It ends when the rotor has turned by 1 rad since its direction is known (4 ms at least), not earlier than
 * 10 ms after its start; without a turning rotor at the caller's time-out. A voltage error that stands still
 * is no rotor: of e x <e> there must be 0.4 of what a rotor with this EMF makes.
 *
 * One step per T; the EMF is that of t_k, from the observer at the speed that catch_t has. Does not handle:
 * rotors so slow that their EMF drowns in the dead time's voltage at zero current (they count as
 * standing); rotors that turn faster than 5000 rad/s, whose <e> is next to nothing. */
#ifndef FAST_REFERENCE_CATCH_H
#define FAST_REFERENCE_CATCH_H

#include <stdbool.h>
#include <stdint.h>

#include "estimator/position.h"
#include "math/frames.h"

typedef struct {
    float flux_linkage; /* psi_f [Wb], > 0 */
    float speed_min;    /* slower rotors stand [rad/s], electrical */
    float doubtful;     /* current below which the loss of a leg is in doubt [A] */
    float current_d;    /* along the d axis of a rotor that is seen [A]; at least what phase a gets */
    bool salient;       /* L_q > L_d by so much that i_d shall be below zero */
    float period;       /* T [s] */
} catch_params_t;

typedef struct {
    float trail_share;    /* of <e> [-] */
    float trail_time;     /* 1/its cutoff [s] */
    float length_share;   /* of <|e|> [-] */
    float emf_share;      /* of the EMF in its own frame [-] */
    float period;         /* T [s] */
    float speed_per_volt; /* 1/psi_f [rad/s/V] */
    float speed_min;      /* [rad/s] electrical */
    float emf_min_square; /* of the EMF in its own frame [V^2] */
    float current;        /* along phase a [A] */
    float current_d;      /* along the d axis, once it is seen [A] */
    float lead;           /* 1.5 T [s] */
    uint32_t seen;        /* [periods] before the mean of the length begins */
    uint32_t settled;     /* [periods] before the speed is believed, and a rotor seen */
    uint32_t sure;        /* [periods] after which a rotor that has turned far enough is caught at once */
    float turn_sure;      /* how far that is, over T [rad/s] */
    uint32_t beyond;      /* [periods] that an EMF beyond the link must last */
} catch_tuning_t;

typedef struct {
    ab_t trail;              /* <e> [V] */
    ab_t emf;                /* e at t_k, low-passed in a frame that turns with it [V] */
    float cross;             /* sum of e x <e> [V^2] */
    float cross_min;         /* least that it must have [V^2] */
    float length;            /* <|e|> [V] */
    float slip;              /* of the EMF against a frame that turns with <|e|>/psi_f [rad/s] */
    float omega_e;           /* [rad/s] electrical, of the start until it is believed */
    float turned;            /* sum of |omega_e| since [rad/s] */
    uint32_t periods;        /* [periods] so far */
    uint32_t wanted;         /* [periods] of the whole catch */
    uint32_t turning;        /* [-] 1: a rotor is seen turning */
    uint32_t found;          /* [-] 1: a step has ended with CATCH_TURNING */
    uint32_t periods_beyond; /* [periods] without a break with an EMF that the link cannot hold */
} catch_t;

typedef enum { CATCH_GOES_ON, CATCH_TURNING, CATCH_STANDING, CATCH_TOO_FAST } catch_outcome_t;

/* The current along the d axis of a rotor that is caught [A]: as wished for, but at least clear of what is
 * doubtful [A]; of a salient one against the magnet, where its EMF grows. */
float catch_current_along(float doubtful, float current_d, bool salient);

/* Coefficients. Division and exponentials: for the background. */
catch_tuning_t catch_prepare(const catch_params_t *params);

/* Nothing seen. */
void catch_init(catch_t *catching);

/* A catch of so many periods begins; omega_e [rad/s]: the speed until it has seen one. */
void catch_enter(catch_t *catching, uint32_t periods, float omega_e);

/* One period: EMF at t_k and its length [V], largest voltage that the link gives [V]. No division. */
catch_outcome_t catch_step(catch_t *catching, const catch_tuning_t *tuning, ab_t emf, float length,
                           float voltage_max);

/* Once a rotor is found: its EMF a period later, by its speed alone. */
void catch_turn(catch_t *catching, const catch_tuning_t *tuning);

/* The current to be held [A]: along phase a, or the d axis of a rotor that is seen. No division. */
ab_t catch_current(const catch_t *catching, const catch_tuning_t *tuning);

/* The voltage that holds this EMF [V] when it acts. */
ab_t catch_voltage(const catch_t *catching, const catch_tuning_t *tuning, ab_t emf);

/* The rotor as it was caught, at t_k. No division. */
frame_t catch_rotor(const catch_t *catching);

/* Length of the EMF that turns with it, the mean of some periods [V]. No division. */
float catch_length(const catch_t *catching);

/* Angle of the d axis [rad] under this EMF [V], which turns with a speed of this sign. No division. */
float catch_angle(ab_t emf, float omega_e);

#endif
