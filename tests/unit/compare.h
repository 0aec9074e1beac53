/* Common code of the unit tests: the headers of C and of Unity, and functions that compare values. */
#ifndef TESTS_UNIT_COMPARE_H
#define TESTS_UNIT_COMPARE_H

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <unity.h>

#define PI 3.14159265358979323846

/* The difference of two angles [rad] in the range -pi to pi. */
static inline double circle(double difference)
{
    return difference - 2.0 * PI * nearbyint(difference / (2.0 * PI));
}

static inline void check_below(double value, double limit, const char *what)
{
    char text[120];
    snprintf(text, sizeof text, "%s: %.9g, limit %.9g", what, value, limit);
    TEST_ASSERT_TRUE_MESSAGE(value <= limit, text);
}

/* Checks that the value is below the limit and prints both; tools/salient writes the largest value of each
 * line into docs/salient.md. */
static inline void check_line(double value, double limit, const char *line)
{
    printf("measured %s: %.6g, limit %.6g\n", line, value, limit);
    check_below(value, limit, line);
}

#endif
