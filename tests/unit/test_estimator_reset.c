/* Resets and coasting of the estimator. */
#include "tests/unit/estimator_bench.h"

/* ---- reset ---- */

/* The largest difference [mrad] over 0.05 s between two estimators: one has run for long, the other was
 * reset to the true state at t_k and makes its first step at t_k+1. */
static double bump(const estimator_params_t *params, const estimator_oracle_case_t *rig, long k)
{
    static double settled_error[600];
    init(params);
    reset_near(rig, k - 4000, 0.0, 0.0);
    (void)deviation(rig, k - 3999, 4000, 0);
    for (long n = 1; n < 500; n++) {
        settled_error[n] = error_of(rig, k + n, step(rig, k + n));
    }
    init(params);
    reset_near(rig, k, 0.0, 0.0);
    double largest = 0.0;
    for (long n = 1; n < 500; n++) {
        double error = error_of(rig, k + n, step(rig, k + n));
        largest = fmax(largest, fabs(error - settled_error[n]));
    }
    return largest;
}

/* The k_f of the sigmoid starts from one sample instead of a mean over turns. */
static void test_reset_goes_on_without_a_bump_and_the_sigmoid_with_little(void)
{
    static const double rpm[] = {-1500.0, -800.0, -300.0, -100.0, 100.0, 300.0, 1000.0, 1500.0};
    for (int m = 0; m < 4 * (LAG_EXACT + 1); m++) {
        const bool vector = m % 2 != 0;
        for (int n = 0; n < 16; n += SWEEP_FEW) {
            estimator_params_t params = paper_params((lag_mode_t)(m / 4));
            params.smo.switching = vector ? SMO_SIGMOID_VECTOR : SMO_SIGMOID;
            params.smo.emf_cutoff = m / 2 % 2 ? 2000.0f : 0.0f;
            estimator_oracle_case_t rig = rig_of(0, rpm[n / 2] * RAD_PER_RPM, n % 2 ? RATED : 0.0);
            check_below(bump(&params, &rig, 4000 + 37 * n), vector ? 0.1 : 5.0, "after the reset");
        }
    }
}

/* The estimate is the start value until the step of t_k+1, which continues it by omega T. */
static void test_reset_gives_the_start_and_goes_on(void)
{
    for (int n = 0; n < 64; n++) {
        double way = n % 2 ? -1.0 : 1.0;
        estimator_params_t params = params_of(0);
        estimator_oracle_case_t rig = rig_of(0, way * (50.0 + 9.0 * n), n / 2 % 2 ? 3.0 : 0.0);
        init(&params);
        reset_near(&rig, 77 * n, 0.0, 0.0);
        TEST_ASSERT_DOUBLE_WITHIN(
            2e-3, 0.0,
            error_of(&rig, 77 * n, (position_t){est.estimate.frame.theta_e, est.estimate.frame.omega_e}));
        TEST_ASSERT_DOUBLE_WITHIN(
            2e-6, 0.0,
            circle(atan2((double)est.estimate.frame.rotation.sin, (double)est.estimate.frame.rotation.cos) -
                   (double)est.estimate.frame.theta_e));
        TEST_ASSERT_EQUAL_FLOAT((float)rig.omega_start, est.estimate.frame.omega_e);
        TEST_ASSERT_DOUBLE_WITHIN(0.1, 0.0, error_of(&rig, 77 * n + 1, step(&rig, 77 * n + 1)));
        TEST_ASSERT_DOUBLE_WITHIN(0.1, 0.0, error_of(&rig, 77 * n + 2, step(&rig, 77 * n + 2)));
    }
}

static void test_reset_of_the_other_machines_goes_on_without_a_bump(void)
{
    for (int machine = 1; machine < MACHINE_COUNT; machine++) {
        for (int n = 0; n < 8; n += SWEEP_FEW) {
            double omega = (n % 2 ? -1.0 : 1.0) * (n / 2 % 2 ? 0.2 : 0.95) * MACHINES[machine].omega_max;
            estimator_params_t params = params_of(machine);
            estimator_oracle_case_t rig = rig_of(machine, omega, n / 4 ? RATED : 0.0);
            check_below(bump(&params, &rig, 4000 + 31 * n), 1.0, "after the reset");
        }
    }
}

/* In the modes that leave the filter in the observer, a reset includes the effect of the filter on a fast
 * EMF, as estimator.h states. */
static void test_reset_at_high_speed_makes_the_filters_lag(void)
{
    static const lag_mode_t modes[] = {LAG_NONE, LAG_PRINTED, LAG_CORRECTED};
    for (int n = 0; n < 24; n += SWEEP_FEW) {
        const double way = n / 12 ? -1.0 : 1.0;
        int machine = n % 2 ? EXTREME : 1;
        estimator_params_t params = params_of(machine);
        params.lag = modes[n / 4 % 3];
        params.smo.emf_cutoff = n / 2 % 2 ? 600.0f : 2000.0f;
        estimator_oracle_case_t rig = rig_of(machine, 0.98 * way * MACHINES[machine].omega_max, way * 2.0);
        double largest = bump(&params, &rig, 4000 + 17 * n);
        check_below(largest, 0.1, "after the reset");
    }
}

/* ---- coasting ---- */

static void test_coast_keeps_the_error_and_the_observer_going(void)
{
    for (int n = 0; n < 8; n++) {
        double way = n % 2 ? -1.0 : 1.0;
        estimator_params_t params = params_of(0);
        tune(&params, 200.0, n / 2 % 2 ? 50.0 : 0.0);
        params.validity =
            (validity_params_t){0.98f, 1.02f, 0.0f, 0.01f, 0.0f, 3.0f, 0.0f, 20.0f, 900.0f, 0.0f};
        params.validity.speed_max = n / 4 ? 900.0f : 0.0f;
        estimator_oracle_case_t rig = rig_of(0, way * (n / 4 ? 620.0 : 100.0), way * RATED);
        (void)settled(&params, &rig);
        double before = error_of(&rig, 11001, step(&rig, 11001));
        for (long k = 11002; k < 11022; k++) {
            const estimator_oracle_sample_t now = sample_of(&rig, k);
            position_t position = estimator_coast(&est, as_float(now.voltage), as_float(now.current));
            TEST_ASSERT_DOUBLE_WITHIN(0.1, before, error_of(&rig, k, position));
            TEST_ASSERT_DOUBLE_WITHIN(0.1, rig.omega_start, (double)position.omega_e);
        }
        for (long k = 11022; k < 11222; k++) {
            TEST_ASSERT_DOUBLE_WITHIN(FLOAT_PEAK, before, error_of(&rig, k, step(&rig, k)));
            TEST_ASSERT_EQUAL_UINT16(0, estimator_invalid(&est));
        }
    }
}
