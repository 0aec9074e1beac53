/* The response is compared with the oracle's state space, and the values in time with exact data of a
 * turning machine. The 1e-5 rad of the header consist of 3e-6 for atan2, 1e-6 for gain and coefficients,
 * and the first terms that the series of W omits. At x = omega_e T = 0.63 and d = 0.3 these are x^5 d/5040
 * = 6e-6 of the angle and x^6/30240 = 2e-6 of the length; at 1.15 they are 1.2e-4 and 7.6e-5. */
#include "estimator/lag.h"
#include "tests/oracle/smo_oracle.h"
#include "tests/unit/machines.h"

#define ANGLE  1e-5 /* [rad] */
#define LENGTH 1e-5 /* [-] */
#define FAR    2e-4 /* [rad], [-] beyond 0.63 rad */

static smo_t smo;

static smo_params_t paper(void)
{
    smo_params_t params = PAPER;
    params.switching = SMO_SIGMOID_VECTOR;
    return params;
}

static smo_oracle_case_t motor_case(int n, double omega_e)
{
    smo_oracle_case_t rig = {
        MACHINES[n].resistance, MACHINES[n].inductance, MACHINES[n].flux_linkage, 1e-4, omega_e, 0.3, 2.0};
    return rig;
}

void setUp(void)
{
    const smo_params_t params = paper();
    smo_init(&smo, &params);
}

static void test_exact_lag_and_attenuation_are_those_of_the_sampled_system(void)
{
    static const float cutoffs[] = {0.0f, 100.0f, 600.0f, 2000.0f, 20000.0f};
    static const float errors[] = {0.0f, 0.3f, 1.5f};
    double worst[2] = {0.0, 0.0}; /* up to 0.63 rad, and beyond */
    double worst_ratio[2] = {0.0, 0.0};
    for (int n = 0; n < MACHINE_COUNT; n++) {
        for (int c = 0; c < 5; c++) {
            for (int m = 0; m < 3; m++) {
                smo_params_t params = observer_of(n, cutoffs[c]);
                smo_init(&smo, &params);
                /* The k_f for a large, a small and no error. */
                smo_reset(&smo, (ab_t){0.0f, 0.0f}, (ab_t){0.6f * errors[m] * params.gain, 0.0f});
                for (double omega = -11400.0; omega <= 11400.0; omega += 100.0) {
                    smo_oracle_case_t rig = motor_case(n, omega);
                    smo_oracle_observer_t observer = {(double)params.gain, (double)params.slope,
                                                      (double)cutoffs[c]};
                    smo_oracle_response_t truth =
                        smo_oracle_response(&rig, &observer, (double)smo_equivalent_gain(&smo));
                    double error = (double)lag_angle(&smo, LAG_EXACT, (float)omega) - truth.lag;
                    error = remainder(error, 2.0 * PI);
                    double ratio = (double)lag_attenuation(&smo, (float)omega) / truth.attenuation - 1.0;
                    const bool is_far = fabs(omega) > 6300.0;
                    worst[is_far] = fmax(worst[is_far], fabs(error));
                    worst_ratio[is_far] = fmax(worst_ratio[is_far], fabs(ratio));
                }
            }
        }
    }
    TEST_ASSERT_TRUE(worst[0] <= ANGLE && worst[1] <= FAR);
    TEST_ASSERT_TRUE(worst_ratio[0] <= LENGTH && worst_ratio[1] <= FAR);
}

/* 1.15 rad per period are 11500 rad/s. From 11499.99 rad/s to the limit the lag, below 3 rad in all, grows
 * by 3 rad/11500 rad/s times 0.01 rad/s = 3e-6 rad. The paper's modes have a formula of their own, which
 * needs no limit. */
static void test_speeds_beyond_the_turn_limit_are_answered_as_at_it(void)
{
    static const float beyond[] = {11500.01f, 11600.0f, 15708.0f, 31416.0f, 1e30f, INFINITY};
    static const float cutoffs[] = {0.0f, 2000.0f};
    for (int c = 0; c < 2; c++) {
        for (int m = 0; m < MACHINE_COUNT; m++) {
            smo_params_t params = observer_of(m, cutoffs[c]);
            smo_init(&smo, &params);
            const double lag = (double)lag_angle(&smo, LAG_EXACT, 11499.99f);
            const double ratio = (double)lag_attenuation(&smo, 11499.99f);
            /* Below the limit the angle is not limited. */
            TEST_ASSERT_TRUE(lag != (double)lag_angle(&smo, LAG_EXACT, 11490.0f));
            for (int n = 0; n < 12; n++) {
                const float way = n < 6 ? 1.0f : -1.0f;
                const float omega = way * beyond[n % 6];
                TEST_ASSERT_DOUBLE_WITHIN(5e-6, (double)way * lag, (double)lag_angle(&smo, LAG_EXACT, omega));
                TEST_ASSERT_DOUBLE_WITHIN(5e-6, ratio, (double)lag_attenuation(&smo, omega));
                TEST_ASSERT_TRUE(isfinite(lag_angle(&smo, LAG_PRINTED, omega)));
                TEST_ASSERT_TRUE(isfinite(lag_angle(&smo, LAG_CORRECTED, omega)));
            }
        }
    }
}

typedef struct {
    double angle;  /* [rad] angle of b relative to a */
    double length; /* |b|/|a| [-] */
} turn_t;

static turn_t turn_of(ab_t from, ab_t to)
{
    const double a = (double)from.alpha;
    const double b = (double)from.beta;
    const double c = (double)to.alpha;
    const double d = (double)to.beta;
    return (turn_t){atan2(a * d - b * c, a * c + b * d), hypot(c, d) / hypot(a, b)};
}

/* With LAG_EXACT it is the switching voltage of the observer, rotated and lengthened by the response
 * without the filter, for any state of the filter. In the paper's modes it is the filtered estimate,
 * rotated by the angle of the mode and lengthened by the whole response. */
static void test_emf_is_turned_by_the_angle_and_divided_by_the_attenuation(void)
{
    for (int n = 0; n < MACHINE_COUNT; n++) {
        for (int s = SMO_SIGMOID; s <= SMO_SIGMOID_VECTOR; s++) {
            smo_params_t params = observer_of(n, 2000.0f);
            params.switching = (smo_switching_t)s;
            const ab_t switched = {0.1f * params.gain, 0.5f * params.gain};
            const ab_t filtered = {0.3f * params.gain, -0.4f * params.gain};
            smo_oracle_observer_t observer = {(double)params.gain, (double)params.slope, 0.0};
            smo_oracle_observer_t with_filter = observer;
            with_filter.emf_cutoff = 2000.0;
            smo_init(&smo, &params);
            smo_reset(&smo, (ab_t){1.0f, -2.0f}, switched);
            smo.emf_hat = filtered;
            const double k_f = (double)smo_equivalent_gain(&smo);
            const double g = (double)params.gain * k_f;
            const double r = (double)params.resistance;
            for (double omega = -6300.0; omega <= 6300.0; omega += 300.0) {
                smo_oracle_case_t rig = motor_case(n, omega);
                smo_oracle_response_t bare = smo_oracle_response(&rig, &observer, k_f);
                smo_oracle_response_t whole = smo_oracle_response(&rig, &with_filter, k_f);
                const double angles[] = {0.0, atan(omega * (double)params.inductance / (g * r + r)),
                                         atan(omega * (double)params.inductance / (g + r)), bare.lag};
                for (int mode = LAG_NONE; mode <= LAG_EXACT; mode++) {
                    const ab_t emf = lag_emf(&smo, (lag_mode_t)mode, (float)omega);
                    const bool exact = mode == LAG_EXACT;
                    const turn_t turn = turn_of(exact ? smo.switched : filtered, emf);
                    const double length = turn.length * (exact ? bare.attenuation : whole.attenuation);
                    const double off = fabs(remainder(turn.angle - angles[mode], 2.0 * PI));
                    TEST_ASSERT_TRUE(off <= ANGLE);
                    TEST_ASSERT_DOUBLE_WITHIN(LENGTH, 1.0, length);
                }
            }
        }
    }
}

/* Without an error the EMF is zero, and nothing is divided by it. */
static void test_emf_of_no_error_is_zero(void)
{
    for (int s = SMO_SIGN; s <= SMO_SIGMOID_VECTOR; s++) {
        smo_params_t params = paper();
        params.switching = (smo_switching_t)s;
        smo_init(&smo, &params);
        for (int mode = LAG_NONE; mode <= LAG_EXACT; mode++) {
            const ab_t emf = lag_emf(&smo, (lag_mode_t)mode, 400.0f);
            TEST_ASSERT_TRUE(emf.alpha == 0.0f && emf.beta == 0.0f);
        }
    }
}

/* The v and e_hat that an EMF of 5 V makes: e_hat follows from the response, and v is the value from which
 * the filter, by its own formula, makes that e_hat. The inverse of the filter makes up to 27 V from the 5
 * V; the limit is this times 5e-7 for the sine and the rounding. */
static void test_switched_and_filtered_are_the_response(void)
{
    for (int n = 0; n < MACHINE_COUNT; n++) {
        for (int c = 0; c < 2; c++) {
            smo_params_t params = observer_of(n, c == 0 ? 0.0f : 2000.0f);
            smo_oracle_observer_t observer = {(double)params.gain, (double)params.slope,
                                              (double)params.emf_cutoff};
            smo_init(&smo, &params);
            const double k_f = (double)smo_equivalent_gain(&smo);
            const double decay = c == 0 ? 0.0 : exp(-0.2);
            for (double omega = -6000.0; omega <= 6000.0; omega += 400.0) {
                smo_oracle_case_t rig = motor_case(n, omega);
                smo_oracle_response_t truth = smo_oracle_response(&rig, &observer, k_f);
                const ab_t switched = lag_switched(&smo, (float)omega, (ab_t){3.0f, -4.0f});
                const ab_t emf_hat = lag_filtered(&smo, (float)omega, switched);
                const turn_t turn = turn_of((ab_t){3.0f, -4.0f}, emf_hat);
                TEST_ASSERT_DOUBLE_WITHIN(ANGLE, 0.0, remainder(turn.angle + truth.lag, 2.0 * PI));
                TEST_ASSERT_DOUBLE_WITHIN(LENGTH, 1.0, turn.length / truth.attenuation);

                /* The expected value follows from the filter (1 - c/z) e_hat = (1 - c) v. */
                const double a = (double)emf_hat.alpha;
                const double b = (double)emf_hat.beta;
                const double x = omega * 1e-4;
                const double re = 1.0 - decay * cos(x);
                const double im = decay * sin(x);
                TEST_ASSERT_DOUBLE_WITHIN(2e-5, (a * re - b * im) / (1.0 - decay), (double)switched.alpha);
                TEST_ASSERT_DOUBLE_WITHIN(2e-5, (a * im + b * re) / (1.0 - decay), (double)switched.beta);
            }
        }
    }
}

/* lag_error() returns the current error that belongs to an EMF, in the vector form. lag_emf() must return
 * this EMF from that error. ERROR_STEPS leave 3e-5 of the largest EMF by the rule, 0.57 k_s. */
static void test_error_makes_the_emf_again(void)
{
    for (int n = 0; n < MACHINE_COUNT; n++) {
        smo_params_t params = observer_of(n, 0.0f);
        smo_init(&smo, &params);
        for (double part = -1.0; part <= 1.0; part += 0.16) {
            const double omega = part * MACHINES[n].omega_max;
            const double length = part * (double)params.gain / 1.75;
            const ab_t emf = {(float)(0.6 * length), (float)(0.8 * length)};
            smo_reset_error(&smo, (ab_t){0.0f, 0.0f}, lag_error(&smo, (float)omega, emf));
            const turn_t turn = turn_of(emf, lag_emf(&smo, LAG_EXACT, (float)omega));
            TEST_ASSERT_DOUBLE_WITHIN(2e-4, 0.0, turn.angle);
            TEST_ASSERT_DOUBLE_WITHIN(1e-3, 1.0, turn.length);
        }
    }
}
