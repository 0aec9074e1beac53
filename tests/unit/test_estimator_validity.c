/* The criteria of validity and their debounce. */
#include "tests/unit/estimator_bench.h"

/* ---- validity ---- */

typedef struct {
    validity_params_t loose, strict; /* limits that no value and every value violates */
} limits_t;

static const uint32_t BITS[] = {ESTIMATOR_AMPLITUDE, ESTIMATOR_AMPLITUDE, ESTIMATOR_DETECTOR,
                                ESTIMATOR_CURRENT,   ESTIMATOR_SPEED,     ESTIMATOR_SPEED};
#define LIMIT_COUNT 6

/* Limits of which only number n is set, to `value`. */
static validity_params_t limit_at(int n, double value)
{
    validity_params_t limits = {.amplitude_min = 0.0f};
    float *slots[] = {&limits.amplitude_min, &limits.amplitude_max, &limits.detector_max,
                      &limits.current_max,   &limits.speed_min,     &limits.speed_max};
    *slots[n] = (float)value;
    return limits;
}

/* +1: the criterion is an upper limit, -1: a lower limit. */
static const double SIDE[] = {-1.0, 1.0, 1.0, 1.0, -1.0, 1.0};

/* The machine accelerates at 300 to 630 rad/s with a/ki = 0.05, so that no judged value is zero. The lower
 * limit of the amplitude can be at most 1, and for its test psi_hat is 15 % too large. The upper limit is
 * at least 1, and psi_hat is a third too small. The speed has an allowance of 10 rad/s on either side. */
static estimator_oracle_case_t validity_rig(double way)
{
    return ramp_rig(way * 300.0, way * 0.05 * 6495.0);
}

static estimator_params_t validity_params(int n)
{
    estimator_params_t params = params_of(0);
    tune(&params, 200.0, 0.0);
    params.smo.emf_cutoff = 0.0f;
    params.flux_linkage = (float)(n == 1 ? PSI / 1.5 : PSI * 1.15);
    return params;
}

#define JUDGED    6000L
#define ALLOWANCE 10.0 /* [rad/s] */

static void run_to_judged(int n, double way)
{
    estimator_params_t params = validity_params(n);
    estimator_oracle_case_t rig = validity_rig(way);
    run_near(&params, &rig, 0.0, JUDGED - 1);
}

/* The value that each criterion judges in step JUDGED, computed from the truth: the speed of the ramp; the
 * same less kp eps for the smooth speed; the EMF divided by psi_hat; a/ki; and |x| of the settled observer
 * (oracle) at this speed. */
static double judged(int n, double way)
{
    estimator_params_t params = validity_params(n);
    estimator_oracle_case_t rig = validity_rig(way);
    const estimator_oracle_sample_t now = sample_of(&rig, JUDGED);
    double ratio = 0.05 * 6495.0 / (double)params.pll.ki;
    double speed = fabs(now.omega) - (double)params.pll.kp * ratio;
    double amplitude = fabs(now.omega) * PSI / (double)params.flux_linkage;
    smo_oracle_case_t turning = {0.95, 0.0125, PSI, T, now.omega, 0.0, 0.0};
    smo_oracle_observer_t observer = {(double)params.smo.gain, (double)params.smo.slope, 0.0};
    double error = sqrt(smo_oracle_run(&turning, &observer, SMO_ORACLE_VECTOR, 300, 100).square);
    const double values[] = {
        (amplitude + ALLOWANCE) / speed, (amplitude - ALLOWANCE) / speed, ratio, error, speed, speed};
    return values[n];
}

/* The limits are 2 % beside the true value on either side. */
static void test_each_criterion_fails_beyond_its_limit_and_not_before(void)
{
    for (double way = -1.0; way <= 1.0; way += 2.0) {
        for (int n = 0; n < LIMIT_COUNT; n++) {
            double value = judged(n, way);
            for (int m = 0; m < 2; m++) {
                double factor = 1.0 + (m ? 0.02 : -0.02) * SIDE[n];
                estimator_params_t params = validity_params(n);
                params.validity = limit_at(n, value * factor);
                estimator_oracle_case_t rig = validity_rig(way);
                run_to_judged(n, way);
                retune(&params);
                (void)step(&rig, JUDGED);
                TEST_ASSERT_EQUAL_UINT16(m ? 0u : BITS[n], estimator_invalid(&est));
            }
        }
    }
}

/* The limit is just below, at and just above the value of the step, to the last digits. */
static void test_at_its_limit_a_criterion_still_holds(void)
{
    for (int n = 0; n < LIMIT_COUNT; n++) {
        estimator_params_t params = validity_params(n);
        estimator_oracle_case_t rig = validity_rig(1.0);
        run_to_judged(n, 1.0);
        estimator_t before = est;
        (void)step(&rig, JUDGED);
        double speed = (double)est.tracker.pll.omega_smooth;
        double amplitude = (double)est.tracker.pll.amplitude * (double)est.tracker.motor.speed_per_volt;
        const double values[] = {(amplitude + ALLOWANCE) / speed,
                                 (amplitude - ALLOWANCE) / speed,
                                 fabs((double)est.tracker.pll.detector),
                                 sqrt((double)smo_error_square(&est.observer.smo)),
                                 speed,
                                 speed};
        /* Widths for the rounding of the products; the other end of a range is set to 2 and 750. */
        static const double width[] = {2e-6, 2e-6, 1.2e-7, 4e-7, 4e-7, 4e-7};
        for (int m = -1; m <= 1; m++) {
            if (m == 0 && n != 2) {
                continue;
            }
            est = before;
            params.validity = limit_at(n, values[n] * (1.0 - m * width[n] * SIDE[n]));
            params.validity.amplitude_max = n == 0 ? 2.0f : params.validity.amplitude_max;
            params.validity.speed_max = n == 4 ? 750.0f : params.validity.speed_max;
            retune(&params);
            (void)step(&rig, JUDGED);
            TEST_ASSERT_EQUAL_UINT16(m > 0 ? BITS[n] : 0u, estimator_invalid(&est));
        }
    }
}

static void test_criterion_switched_off_is_not_judged(void)
{
    estimator_params_t params = params_of(0);
    init(&params);
    uint32_t seed = UINT32_C(7);
    for (int k = 0; k < 3000; k++) {
        seed = seed * UINT32_C(1664525) + UINT32_C(1013904223);
        float noise = (float)(seed >> 16) - 32768.0f;
        (void)stepped((ab_t){noise, 100.0f}, (ab_t){1.0f, noise});
        TEST_ASSERT_EQUAL_UINT16(0, estimator_invalid(&est));
    }
}

/* A debounce of 4.5 periods takes 5. The test sets the limits to either side of the value, so that a
 * period fails or passes as required; it counts the periods separately. */
static void check_debounce(int n)
{
    static const char pattern[] = "FFFF....FFFF.F.FF.FFFFFFFFFFFFFFF....F....F..FF......FFFFF.....";
    estimator_params_t loose = validity_params(n);
    estimator_oracle_case_t rig = validity_rig(1.0);
    double value = judged(n, 1.0);
    run_to_judged(n, 1.0);
    loose.validity = limit_at(n, value * (1.0 + 0.05 * SIDE[n]));
    loose.validity.amplitude_time = n < 2 ? 4.5e-4f : 0.0f;
    loose.validity.detector_time = n == 2 ? 4.5e-4f : 0.0f;
    loose.validity.current_time = n == 3 ? 4.5e-4f : 0.0f;
    loose.validity.speed_time = n > 3 ? 4.5e-4f : 0.0f;
    estimator_params_t strict = loose;
    validity_params_t moved = limit_at(n, value * (1.0 - 0.05 * SIDE[n]));
    strict.validity.amplitude_min = moved.amplitude_min;
    strict.validity.amplitude_max = moved.amplitude_max;
    strict.validity.detector_max = moved.detector_max;
    strict.validity.current_max = moved.current_max;
    strict.validity.speed_min = moved.speed_min;
    strict.validity.speed_max = moved.speed_max;
    int count = 0;
    bool raised = false;
    int changes = 0;
    for (long k = 0; pattern[k] != '\0'; k++) {
        bool fails = pattern[k] == 'F';
        retune(fails ? &strict : &loose);
        (void)step(&rig, JUDGED + k);
        count = fails ? (count < 5 ? count + 1 : 5) : (count > 0 ? count - 1 : 0);
        bool was = raised;
        raised = count == 5 || (raised && count > 0);
        changes += was != raised;
        TEST_ASSERT_EQUAL_UINT16(raised ? BITS[n] : 0u, estimator_invalid(&est));
    }
    TEST_ASSERT_EQUAL_INT(4, changes);
}

static void test_each_criterion_is_debounced(void)
{
    for (int n = 0; n < LIMIT_COUNT; n++) {
        check_debounce(n);
    }
}

/* The bit is set and cleared with the sample, and it does not change the other bits. */
static void test_sample_bit_is_not_debounced(void)
{
    estimator_params_t params = validity_params(4);
    params.validity = limit_at(4, 900.0);
    params.validity.speed_time = 2.5e-4f;
    estimator_oracle_case_t rig = validity_rig(1.0);
    run_to_judged(4, 1.0);
    retune(&params);
    uint16_t seen[7];
    for (long k = 0; k < 7; k++) {
        if (k == 1 || k == 2 || k == 5) {
            (void)stepped((ab_t){0.0f, NAN}, (ab_t){0.0f, 0.0f});
        } else {
            (void)step(&rig, JUDGED + k);
        }
        seen[k] = estimator_invalid(&est);
    }
    static const uint16_t expected[] = {0, 16, 16, 0, 8, 24, 8};
    TEST_ASSERT_EQUAL_UINT16_ARRAY(expected, seen, 7);
}

static void test_reset_starts_validity_again(void)
{
    estimator_params_t params = validity_params(0);
    estimator_oracle_case_t rig = validity_rig(1.0);
    run_to_judged(0, 1.0);
    params.validity =
        (validity_params_t){1.0f, 0.0f, 2.5e-4f, 0.01f, 2.5e-4f, 1e-3f, 2.5e-4f, 900.0f, 0.0f, 2.5e-4f};
    retune(&params);
    for (int n = 0; n < 2; n++) {
        for (long k = 0; k < 3; k++) {
            TEST_ASSERT_EQUAL_UINT16(0, estimator_invalid(&est));
            (void)step(&rig, JUDGED + 10 * n + k);
        }
        TEST_ASSERT_TRUE((estimator_invalid(&est) & ESTIMATOR_SPEED) != 0u);
        reset_near(&rig, JUDGED + 10 * n + 9, 0.0, 0.0);
        TEST_ASSERT_EQUAL_UINT16(0, estimator_invalid(&est));
    }
}
