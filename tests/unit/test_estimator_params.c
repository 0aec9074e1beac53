/* The parameters of the estimator. */
#include "tests/unit/estimator_bench.h"

/* ---- parameters ---- */

#define AT(member) offsetof(estimator_params_t, member)
#define OF(member) AT(validity.member)
#define CUTOFF     AT(pll.feedforward_cutoff)

static estimator_params_t full_params(void)
{
    estimator_params_t params = params_of(0);
    params.smo.gain = 200.0f;
    params.flux_linkage = 0.2f;
    params.flux_adaptation = 3.0f;
    params.torque_feedforward = 69.0f;
    params.validity = (validity_params_t){0.5f, 1.5f, 0.05f, 0.5f, 0.05f, 5.0f, 0.05f, 40.0f, 800.0f, 0.05f};
    return params;
}

/* The name of a field may have the name of its part before it. */
static bool named(const char *field, const char *expected)
{
    const char *dot = strrchr(field, '.');
    return strcmp(dot != NULL ? dot + 1 : field, expected) == 0;
}

static void test_check_names_each_field_value_and_range(void)
{
    static const struct {
        size_t offset;
        const char *field;
        float min, max;
    } rows[] = {
        {AT(flux_linkage), "flux_linkage", 1e-4f, 10.0f},
        {AT(flux_adaptation), "flux_adaptation", 0.0f, 100.0f},
        {AT(torque_feedforward), "torque_feedforward", 0.0f, 1e7f},
        {OF(amplitude_min), "amplitude_min", 0.0f, 1.0f},
        {OF(amplitude_time), "amplitude_time", 0.0f, 10.0f},
        {OF(detector_max), "detector_max", 0.0f, 1.0f},
        {OF(detector_time), "detector_time", 0.0f, 10.0f},
        {OF(current_max), "current_max", 0.0f, 1e3f},
        {OF(current_time), "current_time", 0.0f, 10.0f},
        {OF(speed_min), "speed_min", 0.0f, 1e6f},
        {OF(speed_max), "speed_max", 0.0f, 1e6f},
        {OF(speed_time), "speed_time", 0.0f, 10.0f},
    };
    params_error_t why;
    estimator_params_t params = full_params();
    TEST_ASSERT_TRUE(estimator_params_check(&params, &why));
    for (size_t n = 0; n < sizeof rows / sizeof rows[0]; n++) {
        const float bad[] = {nextafterf(rows[n].min, -1.0f), nextafterf(rows[n].max, INFINITY), NAN,
                             -INFINITY};
        for (int m = 0; m < 4; m++) {
            params = full_params();
            memcpy((char *)&params + rows[n].offset, &bad[m], sizeof bad[m]);
            why = (params_error_t){0};
            TEST_ASSERT_FALSE_MESSAGE(estimator_params_check(&params, &why), rows[n].field);
            TEST_ASSERT_TRUE_MESSAGE(named(why.field, rows[n].field), rows[n].field);
            TEST_ASSERT_NOT_NULL(why.rule);
            TEST_ASSERT_TRUE(isnan(bad[m]) ? isnan(why.value) : why.value == bad[m]);
            TEST_ASSERT_FLOAT_WITHIN(1e-6f * rows[n].min, rows[n].min, why.min);
            TEST_ASSERT_FLOAT_WITHIN(1e-6f * rows[n].max, rows[n].max, why.max);
        }
        /* At the limits this rule holds; another rule may then report an error with another text. */
        for (int m = 0; m < 2; m++) {
            params = full_params();
            float limit = m ? rows[n].max : rows[n].min;
            memcpy((char *)&params + rows[n].offset, &limit, sizeof limit);
            memset(&why, 0, sizeof why);
            TEST_ASSERT_TRUE_MESSAGE(estimator_params_check(&params, &why) ||
                                         strcmp(why.rule, "range of the parameter") != 0,
                                     rows[n].field);
        }
    }
}

/* Each set breaks one rule. The table has the reported parameter, its value and its range, if these are
 * known, and a change that makes the set valid. The largest EMF is 1.1 x 0.2 Wb x 800 rad/s = 176 V, or
 * 220 V; 2/T + ki T/2 is 20000.134. */
static void test_check_refuses_what_rules_between_fields_forbid(void)
{
    const struct {
        const char *field;
        struct {
            size_t at;
            float value;
        } set[2], instead;
        float value, min, max;
    } rules[] = {
        {"gain", {{AT(smo.gain), 175.99f}}, {AT(smo.gain), 176.01f}, 175.99f, 176.0f, 1e4f},
        {"gain", {{AT(validity.speed_max), 1000.0f}}, {AT(smo.gain), 220.1f}, 200.0f, 220.0f, 1e4f},
        {"gain", {{AT(flux_linkage), 0.25f}}, {AT(validity.speed_max), 0.0f}, 200.0f, 220.0f, 1e4f},
        {"gain", {{AT(smo.gain), 480.0f}}, {AT(smo.slope), 0.6f}, 480.0f, NAN, NAN},
        {"period", {{AT(pll.period), nextafterf(1e-4f, 1.0f)}}, {AT(pll.period), 1e-4f}, NAN, 1e-4f, 1e-4f},
        {"period", {{AT(pll.period), 0.5e-4f}}, {AT(pll.period), 1e-4f}, 0.5e-4f, 1e-4f, 1e-4f},
        {"torque_feedforward", {{CUTOFF, 0.0f}}, {AT(torque_feedforward), 0.0f}, 69.0f, 0.0f, 0.0f},
        {"torque_feedforward", {{CUTOFF, 0.0f}}, {CUTOFF, 1e-3f}, 69.0f, 0.0f, 0.0f},
        {"speed_min", {{OF(speed_min), 800.0f}}, {OF(speed_min), 799.9999f}, 800.0f, 0.0f, 800.0f},
        {"speed_min", {{OF(speed_min), 801.0f}}, {OF(speed_max), 0.0f}, 801.0f, 0.0f, 800.0f},
        {"amplitude_max", {{OF(amplitude_max), -1.0f}}, {OF(amplitude_max), 0.0f}, -1.0f, 1.0f, 100.0f},
        {"amplitude_max", {{OF(amplitude_max), 1.0f}}, {OF(amplitude_max), 1.0001f}, 1.0f, 1.0f, 100.0f},
        {"amplitude_max", {{OF(amplitude_max), 100.1f}}, {OF(amplitude_max), 100.0f}, 100.1f, 1.0f, 100.0f},
        {"amplitude_max", {{OF(amplitude_max), NAN}}, {OF(amplitude_max), 2.0f}, NAN, 1.0f, 100.0f},
        {"kp", {{AT(pll.kp), 3e4f}}, {AT(pll.kp), 104.0f}, 3e4f, NAN, NAN},
        {"kp",
         {{AT(pll.kp), 20000.2f}, {AT(smo.emf_cutoff), 0.0f}},
         {AT(pll.kp), 20000.05f},
         20000.2f,
         NAN,
         NAN},
        {"ki", {{AT(pll.ki), -1.0f}}, {AT(pll.ki), 2700.0f}, -1.0f, NAN, NAN},
    };
    for (size_t n = 0; n < sizeof rules / sizeof rules[0]; n++) {
        params_error_t why = {0};
        estimator_params_t params = full_params();
        for (size_t m = 0; m < 2u && (m == 0u || rules[n].set[m].at != 0u); m++) {
            memcpy((char *)&params + rules[n].set[m].at, &rules[n].set[m].value, sizeof(float));
        }
        TEST_ASSERT_FALSE_MESSAGE(estimator_params_check(&params, &why), rules[n].field);
        TEST_ASSERT_TRUE_MESSAGE(named(why.field, rules[n].field), why.field);
        TEST_ASSERT_TRUE_MESSAGE(isnan(rules[n].value) || why.value == rules[n].value, why.field);
        if (!isnan(rules[n].min)) {
            TEST_ASSERT_FLOAT_WITHIN(1e-6f * rules[n].min, rules[n].min, why.min);
            TEST_ASSERT_FLOAT_WITHIN(1e-6f * rules[n].max, rules[n].max, why.max);
        }
        memcpy((char *)&params + rules[n].instead.at, &rules[n].instead.value, sizeof(float));
        TEST_ASSERT_TRUE_MESSAGE(estimator_params_check(&params, &why), rules[n].field);
    }
}

static void test_check_refuses_what_is_not_a_choice(void)
{
    for (int n = -1; n <= 4; n++) {
        params_error_t why = {.field = "unchanged"};
        estimator_params_t params = full_params();
        params.lag = (lag_mode_t)n;
        TEST_ASSERT_EQUAL(n >= (int)LAG_NONE && n <= (int)LAG_EXACT, estimator_params_check(&params, &why));
        TEST_ASSERT_EQUAL_STRING(n >= (int)LAG_NONE && n <= (int)LAG_EXACT ? "unchanged" : "lag", why.field);
        params = full_params();
        params.smo.switching = (smo_switching_t)n;
        TEST_ASSERT_EQUAL(n >= 0 && n < 3, estimator_params_check(&params, &why));
        TEST_ASSERT_TRUE((n >= 0 && n < 3) || named(why.field, "switching"));
    }
}
