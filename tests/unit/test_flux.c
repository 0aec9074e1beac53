/* Adaptation of the flux linkage, which runs with the estimator. */
#include "tests/unit/estimator_bench.h"

/* With a settled loop 1/psi_hat approaches 1/psi like exp(-rate t). A change of psi_hat acts on the loop
 * like an acceleration of rate times the error of F. An acceleration lowers the smooth speed by kp/ki of
 * itself, so that rate = share/(1 - share kp/ki). The first 0.3 s are left out, in which the means follow
 * a wrong start of |e|. The change per step is 10 to 25 last digits of 1/psi_hat, so that the limit is a
 * hundredth. */
static void test_flux_adapts_at_its_share(void)
{
    for (int n = 0; n < 4; n++) {
        double wrong = n % 2 ? 1.02 : 0.98;
        estimator_params_t params = params_of(0);
        params.flux_linkage = (float)(wrong * PSI);
        params.flux_adaptation = 2.0f;
        estimator_oracle_case_t rig = rig_of(0, n / 2 ? -500.0 : 500.0, 2.0);
        run_near(&params, &rig, 0.0, 3000);
        double before = 1.0 / (double)flux.flux_linkage - 1.0 / PSI;
        (void)deviation(&rig, 3001, 5000, 0);
        double after = 1.0 / (double)flux.flux_linkage - 1.0 / PSI;
        double rate = 2.0 / (1.0 - 2.0 * (double)params.pll.kp / (double)params.pll.ki);
        TEST_ASSERT_DOUBLE_WITHIN(0.01, exp(-0.5 * rate), after / before);
    }
}

/* The flux is not adapted below 60 rad/s, while the detector shows more than 0.05, or when the adaptation
 * is off; it is limited to half of the parameter. */
static void test_flux_rests_where_it_cannot_be_seen(void)
{
    static const struct {
        double omega, share, wrong, lowest, highest; /* the last two are the range of psi_hat/psi after 2 s */
    } cases[] = {{59.0, 2.0, 1.1, 1.1, 1.1},
                 {61.0, 2.0, 1.1, 0.99, 1.01},
                 {500.0, 0.0, 1.1, 1.1, 1.1},
                 {500.0, 5.0, 2.5, 1.25, 1.27},
                 {500.0, 5.0, 0.6, 0.88, 0.9}};
    for (int n = 0; n < 10; n += SWEEP_FEW) {
        double way = n % 2 ? -1.0 : 1.0;
        estimator_params_t params = params_of(0);
        params.flux_linkage = (float)(cases[n / 2].wrong * PSI);
        params.flux_adaptation = (float)cases[n / 2].share;
        estimator_oracle_case_t rig = rig_of(0, way * cases[n / 2].omega, 0.0);
        run_near(&params, &rig, 0.0, 25000);
        double ratio = (double)flux.flux_linkage / PSI;
        check_below(ratio, cases[n / 2].highest * 1.000001, "flux, highest");
        check_below(cases[n / 2].lowest * 0.999999, ratio, "flux, lowest");
    }
}

/* The flux of the machine differs from the parameter: psi_hat changes by up to half of the parameter in
 * both directions and not further, and it returns with the flux. */
static void test_flux_stops_at_half_of_the_parameter_either_way_and_comes_back(void)
{
    for (int n = 0; n < 4; n++) {
        const double end = n % 2 ? 1.5 * PSI : 0.5 * PSI;
        estimator_params_t params = params_of(0);
        params.flux_adaptation = 5.0f;
        estimator_oracle_case_t rig = rig_of(0, n / 2 ? -300.0 : 300.0, 0.0);
        rig.flux_linkage = n % 2 ? 2.0 * PSI : 0.4 * PSI;
        run_near(&params, &rig, 0.0, 30000);
        TEST_ASSERT_DOUBLE_WITHIN(2e-3 * end, end, (double)flux.flux_linkage);
        TEST_ASSERT_TRUE(fabs((double)flux.flux_linkage / PSI - 1.0) < 0.5 + 1e-6);
        rig.flux_linkage = PSI;
        (void)deviation(&rig, 30001, 30000, 0);
        TEST_ASSERT_DOUBLE_WITHIN(5e-3 * PSI, PSI, (double)flux.flux_linkage);
    }
}

static void test_flux_rests_while_the_detector_is_off(void)
{
    static const double ratios[] = {0.045, 0.055}; /* ratios of a/ki */
    for (int n = 0; n < 4; n++) {
        double way = n % 2 ? -1.0 : 1.0;
        estimator_params_t params = params_of(0);
        tune(&params, 200.0, 0.0);
        params.flux_linkage = (float)(1.1 * PSI);
        params.flux_adaptation = 5.0f;
        estimator_oracle_case_t rig = ramp_rig(way * 100.0, way * ratios[n / 2] * (double)params.pll.ki);
        (void)ramp(&params, &rig);
        double before = (double)flux.flux_linkage;
        (void)deviation(&rig, RAMP_START + RAMP_STEPS - 1000, 0, 1000);
        run_near(&params, &rig, 0.0, RAMP_START + 3000);
        double early = (double)flux.flux_linkage;
        (void)deviation(&rig, RAMP_START + 3001, 5000, 0);
        double late = (double)flux.flux_linkage;
        TEST_ASSERT_EQUAL_INT(n / 2, early == late);
        TEST_ASSERT_TRUE(before > 0.0);
    }
}

/* An adapted flux is kept when the tuning changes, unless its own parameter changes or the adaptation is
 * off. */
static void test_retune_keeps_an_adapted_flux_while_it_is_meant(void)
{
    estimator_params_t params = params_of(0);
    params.flux_linkage = 0.2f;
    params.flux_adaptation = 5.0f;
    estimator_oracle_case_t rig = rig_of(0, 400.0, 0.0);
    (void)settled(&params, &rig);
    float adapted = flux.flux_linkage;
    TEST_ASSERT_FLOAT_WITHIN(1e-3f, (float)PSI, adapted);
    params.flux_adaptation = 3.0f;
    retune(&params);
    TEST_ASSERT_TRUE(flux.flux_linkage == adapted);
    reset_near(&rig, 20000, 0.0, 0.0);
    TEST_ASSERT_TRUE(flux.flux_linkage == adapted);
    params.flux_linkage = 0.19f;
    retune(&params);
    TEST_ASSERT_TRUE(flux.flux_linkage == 0.19f);
    TEST_ASSERT_FLOAT_WITHIN(1e-6f, 1.0f / 0.19f, est.tracker.motor.speed_per_volt);
    (void)deviation(&rig, 20001, 5000, 0);
    TEST_ASSERT_FLOAT_WITHIN(2e-3f, (float)PSI, flux.flux_linkage);
    params.flux_adaptation = 0.0f;
    retune(&params);
    TEST_ASSERT_TRUE(flux.flux_linkage == 0.19f);
    init(&params);
    TEST_ASSERT_TRUE(flux.flux_linkage == 0.19f);
}
