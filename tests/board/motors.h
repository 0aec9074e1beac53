/* A motor that fits the board, with parameters by the rules of docs/motors.md, and the facts of the board
 * in SI units. */
#ifndef TESTS_BOARD_MOTORS_H
#define TESTS_BOARD_MOTORS_H

#include "tests/rig/run.h"

#if BOARD_DC_NOMINAL_MV >= 200000
/* The motor of the paper's Table I with the inertia and friction of its test rig. */
static const run_motor_t board_motor = {.pole_pairs = 4.0,
                                        .resistance = 0.95,
                                        .inductance = 12.5e-3,
                                        .flux_linkage = 0.183,
                                        .inertia = 0.0636,
                                        .friction = 1.32,
                                        .speed = 1500.0 * RPM,
                                        .bandwidth = 8.0};
#define BOARD_RATED_TORQUE 5.0 /* [N m]; current_limit gives more */
#elif BOARD_CURRENT_LIMIT_MA >= 60000
/* The 48 V motor below with twice the current and half the impedance. For a smaller motor the steps of
 * this board's current sensors would be too coarse. */
static const run_motor_t board_motor = {.pole_pairs = 4.0,
                                        .resistance = 0.04,
                                        .inductance = 0.1e-3,
                                        .flux_linkage = 0.0145,
                                        .inertia = 4e-3,
                                        .friction = 0.4,
                                        .speed = 3500.0 * RPM,
                                        .bandwidth = 20.0};
#define BOARD_RATED_TORQUE 3.48
#else
/* 48 V, 640 W at 3500 r/min. The EMF is 21.3 V of the 27.7 V per phase that the link allows; 20 A make
 * 1.74 N m. Inertia and friction include the load, a small pump, which takes 2.3 A (the paper's rig takes
 * 1.2 A of its 10 A). With bearing friction alone, the switching ripple of about 2 A would change the sign
 * of the current within a period, and dead time cannot be compensated by the sign of the current then. */
static const run_motor_t board_motor = {.pole_pairs = 4.0,
                                        .resistance = 0.08,
                                        .inductance = 0.2e-3,
                                        .flux_linkage = 0.0145,
                                        .inertia = 2e-3,
                                        .friction = 0.2,
                                        .speed = 3500.0 * RPM,
                                        .bandwidth = 20.0};
#define BOARD_RATED_TORQUE 1.74
#endif

#define BOARD_RATED_RPM     (board_motor.speed / RPM)
#define BOARD_LIMIT_AMPERES (BOARD_CURRENT_LIMIT_MA / 1e3) /* [A] */

static inline double board_torque_per_ampere(void)
{
    return 1.5 * board_motor.pole_pairs * board_motor.flux_linkage;
}

/* From power-on to ready: 64 samples for the settling and 512 for the average, whatever the carrier is. If
 * a speed is given, the rotor turns at it, and friction is off meanwhile so that the speed remains. */
static inline void board_to_ready_at(rig_t *rig, double speed)
{
    const double friction = rig_value(rig, "friction_coulomb");
    run_put(rig, "friction_coulomb", 0.0);
    rig_set_motion(rig, 0.0, speed);
    rig_run(rig, seed_phase() + 64u + 512u + 24u);
    TEST_ASSERT_EQUAL_DOUBLE(1.0, rig_value(rig, "state"));
    run_put(rig, "friction_coulomb", friction);
}

/* Gives the motor to plant and firmware. The drive uses the encoder or the estimate. It uses the estimate
 * at low speed, too. The limits are those of the board. By the rules in docs/motors.md ("Rules used by
 * `lagless tune`") the feed-forward has 50 rad/s or 1.6 sqrt(p T/J), and the PLL has four times that. */
static inline void board_put_motor(rig_t *rig)
{
    const run_motor_t *m = &board_motor;
    const double cutoff = fmax(50.0, 1.6 * sqrt(m->pole_pairs * BOARD_RATED_TORQUE / m->inertia));
    run_paper_drive(rig);
    run_put_motor(rig, m);
    run_put(rig, "handover_speed", 0.05 * m->speed);
    run_put(rig, "fallback_speed", 0.02 * m->speed);
    run_put(rig, "overspeed_trip", 1.4 * m->speed);
    run_put(rig, "feedforward_cutoff", cutoff);
    run_parameter(rig, "pll_bandwidth", 4.0 * cutoff);
}

#endif
