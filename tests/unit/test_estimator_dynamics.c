/* The estimator during acceleration. */
#include "tests/unit/estimator_bench.h"

/* If K is wrong by rho, rho times the error without K remains. If K is right, two errors remain
 * (docs/theory.md, 9; 1.6 mrad): the jump of the current in its first period, and the half period by which
 * a sampled integral of the current is early. */
static void test_torque_feedforward_takes_the_error_away(void)
{
    for (int n = 0; n < 8; n += SWEEP_FEW) {
        double way = n % 2 ? -1.0 : 1.0;
        double a = n / 2 % 2 ? -RAMP : RAMP;
        estimator_params_t params = params_of(0);
        tune(&params, n / 4 ? 200.0 : 100.0, n / 4 ? 50.0 : 25.0);
        estimator_oracle_case_t rig = ramp_rig(way * (a > 0.0 ? 42.0 : 620.0), way * a);
        double peaks[4];
        static const float factors[] = {0.0f, 0.7f, 1.0f, 1.3f};
        for (int m = 0; m < 4; m++) {
            params.torque_feedforward = 69.0f * factors[m];
            ramp_t r = ramp(&params, &rig);
            peaks[m] = r.peak;
            check_below(fabs(r.steady), 2.0, "steady");
        }
        TEST_ASSERT_DOUBLE_WITHIN(0.05 * peaks[0], 0.3 * peaks[0], peaks[1]);
        TEST_ASSERT_DOUBLE_WITHIN(0.05 * peaks[0], 0.3 * peaks[0], peaks[3]);
        check_below(peaks[2], 4.0, "right K");
    }
}

/* The current that carries the load must not be fed forward: if the whole current counts as load, the loop
 * works as without K. */
static void test_current_of_the_load_is_not_fed_forward(void)
{
    const estimator_oracle_case_t rig = rig_of(0, 300.0, 2.0);
    double ends[3];
    for (int n = 0; n < 3; n++) {
        estimator_params_t params = params_of(0);
        params.torque_feedforward = n == 2 ? 0.0f : 69.0f;
        init(&params);
        reset_near(&rig, 0, 0.0, 0.0);
        estimator_set_load(&est, n == 0 ? 2.0f : 0.0f);
        for (long k = 1; k <= 50; k++) {
            const estimator_oracle_sample_t now = sample_of(&rig, k);
            (void)estimator_step(&est, as_float(now.voltage), as_float(now.current));
        }
        ends[n] = (double)est.tracker.pll.feedforward;
    }
    /* 50 periods add K i per period to F, less the part that decays at omega_c: (1 - exp(-omega_c
     * t))/omega_c. */
    const double cutoff = 50.0, time = 50.0 * T;
    const double gained = 69.0 * (1.0 - exp(-cutoff * time)) / cutoff;
    TEST_ASSERT_DOUBLE_WITHIN(0.02 * 2.0 * gained, 2.0 * gained, ends[1] - ends[0]);
    TEST_ASSERT_DOUBLE_WITHIN(0.02 * 2.0 * gained, ends[2], ends[0]);
}
