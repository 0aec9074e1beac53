/* The DC link: what it leaves of torque, so that it neither rises to the trip nor falls to it while the rotor
 * can feed it, and what a supply looks like that has lost a phase.
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
 * The slopes take LINK_OVER_BAND of U_over and LINK_HOLD_BAND of
 * U_under for the whole of I. With the capacitance C the loop that each closes has the rate K_t omega_m I/(C
 * u band), which must stay below half of current control's bandwidth: docs/theory.md, 29, has the least C.
 * Towards standstill, below omega_free = LINK_FREE R I/K_t, the limits of braking open: what a rotor as slow
 * can feed into a link, (K_t omega_m)^2/(6 R) at most, the devices' drops take, and no limit may change sides
 * where the speed does.
 *
 * Supply lost: below u_hold, until the link is back above the driving limit's band. In and below that band
 * u_hold sinks by LINK_SINK of U_under in LINK_SINK_TIME: a link that the rotor holds follows. One that stays
 * above it, or above U_under beside a rotor too slow to feed it, and whose mean of LINK_FED_TIME has not
 * fallen from the one before, has a low supply that delivers. Such a supply limits nothing until the link was
 * above the band again, and is lost below U_under only. For ride_time from the loss on a link below U_under
 * is no fault: the bridge opens, the rotor coasts, and is caught when the link is back. Without ride_time (0)
 * nothing limits the driving torque.
 *
 * Ripple: largest less smallest u of LINK_WINDOW, LINK_WINDOWS of them in a row beyond LINK_RIPPLE of the
 * largest. One sag or one braking is not that many.
 *
 * Does not handle: the torque of a forced frame, brief power through i_d, a link without a capacitor. */
#ifndef MEDIUM_PROTECT_LINK_H
#define MEDIUM_PROTECT_LINK_H

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

#define LINK_SINK      0.1f   /* [-] of dc_undervoltage, by which u_hold sinks ... */
#define LINK_SINK_TIME 0.15f  /* [s] ... in this time */
#define LINK_ABOVE     0.05f  /* [-] of the band: so far above u_hold the rotor does not hold the link */
#define LINK_FED_TIME  50e-3f /* [s] of a mean that may fall by as much */

#define LINK_WINDOW  20e-3f /* [s] in which the ripple is seen: a period of the mains */
#define LINK_RIPPLE  0.1f   /* [-] of the largest voltage in it */
#define LINK_WINDOWS 5u     /* [-] in a row */

/* What holds: bits. */
#define LINK_LIMITS  UINT32_C(1) /* braking or driving is limited */
#define LINK_RIPPLES UINT32_C(2)
#define LINK_SINKS   UINT32_C(4) /* below U_under for two looks within ride_time: the bridge shall open */
#define LINK_LOST    UINT32_C(8) /* ride_time is over, and the supply still lost */

typedef struct {
    float overvoltage;  /* U_over [V] */
    float undervoltage; /* U_under [V], below U_over */
    float ride_time;    /* [s]; 0: none */
    float current_max;  /* I [A], above 0 */
    float resistance;   /* R of a phase with the device's [ohm] */
    float torque;       /* K_t = 1.5 p psi_f [N m/A], above 0 */
    float period;       /* from one look to the next [s] */
} link_params_t;

typedef struct {
    float current_max;     /* I [A] */
    float full;            /* u_full [V] */
    float braking_gain;    /* G [A/V] */
    float braking_from;    /* [V] above which braking is limited */
    float hold;            /* u_hold [V] */
    float driving_gain;    /* G' [A/V] */
    float driving_from;    /* [V] below which driving is limited; without ride_time 0 */
    float undervoltage;    /* U_under [V] */
    float free_inverse;    /* 1/omega_free [s/rad] mechanical */
    float taken;           /* LINK_TAKEN I [A] */
    float gained;          /* omega_free [rad/s] */
    float back;            /* [V] below which a supply does not hold the link above u_full */
    float sink_most;       /* [V] by which u_hold sinks */
    float sink;            /* [V] a look */
    float above;           /* [V] over u_hold */
    float above_sum;       /* [V] of as many looks as are in LINK_FED_TIME */
    uint32_t fed_looks;    /* [looks] of LINK_FED_TIME */
    uint32_t ride_looks;   /* [looks] of ride_time */
    uint32_t window_looks; /* [looks] of LINK_WINDOW */
} link_tuning_t;

typedef struct {
    float braking;       /* largest i_q against the speed [A], -LINK_TAKEN I .. I */
    float driving;       /* largest i_q with the speed [A], -I .. I */
    uint32_t limits;     /* [-] 1: one of them is not I */
    uint32_t lost_looks; /* [looks] since the supply is lost; 0: it is there */
    uint32_t low_looks;  /* [looks] below U_under, up to two */
    float slowest;       /* of the rotor since the link is above u_full, amount [rad/s] */
    uint32_t held;       /* [-] 1: a supply holds the link above u_full */
    float sunk;          /* [V] of u_hold */
    uint32_t slow;       /* [-] 1: the rotor is too slow to feed the link */
    float fed_sum;       /* of u in this window without a sign of the loss [V] */
    float fed_before;    /* of the window before it [V]; 0: there was none */
    uint32_t fed_looks;  /* [looks] of this window */
    uint32_t low;        /* [-] 1: the supply is low, and delivers */
    float largest;       /* u in this window [V] */
    float smallest;      /* likewise */
    uint32_t looks;      /* [looks] of this window */
    uint32_t rippled;    /* [-] windows with ripple in a row, up to LINK_WINDOWS */
    float ripple;        /* of the last window, peak to peak [V] */
    uint32_t conditions; /* [-] LINK_... */
} link_t;

/* Coefficients. Divisions: for the background. */
link_tuning_t link_prepare(const link_params_t *params);

/* These coefficients; nothing seen. */
void link_init(link_t *x, const link_tuning_t *tuning);

/* From here on with these coefficients; a lost supply stays so. */
void link_take(link_t *x, const link_tuning_t *tuning);

/* Does this link [V] limit the torque, or has it just done so? */
static inline bool link_is_near(const link_t *x, const link_tuning_t *tuning, float u_dc)
{
    return u_dc > tuning->braking_from || u_dc < tuning->driving_from || x->limits != 0u;
}

/* x->braking and x->driving at this link [V] and mechanical speed [rad/s], 0 where they do not act: in each
 * period in which link_is_near(). Never both below zero while the bands are apart (settings/rules.h). No
 * division. */
void link_limit(link_t *x, const link_tuning_t *tuning, float u_dc, float omega_m);

/* One look at the link [V]: supply, ripple and x->conditions. No division. */
void link_look(link_t *x, const link_tuning_t *tuning, float u_dc);

/* Is a link that is too low no fault yet? */
static inline bool link_excuses(const link_t *x, const link_tuning_t *tuning)
{
    return tuning->ride_looks != 0u && x->lost_looks <= tuning->ride_looks;
}

#endif
