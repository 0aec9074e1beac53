/* The switched plant compared with matrix exponentials: with the same edges and the same parameters the
 * currents of every sample must agree. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "tests/oracle/oracle.h"
#include "tests/plant/bench.h"
#include "unity.h"

#define PERIODS 1500 /* largest number of periods */

static oracle_edge_t edges[12 * PERIODS];
static uint64_t ticks[PERIODS];
static plant_truth_t seen[PERIODS];
static oracle_sample_t wanted[PERIODS];

typedef struct {
    double current; /* [A] largest difference of a phase current */
    double angle;   /* [rad] largest difference of the mechanical angle */
    double speed;   /* [rad/s] largest difference of the speed */
    double largest; /* [A] largest current that occurred */
} distance_t;

/* Drives the loop with `q_current` and compares both models at the end of every period. */
static distance_t run(const plant_params_t *q, oracle_frame_t frame, double omega_start, double target,
                      double i_d, double most, int periods)
{
    setUp();
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

/* The loop changes the speed from `start` to `target`, with this i_d and at most this i_q. */
static const struct {
    const char *name, *changes;
    oracle_frame_t frame;
    double start, target, i_d, most; /* [rad/s], [A] */
    int periods;
    double end, within; /* [rad/s]; 0: not checked */
} drives[] = {
    {"from rest to rated speed under load", "load_torque = 5, inertia = 0.003", ORACLE_STATIONARY, 0.0,
     157.0796, 0.0, 10.0, 1200, 157.0, 15.0},
    /* At 100 r/min, with friction as the only load, the dead time keeps the currents in the zone for a
     * large part of a turn. */
    {"on the rig at low current", "", ORACLE_STATIONARY, 5.0, 10.472, 0.0, 10.0, PERIODS, 0.0, 0.0},
    {"backwards with active load", "load_kind = 1, load_torque = 3, friction_viscous = 0.01, inertia = 0.01",
     ORACLE_STATIONARY, 20.0, -120.0, 0.0, 8.0, 1200, -115.0, 15.0},
    {"on a salient machine", "inductance_d = 0.008, inductance_q = 0.02, inertia = 0.003", ORACLE_ROTOR, 0.0,
     157.0796, -4.0, 10.0, 500, 0.0, 0.0},
    {"on a salient machine by its flux", "inductance_d = 0.008, inductance_q = 0.02, inertia = 0.003",
     ORACLE_FLUX, 0.0, 157.0796, -4.0, 10.0, 200, 0.0, 0.0},
    /* 1.4 I_s on the q axis, where the incremental inductance is a fifth of the unsaturated one. */
    {"on a machine that saturates on both axes",
     "inductance_d = 0.02, inductance_q = 0.04, saturation_d = 8, saturation_q = 8, inertia = 0.0636",
     ORACLE_FLUX, 0.0, 157.0796, -6.0, 12.0, 300, 0.0, 0.0},
    {"backwards on a round machine that saturates",
     "saturation_d = 5, saturation_q = 5, load_kind = 1, load_torque = 3, inertia = 0.01", ORACLE_FLUX, 20.0,
     -120.0, 0.0, 8.0, 300, 0.0, 0.0},
    {"with a loss of the iron on a salient machine",
     "inductance_d = 0.008, inductance_q = 0.02, iron_loss_resistance = 150, inertia = 0.003", ORACLE_FLUX,
     0.0, 157.0796, -4.0, 10.0, 150, 0.0, 0.0},
    {"with a loss of the iron on a machine that saturates",
     "saturation_d = 5, saturation_q = 5, iron_loss_resistance = 150, load_kind = 1, load_torque = 3, "
     "inertia = "
     "0.01",
     ORACLE_FLUX, 20.0, -120.0, 0.0, 8.0, 150, 0.0, 0.0},
    {"with EMF harmonics", "emf_5th = 0.05, emf_7th = -0.03, load_torque = 5, inertia = 0.003",
     ORACLE_STATIONARY, 100.0, 157.0796, 0.0, 10.0, 500, 0.0, 0.0},
    {"at three tenths of a radian per period",
     "flux_linkage = 0.04, inductance_d = 0.002, inductance_q = 0.003, shaft_locked = 1, shaft_locked_speed "
     "= 750",
     ORACLE_ROTOR, 0.0, 766.0, -2.0, 8.0, 250, 0.0, 0.0},
    {"with unlike device slopes and no delays",
     "turn_on_delay = 0, turn_off_delay = 0, igbt_resistance = 0.05, diode_resistance = 0.01, current_zone = "
     "0.2",
     ORACLE_STATIONARY, 60.0, 100.0, 1.0, 6.0, 500, 0.0, 0.0},
};

/* The limit is 1 mA. The angle error that a current error of 1 mA could hide is 1 mA/10 A of an electrical
 * radian. */
static void test_currents_follow_the_oracle(void)
{
    for (size_t n = 0; n < sizeof drives / sizeof drives[0]; n++) {
        const plant_params_t q = plant_of(drives[n].changes);
        const distance_t far = run(&q, drives[n].frame, drives[n].start, drives[n].target, drives[n].i_d,
                                   drives[n].most, drives[n].periods);
        TEST_ASSERT_TRUE_MESSAGE(far.largest > 1.0, drives[n].name); /* currents did flow */
        TEST_ASSERT_TRUE_MESSAGE(far.current < 1e-3, drives[n].name);
        TEST_ASSERT_TRUE_MESSAGE(far.angle < 1e-3 / 10.0 / 4.0, drives[n].name);
        if (drives[n].within > 0.0) {
            TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(drives[n].within, drives[n].end,
                                              seen[drives[n].periods - 1].omega_m, drives[n].name);
        }
    }
}
