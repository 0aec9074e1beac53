/* Are the current sensors and the wires to the motor sound? Measured current against the winding's own law,
 *
 *     L Di = sum of T u - R sum of T i - psi_f Dn,    n = (cos theta_e, sin theta_e)
 *
 * over windows of so many periods: what the voltage that acted must have moved the current by, p, beside what
 * the sensors say that it moved, m; and what control asks for beside what flows. Of the EMF only what is
 * believed of the rotor counts, not the observed one: that follows the sensors whatever they say.
 *
 *     stuck   a sensor's value has not moved by a bit, and p goes beyond what wrong beliefs explain,
 *                 d = T_w/L (U_dead + R/2 |i| + share psi_f |omega_e|);   sum of |p| - d above the limit
 *             or it has not for so long, while another sensor's has and p went up and down
 *     gain    of what is new of the change in a window, Dm against Dp:  g = sum Dm Dp/sum Dp^2  per sensor;
 *             all of them outside GAIN_MIN .. GAIN_MAX, or one beside another by more than GAIN_RATIO
 *     loss    a phase that is asked for current, on a window's mean, by more voltage than the dead time may
 *             take, has next to none for so long, while another carries some; or it is fed more than any
 *             rotor's flux takes
 *     sum     three sensors whose currents do not add up to zero
 *
 * Derivation, margins and what is not seen: docs/theory.md, 27. What is summed in each period is the voltage;
 * the rest is done once a window. No division.
 *
 * Does not handle: a sensor that is stuck where nothing moves; a gain of sensors through which the current
 * has never changed fast. */
#ifndef MEDIUM_PROTECT_CURRENT_WATCH_H
#define MEDIUM_PROTECT_CURRENT_WATCH_H

#include <stdbool.h>
#include <stdint.h>

#include "math/bounds.h"
#include "math/frames.h"
#include "math/winding.h"

/* Conditions of the fault table. */
#define CURRENT_WATCH_STUCK UINT32_C(1) /* a sensor does not follow what must flow */
#define CURRENT_WATCH_GAIN  UINT32_C(2) /* the sensors' gain, or that of one of them, is not as believed */
#define CURRENT_WATCH_LOSS  UINT32_C(4) /* no current flows through a phase */
#define CURRENT_WATCH_SUM   UINT32_C(8) /* three currents do not add up to zero */
#define CURRENT_WATCH_MAYBE                                                                                  \
    UINT32_C(16) /* one of the first three may follow: the EMF is not to be believed */

typedef struct {
    float resistance;   /* R [ohm] */
    float inductance_d; /* L_d [H], > 0 */
    float inductance_q; /* L_q [H], > 0 */
    float flux_linkage; /* psi_f [Wb] */
    float per_ampere;   /* K = 1.5 p^2 psi_f/J, of the rotor's acceleration [rad/s^2 per A]; 0: it stands */
    float dead_time;    /* of the legs over T [-]: what can be lost of the link */
    float drop;         /* of a device [V] */
    float range;        /* what the sensors see in both directions [A] */
    bool three_sensors; /* has phase c one of its own? */
    bool judged;        /* false: nothing is ever found */
    float period;       /* T [s] */
} current_watch_params_t;

/* For how long a value must not have moved. */
typedef enum {
    STILL_STUCK, /* one at which a current may be */
    STILL_JUMP,  /* one near zero that has jumped there */
    STILL_ZERO,  /* another one near zero */
    STILL_KINDS
} current_watch_still_t;

typedef struct {
    uint32_t judged;   /* [-] 1 */
    winding_t winding; /* of R and the mean of L_d and L_q */
    float per_speed;   /* psi_f T/L [A s] */
    float back;        /* -T/2 [s] */
    float dead_link;   /* of what dead time and drops may take of the current in a period, per volt [A/V] */
    float dead;        /* of it at no link [A] */
    float per_current; /* of d per ampere, for a period [-] */
    float flux;        /* largest change of the magnets' flux in a phase over L [A] */
    float stuck;       /* limit of what is beyond d [A] */
    float beside;      /* least that another sensor's value has moved by meanwhile [A] */
    uint32_t still[STILL_KINDS]; /* [periods] that a value must not have moved */
    uint32_t long_still; /* [periods] in which no value that belongs to a current stays, where others move */
    float surprise;      /* largest error of the observer that is none [A] */
    float gain_least;    /* shortest Dp that is judged, squared [A^2] */
    float gain_pair;     /* least sum of Dp^2 of a sensor that is compared with the other [A^2] */
    float gain_ratio;    /* most of one sensor's over the other's [-] */
    float gain_swing;    /* shortest Dp that is judged, per ampere and squared period [-] */
    float gain_min;      /* of the sensors together [-] */
    float gain_max;      /* likewise */
    float none;          /* largest current of a phase that has none [A] */
    float slow_link;     /* DC link, below which the limit of the voltage lets a current lag far behind [V] */
    float carries;       /* least of one that does [A] */
    uint32_t absent;     /* [periods] without current that are a loss */
    float sum;           /* largest sum of three currents [A] */
    uint32_t sensors;    /* [-] 2 or 3 */
} current_watch_tuning_t;

/* Of one phase. */
typedef struct {
    float value;    /* as measured at the last window's end [A] */
    float change;   /* m of the last window [A] */
    float expected; /* p of the last window [A] */
    float stuck;    /* sum of what p is beyond its doubt since the value has not moved [A] */
    float held;     /* p of a period when it did not for the first time [A] */
    float emf;    /* what of a window's EMF may be wrong, by what was believed of the rotor before that [A] */
    float path;   /* how far p has gone from that since, up and down [A] */
    float beside; /* another sensor's value then [A] */
    float fed;    /* sum of p without the EMF, beyond its doubt, while next to no current flows [A] */
    uint32_t absent; /* [periods] asked for current, and without */
    uint32_t still;  /* [periods] in all of which it has not moved */
    uint32_t sure;   /* [periods] for which it must not */
} current_watch_phase_t;

/* What a ratio of m to p says, as long as one window after the other says so. */
typedef struct {
    int32_t side;     /* [-] -1, 1: too small, too large; 0: neither */
    uint32_t windows; /* [windows] in a row */
    float square[2];  /* sums of Dp^2 of sensors a and b [A^2] */
    float product[2]; /* sums of Dm Dp [A^2] */
} current_watch_gain_t;

typedef struct {
    current_watch_tuning_t tuning;
    uint32_t suspected; /* [-] bits of the phases whose value has not moved in a window, or has jumped and not
                           moved since */
    ab_t current;       /* at the last window's end [A] */
    float emf;          /* what of the EMF could be wrong in the last window [A] */
    float asked;        /* square of the current that control asked for at the last window's end [A^2] */
    uint32_t steered;   /* [-] bits: asked for another length of it in this window, 1, and in the last two, 2
                           and 4 */
    uint32_t windows;   /* [windows] in a row of which all is known, up to 3 */
    current_watch_phase_t phase[3];
    float noise;               /* mean square of Dm - Dp of a sensor where Dp is next to nothing [A^2] */
    current_watch_gain_t all;  /* of both sensors together */
    current_watch_gain_t pair; /* of a beside b */
} current_watch_t;

/* What a window's end brings. */
typedef struct {
    uint32_t periods; /* [periods] of the window */
    ab_t voltage;     /* sum of what acted in it [V] */
    dq_t asked_for;   /* sum of what control asked for, a period before each sample [A] */
    uint32_t moved; /* [-] bits of the phases whose value has not stayed in all of its samples what it was at
                       the end of the window before */
    abc_t current;  /* measured at t_k, offsets removed [A] */
    ab_t error;     /* what the observer expects there, less that [A] */
    dq_t reference; /* what control asks for [A] ... */
    rotation_t frame;  /* ... in this frame at t_k */
    float u_dc;        /* [V] */
    rotation_t rotor;  /* where it is believed at t_k */
    float omega_e;     /* [rad/s] likewise; 0 where only its speed is known */
    float doubt;       /* speed whose EMF may be wrong [rad/s] */
    bool forced;       /* does a forced frame take the rotor along? */
    bool contradicted; /* does the EMF along a phase's axis contradict where the rotor is believed? */
    bool limited;      /* has control not got the voltage that it asked for, in one of the periods? */
    bool elsewhere;    /* does it contradict along none? */
    bool comparable;   /* does the EMF go on smoothly in this window, or as it is believed? */
} current_watch_input_t;

/* Coefficients. Divisions: for the background. */
current_watch_tuning_t current_watch_prepare(const current_watch_params_t *params);

/* These coefficients; nothing seen. */
void current_watch_init(current_watch_t *watch, const current_watch_tuning_t *tuning);

/* New coefficients; what has been seen stays. */
static inline void current_watch_take(current_watch_t *watch, const current_watch_tuning_t *tuning)
{
    watch->tuning = *tuning;
}

/* From here on, with nothing seen: the bridge has been off, or the rotor is believed elsewhere. */
void current_watch_begin(current_watch_t *watch);

/* Is there a phase that is asked for current [A] and has none, now [A] and at the last window's end? Its wire
 * or its sensor may be open. A current that only passes zero is elsewhere a window later. */
bool current_watch_lacks(const current_watch_t *watch, abc_t current, abc_t asked);

/* The end of a window: CURRENT_WATCH_... bits. */
uint32_t current_watch_step(current_watch_t *watch, const current_watch_input_t *input);

#endif
