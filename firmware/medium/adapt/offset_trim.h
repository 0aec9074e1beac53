/* Trims what calibration at standstill left of the current sensors' offsets, while the motor turns.
 *
 * The EMF of a turning rotor has no mean over whole turns. An offset o of the sensors gives its estimate one:
 * the control makes the currents it sees sinusoidal, so the true ones carry -o, of which the observer's model
 * knows neither the drop R o nor that the inverter's dead-time loss changes sign a little early or late,
 *
 *     mean e_hat = -(R + 2 V_leg/(pi |i|)) o
 *
 * (docs/theory.md, 14; the second term is the describing function of a relay; some 4 ohm at 1.2 A). Over a
 * whole number of turns, TRIM_WINDOW long at least and at steady speed, the mean is taken and o follows by a
 * share of it. A sample stands for the period before it; where a turn ends within that, each of two windows
 * gets its share, and of the turning EMF less than omega T/8 samples are left in a sum. Whole samples alone
 * would leave up to one, which comes and goes as an offset of the trim's own making.
 *
 * One step per T. A leg with another dead time than its neighbours also gives e_hat a mean and is trimmed
 * away as if it were an offset: the estimate profits, the current carries what remains. Does not handle:
 * speed below TRIM_SPEED_MIN or changing, currents so small that they never leave the zone of the dead time.
 */
#ifndef MEDIUM_ADAPT_OFFSET_TRIM_H
#define MEDIUM_ADAPT_OFFSET_TRIM_H

#include <stdbool.h>
#include <stdint.h>

#include "math/angle.h"
#include "math/bounds.h"
#include "math/frames.h"

#define TRIM_SPEED_MIN   30.0f  /* [rad/s] electrical */
#define TRIM_SPEED_DRIFT 0.005f /* [-] of the speed, over a window: more is not steady */
#define TRIM_CURRENT_MIN 0.5f   /* [A] |i| */
#define TRIM_WINDOW      0.1f   /* [s] */
#define TRIM_LIMIT       0.2f   /* [A] of either component: an offset beyond this is a fault, not a rest */

typedef struct {
    float gain;   /* share of o per mean volt and window [A/V], 0..0.1; 0 = off */
    float period; /* T [s] */
} offset_trim_params_t;

typedef struct {
    float gain;              /* [A/V] */
    uint32_t window_periods; /* [periods] */
} offset_trim_tuning_t;

typedef struct {
    offset_trim_tuning_t tuning;
    ab_t sum;         /* of e_hat in this window [V] */
    float ahead;      /* share of the sample before its first that is in it too [-] */
    uint32_t count;   /* samples in it, beside that [-] */
    float theta_prev; /* [rad] */
    float omega;      /* speed when it began [rad/s] */
    ab_t offset;      /* o [A] */
} offset_trim_t;

/* Coefficients. One division. */
offset_trim_tuning_t offset_trim_prepare(const offset_trim_params_t *params);

/* These coefficients; no offset known. */
void offset_trim_init(offset_trim_t *trim, const offset_trim_tuning_t *tuning);

/* New coefficients; window and offset go on. */
static inline void offset_trim_take(offset_trim_t *trim, const offset_trim_tuning_t *tuning)
{
    trim->tuning = *tuning;
}

/* Forgets the window, and goes on from `offset` [A]: where the estimate begins anew with what is known, after
 * a new calibration of the sensors, which sees all of their offsets, from zero. */
void offset_trim_reset(offset_trim_t *trim, ab_t offset);

/* A turn has ended, in a period in which the wrapped angle `moved` by so much [rad]: for offset_trim_step().
 * Two divisions at the end of a window. */
void offset_trim_turn(offset_trim_t *trim, ab_t emf_hat, float theta_e, float moved, float omega_e,
                      const ab_t *current);

/* o [A], stationary frame, to be subtracted from the measured currents, after a period with this estimated
 * EMF [V], whose angle and speed are theta_e [rad] and omega_e [rad/s], and this current [A]. Straight line
 * but at the end of a turn. */
static inline ab_t offset_trim_step(offset_trim_t *trim, ab_t emf_hat, float theta_e, float omega_e,
                                    const ab_t *current)
{
    /* A turn ends where the angle wraps, in either direction; elsewhere it moves by less than half a turn. */
    const float moved = theta_e - trim->theta_prev;
    trim->theta_prev = theta_e;
    trim->sum.alpha += emf_hat.alpha;
    trim->sum.beta += emf_hat.beta;
    trim->count++;
    if (bounds_magnitude(moved) > ANGLE_PI) {
        offset_trim_turn(trim, emf_hat, theta_e, moved, omega_e, current);
    }
    return trim->offset;
}

#endif
