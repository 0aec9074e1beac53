#include "medium/manoeuvre/speed_control.h"
#include "tests/unit/sweep.h"
#include "tests/unit/vectors.h"

/* The paper's gains and limit (section 2). */
static const speed_control_params_t PARAMS = {
    .kp = 0.5f, .ki = 2.5f, .weight = 1.0f, .current_limit = 10.0f, .period = 1e-4f};

static void begin_with(speed_control_t *control, const speed_control_params_t *params)
{
    const speed_control_tuning_t tuning = speed_control_prepare(params);
    speed_control_init(control, &tuning);
}

static void begin(speed_control_t *control)
{
    begin_with(control, &PARAMS);
}

/* The paper's gains with another share of the reference in the proportional part. */
static void begin_weighed(speed_control_t *control, float weight)
{
    speed_control_params_t params = PARAMS;
    params.weight = weight;
    begin_with(control, &params);
}

/* A step with the whole current limit. */
static float step(speed_control_t *control, float omega_m_ref, float omega_m)
{
    return speed_control_step(control, omega_m_ref, omega_m, -control->current_limit, control->current_limit);
}

static void test_output_below_at_above_the_limit(void)
{
    static const float errors[] = {19.98f, 20.0f, 20.02f, 1e6f};
    static const float outputs[] = {9.99f, 10.0f, 10.0f, 10.0f};
    for (unsigned k = 0; k < sizeof errors / sizeof errors[0]; k++) {
        speed_control_t control;
        begin(&control);
        TEST_ASSERT_TRUE(step(&control, errors[k], 0.0f) == outputs[k]);
        begin(&control);
        TEST_ASSERT_TRUE(step(&control, 0.0f, errors[k]) == -outputs[k]);
    }
}

static void test_reset_beyond_the_limit_is_cut(void)
{
    speed_control_t control;
    begin(&control);
    speed_control_reset(&control, 25.0f, 1.0f);
    TEST_ASSERT_TRUE(step(&control, 1.0f, 1.0f) == 10.0f);
    speed_control_reset(&control, -25.0f, 1.0f);
    TEST_ASSERT_TRUE(step(&control, 1.0f, 1.0f) == -10.0f);
}

static void test_integral_follows_the_limit_while_it_holds(void)
{
    speed_control_t control;
    begin(&control);
    /* I = limit (1 - (1 - ki T/kp)^n) for any error: a time constant of kp/ki = 0.2 s. The permitted
     * difference of 1.1e-3 A is for rounding. In each step the part of kp e = 70 A beyond the limit is
     * rounded by 4e-6 A, of which the integral takes 1/2000; and the sum itself is rounded by 5e-7 A.
     * These errors add up over 2000 steps. */
    for (int n = 1; n <= 10000; n++) {
        TEST_ASSERT_TRUE(step(&control, 157.0f, 17.0f) == 10.0f);
        TEST_ASSERT_DOUBLE_WITHIN(1.1e-3, 10.0 * (1.0 - pow(1.0 - 5e-4, n)), (double)control.pi.integral);
    }
    /* The braking begins as soon as the speed is beyond the reference. */
    TEST_ASSERT_TRUE(step(&control, 157.0f, 157.5f) < 10.0f);
}

/* The step of the output is kp (b ref - omega) = 0.5 (b 10 - 4). */
static void test_weight_is_the_references_share_of_the_proportional_part(void)
{
    static const float weights[] = {0.0f, 0.25f, 0.5f, 1.0f};
    for (unsigned k = 0; k < sizeof weights / sizeof weights[0]; k++) {
        speed_control_t control;
        begin_weighed(&control, weights[k]);
        TEST_ASSERT_FLOAT_WITHIN(1e-6f, 0.5f * (weights[k] * 10.0f - 4.0f), step(&control, 10.0f, 4.0f));
        begin_weighed(&control, weights[k]); /* the response to a load does not depend on the weight */
        (void)step(&control, 0.0f, 0.0f);
        TEST_ASSERT_FLOAT_WITHIN(1e-6f, -2.0f, step(&control, 0.0f, 4.0f));
    }
}

/* Near the reference the output does not change with gain and weight; sums of 157 are rounded by 2e-5. */
static void test_new_gains_are_bumpless_at_the_reference(void)
{
    for (unsigned k = 0; k < 8; k++) {
        speed_control_t control;
        begin_weighed(&control, k & 1u ? 1.0f : 0.0f);
        speed_control_reset(&control, 4.55f, -157.0f);
        speed_control_params_t params = PARAMS;
        params.kp = k & 2u ? 1.0f : 0.25f;
        params.weight = k & 4u ? 1.0f : 0.0f;
        const speed_control_tuning_t tuning = speed_control_prepare(&params);
        speed_control_take(&control, &tuning, -157.0f);
        TEST_ASSERT_FLOAT_WITHIN(4e-5f, 4.55f, step(&control, -157.0f, -157.0f));
    }
}

/* Without a proportional part of the reference the integral exceeds the limit, for any duration, by at
 * most what it gains in 10 ms: 2.5 x 137 x 10 ms = 3.425 A. A speed above the reference reduces the
 * current at once: 10 rad/s are 5 A. */
static void test_without_weight_the_limit_leaves_nothing_to_unwind(void)
{
    speed_control_t control;
    begin_weighed(&control, 0.0f);
    for (int n = 0; n < 5000; n++) {
        (void)step(&control, 157.0f, 20.0f);
    }
    TEST_ASSERT_FLOAT_WITHIN(1e-5f, 10.0f, step(&control, 157.0f, 20.0f));
    TEST_ASSERT_FLOAT_WITHIN(1e-3f, 10.0f + 3.425f - 5.0f, step(&control, 157.0f, 30.0f));
}

/* ---- on an inertia ---- */

/* With the setpoint weight b, i_q = kp (b omega_ref - omega) + I, the loop with an inertia J/K_t is
 * omega/omega_ref = (b kp s + ki) c/(s^2 + kp c s + ki c), c = K_t/J. b does not change its poles. */
#define T  1e-4
#define C  17.26 /* K_t/J [rad/s^2 per A]: 1.098 N m/A on 0.0636 kg m^2 */
#define KP 0.8277
#define KI (KP * KP * C / 3.0) /* damping sqrt(3)/2 */

static void begin_loop(speed_control_t *control, double weight, float limit)
{
    const speed_control_params_t params = {(float)KP, (float)KI, (float)weight, limit, (float)T};
    begin_with(control, &params);
}

/* The step response of the loop in closed form, from the residues of the two poles. */
static double answer(double weight, double t)
{
    const double complex root = J * sqrt(KI * C - KP * KP * C * C / 4.0);
    const double complex s = -KP * C / 2.0 + root;
    const double complex residue = (weight * KP * s + KI) * C / (s * 2.0 * root);
    return 1.0 + 2.0 * creal(residue * cexp(s * t));
}

/* The output is held for a period, so that the response is half a period late: 0.5e-4 s times the 14 1/s
 * of the poles. */
static void test_loop_answers_a_step_as_its_transfer_function(void)
{
    static const double weights[] = {0.0, 0.5, 1.0};
    static const double beyond[] = {0.0043, 0.05, 0.3}; /* largest overshoot: exp(-pi sqrt 3) for b = 0 */
    double peaks[3] = {0.0};
    for (int n = 0; n < 3; n += SWEEP_FEW) {
        speed_control_t control;
        begin_loop(&control, weights[n], 1e3f);
        double omega = 0.0;
        for (int k = 0; k < 20000; k++) {
            if (k % SWEEP_FEW == 0) {
                TEST_ASSERT_DOUBLE_WITHIN(2e-3, answer(weights[n], k * T), omega / 10.0);
            }
            omega += T * C * (double)step(&control, 10.0f, (float)omega);
            peaks[n] = fmax(peaks[n], omega / 10.0 - 1.0);
        }
        TEST_ASSERT_TRUE(peaks[n] < beyond[n] + 1e-3);
    }
    TEST_ASSERT_DOUBLE_WITHIN(5e-4, exp(-PI * sqrt(3.0)), peaks[0]);
    TEST_ASSERT_TRUE(SWEEP_FEW != 1 || (peaks[0] < peaks[1] && peaks[1] < peaks[2]));
}

/* The output leaves the limit where the rise of the integral no longer compensates the rise of the speed:
 * ki e = kp c limit, e = 3 limit/kp = 36.2 rad/s. From there e = exp(-a t) (36.2 cos(b t) + 20.9 sin(b t))
 * with a = kp c/2, b = a/sqrt 3: an overshoot of 0.225 rad/s. */
static void test_step_that_needs_the_limit_does_not_run_past(void)
{
    speed_control_t control;
    begin_loop(&control, 0.0, 10.0f);
    double omega = 0.0, peak = 0.0;
    bool limited = false;
    for (int32_t k = 0; k < 40000; k++) {
        const double current = (double)step(&control, 150.0f, (float)omega);
        limited = limited || current > 0.9999 * 10.0;
        omega += T * C * current;
        peak = fmax(peak, omega);
    }
    TEST_ASSERT_TRUE(limited);
    TEST_ASSERT_DOUBLE_WITHIN(0.05, 150.0, omega);
    TEST_ASSERT_DOUBLE_WITHIN(0.01, 150.225, peak);
}
