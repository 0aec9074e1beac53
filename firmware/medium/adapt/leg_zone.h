/* The half width w of the range of currents in which the sign of a leg's loss is not certain.
 *
 * Around zero the capacitance of the node makes the sign linear within +-zone. In a dead time T_e the sign s
 * of the leg itself changes its current by z s with z = T_e u_dc/(3 L), and the samples, which contain the
 * effect of both edges, already show half of it: with equal signs at both edges and a duty of 1/2, where a
 * current crosses zero,
 *
 *     s zone = i - z/2 s,   w = zone + z/2
 *
 * for the current i of fast/inverter/edges.h. z is 20 mA with 12.5 mH and 311 V, but 0.16 A with 1.5 mH.
 *
 * No state. Derivation: docs/theory.md, 12. */
#ifndef MEDIUM_ADAPT_LEG_ZONE_H
#define MEDIUM_ADAPT_LEG_ZONE_H

#include "math/bounds.h"

/* One over the half width [1/A], for the zone `per_zone` [1/A] and the shift z/2 [A]. One division. */
static inline float leg_zone_inverse(float per_zone, float shift)
{
    const float x = per_zone * bounds_magnitude(shift);
    const float wide = 1.0f + x;
    return per_zone * wide / (1.0f + x * wide);
}

#endif
