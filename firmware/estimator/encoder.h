/* Rotor position and speed from an incremental encoder, the commissioning source. One step per `period`;
 * `count` is the position latched at t_k and the result belongs to t_k.
 *
 * Angle: the counter at c says that the shaft is somewhere in [c, c + 1) steps; the middle is returned,
 *
 *     theta_e = offset + 2 pi ((c + 1/2) p/N mod 1)      N counts per turn, p pole pairs
 *
 * in turns of 2^32 steps that wrap by themselves; p/N has 48 bits behind the point, so neither a turn nor a
 * pole nor a count adds a rounding error. What is left is the half step pi p/N of the quantisation (1.3 mrad
 * for 10000 counts and 4 pole pairs).
 *
 * Speed: a type-II tracking loop on the wrapped difference e between that angle and its own prediction,
 *
 *     omega += r^2/T e,   prediction += T omega + r (2 - r) e,   r = 1 - exp(-bandwidth T)
 *
 * Both poles lie at exp(-bandwidth T): critically damped with the natural frequency `bandwidth`, stable for
 * any of them. In a steady acceleration a [rad/s^2] omega_e is late by
 *
 *     omega_hat - omega = -a T (2/r - 3/2),   about -2 a/bandwidth,
 *
 * and exact at constant speed. The quantisation moves omega_e by at most 0.75 bandwidth times the half step
 * (2/e, the 1-norm of the loop from angle to speed; up to bandwidth T = 0.3).
 *
 * Does not handle: lost counts, the search for the index, more than half an electrical turn between two
 * samples. */
#ifndef ESTIMATOR_ENCODER_H
#define ESTIMATOR_ENCODER_H

#include <stdint.h>

#include "estimator/position.h"
#include "math/angle.h"
#include "math/bounds.h"

/* Not checked here; the drive validates its whole set of parameters. */
typedef struct {
    float count_per_turn; /* N, counts of one mechanical turn [-]: a whole number, 2..65536 */
    float pole_pairs;     /* p [-]: a whole number, 1..32767 */
    float offset;         /* electrical angle at the lower edge of count 0 [rad], |offset| <= 1e3 */
    float bandwidth;      /* natural frequency of the speed loop [rad/s] */
    float period;         /* T [s] */
} encoder_params_t;

typedef struct {
    uint32_t last_count;      /* N - 1 [-] */
    uint32_t steps_per_count; /* p/N of a turn [2^-32 turns] */
    uint32_t rest_per_count;  /* what that leaves [2^-48 turns] */
    uint32_t first;           /* angle of count 0 [2^-32 turns] */
    float angle_gain;         /* r (2 - r) [-] */
    float speed_gain;         /* r^2/T, of an error in steps [rad/s] */
    float step_gain;          /* T/(2 pi) 2^32 [s] */
} encoder_tuning_t;

typedef struct {
    uint32_t next; /* the angle expected at the next sample [2^-32 turns], electrical */
    float omega_e; /* [rad/s], electrical */
    float missed;  /* what the angle of the last sample was off the one expected [rad], electrical */
} encoder_t;

/* Coefficients. Divisions, one of 64 bits, and an exponential: for the background. */
void encoder_prepare(encoder_tuning_t *tuning, const encoder_params_t *params);

/* As if the shaft had stood at `count` for ever: a step with the same count returns its angle and speed 0. */
void encoder_reset(encoder_t *encoder, const encoder_tuning_t *tuning, uint32_t count);

/* Other coefficients than `before`. The speed loop goes on, unless a new offset, pole or count number gives
 * the counts other angles: it would take that for a motion, and starts again from the last `count`. */
void encoder_take(encoder_t *encoder, const encoder_tuning_t *before, const encoder_tuning_t *tuning,
                  uint32_t count);

/* Electrical angle of the middle of a count step [2^-32 turns]. */
static inline uint32_t encoder_phase(const encoder_tuning_t *tuning, uint32_t count)
{
    uint32_t c = count < tuning->last_count ? count : tuning->last_count;
    return tuning->first + c * tuning->steps_per_count + ((c * tuning->rest_per_count) >> 16);
}

/* [rad per 2^-32 turns]; half a turn becomes ANGLE_LARGEST. */
#define ENCODER_ANGLE_PER_STEP (ANGLE_LARGEST / 2147483648.0f)

/* Almost half a turn [2^-32 turns], as much as an int32_t holds: who moves further has lost the angle. */
#define ENCODER_MOVE_LIMIT 2.1e9f

/* Position at t_k from the count latched there, 0..N-1 (N and above count as N-1). Straight line, no
 * division. */
static inline position_t encoder_step(encoder_t *encoder, const encoder_tuning_t *tuning, uint32_t count)
{
    uint32_t phase = encoder_phase(tuning, count);
    float error = (float)(int32_t)(phase - encoder->next);
    encoder->missed = ENCODER_ANGLE_PER_STEP * error;
    encoder->omega_e += tuning->speed_gain * error;
    float moved = tuning->step_gain * encoder->omega_e + tuning->angle_gain * error;
    encoder->next += (uint32_t)(int32_t)(bounds_within(moved, ENCODER_MOVE_LIMIT) ? moved : 0.0f);
    return (position_t){(float)(int32_t)phase * ENCODER_ANGLE_PER_STEP, encoder->omega_e};
}

/* Has the angle of the last sample moved by more than a rotor can? `leap` [rad]: electrical, the most that it
 * may be off the one expected. */
static inline bool encoder_jumped(const encoder_t *encoder, float leap)
{
    return bounds_magnitude(encoder->missed) > leap;
}

#endif
