/* The float and the fixed-point twin run side by side on the same exact data. Their allowed difference
 * follows from the formats (estimator/fixed/formats.h) and from the 24 bits of a float. A current of up to
 * 6 A is rounded by 2.4e-7 A in float, which L/T = 125 ohm turns into 3e-5 V twice (sample and observer).
 * The arc tangent has an error of 1.2e-7 rad, in float 3e-6 rad. A count of the speed is 3e-5 rad/s; float
 * has 1e-7 of up to 1e3 rad/s, and its dead zone is 2e-4 mrad of angle. */
#include "estimator/fixed/fixed.h"
#include "tests/unit/estimator_bench.h"

#define VOLTAGE_APART   4e-4  /* [V] */
#define GAIN_APART      4e-6  /* [-] of k_f, computed from the same tanh */
#define MEAN_APART      1e-5  /* [-] of the power-weighted k_f, with x x of 0.0016 I^2 in counts of 2^-26 */
#define TRANSIENT_APART 0.05  /* [mrad] of the whole estimator during the transient */
#define MRAD_APART      0.01  /* [mrad] of the whole estimator after it */
#define SPEED_APART     0.003 /* [rad/s] of the whole estimator after the transient */

static fixed_t fix; /* the fixed-point estimator; est is the float one */

static estimator_params_t twin_params(smo_switching_t switching, lag_mode_t lag, float emf_cutoff)
{
    estimator_params_t params = paper_params(lag);
    params.smo.switching = switching;
    params.smo.emf_cutoff = emf_cutoff;
    params.pll.amplitude_floor = 2.0f;
    return params;
}

static void init_both(const estimator_params_t *params)
{
    estimator_init(&est, params);
    memset(&fix, 0, sizeof fix);
    fixed_init(&fix, params);
}

static void reset_both(const estimator_oracle_case_t *rig, long k, double beside)
{
    const estimator_oracle_sample_t now = sample_of(rig, k);
    position_t start = {(float)circle(now.theta + beside), (float)now.omega};
    estimator_reset(&est, start, as_float(now.current));
    fixed_reset(&fix, start, as_float(now.current));
}

/* ---- formats ---- */

static void test_units_are_the_bases_over_their_counts(void)
{
    estimator_params_t params = twin_params(SMO_SIGMOID_VECTOR, LAG_EXACT, 0.0f);
    init_both(&params);
    /* With k_s 200 V, U = 256 V; k_s T/L = 1.6 A, so that I = 2 A. */
    TEST_ASSERT_EQUAL_FLOAT(256.0f / 134217728.0f, fix.scale.units.voltage);
    TEST_ASSERT_EQUAL_FLOAT(2.0f / 33554432.0f, fix.scale.units.current);
    TEST_ASSERT_DOUBLE_WITHIN(2e-12, 2.0 * PI / T / 2147483648.0, (double)fix.scale.units.speed);
}

/* Both observers run on the same data for a second, with currents of 0 and 6 A in both directions. */
static void check_observers(smo_switching_t switching, float emf_cutoff)
{
    estimator_params_t params = twin_params(switching, LAG_CORRECTED, emf_cutoff);
    double volts = 0.0;
    double gain = 0.0;
    for (int n = 0; n < 8; n += SWEEP_FEW) {
        static const double rpm[] = {100.0, 500.0, 1000.0, 1500.0};
        double way = n % 2 ? -1.0 : 1.0;
        estimator_oracle_case_t rig = rig_of(0, way * rpm[n / 2] * RAD_PER_RPM, n / 4 ? 6.0 : 0.0);
        init_both(&params);
        for (long k = 1; k <= 3000; k++) {
            const estimator_oracle_sample_t now = sample_of(&rig, k);
            ab_t a = smo_step(&est.observer.smo, as_float(now.voltage), as_float(now.current));
            const ab_q_t u = {(int32_t)lrint(now.voltage[0] / (double)fix.scale.units.voltage),
                              (int32_t)lrint(now.voltage[1] / (double)fix.scale.units.voltage)};
            const ab_q_t i = {(int32_t)lrint(now.current[0] / (double)fix.scale.units.current),
                              (int32_t)lrint(now.current[1] / (double)fix.scale.units.current)};
            ab_q_t b = smo_step_q(&fix.q.smo, u, i);
            volts = fmax(volts, hypot((double)a.alpha - b.alpha * (double)fix.scale.units.voltage,
                                      (double)a.beta - b.beta * (double)fix.scale.units.voltage));
            double k_f = (double)smo_equivalent_gain(&est.observer.smo);
            gain = fmax(
                gain,
                fabs((double)smo_equivalent_gain_q(&fix.q.smo) * (double)fix.scale.units.gain / k_f - 1.0));
        }
    }
    check_below(volts, VOLTAGE_APART, "e_hat [V]");
    check_below(gain, switching == SMO_SIGMOID ? MEAN_APART : GAIN_APART, "k_f");
}

static void test_observers_of_both_forms(void)
{
    for (int s = SMO_SIGMOID; s <= SMO_SIGMOID_VECTOR; s++) {
        check_observers((smo_switching_t)s, 0.0f);
        check_observers((smo_switching_t)s, 2000.0f);
    }
}

/* ---- all blocks of the estimator in succession ---- */

/* Compares both estimators from an error of 0.1 rad on, through the transient and after it. */
static void check_composed(smo_switching_t switching, lag_mode_t mode, float emf_cutoff)
{
    static const double rpm[] = {100.0, 500.0, 1000.0, 1500.0};
    estimator_params_t params = twin_params(switching, mode, emf_cutoff);
    double transient = 0.0;
    double settled = 0.0;
    double speed = 0.0;
    for (int n = 0; n < 16; n += SWEEP_FEW) {
        double way = n % 2 ? -1.0 : 1.0;
        estimator_oracle_case_t rig = rig_of(0, way * rpm[n / 2 % 4] * RAD_PER_RPM, n / 8 ? way * 4.55 : 0.0);
        init_both(&params);
        reset_both(&rig, 0, 0.1);
        for (long k = 1; k <= 8000; k++) {
            const estimator_oracle_sample_t now = sample_of(&rig, k);
            position_t a = estimator_step(&est, as_float(now.voltage), as_float(now.current));
            position_t b = fixed_step(&fix, as_float(now.voltage), as_float(now.current));
            double between = 1e3 * fabs(circle((double)a.theta_e - (double)b.theta_e));
            if (k > 5000) {
                settled = fmax(settled, between);
                speed = fmax(speed, fabs((double)a.omega_e - (double)b.omega_e));
            } else {
                transient = fmax(transient, between);
            }
        }
        TEST_ASSERT_EQUAL_UINT16(estimator_invalid(&est), fixed_invalid(&fix));
    }
    check_below(transient, TRANSIENT_APART, "angle on the way [mrad]");
    check_below(settled, MRAD_APART, "angle [mrad]");
    check_below(speed, SPEED_APART, "speed [rad/s]");
}

static void test_estimators_of_both_forms(void)
{
    for (int mode = LAG_NONE; mode <= LAG_EXACT; mode++) {
        check_composed(SMO_SIGMOID_VECTOR, (lag_mode_t)mode, 2000.0f);
        check_composed(SMO_SIGMOID, (lag_mode_t)mode, 0.0f);
    }
    check_composed(SMO_SIGMOID_VECTOR, LAG_EXACT, 0.0f);
}

/* ---- the boundary ---- */

/* Each set is accepted by the float estimator and exceeds the range of a fixed-point format, above or
 * below. */
static void test_constants_that_do_not_fit_are_refused_by_name(void)
{
#define SET(field, value)                                                                                    \
    {                                                                                                        \
        offsetof(estimator_params_t, field), value                                                           \
    }
    static const struct {
        const char *field;
        bool above;
        lag_mode_t lag;
        struct {
            size_t at; /* 0 ends the list */
            float value;
        } set[3];
    } cases[] = {
        {"inductance", true, LAG_EXACT, {SET(smo.inductance, 0.9f)}},
        {"slope", true, LAG_EXACT, {SET(smo.inductance, 0.6f), SET(smo.slope, 40.0f)}},
        {"flux_linkage", false, LAG_EXACT, {SET(flux_linkage, 0.005f)}},
        {"amplitude_floor", false, LAG_EXACT, {SET(pll.amplitude_floor, 2e-3f)}},
        {"amplitude_floor", true, LAG_EXACT, {SET(pll.amplitude_floor, 2e3f)}},
        {"torque_feedforward", /* I would be 32 A */
         true,
         LAG_EXACT,
         {SET(smo.inductance, 1e-3f), SET(smo.slope, 0.1f), SET(torque_feedforward, 9e6f)}},
        {"ki", true, LAG_EXACT, {SET(pll.kp, 1.5e4f), SET(pll.ki, 8e7f), SET(smo.emf_cutoff, 0.0f)}},
        {"emf_cutoff", false, LAG_CORRECTED, {SET(smo.emf_cutoff, 10.0f)}},
        {"period", false, LAG_EXACT, {SET(smo.period, 2e-6f), SET(pll.period, 2e-6f)}},
    };
#undef SET
    params_error_t why;
    estimator_params_t params = twin_params(SMO_SIGMOID_VECTOR, LAG_EXACT, 2000.0f);
    TEST_ASSERT_TRUE(fixed_params_check(&params, &why));
    for (size_t n = 0; n < sizeof cases / sizeof cases[0]; n++) {
        params = twin_params(SMO_SIGMOID_VECTOR, cases[n].lag, 2000.0f);
        for (size_t m = 0; m < 3u && cases[n].set[m].at != 0u; m++) {
            memcpy((char *)&params + cases[n].set[m].at, &cases[n].set[m].value, sizeof(float));
        }
        TEST_ASSERT_TRUE_MESSAGE(estimator_params_check(&params, &why), cases[n].field);
        TEST_ASSERT_FALSE_MESSAGE(fixed_params_check(&params, &why), cases[n].field);
        TEST_ASSERT_EQUAL_STRING(cases[n].field, why.field);
        TEST_ASSERT_NOT_NULL(strstr(why.rule, "fixed"));
        TEST_ASSERT_TRUE(cases[n].above ? why.value > why.max : why.value < why.min);
    }
}

static void test_the_limit_of_a_refusal_is_accepted(void)
{
    params_error_t why;
    estimator_params_t params = twin_params(SMO_SIGMOID_VECTOR, LAG_EXACT, 2000.0f);
    params.flux_linkage = 0.005f;
    TEST_ASSERT_FALSE(fixed_params_check(&params, &why));
    params.flux_linkage = why.min;
    TEST_ASSERT_TRUE(fixed_params_check(&params, &why));
    fixed_init(&fix, &params);
    params.flux_linkage = nextafterf(params.flux_linkage, 0.0f);
    TEST_ASSERT_FALSE(fixed_params_check(&params, &why));
}

/* With a value beyond the formats the loop coasts, and the next valid sample is used. */
static void test_samples_that_do_not_fit_are_invalid(void)
{
    static const float bad[] = {NAN, INFINITY, -INFINITY, 1e30f, -1100.0f, 1100.0f};
    estimator_params_t params = twin_params(SMO_SIGMOID_VECTOR, LAG_EXACT, 2000.0f);
    estimator_oracle_case_t rig = rig_of(0, 1000.0 * RAD_PER_RPM, 4.0);
    for (unsigned n = 0; n < sizeof bad / sizeof bad[0]; n++) {
        for (int place = 0; place < 4; place++) {
            estimator_oracle_sample_t now;
            init_both(&params);
            reset_both(&rig, 0, 0.0);
            for (long k = 1; k < 100; k++) {
                now = sample_of(&rig, k);
                (void)fixed_step(&fix, as_float(now.voltage), as_float(now.current));
            }
            float v[4] = {0.0f, 50.0f, 1.0f, 0.0f};
            v[place] = bad[n];
            now = sample_of(&rig, 100);
            position_t coasting = fixed_step(&fix, (ab_t){v[0], v[1]}, (ab_t){v[2], v[3]});
            TEST_ASSERT_TRUE((fixed_invalid(&fix) & ESTIMATOR_SAMPLE) != 0u);
            TEST_ASSERT_DOUBLE_WITHIN(1e-4, 0.0, circle((double)coasting.theta_e - now.theta));
            now = sample_of(&rig, 101);
            (void)fixed_step(&fix, as_float(now.voltage), as_float(now.current));
            TEST_ASSERT_EQUAL_UINT16(0, fixed_invalid(&fix));
        }
    }
}

/* 4 U = 1024 V and 16 I = 32 A are the largest valid values. */
static void test_range_of_the_samples(void)
{
    estimator_params_t params = twin_params(SMO_SIGMOID_VECTOR, LAG_EXACT, 2000.0f);
    init_both(&params);
    (void)fixed_step(&fix, (ab_t){1.0f, 0.0f}, (ab_t){1.0f, 0.0f});
    (void)fixed_step(&fix, (ab_t){1024.0f, -1024.0f}, (ab_t){-32.0f, 32.0f});
    TEST_ASSERT_EQUAL_UINT16(0, fixed_invalid(&fix) & ESTIMATOR_SAMPLE);
    (void)fixed_step(&fix, (ab_t){1024.1f, 0.0f}, (ab_t){0.0f, 0.0f});
    TEST_ASSERT_EQUAL_UINT16(ESTIMATOR_SAMPLE, fixed_invalid(&fix) & ESTIMATOR_SAMPLE);
    (void)fixed_step(&fix, (ab_t){0.0f, 0.0f}, (ab_t){0.0f, 32.01f});
    TEST_ASSERT_EQUAL_UINT16(ESTIMATOR_SAMPLE, fixed_invalid(&fix) & ESTIMATOR_SAMPLE);
}

/* k_s of 300 V needs U = 512 V and I = 4 A: the state is converted to these bases and back, and continues
 * like that of the float estimator. */
static void test_take_in_other_bases_keeps_the_estimate(void)
{
    estimator_params_t params = twin_params(SMO_SIGMOID_VECTOR, LAG_EXACT, 2000.0f);
    estimator_params_t other = params;
    other.smo.gain = 300.0f;
    other.smo.slope = 0.6f;
    estimator_oracle_case_t rig = rig_of(0, 1000.0 * RAD_PER_RPM, 4.0);
    double apart = 0.0;
    estimator_oracle_sample_t now;
    init_both(&params);
    reset_both(&rig, 0, 0.0);
    for (long k = 1; k <= 6000; k++) {
        if (k % 1000 == 0) {
            const float before = fix.scale.units.voltage;
            estimator_tuning_t tuning;
            fixed_tuning_t fixed_tuning;
            estimator_prepare(&tuning, k % 2000 ? &other : &params);
            estimator_take(&est, &tuning);
            fixed_prepare(&fixed_tuning, k % 2000 ? &other : &params);
            fixed_take(&fix, &fixed_tuning);
            TEST_ASSERT_TRUE(before != fix.scale.units.voltage);
        }
        now = sample_of(&rig, k);
        position_t a = estimator_step(&est, as_float(now.voltage), as_float(now.current));
        position_t b = fixed_step(&fix, as_float(now.voltage), as_float(now.current));
        apart = fmax(apart, 1e3 * fabs(circle((double)a.theta_e - (double)b.theta_e)));
    }
    check_below(apart, TRANSIENT_APART, "angle [mrad]");
}

/* The limit of each criterion in counts: a value at the limit holds, a value one count beyond does not. */
static void test_at_its_limit_a_criterion_still_holds(void)
{
    estimator_params_t params = twin_params(SMO_SIGMOID_VECTOR, LAG_EXACT, 2000.0f);
    params.validity.amplitude_max = 1.5f;
    estimator_oracle_case_t rig = rig_of(0, 1000.0 * RAD_PER_RPM, 4.0);
    estimator_oracle_sample_t now;
    init_both(&params);
    reset_both(&rig, 0, 0.05);
    for (long k = 1; k < 60; k++) {
        now = sample_of(&rig, k);
        (void)fixed_step(&fix, as_float(now.voltage), as_float(now.current));
    }
    const estimator_q_t before = fix.q;
    now = sample_of(&rig, 60);
    (void)fixed_step(&fix, as_float(now.voltage), as_float(now.current));
    const estimator_q_t judged = fix.q;
    const int32_t speed = q_magnitude(judged.pll.omega_smooth);
    const int32_t detector = q_magnitude(judged.pll.detector);
    TEST_ASSERT_TRUE(speed > 1000 && detector > 1000);
    for (int32_t n = 0; n < 6; n++) {
        const int32_t beyond = n % 2;
        const uint32_t bit = n < 4 ? ESTIMATOR_SPEED : ESTIMATOR_DETECTOR;
        fix.q = before;
        *(n < 2   ? &fix.q.tuning.speed_min
          : n < 4 ? &fix.q.tuning.speed_max
                  : &fix.q.tuning.detector_max) =
            n < 2 ? speed + beyond : (n < 4 ? speed : detector) - beyond;
        (void)fixed_step(&fix, as_float(now.voltage), as_float(now.current));
        TEST_ASSERT_EQUAL_UINT16(beyond != 0 ? bit : 0u, fixed_invalid(&fix));
    }
}
