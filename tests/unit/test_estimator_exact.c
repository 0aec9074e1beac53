/* The estimator with exact data: the data themselves, the default configuration, which must have no error,
 * and the EMF filter in the frame of the loop. */
#include "tests/unit/estimator_bench.h"

/* ---- the default is exact ---- */

static void test_default_is_exact_for_every_machine_either_way(void)
{
    static const double parts[] = {1.0 / 15.0, 1.0 / 3.0, 0.7, 1.0}, cutoffs[] = {0.0, 600.0, 2000.0, 5000.0};
    deviation_t worst = {0.0, 0.0, 0.0, 0.0};
    for (int n = 0; n < 64 * MACHINE_COUNT; n += SWEEP_FEW) {
        const int machine = n / 64;
        const double way = n % 2 ? -1.0 : 1.0;
        estimator_params_t params = params_of(machine);
        params.smo.emf_cutoff = (float)cutoffs[n / 16 % 4];
        /* Limits that no run without a fault violates: |x| of 1.75 times the EMF is 1.3/slope. */
        params.validity = (validity_params_t){.amplitude_min = 0.98f,
                                              .amplitude_max = 1.02f,
                                              .detector_max = 0.01f,
                                              .current_max = 3.0f / params.smo.slope,
                                              .speed_min = 20.0f,
                                              .speed_max = 1.5f * (float)MACHINES[machine].omega_max};
        const double omega = way * parts[n / 4 % 4] * MACHINES[machine].omega_max;
        const estimator_oracle_case_t rig = rig_of(machine, omega, n / 2 % 2 ? way * RATED : 0.0);
        const deviation_t d = settled(&params, &rig);
        TEST_ASSERT_EQUAL_UINT16(0, estimator_invalid(&est));
        worst.mean = fmax(worst.mean, fabs(d.mean));
        worst.peak = fmax(worst.peak, d.peak);
        worst.speed = fmax(worst.speed, fabs(d.speed));
    }
    check_line(worst.mean, FLOAT_MEAN, "A2 mean");
    check_line(worst.peak, FLOAT_PEAK, "A2 peak");
    /* A mean speed that is wrong by d would drift by d 0.6 s. */
    check_below(worst.speed, 2e-3 * FLOAT_PEAK / 0.6 + 1e-3, "speed");
}

/* lag.h gives the length within 1e-5, for R T/L up to 0.5. The feed-forward is that length divided by
 * psi_f. It stops half a last digit, divided by omega_c T = 0.005, before its end: 2.4e-4 rad/s at 3000
 * rad/s, less than 1e-6 of it. */
static void test_emf_has_its_length_and_the_feedforward_carries_the_speed(void)
{
    for (int n = 0; n <= EXTREME; n++) {
        for (int m = 0; m < 8; m += SWEEP_FEW) {
            double part = (m % 2 ? -1.0 : 1.0) * (0.1 + 0.3 * (m / 2));
            double omega = part * fmin(3000.0, MACHINES[n].omega_max);
            estimator_params_t params = params_of(n);
            estimator_oracle_case_t rig = rig_of(n, omega, 2.0);
            (void)settled(&params, &rig);
            double length = hypot((double)est.estimate.emf.alpha, (double)est.estimate.emf.beta);
            double off = length / fabs(rig.flux_linkage * omega) - 1.0;
            TEST_ASSERT_DOUBLE_WITHIN(1e-5, 0.0, off);
            TEST_ASSERT_DOUBLE_WITHIN(1e-5, 1.0,
                                      (double)est.tracker.pll.amplitude / fabs(rig.flux_linkage * omega));
            TEST_ASSERT_DOUBLE_WITHIN(1e-4, 1.0, (double)est.tracker.pll.feedforward / omega);
            TEST_ASSERT_DOUBLE_WITHIN(1e-4 * fabs(omega), 0.0, (double)est.tracker.pll.integral);
        }
    }
}

/* ---- the EMF filter acts in the frame of the loop ---- */

/* While the motor turns, a filter is switched on, set to another cutoff and switched off again. The angle
 * must not change, because the filter continues from its present EMF. An EMF that is 5 V longer afterwards
 * must add the share of the new filter to the error, 1 - exp(-cutoff T). */
static void test_filter_is_switched_while_it_runs(void)
{
    static const double cutoffs[] = {2000.0, 600.0, 0.0, 5000.0};
    for (double way = -1.0; way <= 1.0; way += 2.0) {
        const double omega = way * 1000.0 * RAD_PER_RPM;
        estimator_params_t params = params_of(0);
        params.smo.emf_cutoff = 0.0f;
        estimator_oracle_case_t rig = rig_of(0, omega, way * RATED);
        (void)settled(&params, &rig);
        for (long n = 0; n < 4; n++) {
            params.smo.emf_cutoff = (float)cutoffs[n];
            retune(&params);
            check_below(deviation(&rig, 11001 + 200 * n, 0, 200).peak, FLOAT_PEAK, "peak");
            pll_t pll = est.tracker.pll;
            const double before = (double)pll.emf.q;
            const double q = before + 5.0;
            const ab_t emf = {(float)(-q * (double)pll.rotation.sin), (float)(q * (double)pll.rotation.cos)};
            (void)pll_step(&pll, emf, (float)(1.0 / PSI), 0.0f);
            const double share = cutoffs[n] > 0.0 ? 1.0 - exp(-cutoffs[n] * T) : 1.0;
            TEST_ASSERT_DOUBLE_WITHIN(1e-5 * fabs(q), before + share * 5.0, (double)pll.emf.q);
        }
    }
}
