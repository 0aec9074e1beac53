/* Rotor position and speed from an incremental encoder, the commissioning source. One step per `period`;
 * `count` is the position latched at t_k and the result belongs to t_k.
 *
 * Angle: the counter at c says that the shaft is somewhere in [c, c + 1) steps; the middle is returned,
 *
 *     theta_e = offset + 2 pi ((2c + 1) p mod 2N) / 2N      N counts per turn, p pole pairs
 *
 * with the product and its remainder in integers, so no turn and no pole adds a rounding error; what is left
 * is the half step pi p/N of the quantisation (1.3 mrad for 10000 counts and 4 pole pairs).
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

/* Not checked here; the drive validates its whole set of parameters. */
typedef struct {
    float count_per_turn; /* N, counts of one mechanical turn [-]: a whole number, 2..65536 */
    float pole_pairs;     /* p [-]: a whole number, 1..32767 */
    float offset;         /* electrical angle at the lower edge of count 0 [rad], |offset| <= 1e3 */
    float bandwidth;      /* natural frequency of the speed loop [rad/s] */
    float period;         /* T [s] */
} encoder_params_t;

typedef struct {
    /* coefficients, from encoder_init */
    uint32_t count_per_turn; /* N [-] */
    uint32_t pole_pairs;     /* p [-] */
    float turn_per_count;    /* 1/(2N) [-] */
    float angle_per_count;   /* pi/N [rad] */
    float offset;            /* [rad] */
    float angle_gain;        /* r (2 - r) [-] */
    float speed_gain;        /* r^2/T [1/s] */
    float period;            /* T [s] */
    /* state */
    float theta_next; /* the angle expected at the next sample [rad], electrical */
    float omega_e;    /* [rad/s], electrical */
} encoder_t;

/* Coefficients; expects count 0 at standstill. */
void encoder_init(encoder_t *encoder, const encoder_params_t *params);

/* Coefficients alone. A new offset, pole or count number turns the angle at once and the speed loop sees it
 * as a step: follow with encoder_reset() then. */
void encoder_retune(encoder_t *encoder, const encoder_params_t *params);

/* As if the shaft had stood at `count` for ever: a step with the same count returns its angle and speed 0. */
void encoder_reset(encoder_t *encoder, uint32_t count);

/* Position at t_k from the count latched there, 0..N-1 (N and above count as N-1). No division, bounded. */
position_t encoder_step(encoder_t *encoder, uint32_t count);

#endif
