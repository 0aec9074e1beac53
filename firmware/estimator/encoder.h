/* Rotor position and speed from an incremental encoder, the source for commissioning. One step per `period`;
 * `count` is the position latched at t_k, and the result belongs to t_k.
 *
 * Angle: the counter value c means that the shaft is in [c, c + 1) steps; the middle is returned,
 *
 *     theta_e = offset + 2 pi ((c + 1/2) p/N mod 1)      N counts per turn, p pole pairs
 *
 * in turns of 2^32 steps with an automatic overflow; p/N has 48 bits after the point, so neither a turn nor a
 * pole nor a count adds a rounding error. What remains is the half step pi p/N of the quantisation (1.3 mrad
 * for 10000 counts and 4 pole pairs).
 *
 * Speed: a type-II tracking loop on the wrapped difference e between that angle and its own prediction,
 *
 *     omega += r^2/T e,   prediction += T omega + r (2 - r) e,   r = 1 - exp(-bandwidth T)
 *
 * Both poles are at exp(-bandwidth T): critically damped with the natural frequency `bandwidth`, stable for
 * any value. In a steady acceleration a [rad/s^2] omega_e lags by
 *
 *     omega_hat - omega = -a T (2/r - 3/2),   about -2 a/bandwidth,
 *
 * and is exact at constant speed. The quantisation changes omega_e by at most 0.75 bandwidth times the half
 * step (2/e, the 1-norm of the loop from angle to speed; up to bandwidth T = 0.3).
 *
 * Does not handle: lost counts, the search for the index, more than half an electrical turn between two
 * samples. */
#ifndef ESTIMATOR_ENCODER_H
#define ESTIMATOR_ENCODER_H

#include <stdint.h>

#include "estimator/position.h"
#include "math/angle.h"
#include "math/bounds.h"

/* Not checked here; the drive validates the whole set of its parameters. */
typedef struct {
    float count_per_turn; /* N, counts of one mechanical turn [-]: a whole number, 2..65536 */
    float pole_pairs;     /* p [-]: a whole number, 1..32767 */
    float offset;         /* electrical angle at the lower edge of count 0 [rad], |offset| <= 1e3 */
    float bandwidth;      /* natural frequency of the speed loop [rad/s] */
    float period;         /* T [s] */
} encoder_params_t;

typedef struct {
    uint32_t last_count;      /* N - 1 [-] */
    uint32_t steps_per_count; /* p/N of a turn, rounded down [2^-32 turns] */
    uint32_t rest_per_count;  /* remainder of p/N [2^-48 turns] */
    uint32_t first;           /* angle of count 0 [2^-32 turns] */
    float angle_gain;         /* r (2 - r) [-] */
    float speed_gain;         /* r^2/T, of an error in steps [rad/s] */
    float step_gain;          /* T/(2 pi) 2^32 [s] */
} encoder_tuning_t;

typedef struct {
    uint32_t next; /* the predicted angle of the next sample [2^-32 turns], electrical */
    float omega_e; /* [rad/s], electrical */
    float missed;  /* difference of the last sample from the prediction [rad], electrical */
} encoder_t;

/* Computes the coefficients. It has divisions, one of 64 bits, and an exponential, and runs in the
 * background. */
void encoder_prepare(encoder_tuning_t *tuning, const encoder_params_t *params);

/* Sets the state of a shaft that has rested at `count`: a step with the same count returns its angle and
 * speed 0. */
void encoder_reset(encoder_t *encoder, const encoder_tuning_t *tuning, uint32_t count);

/* Continues with coefficients that differ from `before`. The speed loop keeps its state, unless a new offset,
 * number of poles or number of counts changes the angle of the counts: the loop would treat that as a motion,
 * and starts again from the last `count`. */
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

/* Almost half a turn, the range of an int32_t [2^-32 turns]. The loop cannot follow a larger movement. */
#define ENCODER_MOVE_LIMIT 2.1e9f

/* Position at t_k from the count latched then, 0..N-1 (N and above count as N-1). No loop, no division. */
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

/* Largest difference between angle and prediction while the rotor's acceleration [rad/s^2], electrical, stays
 * within this one [rad]: that of the acceleration, a T^2/r^2, and two counts. A division: for the background.
 */
float encoder_missed_most(const encoder_tuning_t *tuning, float acceleration);

/* true: the angle of the last sample has moved by more than a rotor can. `leap` [rad]: largest difference
 * from the prediction, electrical. */
static inline bool encoder_jumped(const encoder_t *encoder, float leap)
{
    return bounds_magnitude(encoder->missed) > leap;
}

/* true: a rotor that turned with the encoder, and whose load brakes it at most to standstill, may be behind
 * the prediction by the last difference m. A change of the speed by d, k samples ago, makes m = k T d
 * q^(k-1), q = 1 - r, and leaves r |m| or more of T omega, omega being the speed before the sample. The
 * decrease of the speed is a sum of such changes of one sign, thus
 *
 *     T |omega| >= r |m|,   m against omega */
bool encoder_may_brake(const encoder_t *encoder, const encoder_tuning_t *tuning);

/* Continues from the sample `count` with this speed, electrical [rad/s], in place of the prediction. The
 * motion of one period must be less than half a turn. */
void encoder_follow(encoder_t *encoder, const encoder_tuning_t *tuning, uint32_t count, float omega_e);

#endif
