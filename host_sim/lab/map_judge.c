/* Points of a map, found and judged. */
#include <math.h>

#include "host_sim/lab/map.h"

#include "host_sim/rig/rig.h"

#define SURE 0.9 /* [-] confidence of an L that is learnt */
/* [-] share of the effect that i_d has with a wrong R. It occurs at low speed and load, where the zones of
 * the dead time cause errors of the assumed voltages. */
#define OPEN 0.2

static const double limits[MAP_CLAIMS] = {
    [MAP_CLAIM_INDUCTANCE] = 2.0,
    [MAP_CLAIM_NO_EFFECT] = 0.3,
    [MAP_CLAIM_LEARNT] =
        3.5}; /* [mrad]; with learnt values: 0.14 +- 0.90 over 32 points of 8 seeds at 100 r/min, worst 2.7 */

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
        return of_inductance && point->adaptation == MAP_ADAPTATION_OFF;
    case MAP_CLAIM_NO_EFFECT:
        return point->deviation >= MAP_FLUX_LOW && point->deviation <= MAP_RESISTANCE_HIGH &&
               point->adaptation == MAP_ADAPTATION_OFF;
    case MAP_CLAIM_LEARNT:
        return of_inductance && point->adaptation == MAP_ADAPTATION_ON && point->confidence >= SURE;
    case MAP_CLAIMS:
        break;
    }
    return false;
}

/* Change of the mean by a deviation, beyond the law of the theory and its tolerance [mrad]. */
static double distance(map_claim_t claim, const map_point_t *point, const map_point_t *nominal)
{
    const double moved = point->mean_mrad - nominal->mean_mrad;
    const double theory = point->theory_mrad - nominal->theory_mrad;
    switch (claim) {
    case MAP_CLAIM_INDUCTANCE:
        return fabs(moved - theory);
    case MAP_CLAIM_NO_EFFECT:
        return fmax(fabs(moved - theory) - OPEN * fabs(theory), 0.0);
    case MAP_CLAIM_LEARNT:
    case MAP_CLAIMS:
        break;
    }
    return fabs(moved);
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
    verdict.silent = verdict.judged == 0u && verdict.lost == 0u;
    verdict.met = verdict.judged > 0u && verdict.lost == 0u && verdict.worst_mrad <= verdict.limit_mrad;
    return verdict;
}

static const map_point_t *larger(const map_point_t *a, const map_point_t *b)
{
    return a == NULL || fabs(b->mean_mrad) > fabs(a->mean_mrad) ? b : a;
}

map_own_t map_judge_own(const map_point_t *points, size_t count)
{
    map_own_t own = {.limit_mrad = MAP_OWN_MEAN};
    for (size_t n = 0; n < count; n++) {
        const map_point_t *point = &points[n];
        if (!point->locked) {
            own.lost = own.lost != NULL ? own.lost : point;
            own.lost_count++;
            continue;
        }
        own.largest = larger(own.largest, point);
        if (point->deviation == MAP_NOMINAL) {
            own.nominal = larger(own.nominal, point);
            own.restless =
                own.restless == NULL || point->sd_mrad > own.restless->sd_mrad ? point : own.restless;
        }
    }
    own.held = own.lost == NULL && count > 0u;
    own.accurate = own.nominal != NULL && fabs(own.nominal->mean_mrad) <= own.limit_mrad &&
                   own.restless->sd_mrad <= MAP_OWN_SD;
    return own;
}
