/* Saturation of the iron: the limit case without it, the law of the flux, and the convergence of the
 * steps. */
#include <math.h>
#include <string.h>

#include "host_sim/plant/flux_map.h"
#include "tests/plant/bench.h"
#include "unity.h"

#define BENT "inductance_d = 0.02, inductance_q = 0.04, inertia = 0.003"

/* The control loop accelerates from rest towards 150 rad/s for this number of periods; the time between
 * two edges is divided into this number of parts. */
static plant_truth_t drive(const plant_params_t *q, int periods, uint32_t parts)
{
    setUp();
    plant_init(&plant, q, 1);
    loop.i_d_ref = -5.0;
    loop.parts = parts;
    for (int k = 0; k < periods; k++) {
        const double wish = 0.5 * (150.0 - plant.omega_m);
        loop.i_q_ref = wish > 12.0 ? 12.0 : wish;
        loop_period(&loop, &plant, NULL, NULL);
    }
    return truth();
}

static double apart(const plant_truth_t *one, const plant_truth_t *other)
{
    return fmax(fabs(one->i_d - other->i_d), fabs(one->i_q - other->i_q));
}

static void test_a_current_of_saturation_far_above_all_others_changes_nothing(void)
{
    const plant_params_t linear = plant_of(BENT);
    const plant_params_t bent = plant_of(BENT ", saturation_d = 10000, saturation_q = 10000");
    const plant_truth_t one = drive(&linear, 400, 0u);
    const plant_truth_t other = drive(&bent, 400, 0u);
    TEST_ASSERT_TRUE(fabs(one.i_q) > 5.0);
    /* The saturation changes the flux by a share of (12 A/10 kA)^2/2 = 7e-7. */
    TEST_ASSERT_TRUE(apart(&one, &other) < 1e-4);
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, one.omega_m, other.omega_m);
    TEST_ASSERT_DOUBLE_WITHIN(1e-4 * one.energy_magnetic, one.energy_magnetic, other.energy_magnetic);
}

/* The method is of fourth order: with steps of a quarter the length the error is negligible, so that the
 * difference is the error of the longer steps. */
static void test_shorter_steps_change_nothing(void)
{
    const plant_params_t bent =
        plant_of(BENT ", saturation_d = 8, saturation_q = 8, turn_on_delay = 0, "
                      "turn_off_delay = 0, shaft_locked = 1, shaft_locked_speed = 100");
    const plant_truth_t whole = drive(&bent, 300, 0u);
    const plant_truth_t parts = drive(&bent, 300, 4u);
    TEST_ASSERT_TRUE(fabs(whole.i_q) > 5.0);
    TEST_ASSERT_TRUE(apart(&whole, &parts) < 1e-4);
}

/* The dynamometer holds the shaft at standstill, and the current is constant: T = 1.5 p (psi_f i_q +
 * (L_d(i_d) - L_q(i_q)) i_d i_q) with the apparent inductances of the law. */
static void test_torque_is_that_of_the_apparent_inductances(void)
{
    const plant_params_t q = plant_of(BENT ", saturation_d = 8, saturation_q = 8, " NO_DROPS
                                           ", shaft_locked = 1, shaft_locked_speed = 0");
    setUp();
    plant_init(&plant, &q, 1);
    loop.i_d_ref = -6.0;
    loop.i_q_ref = 9.0;
    for (int k = 0; k < 4000; k++) {
        loop_period(&loop, &plant, NULL, NULL);
    }
    const plant_truth_t now = truth();
    TEST_ASSERT_DOUBLE_WITHIN(0.2, -6.0, now.i_d);
    TEST_ASSERT_DOUBLE_WITHIN(0.2, 9.0, now.i_q);
    const double along = 0.02 / sqrt(1.0 + now.i_d * now.i_d / 64.0);
    const double across = 0.04 / sqrt(1.0 + now.i_q * now.i_q / 64.0);
    const double torque = 1.5 * 4.0 * (0.183 * now.i_q + (along - across) * now.i_d * now.i_q);
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, torque, now.torque);
}

/* A voltage drives a winding with almost no resistance: the current must belong to the flux psi = integral
 * of u. */
static void test_a_constant_voltage_makes_the_flux_of_its_integral(void)
{
    plant_params_t q =
        plant_of(BENT ", saturation_d = 8, saturation_q = 8, " NO_DROPS
                      ", resistance = 0, flux_linkage = 0, shaft_locked = 1, shaft_locked_speed = 0, "
                      "turn_on_delay = 0, turn_off_delay = 0, short_circuit_current = 0");
    plant_init(&plant, &q, 1);
    plant_gates(&plant, 0, PLANT_UPPER(0) | PLANT_LOWER(1) | PLANT_LOWER(2));
    uint64_t tick = 0;
    for (int k = 0; k < 8; k++) {
        tick += 10000u;
        const plant_truth_t now = truth_at(tick);
        TEST_ASSERT_DOUBLE_WITHIN(1e-6, 0.02 * now.i_d / sqrt(1.0 + now.i_d * now.i_d / 64.0),
                                  now.flux_alpha);
        /* Only the field stores energy: 1.5 (psi i - L I_s^2 (sqrt(1 + (i/I_s)^2) - 1)). */
        const double root = sqrt(1.0 + now.i_d * now.i_d / 64.0);
        TEST_ASSERT_DOUBLE_WITHIN(1e-6, 1.5 * (now.flux_alpha * now.i_d - 0.02 * 64.0 * (root - 1.0)),
                                  now.energy_magnetic);
    }
    TEST_ASSERT_TRUE(plant.i_d > 6.0);
}

/* A winding without resistance keeps the flux that it had when it was short-circuited, psi_f in the
 * direction of the rotor at that time. After a quarter of a turn all of this flux is in the q axis, and
 * the d axis has none: i_d cancels psi_f, and i_q produces psi_f. The iron of the q axis (L_q I_s = 0.12
 * Wb) follows the law up to 6 A, where it has 0.06 x 2/sqrt(1 + 1/9) = 0.1138 Wb. Beyond 6 A the
 * incremental inductance is constant, 0.06/10^1.5 = 1.897 mH, and the remaining 0.0692 Wb need 36.5 A
 * more. Only the shaft supplies the energy of the field. */
static void test_a_short_circuit_turns_more_flux_into_an_axis_than_its_iron_carries(void)
{
    plant_params_t q = plant_of("inductance_d = 0.02, inductance_q = 0.06, saturation_q = 2, " NO_DROPS
                                ", resistance = 0, flux_linkage = 0.183, pole_pairs = 4, shaft_locked = 1, "
                                "shaft_locked_speed = 100, turn_on_delay = 0, turn_off_delay = 0, "
                                "short_circuit_current = 0");
    plant_init(&plant, &q, 1);
    plant_gates(&plant, 0, PLANT_LOWER(0) | PLANT_LOWER(1) | PLANT_LOWER(2));
    const double turn = 1.57079632679489661923; /* [rad] a quarter of a turn, at 400 rad/s */
    const plant_truth_t now = truth_at((uint64_t)(turn / 400.0 * 150e6 + 0.5));
    const double slope = 0.06 / sqrt(1000.0);
    const double full = 0.06 * 6.0 / sqrt(10.0);
    TEST_ASSERT_DOUBLE_WITHIN(2e-3, -0.183 / 0.02, now.i_d);
    TEST_ASSERT_DOUBLE_WITHIN(2e-3 * 42.5, -(6.0 + (0.183 - full) / slope), now.i_q);
    const double root = sqrt(10.0);
    const double iron = 0.06 * 36.0 / (root * (1.0 + root));
    const double energy =
        1.5 * (0.5 * 0.02 * now.i_d * now.i_d + iron + 0.5 * slope * (now.i_q * now.i_q - 36.0));
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, energy, now.energy_magnetic);
}

static void test_a_current_of_saturation_below_an_ampere_is_refused(void)
{
    plant_params_t q = plant_params_default();
    plant_params_error_t why;
    q.saturation_q = 0.5;
    TEST_ASSERT_FALSE(plant_params_check(&q, &why));
    TEST_ASSERT_EQUAL_STRING("saturation_q", why.field);
    q.saturation_q = 1.0;
    TEST_ASSERT_TRUE(plant_params_check(&q, &why));
}

/* ---- flux maps ---- */

#define MOST 71u

/* Both axes saturate together, from one energy: psi_d = L_d i_d/s, psi_q = L_q i_q/s, with the coenergy K (s
 * - 1), s^2 = 1 + (L_d i_d^2 + L_q i_q^2)/K. */
#define ALONG  0.02
#define ACROSS 0.04
#define STIFF  2.0 /* K [J], as two thirds of the energy of three phases */
#define MAGNET 0.183

static double together(double i_d, double i_q)
{
    return sqrt(1.0 + (ALONG * i_d * i_d + ACROSS * i_q * i_q) / STIFF);
}

static double own_law(double inductance, double i)
{
    return inductance * i / sqrt(1.0 + i * i / 64.0);
}

/* The number of a flux map from -15 to 15 A in steps of `step`. It is made from the coupled law of this
 * file, or from the law of BENT with an I_s of 8 A in both axes. */
static uint32_t map_of(double step, bool coupled)
{
    static double i[MOST], flux_d[MOST * MOST], flux_q[MOST * MOST];
    const uint32_t count = 1u + (uint32_t)lround(30.0 / step);
    TEST_ASSERT_TRUE(count <= MOST);
    for (uint32_t n = 0; n < count; n++) {
        i[n] = -15.0 + n * step;
    }
    for (uint32_t n = 0; n < count; n++) {
        for (uint32_t m = 0; m < count; m++) {
            const double s = together(i[n], i[m]);
            flux_d[n * count + m] = MAGNET + (coupled ? ALONG * i[n] / s : own_law(0.02, i[n]));
            flux_q[n * count + m] = coupled ? ACROSS * i[m] / s : own_law(0.04, i[m]);
        }
    }
    flux_map_error_t error;
    const uint32_t number = flux_map_add(&(flux_map_grid_t){count, count, i, i, flux_d, flux_q}, &error);
    TEST_ASSERT_TRUE_MESSAGE(number > 0u, error.rule);
    return number;
}

static plant_params_t with_map(const char *rows, uint32_t number)
{
    plant_params_t q = plant_of(rows);
    q.flux_map = number;
    return q;
}

/* The interpolation is of third order: half the step leaves an eighth of the difference or less. */
static void test_a_map_of_a_law_is_that_law(void)
{
    const plant_params_t law = plant_of(BENT ", saturation_d = 8, saturation_q = 8");
    const plant_truth_t one = drive(&law, 400, 0u);
    double last = 1.0;
    for (int n = 0; n < 2; n++) {
        const plant_params_t map = with_map(BENT, map_of(n == 0 ? 1.0 : 0.5, false));
        const plant_truth_t other = drive(&map, 400, 0u);
        const double differs = apart(&one, &other);
        TEST_ASSERT_TRUE(differs < (n == 0 ? 5e-3 : 0.3 * last) || differs < 2e-4);
        TEST_ASSERT_DOUBLE_WITHIN(1e-3 * one.energy_magnetic, one.energy_magnetic, other.energy_magnetic);
        last = differs;
    }
}

/* Without resistance and motion the flux is the integral of the voltage. This must hold at any angle of
 * the rotor, also along the line of two wires when the third is broken; and only the field takes energy. */
static void test_a_map_of_axes_that_act_on_each_other_makes_the_flux_of_the_voltage(void)
{
    for (int n = 0; n < 6; n++) {
        plant_params_t q = with_map(
            NO_DROPS
            ", resistance = 0, shaft_locked = 1, shaft_locked_speed = 0, turn_on_delay = 0, "
            "turn_off_delay = 0, short_circuit_current = 0, inductance_d = 0.02, inductance_q = 0.04",
            map_of(0.5, true));
        q.open_phase_c = n % 2;
        plant_init(&plant, &q, 1);
        plant_set_motion(&plant, 0.25 * (0.4 + 0.9 * (n / 2)), 0.0);
        plant_gates(&plant, 0, PLANT_UPPER(0) | PLANT_LOWER(1) | PLANT_LOWER(2));
        const plant_truth_t begin = truth();
        for (uint64_t tick = 20000u; tick <= 80000u; tick += 20000u) {
            const plant_truth_t now = truth_at(tick);
            const double s = together(now.i_d, now.i_q);
            const double c = cos(now.theta_e);
            const double d = sin(now.theta_e);
            const double flux_d = ALONG * now.i_d / s;
            const double flux_q = ACROSS * now.i_q / s;
            const double alpha = flux_d * c - flux_q * d;
            const double beta = flux_d * d + flux_q * c;
            /* The direction (cos -30 deg, sin -30 deg), in which a and b carry opposite currents. */
            const double line = sqrt(0.75);
            const double more_alpha = now.flux_alpha - begin.flux_alpha;
            const double more_beta = now.flux_beta - begin.flux_beta;
            if (n % 2 == 0) {
                TEST_ASSERT_DOUBLE_WITHIN(2e-5, more_alpha, alpha);
                TEST_ASSERT_DOUBLE_WITHIN(2e-5, more_beta, beta);
            } else {
                TEST_ASSERT_DOUBLE_WITHIN(2e-5, line * more_alpha - 0.5 * more_beta,
                                          line * alpha - 0.5 * beta);
            }
            const double energy = 1.5 * (flux_d * now.i_d + flux_q * now.i_q - STIFF * (s - 1.0));
            TEST_ASSERT_DOUBLE_WITHIN(1e-3 * energy + 1e-6, energy, now.energy_magnetic);
        }
        TEST_ASSERT_TRUE(hypot(plant.i_d, plant.i_q) > 1.5);
    }
}

static void test_a_flux_linkage_that_is_not_that_of_the_map_is_refused(void)
{
    plant_params_t q = with_map("", map_of(1.0, true));
    plant_params_error_t why;
    TEST_ASSERT_TRUE(plant_params_check(&q, &why));
    q.flux_linkage = 0.17;
    TEST_ASSERT_FALSE(plant_params_check(&q, &why));
    TEST_ASSERT_EQUAL_STRING("flux_linkage", why.field);
    q.flux_map = 31.0;
    TEST_ASSERT_FALSE(plant_params_check(&q, &why));
    TEST_ASSERT_EQUAL_STRING("flux_map", why.field);
}

#define IRON  150.0 /* [ohm] resistance of the iron R_c */
#define LOSSY BENT ", iron_loss_resistance = 150, " NO_DROPS ", shaft_locked = 1, shaft_locked_speed = 100"

/* The terminals are open and then short-circuited, at 400 rad/s. The expected values solve u = R i + j
 * omega psi with i = o + j omega psi/R_c by hand for o, the current that makes the flux. The power of the
 * shaft is the loss in R and R_c. */
static void test_the_iron_brakes_and_takes_its_current(void)
{
    const double omega = 400.0;
    const double g = omega / IRON;
    const plant_params_t q = begin(plant_of(LOSSY));
    const double open_d = q.flux_linkage / (1.0 + g * g * q.inductance_d * q.inductance_q);
    const double open_q = -q.inductance_q * g * open_d;
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, -6.0 * g * (open_d * open_d + open_q * open_q), truth_at(1000u).torque);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, omega * hypot(open_d, open_q), hypot(truth().u_alpha, truth().u_beta));

    plant_gates(&plant, 1000u, PLANT_LOWER(0) | PLANT_LOWER(1) | PLANT_LOWER(2));
    const plant_truth_t now = truth_at(150000000u);
    const double more = 1.0 + q.resistance / IRON;
    const double across = omega * more * q.inductance_q / q.resistance;
    const double along = omega * more * q.inductance_d / q.resistance;
    const double o_q = -omega * more * q.flux_linkage / q.resistance / (1.0 + across * along);
    const double o_d = across * o_q;
    const double psi_d = q.flux_linkage + q.inductance_d * o_d;
    const double psi_q = q.inductance_q * o_q;
    TEST_ASSERT_DOUBLE_WITHIN(2e-4, o_d - g * psi_q, now.i_d);
    TEST_ASSERT_DOUBLE_WITHIN(2e-4, o_q + g * psi_d, now.i_q);
    const double heat = 1.5 * (q.resistance * (now.i_d * now.i_d + now.i_q * now.i_q) +
                               omega * omega / IRON * (psi_d * psi_d + psi_q * psi_q));
    TEST_ASSERT_DOUBLE_WITHIN(1e-3 * heat, heat, -100.0 * now.torque);
}

static void test_a_resistance_of_the_iron_that_is_far_above_all_others_changes_nothing(void)
{
    const plant_params_t none = plant_of(BENT);
    const plant_params_t high = plant_of(BENT ", iron_loss_resistance = 1e6");
    const plant_truth_t one = drive(&none, 400, 0u);
    const plant_truth_t other = drive(&high, 400, 0u);
    TEST_ASSERT_TRUE(fabs(one.i_q) > 5.0);
    TEST_ASSERT_TRUE(apart(&one, &other) < 3e-4); /* omega psi/R_c is 2e-4 A */
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, one.omega_m, other.omega_m);
}

static void test_a_resistance_of_the_iron_below_ten_ohm_is_refused(void)
{
    plant_params_t q = plant_params_default();
    plant_params_error_t why;
    q.iron_loss_resistance = 9.0;
    TEST_ASSERT_FALSE(plant_params_check(&q, &why));
    TEST_ASSERT_EQUAL_STRING("iron_loss_resistance", why.field);
}
