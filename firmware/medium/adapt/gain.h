/* How quickly something is learnt, as a rate g [1/s]: quickly at first, more slowly the more has been seen.
 *
 *     dg/dt = (g_least^2 - g^2)/6
 *
 * is the Riccati equation of a value that drifts a little and is measured with noise; with 1 in the place of
 * 1/6 all that was seen would count alike, and a large error at the beginning would last. With it the error
 * falls by (1 + g_0 t/6)^-6 at first, from there on by exp(-g_least t), and what noise leaves by the square
 * root of g. Time counts only while something is seen. */
#ifndef MEDIUM_ADAPT_GAIN_H
#define MEDIUM_ADAPT_GAIN_H

#include "math/bounds.h"

#define GAIN_LEAST 0.1f /* [-] of the rate at which it begins: ten times that time is averaged over */

/* The rate [1/s] after `time` [s] of seeing, of one that began with `first` [1/s]; time * rate below 6. */
static inline float gain_step(float rate, float first, float time)
{
    const float least = GAIN_LEAST * first;
    return rate + (1.0f / 6.0f) * time * (least * least - rate * rate);
}

/* What noise may make of something that is learnt with the share `rate` [-] of its first rate: `most` at the
 * first, nothing from the share `until` [-] on; in the unit of `most`. */
static inline float gain_chance(float most, float rate, float until)
{
    return rate > until ? most * (rate - until) : 0.0f;
}

/* Of what is learnt that which is more than `chance`, in the unit of both. */
static inline float gain_beyond(float learnt, float chance)
{
    return learnt - bounds_clamp(learnt, chance);
}

#endif
