/* The estimator in the paper's configurations: deviations as published, and the sign function. */
#include "tests/unit/estimator_bench.h"

/* ---- the paper's configuration: its printed numbers, after the PLL ---- */

static const double RPM[] = {100.0, 500.0, 1000.0, 1500.0};

/* With the power-weighted gain the paper states only the value for 1500 r/min; the others follow from
 * (14): the printed lag is atan(w L/(R (g + 1))), where g is that of the corrected one. With the exact lag
 * no error remains. */
static void test_each_lag_deviates_as_published(void)
{
    double expected[LAG_EXACT + 1][4] = {[LAG_NONE] = {-3.1, -15.8, -33.1, -54.1},
                                         [LAG_PRINTED] = {0.0, 0.0, 0.0, 35.5},
                                         [LAG_CORRECTED] = {2.1, 10.4, 20.7, 31.1}};
    static const double tolerances[] = {
        [LAG_NONE] = 1.0, [LAG_PRINTED] = 1.5, [LAG_CORRECTED] = 1.5, [LAG_EXACT] = 0.5};
    for (int n = 0; n < 3; n++) {
        const double omega = RPM[n] * RAD_PER_RPM, none = expected[LAG_NONE][n];
        const double g = omega * 0.0125 / tan(1e-3 * (expected[LAG_CORRECTED][n] - none)) - 0.95;
        expected[LAG_PRINTED][n] = none + 1e3 * atan(omega * 0.0125 / (0.95 * g + 0.95));
    }
    for (int lag = LAG_NONE; lag <= LAG_EXACT; lag++) {
        const estimator_params_t params = paper_params((lag_mode_t)lag);
        for (int n = lag == LAG_PRINTED ? 8 : 0; n < 16; n++) {
            const double way = n % 2 ? -1.0 : 1.0;
            const estimator_oracle_case_t rig =
                rig_of(0, way * RPM[n / 2 % 4] * RAD_PER_RPM, n / 8 ? way * RATED : 0.0);
            const deviation_t d = settled(&params, &rig);
            TEST_ASSERT_DOUBLE_WITHIN(tolerances[lag], way * expected[lag][n / 2 % 4], d.mean);
            check_below(d.sd, 1.0, "sd");
        }
    }
}

static void test_smaller_gain_gives_the_papers_eighty_milliradians(void)
{
    estimator_params_t params = paper_params(LAG_NONE);
    params.smo.gain = 162.0f;
    for (double way = -1.0; way <= 1.0; way += 2.0) {
        estimator_oracle_case_t rig = rig_of(0, way * 1500.0 * RAD_PER_RPM, way * RATED);
        deviation_t d = settled(&params, &rig);
        TEST_ASSERT_DOUBLE_WITHIN(3.0, -80.0 * way, d.mean);
    }
}

/* ---- sign ---- */

/* A conventional loop as in the paper: with the unfiltered sign function |v| is k_s sqrt 2 for any EMF, so
 * that there is no speed for a feed-forward. The chatter is chaotic, so that only its size is known: an SD
 * of 20 to 45 mrad with a filter. */
static void test_sign_is_rough_where_the_sigmoid_is_smooth(void)
{
    static const double cutoffs[] = {0.0, 2000.0};
    static const double rpm[] = {1000.0, 1003.0}; /* with and without a whole number of samples per turn */
    for (int n = 0; n < 8; n++) {
        double way = n % 2 ? -1.0 : 1.0;
        estimator_params_t params = paper_params(LAG_EXACT);
        tune(&params, 100.0, 0.0);
        params.smo.emf_cutoff = (float)cutoffs[n / 4];
        estimator_oracle_case_t rig = rig_of(0, way * rpm[n / 2 % 2] * RAD_PER_RPM, way * RATED);
        deviation_t sigmoid = settled(&params, &rig);
        params.smo.switching = SMO_SIGN;
        deviation_t sign = settled(&params, &rig);
        check_below(20.0 * sigmoid.sd, sign.sd, "ratio");
        check_below(fabs(sign.mean), 100.0, "mean of the sign");
        check_below(sign.sd, 200.0, "sd of the sign");
    }
}
