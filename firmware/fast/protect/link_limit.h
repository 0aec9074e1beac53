/* Limits of the torque by the DC link, in each period, so that the link neither rises to the trip nor falls
 * to it while the rotor can feed it.
 *
 *     braking <= G (u_full - u)         u_full = LINK_FULL U_over
 *     driving <= G' (u - u_hold)        u_hold = LINK_HOLD U_under
 *
 * both in [A] of i_q. A driving limit below zero, down to -I, is a demand to brake, by which the rotor holds
 * the link voltage (kinetic buffering). A braking limit below zero, down to -LINK_TAKEN I, removes the energy
 * from the link that a wrong offset of a current sensor has fed in. Where a supply holds the link above
 * u_full, such a limit would drive the rotor. Therefore, if the speed has risen by omega_free plus
 * LINK_GAINED of the speed since the link is above u_full, the limit stays at zero until the link is
 * LINK_BACK of U_over below u_full.
 *
 * The slopes use LINK_OVER_BAND of U_over and LINK_HOLD_BAND of U_under for the whole of I. With the
 * capacitance C, each closed loop has the rate K_t omega_m I/(C u band), which must stay below half of the
 * bandwidth of current control: docs/theory.md, 29, derives the smallest C. Near standstill, below omega_free
 * = LINK_FREE R I/K_t, there are no braking limits. At such a speed the rotor can feed at most (K_t
 * omega_m)^2/(6 R), less than the losses of the devices. Therefore no limit has to change its sign with the
 * speed.
 *
 * The medium task (medium/protect/link_watch.h) finds whether the supply is lost and by how much u_hold is
 * lowered; both come with the setpoint. Without ride_time (0) the driving torque is not limited.
 *
 * Does not handle: the torque of a forced frame, short power pulses through i_d, a link without a
 * capacitor. */
#ifndef FAST_PROTECT_LINK_LIMIT_H
#define FAST_PROTECT_LINK_LIMIT_H

#include <stdbool.h>
#include <stdint.h>

#define LINK_FULL      0.98f /* [-] of dc_overvoltage, at which the braking limit is zero */
#define LINK_OVER_BAND 0.03f /* [-] of dc_overvoltage, in which the braking limit falls from I to zero */
#define LINK_HOLD      1.15f /* [-] of dc_undervoltage, at which the rotor holds the link */
#define LINK_HOLD_BAND 0.12f /* [-] of dc_undervoltage, in which the driving limit falls from I to zero */
#define LINK_FREE      0.15f /* [-] of R I/K_t: below this speed there are no braking limits */

#define LINK_TAKEN  0.005f /* [-] of I, that may drive the rotor while the link is full */
#define LINK_GAINED 0.01f  /* [-] of the speed, largest increase by this current */
#define LINK_BACK   0.01f  /* [-] of dc_overvoltage */

typedef struct {
    float overvoltage;  /* U_over [V] */
    float undervoltage; /* U_under [V], below U_over */
    bool rides;         /* the rotor holds a link whose supply is lost */
    float current_max;  /* I [A], above 0 */
    float resistance;   /* R of a phase, resistance of the device included [ohm] */
    float torque;       /* K_t = 1.5 p psi_f [N m/A], above 0 */
} link_limit_params_t;

typedef struct {
    float current_max;  /* I [A] */
    float full;         /* u_full [V] */
    float braking_gain; /* G [A/V] */
    float braking_from; /* [V] above which braking is limited */
    float hold;         /* u_hold [V] */
    float driving_gain; /* G' [A/V] */
    float driving_from; /* [V] below which driving is limited; 0: the rotor does not hold the link */
    uint32_t rides;     /* [-] 1: the rotor holds the link */
    float free_inverse; /* 1/omega_free [s/rad] mechanical */
    float taken;        /* LINK_TAKEN I [A] */
    float gained;       /* omega_free [rad/s] */
    float back;         /* [V] below which a supply does not hold the link above u_full */
} link_limit_tuning_t;

typedef struct {
    float braking;   /* largest i_q against the direction of the speed [A], -LINK_TAKEN I .. I */
    float driving;   /* largest i_q in the direction of the speed [A], -I .. I */
    uint32_t limits; /* [-] 1: at least one of both is not I */
    uint32_t slow;   /* [-] 1: the rotor is too slow to feed the link */
    float slowest;   /* least amount of the speed since the link is above u_full [rad/s] */
    uint32_t held;   /* [-] 1: a supply holds the link above u_full */
    float sunk;      /* [V] reduction of u_hold, from the setpoint */
    uint32_t low;    /* [-] 1: the supply is low and delivers power, from the setpoint */
} link_limit_t;

/* Computes the coefficients. It has divisions and runs in the background. */
link_limit_tuning_t link_limit_prepare(const link_limit_params_t *params);

/* Sets these coefficients and the initial state. */
void link_limit_init(link_limit_t *x, const link_limit_tuning_t *tuning);

/* Continues with these coefficients. */
void link_limit_take(link_limit_t *x, const link_limit_tuning_t *tuning);

/* true: this link [V] limits the torque, or the limits of the last period act. */
static inline bool link_limit_is_near(const link_limit_t *x, const link_limit_tuning_t *tuning, float u_dc)
{
    return u_dc > tuning->braking_from || u_dc < tuning->driving_from || x->limits != 0u;
}

/* Updates x->braking and x->driving for this link [V] and mechanical speed [rad/s] (0 where they do not act).
 * It is called in each period in which link_limit_is_near() is true. Both limits are never below zero while
 * the bands are apart (settings/rules.h). No division. */
void link_limit_step(link_limit_t *x, const link_limit_tuning_t *tuning, float u_dc, float omega_m);

#endif
