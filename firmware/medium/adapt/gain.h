/* The rate g [1/s] of a learning law: it is high at first and falls with the time for which
 * the quantity has been observed.
 *
 *     dg/dt = (g_least^2 - g^2)/6
 *
 * is the Riccati equation of a value that drifts slowly and is measured with noise. With 1 instead of 1/6 all
 * observations would have equal weight, and a large initial error would decay slowly. With 1/6 the error
 * falls by (1 + g_0 t/6)^-6 at first and then by exp(-g_least t), and the effect of noise falls by the square
 * root of g. Time counts only while the quantity is observed. */
#ifndef MEDIUM_ADAPT_GAIN_H
#define MEDIUM_ADAPT_GAIN_H

#include "math/bounds.h"

#define GAIN_LEAST 0.1f /* [-] of the initial rate: the averaging time grows tenfold */

/* The rate [1/s] after `time` [s] of observation, for an initial rate `first`
 * [1/s]; time * rate is below 6. */
static inline float gain_step(float rate, float first, float time)
{
    const float least = GAIN_LEAST * first;
    return rate + (1.0f / 6.0f) * time * (least * least - rate * rate);
}

/* The possible effect of noise on a value that is learnt with the share `rate` [-] of its initial rate:
 * `most` at the initial rate, zero from the share `until` [-] on; in the unit of `most`. */
static inline float gain_chance(float most, float rate, float until)
{
    return rate > until ? most * (rate - until) : 0.0f;
}

/* The part of the learnt value that exceeds `chance`, in the unit of both. */
static inline float gain_beyond(float learnt, float chance)
{
    return learnt - bounds_clamp(learnt, chance);
}

#endif
