/* The start of the fixed-point loop below 20 rad/s; test_pll.c has the tests of the float loop. The
 * detector is eps = -e_d s/|e|. From a reset s is +1 or -1 (zero counts as positive) until |w_s| has
 * reached 20 rad/s; from then on it is w_s/(20 rad/s), limited to -1 to 1. */
#include "estimator/fixed/fixed.h"
#include "tests/unit/compare.h"

#define AMPLITUDE 10.0 /* [V] */

/* The value of one count (formats.h). The largest speed is one turn per period; the largest voltage is
 * U = 256 V, the power of two above k_s. */
#define SPEED_UNIT   (2.0 * PI / 1e-4 / 2147483648.0) /* [rad/s] */
#define VOLTAGE_UNIT (256.0 / 134217728.0)            /* [V] */

static pll_q_t pll;

/* The paper's motor; with a cutoff [rad/s] of 0 the loop is the conventional one. */
static void start_at(float cutoff, double speed)
{
    estimator_params_t params = {.smo = {.resistance = 0.95f,
                                         .inductance = 0.0125f,
                                         .gain = 200.0f,
                                         .slope = 1.0f,
                                         .period = 1e-4f,
                                         .switching = SMO_SIGMOID_VECTOR},
                                 .lag = LAG_EXACT,
                                 .pll = {.amplitude_floor = 2.0f},
                                 .flux_linkage = 0.183f};
    TEST_ASSERT_TRUE(pll_design(&params.pll, 200.0f, 1.0f, cutoff, 1e-4f));
    fixed_tuning_t tuning;
    fixed_prepare(&tuning, &params);
    pll_take_q(&pll, &tuning.q.pll);
    pll_reset_q(&pll, (position_q_t){.theta_e = 0x20000000u, .omega_e = (int32_t)lrint(speed / SPEED_UNIT)});
}

/* The detector after an EMF that has only a d component of this length. */
static double detector_of(double e_d)
{
    const double theta = (double)(int32_t)pll.theta_e * PI / 2147483648.0;
    const ab_q_t emf = {(int32_t)lrint(e_d * cos(theta) / VOLTAGE_UNIT),
                        (int32_t)lrint(e_d * sin(theta) / VOLTAGE_UNIT)};
    (void)pll_step_q(&pll, emf, 0, 0);
    return (double)pll.detector / 1073741824.0;
}

/* w_s [rad/s]. */
static double smooth_speed(void)
{
    return (double)pll.omega_smooth * SPEED_UNIT;
}

static void test_a_slow_start_has_a_direction_and_the_whole_gain(void)
{
    static const double speeds[] = {-20.1, -19.0, -5.0, -0.1, 0.0, 0.1, 5.0, 19.0, 20.1};
    for (int n = 0; n < 18; n++) {
        const double way = speeds[n / 2] < 0.0 ? -1.0 : 1.0;
        start_at(n % 2 == 0 ? 0.0f : 50.0f, speeds[n / 2]);
        for (int k = 0; k < 3; k++) {
            TEST_ASSERT_DOUBLE_WITHIN(1e-6, way, detector_of(-AMPLITUDE));
        }
    }
}

/* The speed rises for a while and falls again: the loop gains and loses ki T = 0.27 rad/s per step. */
static void test_the_direction_of_a_start_ends_at_20_rad_s(void)
{
    for (double way = -1.0; way <= 1.0; way += 2.0) {
        int steps = 0;
        start_at(0.0f, 15.0 * way);
        while (fabs(smooth_speed()) < 20.5) {
            TEST_ASSERT_DOUBLE_WITHIN(1e-6, way, detector_of(-AMPLITUDE));
            TEST_ASSERT_TRUE(++steps < 100);
        }
        while (fabs(smooth_speed()) > 10.0) {
            const double share = fmin(1.0, fabs(smooth_speed()) / 20.0);
            TEST_ASSERT_DOUBLE_WITHIN(1e-4, -way * share, detector_of(AMPLITUDE));
            TEST_ASSERT_TRUE(++steps < 300);
        }
    }
}

/* Without a direction of the start, while the speed falls from above 20 rad/s; at standstill the detector
 * is zero (pll.h). */
static void test_a_loop_that_turns_has_the_sign_of_its_speed(void)
{
    for (double way = -1.0; way <= 1.0; way += 2.0) {
        start_at(0.0f, 21.0 * way);
        while (fabs(smooth_speed()) > 0.5) {
            const double share = fmin(1.0, fabs(smooth_speed()) / 20.0);
            TEST_ASSERT_DOUBLE_WITHIN(1e-4, -way * share, detector_of(AMPLITUDE));
        }
    }
}
