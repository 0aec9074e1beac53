/* The estimator on exact data: the data themselves, the default configuration without error, and the EMF
 * filter in the frame of the loop. */
#include "tests/unit/estimator_bench.h"

/* ---- the data themselves ---- */

/* L di/dt = u - R i - e by Runge and Kutta's method between the samples: h^5 of (R/L T = 0.3)/50 and 1e-13
 * of rounding in voltages of up to 1e3. */
static void test_oracle_data_solve_the_winding_equation(void)
{
    for (int n = 0; n < MACHINE_COUNT; n++) {
        estimator_oracle_case_t rig = rig_of(n, 0.3 * MACHINES[n].omega_max, 3.0);
        rig.current_d = -1.5;
        rig.acceleration = 2000.0;
        rig.ramp_start = 0.002;
        rig.ramp_end = 0.006;
        rig.swing = 0.2 * MACHINES[n].omega_max;
        rig.swing_rate = 100.0;
        rig.current_torque = 1e-4;
        double theta = rig.theta_start;
        estimator_oracle_sample_t before;
        estimator_oracle_sample(&rig, 0, &before);
        for (long k = 1; k <= 100; k++) {
            estimator_oracle_sample_t now;
            estimator_oracle_sample(&rig, k, &now);
            double i[2] = {before.current[0], before.current[1]};
            double h = T / 50.0;
            for (int m = 0; m < 50; m++) {
                double slope[4][2], omega[3];
                for (int half = 0; half < 3; half++) {
                    double t = (double)(k - 1) * T + ((double)m + 0.5 * half) * h;
                    double ramp = t < 0.002 ? 0.0 : (t < 0.006 ? t - 0.002 : 0.004);
                    omega[half] = rig.omega_start + 2000.0 * ramp + rig.swing * sin(100.0 * t);
                }
                double angle[3] = {theta, theta + h * (5.0 * omega[0] + 8.0 * omega[1] - omega[2]) / 24.0,
                                   theta + h * (omega[0] + 4.0 * omega[1] + omega[2]) / 6.0};
                static const int at[4] = {0, 1, 1, 2};
                static const double share[4] = {0.0, 0.5, 0.5, 1.0};
                for (int stage = 0; stage < 4; stage++) {
                    double w = rig.flux_linkage * omega[at[stage]];
                    double e[2] = {-w * sin(angle[at[stage]]), w * cos(angle[at[stage]])};
                    for (int axis = 0; axis < 2; axis++) {
                        double now_i =
                            i[axis] + (stage > 0 ? share[stage] * h * slope[stage - 1][axis] : 0.0);
                        slope[stage][axis] =
                            (now.voltage[axis] - rig.resistance * now_i - e[axis]) / rig.inductance;
                    }
                }
                for (int axis = 0; axis < 2; axis++) {
                    i[axis] +=
                        h / 6.0 *
                        (slope[0][axis] + 2.0 * slope[1][axis] + 2.0 * slope[2][axis] + slope[3][axis]);
                }
                theta = angle[2];
            }
            TEST_ASSERT_DOUBLE_WITHIN(1e-9, theta, now.theta);
            TEST_ASSERT_DOUBLE_WITHIN(1e-7, now.current[0], i[0]);
            TEST_ASSERT_DOUBLE_WITHIN(1e-7, now.current[1], i[1]);
            before = now;
        }
    }
}

/* ---- 1. the default is exact ---- */

static void check_exact(int machine, double way, const double *cutoffs, int count)
{
    static const double parts[] = {1.0 / 15.0, 1.0 / 3.0, 0.7, 1.0};
    deviation_t worst = {0.0, 0.0, 0.0, 0.0};
    int point = machine + (way > 0.0 ? 0 : SWEEP_FEW / 2);
    for (int c = 0; c < count; c++) {
        for (int s = 0; s < 4; s++) {
            for (int loaded = 0; loaded < 2; loaded++, point++) {
                if (point % SWEEP_FEW != 0) {
                    continue;
                }
                estimator_params_t params = params_of(machine);
                params.smo.emf_cutoff = (float)cutoffs[c];
                /* Signs that a healthy run never raises: |x| of 1.75 times the EMF is 1.3/slope. */
                params.validity = (validity_params_t){.amplitude_min = 0.98f,
                                                      .amplitude_max = 1.02f,
                                                      .detector_max = 0.01f,
                                                      .current_max = 3.0f / params.smo.slope,
                                                      .speed_min = 20.0f,
                                                      .speed_max = 1.5f * (float)MACHINES[machine].omega_max};
                estimator_oracle_case_t rig =
                    rig_of(machine, way * parts[s] * MACHINES[machine].omega_max, loaded ? way * RATED : 0.0);
                deviation_t d = settled(&params, &rig);
                TEST_ASSERT_EQUAL_UINT16(0, estimator_invalid(&est));
                worst.mean = fmax(worst.mean, fabs(d.mean));
                worst.peak = fmax(worst.peak, d.peak);
                worst.speed = fmax(worst.speed, fabs(d.speed));
            }
        }
    }
    check_below(worst.mean, FLOAT_MEAN, "mean");
    check_below(worst.peak, FLOAT_PEAK, "peak");
    /* a mean frequency off by d would drift d 0.6 s */
    check_below(worst.speed, 2e-3 * FLOAT_PEAK / 0.6 + 1e-3, "speed");
}

static void test_default_is_exact_for_every_machine_either_way(void)
{
    static const double filters[] = {0.0, 600.0, 2000.0, 5000.0};
    for (int machine = 0; machine < MACHINE_COUNT; machine++) {
        check_exact(machine, 1.0, filters, 4);
        check_exact(machine, -1.0, filters, 4);
    }
}

static void test_current_on_the_d_axis_does_not_matter(void)
{
    for (double way = -1.0; way <= 1.0; way += 2.0) {
        estimator_params_t params = params_of(0);
        estimator_oracle_case_t rig = rig_of(0, way * 800.0 * RAD_PER_RPM, -3.0);
        rig.current_d = -5.0;
        deviation_t d = settled(&params, &rig);
        check_below(fabs(d.mean), FLOAT_MEAN, "mean");
        check_below(d.peak, FLOAT_PEAK, "peak");
    }
}

/* lag.h: within 1e-5 of the length, R T/L up to 0.5; the feed-forward is that length over psi_f, and stops
 * half a last digit over omega_c T = 0.005 short: 2.4e-4 rad/s at 3000, less than 1e-6 of it. */
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

typedef struct {
    double amplitude, detector, speed; /* SD [V], [-], [rad/s] */
} noise_t;

/* Of noise on the current, +-20 mA evenly. */
static noise_t noise_behind(float emf_cutoff)
{
    estimator_params_t params = params_of(0);
    params.smo.emf_cutoff = emf_cutoff;
    estimator_oracle_case_t rig = rig_of(0, 200.0, 2.0);
    (void)settled(&params, &rig);
    uint32_t seed = UINT32_C(5);
    double squares[3] = {0.0, 0.0, 0.0};
    for (long k = 11001; k < 15001; k++) {
        estimator_oracle_sample_t now;
        estimator_oracle_sample(&rig, k, &now);
        for (int axis = 0; axis < 2; axis++) {
            seed = seed * UINT32_C(1664525) + UINT32_C(1013904223);
            now.current[axis] += 0.02 * ((double)(seed >> 8) / 8388608.0 - 1.0);
        }
        position_t position = stepped(as_float(now.voltage), as_float(now.current));
        squares[0] += pow((double)est.tracker.pll.amplitude - PSI * 200.0, 2.0);
        squares[1] += pow((double)est.tracker.pll.detector, 2.0);
        squares[2] += pow((double)position.omega_e - 200.0, 2.0);
    }
    return (noise_t){sqrt(squares[0] / 4000.0), sqrt(squares[1] / 4000.0), sqrt(squares[2] / 4000.0)};
}

/* White noise behind the filter has sqrt((1 - c)/(1 + c)) = 0.32 of its SD, c = exp(-2000 rad/s T). That of
 * the EMF is the current's difference from sample to sample, mostly, so less: a third at most. */
static void test_filter_smooths_amplitude_detector_and_speed(void)
{
    const noise_t without = noise_behind(0.0f);
    const noise_t with = noise_behind(2000.0f);
    check_below(with.amplitude, 0.33 * without.amplitude, "SD of the amplitude");
    check_below(with.detector, 0.33 * without.detector, "SD of the detector");
    check_below(with.speed, 0.33 * without.speed, "SD of the speed");
}

/* A filter that is switched on, set to another cutoff and off again while the motor turns: the angle never
 * feels it, for the filter goes on from the EMF that it is at; and what an EMF that is longer by 5 V then
 * adds to it is the new one's share, 1 - exp(-cutoff T). */
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
