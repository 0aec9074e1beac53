/* Tests of the runner: its events, ramps, recording, verdicts and the end of a run.
 * tests/python/test_package.py checks that a scenario equals its calls by hand, and
 * tests/cli/test_experiments.py the statistics. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host_sim/lab/runner.h"
#include "unity.h"

#define ROWS_MAX  4u
#define ROOM      4000u
#define HEAD      "schema = 1\ntitle = \"a test\"\n"
#define SHORT_RUN HEAD "[run]\nduration = \"0.2 s\"\n[requests]\nenable = \"on\"\nspeed_request = 50\n"

static scenario_t *scenario;
static runner_result_t result;
static runner_options_t options;

/* The data that the recording function received. */
static struct {
    uint32_t period[ROOM];
    float value[ROOM][ROWS_MAX];
    uint32_t count;
    uint32_t columns;
} taken;

void setUp(void)
{
    scenario = NULL;
    memset(&result, 0, sizeof result);
    memset(&options, 0, sizeof options);
    memset(&taken, 0, sizeof taken);
}

void tearDown(void)
{
    runner_result_free(&result);
    scenario_free(scenario);
}

static void take(void *context, uint32_t period, const uint32_t *slots, uint32_t count)
{
    TEST_ASSERT_EQUAL_PTR(&taken, context);
    TEST_ASSERT_TRUE(taken.count < ROOM && count <= ROWS_MAX);
    taken.period[taken.count] = period;
    memcpy(taken.value[taken.count], slots, count * sizeof(float));
    taken.columns = count;
    taken.count++;
}

static void record(const uint32_t *ids, uint32_t count, uint32_t every)
{
    options.record = ids;
    options.record_count = count;
    options.record_every = every;
    options.sink = take;
    options.sink_context = &taken;
}

static void given(const char *text)
{
    char line[1200];
    scenario_error_t error;
    scenario_free(scenario);
    scenario = scenario_read_text("test.toml", text, strlen(text), &error);
    if (scenario == NULL) {
        TEST_FAIL_MESSAGE(scenario_error_text(&error, line, sizeof line));
    }
}

static void run(void)
{
    char line[1200];
    runner_result_free(&result);
    if (!runner_run(scenario, &options, &result)) {
        TEST_FAIL_MESSAGE(scenario_error_text(&result.error, line, sizeof line));
    }
}

/* 200 degrees mechanical are four times that electrical, which is 80 degrees of a turn. */
static void test_rotor_is_at_the_start_angle_held_or_locked(void)
{
    static const char *const shafts[] = {
        "friction_breakaway = 2\nload_kind = 1\nload_torque = 1.9\n",
        "shaft_locked = 1\n",
    };
    for (size_t n = 0; n < sizeof shafts / sizeof shafts[0]; n++) {
        char text[600];
        snprintf(text, sizeof text,
                 HEAD
                 "[run]\nduration = \"20 ms\"\n[start]\nangle = \"200 deg\"\n[plant]\n%s"
                 "[[expect]]\nsignal = \"true_theta_e\"\nstatistic = \"min\"\nat_least = \"79.9999 deg\"\n"
                 "[[expect]]\nsignal = \"true_theta_e\"\nstatistic = \"max\"\nat_most = \"80.0001 deg\"\n"
                 "[[expect]]\nsignal = \"true_omega_m\"\nstatistic = \"peak\"\nat_most = 0\n",
                 shafts[n]);
        given(text);
        run();
        TEST_ASSERT_TRUE(result.end == RUNNER_COMPLETE && result.failed == 0u);
    }
}

/* ---- events ---- */

/* The values of rows in certain periods must be exact. An event acts in its period and not before. Of two
 * events at one time the later one in the file has effect. A ramp is straight and ends at its value; a
 * later event of its row ends it; it begins at the present value of the row. */
static void test_events_and_ramps_give_their_rows_these_values(void)
{
    static const struct {
        const char *text, *row;
        struct {
            uint32_t period;
            double value;
        } at[8];
    } rows[] = {
        {"[[at]]\ntime = \"0.3 ms\"\nplant.load_torque = 5\n[[at]]\ntime = \"2.9 ms\"\nplant.load_torque = "
         "7\n"
         "[[at]]\ntime = 0\nplant.load_torque = 1\n",
         "load_torque",
         {{0, 1}, {2, 1}, {3, 5}, {28, 5}, {29, 7}}},
        {"[[at]]\ntime = \"0.3 ms\"\nplant.load_torque = 5\n[[at]]\ntime = \"0.3 ms\"\nplant.load_torque = "
         "7\n",
         "load_torque",
         {{2, 0}, {3, 7}}},
        {"[plant]\nload_torque = 1\n[[at]]\ntime = \"1 ms\"\nramp = \"1 ms\"\nplant.load_torque = 4\n",
         "load_torque",
         {{9, 1}, {10, 1}, {11, 1.0 + 3.0 * 0.1}, {15, 2.5}, {19, 1.0 + 3.0 * 0.9}, {20, 4}, {29, 4}}},
#define CUT_SHORT                                                                                            \
    "[[at]]\ntime = \"1 ms\"\nramp = \"1 ms\"\nplant.load_torque = 10\nplant.dc_voltage = 301\n"             \
    "[[at]]\ntime = \"1.5 ms\"\nplant.load_torque = 2\n"                                                     \
    "[[at]]\ntime = \"1.6 ms\"\nramp = \"0.2 ms\"\nplant.load_torque = 6\n"
        {CUT_SHORT, "load_torque", {{14, 4}, {15, 2}, {16, 2}, {17, 4}, {18, 6}, {29, 6}}},
        {CUT_SHORT, "dc_voltage", {{15, 306}, {29, 301}}}, /* the ramp of another row continues */
        {"[[at]]\ntime = \"1 ms\"\nramp = \"1 ms\"\nplant.load_torque = 10\n"
         "[[at]]\ntime = \"1.4 ms\"\nramp = \"0.2 ms\"\nplant.load_torque = 2\n",
         "load_torque",
         {{13, 3}, {14, 3}, {15, 2.5}, {16, 2}, {18, 2}, {29, 2}}},
        {"[[at]]\ntime = \"2 ms\"\nramp = \"1 ms\"\nrequests.speed_request = 10\n",
         "speed_request",
         {{20, 0}, {29, 9}}}, /* to the end of the run */
        {"[params]\nspeed_kp = 0.5\n[[at]]\ntime = \"1 ms\"\nramp = \"0.4 ms\"\nparams.speed_kp = 0.9\n",
         "speed_kp",
         {{10, 0.5}, {11, 0.5 + (0.9 - 0.5) * 0.25}, {14, 0.9}}},
    };
    for (size_t n = 0; n < sizeof rows / sizeof rows[0]; n++) {
        char text[600];
        const uint32_t id = rig_row_by_name(rows[n].row)->id;
        snprintf(text, sizeof text, HEAD "[run]\nduration = \"3 ms\"\n%s", rows[n].text);
        memset(&taken, 0, sizeof taken);
        given(text);
        record(&id, 1u, 1u);
        run();
        TEST_ASSERT_EQUAL_UINT32(30u, taken.count);
        for (size_t k = 0; k < 8u && (k == 0u || rows[n].at[k].period != 0u); k++) {
            TEST_ASSERT_TRUE_MESSAGE(taken.value[rows[n].at[k].period][0] == (float)rows[n].at[k].value,
                                     text);
        }
    }
}

static void test_rows_without_fractions_switch_where_a_ramp_begins(void)
{
    const uint32_t ids[1] = {rig_row_by_name("calibration_periods")->id};
    given(HEAD "[run]\nduration = \"2 ms\"\n[[at]]\ntime = \"1 ms\"\nramp = \"1 ms\"\n"
               "params.calibration_periods = 100\n");
    record(ids, 1u, 1u);
    run();
    uint32_t periods;
    memcpy(&periods, &taken.value[10][0], sizeof periods);
    TEST_ASSERT_EQUAL_UINT32(100u, periods);
}

static void test_a_refusal_of_the_rig_names_line_and_time(void)
{
    char line[1200];
    const uint32_t ids[1] = {rig_row_by_name("i_q")->id};
    given(SHORT_RUN "[[at]]\ntime = 0.1\nparams.dead_time = \"3 us\"\n"
                    "[[expect]]\nsignal = \"i_q\"\nstatistic = \"mean\"\nat_most = 100\n");
    record(ids, 1u, 1u);
    TEST_ASSERT_FALSE(runner_run(scenario, &options, &result));
    TEST_ASSERT_EQUAL_INT(RUNNER_REFUSED, result.end);
    scenario_error_text(&result.error, line, sizeof line);
    TEST_ASSERT_EQUAL_STRING_LEN_MESSAGE(
        "test.toml:10:8: dead_time: 3e-06 s: it changes only while the bridge is off", line, 73, line);
    TEST_ASSERT_NOT_NULL_MESSAGE(strstr(line, "(at 0.1 s)"), line);
    TEST_ASSERT_EQUAL_UINT32(1000u, taken.count); /* the samples recorded before are kept */
    TEST_ASSERT_EQUAL_UINT32(1000u, result.periods);
    TEST_ASSERT_EQUAL_INT(RUNNER_NOT_JUDGED, result.verdicts[0].judgement);
}

/* ---- recording ---- */

static void test_expectations_leave_the_recording_as_it_is(void)
{
    const uint32_t ids[2] = {rig_row_by_name("i_q")->id, rig_row_by_name("i_d")->id};
    given(HEAD "[run]\nduration = \"3.2 ms\"\n[[expect]]\nsignal = \"i_d\"\nminus = \"i_q\"\nstatistic = "
               "\"mean\"\nat_most = 1\n"
               "[[expect]]\nsignal = \"u_dc\"\nstatistic = \"mean\"\nat_most = 400\n");
    record(ids, 2u, 7u);
    run();
    TEST_ASSERT_EQUAL_UINT32(5u, taken.count);
    TEST_ASSERT_EQUAL_UINT32(28u, taken.period[4]);
    TEST_ASSERT_EQUAL_UINT32(2u, taken.columns);
}

/* ---- verdicts ---- */

static void test_a_window_holds_from_and_not_to(void)
{
    given(HEAD "[run]\nduration = \"1 ms\"\n"
               "[[expect]]\nsignal = \"period\"\nstatistic = \"min\"\nfrom = \"0.2 ms\"\nto = \"0.5 "
               "ms\"\nat_most = 1000\n"
               "[[expect]]\nsignal = \"period\"\nstatistic = \"max\"\nfrom = \"0.2 ms\"\nto = \"0.5 "
               "ms\"\nat_most = 1000\n"
               "[[expect]]\nsignal = \"period\"\nstatistic = \"last\"\nat_most = 1000\n"
               "[[expect]]\nsignal = \"period\"\nminus = \"period\"\nstatistic = \"peak\"\nat_most = 0\n");
    run();
    /* the drive counts period k as k + 1 */
    TEST_ASSERT_TRUE(result.verdicts[0].value == 3.0);
    TEST_ASSERT_TRUE(result.verdicts[1].value == 5.0);
    TEST_ASSERT_EQUAL_UINT32(3u, result.verdicts[0].samples);
    TEST_ASSERT_TRUE(result.verdicts[2].value == 10.0);
    TEST_ASSERT_EQUAL_UINT32(10u, result.verdicts[2].samples);
    TEST_ASSERT_TRUE(result.verdicts[3].value == 0.0); /* a row minus itself is zero */
}

static void test_limits_are_accepted_themselves(void)
{
    static const struct {
        const char *limits;
        runner_judgement_t judgement;
    } rows[] = {
        {"at_most = 10\n", RUNNER_MET},
        {"at_most = 9.999999\n", RUNNER_FAILED},
        {"at_least = 10\n", RUNNER_MET},
        {"at_least = 10.000001\n", RUNNER_FAILED},
        {"at_least = 10.5\nat_most = 11\n", RUNNER_FAILED},
        {"at_least = \"10 periods\"\nat_most = \"10 periods\"\n", RUNNER_MET},
    };
    for (size_t n = 0; n < sizeof rows / sizeof rows[0]; n++) {
        char text[400];
        snprintf(text, sizeof text,
                 HEAD "[run]\nduration = \"1 ms\"\n[[expect]]\nsignal = \"period\"\nstatistic = \"max\"\n%s",
                 rows[n].limits);
        given(text);
        run();
        TEST_ASSERT_EQUAL_INT_MESSAGE(rows[n].judgement, result.verdicts[0].judgement, text);
        TEST_ASSERT_EQUAL_UINT32_MESSAGE(rows[n].judgement == RUNNER_MET ? 0u : 1u, result.failed, text);
    }
}

static void test_verdicts_in_words(void)
{
    static const char *const rows[][2] = {
        {"[[expect]]\nsignal = \"true_omega_m\"\nstatistic = \"mean\"\nfrom = \"50 ms\"\nat_least = \"599 "
         "r/min\"\n"
         "at_most = \"601 r/min\"\n",
         "mean of true_omega_m from 50 ms to 100 ms: 600 r/min, at least 599 r/min, at most 601 r/min"},
        {"[[expect]]\nname = \"it waits\"\nsignal = \"state\"\nstatistic = \"last\"\nat_least = \"ready\"\n"
         "at_most = \"ready\"\n",
         "it waits: last of state from 0 s to 100 ms: ready, exactly ready"},
        {"[[expect]]\nsignal = \"plant.encoder_lines\"\nminus = \"params.encoder_lines\"\nstatistic = "
         "\"peak\"\n"
         "at_most = 0\n",
         "peak of plant.encoder_lines - params.encoder_lines from 0 s to 100 ms: 0, at most 0"},
        {"[[expect]]\nsignal = \"fault_reason\"\nstatistic = \"max\"\nat_most = 0\n",
         "max of fault_reason from 0 s to 100 ms: none, exactly none"},
        {"[[expect]]\nsignal = \"true_omega_m\"\nstatistic = \"max\"\nat_most = \"612.3456 r/min\"\n",
         "max of true_omega_m from 0 s to 100 ms: 600 r/min, at most 612.3 r/min"},
        {"[[expect]]\nsignal = \"true_omega_m\"\nstatistic = \"max\"\nat_most = \"600.0123 r/min\"\n",
         "max of true_omega_m from 0 s to 100 ms: 600 r/min, at most 600.012 r/min"}};
    for (size_t n = 0; n < sizeof rows / sizeof rows[0]; n++) {
        char text[600];
        snprintf(text, sizeof text,
                 HEAD "[run]\nduration = \"0.1 s\"\n[plant]\nshaft_locked = 1\n"
                      "shaft_locked_speed = \"600 r/min\"\n%s",
                 rows[n][0]);
        given(text);
        run();
        TEST_ASSERT_EQUAL_STRING(rows[n][1], runner_verdict_text(&result.verdicts[0], text, sizeof text));
    }
}

/* ---- stopping and reports ---- */

static volatile sig_atomic_t stop_now;

static void stop_at_half(void *context, double fraction)
{
    (void)context;
    stop_now = fraction >= 0.5;
}

static void test_a_stop_ends_the_run_after_the_period_and_judges_what_is_over(void)
{
    const uint32_t ids[1] = {rig_row_by_name("i_q")->id};
    stop_now = 0;
    options.progress = stop_at_half;
    options.stop = &stop_now;
    record(ids, 1u, 1u);
    given(HEAD "[run]\nduration = \"0.4 s\"\n"
               "[[expect]]\nsignal = \"period\"\nstatistic = \"last\"\nto = \"0.2001 s\"\nat_most = 2001\n"
               "[[expect]]\nsignal = \"period\"\nstatistic = \"last\"\nto = \"0.2002 s\"\nat_most = 2002\n"
               "[[expect]]\nsignal = \"period\"\nstatistic = \"last\"\nfrom = \"0.3 s\"\nat_most = 4000\n");
    run();
    TEST_ASSERT_EQUAL_INT(RUNNER_INTERRUPTED, result.end);
    TEST_ASSERT_EQUAL_UINT32(2001u,
                             result.periods); /* the flag was set before period 2000 and is tested after it */
    TEST_ASSERT_EQUAL_UINT32(2001u, taken.count);
    TEST_ASSERT_EQUAL_INT(RUNNER_MET, result.verdicts[0].judgement);
    TEST_ASSERT_EQUAL_INT(RUNNER_NOT_JUDGED, result.verdicts[1].judgement);
    TEST_ASSERT_EQUAL_INT(RUNNER_NOT_JUDGED, result.verdicts[2].judgement);
    TEST_ASSERT_EQUAL_UINT32(0u, result.verdicts[2].samples);
    TEST_ASSERT_TRUE(isnan(result.verdicts[2].value));
    TEST_ASSERT_EQUAL_UINT32(2u, result.failed);
    char text[300];
    TEST_ASSERT_EQUAL_STRING("last of period from 300 ms to 400 ms: not reached, at most 4000 periods",
                             runner_verdict_text(&result.verdicts[2], text, sizeof text));
}
