/* A q axis that saturates: its table, the estimator with exact data of such a rotor, and the i_d of most
 * torque per ampere. The rotor has L_d 20 mH, psi_q = 0.08 i_q/sqrt(1 + (i_q/8)^2), psi_f 0.3 Wb, and a
 * very small R. The voltage follows exactly from the change of the flux: u = (psi(k) - psi(k-1))/T + R i. */
#include <complex.h>

#include "estimator/saturation.h"
#include "settings/params.h"
#include "tests/unit/estimator_bench.h"
#include "tests/unit/vectors.h"

#define L_D     0.02
#define L_0     0.08
#define I_S     8.0
#define FLUX    0.3
#define CURRENT 12.0
#define R       1e-3
#define MIDDLE  9.6 /* [A] i_q at which the constant L_q is taken */

/* The law of the drive. */
static double flux_q(double i_q)
{
    return L_0 * i_q / hypot(1.0, i_q / I_S);
}

/* Another law with three parameters, part of which never saturates: psi_q = L_s i_q + (L_1 - L_s) i_q/(1 +
 * (i_q/I_1)^2). The two parameters of the drive are fitted to it, within 1 % of psi_q up to 15 A. */
static double flux_other(double i_q)
{
    return i_q * (0.019 + 0.061 / (1.0 + i_q * i_q / (10.1 * 10.1)));
}

static double (*flux_true)(double i_q) = flux_q;

static double constant(void)
{
    return flux_q(MIDDLE) / MIDDLE;
}

static saturation_params_t law(void)
{
    return (saturation_params_t){.inductance = (float)constant(),
                                 .bend = (float)(L_0 / constant() - 1.0),
                                 .current = (float)I_S,
                                 .current_max = 15.0f};
}

static void test_the_table_is_the_law_within_half_a_percent(void)
{
    const saturation_params_t params = law();
    const saturation_t table = saturation_prepare(&params);
    for (int n = -300; n <= 300; n++) {
        const double i_q = 0.05 * n;
        const saturation_point_t point = saturation_at(&table, (float)i_q);
        const double held = (constant() + (double)point.excess) * i_q;
        /* The table is linear between points 0.94 A apart: an error of (0.94 A)^2/8 times the largest
         * curvature, L_0/I_s^2. */
        TEST_ASSERT_DOUBLE_WITHIN(0.94 * 0.94 / 8.0 * L_0 / (I_S * I_S) * fabs(i_q) + 1e-6, flux_q(i_q),
                                  held);
    }
    TEST_ASSERT_EQUAL_FLOAT(table.excess[16], saturation_at(&table, 40.0f).excess);
    TEST_ASSERT_EQUAL_FLOAT(0.0f, saturation_at(&table, -40.0f).slope);
}

static void test_the_slope_is_that_of_the_table(void)
{
    const saturation_params_t params = law();
    const saturation_t table = saturation_prepare(&params);
    for (int n = 0; n < 16; n++) {
        const float a = ((float)n + 0.25f) * 15.0f / 16.0f;
        const float b = ((float)n + 0.75f) * 15.0f / 16.0f;
        const float rise = saturation_at(&table, -b).excess - saturation_at(&table, a).excess;
        TEST_ASSERT_FLOAT_WITHIN(1e-5f, rise / (b - a), saturation_at(&table, a).slope);
        TEST_ASSERT_TRUE(rise < 0.0f);
    }
}

static void test_without_a_saturation_current_nothing_is_added(void)
{
    const saturation_params_t none = {.inductance = 0.02f};
    const saturation_t table = saturation_prepare(&none);
    TEST_ASSERT_FALSE(saturation_is_on(&table));
    for (float i_q = -50.0f; i_q <= 50.0f; i_q += 2.5f) {
        const saturation_point_t point = saturation_at(&table, i_q);
        TEST_ASSERT_EQUAL_FLOAT(0.0f, point.excess);
        TEST_ASSERT_EQUAL_FLOAT(0.0f, point.slope);
    }
    TEST_ASSERT_EQUAL_FLOAT(1.0f, saturation_share(&none, 10.0f));
}

/* ---- the estimator ---- */

static double theta, omega;
static double complex flows;

static double complex linkage(double complex current)
{
    const double complex inside = current * cexp(-J * theta);
    return (FLUX + L_D * creal(inside) + J * flux_true(cimag(inside))) * cexp(J * theta);
}

static void given(double speed, bool bent)
{
    omega = speed;
    theta = 0.3;
    flows = 0.0;
    estimator_params_t params = {.smo = {.resistance = (float)R,
                                         .inductance = (float)constant(),
                                         .gain = 800.0f,
                                         .slope = (float)(1.6 * constant() / (800.0 * T)),
                                         .emf_cutoff = 2500.0f,
                                         .period = (float)T,
                                         .switching = SMO_SIGMOID_VECTOR},
                                 .lag = LAG_EXACT,
                                 .pll = {.amplitude_floor = (float)(11.0 * FLUX)},
                                 .flux_linkage = (float)FLUX,
                                 .saliency = (float)(constant() - L_D)};
    if (bent) {
        params.saturation = law();
    }
    tune(&params, 313.0, 31.0);
    init(&params);
}

/* Simulates a period with this current in the frame of the estimator [A]; returns the error of the angle
 * [mrad]. */
static double period(double i_d, double i_q)
{
    const double complex next = (i_d + J * i_q) * cexp(J * (double)est.tracker.pll.theta_e);
    const double complex before = linkage(flows);
    theta += omega * T;
    const double complex voltage = (linkage(next) - before) / T + R * 0.5 * (flows + next);
    const double now[2] = {creal(next), cimag(next)};
    const double held[2] = {creal(voltage), cimag(voltage)};
    flows = next;
    return 1e3 * circle((double)estimator_step(&est, as_float(held), as_float(now)).theta_e - theta);
}

static void locked(double i_d, double i_q)
{
    flows = (i_d + J * i_q) * cexp(J * theta);
    const double now[2] = {creal(flows), cimag(flows)};
    estimator_reset(&est, (position_t){(float)circle(theta), (float)omega}, as_float(now));
}

/* The i_d of most torque at this length of the current, found by trial. */
static double most_torque(double current)
{
    double most = 0.0;
    double best = 0.0;
    for (int n = 0; n <= 20000; n++) {
        const double i_d = -current * n / 20000.0;
        const double i_q = sqrt(current * current - i_d * i_d);
        const double torque = (FLUX + L_D * i_d) * i_q - flux_q(i_q) * i_d;
        best = torque > most ? i_d : best;
        most = fmax(torque, most);
    }
    return best;
}

/* The remaining error is that of the interpolation: 0.5 % of psi_q, divided by psi_a. */
static void test_right_data_leave_only_the_table(void)
{
    static const double currents[] = {3.0, 6.0, 9.0, 12.0, 15.0};
    for (int way = -1; way <= 1; way += 2) {
        for (size_t n = 0; n < sizeof currents / sizeof currents[0]; n++) {
            given(300.0, true);
            const double i_d = most_torque(currents[n]);
            const double i_q = way * sqrt(currents[n] * currents[n] - i_d * i_d);
            locked(i_d, i_q);
            double largest = 0.0;
            for (int k = 0; k < 4000; k++) {
                const double error = period(i_d, i_q);
                largest = k < 2000 ? 0.0 : fmax(largest, fabs(error));
            }
            check_below(largest, 6.0, "steady error");
        }
    }
}

/* The iron obeys another law than that of the drive's two parameters (line A12 of docs/salient.md). The
 * remaining error is that of psi_q divided by psi_a. */
static void test_two_parameters_are_enough_for_another_law(void)
{
    flux_true = flux_other;
    double worst = 0.0;
    for (double current = 3.0; current <= 15.0; current += 1.5) {
        given(300.0, true);
        const double i_d = most_torque(current);
        const double i_q = sqrt(current * current - i_d * i_d);
        locked(i_d, i_q);
        double mean = 0.0;
        for (int k = 0; k < 4000; k++) {
            const double error = period(i_d, i_q);
            mean += k < 3000 ? 0.0 : error / 1000.0;
        }
        printf("%g A: psi_q %.2f %% apart, error %.1f mrad\n", current,
               100.0 * (flux_other(i_q) / flux_q(i_q) - 1.0), mean);
        worst = fmax(worst, fabs(mean));
    }
    flux_true = flux_q;
    check_line(worst, 25.0, "A12 another law");
}

/* With the constant L_q alone the error is (L_q - psi_q/i_q) i_q/psi_a, tens of mrad, which shows that the
 * table is needed. */
static void test_without_the_table_the_error_is_that_of_the_inductance(void)
{
    given(300.0, false);
    const double i_q = 0.5;
    locked(0.0, i_q);
    double mean = 0.0;
    for (int k = 0; k < 4000; k++) {
        const double error = period(0.0, i_q);
        mean += k < 3000 ? 0.0 : error / 1000.0;
    }
    const double expected = 1e3 * (flux_q(i_q) - constant() * i_q) / FLUX;
    TEST_ASSERT_TRUE(expected > 40.0);
    TEST_ASSERT_DOUBLE_WITHIN(0.1 * expected, expected, mean);
}

/* The torque steps within one sample, and its voltage is known on both axes. Without the part of psi_q the
 * observer would receive an EMF of 0.1 Wb/0.1 ms. */
static void test_a_torque_step_moves_the_angle_little(void)
{
    given(300.0, true);
    const double i_d = most_torque(CURRENT);
    const double i_q = sqrt(CURRENT * CURRENT - i_d * i_d);
    locked(0.0, 0.0);
    double largest = 0.0;
    for (int k = 0; k < 3000; k++) {
        const double error = k < 1000 ? period(0.0, 0.0) : period(i_d, i_q);
        largest = fmax(largest, fabs(error));
    }
    check_below(largest, 15.0, "torque step");
}

/* ---- the parameters ---- */

static params_t motor(void)
{
    params_t params;
    params_defaults(&params);
    params.motor_inductance_d = (float)L_D;
    params.motor_inductance_q = (float)L_0;
    params.motor_flux_linkage = (float)FLUX;
    params.motor_saturation_current = (float)I_S;
    params.current_limit = (float)CURRENT;
    params.overcurrent_trip = 18.0f;
    params.overspeed_trip = 100.0f;
    return params;
}

static void test_the_drive_takes_the_current_of_most_torque(void)
{
    params_t params = motor();
    params_error_t why;
    TEST_ASSERT_TRUE(params_check(&params, &why));
    const assumed_t assumed = params_configured(&params);
    const double i_d = most_torque(CURRENT);
    TEST_ASSERT_FLOAT_WITHIN(1e-3f, (float)i_d, params_mtpa(&params, &assumed));
    const double i_q = sqrt(CURRENT * CURRENT - i_d * i_d);
    const double torque = 1.5 * 4.0 * ((FLUX + L_D * i_d) * i_q - flux_q(i_q) * i_d);
    TEST_ASSERT_FLOAT_WITHIN(1e-3f * (float)torque, (float)torque, params_torque_most(&params, &assumed));
}

static void test_a_start_has_the_current_of_the_unsaturated_rotor(void)
{
    const params_t params = motor();
    const assumed_t assumed = params_configured(&params);
    /* 0.8 psi_f/(L_0 - L_d), because the rotor stands along the current and i_q is zero. */
    TEST_ASSERT_FLOAT_WITHIN(1e-3f, (float)(0.8 * FLUX / (L_0 - L_D)),
                             params_start(&params, &assumed).current);
}

static void test_a_saturation_below_the_current_limit_is_refused_with_both_rows(void)
{
    params_t params = motor();
    params_error_t why;
    params.motor_saturation_current = 4.0f;
    TEST_ASSERT_FALSE(params_check(&params, &why));
    TEST_ASSERT_EQUAL_STRING("motor_saturation_current", why.field);
    TEST_ASSERT_FLOAT_WITHIN(1e-4f, 0.4f * (float)CURRENT, why.min);
    params.motor_saturation_current = 1e-30f;
    TEST_ASSERT_FALSE(params_check(&params, &why));
    params.motor_saturation_current = 0.4f * (float)CURRENT;
    TEST_ASSERT_TRUE(params_check(&params, &why));
}

/* L_0/L_d is 8, but at 0.8 of the limit the ratios are 4.9 and 3.8: the inductance at that current
 * decides. */
static void test_the_ratio_that_counts_is_that_under_load(void)
{
    params_t params = motor();
    params_error_t why;
    params.motor_inductance_d = 0.01f;
    params.motor_saturation_current = 7.5f;
    TEST_ASSERT_FALSE(params_check(&params, &why));
    TEST_ASSERT_EQUAL_STRING("motor_inductance_q", why.field);
    params.motor_saturation_current = 5.0f;
    TEST_ASSERT_TRUE(params_check(&params, &why));
}
