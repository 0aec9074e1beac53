/* Limits of the current of the supply, in both directions, as limits of i_q.
 *
 *     P(i)      = 1.5 R i^2 + K_t |omega_m| i + P_r          i: i_q in the direction of the speed
 *     P_r       = <p - 1.5 R i_q^2 - K_t omega_m i_q>        low-pass of SUPPLY_LIMIT_TIME
 *     p         = 1.5 (u_d i_d + u_q i_q) + V_d (|i_a| + |i_b| + |i_c|)
 *     -u I_back <= P(i) <= u I_drawn
 *
 * p/u is the mean current of the inverter: no sensor beside those of the currents and of the link is
 * necessary. P_r contains the losses that the model omits, and the errors of R and K_t: in steady state P is
 * equal to p. The two conditions give one limit for i_q that drives the rotor, and one for i_q that brakes
 * it. Both are at least zero: a limit reduces the torque, and never reverses it. docs/theory.md, 29.2,
 * derives the limits and their accuracy.
 *
 * A large braking current takes energy from the rotor and from the supply: the limit of the drawn current
 * holds for braking as well. The limit of the returned current fades out at omega_free of
 * fast/protect/link_limit.h, as the limits by the link do: near standstill it would remove the torque that
 * holds a load, although the rotor returns less than the losses of the devices there.
 *
 * Does not handle: the current of a forced frame, the current by which the supply charges the capacitor of
 * the link, and that of a brake resistor. */
#ifndef MEDIUM_PROTECT_SUPPLY_LIMIT_H
#define MEDIUM_PROTECT_SUPPLY_LIMIT_H

#include <stdint.h>

#define SUPPLY_LIMIT_TIME 10e-3f /* [s] of the low-pass */
#define SUPPLY_LIMIT_NEAR 0.98f  /* [-] of a limit, from which it counts as reached */

typedef struct {
    float drawn;       /* I_drawn, largest current from the supply [A]; 0: no limit */
    float back;        /* I_back, largest current into the supply [A]; 0: no limit */
    float current_max; /* of i_q [A], above 0 */
    float resistance;  /* R of a phase and its device [ohm], above 0 */
    float torque;      /* K_t = 1.5 p psi_f [N m/A] */
    float drop;        /* V_d of a device at small current [V] */
    float free_emf;    /* K_t omega_free [V], below which the rotor cannot feed the link, above 0 */
    float period;      /* of a look [s] */
} supply_limit_params_t;

typedef struct {
    uint32_t on;         /* [-] 1: at least one of both limits */
    float drawn;         /* I_drawn [A]; FLT_MAX: no limit */
    float back;          /* I_back [A]; FLT_MAX: no limit */
    float current_max;   /* [A] */
    float loss;          /* 1.5 R [ohm] */
    float sixfold;       /* 6 R [ohm] */
    float free_inverse;  /* 1/(K_t omega_free) [1/V] */
    float third_inverse; /* 1/(3 R) [S] */
    float torque;        /* K_t [N m/A] */
    float drop;          /* V_d [V] */
    float share;         /* of the low-pass [-] */
} supply_limit_tuning_t;

typedef struct {
    float u_dc;          /* [V] */
    float power;         /* into the winding [W] */
    float magnitudes;    /* |i_a| + |i_b| + |i_c| [A] */
    float i_q;           /* [A] */
    float torque_share;  /* torque per i_q over that of psi_f [-]: above 1 for a salient rotor */
    float omega_m;       /* [rad/s] mechanical */
    uint32_t conducting; /* [-] 1: the bridge is on and the power is known */
    uint32_t in_rotor;   /* [-] 1: i_q is that of the rotor; 0: that of a forced frame */
} supply_limit_input_t;

typedef struct {
    float current;   /* p/u, low-pass: drawn from the supply [A]; negative: into it */
    float rest;      /* P_r [W] */
    float driving;   /* largest i_q in the direction of the speed [A], 0 .. current_max */
    float braking;   /* largest i_q against it [A], 0 .. current_max */
    uint32_t limits; /* [-] 1: i_q has reached one of both */
} supply_limit_t;

/* Computes the coefficients. Divisions: for the background. */
supply_limit_tuning_t supply_limit_prepare(const supply_limit_params_t *params);

/* Nothing is limited, and no power is known. */
void supply_limit_reset(supply_limit_t *x, const supply_limit_tuning_t *tuning);

/* One look, once per window, where tuning->on is not 0. Three divisions and two roots. */
void supply_limit_step(supply_limit_t *x, const supply_limit_tuning_t *tuning,
                       const supply_limit_input_t *input);

#endif
