/* Is the voltage that acted in the last period too uncertain to track by?
 *
 * Around a zero crossing of a phase current the sign of its leg's loss (dead_time.h) hangs on the sensor's
 * offset, for as long as the current takes to pass. That matters while the flux lost in this time could turn
 * that of the rotor by more than DOUBT_ANGLE, and the whole loss is no small part of the EMF:
 *
 *     smallest < current,   largest > current/DOUBT_SHARE,   |e| < DOUBT_EMF leg,
 *     leg current > DOUBT_ANGLE |e| largest
 *
 * with the smallest and the largest phase current, and the loss `leg` of one leg. The tracking loop coasts
 * meanwhile, and for as long as the EMF filter remembers it. Coasting needs a speed that stays, or large
 * currents whose torque the loop is told of. Reasons: docs/theory.md, 13.
 * Does not handle: which leg it is. */
#ifndef INVERTER_DOUBT_H
#define INVERTER_DOUBT_H

#include <stdbool.h>
#include <stdint.h>

#include "math/frames.h"

typedef struct {
    float current;           /* phase current below which a leg's loss is in doubt [A]; 0: never */
    float emf_cutoff;        /* low-pass of the EMF that the loop sees [rad/s]; 0: none */
    bool acceleration_known; /* is the loop told of the motor's torque? */
    float period;            /* T [s] */
} doubt_params_t;

typedef struct {
    float current;               /* [A] */
    uint32_t memory;             /* [periods] for which a doubtful voltage is remembered */
    uint32_t acceleration_known; /* [-] 0 or 1 */
} doubt_tuning_t;

typedef struct {
    doubt_tuning_t tuning;
    uint32_t left; /* [periods] for which the loop still coasts */
} doubt_t;

/* What is judged: of the last period, whose estimate is the newest there is. */
typedef struct {
    ab_t current;       /* mean of the period [A] */
    float leg;          /* loss of a leg whose sign is certain [V] */
    float amplitude;    /* |e| [V] */
    float detector;     /* of the tracking loop [-] */
    float omega_e;      /* estimated [rad/s], electrical */
    float omega_m;      /* [rad/s], mechanical */
    float omega_m_miss; /* reference - omega_m [rad/s] */
} doubt_input_t;

/* Coefficients. One division. */
doubt_tuning_t doubt_prepare(const doubt_params_t *params);

/* These coefficients; no doubt. */
void doubt_init(doubt_t *doubt, const doubt_tuning_t *tuning);

/* EMF over a leg's loss above which even a wrong sign is tracked [-]. */
#define DOUBT_EMF 4.0f

/* Can there be a doubt with this |e| [V] and this loss of a leg [V]? false: doubt_step() would say no and
 * change nothing. */
static inline bool doubt_possible(const doubt_t *doubt, float amplitude, float leg)
{
    return amplitude < DOUBT_EMF * leg || doubt->left > 0u;
}

/* true: the tracking loop shall coast over this period. Straight line. */
bool doubt_step(doubt_t *doubt, const doubt_input_t *input);

#endif
