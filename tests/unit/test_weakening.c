#include "medium/manoeuvre/weakening.h"

#include "tests/unit/compare.h"

/* A family of rotors with L_q 20 mH, psi_f 0.1 Wb and 15 A. R is zero, so that the voltage is speed times
 * flux. */
#define FLUX    0.1
#define L_Q     20e-3
#define CURRENT 15.0
#define U_DC    300.0
#define USE     0.5
#define PERIOD  0.8e-3

static const double ratios[] = {1.0, 1.5, 2.0, 3.0, 4.0};
#define RATIOS (sizeof ratios / sizeof ratios[0])

static weakening_t weakening;
static double l_d, saliency;

static double mtpa(void)
{
    return -2.0 * saliency * CURRENT * CURRENT /
           (FLUX + sqrt(FLUX * FLUX + 8.0 * saliency * saliency * CURRENT * CURRENT));
}

static void begin_with(double ratio, double resistance, double current)
{
    l_d = L_Q / ratio;
    saliency = L_Q - l_d;
    const weakening_params_t params = {
        .flux_linkage = (float)FLUX,
        .inductance_d = (float)l_d,
        .inductance_q = (float)L_Q,
        .resistance = (float)resistance,
        .current_max = (float)current,
        .i_d_mtpa = (float)mtpa(),
        .use = (float)USE,
        .period = (float)PERIOD,
    };
    const weakening_tuning_t tuning = weakening_prepare(&params);
    weakening_init(&weakening, &tuning);
}

static void begin(double ratio, double resistance)
{
    begin_with(ratio, resistance, CURRENT);
}

static void look(double omega)
{
    weakening_look(&weakening, (float)U_DC, (float)omega, (dq_t){(float)(USE * U_DC), 0.0f});
}

/* Returns the largest torque at this flux [Wb], divided by 1.5 p psi_f [A]. Every i_d within the current
 * limit is tried. */
static double most_torque(double flux)
{
    double most = 0.0;
    for (int n = 0; n <= 60000; n++) {
        const double i_d = -CURRENT * n / 60000.0;
        const double flux_d = FLUX + l_d * i_d;
        const double square =
            fmin((flux * flux - flux_d * flux_d) / (L_Q * L_Q), CURRENT * CURRENT - i_d * i_d);
        if (square > 0.0) {
            most = fmax(most, sqrt(square) * (1.0 - saliency / FLUX * i_d));
        }
    }
    return most;
}

/* The flux goes up to six times the smallest one, in both directions: current limit, voltage ellipse, and
 * the range in which MTPV is within 15 A. */
static void test_the_most_torque_is_that_of_trying_every_i_d(void)
{
    for (unsigned n = 0; n < RATIOS; n++) {
        begin(ratios[n], 0.0);
        for (double omega = 300.0; omega < 4000.0; omega *= 1.3) {
            for (int way = -1; way <= 1; way += 2) {
                weakening.looks = 0u; /* the low-pass begins again */
                look(way * omega);
                if (weakening.looks == 0u) {
                    continue;
                }
                const double most = most_torque(USE * U_DC / omega);
                TEST_ASSERT_DOUBLE_WITHIN(1e-3 * most + 1e-4, most, (double)weakening.torque_limit);
                TEST_ASSERT_TRUE((double)weakening.i_d_limit >= -CURRENT);
            }
        }
    }
}

/* Any torque up to the largest one is made with the i_d of most torque per ampere if the voltage allows
 * it. Otherwise i_d is on the voltage ellipse, within a thousandth of its flux. */
static void test_a_torque_takes_no_more_i_d_than_the_voltage_needs(void)
{
    for (unsigned n = 0; n < RATIOS; n++) {
        begin(ratios[n], 0.0);
        for (double omega = 600.0; omega < 4000.0; omega *= 1.4) {
            weakening.looks = 0u;
            look(omega);
            const double flux = USE * U_DC / omega;
            for (int part = 0; part <= 10; part++) {
                const double torque = 0.1 * part * (double)weakening.torque_limit;
                const double i_d = (double)weakening_i_d(&weakening, (float)torque, -0.5f, (float)omega);
                const double i_q = torque / (1.0 - saliency / FLUX * i_d);
                const double taken = hypot(FLUX + l_d * i_d, L_Q * i_q);
                TEST_ASSERT_TRUE(taken <= flux * (1.0 + 1e-3));
                if (weakening.weakens != 0u) {
                    TEST_ASSERT_DOUBLE_WITHIN(2e-3 * flux + 4e-3 * l_d, flux, taken);
                } else {
                    TEST_ASSERT_EQUAL_FLOAT(-0.5f, (float)i_d);
                }
            }
        }
    }
}

static void test_i_d_is_the_same_in_every_quarter(void)
{
    begin(3.0, 0.0);
    for (int n = 0; n < 4; n++) {
        const float way = (n & 1) != 0 ? -1.0f : 1.0f;
        const float torque = (n & 2) != 0 ? -4.0f : 4.0f;
        weakening.looks = 0u;
        look((double)(way * 1500.0f));
        static float first;
        const float i_d = weakening_i_d(&weakening, torque, 0.0f, way * 1500.0f);
        first = n == 0 ? i_d : first;
        TEST_ASSERT_TRUE(i_d < -1.0f);
        TEST_ASSERT_EQUAL_FLOAT(first, i_d);
    }
}

/* If (psi_f + L_q I) omega + R I is below the voltage, nothing is changed. */
static void test_below_the_voltage_nothing_is_weakened(void)
{
    begin(2.0, 1.0);
    const double free = (USE * U_DC - CURRENT) / (FLUX + L_Q * CURRENT);
    look(0.99 * free);
    TEST_ASSERT_TRUE(weakening.looks == 0u);
    TEST_ASSERT_EQUAL_FLOAT(1.5f, weakening_i_d(&weakening, 20.0f, 1.5f, 100.0f));
    look(1.01 * free);
    TEST_ASSERT_TRUE(weakening.looks != 0u);
}

static void test_off_is_off(void)
{
    begin(2.0, 1.0);
    weakening.tuning.use = 0.0f;
    look(4000.0);
    TEST_ASSERT_TRUE(weakening.looks == 0u);
    TEST_ASSERT_EQUAL_FLOAT(0.0f, weakening_i_d(&weakening, 20.0f, 0.0f, 4000.0f));
}

/* R takes 15 A of 1 ohm along the EMF: the available flux is smaller while driving and larger while
 * braking. */
static void test_the_drop_of_r_counts_in_the_direction_of_the_emf(void)
{
    begin(1.0, 1.0);
    double seen[2];
    for (int n = 0; n < 2; n++) {
        const float torque = n == 0 ? 3.0f : -3.0f;
        weakening.looks = 0u;
        for (int k = 0; k < 40; k++) {
            look(1500.0);
            weakening.trim = 0.0f;
            (void)weakening_i_d(&weakening, torque, 0.0f, 1500.0f);
        }
        seen[n] = (double)weakening_i_d(&weakening, torque, 0.0f, 1500.0f);
        /* The voltage is |R i + j omega psi_s|. */
        const double i_q = (double)torque;
        const double u_d = seen[n] - 1500.0 * L_Q * i_q;
        const double u_q = i_q + 1500.0 * (FLUX + l_d * seen[n]);
        TEST_ASSERT_DOUBLE_WITHIN(0.01 * USE * U_DC, USE * U_DC, hypot(u_d, u_q));
    }
    TEST_ASSERT_TRUE(seen[0] < seen[1] - 0.1);
}

/* The requested voltage reaches u with any configured data: if psi_f is 10 % larger than configured, the
 * trim is about -0.05. */
static void test_the_trim_brings_the_voltage_to_its_share(void)
{
    begin(2.0, 0.0);
    weakening.looks = 0u;
    double asked = 0.0;
    float i_d = 0.0f;
    for (int k = 0; k < 400; k++) {
        const double i_q = 2.0 / (1.0 - saliency / FLUX * (double)i_d);
        const double flux = hypot(1.1 * FLUX + l_d * (double)i_d, L_Q * i_q);
        asked = 1500.0 * flux;
        weakening_look(&weakening, (float)U_DC, 1500.0f, (dq_t){(float)asked, 0.0f});
        i_d = weakening_i_d(&weakening, 2.0f, 0.0f, 1500.0f);
    }
    TEST_ASSERT_DOUBLE_WITHIN(1e-3 * USE * U_DC, USE * U_DC, asked);
    TEST_ASSERT_TRUE(weakening.trim < -0.02f && weakening.trim > -0.25f);
    for (int k = 0; k < 400; k++) { /* the voltage does not depend on i_d, and the trim reaches its end */
        weakening_look(&weakening, (float)U_DC, 1500.0f, (dq_t){1e3f, 0.0f});
        (void)weakening_i_d(&weakening, 2.0f, 0.0f, 1500.0f);
    }
    TEST_ASSERT_EQUAL_FLOAT(-0.25f, weakening.trim);
}

/* At 1400 rad/s 150 V permit 107 mWb: the configured 100 mWb need no weakening, the true 120 mWb do. The
 * requested voltage alone shows it, 168 V. */
static void test_the_voltage_alone_begins_the_weakening(void)
{
    begin(2.0, 0.0);
    double asked = 0.0;
    float i_d = 0.0f;
    for (int k = 0; k < 400; k++) {
        asked = 1400.0 * (1.2 * FLUX + l_d * (double)i_d);
        weakening_look(&weakening, (float)U_DC, 1400.0f, (dq_t){0.0f, (float)asked});
        i_d = weakening_i_d(&weakening, 0.0f, 0.0f, 1400.0f);
    }
    TEST_ASSERT_DOUBLE_WITHIN(0.01 * USE * U_DC, USE * U_DC, asked);
    TEST_ASSERT_TRUE(i_d < -1.0f);
}

/* At 1350 rad/s 150 V permit 111 mWb. The configured 100 mWb and the 10 mWb of 0.5 A permit any current, but
 * the true 120 mWb need 162 V. A trim of -0.25 leaves 83 mWb, for which -1.7 A would be needed: i_d reaches
 * the limit of the current. */
static void test_the_voltage_begins_the_weakening_where_the_configured_flux_permits_any_current(void)
{
    begin_with(2.0, 0.0, 0.5);
    weakening.tuning.i_d_mtpa = 0.0f;
    float i_d = 0.0f;
    for (int k = 0; k < 400; k++) {
        const double asked = 1350.0 * (1.2 * FLUX + l_d * (double)i_d);
        weakening_look(&weakening, (float)U_DC, 1350.0f, (dq_t){0.0f, (float)asked});
        i_d = weakening_i_d(&weakening, 0.0f, 0.0f, 1350.0f);
    }
    TEST_ASSERT_DOUBLE_WITHIN(0.01, -0.5, (double)i_d);
    for (int k = 0; k < 100; k++) { /* below the voltage nothing remains */
        weakening_look(&weakening, (float)U_DC, 1200.0f, (dq_t){0.0f, 144.0f});
        i_d = weakening_i_d(&weakening, 0.0f, 0.0f, 1200.0f);
    }
    TEST_ASSERT_EQUAL_FLOAT(0.0f, i_d);
}
