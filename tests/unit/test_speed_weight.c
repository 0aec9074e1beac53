/* The setpoint weight b of the speed control: i_q = kp (b omega_ref - omega) + I. On an inertia J/K_t the
 * loop is
 *
 *     omega/omega_ref = (b kp s + ki) c/(s^2 + kp c s + ki c),   c = K_t/J
 *
 * whose poles b does not move. */
#include <complex.h>
#include <stdbool.h>
#include <string.h>
#include <unity.h>

#include "control/speed_control.h"
#include "tests/unit/compare.h"

#define T     1e-4
#define C     17.26 /* K_t/J [rad/s^2 per A]: 1.098 N m/A on 0.0636 kg m^2 */
#define KP    0.8277
#define KI    (KP * KP * C / 3.0) /* damping sqrt(3)/2 */
#define LIMIT 10.0f

static speed_control_t control;

/* i_q within the limit of the tuning [A]. */
static float step(float omega_m_ref, float omega_m)
{
    return speed_control_step(&control, omega_m_ref, omega_m, -control.current_limit, control.current_limit);
}

static void begin_with(double weight, float limit)
{
    const speed_control_params_t params = {.kp = (float)KP,
                                           .ki = (float)KI,
                                           .weight = (float)weight,
                                           .current_limit = limit,
                                           .period = (float)T};
    const speed_control_tuning_t tuning = speed_control_prepare(&params);
    memset(&control, 0x55, sizeof control);
    speed_control_init(&control, &tuning);
}

/* Of the shaft: the integral alone knows the reference. */
static void test_disturbance_is_answered_alike(void)
{
    float answers[3][200];
    static const double weights[] = {0.0, 0.5, 1.0};
    for (int n = 0; n < 3; n++) {
        begin_with(weights[n], LIMIT);
        speed_control_reset(&control, 3.0f, 20.0f);
        for (int k = 0; k < 200; k++) {
            answers[n][k] = step(20.0f, 20.0f - 0.01f * (float)k);
            TEST_ASSERT_FLOAT_WITHIN(2e-5f, answers[0][k], answers[n][k]);
        }
    }
    TEST_ASSERT_TRUE(answers[0][199] > 4.0f);
}

/* Step answer of the loop in closed form: residues of the two poles. */
static double answer(double weight, double t)
{
    const double complex root = csqrt(KP * KP * C * C / 4.0 - KI * C + (double complex)I * 0.0);
    const double complex s = -KP * C / 2.0 + root;
    const double complex residue = (weight * KP * s + KI) * C / (s * 2.0 * root);
    return 1.0 + 2.0 * creal(residue * cexp(s * t));
}

/* Held for a period, the answer is half a period late: 0.5e-4 of the poles' 14 1/s. */
static void test_loop_answers_a_step_as_its_transfer_function(void)
{
    static const double weights[] = {0.0, 0.5, 1.0};
    static const double beyond[] = {0.0043, 0.05, 0.3}; /* no more than this; exp(-pi sqrt 3) with b = 0 */
    double peaks[3] = {0.0};
    for (int n = 0; n < 3; n++) {
        begin_with(weights[n], 1e3f);
        double omega = 0.0;
        for (int k = 0; k < 20000; k++) {
            TEST_ASSERT_DOUBLE_WITHIN(2e-3, answer(weights[n], k * T), omega / 10.0);
            omega += T * C * (double)step(10.0f, (float)omega);
            peaks[n] = fmax(peaks[n], omega / 10.0 - 1.0);
        }
        TEST_ASSERT_TRUE(peaks[n] < beyond[n] + 1e-3);
    }
    TEST_ASSERT_DOUBLE_WITHIN(5e-4, exp(-PI * sqrt(3.0)), peaks[0]);
    TEST_ASSERT_TRUE(peaks[0] < peaks[1] && peaks[1] < peaks[2]);
}

static void test_output_stays_within_the_limit_with_any_weight(void)
{
    for (double weight = 0.0; weight < 1.1; weight += 0.25) {
        begin_with(weight, LIMIT);
        for (int n = 0; n < 20000; n++) {
            const float reference = n / 3000 % 2 == 0 ? 80.0f : -80.0f;
            const float current = step(reference, 0.1f * reference);
            TEST_ASSERT_TRUE(fabsf(current) <= LIMIT * 1.00001f);
        }
    }
}

/* However long it was held there: an error of the other sign takes it off the limit at once where the
 * reference is in the proportional part; for b = 0 the integral has ki T e/s too much, s = T/10 ms, and goes
 * to ki T e'/s as exp(-t/10 ms): from e = 190 to e' = -1 it passes zero after 10 ms ln 191 = 52.5 ms. */
static void test_nothing_is_wound_up_at_the_limit(void)
{
    static const double weights[] = {0.0, 0.25, 1.0};
    for (int n = 0; n < 3; n++) {
        begin_with(weights[n], LIMIT);
        for (int k = 0; k < 100000; k++) {
            TEST_ASSERT_TRUE(step(200.0f, 10.0f) <= LIMIT);
        }
        TEST_ASSERT_FLOAT_WITHIN(1e-4f, LIMIT, step(200.0f, 10.0f));
        for (int k = 0; k < (weights[n] == 0.0 ? 530 : 2); k++) {
            (void)step(9.0f, 10.0f);
        }
        TEST_ASSERT_TRUE(step(9.0f, 10.0f) < LIMIT - 1e-4f);
    }
}

/* With b = 0 the integral waits ki T e/s above where it makes just the limit, s = T/10 ms: what it gets in a
 * period is what it gives back. */
static void test_integral_waits_at_the_limit(void)
{
    begin_with(0.0, LIMIT);
    for (int k = 0; k < 10000; k++) {
        (void)step(200.0f, 10.0f);
    }
    const double inside =
        (double)control.pi.integral - KP * 200.0; /* the share of the reference is not its */
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, 10.0 - KP * 190.0 + KI * T * 190.0 / (T / 10e-3), inside);
}

/* It leaves the limit where the integral's raise no longer makes up for the speed's, ki e = kp c limit, e =
 * 3 limit/kp = 36.2 rad/s; from there e = exp(-a t) (36.2 cos(b t) + 20.9 sin(b t)), a = kp c/2, b = a/sqrt
 * 3: 0.225 rad/s beyond. */
static void test_step_that_needs_the_limit_does_not_run_past(void)
{
    begin_with(0.0, LIMIT);
    double omega = 0.0, peak = 0.0;
    bool limited = false;
    for (int k = 0; k < 40000; k++) {
        const double current = (double)step(150.0f, (float)omega);
        limited = limited || current > 0.9999 * (double)LIMIT;
        omega += T * C * current;
        peak = fmax(peak, omega);
    }
    TEST_ASSERT_TRUE(limited);
    TEST_ASSERT_DOUBLE_WITHIN(0.05, 150.0, omega);
    TEST_ASSERT_DOUBLE_WITHIN(0.01, 150.225, peak);
}
