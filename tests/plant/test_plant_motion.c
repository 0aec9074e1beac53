/* Shaft and windings against closed forms. */
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
    /* J w' = -T_c - B w: w = (w_0 + T_c/B) exp(-B t/J) - T_c/B. */
    for (int k = 1; k <= 5; k++) {
        double t = 0.5 * k;
        double shift = q.friction_coulomb / q.friction_viscous;
        double omega = (150.0 + shift) * exp(-q.friction_viscous * t / q.inertia) - shift;
        plant_truth_t now = truth_at((uint64_t)k * SECOND / 2u);
        /* Midpoint rule: (B h/J)^2/24 of the change, 1e-11; rounding of 25000 steps. */
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
    /* w = 2e-4 6.32/0.003 = 0.42 rad/s. Above, the sign is full and the speed falls by 6.32/0.003 per second;
     * inside it must die out: within 40 periods below a millionth of w, and never a thousandth of w
     * backwards. */
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
    q.load_torque = 0.66; /* half of the dry friction: x (3 - x^2)/2 = 1/2 at x = 0.347296 */
    plant_init(&plant, &q, 1);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, -0.3472964 * PLANT_SHAFT_WIDTH, truth_at(2u * SECOND).omega_m);
}

static void test_active_load_turns_a_free_rotor_at_constant_acceleration(void)
{
    plant_params_t q = begin(plant_of("friction_coulomb = 0, load_kind = 1, load_torque = -5"));
    double alpha = 5.0 / q.inertia;
    for (int k = 1; k <= 10; k++) {
        double t = 0.1 * k;
        plant_truth_t now = truth_at((uint64_t)k * SECOND / 10u);
        TEST_ASSERT_DOUBLE_WITHIN(1e-8, alpha * t, now.omega_m);
        TEST_ASSERT_DOUBLE_WITHIN(1e-8, 0.5 * alpha * t * t, now.theta_m);
        TEST_ASSERT_DOUBLE_WITHIN(1e-8, remainder(4.0 * now.theta_m - now.theta_e, 2.0 * PI), 0.0);
        TEST_ASSERT_TRUE(now.theta_e >= -PI && now.theta_e < PI);
        TEST_ASSERT_EQUAL_DOUBLE(-5.0, now.load_torque);
    }
}

static void test_passive_load_opposes_either_direction_and_active_load_only_one(void)
{
    plant_truth_t now;
    plant_params_t q = begin(plant_of("load_torque = 5"));
    plant_set_motion(&plant, 0.0, 50.0);
    now = truth();
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 6.32, now.load_torque);
    plant_set_motion(&plant, 0.0, -50.0);
    now = truth();
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, -6.32, now.load_torque);
    q.load_kind = PLANT_LOAD_ACTIVE;
    plant_set_params(&plant, &q);
    now = truth();
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 5.0 - 1.32, now.load_torque);
}

static void test_locked_winding_charges_on_its_time_constant(void)
{
    plant_params_t q = begin(plant_with(ideal(), "dc_voltage = 30, shaft_locked = 1"));
    plant_gates(&plant, 0, PLANT_UPPER(0) | PLANT_LOWER(1) | PLANT_LOWER(2));
    for (int k = 1; k <= 20; k++) {
        double t = 3e-3 * k;
        plant_truth_t now = truth_at((uint64_t)k * 450000u);
        double i = 2.0 / 3.0 * 30.0 / q.resistance * (1.0 - exp(-q.resistance * t / q.inductance_d));
        /* Fourth order: (R h/L)^4/120 = 3e-11 of the change; and the mean resistance of ideal devices is
         * zero. */
        TEST_ASSERT_DOUBLE_WITHIN(1e-8, i, now.i_a);
        TEST_ASSERT_DOUBLE_WITHIN(1e-8, -0.5 * i, now.i_b);
        TEST_ASSERT_DOUBLE_WITHIN(1e-8, i, now.i_d);
        TEST_ASSERT_DOUBLE_WITHIN(1e-8, 0.0, now.torque);
        TEST_ASSERT_DOUBLE_WITHIN(1e-9, 20.0, now.u_alpha);
        TEST_ASSERT_DOUBLE_WITHIN(1e-9, 20.0 * t, now.flux_alpha);
        TEST_ASSERT_DOUBLE_WITHIN(1e-9, 0.0, now.flux_beta);
    }
}

static void test_locked_winding_sees_the_inductance_of_the_axis_it_lies_on(void)
{
    plant_params_t q =
        plant_with(ideal(), "dc_voltage = 30, shaft_locked = 1, inductance_d = 0.008, inductance_q = 0.02");
    for (int axis = 0; axis < 2; axis++) {
        plant_init(&plant, &q, 1);
        plant_set_motion(&plant, axis ? -PI / 2.0 / 4.0 : 0.0, 0.0);
        plant_gates(&plant, 0, PLANT_UPPER(0) | PLANT_LOWER(1) | PLANT_LOWER(2));
        double t = 5e-3;
        double i =
            20.0 / q.resistance * (1.0 - exp(-q.resistance * t / (axis ? q.inductance_q : q.inductance_d)));
        plant_truth_t now = truth_at(750000u);
        TEST_ASSERT_DOUBLE_WITHIN(1e-8, i, now.i_a);
        TEST_ASSERT_DOUBLE_WITHIN(1e-8, i, axis ? now.i_q : now.i_d);
        TEST_ASSERT_DOUBLE_WITHIN(1e-7, axis ? 1.5 * 4.0 * 0.183 * i : 0.0, now.torque);
    }
}

static void test_steady_current_of_a_locked_winding_carries_the_drops(void)
{
    begin(plant_of("dc_voltage = 30, shaft_locked = 1"));
    plant_gates(&plant, 0, PLANT_UPPER(0) | PLANT_LOWER(1) | PLANT_LOWER(2));
    /* Three IGBTs, 0.8 V + 18 mohm: u = 2/3 (30 - 1.6) - 18 mohm (2 i + i/2 + i/2)/3. 20 time constants. */
    plant_truth_t now = truth_at(SECOND / 4u);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 2.0 / 3.0 * 28.4 / (0.95 + 0.018), now.i_a);
    TEST_ASSERT_EQUAL_DOUBLE(PLANT_LEG_UPPER_IGBT, now.leg_a);
    TEST_ASSERT_EQUAL_DOUBLE(PLANT_LEG_LOWER_IGBT, now.leg_b);
}

static void test_short_circuited_machine_brakes_with_its_steady_torque(void)
{
    /* All lower switches on at a locked speed, ideal: i_q = -w^2 psi L../(R^2 + w^2 L_d L_q), textbook. */
    plant_params_t q = begin(plant_with(
        ideal(), "inductance_d = 0.008, inductance_q = 0.02, shaft_locked = 1, shaft_locked_speed = 25"));
    plant_gates(&plant, 0, PLANT_LOWER(0) | PLANT_LOWER(1) | PLANT_LOWER(2));
    double w = 100.0;
    double square = q.resistance * q.resistance + w * w * q.inductance_d * q.inductance_q;
    double i_d = -w * w * q.inductance_q * q.flux_linkage / square;
    double i_q = -w * q.resistance * q.flux_linkage / square;
    plant_truth_t now = truth_at(SECOND);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, i_d, now.i_d);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, i_q, now.i_q);
    double torque = 1.5 * 4.0 * (q.flux_linkage * i_q + (q.inductance_d - q.inductance_q) * i_d * i_q);
    TEST_ASSERT_DOUBLE_WITHIN(1e-5, torque, now.torque);
    TEST_ASSERT_EQUAL_DOUBLE(now.torque, now.load_torque);
    TEST_ASSERT_EQUAL_DOUBLE(25.0, now.omega_m);
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 25.0, now.theta_m);
}

static void test_rotor_without_magnets_does_not_matter_to_a_round_machine(void)
{
    /* The windings charge as if nothing turned, although all is reckoned in a frame at 8000 rad/s. The rest
     * of Taylor's series turns the current by x^5/120 a step, x = 0.088 rad: 4e-8 times 450 steps in a time
     * constant, of 21 A. */
    plant_params_t q =
        plant_with(ideal(), "flux_linkage = 0, dc_voltage = 30, shaft_locked = 1, shaft_locked_speed = 2000");
    plant_init(&plant, &q, 1);
    plant_gates(&plant, 0, PLANT_UPPER(0) | PLANT_LOWER(1) | PLANT_LOWER(2));
    for (int k = 1; k <= 20; k++) {
        double i = 20.0 / q.resistance * (1.0 - exp(-q.resistance * 2e-3 * k / q.inductance_d));
        plant_truth_t now = truth_at((uint64_t)k * 300000u);
        TEST_ASSERT_DOUBLE_WITHIN(1e-3, i, now.i_a);
        TEST_ASSERT_DOUBLE_WITHIN(1e-3, -0.5 * i, now.i_c);
    }
}

static void test_phasor_keeps_to_the_angle_however_long_the_run(void)
{
    begin(plant_of("shaft_locked = 1, shaft_locked_speed = 249"));
    for (uint64_t k = 1; k <= 100; k++) {
        plant_advance(&plant, k * SECOND / 10u);
        /* 64 turns of 0.09 rad at most between two exact ones: 64 * 1e-15. */
        TEST_ASSERT_DOUBLE_WITHIN(1e-12, cos(plant.theta_e), plant.cos_e);
        TEST_ASSERT_DOUBLE_WITHIN(1e-12, sin(plant.theta_e), plant.sin_e);
    }
    /* 10 s in some 100 000 additions of the angle, 1e-16 pi each. */
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
