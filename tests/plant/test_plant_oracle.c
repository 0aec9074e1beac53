/* The switched plant against matrix exponentials: same edges, same parameters, currents at every sample. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "tests/oracle/oracle.h"
#include "tests/plant/loop.h"
#include "unity.h"

#define PERIODS 5000 /* 0.5 s */

static oracle_edge_t edges[12 * PERIODS];
static uint64_t ticks[PERIODS];
static plant_truth_t seen[PERIODS];
static oracle_sample_t wanted[PERIODS];

typedef struct {
    double current; /* [A] largest difference of a phase current */
    double angle;   /* [rad] of the mechanical angle */
    double speed;   /* [rad/s] */
    double largest; /* [A] largest current met */
} distance_t;

/* Drives the loop with `q_current` and compares at the end of every period. */
static distance_t run(const plant_params_t *q, oracle_frame_t frame, double omega_start, double target,
                      double i_d, double most, int periods)
{
    static plant_t plant;
    loop_t loop;
    memset(&loop, 0, sizeof loop);
    loop.dead = 375;
    plant_init(&plant, q, 1);
    plant_set_motion(&plant, 0.1, omega_start);
    size_t count = 0;
    size_t samples = 0;
    for (int k = 0; k < periods; k++) {
        double wish = 0.5 * (target - plant.omega_m);
        loop.i_d_ref = i_d;
        loop.i_q_ref = wish > most ? most : wish < -most ? -most : wish;
        loop_period(&loop, &plant, edges, &count);
        ticks[samples] = plant.tick;
        plant_truth(&plant, &seen[samples++]);
    }
    TEST_ASSERT_TRUE(oracle_run(q, frame, 0.1, q->shaft_locked != 0.0 ? 0.0 : omega_start, edges, count,
                                ticks, samples, wanted));
    distance_t far = {0.0, 0.0, 0.0, 0.0};
    for (size_t n = 0; n < samples; n++) {
        far.current = fmax(far.current, fabs(seen[n].i_a - wanted[n].i_a));
        far.current = fmax(far.current, fabs(seen[n].i_b - wanted[n].i_b));
        far.current = fmax(far.current, fabs(seen[n].i_c - wanted[n].i_c));
        far.angle = fmax(far.angle, fabs(seen[n].theta_m - wanted[n].theta_m));
        far.speed = fmax(far.speed, fabs(seen[n].omega_m - wanted[n].omega_m));
        far.largest = fmax(far.largest, fabs(wanted[n].i_a));
    }
    return far;
}

/* 1 mA is the acceptance; the angle that 1 mA could hide is 1 mA/10 A of an electrical radian. */
static void close_enough(distance_t far)
{
    TEST_ASSERT_TRUE_MESSAGE(far.largest > 1.0, "nothing flowed");
    TEST_ASSERT_TRUE_MESSAGE(far.current < 1e-3, "current off by more than 1 mA");
    TEST_ASSERT_TRUE_MESSAGE(far.angle < 1e-3 / 10.0 / 4.0, "angle");
}

static void test_currents_follow_the_oracle_from_rest_to_rated_speed_under_load(void)
{
    plant_params_t q = plant_params_default();
    q.load_torque = 5.0;
    q.inertia = 0.003;
    distance_t far = run(&q, ORACLE_STATIONARY, 0.0, 157.0796, 0.0, 10.0, PERIODS);
    close_enough(far);
    TEST_ASSERT_DOUBLE_WITHIN(15.0, 157.0, seen[PERIODS - 1].omega_m);
}

static void test_currents_follow_the_oracle_on_the_rig_at_low_current(void)
{
    /* 100 r/min, friction only: dead time clamps the currents to the zone for much of the turn. */
    plant_params_t q = plant_params_default();
    close_enough(run(&q, ORACLE_STATIONARY, 5.0, 10.472, 0.0, 10.0, 2000));
}

static void test_currents_follow_the_oracle_backwards_with_active_load(void)
{
    plant_params_t q = plant_params_default();
    q.load_kind = PLANT_LOAD_ACTIVE;
    q.load_torque = 3.0;
    q.friction_viscous = 0.01;
    q.inertia = 0.01;
    distance_t far = run(&q, ORACLE_STATIONARY, 20.0, -120.0, 0.0, 8.0, 2000);
    close_enough(far);
    TEST_ASSERT_TRUE(seen[1999].omega_m < -100.0);
}

static void test_currents_follow_the_oracle_on_a_salient_machine(void)
{
    plant_params_t q = plant_params_default();
    q.inductance_d = 0.008;
    q.inductance_q = 0.02;
    q.inertia = 0.003;
    close_enough(run(&q, ORACLE_ROTOR, 0.0, 157.0796, -4.0, 10.0, 1000));
}

static void test_currents_follow_the_oracle_with_emf_harmonics(void)
{
    plant_params_t q = plant_params_default();
    q.emf_5th = 0.05;
    q.emf_7th = -0.03;
    q.load_torque = 5.0;
    q.inertia = 0.003;
    close_enough(run(&q, ORACLE_STATIONARY, 100.0, 157.0796, 0.0, 10.0, 1000));
}

static void test_currents_follow_the_oracle_at_three_tenths_of_a_radian_per_period(void)
{
    plant_params_t q = plant_params_default();
    q.flux_linkage = 0.04;
    q.inductance_d = 0.002;
    q.inductance_q = 0.003;
    q.shaft_locked = 1.0;
    q.shaft_locked_speed = 3000.0 / 4.0;
    close_enough(run(&q, ORACLE_ROTOR, 0.0, 766.0, -2.0, 8.0, 500));
}

static void test_currents_follow_the_oracle_with_unlike_device_slopes_and_no_delays(void)
{
    plant_params_t q = plant_params_default();
    q.turn_on_delay = 0.0;
    q.turn_off_delay = 0.0;
    q.igbt_resistance = 0.05;
    q.diode_resistance = 0.01;
    q.current_zone = 0.2;
    close_enough(run(&q, ORACLE_STATIONARY, 60.0, 100.0, 1.0, 6.0, 1000));
}

static void test_the_oracle_agrees_with_itself_in_both_frames(void)
{
    plant_params_t q = plant_params_default();
    q.emf_5th = 0.02;
    q.emf_7th = 0.01;
    q.inertia = 0.003;
    static oracle_sample_t other[300];
    run(&q, ORACLE_STATIONARY, 50.0, 157.0796, 0.0, 10.0, 300);
    /* The loop is deterministic: same plant, same edges in the second run. */
    memcpy(other, wanted, sizeof other);
    run(&q, ORACLE_ROTOR, 50.0, 157.0796, 0.0, 10.0, 300);
    for (int n = 0; n < 300; n++) {
        /* The rotor frame holds the slopes of the legs' voltages for a sub-step in which they turn; the error
         * falls fourfold when the step is halved. 0.02 mA is a fiftieth of what either is to judge. */
        TEST_ASSERT_DOUBLE_WITHIN(2e-5, other[n].i_a, wanted[n].i_a);
        TEST_ASSERT_DOUBLE_WITHIN(2e-5, other[n].i_b, wanted[n].i_b);
    }
}

static void test_the_oracle_refuses_what_it_does_not_know(void)
{
    oracle_sample_t sample;
    uint64_t tick = 1;
    plant_params_t q = plant_params_default();
    q.inductance_q = 0.02;
    TEST_ASSERT_FALSE(oracle_run(&q, ORACLE_STATIONARY, 0.0, 0.0, NULL, 0, &tick, 1, &sample));
    q = plant_params_default();
    q.open_phase_b = 1.0;
    TEST_ASSERT_FALSE(oracle_run(&q, ORACLE_ROTOR, 0.0, 0.0, NULL, 0, &tick, 1, &sample));
    q = plant_params_default();
    q.dc_capacitance = 1e-3;
    q.dc_resistance = 1.0;
    TEST_ASSERT_FALSE(oracle_run(&q, ORACLE_ROTOR, 0.0, 0.0, NULL, 0, &tick, 1, &sample));
    q = plant_params_default();
    q.leg_c_delay = 1e-6;
    TEST_ASSERT_FALSE(oracle_run(&q, ORACLE_ROTOR, 0.0, 0.0, NULL, 0, &tick, 1, &sample));
    q = plant_params_default();
    q.load_inertia = 0.01;
    TEST_ASSERT_FALSE(oracle_run(&q, ORACLE_ROTOR, 0.0, 0.0, NULL, 0, &tick, 1, &sample));
}
