/* Loads that depend on the square of the speed or on the angle: fan, piston, spring. */
#include <math.h>

#include "tests/plant/loop.h"
#include "unity.h"

#define SECOND PLANT_TICKS_PER_SECOND
#define PI     3.14159265358979323846

static plant_t plant;

/* A machine with inertia and the load of the test alone, without magnets, so that the winding has no
 * effect. */
static plant_params_t bare(void)
{
    return plant_of("flux_linkage = 0, friction_coulomb = 0, inertia = 0.002");
}

static plant_truth_t truth_at(double seconds)
{
    plant_truth_t now;
    plant_advance(&plant, (uint64_t)(seconds * (double)SECOND + 0.5));
    plant_truth(&plant, &now);
    return now;
}

static void test_a_fan_slows_its_rotor_by_the_hyperbola(void)
{
    /* J w' = -k w^2 gives 1/w = 1/w_0 + k t/J, in either direction. */
    for (int way = -1; way <= 1; way += 2) {
        plant_params_t q = plant_with(bare(), "load_quadratic = 1e-5");
        plant_init(&plant, &q, 1);
        plant_set_motion(&plant, 0.0, way * 200.0);
        for (int k = 1; k <= 5; k++) {
            double omega = way / (1.0 / 200.0 + q.load_quadratic * 0.4 * k / q.inertia);
            plant_truth_t now = truth_at(0.4 * k);
            TEST_ASSERT_DOUBLE_WITHIN(1e-6 * 200.0, omega, now.omega_m);
            TEST_ASSERT_DOUBLE_WITHIN(1e-9, q.load_quadratic * now.omega_m * fabs(now.omega_m),
                                      now.load_torque);
        }
    }
}

static void test_a_spring_swings_its_rotor_as_a_cosine(void)
{
    plant_params_t q = bare();
    q.load_spring = 1.8; /* natural frequency 30 rad/s with 0.002 kg m^2 */
    plant_init(&plant, &q, 1);
    plant_set_motion(&plant, 0.5, 0.0);
    for (int k = 1; k <= 20; k++) {
        double t = 0.037 * k;
        plant_truth_t now = truth_at(t);
        /* The steps of 100 us are of second order: at 30 rad/s the error is (w h)^2 = 9e-6 for each radian
         * of motion. */
        double bound = 9e-6 * 30.0 * t;
        TEST_ASSERT_DOUBLE_WITHIN(0.5 * bound, 0.5 * cos(30.0 * t), now.theta_m);
        TEST_ASSERT_DOUBLE_WITHIN(15.0 * bound, -15.0 * sin(30.0 * t), now.omega_m);
        TEST_ASSERT_DOUBLE_WITHIN(1e-9, 1.8 * now.theta_m, now.load_torque);
    }
}

static void test_a_piston_takes_and_returns_the_energy_of_its_potential(void)
{
    /* J w^2/2 - (T/n) cos(n theta) is constant, whether the rotor swings or turns. */
    const double speeds[] = {5.0, 40.0};
    for (int n = 0; n < 2; n++) {
        plant_params_t q = plant_with(bare(), "load_sine = 0.2, load_sine_cycles = 2");
        plant_init(&plant, &q, 1);
        plant_set_motion(&plant, 0.0, speeds[n]);
        double whole = 0.5 * q.inertia * speeds[n] * speeds[n] - 0.1;
        for (int k = 1; k <= 50; k++) {
            plant_truth_t now = truth_at(0.013 * k);
            double kept = 0.5 * q.inertia * now.omega_m * now.omega_m - 0.1 * cos(2.0 * now.theta_m);
            TEST_ASSERT_DOUBLE_WITHIN(2e-5 * 0.2, whole, kept);
            TEST_ASSERT_DOUBLE_WITHIN(1e-9, 0.2 * sin(2.0 * now.theta_m), now.load_torque);
        }
    }
}

static void test_a_table_is_straight_between_its_points_and_goes_on_behind_the_last(void)
{
    plant_params_t q = plant_with(bare(), "load_table_speed = 20, load_table_3 = 0.3, load_table_4 = 0.5, "
                                          "load_table_5 = 0.8, load_table_6 = 1.2");
    q.load_table_1 = 0.4; /* J w' = -0.02 w up to 20 rad/s */
    q.load_table_2 = 0.1; /* a maximum at a low speed, like that of a stirrer that breaks away */
    static const double points[][2] = {{10.0, 0.2},  {20.0, 0.4},   {30.0, 0.25}, {40.0, 0.1},
                                       {50.0, 0.2},  {90.0, 0.65},  {120.0, 1.2}, {135.0, 1.2},
                                       {400.0, 1.2}, {-50.0, -0.2}, {0.0, 0.0},   {-500.0, -1.2}};
    plant_init(&plant, &q, 1);
    for (size_t n = 0; n < sizeof points / sizeof points[0]; n++) {
        plant_truth_t now;
        plant_set_motion(&plant, 0.3, points[n][0]);
        plant_truth(&plant, &now);
        TEST_ASSERT_DOUBLE_WITHIN(1e-12, points[n][1], now.load_torque);
    }
    plant_init(&plant, &q, 1);
    plant_set_motion(&plant, 0.0, 18.0);
    for (int k = 1; k <= 5; k++) {
        double t = 0.05 * k;
        TEST_ASSERT_DOUBLE_WITHIN(1e-5, 18.0 * exp(-0.02 * t / q.inertia), truth_at(t).omega_m);
    }
}

static void test_the_load_is_at_the_far_end_of_an_elastic_shaft(void)
{
    /* The dynamometer holds the motor; the mass at the far end swings between two springs. */
    plant_params_t q =
        plant_with(bare(), "shaft_locked = 1, load_inertia = 0.001, shaft_stiffness = 4, load_spring = 1");
    plant_init(&plant, &q, 1);
    plant_set_motion(&plant, 0.3, 0.0);
    /* twist' = -omega_load, J omega_load' = k twist - c (0.3 - twist); the rest position is twist = 0.3
     * c/(k + c). */
    const double rest = 0.3 * 1.0 / 5.0;
    const double swing = sqrt(5.0 / 0.001);
    for (int k = 1; k <= 20; k++) {
        double t = 0.0071 * k;
        TEST_ASSERT_DOUBLE_WITHIN(2e-5, rest * (1.0 - cos(swing * t)), truth_at(t).twist);
    }
}

static void test_dry_friction_holds_a_wound_spring_and_lets_a_stronger_one_go(void)
{
    plant_params_t q =
        plant_with(bare(), "friction_coulomb = 0.5, friction_breakaway = 0.6, load_spring = 1");
    plant_init(&plant, &q, 1);
    plant_set_motion(&plant, 0.59, 0.0);
    TEST_ASSERT_EQUAL_DOUBLE(0.59, truth_at(0.5).theta_m);
    plant_set_motion(&plant, 0.61, 0.0);
    /* Spring and friction are equal at 0.5. The mass slides to the same distance on the other side of this
     * point and is held there, at 0.39. */
    plant_truth_t now = truth_at(2.0);
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, 0.39, now.theta_m);
    TEST_ASSERT_EQUAL_DOUBLE(0.0, now.omega_m);
}

static void test_what_a_load_takes_is_metered(void)
{
    plant_params_t q = plant_with(bare(), "load_quadratic = 2e-5, load_sine = 0.05, load_spring = 0.01");
    plant_init(&plant, &q, 1);
    plant_set_motion(&plant, 0.2, 80.0);
    plant_set_metering(&plant, true);
    double before = 0.5 * q.inertia * 80.0 * 80.0;
    plant_truth_t now = truth_at(1.0);
    TEST_ASSERT_DOUBLE_WITHIN(1e-4 * before, before - now.energy_kinetic, now.energy_mechanical);
}
