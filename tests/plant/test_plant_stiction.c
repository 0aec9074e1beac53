/* A shaft with static friction: break-away, rest and brake compared with algebra. Events occur at ticks of
 * 1/150 MHz. */
#include <math.h>
#include <string.h>

#include "tests/plant/bench.h"
#include "unity.h"

#define SECOND PLANT_TICKS_PER_SECOND
#define TICK   (1.0 / 150e6) /* [s] */
#define PI     3.14159265358979323846

#define COULOMB 1.32   /* [N m] */
#define INERTIA 0.0636 /* [kg m^2] */

static plant_t copy;

static plant_params_t sticking(double breakaway)
{
    plant_params_t q = plant_params_default();
    q.inertia = INERTIA;
    q.friction_coulomb = COULOMB;
    q.friction_breakaway = breakaway;
    return q;
}

/* ---- coming to rest ---- */

static void test_decelerating_rotor_rests_at_the_tick_of_algebra(void)
{
    for (int way = -1; way <= 1; way += 2) {
        for (int n = 0; n < 2; n++) {
            plant_params_t q = sticking(2.0);
            q.load_torque = n == 0 ? 0.0 : 5.0; /* the load is passive and decelerates like friction */
            const double torque = COULOMB + q.load_torque;
            const double seconds = INERTIA * 20.0 / torque;
            const uint64_t tick = (uint64_t)(seconds / TICK);
            plant_init(&plant, &q, 1);
            plant_set_motion(&plant, 0.3, way * 20.0);
            /* One tick earlier the speed is at most the deceleration of a tick; at the tick it is zero. */
            const double left = way * truth_at(tick - 1u).omega_m;
            TEST_ASSERT_TRUE(left > 0.5 * torque / INERTIA * TICK && left < 2.5 * torque / INERTIA * TICK);
            TEST_ASSERT_EQUAL_DOUBLE(0.0, truth_at(tick + 2u).omega_m);
            /* The same motion without a reading in between: theta = J w^2/(2 T), after which the shaft
             * stays at rest. */
            plant_init(&plant, &q, 1);
            plant_set_motion(&plant, 0.3, way * 20.0);
            const plant_truth_t rest = truth_at(SECOND);
            TEST_ASSERT_EQUAL_DOUBLE(0.0, rest.omega_m);
            TEST_ASSERT_DOUBLE_WITHIN(1e-10, way * 0.5 * INERTIA * 400.0 / torque, rest.theta_m - 0.3);
            TEST_ASSERT_EQUAL_DOUBLE(rest.theta_m, truth_at(3u * SECOND).theta_m);
            TEST_ASSERT_EQUAL_DOUBLE(0.0, rest.load_torque);
        }
    }
}

static void test_active_load_below_break_away_stops_a_rotor_and_one_above_turns_it_round(void)
{
    for (int n = 0; n < 2; n++) {
        begin(plant_with(sticking(n == 0 ? 5.5 : 4.5), "load_kind = 1, load_torque = 5"));
        plant_set_motion(&plant, 0.0, 20.0);
        const double turn = INERTIA * 20.0 / (5.0 + COULOMB);
        const double way = 0.5 * 20.0 * turn;
        const double t = 1.0 - turn;
        const double back = n == 0 ? 0.0 : (5.0 - COULOMB) / INERTIA;
        const plant_truth_t now = truth_at(SECOND);
        /* The error is a tick at the reversal: 2 T_c/J times a tick in speed, times 0.8 s in angle. */
        TEST_ASSERT_DOUBLE_WITHIN(n == 0 ? 0.0 : 1e-6, -back * t, now.omega_m);
        TEST_ASSERT_DOUBLE_WITHIN(1e-6, way - 0.5 * back * t * t, now.theta_m);
    }
}

/* ---- standing ---- */

static void test_shaft_is_held_at_break_away_and_loose_beyond_it(void)
{
    plant_params_t q = begin(plant_with(sticking(2.0), "load_kind = 1, load_torque = 2"));
    TEST_ASSERT_EQUAL_DOUBLE(0.0, truth_at(SECOND).omega_m);
    q.load_torque = nextafter(2.0, 3.0);
    plant_set_params(&plant, &q);
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, -(2.0 - COULOMB) / INERTIA, truth_at(2u * SECOND).omega_m);
    plant_init(&plant, &q, 1);
    q.load_torque = -nextafter(2.0, 3.0);
    plant_set_params(&plant, &q);
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, (2.0 - COULOMB) / INERTIA, truth_at(SECOND).omega_m);
}

static void test_passive_load_holds_and_never_drives(void)
{
    plant_params_t q = begin(plant_with(sticking(2.0), "load_torque = 50"));
    TEST_ASSERT_EQUAL_DOUBLE(0.0, truth_at(SECOND).omega_m);
    plant_set_motion(&plant, 0.0, -100.0);
    TEST_ASSERT_EQUAL_DOUBLE(0.0, truth_at(2u * SECOND).omega_m);
    /* If the load becomes active, it drives the shaft, which breaks loose at once. */
    q.load_kind = PLANT_LOAD_ACTIVE;
    plant_set_params(&plant, &q);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, -(50.0 - COULOMB) / INERTIA * 0.1,
                              truth_at(2u * SECOND + SECOND / 10u).omega_m);
}

/* A voltage is applied to the q axis of a rotor at rest: i = U/R (1 - exp(-t R/L)), T = 1.5 p psi i. */
static void test_rising_torque_breaks_the_shaft_loose_at_the_tick_of_algebra(void)
{
    for (int n = 0; n < 2; n++) {
        plant_params_t q = plant_with(
            sticking(6.0), "turn_on_delay = 0, turn_off_delay = 0, " NO_DROPS
                           ", current_zone = 0, short_circuit_current = 0, fault_pulse = 0, dc_voltage = 30");
        q.inertia = 10.0; /* so that the EMF does not change the current */
        q.load_torque = n == 0 ? 0.0 : 3.0;
        const double hold = 6.0 + q.load_torque;
        const double most = 1.5 * 4.0 * q.flux_linkage * 20.0 / q.resistance;
        const double lag = q.inductance_d / q.resistance;
        const double loose = -lag * log(1.0 - hold / most);
        const uint64_t tick = (uint64_t)(loose / TICK);
        const uint32_t gates = PLANT_UPPER(0) | PLANT_LOWER(1) | PLANT_LOWER(2);
        plant_init(&plant, &q, 1);
        plant_set_motion(&plant, -PI / 2.0 / 4.0, 0.0);
        plant_gates(&plant, 0, gates);
        memcpy(&copy, &plant, sizeof copy);
        plant_truth_t now = truth_at(tick - 10u);
        TEST_ASSERT_EQUAL_DOUBLE(0.0, now.omega_m);
        TEST_ASSERT_EQUAL_DOUBLE(plant.torque, now.load_torque);
        TEST_ASSERT_DOUBLE_WITHIN(1e-4, hold, now.torque);
        now = truth_at(tick + 10u);
        TEST_ASSERT_TRUE(now.omega_m > 0.0);
        TEST_ASSERT_DOUBLE_WITHIN(1e-12, hold - 6.0 + COULOMB, now.load_torque);
        /* One call advances by 10 ms: J w = integral of T - T_c. A straight line instead of the
         * exponential within 100 us is wrong by 3e-5 of the torque's rise; a break-away found 100 us late
         * would be wrong by 0.6 %. */
        memcpy(&plant, &copy, sizeof copy);
        const double end = loose + 0.01;
        const double impulse =
            most * (0.01 + lag * (exp(-end / lag) - exp(-loose / lag))) - (COULOMB + q.load_torque) * 0.01;
        now = truth_at((uint64_t)(end / TICK));
        TEST_ASSERT_DOUBLE_WITHIN(1e-3 * impulse / q.inertia, impulse / q.inertia, now.omega_m);
    }
}

/* ---- brake ---- */

static void test_brake_stops_the_rig_holds_it_and_lets_go(void)
{
    for (int sticks = 0; sticks < 2; sticks++) {
        plant_params_t q = begin(sticking(sticks ? 2.0 : 0.0));
        plant_set_motion(&plant, 0.0, 150.0);
        plant_set_brake(&plant, 60.0);
        const double seconds = INERTIA * 150.0 / (60.0 + COULOMB);
        const uint64_t tick = (uint64_t)(seconds / TICK);
        TEST_ASSERT_TRUE(truth_at(tick - 1u).omega_m > 0.0);
        plant_truth_t now = truth_at(tick + 2u);
        TEST_ASSERT_EQUAL_DOUBLE(0.0, now.omega_m);
        TEST_ASSERT_DOUBLE_WITHIN(1e-9, 0.5 * 150.0 * seconds, now.theta_m);
        /* Brake and friction together hold the load up to the sum of their static torques. */
        q.load_kind = PLANT_LOAD_ACTIVE;
        q.load_torque = 60.0 + (sticks ? 2.0 : COULOMB);
        plant_set_params(&plant, &q);
        const double angle = now.theta_m;
        now = truth_at(5u * SECOND);
        TEST_ASSERT_EQUAL_DOUBLE(0.0, now.omega_m);
        TEST_ASSERT_EQUAL_DOUBLE(angle, now.theta_m);
        q.load_torque += 0.01;
        plant_set_params(&plant, &q);
        TEST_ASSERT_TRUE(truth_at(6u * SECOND).omega_m < 0.0);
        /* After the release the load accelerates against friction alone. */
        q.load_torque = 10.0;
        plant_set_params(&plant, &q);
        plant_set_motion(&plant, 0.0, 0.0);
        TEST_ASSERT_EQUAL_DOUBLE(0.0, truth_at(7u * SECOND).omega_m);
        plant_set_brake(&plant, 0.0);
        /* With smooth friction the mean friction over the first 0.2 rad/s is about 5/8 of T_c: a gain of
         * 3/8 of T_c/J during 1.4 ms. */
        TEST_ASSERT_DOUBLE_WITHIN(sticks ? 1e-9 : 2e-2, -(10.0 - COULOMB) / INERTIA,
                                  truth_at(8u * SECOND).omega_m);
    }
}

static void test_brake_has_no_effect_on_a_locked_shaft(void)
{
    plant_params_t q = begin(plant_with(sticking(2.0), "shaft_locked = 1, shaft_locked_speed = 30"));
    plant_set_brake(&plant, 60.0);
    TEST_ASSERT_EQUAL_DOUBLE(30.0, truth_at(SECOND).omega_m);
    /* After its release the shaft behaves like any braked shaft. */
    q.shaft_locked = 0.0;
    plant_set_params(&plant, &q);
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 30.0 - (60.0 + COULOMB) / INERTIA * 0.01,
                              truth_at(SECOND + SECOND / 100u).omega_m);
}

/* ---- saved and restored states ---- */

static void test_the_times_of_reading_move_no_event(void)
{
    begin(plant_with(sticking(2.0), "load_kind = 1, load_torque = 1.9"));
    plant_set_motion(&plant, 0.0, 20.0);
    memcpy(&copy, &plant, sizeof copy);
    plant_advance(&plant, SECOND);
    for (uint64_t tick = 0; tick < SECOND; tick += 99991u) {
        plant_advance(&copy, tick);
    }
    plant_advance(&copy, SECOND);
    TEST_ASSERT_EQUAL_DOUBLE(0.0, plant.omega_m);
    TEST_ASSERT_EQUAL_DOUBLE(0.0, copy.omega_m);
    TEST_ASSERT_DOUBLE_WITHIN(1e-10, plant.theta_e, copy.theta_e);
}
