/* Sequences of values of a drive as data, for the tests of the campaign's judgement. A test program
 * includes this file once. */
#ifndef TESTS_LAB_COURSES_H
#define TESTS_LAB_COURSES_H

#include <stdlib.h>
#include <string.h>

#include "settings/reasons.h"
#include "tests/lab/watched.h"

/* Turns the gates on or all off at the present time. */
static void gates(bool on)
{
    campaign_watch_edge(&watch, 0u, (uint32_t)RIG_EDGE_GATES, on ? 0x15u : 0u);
}

/* The value of a choice or a reason by its name, otherwise a number. */
static double value_by_name(const table_row_t *row, const char *name, size_t length)
{
    const char *choice = row->choices;
    for (uint32_t n = 0; *choice != '\0'; n++) {
        if (strcspn(choice, "|") == length && strncmp(choice, name, length) == 0) {
            return n;
        }
        choice += strcspn(choice, "|");
        choice += *choice == '|' ? 1 : 0;
    }
    for (uint32_t n = 0; n < reasons_count; n++) {
        if (strlen(reasons[n].name) == length && strncmp(reasons[n].name, name, length) == 0) {
            return reasons[n].number;
        }
    }
    char *end;
    const double value = strtod(name, &end);
    TEST_ASSERT_EQUAL_PTR_MESSAGE(name + length, end, name);
    return value;
}

/* Writes "row=value row=value" in this order; the row `gates` makes a gate edge. */
static void set_rows(const char *sets)
{
    while (*sets != '\0') {
        char name[40] = "";
        const size_t length = strcspn(sets, "=");
        TEST_ASSERT_TRUE_MESSAGE(length < sizeof name && sets[length] == '=', sets);
        memcpy(name, sets, length);
        const char *value = sets + length + 1u;
        sets = value + strcspn(value, " ");
        if (strcmp(name, "gates") == 0) {
            gates(*value == '1');
        } else {
            const table_row_t *row = rig_row_by_name(name);
            TEST_ASSERT_NOT_NULL_MESSAGE(row, name);
            const double number = value_by_name(row, value, (size_t)(sets - value));
            if (row->kind == SLOT_FLOAT) {
                put(name, (float)number);
            } else {
                *slot(name) = (uint32_t)(int32_t)number;
            }
        }
        sets += strspn(sets, " ");
    }
}

/* Runs this number of seconds with the present values of the slots. */
static void pass(double seconds)
{
    const uint32_t periods = campaign_periods(seconds);
    for (uint32_t n = 0; n < periods; n++) {
        campaign_watch_sample(&watch, now++, slots, count);
    }
}

#define PERIOD RIG_PERIOD_SECONDS
#define HELD   (-1)

/* The values that a drive shows, step by step, and the verdict. The verdict is HELD in all steps before
 * the last one; in the last one it is HELD or the violated invariant. */
typedef struct {
    const char *what, *fault; /* name of the course; fault in campaign_faults, "" if none */
    double value, lasts;      /* value of the fault [unit of its row] and its duration [s]; 0: to the end */
    struct {
        const char *set;
        double seconds;
    } steps[9];
    int violated;
    const char *row;  /* the row that the violation names; NULL: not checked */
    uint32_t periods; /* number of periods for which the violation has lasted; 0: not checked */
    uint32_t excused; /* the excuses that must be among the recorded ones */
} course_t;

static void inject(const char *fault, double value, double lasts)
{
    for (uint32_t n = 0; n < campaign_fault_count; n++) {
        if (strcmp(campaign_faults[n].name, fault) == 0) {
            observed.faults[0] = (campaign_injected_t){n, 0.0, value, lasts};
        }
    }
    TEST_ASSERT_TRUE_MESSAGE(fault[0] == '\0' || observed.faults[0].kind != 0u, fault);
    watch_a_drive_that_runs();
    put("true_u_dc", 311.0f);
    gates(true);
}

static void expect(int violated, const char *what)
{
    const int found = result.end == CAMPAIGN_VIOLATED ? (int)result.invariant : HELD;
    TEST_ASSERT_EQUAL_INT_MESSAGE(violated, found, what);
    TEST_ASSERT_EQUAL_MESSAGE(violated != HELD, watch.stop != 0, what);
}

/* Runs the course, which begins when the fault is injected. */
static void follow(const course_t *course)
{
    for (size_t n = 0; n < 9u && course->steps[n].set != NULL; n++) {
        expect(HELD, course->what);
        set_rows(course->steps[n].set);
        pass(course->steps[n].seconds);
    }
    expect(course->violated, course->what);
    if (course->row != NULL) {
        TEST_ASSERT_EQUAL_UINT32_MESSAGE(rig_row_by_name(course->row)->id, result.row, course->what);
    }
    if (course->periods != 0u) {
        TEST_ASSERT_EQUAL_UINT32_MESSAGE(course->periods, result.period - result.from, course->what);
    }
    TEST_ASSERT_EQUAL_HEX32_MESSAGE(course->excused, course->excused & result.excused, course->what);
}

#endif
