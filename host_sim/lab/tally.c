#include "host_sim/lab/tally.h"

#include <math.h>
#include <string.h>

tally_t tally_empty(void)
{
    return (tally_t){.min = (double)INFINITY, .max = -(double)INFINITY};
}

double tally_number(uint32_t slot, slot_kind_t kind)
{
    float value;
    switch (kind) {
    case SLOT_UINT:
        return (double)slot;
    case SLOT_INT:
    case SLOT_ENUM:
        return (double)(int32_t)slot;
    case SLOT_FLOAT:
    case SLOT_KINDS:
        break;
    }
    memcpy(&value, &slot, sizeof value);
    return (double)value;
}

void tally_count(tally_t *tally, double x)
{
    tally->count++;
    const double from_mean = x - tally->mean;
    tally->mean += from_mean / tally->count;
    tally->squares_about += from_mean * (x - tally->mean);
    tally->squares += x * x;
    /* with the negations a NaN is stored and stays */
    tally->min = !(x >= tally->min) && tally->min == tally->min ? x : tally->min;
    tally->max = !(x <= tally->max) && tally->max == tally->max ? x : tally->max;
    tally->last = x;
}

double tally_value(const tally_t *tally, statistic_t statistic)
{
    if (tally->count == 0u) {
        return (double)NAN;
    }
    switch (statistic) {
    case STATISTIC_MEAN:
        return tally->mean;
    case STATISTIC_MIN:
        return tally->min;
    case STATISTIC_MAX:
        return tally->max;
    case STATISTIC_PEAK:
        return fabs(tally->min) > fabs(tally->max) || tally->min != tally->min ? fabs(tally->min)
                                                                               : fabs(tally->max);
    case STATISTIC_SD:
        return sqrt(tally->squares_about / tally->count);
    case STATISTIC_RMS:
        return sqrt(tally->squares / tally->count);
    case STATISTIC_LAST:
        return tally->last;
    case STATISTICS:
        break;
    }
    return (double)NAN;
}
