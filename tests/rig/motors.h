/* The paper's motor, and motors with very different data: the tests of the estimate and of learning run
 * all of them. */
#ifndef TESTS_RIG_MOTORS_H
#define TESTS_RIG_MOTORS_H

#include "tests/rig/run.h"

/* A motor and its rated load, with the limits of current and link. */
typedef struct {
    const char *name;
    run_motor_t motor;
    double load, current, dc_voltage; /* [N m], [A], [V] */
} rated_motor_t;

/* The motor of Table I in its test rig. */
static const rated_motor_t paper = {
    "paper", {4.0, 0.95, 12.5e-3, 0.183, 0.0636, 1.32, 1500.0 * RPM, 8.0}, 5.0, 10.0, 311.0};

/* A fast and light motor: omega_e T_s = 0.3 with one pole pair at 28648 r/min. */
static const rated_motor_t spindle = {
    "spindle", {1.0, 0.4, 0.6e-3, 0.03, 5e-5, 0.03, 3000.0, 40.0}, 0.3, 10.0, 200.0};

/* A motor with many pole pairs, the same electrical frequency and a very small inductance. */
static const rated_motor_t hub = {
    "hub", {15.0, 0.12, 0.35e-3, 0.015, 0.02, 0.3, 200.0, 20.0}, 2.5, 12.0, 100.0};

/* A slow motor with large resistance, inductance, flux and inertia. */
static const rated_motor_t direct = {
    "direct", {20.0, 12.0, 60e-3, 0.55, 0.5, 3.0, 13.0, 20.0}, 30.0, 3.0, 400.0};

/* A motor with a dominant resistance: R T_s/L = 0.4; the limit of the observer is 0.5. */
static const rated_motor_t miniature = {
    "miniature", {2.0, 8.0, 2e-3, 0.02, 2e-5, 0.01, 1000.0, 40.0}, 0.06, 1.5, 100.0};

static inline double rated_trip(const rated_motor_t *m)
{
    return fmin(1.5 * m->current, 0.95 * (double)DRIVE_CURRENT_RANGE);
}

/* Sets the motor in plant and firmware, with suitable limits. To be called before the state ready; the
 * parameters are staged. */
static inline void rated_put(rig_t *rig, const rated_motor_t *m)
{
    run_put_motor(rig, &m->motor);
    run_put(rig, "dc_voltage", m->dc_voltage);
    run_put(rig, "current_limit", m->current);
    run_put(rig, "overcurrent_trip", rated_trip(m));
    run_put(rig, "dc_overvoltage", 1.1 * m->dc_voltage);
    run_put(rig, "dc_undervoltage", 0.6 * m->dc_voltage);
    run_put(rig, "overspeed_trip", 1.15 * m->motor.speed);
}

#endif
