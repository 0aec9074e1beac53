/* Field weakening: the torque limit by the voltage, and the i_d that a torque
 * needs, for a rotor of any saliency.
 *
 *     psi_m = (u (1 + trim) - R (i n))/|omega|      largest flux that the voltage u permits, a share of
 *                                                   the DC link; n the direction of the EMF
 *     (psi_f + L_d i_d)^2 + (L_q i_q)^2 <= psi_m^2  the voltage ellipse
 *     i_d^2 + i_q^2 <= I^2                          the current circle
 *
 * The most torque at a speed is at the largest i_d of three: the intersection of circle and ellipse, the
 * point of most torque on the ellipse (MTPV), and -I. A smaller torque is made with the largest i_d, up to
 * that of most torque per ampere, at which the ellipse permits it: between the two the torque falls with i_d,
 * and bisection finds it. Errors of the motor data in the voltage are corrected by `trim`, from the voltage
 * that current control requests (docs/theory.md, 30).
 *
 * One look and one step per window. Does not handle: saturation of the d axis, over-modulation. */
#ifndef MEDIUM_MANOEUVRE_WEAKENING_H
#define MEDIUM_MANOEUVRE_WEAKENING_H

#include <stdint.h>

#include "math/frames.h"

typedef struct {
    float flux_linkage; /* psi_f [Wb] */
    float inductance_d; /* L_d [H] */
    float inductance_q; /* L_q [H]; L_d for a round rotor */
    float resistance;   /* R [ohm] */
    float current_max;  /* I [A] */
    float i_d_mtpa;     /* of most torque per ampere at I [A], not above zero */
    float use;          /* u over U_dc [-]; 0: no weakening */
    float period;       /* of a step [s] */
} weakening_params_t;

typedef struct {
    float flux_linkage; /* psi_f [Wb] */
    float inductance_d; /* L_d [H] */
    float inductance_q; /* L_q [H] */
    float inverse_d;    /* 1/L_d [1/H] */
    float inverse_q;    /* 1/L_q [1/H] */
    float inverse_flux; /* 1/psi_f [1/Wb] */
    float saliency;     /* D = L_q - L_d [H] */
    float resistance;   /* R [ohm] */
    float current_max;  /* I [A] */
    float i_d_mtpa;     /* [A] */
    float use;          /* [-] of U_dc */
    float flux_bound;   /* psi_f + L_q I [Wb] */
    float trim_share;   /* of a shortfall, per step [-] */
} weakening_tuning_t;

typedef struct {
    weakening_tuning_t tuning;
    float trim;         /* [-] */
    float drop;         /* R (i n) of the last step, for a speed above zero [V] */
    float flux_most;    /* psi_m [Wb] */
    float i_d_limit;    /* at the most torque [A] */
    float i_q_most;     /* largest |i_q| between that and zero torque, without the circle [A] */
    float torque_share; /* psi_a/psi_f at the most torque [-] */
    float torque_limit; /* largest torque, as a current of psi_f [A] */
    uint32_t looks;     /* [-] 1: the voltage may limit at this speed; 0: the values above are not known */
    uint32_t weakens;   /* [-] 1: the field was weakened in the last step */
} weakening_t;

/* Computes the coefficients. Divisions: for the background. */
weakening_tuning_t weakening_prepare(const weakening_params_t *params);

/* Takes these coefficients; nothing limits. */
void weakening_init(weakening_t *weakening, const weakening_tuning_t *tuning);

/* Takes over new coefficients; the trim is kept. */
static inline void weakening_take(weakening_t *weakening, const weakening_tuning_t *tuning)
{
    weakening->tuning = *tuning;
}

/* Another L_q [H], as a q axis that saturates has it at the present i_q, until weakening_take(). A division.
 */
void weakening_bend(weakening_t *weakening, float inductance_q);

/* The limits at this DC link [V] and electrical speed [rad/s], with the voltage that current control requests
 * [V]. One division where the voltage may limit. */
void weakening_look(weakening_t *weakening, float u_dc, float omega_e, dq_t voltage);

/* i_d [A] with which the voltage permits this torque, as a current of psi_f [A] within torque_limit: `i_d`
 * [A], or less. `omega_e` [rad/s] gives the direction. One division where the voltage may limit. */
float weakening_i_d(weakening_t *weakening, float torque, float i_d, float omega_e);

#endif
