/* Current watch: judges the current sensors and the wires to the motor. It compares the measured
 * current with the law of the winding,
 *
 *     L Di = sum of T u - R sum of T i - psi_f Dn,    n = (cos theta_e, sin theta_e)
 *
 * over windows of several periods: the change of the current by the voltage that was applied, p, with the
 * change that the sensors measure, m; and the requested current with the measured one. The EMF follows from
 * the assumed angle and speed of the rotor, not from the observer, because the observed EMF follows the
 * sensors even if they are wrong.
 *
 *     stuck   a sensor's value has not changed by one bit, and p exceeds the effect of wrong assumed values,
 *                 d = T_w/L (U_dead + R/2 |i| + share psi_f |omega_e|);   sum of |p| - d above the limit
 *             or p differs from the p - m of the window before the value became constant by more than these
 *             effects can change
 *             or the value has not changed for long, while another sensor's value and p have changed
 *             or it has not changed for so long that the noise of the sensors rules it out
 *             Three values that add up to zero are those of the currents: none of them is stuck.
 *     gain    of the new part of the change in a window, Dm against Dp:  g = sum Dm Dp/sum Dp^2  per sensor;
 *             all of them outside GAIN_MIN .. GAIN_MAX, or one differs from another by more than GAIN_RATIO
 *             and by more than the saliency of a rotor in any position explains
 *     loss    a phase for which a current is requested in two windows in succession, on their mean, with
 *             more voltage than the dead time may take, has nearly no current of this sign for some time;
 *             if no other phase carries current, with more voltage than the dead time and the uncertain EMF;
 *             the dead time is enough for a phase that has carried a current of the other sign only;
 *             or for twice the time, while the current of any phase deviates from the requested one;
 *             or its voltage exceeds the effect of any rotor's flux
 *     sum     three sensors whose currents do not add up to zero
 *
 * Derivation, margins and undetected errors: docs/theory.md, 27. Only the voltage is summed in each period;
 * the rest is computed once per window. No division.
 *
 * Does not handle: a sensor that is stuck while nothing changes; a wrong gain while
 * the current never changes fast. */
#ifndef MEDIUM_PROTECT_CURRENT_WATCH_H
#define MEDIUM_PROTECT_CURRENT_WATCH_H

#include <stdbool.h>
#include <stdint.h>

#include "math/bounds.h"
#include "math/frames.h"
#include "math/winding.h"

/* Conditions of the fault table. */
#define CURRENT_WATCH_STUCK UINT32_C(1) /* a sensor does not show the current that must flow */
#define CURRENT_WATCH_GAIN  UINT32_C(2) /* the gain of all sensors, or of one, is wrong */
#define CURRENT_WATCH_LOSS  UINT32_C(4) /* no current flows through a phase */
#define CURRENT_WATCH_SUM   UINT32_C(8) /* three currents do not add up to zero */
/* One of the first three conditions may follow, so that the EMF is not valid. */
#define CURRENT_WATCH_MAYBE UINT32_C(16)

typedef struct {
    float resistance;   /* R [ohm] */
    float inductance_d; /* L_d [H], > 0 */
    float inductance_q; /* L_q [H], > 0 */
    float least;        /* smallest incremental L at the largest current [H], > 0; a saturated axis has less
                           than L_d and L_q */
    float flux_linkage; /* psi_f [Wb] */
    float per_ampere;   /* K = 1.5 p^2 psi_f/J, for the rotor's acceleration [rad/s^2 per A]; 0: the rotor
                           stands still */
    float dead_time;    /* of the legs over T [-]: part of the link that may be lost */
    float drop;         /* of a device [V] */
    float range;        /* range of the sensors in both directions [A] */
    bool three_sensors; /* true: phase c has a sensor of its own */
    bool judged;        /* false: no condition is ever reported */
    float period;       /* T [s] */
} current_watch_params_t;

/* Time for which a value must not have changed. */
typedef enum {
    STILL_STUCK, /* a value that a current may have */
    STILL_JUMP,  /* a value near zero that was reached by a jump */
    STILL_ZERO,  /* another value near zero */
    STILL_KINDS
} current_watch_still_t;

/* Limits for the comparison of measured changes with expected ones. */
typedef struct {
    float least; /* smallest Dp that is judged, squared [A^2] */
    float pair;  /* least sum of Dp^2 of a sensor that is compared with the other [A^2] */
    float axis;  /* least Dp^2 of such a sensor over that of the vector, three quarters [-] */
    float ratio; /* largest gain of one sensor over the other's [-] */
    float swing; /* smallest Dp that is judged, per ampere and squared period [-] */
    float min;   /* least gain of both sensors [-] */
    float max;   /* largest gain of both sensors [-] */
} current_watch_limits_t;

typedef struct {
    uint32_t judged;   /* [-] 1 */
    winding_t winding; /* of R and the mean of L_d and L_q */
    float per_speed;   /* psi_f T/L [A s] */
    float back;        /* -T/2 [s] */
    float dead_link; /* share of the current that dead time and drops may take in a period, per volt [A/V] */
    float dead;      /* the same with zero link voltage [A] */
    float per_current;           /* part of d per ampere, for a period [-] */
    float flux;                  /* largest change of the magnets' flux in a phase over L [A] */
    float stuck;                 /* limit of the sum beyond d [A] */
    float beside;                /* least change of another sensor's value in the same time [A] */
    uint32_t still[STILL_KINDS]; /* [periods] for which a value must not have changed */
    uint32_t long_still;         /* [periods] for which no current stays constant while others change */
    float noisy;    /* mean square of a sensor's noise with which no value stays constant for long [A^2] */
    float surprise; /* largest observer error of a sound sensor [A] */
    current_watch_limits_t gain;
    float none;       /* largest value of a phase without current [A] */
    float slow_link;  /* DC link, below which the voltage limit lets a current lag far behind [V] */
    float carries;    /* least current of a phase that carries current [A] */
    int32_t absent;   /* [periods] without current that count as a loss */
    float sum;        /* largest sum of three currents [A] */
    uint32_t sensors; /* [-] 2 or 3 */
} current_watch_tuning_t;

/* State of one phase. */
typedef struct {
    float value;    /* as measured at the last window's end [A] */
    float change;   /* m of the last window [A] */
    float expected; /* p of the last window [A] */
    float stuck;    /* sum of p beyond its uncertainty since the value last changed [A] */
    float held;     /* p per period when the value was first constant [A] */
    float error;    /* p - m of the last window; at the end of a window still of the last but one [A] */
    float bias;     /* p - m of the last window in which the suspected value was certainly right [A] */
    float emf;      /* uncertain part of a window's EMF when the value was first constant [A] */
    float path;     /* sum of the magnitudes of the changes of p since then [A] */
    float beside;   /* another sensor's value then [A] */
    float fed;      /* sum of p without the EMF, beyond its uncertainty, while nearly no current flows [A] */
    int32_t absent; /* [periods] with a requested current, and without a measured one; sign of the request */
    int32_t first;  /* [periods] of the first window since a current flowed, not yet in `absent`; -1: it is */
    uint32_t still; /* [periods] for which it has not changed */
    uint32_t sure;  /* [periods] for which it must not change */
} current_watch_phase_t;

/* A ratio of m to p, while consecutive windows agree about its side. */
typedef struct {
    int32_t side;     /* [-] -1, 1: too small, too large; 0: within the limits */
    uint32_t windows; /* [windows] in succession */
    float square[2];  /* sums of Dp^2 of sensors a and b [A^2] */
    float product[2]; /* sums of Dm Dp [A^2] */
} current_watch_gain_t;

typedef struct {
    current_watch_tuning_t tuning;
    uint32_t suspected; /* [-] bits of the phases whose value is constant in a window or since a jump */
    uint32_t other;     /* [-] bits of the three phases: currents of the other sign since `absent` counts
                           (current_watch_wires.c) */
    uint32_t biased;    /* [-] bits of these with a known `bias` */
    ab_t current;       /* at the last window's end [A] */
    float emf;          /* uncertain part of the EMF in the last window [A] */
    float asked;        /* square of the requested current at the last window's end [A^2] */
    uint32_t steered; /* [-] bits: the requested length changed in this window, 1; one or two before, 2, 4 */
    uint32_t windows; /* [windows] since the watch began */
    uint32_t unknown; /* [windows] number of the last window whose values cannot be used */
    current_watch_phase_t phase[3];
    float noise;               /* mean square of Dm - Dp of a sensor where Dp is nearly zero [A^2] */
    current_watch_gain_t all;  /* of both sensors together */
    current_watch_gain_t pair; /* of a compared with b */
} current_watch_t;

/* The inputs at a window's end. */
typedef struct {
    uint32_t periods; /* [periods] of the window */
    ab_t voltage;     /* sum of the voltage that was applied in it [V] */
    dq_t asked_for;   /* sum of the requested currents, one period before each sample [A] */
    uint32_t moved;   /* [-] bits of the phases whose value differed in a sample from the last window's end */
    abc_t current;    /* measured at t_k, offsets removed [A] */
    ab_t error;       /* value expected by the observer at t_k, minus this current [A] */
    dq_t reference;   /* requested current [A] ... */
    rotation_t frame; /* ... in this frame at t_k */
    float u_dc;       /* [V] */
    rotation_t rotor; /* assumed rotation of the rotor at t_k */
    float omega_e;    /* assumed speed [rad/s]; 0 where only its speed is known */
    float doubt;      /* speed whose EMF is uncertain [rad/s] */
    bool forced;      /* true: a forced frame takes along a rotor that is aligned with it */
    bool contradicted; /* true: the EMF along a phase's axis contradicts the assumed rotor */
    bool limited;      /* true: the requested voltage was limited in one of the periods */
    bool elsewhere;    /* true: the EMF contradicts the assumed rotor along no phase's axis */
    bool comparable;   /* true: the EMF changes smoothly in this window, or as assumed */
    float noise;       /* mean square of the noise of a sensor, in the last calibration [A^2] */
} current_watch_input_t;

/* Computes the coefficients. Divisions: for the background. */
current_watch_tuning_t current_watch_prepare(const current_watch_params_t *params);

/* Takes these coefficients; nothing has been measured yet. */
void current_watch_init(current_watch_t *watch, const current_watch_tuning_t *tuning);

/* Takes over new coefficients; the state is kept. */
static inline void current_watch_take(current_watch_t *watch, const current_watch_tuning_t *tuning)
{
    watch->tuning = *tuning;
}

/* Restarts the watch: the bridge has been off, or the assumed position of the rotor has changed. */
void current_watch_begin(current_watch_t *watch);

/* True if a phase has no current, now [A] and at the last window's end, although one is requested [A] with
 * which the watch can find a loss: its wire or its sensor may be open. A current that only passes zero has
 * another value one window later. A phase that has been without its current for half of the time of a loss
 * lacks it also while less is requested. */
bool current_watch_lacks(const current_watch_t *watch, abc_t current, abc_t asked);

/* The end of a window: CURRENT_WATCH_... bits. */
uint32_t current_watch_step(current_watch_t *watch, const current_watch_input_t *input);

#endif
