/* The text of a refusal of parameters must be true. Every value of the reported range is accepted for this
 * parameter, and a value beyond it by one float is not. If no value is accepted, a change of the named
 * parameter makes some values possible. */
#include "settings/reasons.h"
#include "settings/requests.h"
#include "tests/unit/rows.h"
#include "tests/unit/sweep.h"

static params_t params;
static params_error_t why;

void setUp(void)
{
    params_defaults(&params);
    memset(&why, 0, sizeof why);
}

/* The observer of the paper's machine with configured values instead of the rule, so that these values can
 * violate the rules. */
static void given_observer(void)
{
    params_defaults(&params);
    set_rows(&params, "observer_gain=200 observer_slope=1");
}

/* Returns true if the parameter is reported again with this value. */
static bool is_named_with(const params_t *set, const table_row_t *row, float value)
{
    params_t changed = *set;
    params_error_t again;
    table_set(row, &changed, value);
    return !params_check(&changed, &again) && again.id == row->id;
}

static float beyond(const table_row_t *row, float value, float towards)
{
    return row->kind == SLOT_FLOAT ? nextafterf(value, towards) : value + (towards > value ? 1.0f : -1.0f);
}

/* A value just beyond an end violates a rule that reads this parameter: the set is refused because of this
 * parameter or another one in the rule. */
static void expect_refused_at(const params_t *set, const table_row_t *row, float value)
{
    params_t changed = *set;
    params_error_t ignored;
    table_set(row, &changed, value);
    TEST_ASSERT_FALSE_MESSAGE(params_check(&changed, &ignored), row->name);
}

/* A name consists of letters, digits and underscores; each name with an underscore in a rule must be a
 * parameter. */
static void expect_told_in_rows(const char *rule)
{
    char word[64];
    for (const char *c = rule; *c != '\0';) {
        size_t length = strspn(c, "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_");
        TEST_ASSERT_TRUE(length < sizeof word);
        memcpy(word, c, length);
        word[length] = '\0';
        if (strchr(word, '_') != NULL && strcmp(word, "T_s") != 0) {
            TEST_ASSERT_NOT_NULL_MESSAGE(table_by_name(&params_table, word), rule);
        }
        c += length > 0 ? length : 1;
    }
    static const char *const inner[] = {"speed_max", "flux_linkage speed", "gain >=", "slope /",
                                        "inductance /"};
    for (size_t n = 0; n < sizeof inner / sizeof inner[0]; n++) {
        const char *found = strstr(rule, inner[n]);
        TEST_ASSERT_TRUE_MESSAGE(found == NULL || (found > rule && found[-1] == '_'), rule);
    }
}

static uint32_t random_state;

static float random_share(void)
{
    random_state = random_state * UINT32_C(1664525) + UINT32_C(1013904223);
    return (float)(random_state >> 8) * (1.0f / 16777216.0f);
}

static void expect_true(const params_t *set)
{
    const table_row_t *row = table_by_id(&params_table, why.id);
    TEST_ASSERT_NOT_NULL(row);
    TEST_ASSERT_EQUAL_STRING(row->name, why.field);
    const float held = table_get(row, set);
    TEST_ASSERT_FLOAT_WITHIN_MESSAGE(1e-6f * fabsf(held), held, why.value, why.rule);
    expect_told_in_rows(why.rule);
    if (params_none_accepted(&why)) {
        for (int n = 0; n <= 20; n++) { /* no direction has an accepted range */
            const float share = (float)n / 20.0f;
            expect_refused_at(set, row, table_min(row) + share * share * (table_max(row) - table_min(row)));
        }
        return;
    }
    TEST_ASSERT_EQUAL_UINT32(row->id, why.change);
    const float inside[] = {why.min, why.max, 0.5f * (why.min + why.max), sqrtf(why.min) * sqrtf(why.max)};
    for (int n = 0; n < (row->kind == SLOT_FLOAT ? 4 : 2); n++) {
        if (inside[n] >= why.min && inside[n] <= why.max) {
            TEST_ASSERT_FALSE_MESSAGE(is_named_with(set, row, inside[n]), why.rule);
        }
    }
    if (why.min > table_min(row)) {
        expect_refused_at(set, row, beyond(row, why.min, -INFINITY));
    } else {
        TEST_ASSERT_FALSE(table_accepts(row, beyond(row, why.min, -INFINITY)));
    }
    expect_refused_at(set, row, beyond(row, why.max, INFINITY));
    if (why.advice != 0.0f) {
        TEST_ASSERT_TRUE_MESSAGE(why.advice >= why.min && why.advice <= why.max, why.field);
    }
}

/* One or two parameters have random values in their ranges or somewhat beyond, the others have their
 * defaults. */
static void make_random_set(void)
{
    params_defaults(&params);
    const int changes = random_share() < 0.5f ? 1 : 2;
    for (int n = 0; n < changes; n++) {
        const table_row_t *row = &params_table.rows[(uint32_t)(random_share() * (float)params_table.count)];
        const float share = random_share();
        const float span = table_max(row) - table_min(row);
        const float value = table_min(row) + share * share * share * 1.05f * span;
        table_set(row, &params, random_share() < 0.1f ? table_min(row) - share * (1.0f + span) : value);
    }
}

static void test_every_reported_range_is_true_of_random_sets(void)
{
    uint32_t refused = 0u;
    random_state = 14u;
    for (int n = 0; n < 20000; n += SWEEP_LONG) {
        make_random_set();
        if (!params_check(&params, &why)) {
            expect_true(&params);
            refused++;
        }
    }
    TEST_ASSERT_TRUE(refused > 4000u / SWEEP_LONG);
}

/* Several parameters of the start are changed together, by factors from a third to three of their value or
 * of the value by rule. Then each of them in turn is set out of its range, so that it is reported for any
 * order of the rules. The value 0 of some parameters is separate: values between 0 and the reported range
 * are refused. */
static void test_every_reported_range_of_the_start_is_true(void)
{
    static const struct {
        const char *row;
        float middle;
    } rows[] = {{"start_current", 5.0f},   {"current_limit", 7.0f},      {"low_speed_current", 4.0f},
                {"start_ramp", 60.0f},     {"handover_speed", 20.0f},    {"fallback_speed", 10.0f},
                {"start_speed", 10.0f},    {"overspeed_trip", 60.0f},    {"dead_time", 2.5e-6f},
                {"motor_inertia", 0.06f},  {"motor_flux_linkage", 0.1f}, {"motor_resistance", 1.0f},
                {"dc_overvoltage", 300.0f}};
    enum { COUNT = sizeof rows / sizeof rows[0] };
    uint32_t told[COUNT] = {0};
    random_state = 7u;
    for (int n = 0; n < 20000; n += SWEEP_LONG) {
        params_defaults(&params);
        for (int m = 0; m < 4; m++) {
            const size_t at = (size_t)(random_share() * (float)COUNT);
            table_set(row_of(rows[at].row), &params, rows[at].middle * powf(9.0f, random_share() - 0.5f));
        }
        if (random_share() < 0.5f) {
            const size_t at = (size_t)(random_share() * (float)COUNT);
            table_set(row_of(rows[at].row), &params, -1.0f);
        }
        if (params_check(&params, &why)) {
            continue;
        }
        expect_true(&params);
        for (size_t at = 0; at < COUNT; at++) {
            told[at] += why.id == row_of(rows[at].row)->id && !params_none_accepted(&why);
        }
    }
    for (size_t at = 0; at < COUNT; at++) {
        TEST_ASSERT_TRUE_MESSAGE(told[at] > 100u / SWEEP_LONG, rows[at].row);
    }
}

/* If a parameter has no permitted value, a change of the named parameter gives one: at its advised value,
 * or, without one, at an end of its range. After the change the report names another parameter, or this
 * one with a range. */
static void test_the_row_to_change_makes_room_for_the_one_that_has_none(void)
{
    uint32_t found = 0u;
    random_state = 41u;
    for (int n = 0; n < 20000; n += SWEEP_LONG) {
        make_random_set();
        if (params_check(&params, &why) || !params_none_accepted(&why)) {
            continue;
        }
        TEST_ASSERT_TRUE_MESSAGE(why.change != why.id, why.rule);
        if (why.change == 0u) { /* at least two parameters must change together */
            continue;
        }
        const table_row_t *other = table_by_id(&params_table, why.change);
        TEST_ASSERT_NOT_NULL(other);
        const float ends[] = {table_min(other), table_max(other)};
        bool makes_room = false;
        for (int m = 0; m < (why.advice != 0.0f ? 1 : 2); m++) {
            params_t changed = params;
            params_error_t again;
            table_set(other, &changed, why.advice != 0.0f ? why.advice : ends[m]);
            makes_room = makes_room || params_check(&changed, &again) || again.id != why.id ||
                         !params_none_accepted(&again);
        }
        TEST_ASSERT_TRUE_MESSAGE(makes_room, why.rule);
        found++;
    }
    TEST_ASSERT_TRUE(found > 40u / SWEEP_LONG);
}

/* Every rule of the estimator that a set of parameters can violate: the field that the estimator itself
 * names, and the parameter by which it is reported. The ranges of the parameters exclude the other
 * violations. */
static const struct {
    const char *field, *row, *settings;
} broken[] = {
    {"resistance", "motor_resistance", "motor_resistance=99.9 device_resistance=0.2 motor_inductance_q=1"},
    {"period", "motor_resistance", "motor_resistance=62.6"},
    {"period", "motor_resistance", "motor_inductance_q=1.9e-4"},
    {"period", "motor_resistance", "device_resistance=1 motor_inductance_q=3e-4"},
    {"gain", "observer_gain", "observer_gain=302"},
    {"gain", "observer_gain", "observer_slope=1.6"},
    {"gain", "observer_gain", "motor_inductance_q=8e-3"},
    {"gain", "observer_gain", "observer_gain=177"},
    {"gain", "observer_gain", "overspeed_trip=249"},
    {"gain", "observer_gain", "motor_flux_linkage=0.25"},
    {"gain", "observer_gain", "motor_pole_pairs=5"},
    {"emf_cutoff", "observer_emf_cutoff", "observer_emf_cutoff=100"},
    {"emf_cutoff", "observer_emf_cutoff", "pll_bandwidth=4750 feedforward_cutoff=50"},
    {"emf_cutoff", "observer_emf_cutoff", "observer_emf_cutoff=105 pll_damping=2"},
    {"torque_feedforward", "torque_feedforward", "torque_feedforward=1 motor_inertia=4e-7"},
    {"torque_feedforward", "torque_feedforward",
     "torque_feedforward=0.5 feedforward_cutoff=0 pll_bandwidth=200"},
    {"speed_min", "estimate_speed_min", "estimate_speed_min=220"},
    {"speed_min", "estimate_speed_min", "estimate_speed_min=300"},
    {"period", "feedforward_cutoff",
     "feedforward_cutoff=200 pll_bandwidth=200"}, /* such a loop does not exist */
};

static void test_every_rule_of_the_estimator_is_reported_in_rows_and_truly(void)
{
    for (size_t n = 0; n < sizeof broken / sizeof broken[0]; n++) {
        estimator_params_t estimator;
        given_observer();
        set_rows(&params, broken[n].settings);
        const assumed_t assumed = params_configured(&params);
        params_estimator(&params, &assumed, &estimator);
        TEST_ASSERT_FALSE_MESSAGE(estimator_params_check(&estimator, &why), broken[n].field);
        TEST_ASSERT_EQUAL_STRING(broken[n].field, why.field);
        TEST_ASSERT_FALSE(params_check(&params, &why));
        TEST_ASSERT_EQUAL_STRING(broken[n].row, why.field);
        TEST_ASSERT_EQUAL_INT32(REASON_CROSS_RULE, why.reason);
        expect_true(&params);
    }
}

/* The largest EMF is 0.183 Wb x 4 x 220 rad/s = 161.04 V, which times 1.25 is 201.3 V. */
static void test_rules_of_thumb_are_reported(void)
{
    params.observer_gain = 100.0f;
    TEST_ASSERT_FALSE(params_check(&params, &why));
    TEST_ASSERT_EQUAL_UINT32(row_of("observer_gain")->id, why.change);
    TEST_ASSERT_FLOAT_WITHIN(1e-3f, 201.3f, why.advice);

    /* 1.6 x 12.5 mH/(200 V x 100 us) = 1/A. */
    given_observer();
    params.observer_slope = 2000.0f;
    TEST_ASSERT_FALSE(params_check(&params, &why));
    TEST_ASSERT_EQUAL_UINT32(row_of("observer_slope")->id, why.change);
    TEST_ASSERT_FLOAT_WITHIN(1e-5f, 1.0f, why.advice);

    /* The limit is 4/(0.5 1/A). */
    params_defaults(&params);
    params.observer_slope = 0.5f;
    params.estimate_current_max = -1.0f;
    TEST_ASSERT_FALSE(params_check(&params, &why));
    TEST_ASSERT_EQUAL_STRING("estimate_current_max", why.field);
    TEST_ASSERT_FLOAT_WITHIN(1e-5f, 8.0f, why.advice);
}

/* 300 rad/s need 1.1 x 219.6 V = 241.6 V, and with 9 mH and a slope of 1 the observer oscillates from 217
 * V on: no gain fulfils both. The slope must be reduced: 1.6 L/(k_s T) = 0.52459 with k_s = 1.25 x 219.6 V
 * = 274.5 V. */
static void test_a_gain_without_room_requires_another_slope(void)
{
    given_observer();
    set_rows(&params, "overspeed_trip=300 motor_inductance_d=9e-3 motor_inductance_q=9e-3");
    TEST_ASSERT_FALSE(params_check(&params, &why));
    TEST_ASSERT_EQUAL_STRING("observer_gain", why.field);
    TEST_ASSERT_TRUE(params_none_accepted(&why));
    TEST_ASSERT_EQUAL_UINT32(row_of("observer_slope")->id, why.change);
    TEST_ASSERT_FLOAT_WITHIN(1e-4f, 0.52459f, why.advice);
    params.observer_slope = why.advice;
    TEST_ASSERT_FALSE(params_check(&params, &why));
    TEST_ASSERT_EQUAL_UINT32(row_of("observer_gain")->id, why.change);
    TEST_ASSERT_FLOAT_WITHIN(0.01f, 274.5f, why.advice);
    params.observer_gain = why.advice;
    TEST_ASSERT_TRUE(params_check(&params, &why));
}

/* For a parameter beyond its own range the report has the range that all rules permit: 200 V/(1.1 x 0.183
 * Wb x 4) = 248.385 rad/s. */
static void test_a_row_out_of_range_is_reported_with_the_range_of_the_rules(void)
{
    given_observer();
    params.overspeed_trip = 20000.0f;
    TEST_ASSERT_FALSE(params_check(&params, &why));
    TEST_ASSERT_EQUAL_INT32(REASON_OUT_OF_RANGE, why.reason);
    TEST_ASSERT_FLOAT_WITHIN(1e-3f, 248.385f, why.max);
    TEST_ASSERT_FLOAT_WITHIN(1e-5f, 3.0f, why.min);
    TEST_ASSERT_TRUE(why.min > 3.0f); /* above estimate_speed_min */
    expect_true(&params);
    params.start_speed = 8.0f; /* a start by rule has its hand-over at this speed or above */
    TEST_ASSERT_FALSE(params_check(&params, &why));
    TEST_ASSERT_FLOAT_WITHIN(1e-5f, 8.0f / 0.3f, why.min);
    expect_true(&params);
}
