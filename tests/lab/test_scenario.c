/* The meaning of a scenario file: settings and their order, times, overrides. test_broken.c tests mistakes
 * in files. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "host_sim/lab/scenario.h"
#include "unity.h"

#define PI   3.14159265358979323846
#define HEAD "schema = 1\ntitle = \"a test\"\n"
#define RUN  HEAD "[run]\nduration = \"1 s\"\n"

static scenario_t *scenario;
static scenario_error_t error;

void setUp(void)
{
    scenario = NULL;
}

void tearDown(void)
{
    scenario_free(scenario);
}

static void given(const char *text)
{
    char line[1200];
    scenario_free(scenario);
    scenario = scenario_read_text("test.toml", text, strlen(text), &error);
    if (scenario == NULL) {
        TEST_FAIL_MESSAGE(scenario_error_text(&error, line, sizeof line));
    }
}

static void expect_error(const char *text, const char *part)
{
    char line[1200];
    scenario_t *none = scenario_read_text("test.toml", text, strlen(text), &error);
    scenario_free(none);
    TEST_ASSERT_NULL(none);
    scenario_error_text(&error, line, sizeof line);
    TEST_ASSERT_NOT_NULL_MESSAGE(strstr(line, part), line);
}

static const scenario_setting_t *setting_of(const scenario_event_t *event, const char *name)
{
    const table_row_t *row = rig_row_by_name(name);
    for (uint32_t n = 0; n < event->count; n++) {
        if (event->settings[n].row == row) {
            return &event->settings[n];
        }
    }
    TEST_FAIL_MESSAGE(name);
    return NULL;
}

/* ---- files ---- */

static void test_the_least_file_has_every_default(void)
{
    given(RUN);
    TEST_ASSERT_EQUAL_STRING("test.toml", scenario->path);
    TEST_ASSERT_EQUAL_STRING(RUN, scenario->source);
    TEST_ASSERT_EQUAL_STRING("a test", scenario->title);
    TEST_ASSERT_EQUAL_STRING("", scenario->text);
    TEST_ASSERT_EQUAL_UINT32(10000u, scenario->periods);
    TEST_ASSERT_TRUE(scenario->seed == 1u);
    TEST_ASSERT_EQUAL_UINT32(1u, scenario->every);
    TEST_ASSERT_EQUAL_UINT32(0u, scenario->record_count);
    TEST_ASSERT_EQUAL_UINT32(1u, scenario->event_count);
    TEST_ASSERT_EQUAL_UINT32(0u, scenario->events[0].count);
    TEST_ASSERT_EQUAL_UINT32(0u, scenario->expect_count);
    TEST_ASSERT_FALSE(scenario->has_start);
}

static void test_every_key_arrives(void)
{
    given("schema = 1\ntitle = \"t\"\ntext = \"\"\"two\nlines\"\"\"\n"
          "[run]\nduration = \"2.5 s\"\nseed = 9\nrecord = [\"i_q\", \"plant.encoder_lines\"]\nevery = 3\n"
          "[start]\nspeed = \"500 r/min\"\nangle = \"30 deg\"\n"
          "[params]\nspeed_kp = 0.4\n[requests]\nenable = \"on\"\n[plant]\ninertia = \"30 kg "
          "cm^2\"\n[rig]\nfidelity = \"averaged\"\n"
          "[[at]]\ntime = 1\nramp = \"0.2 s\"\nplant.load_torque = \"5 N m\"\n"
          "[[expect]]\nname = \"n\"\nsignal = \"true_omega_m\"\nminus = \"omega_m_ref\"\nstatistic = "
          "\"rms\"\nfrom = \"1 s\"\n"
          "to = 2\nat_least = \"-1 r/min\"\nat_most = 3\n");
    TEST_ASSERT_EQUAL_STRING("two\nlines", scenario->text);
    TEST_ASSERT_EQUAL_UINT32(25000u, scenario->periods);
    TEST_ASSERT_TRUE(scenario->seed == 9u);
    TEST_ASSERT_EQUAL_UINT32(3u, scenario->every);
    TEST_ASSERT_EQUAL_UINT32(2u, scenario->record_count);
    TEST_ASSERT_EQUAL_UINT32(rig_row_by_name("i_q")->id, scenario->record[0]);
    TEST_ASSERT_EQUAL_UINT32(rig_row_by_name("plant.encoder_lines")->id, scenario->record[1]);
    TEST_ASSERT_TRUE(scenario->has_start);
    TEST_ASSERT_TRUE(scenario->start_speed == 500.0 * (PI / 30.0));
    TEST_ASSERT_TRUE(scenario->start_angle == 30.0 * (PI / 180.0));
    TEST_ASSERT_EQUAL_UINT32(4u, scenario->events[0].count);
    TEST_ASSERT_TRUE(setting_of(&scenario->events[0], "speed_kp")->value == 0.4);
    TEST_ASSERT_TRUE(setting_of(&scenario->events[0], "enable")->value == 1.0);
    TEST_ASSERT_TRUE(setting_of(&scenario->events[0], "inertia")->value == 0.003);
    TEST_ASSERT_TRUE(setting_of(&scenario->events[0], "fidelity")->value == 1.0);
    TEST_ASSERT_EQUAL_UINT32(2u, scenario->event_count);
    TEST_ASSERT_EQUAL_UINT32(10000u, scenario->events[1].period);
    TEST_ASSERT_EQUAL_UINT32(2000u, scenario->events[1].ramp_periods);
    TEST_ASSERT_TRUE(setting_of(&scenario->events[1], "load_torque")->value == 5.0);
    const scenario_expect_t *expect = &scenario->expects[0];
    TEST_ASSERT_EQUAL_STRING("n", expect->name);
    TEST_ASSERT_EQUAL_PTR(rig_row_by_name("true_omega_m"), expect->row);
    TEST_ASSERT_EQUAL_PTR(rig_row_by_name("omega_m_ref"), expect->minus);
    TEST_ASSERT_EQUAL_INT(STATISTIC_RMS, expect->statistic);
    TEST_ASSERT_EQUAL_UINT32(10000u, expect->begin);
    TEST_ASSERT_EQUAL_UINT32(20000u, expect->end);
    TEST_ASSERT_TRUE(expect->at_least == -1.0 * (PI / 30.0));
    TEST_ASSERT_TRUE(expect->at_most == 3.0);
}

/* --set, [[profile]] and [[at]] accept the same names. */
static void test_an_event_sets_rows_by_their_names_in_the_order_of_the_file(void)
{
    given(RUN "[[at]]\ntime = 0.5\nspeed_request = \"300 r/min\"\nparams.speed_kp = 0.4\nload_torque = 5\n");
    const scenario_event_t *event = &scenario->events[1];
    TEST_ASSERT_EQUAL_UINT32(3u, event->count);
    TEST_ASSERT_EQUAL_PTR(rig_row_by_name("requests.speed_request"), event->settings[0].row);
    TEST_ASSERT_TRUE(event->settings[0].value == 300.0 * (PI / 30.0));
    TEST_ASSERT_EQUAL_PTR(rig_row_by_name("params.speed_kp"), event->settings[1].row);
    TEST_ASSERT_EQUAL_PTR(rig_row_by_name("plant.load_torque"), event->settings[2].row);
    TEST_ASSERT_TRUE(event->settings[2].value == 5.0);
}

/* 0.151 ms is rounded up to period 2, after which 9998 periods remain for a ramp of 9998.49. */
static void test_ramp_may_fill_what_is_left_of_the_run(void)
{
    given(RUN "[[at]]\ntime = \"151 us\"\nramp = \"0.999849 s\"\nplant.load_torque = 1\n");
    TEST_ASSERT_EQUAL_UINT32(2u, scenario->events[1].period);
    TEST_ASSERT_EQUAL_UINT32(9998u, scenario->events[1].ramp_periods);
    /* 2.5 and 9997.5 periods are both rounded up, and together they exceed the run by one period. */
    given(RUN "[[at]]\ntime = \"250 us\"\nramp = \"0.99975 s\"\nplant.load_torque = 1\n");
    TEST_ASSERT_EQUAL_UINT32(3u, scenario->events[1].period);
    TEST_ASSERT_EQUAL_UINT32(9997u, scenario->events[1].ramp_periods);
    expect_error(RUN "[[at]]\ntime = \"151 us\"\nramp = \"0.9999 s\"\nplant.load_torque = 1\n",
                 "ramp: 999.9 ms is outside its range");
}

static void test_durations_at_their_limits(void)
{
    given(HEAD "[run]\nduration = \"100 us\"\n");
    TEST_ASSERT_EQUAL_UINT32(1u, scenario->periods);
    expect_error(HEAD "[run]\nduration = \"99 us\"\n", "4:1: duration: 99 us is outside its range");
    given(HEAD "[run]\nduration = \"60 min\"\n");
    TEST_ASSERT_EQUAL_UINT32(36000000u, scenario->periods);
    expect_error(HEAD "[run]\nduration = 3600.0001\n", "duration: 3600 s is outside its range");
}

static void test_events_are_sorted_and_those_of_one_time_stay_in_order(void)
{
    given(RUN "[[at]]\ntime = 0.5\nplant.load_torque = 1\n[[at]]\ntime = 0.2\nplant.load_torque = 2\n"
              "[[at]]\ntime = 0.5\nplant.load_torque = 3\n[[at]]\ntime = 0.2\nplant.load_torque = 4\n");
    static const double expected[] = {2.0, 4.0, 1.0, 3.0};
    for (uint32_t n = 0; n < 4u; n++) {
        TEST_ASSERT_TRUE(scenario->events[n + 1u].settings[0].value == expected[n]);
    }
}

static void test_sub_tables_and_dotted_keys_mean_the_same(void)
{
    given(RUN "[[at]]\ntime = 0.5\nplant.load_torque = 5\nrequests.speed_request = 10\n");
    TEST_ASSERT_EQUAL_UINT32(2u, scenario->events[1].count);
    TEST_ASSERT_EQUAL_STRING("load_torque",
                             scenario->events[1].settings[0].row->name); /* in the order of the file */
    given(RUN "[[at]]\ntime = 0.5\n[at.plant]\nload_torque = 5\n[at.requests]\nspeed_request = 10\n");
    TEST_ASSERT_EQUAL_UINT32(2u, scenario->events[1].count);
    given(RUN "[[at]]\ntime = 0.5\nplant = {load_torque = 5}\nrequests = {speed_request = 10}\n");
    TEST_ASSERT_EQUAL_UINT32(2u, scenario->events[1].count);
    TEST_ASSERT_TRUE(setting_of(&scenario->events[1], "speed_request")->value == 10.0);
}

/* ---- rules between rows ---- */

static void test_a_parameter_set_is_judged_as_one(void)
{
    given(RUN "[params]\ncurrent_limit = 14\novercurrent_trip = 18\n"); /* written in this order, 14 violates
                                                                           the old trip of 15 A */
    given(RUN "[params]\novercurrent_trip = 18\ncurrent_limit = 14\n");
    given(RUN "[params]\novercurrent_trip = 7\ncurrent_limit = 5\n");
}

/* The scenario records as many rows as fit, and expects one more row. */
static void test_recorded_and_expected_rows_share_the_tap(void)
{
    char text[8000] = HEAD "[run]\nduration = 1\nrecord = [\n";
    uint32_t count = 0;
    for (uint32_t t = 0; count < RIG_TAP_MAX; t++) {
        const table_t *table = rig_table(t);
        for (uint32_t n = 0; n < table->count && count < RIG_TAP_MAX; n++) {
            if (strcmp(table->rows[n].name, "i_q") != 0) {
                char line[160];
                snprintf(line, sizeof line, "\"%s.%s\",\n", table->name, table->rows[n].name);
                strcat(text, line);
                count++;
            }
        }
    }
    /* The scenario already records it. */
    strcat(text, "]\n[[expect]]\nsignal = \"speed_kp\"\nstatistic = \"mean\"\nat_most = 1\n");
    given(text);
    TEST_ASSERT_EQUAL_UINT32(RIG_TAP_MAX, scenario->record_count);
    strcat(text, "[[expect]]\nsignal = \"i_q\"\nstatistic = \"mean\"\nat_most = 1\n");
    expect_error(text,
                 "i_q: too many rows in record and [[expect]] together; accepted: up to 160 different ones");
}

static void test_settings_that_wait_for_each_other_find_their_order(void)
{
    /* The reference is above the old limit and is written before the new limit. */
    given(RUN "[requests]\ni_q_request = 12\n[params]\ncurrent_limit = 12\n");
    TEST_ASSERT_EQUAL_STRING("current_limit", scenario->events[0].settings[0].row->name);
    /* If a limit is refused, the message names the limit and not the reference that depends on it. */
    expect_error(RUN "[requests]\ni_q_request = 12\n[params]\ncurrent_limit = 14\n",
                 "8:1: overcurrent_trip: 15 A: accepted: 16.8 to 19 A");
    /* In the reverse direction the reference must change first. */
    given(RUN "[requests]\ni_q_request = 9\n[[at]]\ntime = 0.5\nparams.current_limit = "
              "5\nrequests.i_q_request = 4\n");
    TEST_ASSERT_EQUAL_STRING("i_q_request", scenario->events[1].settings[0].row->name);
    /* An active load may have a driving torque, a passive one may not. */
    given(RUN "[plant]\nload_torque = -5\nload_kind = 1\n[[at]]\ntime = 0.5\nplant.load_kind = "
              "0\nplant.load_torque = 5\n");
    TEST_ASSERT_EQUAL_STRING("load_kind", scenario->events[0].settings[0].row->name);
    TEST_ASSERT_EQUAL_STRING("load_torque", scenario->events[1].settings[0].row->name);
}

static void test_the_first_mistake_of_a_file_is_reported_first(void)
{
    expect_error(RUN "[plant]\nzebra = 1\napple = 2\n", "test.toml:6:1: zebra: no such row in plant");
}

static void test_events_are_judged_in_the_order_of_time(void)
{
#define FASTER "params.overspeed_trip = 320\nparams.observer_gain = 290\n"
    given(RUN "[[at]]\ntime = 0.8\nrequests.speed_request = 300\n[[at]]\ntime = 0.2\n" FASTER);
    expect_error(RUN "[[at]]\ntime = 0.2\nrequests.speed_request = 300\n[[at]]\ntime = 0.8\n" FASTER,
                 "7:10: speed_request: 300 rad/s: accepted: -209 to 209 rad/s");
#undef FASTER
}

static void test_a_ramp_is_tried_between_its_ends(void)
{
    given(RUN "[[at]]\ntime = 0.1\nramp = 0.1\nplant.load_torque = 5\nparams.current_limit = 5\n");
    /* The end of the ramp is a whole number, the values between are not. */
    expect_error(RUN "[[at]]\ntime = 0.1\nramp = 0.1\nplant.pole_pairs = 5\n",
                 "8:7: pole_pairs: a ramp passes values");
    /* This row is not a float, so that its value changes in one step. */
    given(RUN "[[at]]\ntime = 0.1\nramp = 0.1\nparams.motor_pole_pairs = 3\n");
}

/* ---- limits of expectations ---- */

static void test_choices_are_limits_by_name_and_one_limit_leaves_the_other_side_open(void)
{
    given(RUN "[[expect]]\nsignal = \"state\"\nstatistic = \"last\"\nat_least = \"ready\"\nat_most = 3\n");
    TEST_ASSERT_TRUE(scenario->expects[0].at_least == 1.0);
    TEST_ASSERT_TRUE(scenario->expects[0].at_most == 3.0);
    given(RUN "[[expect]]\nsignal = \"i_q\"\nstatistic = \"max\"\nat_most = \"250 mA\"\n");
    TEST_ASSERT_TRUE(scenario->expects[0].at_least == -(double)INFINITY);
    TEST_ASSERT_TRUE(scenario->expects[0].at_most == 0.25);
    TEST_ASSERT_EQUAL_UINT32(0u, scenario->expects[0].begin);
    TEST_ASSERT_EQUAL_UINT32(10000u, scenario->expects[0].end);
}

/* ---- overrides ---- */

static void set(const char *assignment)
{
    char line[1200];
    if (!scenario_override(scenario, assignment, &error)) {
        TEST_FAIL_MESSAGE(scenario_error_text(&error, line, sizeof line));
    }
}

static double initial(const char *name)
{
    return scenario_initial(scenario, rig_row_by_name(name));
}

static void test_an_override_replaces_or_adds_a_setting(void)
{
    given(RUN "[plant]\ninertia = 0.01\n");
    set("inertia=0.003");
    set("load_torque = 2 N m");
    set("plant.dc_voltage=0.3 kV");
    set("enable=on");
    set("requests.speed_request= 600 r/min");
    set("compensation_gain=40 %");
    /* The name exists in signals, where it can only be read, and in plant, where it is set. */
    set("sink_temperature=60");
    TEST_ASSERT_TRUE(scenario_check(scenario, &error));
    TEST_ASSERT_EQUAL_UINT32(7u, scenario->events[0].count);
    TEST_ASSERT_TRUE(initial("plant.sink_temperature") == 60.0);
    TEST_ASSERT_TRUE(initial("inertia") == (double)0.003f);
    TEST_ASSERT_TRUE(initial("load_torque") == 2.0);
    TEST_ASSERT_TRUE(initial("dc_voltage") == 300.0);
    TEST_ASSERT_TRUE(initial("enable") == 1.0);
    TEST_ASSERT_TRUE(initial("compensation_gain") == (double)0.4f);
    TEST_ASSERT_TRUE(initial("speed_request") == (double)(float)(600.0 * (PI / 30.0)));
    TEST_ASSERT_TRUE(initial("friction_coulomb") == (double)1.32f); /* the default value */
}

static void test_run_and_start_can_be_overridden(void)
{
    given(RUN);
    set("run.duration=0.5 s");
    set("run.seed=18446744073709551615");
    set("run.every=7");
    set("start.speed=300 r/min");
    TEST_ASSERT_TRUE(scenario_check(scenario, &error));
    TEST_ASSERT_EQUAL_UINT32(5000u, scenario->periods);
    TEST_ASSERT_TRUE(scenario->seed == UINT64_MAX);
    TEST_ASSERT_EQUAL_UINT32(7u, scenario->every);
    TEST_ASSERT_TRUE(scenario->has_start);
    TEST_ASSERT_TRUE(scenario->start_speed == 300.0 * (PI / 30.0));
}

static void test_a_locked_shaft_has_a_start_angle_and_no_start_speed(void)
{
    given(RUN "[start]\nangle = \"30 deg\"\n[plant]\nshaft_locked = 1\n");
    TEST_ASSERT_TRUE(scenario->has_start && !scenario->has_start_speed);
    set("start.speed=0");
    TEST_ASSERT_FALSE(scenario_check(scenario, &error));
    TEST_ASSERT_NOT_NULL(strstr(error.message, "plant.shaft_locked_speed"));
}

static void test_a_wrong_override_says_what_is_accepted_and_changes_nothing(void)
{
    static const char *const rows[][2] = {
        {"inertai=1", "inertai: no table has a row of this name; nearest: inertia"},
        {"inertia", "accepted: NAME=VALUE"},
        {"  =3", "accepted: NAME=VALUE"},
        {"", "accepted: NAME=VALUE"},
        {"inertia=", "does not begin with a number"},
        {"inertia=5 s", "quantity in kg m^2"},
        {"inertia=nan", "does not begin with a number"},
        {"inertia=1e6", "accepted: 1e-06 to 1000 kg m^2"},
        {"encoder_lines=1000", "write params.encoder_lines or plant.encoder_lines"},
        {"omega_m=10", "it can be read, not set"},
        {"signals.omega_m=10", "it can be read, not set"},
        {"plnt.inertia=1", "nearest: plant"},
        {"plant.inertai=1", "no such row in plant; nearest: inertia"},
        {"params.inertia=1", "it is plant.inertia"},
        {"enable=yes", "accepted: off, on, quick_stop"},
        {"enable=1", "accepted: off, on, quick_stop"},
        {"enable=off|on", "of its choices"},
        {"run.seed=18446744073709551616", "whole numbers 0 to 18446744073709551615"},
        {"run.seed=-1", "whole numbers 0 to"},
        {"run.every=0", "whole numbers 1 to 100000"},
        {"run.duration=2 h", "quantity in s"},
        {"run.duration=0", "0 s is outside its range; accepted: 0.0001 to 3600 s"},
        {"run.durration=1", "nearest: run.duration"},
        {"run.decimation=5", "now called run.every"},
        {"start.sped=1", "nearest: start.speed"},
    };
    given(RUN);
    for (size_t n = 0; n < sizeof rows / sizeof rows[0]; n++) {
        char line[1200];
        TEST_ASSERT_FALSE_MESSAGE(scenario_override(scenario, rows[n][0], &error), rows[n][0]);
        scenario_error_text(&error, line, sizeof line);
        TEST_ASSERT_NOT_NULL_MESSAGE(strstr(line, rows[n][1]), line);
        TEST_ASSERT_EQUAL_STRING_LEN_MESSAGE("--set ", line, 6, line);
    }
    TEST_ASSERT_EQUAL_UINT32(0u, scenario->events[0].count);
    TEST_ASSERT_TRUE(scenario->periods == 10000u && scenario->seed == 1u && scenario->every == 1u);
    TEST_ASSERT_TRUE(scenario_check(scenario, &error));
}

static void test_overrides_that_fit_only_together_are_judged_together(void)
{
    char line[1200];
    given(RUN);
    set("current_limit=14");
    TEST_ASSERT_FALSE(scenario_check(scenario, &error));
    scenario_error_text(&error, line, sizeof line);
    TEST_ASSERT_NOT_NULL_MESSAGE(strstr(line, "test.toml: overcurrent_trip: 15 A: accepted: 16.8 to 19 A"),
                                 line);
    set("overcurrent_trip=18");
    TEST_ASSERT_TRUE(scenario_check(scenario, &error));
}

static void test_an_override_that_breaks_an_event_is_found(void)
{
    char line[1200];
    given(RUN "[[at]]\ntime = 0.5\nplant.load_torque = 5\n");
    set("run.duration=0.4 s");
    TEST_ASSERT_FALSE(scenario_check(scenario, &error));
    scenario_error_text(&error, line, sizeof line);
    TEST_ASSERT_NOT_NULL_MESSAGE(
        strstr(line, "test.toml:6:1: time: 500 ms is outside its range; accepted: 0 to 400 ms"), line);
    set("run.duration=2 s");
    TEST_ASSERT_TRUE(scenario_check(scenario, &error));
}

static void test_every_settable_row_can_be_overridden_at_once(void)
{
    static const char *const tables[] = {"params", "requests", "plant", "rig"};
    char assignment[160];
    given(RUN "[plant]\ninertia = 0.01\n");
    for (uint32_t t = 0; t < rig_table_count(); t++) {
        const table_t *table = rig_table(t);
        for (size_t m = 0; m < 4u; m++) {
            for (uint32_t n = 0; n < table->count && strcmp(tables[m], table->name) == 0; n++) {
                const table_row_t *row = &table->rows[n];
                char choice[64];
                snprintf(choice, sizeof choice, "%.*s", (int)strcspn(row->choices, "|"), row->choices);
                snprintf(assignment, sizeof assignment,
                         row->kind == SLOT_ENUM ? "%s.%s=%s" : "%s.%s=%.0s%.9g", table->name, row->name,
                         choice, rig_initial(row));
                set(assignment);
            }
        }
    }
    TEST_ASSERT_TRUE_MESSAGE(scenario_check(scenario, &error), error.message);
}

static void test_names_are_qualified_where_they_must(void)
{
    static const char *const names[] = {"i_q", "plant.encoder_lines", "signals.sink_temperature"};
    for (size_t n = 0; n < 3u; n++) {
        char name[64];
        scenario_row_name(rig_row_by_name(names[n]), name, sizeof name);
        TEST_ASSERT_EQUAL_STRING(names[n], name);
    }
}
