/* Detects that the voltage that acted in the last period is too uncertain for tracking.
 *
 * Around a zero crossing of a phase current, the sign of the loss of its leg (dead_time.h) depends on the
 * sensor's offset until the current has left the zone. This matters while the flux lost in this time could
 * rotate that of the rotor by more than DOUBT_ANGLE, and the whole loss is not small compared with the EMF:
 *
 *     smallest < current,   largest > current/DOUBT_SHARE,   |e| < DOUBT_EMF leg,
 *     leg current > DOUBT_ANGLE |e| largest
 *
 * with the smallest and the largest phase current, and the loss `leg` of one leg. The tracking loop coasts in
 * this time, and until the effect has decayed in the EMF filter. Coasting requires one of two conditions: a
 * steady speed, or large currents whose torque the loop receives. In the second case two errors must be small
 * enough to turn the rotor by little in this time: the load, because its direction at a reversal of speed is
 * unknown, and the difference of the speed from the change that follows from the inertia. Reasons:
 * docs/theory.md, 13. Does not handle: identification of the leg. */
#ifndef FAST_INVERTER_DOUBT_H
#define FAST_INVERTER_DOUBT_H

#include <stdbool.h>
#include <stdint.h>

#include "math/bounds.h"
#include "math/frames.h"

#define DOUBT_EMF            4.0f /* [-] of the loss of a leg: a longer EMF is tracked even with a wrong sign */
#define DOUBT_SHARE          0.2f   /* [-] of the largest phase current: limit of the doubtful current */
#define DOUBT_REMEMBERED     0.577f /* [-] of this share: reduction if the rotor turns by 1 rad in the memory */
#define DOUBT_ANGLE          0.005f /* [rad] least error of the angle that matters */
#define DOUBT_SPEED_STEADY   8.0f  /* [rad/s] at a lower speed a current is near zero for too long to coast */
#define DOUBT_DETECTOR       0.1f  /* [-] least error of the loop at which it must track; noise is smaller */
#define DOUBT_SPEED_HEAVY    0.2f  /* [-] of the speed, largest speed error for coasting */
#define DOUBT_SPEED_LIGHT    0.1f  /* [-] the same for a rotor whose speed can change during one crossing */
#define DOUBT_TIME           5e-3f /* [s] duration of a crossing and its memory at the speeds in question */
#define DOUBT_TURN           0.02f /* [rad] largest rotation in this time beyond the foreseen one */
#define DOUBT_SHARE_FORESEEN 0.1f  /* [-] replaces DOUBT_SHARE while the speed changes as expected */
/* [rad/s] replaces DOUBT_SPEED_STEADY while the speed changes as expected */
#define DOUBT_SPEED_FORESEEN 3.0f

typedef struct {
    float current;           /* phase current below which the loss of a leg is in doubt [A]; 0: never */
    float emf_cutoff;        /* cutoff of the low-pass of the EMF in the loop [rad/s]; 0: no low-pass */
    bool acceleration_known; /* the loop receives the torque of the motor */
    float acceleration;      /* of the rotor at the current limit [rad/s^2], electrical, > 0 */
    float current_max;       /* current limit [A] */
    float period;            /* T [s] */
} doubt_params_t;

typedef struct {
    float current;         /* [A] */
    uint32_t memory;       /* [periods] for which a doubtful voltage is remembered */
    float share_per_speed; /* reduction of DOUBT_SHARE per speed by this memory [s/rad] */
    float load_most;   /* largest load with which a change of speed is foreseen [A]; 0: none is foreseen */
    float speed_share; /* largest speed error as a share of the speed [-] */
    float miss_share;  /* largest share of the gained speed that was not foreseen [-] */
} doubt_tuning_t;

typedef struct {
    uint32_t left; /* [periods] for which the loop continues to coast */
} doubt_t;

/* Inputs of the last period, whose estimate is the newest one. */
typedef struct {
    ab_t current;       /* mean of the period [A] */
    float leg;          /* loss of a leg whose sign is certain [V] */
    float amplitude;    /* |e| [V] */
    float detector;     /* of the tracking loop [-] */
    float omega_e;      /* estimated [rad/s], electrical */
    float omega_m;      /* [rad/s], mechanical */
    float omega_m_miss; /* reference - omega_m [rad/s] */
    float load;         /* known part of i_q that carries the load [A] */
    float gained;       /* speed since its reference moved [rad/s], electrical; 0: constant reference */
    float foreseen;     /* the same, from the current [rad/s]; 0: constant reference */
} doubt_input_t;

/* Computes the coefficients. Two divisions. */
doubt_tuning_t doubt_prepare(const doubt_params_t *params);

/* Starts without doubt. */
static inline void doubt_init(doubt_t *doubt)
{
    doubt->left = 0u;
}

/* true: an EMF of this length [V] is small compared with the loss of a leg [V]. */
static inline bool doubt_small(float amplitude, float leg)
{
    return amplitude < DOUBT_EMF * leg;
}

/* true: doubt_step() has to be called. Most of the time there is neither doubt nor a memory, and the result
 * is false. */
static inline bool doubt_may_be(const doubt_t *doubt, float amplitude, float leg)
{
    return doubt->left != 0u || doubt_small(amplitude, leg);
}

/* true: the tracking loop has to coast over this period. No loop, no division. The step changes nothing where
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
        /* a bit that flips in the memory must not make the loop coast for longer */
        doubt->left = (doubt->left < tuning->memory ? doubt->left : tuning->memory) - 1u;
    }
    return doubt->left > 0u;
}

#endif
