/* The half width w of the range of currents in which the sign of a leg's loss is not certain.
 *
 * Around zero the capacitance of the node makes the sign linear within +-zone. In a dead time T_e the sign s
 * of the leg itself changes its current by z s with z = T_e u_dc/(3 L): a current beyond zone + z keeps its
 * sign during the whole dead time, one below zone decays towards zero. The samples show half of z s. The
 * linear passage with the same area as the mean sign over the current in the middle has
 *
 *     w = z/2 + zone (1 - e^-k)/k,   k = z/zone
 *
 * in which 1/(1 + x + x^2/3) with x = k/2 is used for (1 - e^-k)/k here: right to the second order of k, and
 * for large k, where z/2 is much larger. z is 20 mA with 12.5 mH and 311 V, but 0.16 A with 1.5 mH.
 *
 * No state. Derivation: docs/theory.md, 12. */
#ifndef MEDIUM_ADAPT_LEG_ZONE_H
#define MEDIUM_ADAPT_LEG_ZONE_H

#include "math/bounds.h"

/* One over the half width [1/A], for the zone `per_zone` [1/A] and z/2 [A]. One division. */
static inline float leg_zone_inverse(float per_zone, float half)
{
    const float x = per_zone * bounds_magnitude(half);
    const float wide = 1.0f + x + x * x * (1.0f / 3.0f);
    return per_zone * wide / (1.0f + x * wide);
}

#endif
