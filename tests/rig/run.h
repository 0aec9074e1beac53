/* What closed-loop tests share: a rig brought to a speed, in words of the field. */
#ifndef TESTS_RIG_RUN_H
#define TESTS_RIG_RUN_H

#include <stdio.h>

#include "host_sim/rig/rig.h"
#include "unity.h"

#define RPM (2.0 * 3.14159265358979323846 / 60.0) /* [rad/s] */

static inline void run_put(rig_t *rig, const char *name, double value)
{
    if (!rig_put(rig, name, value)) {
        TEST_FAIL_MESSAGE(rig_error(rig));
    }
}

static inline void run_seconds(rig_t *rig, double seconds)
{
    rig_run(rig, (uint32_t)(seconds / RIG_PERIOD_SECONDS + 0.5));
}

static inline void run_parameter(rig_t *rig, const char *name, double value)
{
    run_put(rig, name, value);
    if (!rig_apply(rig)) {
        TEST_FAIL_MESSAGE(rig_error(rig));
    }
}

/* From power-on to ready; offsets are measured with whatever the plant does. */
static inline void run_to_ready(rig_t *rig)
{
    run_seconds(rig, 0.06);
    TEST_ASSERT_EQUAL_DOUBLE(1.0, rig_value(rig, "state"));
}

/* On, at this speed reference. */
static inline void run_on(rig_t *rig, double rpm)
{
    run_put(rig, "speed_request", rpm * RPM);
    run_put(rig, "enable", 1.0);
}

static inline void run_expect_no_fault(rig_t *rig)
{
    TEST_ASSERT_EQUAL_DOUBLE(0.0, rig_value(rig, "fault_reason"));
    TEST_ASSERT_EQUAL_DOUBLE(3.0, rig_value(rig, "state"));
}

#endif
