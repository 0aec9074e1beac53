/* The observer alone, at a given speed, and the loop locked to the observed EMF. */
#include "tests/unit/estimator_bench.h"

static void observe(const estimator_oracle_case_t *rig, long k, double omega)
{
    const estimator_oracle_sample_t now = sample_of(rig, k);
    estimator_observe(&est, as_float(now.voltage), as_float(now.current), (float)omega);
}

/* The error [mrad] of the d axis that follows from the EMF and the direction of rotation. */
static double emf_error(const estimator_oracle_case_t *rig, long k)
{
    const estimator_oracle_sample_t now = sample_of(rig, k);
    const double way = now.omega < 0.0 ? -1.0 : 1.0;
    const ab_t emf = est.estimate.emf;
    return 1e3 * circle(atan2(-way * (double)emf.alpha, way * (double)emf.beta) - now.theta);
}

static const double RPM[] = {-1500.0, -600.0, -100.0, -30.0, 30.0, 100.0, 600.0, 1500.0};

/* The observer starts without a state, at angle zero and speed zero, and has settled within 10 ms. Limit
 * for the EMF of a sample: float arithmetic leaves L/T 5e-7 A = 6e-5 V (estimator_bench.h), the series of
 * the lag 1e-5 of the EMF. */
static void test_emf_of_a_turning_rotor_is_seen_without_the_loop(void)
{
    for (int n = 0; n < 16; n++) {
        const estimator_params_t params = params_of(0);
        const double omega = RPM[n / 2] * RAD_PER_RPM;
        const estimator_oracle_case_t rig = rig_of(0, omega, n % 2 ? RATED : 0.0);
        init(&params);
        for (long k = 1; k < 400; k++) {
            observe(&rig, k, omega);
            if (k > 100) {
                const double allowed = 0.05 + 1e3 * 2e-4 / (PSI * fabs(omega));
                TEST_ASSERT_DOUBLE_WITHIN(allowed, 0.0, emf_error(&rig, k));
                TEST_ASSERT_DOUBLE_WITHIN(1e-4 * fabs(omega) * PSI + 2e-3, fabs(omega) * PSI,
                                          (double)est.estimate.amplitude);
            }
        }
    }
}

/* The lag of the observer is about one sample: a speed that is wrong by 100 rad/s makes an error below 100
 * rad/s 2 T = 20 mrad, but not zero. */
static void test_a_given_speed_compensates_the_lag(void)
{
    const estimator_params_t params = params_of(0);
    const estimator_oracle_case_t rig = rig_of(0, 400.0, RATED);
    init(&params);
    for (long k = 1; k < 300; k++) {
        observe(&rig, k, 300.0);
    }
    TEST_ASSERT_TRUE(fabs(emf_error(&rig, 299)) > 2.0 && fabs(emf_error(&rig, 299)) < 20.0);
    observe(&rig, 300, 400.0);
    TEST_ASSERT_DOUBLE_WITHIN(0.1, 0.0, emf_error(&rig, 300));
}

static void test_frame_and_speed_stay_during_this_time(void)
{
    const estimator_params_t params = params_of(0);
    const estimator_oracle_case_t rig = rig_of(0, 400.0, 2.0);
    (void)settled(&params, &rig);
    const estimate_t before = est.estimate;
    const float theta_e = est.tracker.pll.theta_e;
    for (long k = 11001; k < 11500; k++) {
        observe(&rig, k, 400.0);
        const estimate_t *now = &est.estimate;
        TEST_ASSERT_TRUE(now->frame.theta_e == before.frame.theta_e &&
                         now->frame.omega_e == before.frame.omega_e &&
                         now->omega_smooth == before.omega_smooth);
        TEST_ASSERT_EQUAL_FLOAT(0.0f, now->detector);
        TEST_ASSERT_EQUAL_UINT32(1u, now->coasted);
        TEST_ASSERT_EQUAL_UINT16(0, estimator_invalid(&est));
        TEST_ASSERT_DOUBLE_WITHIN(0.1, 0.0, emf_error(&rig, k));
    }
    TEST_ASSERT_TRUE(est.tracker.pll.theta_e == theta_e);
}

static void test_sample_that_is_no_number_changes_nothing(void)
{
    const estimator_params_t params = params_of(0);
    const estimator_oracle_case_t rig = rig_of(0, 400.0, 2.0);
    init(&params);
    for (long k = 1; k < 200; k++) {
        observe(&rig, k, 400.0);
    }
    const estimate_t before = est.estimate;
    static const float bad[] = {NAN, INFINITY, -INFINITY};
    for (int n = 0; n < 3; n++) {
        estimator_observe(&est, (ab_t){bad[n], 0.0f}, (ab_t){0.0f, 0.0f}, 400.0f);
        TEST_ASSERT_TRUE(est.estimate.emf.alpha == before.emf.alpha &&
                         est.estimate.emf.beta == before.emf.beta &&
                         est.estimate.amplitude == before.amplitude);
        estimator_observe(&est, (ab_t){0.0f, 0.0f}, (ab_t){0.0f, bad[n]}, 400.0f);
        TEST_ASSERT_TRUE(est.estimate.amplitude == before.amplitude && est.estimate.coasted == 1u);
    }
}

/* A loop that is locked at the angle of the EMF continues like a loop that has been locked for long. The
 * difference is below 0.1 mrad up to the turn limit, by the header; at 100 r/min the EMF of a sample adds
 * 0.1 mrad. */
static void test_lock_on_the_observed_emf_goes_on_without_a_bump(void)
{
    for (int n = 0; n < 16; n++) {
        const double omega = RPM[n / 2] * RAD_PER_RPM;
        if (fabs(RPM[n / 2]) < 50.0) {
            continue;
        }
        const estimator_params_t params = params_of(0);
        const estimator_oracle_case_t rig = rig_of(0, omega, n % 2 ? RATED : 0.0);
        init(&params);
        for (long k = 1; k <= 200; k++) {
            observe(&rig, k, omega);
        }
        const estimator_oracle_sample_t now = sample_of(&rig, 200);
        const position_t rotor = {(float)circle(now.theta), (float)omega};
        const ab_t emf = est.estimate.emf;
        const ab_t error = est.observer.smo.current_err;
        estimator_lock(&est, rotor, est.estimate.amplitude);
        /* The estimate is the initial one, and the observer continues. */
        TEST_ASSERT_DOUBLE_WITHIN(1e-6, 0.0, circle((double)est.estimate.frame.theta_e - now.theta));
        TEST_ASSERT_DOUBLE_WITHIN(2.5e-6, sin(now.theta), (double)est.estimate.frame.rotation.sin);
        TEST_ASSERT_DOUBLE_WITHIN(2.5e-6, cos(now.theta), (double)est.estimate.frame.rotation.cos);
        TEST_ASSERT_DOUBLE_WITHIN(1e-6 * fabs(omega), omega, (double)est.estimate.frame.omega_e);
        TEST_ASSERT_DOUBLE_WITHIN(1e-6 * fabs(omega), omega, (double)est.estimate.omega_smooth);
        TEST_ASSERT_TRUE(est.estimate.emf.alpha == emf.alpha && est.estimate.emf.beta == emf.beta);
        TEST_ASSERT_TRUE(est.observer.smo.current_err.alpha == error.alpha);
        for (long k = 201; k < 1000; k++) {
            const double late = error_of(&rig, k, step(&rig, k));
            TEST_ASSERT_DOUBLE_WITHIN(0.2, 0.0, late);
            TEST_ASSERT_DOUBLE_WITHIN(0.05 + 1e-4 * fabs(omega), omega, (double)est.estimate.omega_smooth);
            TEST_ASSERT_EQUAL_UINT32(0u, est.estimate.coasted);
            TEST_ASSERT_EQUAL_UINT16(0, estimator_invalid(&est));
        }
    }
}

static void test_lock_begins_validity_again(void)
{
    estimator_params_t params = params_of(0);
    params.validity =
        (validity_params_t){0.5f, 1.5f, 0.001f, 0.6f, 0.001f, 3.0f, 0.001f, 20.0f, 900.0f, 0.001f};
    const estimator_oracle_case_t rig = rig_of(0, 400.0, 2.0);
    init(&params);
    for (long k = 1; k < 100; k++) { /* at standstill the speed is too low for a lock */
        (void)estimator_step(&est, (ab_t){0.0f, 0.0f}, (ab_t){0.0f, 0.0f});
    }
    TEST_ASSERT_TRUE((estimator_invalid(&est) & ESTIMATOR_SPEED) != 0u);
    for (long k = 1; k < 200; k++) {
        observe(&rig, k, 400.0);
    }
    const estimator_oracle_sample_t now = sample_of(&rig, 199);
    estimator_lock(&est, (position_t){(float)circle(now.theta), 400.0f}, est.estimate.amplitude);
    TEST_ASSERT_EQUAL_UINT16(0, estimator_invalid(&est));
    for (long k = 200; k < 400; k++) {
        (void)step(&rig, k);
        TEST_ASSERT_EQUAL_UINT16(0, estimator_invalid(&est));
    }
}
