/* The runner against the rig's own calls and against two-pass statistics of what it recorded. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host_sim/lab/runner.h"
#include "unity.h"

#define PI        3.14159265358979323846
#define ROWS_MAX  4u
#define ROOM      4000u
#define HEAD      "schema = 1\ntitle = \"a test\"\n"
#define SHORT_RUN HEAD "[run]\nduration = \"0.2 s\"\n[requests]\nenable = \"on\"\nspeed_request = 50\n"

static scenario_t *scenario;
static runner_result_t result;
static runner_options_t options;

/* What the sink was given. */
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

/* ---- the same as by hand ---- */

static void put(rig_t *rig, const char *name, double value)
{
    if (!rig_put(rig, name, value)) {
        TEST_FAIL_MESSAGE(rig_error(rig));
    }
}

static void test_a_scenario_is_what_its_calls_by_hand_are(void)
{
    given(HEAD
          "[run]\nduration = \"0.2 s\"\nseed = 77\n[start]\nspeed = 30\nangle = 1\n"
          "[params]\nspeed_kp = 0.4\n[requests]\nenable = \"on\"\nspeed_request = 50\n[plant]\ninertia = "
          "0.003\n"
          "[[at]]\ntime = 0.1\nplant.load_torque = 2\nparams.speed_ki = 3\n"
          "[[at]]\ntime = 0.15\nramp = \"300 us\"\nplant.load_torque = 5\n");
    run();
    rig_t *rig = rig_create(77);
    put(rig, "speed_kp", 0.4);
    TEST_ASSERT_TRUE(rig_apply(rig));
    put(rig, "speed_request", 50.0);
    put(rig, "enable", 1.0);
    put(rig, "inertia", 0.003);
    rig_set_motion(rig, 1.0, 30.0);
    rig_run(rig, 1000u);
    put(rig, "load_torque", 2.0);
    put(rig, "speed_ki", 3.0);
    TEST_ASSERT_TRUE(rig_apply(rig));
    rig_run(rig, 501u);
    put(rig, "load_torque", 2.0 + 3.0 * (1.0 / 3.0));
    rig_step(rig);
    put(rig, "load_torque", 2.0 + 3.0 * (2.0 / 3.0));
    rig_step(rig);
    put(rig, "load_torque", 5.0);
    rig_run(rig, 497u);
    TEST_ASSERT_EQUAL_UINT32(2000u, rig_period(rig));
    TEST_ASSERT_EQUAL_HEX64(rig_hash(rig), result.hash);
    TEST_ASSERT_EQUAL_UINT32(2000u, result.periods);
    TEST_ASSERT_EQUAL_INT32(3, result.state);
    TEST_ASSERT_EQUAL_INT32(0, result.fault_reason);
    TEST_ASSERT_EQUAL_INT(RUNNER_COMPLETE, result.end);
    rig_free(rig);
}

/* 200 deg mechanical are 4 times that electrical: 80 deg of a turn. */
static void test_rotor_stands_at_the_start_angle_held_or_locked(void)
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

static void test_same_seed_same_bits_another_seed_others(void)
{
    given(SHORT_RUN);
    run();
    const uint64_t first = result.hash;
    run();
    TEST_ASSERT_EQUAL_HEX64(first, result.hash);
    options.has_seed = true;
    options.seed = 2;
    run();
    TEST_ASSERT_TRUE(result.hash != first);
    TEST_ASSERT_TRUE(result.seed == 2u);
    options.seed = 1; /* the default of a scenario without one */
    run();
    TEST_ASSERT_EQUAL_HEX64(first, result.hash);
}

static void ignore_progress(void *context, double fraction)
{
    (void)context;
    (void)fraction;
}

static void ignore_edge(void *context, uint64_t tick, uint32_t what, uint32_t value)
{
    (void)what;
    (void)value;
    *(uint64_t *)context = tick;
}

static void test_onlookers_change_nothing(void)
{
    const uint32_t ids[2] = {rig_row_by_name("i_q")->id, rig_row_by_name("true_omega_m")->id};
    const volatile sig_atomic_t stop = 0;
    uint64_t tick = 0;
    given(SHORT_RUN);
    run();
    const uint64_t alone = result.hash;
    given(SHORT_RUN "[[expect]]\nsignal = \"i_q\"\nstatistic = \"mean\"\nat_most = 100\n");
    record(ids, 2u, 3u);
    options.edge_sink = ignore_edge;
    options.edge_context = &tick;
    options.progress = ignore_progress;
    options.stop = &stop;
    options.has_stop_period = true;
    options.stop_period = 100;
    run();
    TEST_ASSERT_EQUAL_HEX64(alone, result.hash);
    TEST_ASSERT_TRUE(tick > 0u);
}

/* ---- events ---- */

static void test_an_event_acts_in_its_period_and_not_before(void)
{
    const uint32_t ids[1] = {rig_row_by_name("load_torque")->id};
    given(HEAD "[run]\nduration = \"1 ms\"\n[[at]]\ntime = \"0.3 ms\"\nplant.load_torque = 5\n"
               "[[at]]\ntime = \"0.9 ms\"\nplant.load_torque = 7\n[[at]]\ntime = 0\nplant.load_torque = 1\n");
    record(ids, 1u, 1u);
    run();
    static const float expected[10] = {1, 1, 1, 5, 5, 5, 5, 5, 5, 7};
    TEST_ASSERT_EQUAL_UINT32(10u, taken.count);
    for (uint32_t n = 0; n < 10u; n++) {
        TEST_ASSERT_EQUAL_UINT32(n, taken.period[n]);
        TEST_ASSERT_TRUE(taken.value[n][0] == expected[n]);
    }
}

static void test_of_two_events_at_one_time_the_later_in_the_file_wins(void)
{
    const uint32_t ids[1] = {rig_row_by_name("load_torque")->id};
    given(HEAD "[run]\nduration = \"1 ms\"\n[[at]]\ntime = \"0.3 ms\"\nplant.load_torque = 5\n"
               "[[at]]\ntime = \"0.3 ms\"\nplant.load_torque = 7\n");
    record(ids, 1u, 1u);
    run();
    TEST_ASSERT_TRUE(taken.value[2][0] == 0.0f && taken.value[3][0] == 7.0f);
}

static void test_a_ramp_is_straight_and_ends_on_its_value(void)
{
    const uint32_t ids[2] = {rig_row_by_name("load_torque")->id, rig_row_by_name("dc_voltage")->id};
    given(HEAD "[run]\nduration = \"3 ms\"\n[plant]\nload_torque = 1\n"
               "[[at]]\ntime = \"1 ms\"\nramp = \"1 ms\"\nplant.load_torque = 4\nplant.dc_voltage = 300\n");
    record(ids, 2u, 1u);
    run();
    for (uint32_t n = 0; n < 30u; n++) {
        const double share = n <= 10u ? 0.0 : n >= 20u ? 1.0 : (n - 10u) / 10.0;
        TEST_ASSERT_TRUE(taken.value[n][0] == (float)(1.0 + 3.0 * share));
        TEST_ASSERT_TRUE(taken.value[n][1] == (float)(311.0 - 11.0 * share));
    }
}

static void test_a_later_event_ends_a_ramp_of_its_row_and_of_no_other(void)
{
    const uint32_t ids[2] = {rig_row_by_name("load_torque")->id, rig_row_by_name("dc_voltage")->id};
    given(HEAD "[run]\nduration = \"3 ms\"\n"
               "[[at]]\ntime = \"1 ms\"\nramp = \"1 ms\"\nplant.load_torque = 10\nplant.dc_voltage = 301\n"
               "[[at]]\ntime = \"1.5 ms\"\nplant.load_torque = 2\n"
               "[[at]]\ntime = \"1.6 ms\"\nramp = \"0.2 ms\"\nplant.load_torque = 6\n");
    record(ids, 2u, 1u);
    run();
    TEST_ASSERT_TRUE(taken.value[14][0] == 4.0f);
    TEST_ASSERT_TRUE(taken.value[15][0] == 2.0f);
    TEST_ASSERT_TRUE(taken.value[16][0] == 2.0f);
    TEST_ASSERT_TRUE(taken.value[17][0] == 4.0f); /* from where it is */
    TEST_ASSERT_TRUE(taken.value[18][0] == 6.0f);
    TEST_ASSERT_TRUE(taken.value[29][0] == 6.0f);
    TEST_ASSERT_TRUE(taken.value[15][1] == 306.0f);
    TEST_ASSERT_TRUE(taken.value[29][1] == 301.0f);
}

static void test_a_ramp_replaces_a_longer_one_that_is_under_way(void)
{
    const uint32_t ids[1] = {rig_row_by_name("load_torque")->id};
    given(HEAD "[run]\nduration = \"3 ms\"\n"
               "[[at]]\ntime = \"1 ms\"\nramp = \"1 ms\"\nplant.load_torque = 10\n"
               "[[at]]\ntime = \"1.4 ms\"\nramp = \"0.2 ms\"\nplant.load_torque = 2\n");
    record(ids, 1u, 1u);
    run();
    TEST_ASSERT_TRUE(taken.value[13][0] == 3.0f);
    TEST_ASSERT_TRUE(taken.value[14][0] == 3.0f); /* the new one starts from there */
    TEST_ASSERT_TRUE(taken.value[15][0] == 2.5f);
    TEST_ASSERT_TRUE(taken.value[16][0] == 2.0f);
    TEST_ASSERT_TRUE(taken.value[18][0] == 2.0f);
    TEST_ASSERT_TRUE(taken.value[29][0] == 2.0f);
}

static void test_a_ramp_may_last_to_the_end_and_rows_without_fractions_switch(void)
{
    const uint32_t ids[2] = {rig_row_by_name("speed_request")->id,
                             rig_row_by_name("calibration_periods")->id};
    given(
        HEAD
        "[run]\nduration = \"2 ms\"\n[[at]]\ntime = \"1 ms\"\nramp = \"1 ms\"\nrequests.speed_request = 10\n"
        "params.calibration_periods = 100\n");
    record(ids, 2u, 1u);
    run();
    uint32_t periods;
    memcpy(&periods, &taken.value[10][1], sizeof periods);
    TEST_ASSERT_EQUAL_UINT32(100u, periods);
    TEST_ASSERT_TRUE(taken.value[10][0] == 0.0f);
    TEST_ASSERT_TRUE(taken.value[19][0] == 9.0f);
}

static void test_parameters_can_ramp(void)
{
    const uint32_t ids[1] = {rig_row_by_name("speed_kp")->id};
    given(HEAD
          "[run]\nduration = \"2 ms\"\n[params]\nspeed_kp = 0.5\n[[at]]\ntime = \"1 ms\"\nramp = \"0.4 ms\"\n"
          "params.speed_kp = 0.9\n");
    record(ids, 1u, 1u);
    run();
    TEST_ASSERT_TRUE(taken.value[10][0] == 0.5f);
    TEST_ASSERT_TRUE(taken.value[11][0] == (float)(0.5 + (0.9 - 0.5) * 0.25));
    TEST_ASSERT_TRUE(taken.value[14][0] == 0.9f);
}

static void test_what_the_rig_refuses_on_the_way_names_line_and_time(void)
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
    TEST_ASSERT_EQUAL_UINT32(1000u, taken.count); /* what was recorded stays */
    TEST_ASSERT_EQUAL_UINT32(1000u, result.periods);
    TEST_ASSERT_EQUAL_INT(RUNNER_NOT_JUDGED, result.verdicts[0].judgement);
}

/* ---- recording ---- */

static void test_every_nth_period_is_recorded_from_the_first_on(void)
{
    const uint32_t ids[1] = {rig_row_by_name("period")->id};
    given(HEAD "[run]\nduration = \"3.2 ms\"\n");
    record(ids, 1u, 7u);
    run();
    TEST_ASSERT_EQUAL_UINT32(5u, taken.count);
    for (uint32_t n = 0; n < 5u; n++) {
        TEST_ASSERT_EQUAL_UINT32(7u * n, taken.period[n]);
    }
}

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

static void test_more_rows_than_the_tap_holds_are_refused(void)
{
    uint32_t ids[RIG_TAP_MAX];
    uint32_t count = 0;
    for (uint32_t n = 0; count < RIG_TAP_MAX; n++) {
        const table_t *table = rig_table(n);
        for (uint32_t m = 0; m < table->count && count < RIG_TAP_MAX; m++) {
            if (strcmp(table->rows[m].name, "i_q") != 0) {
                ids[count++] = table->rows[m].id;
            }
        }
    }
    given(SHORT_RUN "[[expect]]\nsignal = \"i_q\"\nstatistic = \"mean\"\nat_most = 100\n");
    record(ids, RIG_TAP_MAX, 1u);
    TEST_ASSERT_FALSE(runner_run(scenario, &options, &result));
    TEST_ASSERT_NOT_NULL_MESSAGE(strstr(result.error.message, "up to 128"), result.error.message);
    runner_result_free(&result);
    record(ids, 0u, 1u);
    TEST_ASSERT_FALSE(runner_run(scenario, &options, &result));
    runner_result_free(&result);
    ids[0] = 99999u;
    record(ids, 1u, 1u);
    TEST_ASSERT_FALSE(runner_run(scenario, &options, &result));
}

/* ---- verdicts ---- */

#define SEVEN(window)                                                                                        \
    "[[expect]]\nsignal = \"true_i_a\"\nminus = \"true_i_b\"\nstatistic = \"mean\"\nat_most = 1e9\n" window  \
    "[[expect]]\nsignal = \"true_i_a\"\nminus = \"true_i_b\"\nstatistic = \"min\"\nat_most = 1e9\n" window   \
    "[[expect]]\nsignal = \"true_i_a\"\nminus = \"true_i_b\"\nstatistic = \"max\"\nat_most = 1e9\n" window   \
    "[[expect]]\nsignal = \"true_i_a\"\nminus = \"true_i_b\"\nstatistic = \"peak\"\nat_most = 1e9\n" window  \
    "[[expect]]\nsignal = \"true_i_a\"\nminus = \"true_i_b\"\nstatistic = \"sd\"\nat_most = 1e9\n" window    \
    "[[expect]]\nsignal = \"true_i_a\"\nminus = \"true_i_b\"\nstatistic = \"rms\"\nat_most = 1e9\n" window   \
    "[[expect]]\nsignal = \"true_i_a\"\nminus = \"true_i_b\"\nstatistic = \"last\"\nat_most = 1e9\n" window

static void test_statistics_are_those_of_the_samples_in_the_window(void)
{
    const uint32_t ids[2] = {rig_row_by_name("true_i_a")->id, rig_row_by_name("true_i_b")->id};
    given(SHORT_RUN SEVEN("from = 0.1\nto = 0.15\n"));
    record(ids, 2u, 1u);
    run();
    const uint32_t begin = 1000u;
    const uint32_t end = 1500u;
    double sum = 0.0;
    double squares = 0.0;
    double about = 0.0;
    double low = 1e9;
    double high = -1e9;
    double last = 0.0;
    for (uint32_t n = begin; n < end; n++) {
        last = (double)taken.value[n][0] - (double)taken.value[n][1];
        sum += last;
        squares += last * last;
        low = fmin(low, last);
        high = fmax(high, last);
    }
    const double mean = sum / 500.0;
    for (uint32_t n = begin; n < end; n++) {
        const double off = (double)taken.value[n][0] - (double)taken.value[n][1] - mean;
        about += off * off;
    }
    const double expected[7] = {
        mean, low, high, fmax(fabs(low), fabs(high)), sqrt(about / 500.0), sqrt(squares / 500.0), last};
    TEST_ASSERT_TRUE(high - low > 0.5); /* the currents do turn */
    for (uint32_t n = 0; n < 7u; n++) {
        TEST_ASSERT_EQUAL_UINT32(500u, result.verdicts[n].samples);
        /* 500 samples of some amperes, both sums in double: 500 roundings of 2e-16 x 10 A at most */
        TEST_ASSERT_DOUBLE_WITHIN(1e-12, expected[n], result.verdicts[n].value);
    }
}

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
    /* the drive counts its period k as k + 1 */
    TEST_ASSERT_TRUE(result.verdicts[0].value == 3.0);
    TEST_ASSERT_TRUE(result.verdicts[1].value == 5.0);
    TEST_ASSERT_EQUAL_UINT32(3u, result.verdicts[0].samples);
    TEST_ASSERT_TRUE(result.verdicts[2].value == 10.0);
    TEST_ASSERT_EQUAL_UINT32(10u, result.verdicts[2].samples);
    TEST_ASSERT_TRUE(result.verdicts[3].value == 0.0); /* a row minus itself */
}

static void expect_judged(const char *limits, runner_judgement_t judgement)
{
    char text[400];
    snprintf(text, sizeof text,
             HEAD "[run]\nduration = \"1 ms\"\n[[expect]]\nsignal = \"period\"\nstatistic = \"max\"\n%s",
             limits);
    given(text);
    run();
    TEST_ASSERT_EQUAL_INT_MESSAGE(judgement, result.verdicts[0].judgement, limits);
    TEST_ASSERT_EQUAL_UINT32_MESSAGE(judgement == RUNNER_MET ? 0u : 1u, result.failed, limits);
}

static void test_limits_are_accepted_themselves(void)
{
    expect_judged("at_most = 10\n", RUNNER_MET);
    expect_judged("at_most = 9.999999\n", RUNNER_FAILED);
    expect_judged("at_most = 10.000001\n", RUNNER_MET);
    expect_judged("at_least = 10\n", RUNNER_MET);
    expect_judged("at_least = 10.000001\n", RUNNER_FAILED);
    expect_judged("at_least = 10\nat_most = 10\n", RUNNER_MET);
    expect_judged("at_least = 10.5\nat_most = 11\n", RUNNER_FAILED);
    expect_judged("at_least = \"10 periods\"\nat_most = \"10 periods\"\n", RUNNER_MET);
}

static void expect_verdict_text(const char *expectation, const char *expected)
{
    char text[600];
    snprintf(text, sizeof text,
             HEAD
             "[run]\nduration = \"0.1 s\"\n[plant]\nshaft_locked = 1\nshaft_locked_speed = \"600 r/min\"\n%s",
             expectation);
    given(text);
    run();
    TEST_ASSERT_EQUAL_STRING(expected, runner_verdict_text(&result.verdicts[0], text, sizeof text));
}

static void test_verdicts_in_words(void)
{
    expect_verdict_text(
        "[[expect]]\nsignal = \"true_omega_m\"\nstatistic = \"mean\"\nfrom = \"50 ms\"\nat_least = \"599 "
        "r/min\"\n"
        "at_most = \"601 r/min\"\n",
        "mean of true_omega_m from 50 ms to 100 ms: 600 r/min, at least 599 r/min, at most 601 r/min");
    expect_verdict_text(
        "[[expect]]\nname = \"it waits\"\nsignal = \"state\"\nstatistic = \"last\"\nat_least = \"ready\"\n"
        "at_most = \"ready\"\n",
        "it waits: last of state from 0 s to 100 ms: ready, exactly ready");
    expect_verdict_text(
        "[[expect]]\nsignal = \"plant.encoder_lines\"\nminus = \"params.encoder_lines\"\nstatistic = "
        "\"peak\"\n"
        "at_most = 0\n",
        "peak of plant.encoder_lines - params.encoder_lines from 0 s to 100 ms: 0, at most 0");
}

/* ---- stopping and telling ---- */

static volatile sig_atomic_t stop_now;
static uint32_t progress_calls;
static double progress_last;

static void on_progress(void *context, double fraction)
{
    TEST_ASSERT_EQUAL_PTR(&progress_calls, context);
    TEST_ASSERT_TRUE(progress_calls == 0u ? fraction == 0.0 : fraction > progress_last);
    progress_last = fraction;
    progress_calls++;
}

static void stop_at_half(void *context, double fraction)
{
    (void)context;
    stop_now = fraction >= 0.5;
}

static void test_progress_is_told_every_thousand_periods(void)
{
    progress_calls = 0;
    options.progress = on_progress;
    options.progress_context = &progress_calls;
    given(HEAD "[run]\nduration = \"0.35 s\"\n");
    run();
    TEST_ASSERT_EQUAL_UINT32(5u, progress_calls); /* 0, 1000, 2000, 3000, end */
    TEST_ASSERT_TRUE(progress_last == 1.0);
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
                             result.periods); /* the flag came before period 2000 and counts after it */
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

static void test_a_fault_is_told(void)
{
    given(SHORT_RUN "[[at]]\ntime = 0.1\nplant.force_fault = 1\n");
    run();
    TEST_ASSERT_EQUAL_INT32(5, result.state);
    TEST_ASSERT_EQUAL_INT32(20, result.fault_reason); /* module_fault */
    TEST_ASSERT_UINT32_WITHIN(1u, 1001u, result.fault_period);
}

static void test_overrides_are_run(void)
{
    scenario_error_t error;
    given(HEAD "[run]\nduration = \"1 ms\"\n[[expect]]\nsignal = \"load_torque\"\nstatistic = "
               "\"mean\"\nat_least = 3\n");
    run();
    TEST_ASSERT_EQUAL_UINT32(1u, result.failed);
    TEST_ASSERT_TRUE(scenario_override(scenario, "load_torque=3", &error));
    run();
    TEST_ASSERT_EQUAL_UINT32(0u, result.failed);
    TEST_ASSERT_TRUE(
        scenario_override(scenario, "current_limit=14", &error)); /* breaks a rule, which the runner finds */
    runner_result_free(&result);
    TEST_ASSERT_FALSE(runner_run(scenario, &options, &result));
    TEST_ASSERT_EQUAL_STRING("overcurrent_trip", result.error.name);
}
