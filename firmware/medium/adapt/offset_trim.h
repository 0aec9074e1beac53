/* Trims the offsets of the current sensors that remain after the calibration at
 * standstill, while the motor turns.
 *
 * The EMF of a turning rotor has no mean over whole turns. An offset o of the sensors gives the estimated EMF
 * a mean: control makes the measured currents sinusoidal, so the true ones contain -o, and the observer's
 * model misses the drop R o and the shift in time of the sign change of the inverter's dead-time loss,
 *
 *     mean e_hat = -(R + 2 V_leg/(pi |i|)) o
 *
 * (docs/theory.md, 14; the second term is the describing function of a relay; some 4 ohm at 1.2 A). The mean
 * is taken over a whole number of turns, for at least TRIM_WINDOW at steady speed, and o follows by a share
 * of it. A sample represents the period before it. If a turn ends within that period, each of the two windows
 * gets its share, and less than omega T/8 samples of the turning EMF remain in a sum. If only whole samples
 * were summed, up to one sample would remain, and would vary like an offset that the trim itself causes.
 *
 * The observed EMF of a salient rotor also has a mean where an offset makes i_d pulsate; this part is
 * subtracted.
 *
 * One step per T. A leg with another dead time than its neighbours also gives e_hat a mean, which is
 * trimmed as if it were an offset: the estimate improves, and the current contains the remaining
 * error. Does not handle: speed below TRIM_SPEED_MIN or changing, currents so small that they never
 * leave the zone of the dead time. */
#ifndef MEDIUM_ADAPT_OFFSET_TRIM_H
#define MEDIUM_ADAPT_OFFSET_TRIM_H

#include <stdbool.h>
#include <stdint.h>

#include "math/angle.h"
#include "math/bounds.h"
#include "math/frames.h"

#define TRIM_SPEED_MIN   30.0f  /* [rad/s] electrical */
#define TRIM_SPEED_DRIFT 0.005f /* [-] of the speed, over a window: a larger drift is not steady */
#define TRIM_TURN_MOST   3.0f   /* [rad] turn of the rotor in a step */
#define TRIM_CURRENT_MIN 0.5f   /* [A] |i| */
#define TRIM_WINDOW      0.1f   /* [s] */
#define TRIM_LIMIT       0.2f   /* [A] of either component: a larger offset is a fault */

typedef struct {
    float gain;     /* share of o per mean volt and window [A/V], 0..0.1; 0 = off */
    float period;   /* T [s] */
    float saliency; /* D = L_q - L_d [H]; 0 = a round rotor */
} offset_trim_params_t;

typedef struct {
    float gain;              /* [A/V] */
    float saliency;          /* D [H] */
    uint32_t window_periods; /* [periods] */
} offset_trim_tuning_t;

typedef struct {
    offset_trim_tuning_t tuning;
    ab_t sum;         /* of e_hat in this window [V] */
    float ahead;      /* share of the sample before the first one that is in the sum [-] */
    uint32_t count;   /* samples in the sum, without that share [-] */
    float theta_prev; /* [rad] */
    float omega;      /* speed at the beginning [rad/s] */
    ab_t offset;      /* o [A] */
} offset_trim_t;

/* Computes the coefficients. One division. */
offset_trim_tuning_t offset_trim_prepare(const offset_trim_params_t *params);

/* Takes these coefficients; no offset is known. */
void offset_trim_init(offset_trim_t *trim, const offset_trim_tuning_t *tuning);

/* Takes over new coefficients; window and offset are kept. */
static inline void offset_trim_take(offset_trim_t *trim, const offset_trim_tuning_t *tuning)
{
    trim->tuning = *tuning;
}

/* Discards the window and continues from `offset` [A]: from the known offset when the estimate starts again,
 * and from zero after a new calibration of the sensors, which measures all of their offsets. */
void offset_trim_reset(offset_trim_t *trim, ab_t offset);

/* The inputs of a step. */
typedef struct {
    ab_t emf_hat;     /* observed EMF [V] */
    ab_t current;     /* [A] */
    rotation_t rotor; /* the estimated rotor */
    float theta_e;    /* its angle [rad] */
    float omega_e;    /* its smoothed speed [rad/s] */
    float cross;      /* psi_q - L_q i_q by the saturation of the q axis [Wb] */
} offset_trim_input_t;

/* A turn has ended, in a period in which the wrapped angle `moved` by this amount [rad]: offset_trim_step()
 * calls this. `emf` [V] is what that step has added to the sum. Two divisions at the end of a window. */
void offset_trim_turn(offset_trim_t *trim, const offset_trim_input_t *input, ab_t emf, float moved);

/* The EMF without j omega (psi_a - psi_f) e^(j theta), the part of a salient rotor that pulsates with the
 * current [V]. */
static inline ab_t offset_trim_round(const offset_trim_t *trim, const offset_trim_input_t *input)
{
    const float flux = -trim->tuning.saliency * frames_park(input->current, input->rotor).d;
    const dq_t pulsating = {-input->omega_e * input->cross, input->omega_e * flux};
    const ab_t part = frames_inverse_park(pulsating, input->rotor);
    return (ab_t){input->emf_hat.alpha - part.alpha, input->emf_hat.beta - part.beta};
}

/* o [A], stationary frame, to be subtracted from the measured currents, after a period. Straight-line code
 * except at the end of a turn. */
static inline ab_t offset_trim_step(offset_trim_t *trim, const offset_trim_input_t *input)
{
    /* A turn ends where the angle wraps, in either direction; elsewhere it moves by less than half a turn. */
    const float moved = input->theta_e - trim->theta_prev;
    const ab_t emf = offset_trim_round(trim, input);
    trim->theta_prev = input->theta_e;
    trim->sum.alpha += emf.alpha;
    trim->sum.beta += emf.beta;
    trim->count++;
    if (bounds_magnitude(moved) > ANGLE_PI) {
        offset_trim_turn(trim, input, emf, moved);
    }
    return trim->offset;
}

#endif
