/* The effective dead time of the legs, learnt from the EMF while the motor turns slowly.
 *
 * A leg loses V = T_e/T u_dc + drop with the sign of its current (inverter/dead_time.h). Where the observer
 * believes in V_hat instead, its EMF carries the rest,
 *
 *     e = e_rotor + (V - V_hat) r,     r = vector of the three signs, of length 4/3
 *
 * Seen from the current, r is a staircase along it, whose mean looks like resistance or flux, and across it a
 * sawtooth of the sixth harmonic, which looks like nothing else. So only what is across the current is
 * correlated, mean values taken off in the frame of the rotor:
 *
 *     e_x = e~ x i/|i|,  r_x = r~ x i/|i|       ~: high-pass at |omega_e|
 *     d(T_e/T)/dt = rate e_x r_x/(DEAD_TIME_LEARN_POWER u_dc)
 *
 * Which makes V_hat follow V with `rate`, at any direction of the current (docs/theory.md, 24). What is
 * learnt is a time, for it is the delays that nobody knows: the voltage follows the link by itself. An error
 * of the drop is learnt as if it were time.
 *
 * It learns only while the EMF is neither small nor large beside the dead band's voltage (a small one is not
 * tracked well, a large one has harmonics of its own), while the current is well outside of the zone, while
 * speed and reference are together and EMF and speed agree; else the value stays.
 *
 * One step per T. Does not handle: differences between the legs, an EMF with large fifth and seventh
 * harmonics: 2 % of it is an error of some 1 % at four times the lowest speed. */
#ifndef ADAPT_DEAD_TIME_LEARN_H
#define ADAPT_DEAD_TIME_LEARN_H

#include <stdint.h>

#include "math/frames.h"

#define DEAD_TIME_LEARN_POWER     0.0749f /* [-] mean square of the sawtooth, whose peak is 2/3 */
#define DEAD_TIME_LEARN_EMF_MIN   0.45f /* [-] EMF over the dead band's voltage from which on it learns ... */
#define DEAD_TIME_LEARN_EMF_MAX   3.2f  /* [-] ... and up to which */
#define DEAD_TIME_LEARN_MISS      0.35f /* [-] EMF of the speed that is missing, over the same, at most */
#define DEAD_TIME_LEARN_AGREE     0.2f  /* [-] of the EMF that belongs to the speed, at least */
#define DEAD_TIME_LEARN_ZONES     7.0f  /* [-] current over the zone, at least */
#define DEAD_TIME_LEARN_RANGE     2.0f /* [-] T_e over the larger of dead band and parameters' T_e, at most */
#define DEAD_TIME_LEARN_EMF_LIMIT 1e4f /* [V] what is longer is no EMF */

typedef struct {
    float rate;         /* [1/s]; 0: off */
    float effective;    /* T_e/T that the parameters say [-] */
    float band;         /* dead band over T, which the hardware keeps exactly [-] */
    float flux_linkage; /* psi_f [Wb] */
    float zone;         /* half width of the zone around zero current [A] */
    float period;       /* T [s] */
} dead_time_learn_params_t;

typedef struct {
    float rate;           /* rate T/(DEAD_TIME_LEARN_POWER zone) [1/A]; 0: off */
    float effective;      /* T_e/T of the parameters [-] */
    float least, most;    /* limits of what is learnt [-] */
    float band;           /* [-] */
    float flux_linkage;   /* [Wb] */
    float current_square; /* least |i|^2 [A^2] */
    float period;         /* [s] */
} dead_time_learn_tuning_t;

typedef struct {
    dead_time_learn_tuning_t tuning;
    float effective; /* T_e/T as learnt [-] */
    uint32_t begun;  /* [-] 1: the means below are of the last periods */
    ab_t emf_mean;   /* what turns like the rotor [V] */
    ab_t along[3]; /* direction of the current, of one to three periods ago [-] */
    ab_t along_mean; /* likewise: direction of the current [-] */
} dead_time_learn_t;

/* What a period brings. */
typedef struct {
    float omega_e;     /* of the rotor, as estimated, smooth [rad/s], electrical */
    float omega_e_ref; /* its reference [rad/s], electrical */
    ab_t emf;          /* at t_k, lag undone [V] */
    ab_t current;      /* mean of the period [A] */
    float link;        /* likewise [V] */
} dead_time_learn_input_t;

/* Coefficients. One division. */
dead_time_learn_tuning_t dead_time_learn_prepare(const dead_time_learn_params_t *params);

/* These coefficients. What is learnt stays while the parameters say the same and it is on; else it starts
 * from them again. */
void dead_time_learn_take(dead_time_learn_t *learn, const dead_time_learn_tuning_t *tuning);

/* The periods go not on from the last ones: the means begin with the next. */
static inline void dead_time_learn_pause(dead_time_learn_t *learn)
{
    learn->begun = 0u;
}

/* One period that was tracked. Input that is no number or no EMF teaches nothing. No division. */
void dead_time_learn_step(dead_time_learn_t *learn, const dead_time_learn_input_t *input);

#endif
