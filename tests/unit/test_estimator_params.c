/* The estimator's set of parameters. */
#include <setjmp.h>
#include <signal.h>

#include "tests/unit/estimator_bench.h"

/* ---- 9. parameters ---- */

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

/* The name of a part's field may have the part before it. */
static bool named(const char *field, const char *expected)
{
    const char *dot = strrchr(field, '.');
    return strcmp(dot != NULL ? dot + 1 : field, expected) == 0;
}

static void check_refused(const estimator_params_t *params, const char *field, float value, float min,
                          float max)
{
    params_error_t why;
    memset(&why, 0, sizeof why);
    TEST_ASSERT_FALSE_MESSAGE(estimator_params_check(params, &why), field);
    TEST_ASSERT_NOT_NULL(why.field);
    TEST_ASSERT_TRUE_MESSAGE(named(why.field, field), why.field);
    TEST_ASSERT_NOT_NULL(why.rule);
    if (isnan(value)) {
        TEST_ASSERT_TRUE(isnan(why.value));
    } else {
        TEST_ASSERT_TRUE(why.value == value);
    }
    TEST_ASSERT_FLOAT_WITHIN(1e-6f * fabsf(min), min, why.min);
    TEST_ASSERT_FLOAT_WITHIN(1e-6f * fabsf(max), max, why.max);
}

static void test_check_names_each_field_value_and_range(void)
{
    static const struct {
        size_t offset;
        const char *field;
        float min, max;
    } rows[] = {
        {offsetof(estimator_params_t, flux_linkage), "flux_linkage", 1e-4f, 10.0f},
        {offsetof(estimator_params_t, flux_adaptation), "flux_adaptation", 0.0f, 100.0f},
        {offsetof(estimator_params_t, torque_feedforward), "torque_feedforward", 0.0f, 1e7f},
        {offsetof(estimator_params_t, validity.amplitude_min), "amplitude_min", 0.0f, 1.0f},
        {offsetof(estimator_params_t, validity.amplitude_time), "amplitude_time", 0.0f, 10.0f},
        {offsetof(estimator_params_t, validity.detector_max), "detector_max", 0.0f, 1.0f},
        {offsetof(estimator_params_t, validity.detector_time), "detector_time", 0.0f, 10.0f},
        {offsetof(estimator_params_t, validity.current_max), "current_max", 0.0f, 1e3f},
        {offsetof(estimator_params_t, validity.current_time), "current_time", 0.0f, 10.0f},
        {offsetof(estimator_params_t, validity.speed_min), "speed_min", 0.0f, 1e6f},
        {offsetof(estimator_params_t, validity.speed_max), "speed_max", 0.0f, 1e6f},
        {offsetof(estimator_params_t, validity.speed_time), "speed_time", 0.0f, 10.0f},
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
            check_refused(&params, rows[n].field, bad[m], rows[n].min, rows[n].max);
        }
        /* At the limits this rule holds; where a cross-rule speaks up, it is another text. */
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

static void test_check_refuses_what_is_no_lag_mode(void)
{
    estimator_params_t params = full_params();
    params.lag = (lag_mode_t)(LAG_EXACT + 1);
    check_refused(&params, "lag", 4.0f, 0.0f, 3.0f);
    params.lag = (lag_mode_t)-1;
    params_error_t why;
    TEST_ASSERT_FALSE(estimator_params_check(&params, &why));
    params_error_t none = {.field = "untouched"};
    for (int n = LAG_NONE; n <= LAG_EXACT; n++) {
        params.lag = (lag_mode_t)n;
        TEST_ASSERT_TRUE(estimator_params_check(&params, &none));
    }
    TEST_ASSERT_EQUAL_STRING("untouched", none.field);
}

static void test_check_refuses_a_gain_below_the_largest_emf(void)
{
    /* 1.1 0.2 Wb 800 rad/s = 176 V */
    params_error_t why;
    estimator_params_t params = full_params();
    params.smo.gain = 175.99f;
    check_refused(&params, "gain", 175.99f, 176.0f, 1e4f);
    params.smo.gain = 176.01f;
    TEST_ASSERT_TRUE(estimator_params_check(&params, &why));
    params.smo.gain = 10.0f;
    params.validity.speed_max = 0.0f; /* not known, not judged */
    TEST_ASSERT_TRUE(estimator_params_check(&params, &why));
    params = full_params();
    TEST_ASSERT_FALSE(estimator_params_check(&params, &why) && params.validity.speed_max != 800.0f);
    params.validity.speed_max = 1000.0f; /* 220 V */
    check_refused(&params, "gain", 200.0f, 220.0f, 1e4f);
    params = full_params();
    params.flux_linkage = 0.25f;
    check_refused(&params, "gain", 200.0f, 220.0f, 1e4f);
}

static void test_check_refuses_unequal_periods(void)
{
    estimator_params_t params = full_params();
    params.pll.period = nextafterf(params.pll.period, 1.0f);
    check_refused(&params, "period", params.pll.period, 1e-4f, 1e-4f);
    params.pll.period = 0.5e-4f;
    check_refused(&params, "period", 0.5e-4f, 1e-4f, 1e-4f);
}

static void test_check_refuses_a_torque_share_that_nothing_forgets(void)
{
    params_error_t why;
    estimator_params_t params = full_params();
    params.pll.feedforward_cutoff = 0.0f;
    check_refused(&params, "torque_feedforward", 69.0f, 0.0f, 0.0f);
    params.torque_feedforward = 0.0f;
    TEST_ASSERT_TRUE(estimator_params_check(&params, &why));
    params.torque_feedforward = 69.0f;
    params.pll.feedforward_cutoff = 1e-3f;
    TEST_ASSERT_TRUE(estimator_params_check(&params, &why));
}

static void test_check_wants_speed_limits_in_order(void)
{
    params_error_t why;
    estimator_params_t params = full_params();
    params.validity.speed_min = 800.0f;
    check_refused(&params, "speed_min", 800.0f, 0.0f, 800.0f);
    params.validity.speed_min = 801.0f;
    check_refused(&params, "speed_min", 801.0f, 0.0f, 800.0f);
    params.validity.speed_min = nextafterf(800.0f, 0.0f);
    TEST_ASSERT_TRUE(estimator_params_check(&params, &why));
    params.validity.speed_min = 801.0f;
    params.validity.speed_max = 0.0f;
    TEST_ASSERT_TRUE(estimator_params_check(&params, &why));
}

static void test_check_wants_the_upper_amplitude_above_one_or_off(void)
{
    static const float bad[] = {-1.0f, 0.5f, 1.0f, 100.1f, INFINITY};
    static const float good[] = {0.0f, 1.0001f, 2.0f, 100.0f};
    params_error_t why;
    for (int n = 0; n < 5; n++) {
        estimator_params_t params = full_params();
        params.validity.amplitude_max = bad[n];
        check_refused(&params, "amplitude_max", bad[n], 1.0f, 100.0f);
    }
    for (int n = 0; n < 4; n++) {
        estimator_params_t params = full_params();
        params.validity.amplitude_max = good[n];
        TEST_ASSERT_TRUE(estimator_params_check(&params, &why));
    }
    estimator_params_t params = full_params();
    params.validity.amplitude_max = NAN;
    TEST_ASSERT_FALSE(estimator_params_check(&params, &why));
}

static void test_check_passes_on_what_observer_and_loop_refuse(void)
{
    params_error_t why;
    estimator_params_t params = full_params();
    params.smo.gain = 480.0f; /* loop gain 1.9 */
    TEST_ASSERT_FALSE(estimator_params_check(&params, &why));
    TEST_ASSERT_TRUE(named(why.field, "gain") && why.max < 310.0f);
    params = full_params();
    params.smo.switching = (smo_switching_t)3;
    TEST_ASSERT_FALSE(estimator_params_check(&params, &why));
    TEST_ASSERT_TRUE(named(why.field, "switching"));
    params = full_params();
    params.pll.kp = 3e4f;
    TEST_ASSERT_FALSE(estimator_params_check(&params, &why));
    TEST_ASSERT_TRUE(named(why.field, "kp"));
    /* 2/T + ki T/2 = 20000.134 */
    params = full_params();
    params.pll.kp = 20000.05f;
    params.smo.emf_cutoff = 0.0f;
    TEST_ASSERT_TRUE(estimator_params_check(&params, &why));
    params.pll.kp = 20000.2f;
    TEST_ASSERT_FALSE(estimator_params_check(&params, &why));
    params = full_params();
    params.pll.ki = -1.0f;
    TEST_ASSERT_FALSE(estimator_params_check(&params, &why));
    TEST_ASSERT_TRUE(named(why.field, "ki"));
}

static jmp_buf back;

static void aborted(int signal_number)
{
    (void)signal_number;
    longjmp(back, 1);
}

static void test_init_asserts_on_a_set_that_the_check_refuses(void)
{
    estimator_params_t params = full_params();
    params.smo.gain = 100.0f;
    (void)signal(SIGABRT, aborted);
    if (setjmp(back) == 0) {
        init(&params);
        (void)signal(SIGABRT, SIG_DFL);
        TEST_FAIL_MESSAGE("estimator_init took a gain below the largest EMF");
    }
    (void)signal(SIGABRT, SIG_DFL);
}

static void test_retune_keeps_the_state(void)
{
    estimator_params_t params = params_of(0);
    estimator_oracle_case_t rig = rig_of(0, 400.0, 3.0);
    (void)settled(&params, &rig);
    estimator_t before = est;
    estimator_params_t other = params;
    tune(&other, 100.0, 25.0);
    other.smo.gain = 150.0f;
    other.flux_adaptation = 3.0f;
    retune(&other);
    TEST_ASSERT_TRUE(est.tracker.pll.tuning.kp == other.pll.kp && est.observer.smo.tuning.gain == 150.0f);
    TEST_ASSERT_TRUE(est.tracker.pll.theta_e == before.tracker.pll.theta_e &&
                     est.tracker.pll.integral == before.tracker.pll.integral);
    retune(&params);
    TEST_ASSERT_EQUAL_MEMORY(&before, &est, sizeof est);
}
