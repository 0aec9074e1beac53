/* The brake resistor of the chopper: its heat, and whether it takes energy from the DC link.
 *
 *     tau dh/dt = share u^2/(R P_c) - h,      h = 1: final temperature with the continuous power P_c
 *
 * `share` is the part of the window in which the chopper was on. Above CHOPPER_HOT the resistor is overloaded
 * until h is below CHOPPER_COOL. The model starts cold.
 *
 * Effect: while the chopper is on for CHOPPER_LOOK without a break, a resistor reduces the energy of the
 * link, C u^2/2, by u^2/R less what the motor returns, P. It has no effect if in this time the voltage has
 * fallen by less than CHOPPER_FALL and P was below half of u^2/R: with that P a resistor makes the link fall
 * by CHOPPER_FALL for every R C up to CHOPPER_LOOK/(4 CHOPPER_FALL) = 1 s. The resistor is then absent, or a
 * supply above the threshold holds the link; the condition lasts until the link is below the band of the
 * chopper.
 *
 * Does not handle: a resistor of a wrong value within a factor of two, its initial temperature, the losses
 * between motor and link (P is the power at the motor, which delays the judgement and does not make it
 * wrong). */
#ifndef MEDIUM_PROTECT_CHOPPER_WATCH_H
#define MEDIUM_PROTECT_CHOPPER_WATCH_H

#include <stdint.h>

#define CHOPPER_HOT  1.0f   /* [-] h that stops the drive */
#define CHOPPER_COOL 0.8f   /* [-] h below which the fault may be reset */
#define CHOPPER_LOOK 20e-3f /* [s] */
#define CHOPPER_FALL 0.005f /* [-] of the voltage */

/* The conditions: bits. */
#define CHOPPER_OVERLOAD  UINT32_C(1)
#define CHOPPER_NO_EFFECT UINT32_C(2)

typedef struct {
    float voltage;    /* U_chop [V]; 0: no chopper */
    float below;      /* lower end of its band [V] */
    float resistance; /* R [ohm], above 0 */
    float continuous; /* P_c [W], above 0 */
    float time;       /* tau [s], above 0 */
    float period;     /* of a look [s] */
    float periods;    /* in a look [-] */
} chopper_watch_params_t;

typedef struct {
    uint32_t on;       /* [-] 1: there is a chopper */
    float below;       /* [V] */
    float conductance; /* 1/R [S] */
    float share;       /* of the new power in h, 1 - exp(-t/tau) [-] */
    float per_square;  /* h per period of a look that the chopper was on, and u^2 [1/V^2] */
    uint32_t most;     /* [periods] of a look */
    uint32_t looks;    /* [looks] of CHOPPER_LOOK */
} chopper_watch_tuning_t;

typedef struct {
    float u_dc;       /* [V] */
    uint32_t chopped; /* [periods] of this look in which the chopper was on */
    float power;      /* that the motor takes from the link [W]; negative: it returns power */
} chopper_watch_input_t;

typedef struct {
    float heat;          /* h [-] */
    float began;         /* u at the begin of the present judgement [V] */
    float taken;         /* sum of u^2/(2 R) over its looks [W] */
    float returned;      /* sum of the power that the motor returned [W] */
    uint32_t looks;      /* [looks] of it; 0: none */
    uint32_t conditions; /* [-] CHOPPER_... bits */
} chopper_watch_t;

/* Computes the coefficients. Divisions: for the background. */
chopper_watch_tuning_t chopper_watch_prepare(const chopper_watch_params_t *params);

/* One look, once per window, where tuning->on is not 0. No division. */
void chopper_watch_step(chopper_watch_t *x, const chopper_watch_tuning_t *tuning,
                        const chopper_watch_input_t *input);

#endif
