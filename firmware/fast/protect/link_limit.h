/* What the DC link leaves of torque, in each period, so that it neither rises to the trip nor falls to it
 * while the rotor can feed it.
 *
 *     braking <= G (u_full - u)         u_full = LINK_FULL U_over
 *     driving <= G' (u - u_hold)        u_hold = LINK_HOLD U_under
 *
 * both [A] of i_q. A driving limit below zero, down to -I, is a demand to brake, by which the rotor holds the
 * link up (kinetic buffering). A braking limit below zero, down to -LINK_TAKEN I and no further, takes from
 * the link what a wrong zero of a current sensor has fed in. Where a supply holds the link above u_full, that
 * would drive the rotor: once the rotor has become faster by omega_free and LINK_GAINED of its speed since
 * the link is there, the limit stays at zero until the link is LINK_BACK of U_over below u_full.
 *
 * The slopes take LINK_OVER_BAND of U_over and LINK_HOLD_BAND of U_under for the whole of I. With the
 * capacitance C the loop that each closes has the rate K_t omega_m I/(C u band), which must stay below half
 * of current control's bandwidth: docs/theory.md, 29, has the least C. Towards standstill, below omega_free =
 * LINK_FREE R I/K_t, the limits of braking open: what a rotor as slow can feed into a link, (K_t
 * omega_m)^2/(6 R) at most, the devices' drops take, and no limit may change sides where the speed does.
 *
 * Whether the supply is lost, and by how much u_hold has sunk, is found by the medium task
 * (medium/protect/link_watch.h) and comes with the setpoint. Without ride_time (0) nothing limits the driving
 * torque.
 *
 * Does not handle: the torque of a forced frame, brief power through i_d, a link without a capacitor. */
#ifndef FAST_PROTECT_LINK_LIMIT_H
#define FAST_PROTECT_LINK_LIMIT_H

#include <stdbool.h>
#include <stdint.h>

#define LINK_FULL      0.98f /* [-] of dc_overvoltage: no braking */
#define LINK_OVER_BAND 0.03f /* [-] of dc_overvoltage, in which braking goes from all to none */
#define LINK_HOLD      1.15f /* [-] of dc_undervoltage, at which the rotor holds the link */
#define LINK_HOLD_BAND 0.12f /* [-] of dc_undervoltage, in which driving goes from all to none */
#define LINK_FREE      0.15f /* [-] of R I/K_t: below that speed the limits of braking open */

#define LINK_TAKEN  0.005f /* [-] of I, that may drive where the link is full */
#define LINK_GAINED 0.01f  /* [-] of the speed, that the rotor may gain by it */
#define LINK_BACK   0.01f  /* [-] of dc_overvoltage */

typedef struct {
    float overvoltage;  /* U_over [V] */
    float undervoltage; /* U_under [V], below U_over */
    bool rides;         /* the rotor holds a link whose supply is lost */
    float current_max;  /* I [A], above 0 */
    float resistance;   /* R of a phase with the device's [ohm] */
    float torque;       /* K_t = 1.5 p psi_f [N m/A], above 0 */
} link_limit_params_t;

typedef struct {
    float current_max;  /* I [A] */
    float full;         /* u_full [V] */
    float braking_gain; /* G [A/V] */
    float braking_from; /* [V] above which braking is limited */
    float hold;         /* u_hold [V] */
    float driving_gain; /* G' [A/V] */
    float driving_from; /* [V] below which driving is limited; where the rotor does not hold the link 0 */
    uint32_t rides;     /* [-] 1: the rotor holds the link */
    float free_inverse; /* 1/omega_free [s/rad] mechanical */
    float taken;        /* LINK_TAKEN I [A] */
    float gained;       /* omega_free [rad/s] */
    float back;         /* [V] below which a supply does not hold the link above u_full */
} link_limit_tuning_t;

typedef struct {
    float braking;   /* largest i_q against the speed [A], -LINK_TAKEN I .. I */
    float driving;   /* largest i_q with the speed [A], -I .. I */
    uint32_t limits; /* [-] 1: one of them is not I */
    uint32_t slow;   /* [-] 1: the rotor is too slow to feed the link */
    float slowest;   /* of the rotor since the link is above u_full, amount [rad/s] */
    uint32_t held;   /* [-] 1: a supply holds the link above u_full */
    float sunk;      /* [V] of u_hold, by the setpoint */
    uint32_t low;    /* [-] 1: the supply is low and delivers, by the setpoint */
} link_limit_t;

/* Coefficients. Divisions: for the background. */
link_limit_tuning_t link_limit_prepare(const link_limit_params_t *params);

/* These coefficients; nothing seen. */
void link_limit_init(link_limit_t *x, const link_limit_tuning_t *tuning);

/* From here on with these coefficients. */
void link_limit_take(link_limit_t *x, const link_limit_tuning_t *tuning);

/* Does this link [V] limit the torque, or has it just done so? */
static inline bool link_limit_is_near(const link_limit_t *x, const link_limit_tuning_t *tuning, float u_dc)
{
    return u_dc > tuning->braking_from || u_dc < tuning->driving_from || x->limits != 0u;
}

/* x->braking and x->driving at this link [V] and mechanical speed [rad/s], 0 where they do not act: in each
 * period in which link_limit_is_near(). Never both below zero while the bands are apart (settings/rules.h).
 * No division. */
void link_limit_step(link_limit_t *x, const link_limit_tuning_t *tuning, float u_dc, float omega_m);

#endif
