/* Float and fixed twin side by side on one set of exact data, each module alone and all in a row. How far
 * they may be apart follows from the formats (estimator/fixed/formats.h) and from float's own 24 bits:
 *
 *   voltages   a current of up to 6 A is rounded by 2.4e-7 A in float, which L/T = 125 ohm makes 3e-5 V
 *              twice (sample and observer); k_f and tanh differ by 3e-6 in what v is for a given error, not
 *              in what it settles on: 1e-4 V of 200 V
 *   k_f        the same tanh: 3e-6, and a count of Q24 in 0.5
 *   lag        counts of Q24 and Q28 in vectors of about 1: 2e-7; float 5e-7
 *   angles     1.2e-7 rad of the arc tangent; float 3e-6; the polynomials of tan 2e-6
 *   speeds     3e-5 rad/s a count; float 1e-7 of up to 1e3 rad/s and its dead zone, 2e-4 of a mrad of angle
 */
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <unity.h>

#include "estimator/fixed/fixed.h"
#include "tests/oracle/estimator_oracle.h"
#include "tests/unit/compare.h"

#define T           1e-4
#define RAD_PER_RPM (4.0 * PI / 30.0)
#define PSI         0.183

#define VOLTAGE_APART    4e-4   /* [V] */
#define GAIN_APART       4e-6   /* of k_f [-] */
#define MEAN_APART       1e-5   /* of the power-weighted k_f: x x of 0.0016 I^2 in counts of 2^-26 [-] */
#define LENGTH_APART     8e-6   /* [-] */
#define ANGLE_APART      5e-6   /* [rad] */
#define LOOP_APART       5.5e-5 /* [rad] float integrator at rest, either way: 0.1 mrad 1624/6495; rotation */
#define LOOP_SPEED_APART 3e-3   /* [rad/s] settled */
#define TRANSIENT_APART  0.05   /* composed, on the way [mrad] */
#define MRAD_APART       0.01   /* composed, settled [mrad] */
#define SPEED_APART      0.003  /* composed, settled [rad/s] */

static estimator_t flt;
static fixed_t fix;

void setUp(void)
{
    memset(&flt, 0, sizeof flt);
    memset(&fix, 0, sizeof fix);
}

static ab_t as_float(const double value[2])
{
    return (ab_t){(float)value[0], (float)value[1]};
}

static estimator_params_t params_of(smo_switching_t switching, lag_mode_t lag, float emf_cutoff)
{
    estimator_params_t params = {.smo = {.resistance = 0.95f,
                                         .inductance = 0.0125f,
                                         .gain = 200.0f,
                                         .slope = 1.0f,
                                         .emf_cutoff = emf_cutoff,
                                         .period = 1e-4f,
                                         .switching = switching},
                                 .lag = lag,
                                 .pll = {.amplitude_floor = 2.0f},
                                 .flux_linkage = (float)PSI};
    TEST_ASSERT_TRUE(pll_design(&params.pll, 200.0f, 1.0f, 50.0f, 1e-4f));
    return params;
}

static estimator_oracle_case_t rig_of(double rpm, double current_q)
{
    estimator_oracle_case_t rig = {.resistance = 0.95,
                                   .inductance = 0.0125,
                                   .flux_linkage = PSI,
                                   .period = T,
                                   .theta_start = 0.3,
                                   .omega_start = rpm * RAD_PER_RPM,
                                   .current_q = current_q};
    return rig;
}

static void init(const estimator_params_t *params)
{
    estimator_init(&flt, params);
    fixed_init(&fix, params);
}

static void reset(const estimator_oracle_case_t *rig, long k, double beside)
{
    estimator_oracle_sample_t now;
    estimator_oracle_sample(rig, k, &now);
    position_t start = {(float)circle(now.theta + beside), (float)now.omega};
    estimator_reset(&flt, start, as_float(now.current));
    fixed_reset(&fix, start, as_float(now.current));
}

/* ---- formats ---- */

static void test_units_are_the_bases_over_their_counts(void)
{
    estimator_params_t params = params_of(SMO_SIGMOID_VECTOR, LAG_EXACT, 0.0f);
    init(&params);
    /* k_s 200 V: U = 256 V; k_s T/L = 1.6 A: I = 2 A. */
    TEST_ASSERT_EQUAL_FLOAT(256.0f / 134217728.0f, fix.scale.units.voltage);
    TEST_ASSERT_EQUAL_FLOAT(2.0f / 33554432.0f, fix.scale.units.current);
    TEST_ASSERT_DOUBLE_WITHIN(2e-12, 2.0 * PI / T / 2147483648.0, (double)fix.scale.units.speed);
}

/* ---- each module ---- */

/* Both observers run on the same data for a second; currents of 0 and 6 A, both directions. */
static void check_observers(smo_switching_t switching, float emf_cutoff)
{
    estimator_params_t params = params_of(switching, LAG_CORRECTED, emf_cutoff);
    double volts = 0.0;
    double gain = 0.0;
    for (int n = 0; n < 8; n++) {
        static const double rpm[] = {100.0, 500.0, 1000.0, 1500.0};
        double way = n % 2 ? -1.0 : 1.0;
        estimator_oracle_case_t rig = rig_of(way * rpm[n / 2], n / 4 ? 6.0 : 0.0);
        init(&params);
        for (long k = 1; k <= 3000; k++) {
            estimator_oracle_sample_t now;
            estimator_oracle_sample(&rig, k, &now);
            ab_t a = smo_step(&flt.observer.smo, as_float(now.voltage), as_float(now.current));
            const ab_q_t u = {(int32_t)lrint(now.voltage[0] / (double)fix.scale.units.voltage),
                              (int32_t)lrint(now.voltage[1] / (double)fix.scale.units.voltage)};
            const ab_q_t i = {(int32_t)lrint(now.current[0] / (double)fix.scale.units.current),
                              (int32_t)lrint(now.current[1] / (double)fix.scale.units.current)};
            ab_q_t b = smo_step_q(&fix.q.smo, u, i);
            volts = fmax(volts, hypot((double)a.alpha - b.alpha * (double)fix.scale.units.voltage,
                                      (double)a.beta - b.beta * (double)fix.scale.units.voltage));
            double k_f = (double)smo_equivalent_gain(&flt.observer.smo);
            gain = fmax(
                gain,
                fabs((double)smo_equivalent_gain_q(&fix.q.smo) * (double)fix.scale.units.gain / k_f - 1.0));
        }
    }
    check_below(volts, VOLTAGE_APART, "e_hat [V]");
    check_below(gain, switching == SMO_SIGMOID ? MEAN_APART : GAIN_APART, "k_f");
}

static void test_observers_of_the_vector_form(void)
{
    check_observers(SMO_SIGMOID_VECTOR, 0.0f);
    check_observers(SMO_SIGMOID_VECTOR, 2000.0f);
}

static void test_observers_per_axis(void)
{
    check_observers(SMO_SIGMOID, 0.0f);
    check_observers(SMO_SIGMOID, 2000.0f);
}

/* Lag and length that each twin makes of the same settled state, at every speed. */
static void check_lags(lag_mode_t mode, float emf_cutoff)
{
    estimator_params_t params = params_of(SMO_SIGMOID_VECTOR, LAG_CORRECTED, emf_cutoff);
    init(&params);
    double angle = 0.0;
    double length = 0.0;
    for (double omega = -6000.0; omega <= 6000.0; omega += 37.0) {
        int32_t speed = (int32_t)lrint(omega / (double)fix.scale.units.speed);
        double a = (double)lag_angle(&flt.observer.smo, mode, (float)omega);
        double b = (double)q_signed(lag_angle_q(&fix.q.smo, mode, speed)) * PI / 2147483648.0;
        angle = fmax(angle, fabs(circle(a - b)));
        double full = (double)lag_attenuation(&flt.observer.smo, (float)omega);
        double part = (double)lag_attenuation_q(&fix.q.smo, speed) / 16777216.0;
        length = fmax(length, fabs(part / full - 1.0));
    }
    check_below(angle, ANGLE_APART, "lag [rad]");
    check_below(length, LENGTH_APART, "attenuation");
}

static void test_lags(void)
{
    for (int mode = LAG_NONE; mode <= LAG_EXACT; mode++) {
        check_lags((lag_mode_t)mode, 0.0f);
        check_lags((lag_mode_t)mode, 2000.0f);
    }
}

/* The error of an EMF, forward again: e = Z(k_f(|x|)) x (lag.h), in double precision with W in its closed
 * form. Half a count of x on each axis, 42 nA, times 90 ohm is 2e-6 of the smallest; what the four steps
 * leave is lag.c's word, and as the angle of Z depends on k_f, it may show in the direction too. Beyond 0.99
 * k_s the length is that. */
static void test_error_of_an_emf_makes_it_again(void)
{
    static const struct {
        double share, off;
    } emfs[] = {{0.01, 2e-6}, {0.3, 0.0}, {0.7, 1e-7}, {0.9, 2e-4}, {0.99, 0.02}, {1.5, 0.02}};
    estimator_params_t params = params_of(SMO_SIGMOID_VECTOR, LAG_EXACT, 0.0f);
    init(&params);
    const double rest = 1.0 - exp(-0.95 * T / 0.0125);
    for (unsigned n = 0; n < sizeof emfs / sizeof emfs[0]; n++) {
        double worst = 0.0;
        for (double turn = -0.2; turn < 0.201; turn += 0.05) {
            double angle = 1.0 + 7.0 * turn;
            double e[2] = {200.0 * emfs[n].share * cos(angle), 200.0 * emfs[n].share * sin(angle)};
            const ab_q_t emf = {(int32_t)lrint(e[0] / (double)fix.scale.units.voltage),
                                (int32_t)lrint(e[1] / (double)fix.scale.units.voltage)};
            ab_q_t found =
                lag_error_q(&fix.q.smo, (int32_t)lrint(turn / T / (double)fix.scale.units.speed), emf);
            double x[2] = {found.alpha * (double)fix.scale.units.current,
                           found.beta * (double)fix.scale.units.current};
            double length = hypot(x[0], x[1]);
            double g = 200.0 * tanh(0.5 * length) / length;
            /* W = b (R + j omega L)/(z - a) */
            double a = 1.0 - rest;
            double reactance = turn / T * 0.0125;
            double size = rest / 0.95 / (pow(cos(turn) - a, 2.0) + pow(sin(turn), 2.0));
            double w_re = size * (0.95 * (cos(turn) - a) + reactance * sin(turn));
            double w_im = size * (reactance * (cos(turn) - a) - 0.95 * sin(turn));
            double re = 0.95 + g * w_re;
            double im = reactance + g * w_im;
            double turned[2] = {re * x[0] - im * x[1], re * x[1] + im * x[0]};
            double cut = fmin(1.0, 0.99 / emfs[n].share);
            worst = fmax(worst, hypot(turned[0] - cut * e[0], turned[1] - cut * e[1]) / hypot(e[0], e[1]));
            check_below(fabs(circle(atan2(turned[1], turned[0]) - angle)), 3e-6 + emfs[n].off, "angle [rad]");
        }
        check_below(worst, 3e-6 + emfs[n].off, "EMF [-]");
    }
    const ab_q_t none = lag_error_q(&fix.q.smo, 0, (ab_q_t){0, 0});
    TEST_ASSERT_EQUAL_INT32(0, none.alpha);
    TEST_ASSERT_EQUAL_INT32(0, none.beta);
}

/* One turning EMF into both loops: in lock, with a ramp, from a wrong start and an empty filter. */
static void test_loops(void)
{
    static const double cutoffs[] = {0.0, 50.0};
    estimator_params_t params = params_of(SMO_SIGMOID_VECTOR, LAG_EXACT, 2000.0f);
    double angle = 0.0;
    double speed = 0.0;
    double transient = 0.0;
    for (int n = 0; n < 8; n++) {
        TEST_ASSERT_TRUE(pll_design(&params.pll, 200.0f, 1.0f, (float)cutoffs[n % 2], 1e-4f));
        double way = n / 2 % 2 ? -1.0 : 1.0;
        double ramp = n / 4 ? 600.0 : 0.0;
        init(&params);
        double theta = 0.3;
        position_t start = {(float)theta + 0.2f, (float)(way * 100.0)};
        pll_reset(&flt.tracker.pll, start);
        pll_reset_q(&fix.q.pll,
                    (position_q_t){(uint32_t)lrint((double)start.theta_e / PI * 2147483648.0),
                                   (int32_t)lrint((double)start.omega_e / (double)fix.scale.units.speed)});
        for (long k = 0; k < 10000; k++) {
            double omega = way * (100.0 + (k < 5000 ? ramp * T * (double)k : ramp * 0.5));
            double length = PSI * omega;
            ab_t e = {(float)(-length * sin(theta)), (float)(length * cos(theta))};
            ab_q_t e_q = {(int32_t)lrint(-length * sin(theta) / (double)fix.scale.units.voltage),
                          (int32_t)lrint(length * cos(theta) / (double)fix.scale.units.voltage)};
            position_t a = pll_step(&flt.tracker.pll, e, (float)(1.0 / PSI), 0.0f);
            position_q_t b = pll_step_q(&fix.q.pll, e_q, fix.q.tuning.speed_per_volt, 0);
            double between = circle((double)a.theta_e - (double)q_signed(b.theta_e) * PI / 2147483648.0);
            angle = fmax(angle, fabs(between));
            double faster = fabs((double)a.omega_e - (double)b.omega_e * (double)fix.scale.units.speed);
            double *largest = k < 2000 ? &transient : &speed;
            *largest = fmax(*largest, faster);
            theta = circle(theta + T * omega);
        }
    }
    check_below(angle, LOOP_APART, "angle [rad]");
    check_below(speed, LOOP_SPEED_APART, "speed [rad/s]");
    check_below(transient, LOOP_SPEED_APART, "speed on the way [rad/s]");
}

/* ---- all in a row ---- */

/* From 0.1 rad beside, over the transient, then settled. */
static void check_composed(smo_switching_t switching, lag_mode_t mode, float emf_cutoff)
{
    static const double rpm[] = {100.0, 500.0, 1000.0, 1500.0};
    estimator_params_t params = params_of(switching, mode, emf_cutoff);
    double transient = 0.0;
    double settled = 0.0;
    double speed = 0.0;
    for (int n = 0; n < 16; n++) {
        double way = n % 2 ? -1.0 : 1.0;
        estimator_oracle_case_t rig = rig_of(way * rpm[n / 2 % 4], n / 8 ? way * 4.55 : 0.0);
        init(&params);
        reset(&rig, 0, 0.1);
        for (long k = 1; k <= 8000; k++) {
            estimator_oracle_sample_t now;
            estimator_oracle_sample(&rig, k, &now);
            position_t a = estimator_step(&flt, as_float(now.voltage), as_float(now.current));
            position_t b = fixed_step(&fix, as_float(now.voltage), as_float(now.current));
            double between = 1e3 * fabs(circle((double)a.theta_e - (double)b.theta_e));
            if (k > 5000) {
                settled = fmax(settled, between);
                speed = fmax(speed, fabs((double)a.omega_e - (double)b.omega_e));
            } else {
                transient = fmax(transient, between);
            }
        }
        TEST_ASSERT_EQUAL_UINT16(estimator_invalid(&flt), fixed_invalid(&fix));
    }
    check_below(transient, TRANSIENT_APART, "angle on the way [mrad]");
    check_below(settled, MRAD_APART, "angle [mrad]");
    check_below(speed, SPEED_APART, "speed [rad/s]");
}

static void test_estimators_of_the_vector_form(void)
{
    for (int mode = LAG_NONE; mode <= LAG_EXACT; mode++) {
        check_composed(SMO_SIGMOID_VECTOR, (lag_mode_t)mode, 2000.0f);
    }
    check_composed(SMO_SIGMOID_VECTOR, LAG_EXACT, 0.0f);
}

static void test_estimators_per_axis(void)
{
    for (int mode = LAG_NONE; mode <= LAG_EXACT; mode++) {
        check_composed(SMO_SIGMOID, (lag_mode_t)mode, 0.0f);
    }
}

/* Chatter is chaotic: only the mean over whole turns can be compared, and that to its own scatter. */
static void test_estimators_of_the_sign(void)
{
    estimator_params_t params = params_of(SMO_SIGN, LAG_EXACT, 2000.0f);
    estimator_oracle_case_t rig = rig_of(1000.0, 4.0);
    init(&params);
    reset(&rig, 0, 0.0);
    double sums[2] = {0.0, 0.0};
    for (long k = 1; k <= 20000; k++) {
        estimator_oracle_sample_t now;
        estimator_oracle_sample(&rig, k, &now);
        position_t a = estimator_step(&flt, as_float(now.voltage), as_float(now.current));
        position_t b = fixed_step(&fix, as_float(now.voltage), as_float(now.current));
        if (k > 5000) {
            sums[0] += circle((double)a.theta_e - now.theta) / 15000.0;
            sums[1] += circle((double)b.theta_e - now.theta) / 15000.0;
        }
    }
    check_below(1e3 * fabs(sums[0] - sums[1]), 1.0, "mean [mrad]");
}

/* ---- the boundary ---- */

static void check_refused(estimator_params_t params, const char *field, bool above)
{
    params_error_t why;
    memset(&why, 0, sizeof why);
    TEST_ASSERT_TRUE_MESSAGE(estimator_params_check(&params, &why), why.rule);
    TEST_ASSERT_FALSE_MESSAGE(fixed_params_check(&params, &why), field);
    TEST_ASSERT_EQUAL_STRING(field, why.field);
    TEST_ASSERT_NOT_NULL(strstr(why.rule, "fixed point"));
    TEST_ASSERT_TRUE(above ? why.value > why.max : why.value < why.min);
}

static void test_constants_that_do_not_fit_are_refused_by_name(void)
{
    params_error_t why;
    estimator_params_t good = params_of(SMO_SIGMOID_VECTOR, LAG_EXACT, 2000.0f);
    TEST_ASSERT_TRUE(fixed_params_check(&good, &why));

    estimator_params_t params = good;
    params.smo.inductance = 0.9f;
    check_refused(params, "inductance", true);
    params = good;
    params.smo.inductance = 0.6f;
    params.smo.slope = 40.0f;
    check_refused(params, "slope", true);
    params = good;
    params.flux_linkage = 0.005f;
    check_refused(params, "flux_linkage", false);
    params = good;
    params.pll.amplitude_floor = 2e-3f;
    check_refused(params, "amplitude_floor", false);
    params = good;
    params.pll.amplitude_floor = 2e3f;
    check_refused(params, "amplitude_floor", true);
    params = good;
    params.smo.inductance = 1e-3f; /* I = 32 A */
    params.smo.slope = 0.1f;
    params.torque_feedforward = 9e6f;
    check_refused(params, "torque_feedforward", true);
    params = good;
    params.pll.kp = 1.5e4f;
    params.pll.ki = 8e7f;
    params.smo.emf_cutoff = 0.0f;
    check_refused(params, "ki", true);
    params = good;
    params.lag = LAG_CORRECTED;
    params.smo.emf_cutoff = 10.0f;
    check_refused(params, "emf_cutoff", false);
    params = good;
    params.smo.period = 2e-6f;
    params.pll.period = 2e-6f;
    check_refused(params, "period", false);
}

/* A limit that is just kept, and just not: the rule says which. */
static void test_the_limit_of_a_refusal_is_accepted(void)
{
    params_error_t why;
    estimator_params_t params = params_of(SMO_SIGMOID_VECTOR, LAG_EXACT, 2000.0f);
    params.flux_linkage = 0.005f;
    TEST_ASSERT_FALSE(fixed_params_check(&params, &why));
    params.flux_linkage = why.min;
    TEST_ASSERT_TRUE(fixed_params_check(&params, &why));
    fixed_init(&fix, &params);
    params.flux_linkage = nextafterf(params.flux_linkage, 0.0f);
    TEST_ASSERT_FALSE(fixed_params_check(&params, &why));
}

/* What no format holds coasts, and the next good sample is taken. */
static void test_samples_that_do_not_fit_are_none(void)
{
    static const float bad[] = {NAN, INFINITY, -INFINITY, 1e30f, -1100.0f, 1100.0f};
    estimator_params_t params = params_of(SMO_SIGMOID_VECTOR, LAG_EXACT, 2000.0f);
    estimator_oracle_case_t rig = rig_of(1000.0, 4.0);
    for (unsigned n = 0; n < sizeof bad / sizeof bad[0]; n++) {
        for (int place = 0; place < 4; place++) {
            estimator_oracle_sample_t now;
            init(&params);
            reset(&rig, 0, 0.0);
            for (long k = 1; k < 100; k++) {
                estimator_oracle_sample(&rig, k, &now);
                (void)fixed_step(&fix, as_float(now.voltage), as_float(now.current));
            }
            float v[4] = {0.0f, 50.0f, 1.0f, 0.0f};
            v[place] = bad[n];
            estimator_oracle_sample(&rig, 100, &now);
            position_t coasting = fixed_step(&fix, (ab_t){v[0], v[1]}, (ab_t){v[2], v[3]});
            TEST_ASSERT_TRUE((fixed_invalid(&fix) & ESTIMATOR_SAMPLE) != 0u);
            TEST_ASSERT_DOUBLE_WITHIN(1e-4, 0.0, circle((double)coasting.theta_e - now.theta));
            estimator_oracle_sample(&rig, 101, &now);
            (void)fixed_step(&fix, as_float(now.voltage), as_float(now.current));
            TEST_ASSERT_EQUAL_UINT16(0, fixed_invalid(&fix));
        }
    }
}

/* 4 U = 1024 V and 16 I = 32 A are still measurements. */
static void test_range_of_the_samples(void)
{
    estimator_params_t params = params_of(SMO_SIGMOID_VECTOR, LAG_EXACT, 2000.0f);
    init(&params);
    (void)fixed_step(&fix, (ab_t){1.0f, 0.0f}, (ab_t){1.0f, 0.0f});
    (void)fixed_step(&fix, (ab_t){1024.0f, -1024.0f}, (ab_t){-32.0f, 32.0f});
    TEST_ASSERT_EQUAL_UINT16(0, fixed_invalid(&fix) & ESTIMATOR_SAMPLE);
    (void)fixed_step(&fix, (ab_t){1024.1f, 0.0f}, (ab_t){0.0f, 0.0f});
    TEST_ASSERT_EQUAL_UINT16(ESTIMATOR_SAMPLE, fixed_invalid(&fix) & ESTIMATOR_SAMPLE);
    (void)fixed_step(&fix, (ab_t){0.0f, 0.0f}, (ab_t){0.0f, 32.01f});
    TEST_ASSERT_EQUAL_UINT16(ESTIMATOR_SAMPLE, fixed_invalid(&fix) & ESTIMATOR_SAMPLE);
}

/* k_s 300 V needs U = 512 V and I = 4 A: the state is carried over, and back, and goes on as float's does. */
static void test_take_in_other_bases_keeps_the_estimate(void)
{
    estimator_params_t params = params_of(SMO_SIGMOID_VECTOR, LAG_EXACT, 2000.0f);
    estimator_params_t other = params;
    other.smo.gain = 300.0f;
    other.smo.slope = 0.6f;
    estimator_oracle_case_t rig = rig_of(1000.0, 4.0);
    double apart = 0.0;
    estimator_oracle_sample_t now;
    init(&params);
    reset(&rig, 0, 0.0);
    for (long k = 1; k <= 6000; k++) {
        if (k % 1000 == 0) {
            const float before = fix.scale.units.voltage;
            estimator_tuning_t tuning;
            fixed_tuning_t fixed_tuning;
            estimator_prepare(&tuning, k % 2000 ? &other : &params);
            estimator_take(&flt, &tuning);
            fixed_prepare(&fixed_tuning, k % 2000 ? &other : &params);
            fixed_take(&fix, &fixed_tuning);
            TEST_ASSERT_TRUE(before != fix.scale.units.voltage);
        }
        estimator_oracle_sample(&rig, k, &now);
        position_t a = estimator_step(&flt, as_float(now.voltage), as_float(now.current));
        position_t b = fixed_step(&fix, as_float(now.voltage), as_float(now.current));
        apart = fmax(apart, 1e3 * fabs(circle((double)a.theta_e - (double)b.theta_e)));
    }
    check_below(apart, TRANSIENT_APART, "angle [mrad]");
}

/* The largest count of each criterion, on the count: at the limit it still holds, one count beyond it does
 * not. */
static void test_at_its_limit_a_criterion_still_holds(void)
{
    estimator_params_t params = params_of(SMO_SIGMOID_VECTOR, LAG_EXACT, 2000.0f);
    params.validity.amplitude_max = 1.5f;
    estimator_oracle_case_t rig = rig_of(1000.0, 4.0);
    estimator_oracle_sample_t now;
    init(&params);
    reset(&rig, 0, 0.05);
    for (long k = 1; k < 60; k++) {
        estimator_oracle_sample(&rig, k, &now);
        (void)fixed_step(&fix, as_float(now.voltage), as_float(now.current));
    }
    const estimator_q_t before = fix.q;
    estimator_oracle_sample(&rig, 60, &now);
    (void)fixed_step(&fix, as_float(now.voltage), as_float(now.current));
    const estimator_q_t judged = fix.q;
    const int32_t speed = q_magnitude(judged.pll.omega_smooth);
    const int32_t detector = q_magnitude(judged.pll.detector);
    TEST_ASSERT_TRUE(speed > 1000 && detector > 1000);
    for (int32_t beyond = 0; beyond < 2; beyond++) {
        const uint32_t expected = beyond ? ESTIMATOR_SPEED : 0u;
        fix.q = before;
        fix.q.tuning.speed_min = speed + beyond;
        (void)fixed_step(&fix, as_float(now.voltage), as_float(now.current));
        TEST_ASSERT_EQUAL_UINT16(expected, fixed_invalid(&fix));
        fix.q = before;
        fix.q.tuning.speed_max = speed - beyond;
        (void)fixed_step(&fix, as_float(now.voltage), as_float(now.current));
        TEST_ASSERT_EQUAL_UINT16(expected, fixed_invalid(&fix));
        fix.q = before;
        fix.q.tuning.detector_max = detector - beyond;
        (void)fixed_step(&fix, as_float(now.voltage), as_float(now.current));
        TEST_ASSERT_EQUAL_UINT16(beyond ? ESTIMATOR_DETECTOR : 0u, fixed_invalid(&fix));
    }
}

/* psi_f comes from outside, as of the adaptation: what it gives is the speed of the same EMF. */
static void test_flux_is_set_from_outside(void)
{
    estimator_params_t params = params_of(SMO_SIGMOID_VECTOR, LAG_EXACT, 2000.0f);
    estimator_oracle_case_t rig = rig_of(1000.0, 4.0);
    params.flux_linkage = 0.2f;
    init(&params);
    const float psi = (float)PSI;
    estimator_set_flux(&flt, psi, 1.0f / psi);
    fixed_set_flux(&fix, psi, 1.0f / psi);
    reset(&rig, 0, 0.0);
    for (long k = 1; k <= 100; k++) {
        estimator_oracle_sample_t now;
        estimator_oracle_sample(&rig, k, &now);
        const position_t a = estimator_step(&flt, as_float(now.voltage), as_float(now.current));
        const position_t b = fixed_step(&fix, as_float(now.voltage), as_float(now.current));
        TEST_ASSERT_DOUBLE_WITHIN(0.2, now.omega, (double)a.omega_e);
        TEST_ASSERT_DOUBLE_WITHIN(0.2, now.omega, (double)b.omega_e);
    }
}
