/* The largest error in a sweep over floats, stored and judged. */
#ifndef TESTS_UNIT_WORST_H
#define TESTS_UNIT_WORST_H

#include "tests/unit/compare.h"
#include "tests/unit/sweep.h"

static double worst;

void setUp(void)
{
    worst = 0.0;
}

static inline void keep_worst(double error)
{
    if (!(fabs(error) <= worst)) {
        worst = fabs(error);
    }
}

static inline void check(const char *what, double tolerance)
{
    char text[64];
    snprintf(text, sizeof text, "%s: %.3e", what, worst);
    TEST_ASSERT_TRUE_MESSAGE(worst <= tolerance, text);
}

/* The float that is n floats above `value`, which is positive. */
static inline float floats_on(float value, uint32_t n)
{
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    bits += n * (uint32_t)SWEEP;
    memcpy(&value, &bits, sizeof value);
    return value;
}

#endif
