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
 * currents whose torque the loop receives, with a load that turns the rotor by little meanwhile, for nobody
 * knows whether it turns round with the speed; and with an inertia by which the speed has changed until now
 * as foreseen, but for a share that turns the rotor by little, too. Reasons: docs/theory.md, 13. Does not
 * handle: which leg it is. */
#ifndef FAST_INVERTER_DOUBT_H
#define FAST_INVERTER_DOUBT_H

#include <stdbool.h>
#include <stdint.h>

#include "math/bounds.h"
#include "math/frames.h"

#define DOUBT_EMF   4.0f /* [-] of a leg's loss: a longer EMF is tracked even by a wrong sign */
#define DOUBT_SHARE 0.2f /* [-] of the largest phase current that may be in doubt: else all of a turn is */
#define DOUBT_REMEMBERED                                                                                     \
    0.577f /* [-] of it a turn by a radian while a crossing is remembered takes as much time */
#define DOUBT_ANGLE        0.005f /* [rad] */
#define DOUBT_SPEED_STEADY 8.0f   /* [rad/s] slower, a current is near zero for too long to coast */
#define DOUBT_DETECTOR     0.1f   /* [-] a loop with an error to work off shall work; noise is no error */
#define DOUBT_SPEED_HEAVY                                                                                    \
    0.2f /* [-] of the speed that may be missing: further from it, nothing may be missed */
#define DOUBT_SPEED_LIGHT    0.1f  /* [-] the same for a rotor that leaves its speed during one crossing */
#define DOUBT_TIME           5e-3f /* [s] that a crossing and its memory last at the speeds in question */
#define DOUBT_TURN           0.02f /* [rad] by which no more may turn the rotor meanwhile than was foreseen */
#define DOUBT_SHARE_FORESEEN 0.1f  /* [-] DOUBT_SHARE while the speed changes as the loop expects */
#define DOUBT_SPEED_FORESEEN 3.0f  /* [rad/s] DOUBT_SPEED_STEADY then */

typedef struct {
    float current;           /* phase current below which a leg's loss is in doubt [A]; 0: never */
    float emf_cutoff;        /* low-pass of the EMF that the loop sees [rad/s]; 0: none */
    bool acceleration_known; /* is the loop told of the motor's torque? */
    float acceleration;      /* of the rotor at the limit of current [rad/s^2], electrical, > 0 */
    float current_max;       /* that limit [A] */
    float period;            /* T [s] */
} doubt_params_t;

typedef struct {
    float current;         /* [A] */
    uint32_t memory;       /* [periods] for which a doubtful voltage is remembered */
    float share_per_speed; /* by which that memory lessens DOUBT_SHARE [s/rad] */
    float load_most;       /* with which a change of speed is foreseen [A]; 0: none is */
    float speed_share;     /* of the speed that may be missing [-] */
    float miss_share;      /* of the speed gained that may not have been foreseen [-] */
} doubt_tuning_t;

typedef struct {
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
    float load;         /* part of i_q that carries the load, as far as it is known [A] */
    float gained;       /* speed since its reference moved [rad/s], electrical; 0: it stands */
    float foreseen;     /* the same from the current [rad/s]; 0: it stands */
} doubt_input_t;

/* Coefficients. Two divisions. */
doubt_tuning_t doubt_prepare(const doubt_params_t *params);

/* No doubt. */
static inline void doubt_init(doubt_t *doubt)
{
    doubt->left = 0u;
}

/* Is an EMF of this length [V] small beside the loss of a leg [V]? */
static inline bool doubt_small(float amplitude, float leg)
{
    return amplitude < DOUBT_EMF * leg;
}

/* Is doubt_step() to be asked? Else, as most of the time, there is no doubt, and none to remember. */
static inline bool doubt_may_be(const doubt_t *doubt, float amplitude, float leg)
{
    return doubt->left != 0u || doubt_small(amplitude, leg);
}

/* true: the tracking loop shall coast over this period. Straight line; no division. It changes nothing where
 * doubt_may_be() is false. */
static inline bool doubt_step(doubt_t *doubt, const doubt_tuning_t *tuning, const doubt_input_t *input)
{
    if (!doubt_may_be(doubt, input->amplitude, input->leg)) {
        return false;
    }
    const bool small = doubt_small(input->amplitude, input->leg);
    const abc_t phases = frames_inverse_clarke(input->current);
    const bounds_span_t span =
        bounds_span(bounds_magnitude(phases.a), bounds_magnitude(phases.b), bounds_magnitude(phases.c));
    const float zone = tuning->current;
    const float speed = bounds_magnitude(input->omega_e);

    const bool near =
        bounds_within(input->omega_m_miss, tuning->speed_share * bounds_magnitude(input->omega_m));
    const bool steady = near && bounds_within(input->detector, DOUBT_DETECTOR) && speed >= DOUBT_SPEED_STEADY;
    const bool far = !bounds_within(input->omega_m_miss, bounds_magnitude(input->omega_m));
    const bool borne_out = bounds_magnitude(input->gained - input->foreseen) <=
                           tuning->miss_share * bounds_magnitude(input->gained);
    const bool foreseen = far && borne_out && bounds_within(input->load, tuning->load_most) &&
                          zone < DOUBT_SHARE_FORESEEN * span.largest && speed >= DOUBT_SPEED_FORESEEN;
    const float share = DOUBT_SHARE - tuning->share_per_speed * speed;
    if (!steady && !foreseen) {
        doubt->left = 0u;
    } else if (span.smallest < zone && zone < share * span.largest && small &&
               input->leg * zone > DOUBT_ANGLE * input->amplitude * span.largest) {
        doubt->left = tuning->memory;
    } else if (doubt->left > 0u) {
        doubt->left--;
    }
    return doubt->left > 0u;
}

#endif
