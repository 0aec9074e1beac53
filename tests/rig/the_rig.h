/* One simulation for each test, made by setUp() or by the test itself and freed after the test. */
#ifndef TESTS_RIG_THE_RIG_H
#define TESTS_RIG_THE_RIG_H

#include "host_sim/rig/rig.h"
#include "unity.h"

static rig_t *rig;

void tearDown(void)
{
    rig_free(rig);
    rig = NULL;
}

#endif
