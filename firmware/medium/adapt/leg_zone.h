/* The zone of currents in which the sign at an edge of a leg is not certain.
 *
 * Around zero the capacitance of the node makes the sign linear within +-zone. The model of the currents at
 * the edges (fast/inverter/edges.h) takes the loss of both edges from the mean current. If the two edges of
 * the leg lose different shares s' and s" of T_e, its currents are wrong by
 *
 *     z (1 - d) (s' + s")/2 and (z/2) s,   z = T_e u_dc/(3 L)
 *
 * since the samples contain the EMF and this loss together, and each edge shifts the current at the other
 * one. Therefore a sign is certain beyond z only, and the half width is the larger of zone and z. z is 20 mA
 * with 12.5 mH and 311 V, but 0.16 A with 1.5 mH.
 *
 * No state. Derivation: docs/theory.md, 12. */
#ifndef MEDIUM_ADAPT_LEG_ZONE_H
#define MEDIUM_ADAPT_LEG_ZONE_H

#include "math/bounds.h"

/* One over the half width [1/A], for the zone `per_zone` [1/A] and the shift z/2 [A]. One division. */
static inline float leg_zone_inverse(float per_zone, float shift)
{
    return per_zone / (1.0f + per_zone * bounds_magnitude(shift));
}

#endif
