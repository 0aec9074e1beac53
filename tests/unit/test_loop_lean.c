/* The lean by its formula, and the tracking loop with a current that turns with the loop, as it does if the
 * drive controls it there. With an L that is wrong by dL the observed EMF is
 *
 *     j psi_f omega e^(j theta) + dL i_q omega_loop e^(j theta_loop)
 *
 * The limit without lean is from Routh's criterion (docs/theory.md, 6). */
#include "estimator/loop_lean.h"

#include "estimator/pll.h"
#include "tests/unit/compare.h"

#define T          1e-4   /* [s] */
#define PSI        0.012  /* [Wb] */
#define INDUCTANCE 1.5e-3 /* [H] */
#define CURRENT    8.4    /* [A] */
#define FASTEST    3142.0 /* [rad/s] 20 periods in a turn */
#define DATA       0.1    /* [-] */

static pll_params_t loop_of(float bandwidth, float cutoff)
{
    pll_params_t params = {.amplitude_floor = 0.13f};
    TEST_ASSERT_TRUE(pll_design(&params, bandwidth, 1.0f, cutoff, (float)T));
    return params;
}

static loop_lean_tuning_t lean_of(const pll_params_t *params)
{
    return loop_lean_prepare((float)DATA, (float)INDUCTANCE, (float)PSI, params);
}

/* The largest c of a stable loop without lean [rad/s]. */
static double limit_of(const pll_params_t *params)
{
    const double kp = (double)params->kp, ki = (double)params->ki,
                 cutoff = (double)params->feedforward_cutoff;
    return kp + ki * kp / (cutoff * (kp + cutoff));
}

typedef struct {
    double error;  /* [rad] mean of theta - theta_loop in the last 0.2 s */
    double spread; /* [rad] largest distance from it there */
} settled_t;

/* Eight seconds at this speed [rad/s] with an L that is wrong by dL [H], from a deviation of 10 mrad.
 * The slowest pole of these loops is at -1.4/s, where c is negative. */
static settled_t settle(const pll_params_t *params, double omega, double i_q, double d_l, float lean)
{
    const int count = 80000;
    const double settled = asin(d_l * i_q / PSI);
    double errors[2000];
    pll_t pll;
    pll_init(&pll, params);
    pll_reset(&pll, (position_t){(float)(-settled - 0.01), (float)omega});
    double sum = 0.0;
    for (int k = 0; k < count; k++) {
        const double theta = omega * T * k;
        const double loop = (double)pll.theta_e;
        const double made = d_l * i_q * (k == 0 ? omega : (double)pll.omega_e);
        const ab_t emf = {(float)(-PSI * omega * sin(theta) + made * cos(loop)),
                          (float)(PSI * omega * cos(theta) + made * sin(loop))};
        const pll_motor_t motor = {(float)(1.0 / PSI), lean, 1.0f, 1.0f, 0.0f};
        const position_t at = pll_step_inline(&pll, emf, motor);
        if (k >= count - 2000) {
            errors[k - (count - 2000)] = circle(theta - (double)at.theta_e);
            sum += errors[k - (count - 2000)];
        }
    }
    settled_t found = {sum / 2000.0, 0.0};
    for (int n = 0; n < 2000; n++) {
        found.spread = fmax(found.spread, fabs(errors[n] - found.error));
    }
    return found;
}

/* kp 100, ki 2500 and omega_c 50 have the limit 100 + 2500 x 100/(50 x 150) = 133.3 rad/s; 0.75 of it is 100.
 * C is 0.2 x 1.5 mH x 8.4 A/12 mWb = 0.21 of the speed, 630 rad/s at 3000 rad/s. */
static const pll_params_t simple = {.kp = 100.0f, .ki = 2500.0f, .feedforward_cutoff = 50.0f};

static void test_it_is_two_and_a_half_times_what_the_loop_does_not_hold(void)
{
    const loop_lean_tuning_t tuning = lean_of(&simple);
    const double lean = 2.5 * (630.0 - 100.0) / 3000.0;
    TEST_ASSERT_DOUBLE_WITHIN(1e-5, lean, (double)loop_lean(&tuning, 8.4f, 3000.0f));
    TEST_ASSERT_DOUBLE_WITHIN(1e-5, lean, (double)loop_lean(&tuning, -8.4f, 3000.0f));
    TEST_ASSERT_DOUBLE_WITHIN(1e-5, -lean, (double)loop_lean(&tuning, 8.4f, -3000.0f));
    TEST_ASSERT_DOUBLE_WITHIN(1e-5, -lean, (double)loop_lean(&tuning, -8.4f, -3000.0f));
}

/* With 8.4 A, C is 100 rad/s at 476.2 rad/s. */
static void test_there_is_none_where_the_loop_holds_a_wrong_l(void)
{
    const loop_lean_tuning_t tuning = lean_of(&simple);
    TEST_ASSERT_EQUAL_FLOAT(0.0f, loop_lean(&tuning, 8.4f, 475.0f));
    TEST_ASSERT_EQUAL_FLOAT(0.0f, loop_lean(&tuning, -8.4f, -475.0f));
    TEST_ASSERT_EQUAL_FLOAT(0.0f, loop_lean(&tuning, 8.4f, 0.0f));
    TEST_ASSERT_EQUAL_FLOAT(0.0f, loop_lean(&tuning, 1.3f, 3000.0f));
    const float begun = loop_lean(&tuning, 8.4f, 478.0f);
    TEST_ASSERT_TRUE(begun > 0.0f && begun < 0.003f); /* 2.5 x 0.38/478 = 0.002: it begins without a step */
    const loop_lean_tuning_t certain = loop_lean_prepare(0.0f, (float)INDUCTANCE, (float)PSI, &simple);
    TEST_ASSERT_EQUAL_FLOAT(0.0f, loop_lean(&certain, 100.0f, 3000.0f));
}

/* Then |e| is not used. */
static void test_there_is_none_without_a_feed_forward(void)
{
    pll_params_t conventional = simple;
    conventional.feedforward_cutoff = 0.0f;
    const loop_lean_tuning_t tuning = lean_of(&conventional);
    TEST_ASSERT_EQUAL_FLOAT(0.0f, loop_lean(&tuning, 100.0f, 3000.0f));
    TEST_ASSERT_EQUAL_FLOAT(0.0f, loop_lean(&tuning, 100.0f, 0.0f));
}

static void test_without_it_a_wrong_l_makes_the_loop_unstable_beyond_the_limit_of_the_theory(void)
{
    const pll_params_t params = loop_of(220.0f, 55.0f);
    const double lean = 0.2 * INDUCTANCE * CURRENT / PSI;
    for (int n = 0; n < 2; n++) {
        const double way = n == 0 ? 1.0 : -1.0;
        const double i_q = way * CURRENT; /* drives the rotor */
        const double omega = limit_of(&params) / lean;
        const settled_t below = settle(&params, 0.8 * way * omega, i_q, 0.2 * INDUCTANCE, 0.0f);
        TEST_ASSERT_DOUBLE_WITHIN(1e-3, way * asin(lean), below.error);
        check_below(below.spread, 1e-3, "below the limit");
        const settled_t beyond = settle(&params, 1.2 * way * omega, i_q, 0.2 * INDUCTANCE, 0.0f);
        TEST_ASSERT_TRUE(beyond.spread > 0.1);
    }
}

/* Driving with an L that is too large, braking with one that is too small, and the two other cases; to the
 * top speed, in both directions. */
static void test_with_it_an_l_a_fifth_wrong_loses_no_rotor(void)
{
    static const float loops[][2] = {{220.0f, 55.0f}, {220.0f, 110.0f}, {1000.0f, 250.0f}};
    for (size_t n = 0; n < sizeof loops / sizeof loops[0]; n++) {
        const pll_params_t params = loop_of(loops[n][0], loops[n][1]);
        const loop_lean_tuning_t tuning = lean_of(&params);
        for (int m = 0; m < 24; m++) {
            const double i_q = (m % 2 ? -1.0 : 1.0) * CURRENT;
            const double d_l = (m / 2 % 2 ? -0.2 : 0.2) * INDUCTANCE;
            const double way = m / 4 % 2 ? -1.0 : 1.0;
            const double omega = way * FASTEST * (m / 8 + 1) / 3.0;
            const float lean = loop_lean(&tuning, (float)i_q, (float)omega);
            const settled_t at = settle(&params, omega, i_q, d_l, lean);
            TEST_ASSERT_DOUBLE_WITHIN(2e-3, asin(d_l * i_q / PSI), at.error);
            check_below(at.spread, 2e-3, "with lean");
        }
    }
}

/* The largest |theta - theta_loop| [rad] in the 2 s after i_q has jumped from `before` to `after` [A];
 * `before` lasts 4 s, in which the loop settles. */
static double jump(const pll_params_t *params, double omega, double d_l, double before, double after,
                   float lean)
{
    const int jumps = 40000;
    double largest = 0.0;
    pll_t pll;
    pll_init(&pll, params);
    pll_reset(&pll, (position_t){(float)-asin(d_l * before / PSI), (float)omega});
    for (int k = 0; k < jumps + 20000; k++) {
        const double theta = omega * T * k, loop = (double)pll.theta_e;
        const double made = d_l * (k < jumps ? before : after) * (k == 0 ? omega : (double)pll.omega_e);
        const ab_t emf = {(float)(-PSI * omega * sin(theta) + made * cos(loop)),
                          (float)(PSI * omega * cos(theta) + made * sin(loop))};
        const pll_motor_t motor = {(float)(1.0 / PSI), lean, 1.0f, 1.0f, 0.0f};
        const position_t at = pll_step_inline(&pll, emf, motor);
        if (k >= jumps) {
            largest = fmax(largest, fabs(circle(theta - (double)at.theta_e)));
        }
    }
    return largest;
}

/* The equations of docs/theory.md, 6, integrated for C = 4.3 times the limit, from no current and from the
 * opposite one: at most 2.02 times the error of the law for either sign of dL. */
static void test_a_jump_of_the_current_loses_no_rotor(void)
{
    const pll_params_t params = loop_of(220.0f, 55.0f);
    const loop_lean_tuning_t tuning = lean_of(&params);
    const double law = asin(0.2 * INDUCTANCE * CURRENT / PSI);
    for (int n = 0; n < 8; n++) {
        const double after = (n % 2 ? -1.0 : 1.0) * CURRENT;
        const double before = n / 2 % 2 ? -after : 0.0;
        const double d_l = (n / 4 % 2 ? -0.2 : 0.2) * INDUCTANCE;
        const float lean = loop_lean(&tuning, (float)after, (float)FASTEST);
        check_below(jump(&params, FASTEST, d_l, before, after, lean), 2.1 * law, "largest error");
    }
    TEST_ASSERT_TRUE(jump(&params, FASTEST, 0.2 * INDUCTANCE, 0.0, CURRENT, 0.0f) > 3.0);
}
