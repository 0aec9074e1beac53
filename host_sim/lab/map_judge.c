/* Points of a map, found and judged. */
#include <math.h>

#include "host_sim/lab/map.h"

static const double limits[MAP_CLAIMS] = {
    [MAP_CLAIM_INDUCTANCE] = 2.0, [MAP_CLAIM_NO_EFFECT] = 0.3, [MAP_CLAIM_LEARNT] = 2.0}; /* [mrad] */

const map_point_t *map_find(const map_point_t *points, size_t count, map_deviation_t deviation, double rpm,
                            double load, map_adaptation_t adaptation)
{
    for (size_t n = 0; n < count; n++) {
        if (points[n].deviation == deviation && points[n].rpm == rpm && points[n].load == load &&
            points[n].adaptation == adaptation) {
            return &points[n];
        }
    }
    return NULL;
}

static bool speaks_of(map_claim_t claim, const map_point_t *point)
{
    const bool of_inductance =
        point->deviation == MAP_INDUCTANCE_LOW || point->deviation == MAP_INDUCTANCE_HIGH;
    switch (claim) {
    case MAP_CLAIM_INDUCTANCE:
        return of_inductance;
    case MAP_CLAIM_NO_EFFECT:
        return point->deviation >= MAP_FLUX_LOW && point->deviation <= MAP_RESISTANCE_HIGH;
    case MAP_CLAIM_LEARNT:
        return of_inductance && point->adaptation == MAP_ADAPTATION_ON;
    case MAP_CLAIMS:
        break;
    }
    return false;
}

/* What a deviation does to the mean, theory taken off unless it is to be forgotten altogether [mrad]. */
static double distance(map_claim_t claim, const map_point_t *point, const map_point_t *nominal)
{
    const double theory = claim == MAP_CLAIM_LEARNT ? 0.0 : point->theory_mrad - nominal->theory_mrad;
    return fabs(point->mean_mrad - nominal->mean_mrad - theory);
}

map_verdict_t map_judge(const map_point_t *points, size_t count, map_claim_t claim)
{
    map_verdict_t verdict = {.limit_mrad = limits[claim]};
    for (size_t n = 0; n < count; n++) {
        const map_point_t *point = &points[n];
        if (!speaks_of(claim, point)) {
            continue;
        }
        const map_point_t *nominal =
            map_find(points, count, MAP_NOMINAL, point->rpm, point->load, point->adaptation);
        if (!point->locked || nominal == NULL || !nominal->locked) {
            verdict.lost++;
            continue;
        }
        const double found = distance(claim, point, nominal);
        verdict.judged++;
        if (verdict.worst == NULL || found > verdict.worst_mrad) {
            verdict.worst = point;
            verdict.worst_mrad = found;
        }
    }
    verdict.met = verdict.judged > 0u && verdict.lost == 0u && verdict.worst_mrad <= verdict.limit_mrad;
    return verdict;
}
