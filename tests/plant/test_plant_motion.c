/* Shaft and windings compared with closed forms. */
#include <math.h>
#include <string.h>

#include "tests/plant/bench.h"
#include "unity.h"

#define SECOND PLANT_TICKS_PER_SECOND
#define PI     3.14159265358979323846

static plant_params_t ideal(void)
{
    return plant_of("turn_on_delay = 0, turn_off_delay = 0, " NO_DROPS
                    ", current_zone = 0, short_circuit_current = 0, fault_pulse = 0");
}

static void test_rotor_coasts_down_on_the_exponential_of_dry_and_viscous_friction(void)
{
    plant_params_t q = begin(plant_of("friction_viscous = 0.01"));
    plant_set_motion(&plant, 0.0, 150.0);
    /* The solution of J w' = -T_c - B w is w = (w_0 + T_c/B) exp(-B t/J) - T_c/B. */
    for (int k = 1; k <= 5; k++) {
        double t = 0.5 * k;
        double shift = q.friction_coulomb / q.friction_viscous;
        double omega = (150.0 + shift) * exp(-q.friction_viscous * t / q.inertia) - shift;
        plant_truth_t now = truth_at((uint64_t)k * SECOND / 2u);
        /* The error of the midpoint rule is (B h/J)^2/24 of the change, 1e-11; the limit is for the
         * rounding of 25000 steps. */
        TEST_ASSERT_DOUBLE_WITHIN(1e-7, omega, now.omega_m);
        TEST_ASSERT_EQUAL_DOUBLE(0.0, now.i_a);
        TEST_ASSERT_EQUAL_DOUBLE(0.0, now.torque);
        TEST_ASSERT_EQUAL_DOUBLE(PLANT_LEG_OPEN, now.leg_a);
    }
}

static void test_rotor_comes_to_rest_and_stays(void)
{
    begin(plant_of("inertia = 0.003, load_torque = 5"));
    plant_set_motion(&plant, 0.0, 20.0);
    /* The width of the smooth friction is w = 2e-4 x 6.32/0.003 = 0.42 rad/s. Above it the friction is
     * complete, and the speed falls by 6.32/0.003 per second. Within it the speed must decay: within 40
     * periods to a millionth of w, and never backwards by more than a thousandth of w. */
    double w = 2e-4 * 6.32 / 0.003;
    double before = 20.0;
    for (int k = 1; k <= 1000; k++) {
        double omega = truth_at((uint64_t)k * 15000u).omega_m;
        if (before > 2.0 * w) {
            TEST_ASSERT_DOUBLE_WITHIN(1e-9, before - 6.32 / 0.003 * 1e-4, omega);
        }
        TEST_ASSERT_TRUE(omega > -1e-3 * w);
        before = omega;
        if (k > 140) {
            TEST_ASSERT_DOUBLE_WITHIN(1e-6 * w, 0.0, omega);
        }
    }
}

static void test_load_below_friction_makes_the_rotor_creep_slower_than_the_width(void)
{
    plant_params_t q = plant_of("load_kind = 1");
    q.load_torque = 0.66; /* half of the friction, since x (3 - x^2)/2 = 1/2 at x = 0.347296 */
    plant_init(&plant, &q, 1);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, -0.3472964 * PLANT_SHAFT_WIDTH, truth_at(2u * SECOND).omega_m);
}

static void test_phasor_keeps_to_the_angle_however_long_the_run(void)
{
    begin(plant_of("shaft_locked = 1, shaft_locked_speed = 249"));
    for (uint64_t k = 1; k <= 100; k++) {
        plant_advance(&plant, k * SECOND / 10u);
        /* At most 64 rotations of 0.09 rad lie between two exact evaluations: an error of 64 * 1e-15. */
        TEST_ASSERT_DOUBLE_WITHIN(1e-12, cos(plant.theta_e), plant.cos_e);
        TEST_ASSERT_DOUBLE_WITHIN(1e-12, sin(plant.theta_e), plant.sin_e);
    }
    /* 10 s are about 100 000 additions to the angle, each with a rounding of 1e-16 pi. */
    plant_truth_t now = truth_at(10u * SECOND);
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 2490.0, now.theta_m);
}

static void test_terminals_of_an_idle_machine_show_its_emf_and_harmonics(void)
{
    begin(plant_of("emf_5th = 0.05, emf_7th = 0.03, shaft_locked = 1, shaft_locked_speed = 50"));
    for (int k = 0; k < 50; k++) {
        plant_truth_t now = truth_at((uint64_t)k * 33333u);
        double sum_alpha = 0.0;
        double sum_beta = 0.0;
        for (int phase = 0; phase < 3; phase++) {
            double axis = 2.0 * PI * phase / 3.0;
            double x = now.theta_e - axis;
            double e = -200.0 * 0.183 * (sin(x) + 0.05 * sin(5.0 * x) + 0.03 * sin(7.0 * x));
            sum_alpha += 2.0 / 3.0 * e * cos(axis);
            sum_beta += 2.0 / 3.0 * e * sin(axis);
        }
        TEST_ASSERT_DOUBLE_WITHIN(1e-9, sum_alpha, now.u_alpha);
        TEST_ASSERT_DOUBLE_WITHIN(1e-9, sum_beta, now.u_beta);
    }
}

static void test_setting_motion_keeps_the_phase_currents(void)
{
    begin(plant_with(ideal(), "dc_voltage = 30, shaft_locked = 1"));
    plant_gates(&plant, 0, PLANT_UPPER(0) | PLANT_LOWER(1));
    plant_truth_t before = truth_at(100000u);
    plant_set_motion(&plant, -7.3, 40.0);
    plant_truth_t after = truth_at(100000u);
    TEST_ASSERT_EQUAL_DOUBLE(before.i_a, after.i_a);
    TEST_ASSERT_EQUAL_DOUBLE(before.i_b, after.i_b);
    TEST_ASSERT_DOUBLE_WITHIN(1e-13, -7.3, after.theta_m);
    TEST_ASSERT_EQUAL_DOUBLE(0.0, after.omega_m);
    double length = after.i_d * after.i_d + after.i_q * after.i_q;
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, before.i_d * before.i_d + before.i_q * before.i_q, length);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, after.i_d * cos(after.theta_e) - after.i_q * sin(after.theta_e),
                              after.i_a);
}
