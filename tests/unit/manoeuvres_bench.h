/* The manoeuvres with a machine: currents are those that were asked for a period ago, the EMF is observed
 * without error, and a loop that tracks is on the rotor. */
#ifndef TESTS_UNIT_MANOEUVRES_BENCH_H
#define TESTS_UNIT_MANOEUVRES_BENCH_H

#include <complex.h>
#include <string.h>
#include <unity.h>

#include "drive/manoeuvres.h"
#include "tests/unit/compare.h"

#define T          1e-4
#define PSI        0.183
#define POLE_PAIRS 4.0
#define KT         (1.5 * POLE_PAIRS * PSI)
#define LINK       179.0f /* [V] 311 V of DC link */

static manoeuvres_t m;
static manoeuvres_tuning_t tuning;
static params_t params;

static struct {
    double theta, omega_m;  /* [rad] electrical, [rad/s] mechanical */
    double inertia;         /* [kg m^2] */
    double friction;        /* against the speed, and holds it at zero [N m] */
    bool blocked;           /* the shaft is held */
    double detector;        /* of the loop's error, every other period [-] */
    double complex current; /* [A] */
} machine;

static estimate_t estimate;
static run_wish_t wish;
static demand_t demand;
static bool lost;
static uint32_t period;

/* Names in the order in which they came. */
static struct {
    int32_t name;
    uint32_t period;
} trace[32];
static int traced;

static inline void tune(void)
{
    const believed_t believed = params_believed(&params);
    tuning = manoeuvres_prepare(&params, &believed);
}

static inline void begin(void)
{
    tune();
    memset(&m, 0x55, sizeof m);
    manoeuvres_init(&m, &tuning);
    manoeuvres_begin(&m, (float)machine.omega_m);
}

void setUp(void)
{
    params_defaults(&params);
    params.motor_inertia = 0.003f;
    params.low_speed_current = 0.0f;
    params.inductance_adaptation = 0.0f;
    memset(&machine, 0, sizeof machine);
    memset(&estimate, 0, sizeof estimate);
    machine.inertia = 0.003;
    machine.friction = 0.05;
    wish = (run_wish_t){RUN_SPEED, 50.0f, {0.0f, 0.0f}};
    demand = (demand_t){{0.0f, 0.0f, {0.0f, 1.0f}}, FRAME_GOES_ON, {0.0f, 0.0f}, {0.0f, 0.0f}, 0.0f};
    lost = false;
    period = 0u;
    traced = 0;
}

static inline double torque_of_current(void)
{
    return KT * cimag(machine.current * cexp(-(double complex)I * machine.theta));
}

static inline void turn_machine(void)
{
    const double torque = torque_of_current();
    const double free = machine.omega_m + T * torque / machine.inertia;
    const double held = T * machine.friction / machine.inertia;
    machine.omega_m = fabs(free) <= held ? 0.0 : free - (free > 0.0 ? held : -held);
    if (machine.blocked) {
        machine.omega_m = 0.0;
    }
    machine.theta = circle(machine.theta + T * POLE_PAIRS * machine.omega_m);
}

static inline frame_t true_frame(void)
{
    return (frame_t){(float)machine.theta,
                     (float)(POLE_PAIRS * machine.omega_m),
                     {(float)sin(machine.theta), (float)cos(machine.theta)}};
}

static inline void observe(void)
{
    const double complex emf =
        (double complex)I * POLE_PAIRS * machine.omega_m * PSI * cexp((double complex)I * machine.theta);
    estimate.emf = (ab_t){(float)creal(emf), (float)cimag(emf)};
    estimate.amplitude = (float)cabs(emf);
    if (m.tracking != 0u) {
        estimate.frame = true_frame();
        estimate.omega_smooth = estimate.frame.omega_e;
        estimate.detector = (float)machine.detector;
    }
}

static inline void note(void)
{
    if (traced == 0 || trace[traced - 1].name != m.now) {
        TEST_ASSERT_TRUE(traced < 32);
        trace[traced].name = m.now;
        trace[traced++].period = period;
    }
}

static inline void step(void)
{
    const double angle = (double)demand.frame.theta_e + T * (double)demand.frame.omega_e;
    const double complex asked = (double)demand.current.d + (double complex)I * (double)demand.current.q;
    machine.current = asked * cexp((double complex)I * angle);
    turn_machine();
    manoeuvres_advance(&m);
    observe();
    const frame_t encoder = true_frame();
    const frame_t rotor = manoeuvres_rotor(&m, &encoder, &estimate);
    const manoeuvres_input_t input = {
        .current = {(float)creal(machine.current), (float)cimag(machine.current)},
        .voltage_max = LINK,
        .estimate = &estimate,
        .encoder = &encoder,
        .omega_m = manoeuvres_smooth(&m, &rotor, &estimate) * m.limits.pole_pairs_inverse,
        .wish = wish,
        .estimating = 1u,
        .losses = lost ? 1u : 0u,
    };
    period++;
    manoeuvres_step(&m, &input, &demand);
    if (m.locking != 0u) {
        estimate.frame = (frame_t){m.locked.theta_e, m.locked.omega_e, {0.0f, 1.0f}};
        estimate.omega_smooth = m.locked.omega_e;
    }
    note();
}

static inline void steps(double seconds)
{
    for (double t = 0.5 * T; t < seconds; t += T) {
        step();
    }
}

/* Periods until this one is under way. */
static inline uint32_t steps_until(manoeuvre_t manoeuvre, double most_seconds)
{
    const uint32_t from = period;
    while (m.now != (int32_t)manoeuvre && (period - from) * T < most_seconds) {
        step();
    }
    TEST_ASSERT_EQUAL_INT32(manoeuvre, m.now);
    return period - from;
}

#define EXPECT_TRACE(...)                                                                                    \
    expect_trace((manoeuvre_t[]){__VA_ARGS__},                                                               \
                 (int)(sizeof((manoeuvre_t[]){__VA_ARGS__}) / sizeof(manoeuvre_t)))
static inline void expect_trace(const manoeuvre_t *names, int count)
{
    for (int n = 0; n < count && n < traced; n++) {
        TEST_ASSERT_EQUAL_INT32(names[n], trace[n].name);
    }
    TEST_ASSERT_EQUAL_INT(count, traced);
    traced = 0;
}

/* Current in a frame: d + j q [A]. */
static inline double complex current_in(double theta)
{
    return machine.current * cexp(-(double complex)I * theta);
}

static inline void make_heavy(void)
{
    params.motor_inertia = 0.0636f;
    machine.inertia = 0.0636;
    machine.friction = 1.32;
}

/* The lock is lost in this period. */
static inline void lose(void)
{
    lost = true;
    step();
    lost = false;
    TEST_ASSERT_EQUAL_INT32(MANOEUVRE_RELOCK, m.now);
}

#endif
