/* For the tests of the campaign's judgement: the slots of one period, which a test writes, and the watch
 * that reads them. A test program includes this file once. */
#ifndef TESTS_LAB_WATCHED_H
#define TESTS_LAB_WATCHED_H

#include <string.h>

#include "host_sim/lab/campaign_parts.h"
#include "medium/manoeuvre/manoeuvres.h"
#include "medium/sequence.h"
#include "unity.h"

static uint32_t ids[CAMPAIGN_WATCHED_MAX];
static uint32_t slots[CAMPAIGN_WATCHED_MAX];
static uint32_t count, floats;
static campaign_case_t observed;
static campaign_result_t result;
static campaign_watch_t watch;
static uint32_t now;

static uint32_t *slot(const char *name)
{
    const uint32_t id = rig_row_by_name(name)->id;
    uint32_t *found = NULL;
    /* a signal that is judged by itself appears twice; this finds the second one. */
    for (uint32_t n = 0; n < count; n++) {
        found = ids[n] == id ? &slots[n] : found;
    }
    TEST_ASSERT_NOT_NULL_MESSAGE(found, name);
    return found;
}

static void put(const char *name, float value)
{
    memcpy(slot(name), &value, sizeof value);
}

/* Gives each quantity of the case its initial value. */
static void set_initial(campaign_case_t *drawn)
{
    for (uint32_t n = 0; n < CAMPAIGN_QUANTITY_COUNT; n++) {
        drawn->quantities[n] = campaign_quantities[n].initial;
    }
}

/* Begins to watch `observed` again, from a period on in which the drive runs. */
static void watch_a_drive_that_runs(void)
{
    result = (campaign_result_t){.invariant = CAMPAIGN_NO_INVARIANT};
    memset(slots, 0, sizeof slots);
    count = campaign_watched(ids, &floats);
    now = 0u;
    campaign_watch_begin(&watch, &observed, &result, NULL);
    *slot("state") = (uint32_t)DRIVE_OPERATION_ENABLED;
    *slot("manoeuvre") = (uint32_t)MANOEUVRE_RUN;
    *slot("enable") = (uint32_t)REQUEST_ON;
}

#endif
