/* The supply of the DC link: judges whether it is lost or only low, and whether it has lost a phase.
 *
 * The supply counts as lost while the voltage is below u_hold of fast/protect/link_limit.h, until the link is
 * above the band of the driving limit again. In and below that band u_hold decreases by LINK_SINK of U_under
 * in LINK_SINK_TIME. A link that the rotor feeds follows u_hold. The supply is only
 * low, and still delivers power, if two conditions hold. First, the link stays above u_hold, or above U_under
 * while the rotor is too slow to feed it. Second, the mean of the link voltage over LINK_FED_TIME is not less
 * than the previous one. A low supply limits nothing until the
 * link has been above the band again, and counts as lost only below U_under. For ride_time after the loss a
 * link below U_under is no fault: the bridge opens, the rotor coasts, and the drive catches it when the link
 * voltage has returned.
 *
 * Ripple: in LINK_WINDOWS consecutive windows of LINK_WINDOW the difference between the largest and the
 * smallest u is above LINK_RIPPLE of the largest. A single sag or braking does not last that long. */
#ifndef MEDIUM_PROTECT_LINK_WATCH_H
#define MEDIUM_PROTECT_LINK_WATCH_H

#include <stdbool.h>
#include <stdint.h>

#define LINK_SINK      0.1f   /* [-] of dc_undervoltage, by which u_hold decreases ... */
#define LINK_SINK_TIME 0.15f  /* [s] ... within this time */
#define LINK_ABOVE     0.05f  /* [-] of the band: this far above u_hold the rotor does not feed the link */
#define LINK_FED_TIME  50e-3f /* [s] of a mean, which is compared with the previous one */

#define LINK_WINDOW  20e-3f /* [s] in which the ripple is measured: a period of the mains */
#define LINK_RIPPLE  0.1f   /* [-] of the largest voltage in it */
#define LINK_WINDOWS 5u     /* [-] in succession */

/* The conditions: bits. */
#define LINK_LIMITS  UINT32_C(1) /* braking or driving is limited */
#define LINK_RIPPLES UINT32_C(2)
#define LINK_SINKS   UINT32_C(4) /* below U_under in two steps within ride_time: the bridge opens */
#define LINK_LOST    UINT32_C(8) /* ride_time has passed, and the supply is still lost */

typedef struct {
    float undervoltage; /* U_under [V] */
    float hold;         /* u_hold [V] */
    float band;         /* of the driving limit [V] */
    float driving_from; /* [V] below which driving is limited; 0 without ride_time */
    float ride_time;    /* [s]; 0: no ride-through */
    float period;       /* from one look to the next [s] */
} link_watch_params_t;

typedef struct {
    float undervoltage;    /* U_under [V] */
    float hold;            /* u_hold [V] */
    float driving_from;    /* [V] below which driving is limited */
    float sink_most;       /* [V] largest decrease of u_hold */
    float sink;            /* [V] decrease per look */
    float above;           /* [V] over u_hold */
    float above_sum;       /* [V] for the sum of all looks in LINK_FED_TIME */
    uint32_t fed_looks;    /* [looks] of LINK_FED_TIME */
    uint32_t ride_looks;   /* [looks] of ride_time */
    uint32_t window_looks; /* [looks] of LINK_WINDOW */
} link_watch_tuning_t;

/* State of the link. */
typedef struct {
    float u_dc;      /* [V] */
    uint32_t slow;   /* [-] 1: the rotor is too slow to feed the link */
    uint32_t limits; /* [-] 1: the link limits braking or driving */
} link_watch_input_t;

typedef struct {
    uint32_t lost_looks; /* [looks] since the loss of the supply; 0: not lost */
    uint32_t low_looks;  /* [looks] below U_under, up to two */
    float sunk;          /* [V] decrease of u_hold */
    float fed_sum;       /* sum of u in this window [V] */
    float fed_before;    /* the same of the window before [V]; 0: there was none */
    uint32_t fed_looks;  /* [looks] of this window */
    uint32_t low;        /* [-] 1: the supply is low, and delivers power */
    float largest;       /* largest u in this window [V] */
    float smallest;      /* smallest u in this window [V] */
    uint32_t looks;      /* [looks] of this window */
    uint32_t rippled;    /* [-] windows with ripple in succession, up to LINK_WINDOWS */
    float ripple;        /* of the last window, peak to peak [V] */
    uint32_t conditions; /* [-] LINK_... bits */
} link_watch_t;

/* Computes the coefficients. Divisions: for the background. */
link_watch_tuning_t link_watch_prepare(const link_watch_params_t *params);

/* One look at the link: supply, ripple and x->conditions. No division. */
void link_watch_step(link_watch_t *x, const link_watch_tuning_t *tuning, const link_watch_input_t *input);

/* True if a link voltage that is too low is no fault yet. */
static inline bool link_watch_excuses(const link_watch_t *x, const link_watch_tuning_t *tuning)
{
    return tuning->ride_looks != 0u && x->lost_looks <= tuning->ride_looks;
}

#endif
