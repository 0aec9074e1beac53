/* The estimator stays finite with any input, and it obeys identities such as mirror images. */
#include "tests/unit/estimator_bench.h"

/* ---- always finite ---- */

static void check_finite(position_t position)
{
    TEST_ASSERT_TRUE(isfinite(position.theta_e) && isfinite(position.omega_e));
    TEST_ASSERT_TRUE(position.theta_e >= -3.1415927f && position.theta_e < 3.1415927f);
    TEST_ASSERT_TRUE(isfinite(est.tracker.pll.theta_e) && isfinite(est.tracker.pll.integral) &&
                     isfinite(est.tracker.pll.feedforward) && isfinite(est.tracker.pll.omega_smooth));
    TEST_ASSERT_TRUE(isfinite(est.observer.smo.current_hat.alpha) &&
                     isfinite(est.observer.smo.current_hat.beta) &&
                     isfinite(est.observer.smo.emf_hat.alpha) && isfinite(est.observer.smo.emf_hat.beta));
    TEST_ASSERT_TRUE(isfinite(smo_equivalent_gain(&est.observer.smo)) && isfinite(flux.flux_linkage) &&
                     isfinite(est.tracker.motor.speed_per_volt) && isfinite(est.estimate.emf.alpha) &&
                     isfinite(est.estimate.emf.beta));
    const float limit = PLL_TURN_LIMIT / (float)T; /* [rad/s] */
    TEST_ASSERT_TRUE(fabsf(est.tracker.pll.feedforward) <= limit &&
                     fabsf(est.tracker.pll.integral) <= 2.0f * limit);
}

/* Inputs without an EMF: a current without a voltage, a voltage that only drives the current (no error, no
 * EMF), and all zero. */
static void test_zero_inputs_stay_finite_and_are_not_valid(void)
{
    for (int n = 0; n < 48 * 3; n += SWEEP_FEW) {
        estimator_params_t params = any_params(n / 3);
        estimator_oracle_case_t rig = rig_of(0, n % 2 ? -400.0 : 400.0, 2.0);
        run_near(&params, &rig, 0.0, 50);
        ab_t current = {n % 3 == 0 ? 0.0f : 2.0f, n % 3 == 0 ? 0.0f : -1.0f};
        ab_t voltage = {0.0f, 0.0f};
        if (n % 3 == 2) {
            voltage = (ab_t){0.95f * current.alpha, 0.95f * current.beta};
        }
        for (int k = 0; k < 5000; k++) {
            check_finite(stepped(voltage, current));
        }
        TEST_ASSERT_TRUE(
            (estimator_invalid(&est) & (ESTIMATOR_AMPLITUDE | ESTIMATOR_SPEED | ESTIMATOR_DETECTOR)) != 0u);
    }
}

/* Each input in turn is not a number for 20 periods. The bit is set at once, the angle continues with
 * omega T, and the loop locks again when the samples return. The observer has missed the change of the
 * current during this time, so that v is at its limit for at most a dozen samples (2 i_q divided by b k_s
 * = 1.6 A for each sample). This is a smaller disturbance than a wrong angle, and it decays as fast. */
static void test_bad_samples_coast_and_recover(void)
{
    static const float bad[] = {NAN, INFINITY, -INFINITY, 1e30f, -1e30f};
    for (int n = 0; n < 40; n += SWEEP_FEW) {
        const double way = n / 20 ? -1.0 : 1.0;
        estimator_params_t params = params_of(0);
        double omega = way * 800.0 * RAD_PER_RPM;
        estimator_oracle_case_t rig = rig_of(0, omega, way * RATED);
        run_near(&params, &rig, 0.0, 3000);
        double before = (double)est.tracker.pll.theta_e - omega * T;
        TEST_ASSERT_EQUAL_UINT16(0, estimator_invalid(&est));
        for (long k = 3001; k <= 3020; k++) {
            const estimator_oracle_sample_t now = sample_of(&rig, k);
            ab_t voltage = as_float(now.voltage);
            ab_t current = as_float(now.current);
            float *slots[] = {&voltage.alpha, &voltage.beta, &current.alpha, &current.beta};
            *slots[n / 5 % 4] = bad[n % 5];
            position_t position = stepped(voltage, current);
            check_finite(position);
            TEST_ASSERT_EQUAL_UINT16(ESTIMATOR_SAMPLE, estimator_invalid(&est));
            double moved = circle((double)position.theta_e - before);
            TEST_ASSERT_DOUBLE_WITHIN(1e-5, 0.0, circle(moved - omega * T));
            TEST_ASSERT_DOUBLE_WITHIN(0.1, omega, (double)position.omega_e);
            before = (double)position.theta_e;
        }
        long last = 3020;
        for (long k = 3021; k < 8000; k++) {
            position_t position = step(&rig, k);
            check_finite(position);
            TEST_ASSERT_EQUAL_UINT16(0, estimator_invalid(&est));
            if (fabs(error_of(&rig, k, position)) > 20.0) {
                last = k;
            }
        }
        check_below(0.1 * (double)(last - 3020), 125.0, "recovery");
        check_below(fabs(error_of(&rig, 8000, step(&rig, 8000))), FLOAT_PEAK, "in the end");
    }
}

static void test_bad_sample_changes_nothing_but_the_angle(void)
{
    for (int n = 0; n < 48; n++) {
        estimator_params_t params = any_params(n);
        estimator_oracle_case_t rig = rig_of(0, 400.0, 2.0);
        run_near(&params, &rig, 0.0, 300);
        estimator_t before = est;
        const float flux_before = flux.flux_linkage;
        (void)stepped((ab_t){NAN, 0.0f}, (ab_t){1.0f, 1.0f});
        TEST_ASSERT_EQUAL_UINT32(1u, est.estimate.coasted);
        TEST_ASSERT_EQUAL_MEMORY(&before.tracker.validity.debounce, &est.tracker.validity.debounce,
                                 sizeof est.tracker.validity.debounce);
        TEST_ASSERT_TRUE(flux.flux_linkage == flux_before);
        TEST_ASSERT_TRUE(est.tracker.pll.integral == before.tracker.pll.integral);
        TEST_ASSERT_TRUE(est.tracker.pll.feedforward == before.tracker.pll.feedforward);
        TEST_ASSERT_EQUAL_MEMORY(&before.observer.smo.current_hat, &est.observer.smo.current_hat,
                                 sizeof est.observer.smo.current_hat);
        TEST_ASSERT_EQUAL_UINT16(before.estimate.invalid | ESTIMATOR_SAMPLE, estimator_invalid(&est));
    }
}

/* No valid sample from the first step on, and samples with the largest values that count as valid. */
static void test_endless_invalid_input_stays_finite(void)
{
    static const float values[] = {0.0f, 1e5f, -1e5f, 9e5f, 1e30f, 3.4e38f, NAN, INFINITY, 1e-30f, -1e-38f};
    for (int n = 0; n < 48; n += SWEEP_FEW) {
        estimator_params_t params = any_params(n);
        init(&params);
        uint32_t seed = UINT32_C(1) + (uint32_t)n;
        for (int k = 0; k < 2000; k++) {
            float v[4];
            for (int m = 0; m < 4; m++) {
                seed = seed * UINT32_C(1664525) + UINT32_C(1013904223);
                v[m] = values[(seed >> 16) % 10u];
            }
            check_finite(stepped((ab_t){v[0], v[1]}, (ab_t){v[2], v[3]}));
            check_finite(estimator_coast(&est, (ab_t){v[3], v[1]}, (ab_t){v[2], v[0]}));
        }
    }
}

/* ---- identities ---- */

static void check_mirror(int n)
{
    static estimator_t mirrored;
    estimator_params_t params = any_params(n);
    estimator_oracle_case_t rig = rig_of(0, 300.0, 2.0);
    rig.swing = 350.0; /* passes zero speed */
    rig.swing_rate = 20.0;
    rig.current_d = 1.0;
    memset(&est, 0, sizeof est);
    memset(&mirrored, 0, sizeof mirrored);
    init(&params);
    estimator_init(&mirrored, &params);
    reset_near(&rig, 0, 0.2, 10.0);
    position_t start = {(float)circle(0.5), 310.0f};
    estimator_oracle_sample_t now = sample_of(&rig, 0);
    ab_t current = as_float(now.current);
    estimator_reset(&est, start, current);
    estimator_reset(&mirrored, (position_t){-start.theta_e, -start.omega_e},
                    (ab_t){current.alpha, -current.beta});
    for (long k = 1; k < 4000; k++) {
        now = sample_of(&rig, k);
        ab_t u = as_float(now.voltage);
        current = as_float(now.current);
        ab_t u_mirrored = {u.alpha, -u.beta};
        ab_t current_mirrored = {current.alpha, -current.beta};
        bool coast = k % 100 == 99;
        position_t p = coast ? estimator_coast(&est, u, current) : estimator_step(&est, u, current);
        position_t q = coast ? estimator_coast(&mirrored, u_mirrored, current_mirrored)
                             : estimator_step(&mirrored, u_mirrored, current_mirrored);
        TEST_ASSERT_TRUE(p.theta_e == -q.theta_e && p.omega_e == -q.omega_e);
        TEST_ASSERT_TRUE(est.observer.smo.axes.gain_axis.alpha == mirrored.observer.smo.axes.gain_axis.alpha);
        TEST_ASSERT_TRUE(est.observer.smo.axes.gain_axis.beta == mirrored.observer.smo.axes.gain_axis.beta);
        TEST_ASSERT_EQUAL_UINT16(estimator_invalid(&est), estimator_invalid(&mirrored));
    }
}

static void test_backward_is_the_mirror_of_forward_bit_for_bit(void)
{
    for (int n = 0; n < 48; n++) {
        check_mirror(n);
    }
}
