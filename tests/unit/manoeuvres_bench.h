/* Both halves of the manoeuvres with a machine: manoeuvres.h runs once in a window, reference.h in each
 * period. The setpoint of window n acts in window n + 2. The currents of the machine are those that were
 * requested a period ago, the EMF is observed without error, and the tracking loop has the true angle. */
#ifndef TESTS_UNIT_MANOEUVRES_BENCH_H
#define TESTS_UNIT_MANOEUVRES_BENCH_H

#include <string.h>

#include "medium/manoeuvre/manoeuvres.h"
#include "tests/unit/vectors.h"

#define T          1e-4
#define PSI        0.183
#define POLE_PAIRS 4.0
#define KT         (1.5 * POLE_PAIRS * PSI)
#define W          8u     /* number of periods in a window */
#define U_DC       310.0f /* [V] */

static manoeuvres_t m;
static manoeuvres_tuning_t tuning;
static reference_t fast;
static reference_tuning_t fast_tuning;
static setpoint_t made, next, setpoint; /* newest setpoint, that of the next window, active one */
static uint32_t window;                 /* number of completed windows */
static struct {
    uint32_t tracked;
    double complex current, emf; /* sums over a window [A], [V] */
    double scatter;
} sum;
static params_t params;

static struct {
    double theta, omega_m;  /* [rad] electrical, [rad/s] mechanical */
    double inertia;         /* [kg m^2] */
    double friction;        /* [N m] opposes the motion, and holds the shaft at zero speed */
    bool blocked;           /* the shaft is held */
    double detector;        /* [-] reading of the detector of the loop's error */
    uint32_t coasts;        /* [periods] in each window for which the loop coasts; its detector is 0 then */
    double wrong_r;         /* [ohm] by which the configured R is too large */
    double astray;          /* [rad/s] electrical speed of a loop that has left the rotor; 0: it follows */
    double complex current; /* [A] */
} machine;

static estimate_t estimate;
static run_wish_t wish;
static demand_t demand;
static bool lost;
static bool again; /* the same parameters are applied again in each window, which must not change anything */
static uint32_t period, in_window;

/* Names of the manoeuvres in the order in which they occurred. */
static struct {
    int32_t name;
    uint32_t period;
} trace[32];
static int traced;

static inline void tune(void)
{
    const assumed_t assumed = params_configured(&params);
    tuning = manoeuvres_prepare(&params, &assumed);
    fast_tuning = reference_prepare(&params, &assumed);
}

/* Clears the orders, because each order is obeyed once. */
static inline void forget_orders(void)
{
    made.enter = 0u;
    made.change = FRAME_GOES_ON;
    made.lock = LOCK_KEEP;
    made.stiffness = 0.0f;
}

/* The bridge turns on with the next window. */
static inline void start(void)
{
    memset(&made, 0, sizeof made);
    memset(&sum, 0, sizeof sum);
    made.number = window;
    manoeuvres_begin(&m, (float)machine.omega_m, &made);
    next = made;
    forget_orders();
    in_window = 0u;
}

static inline void begin(void)
{
    tune();
    memset(&m, 0x55, sizeof m);
    manoeuvres_init(&m, &tuning);
    memset(&fast, 0x55, sizeof fast);
    reference_init(&fast);
    start();
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
    wish = (run_wish_t){RUN_SPEED, 50.0f, {0.0f, 0.0f}, 0.0f};
    demand =
        (demand_t){{0.0f, 0.0f, {0.0f, 1.0f}}, FRAME_GOES_ON, {0.0f, 0.0f}, {0.0f, 0.0f}, EMF_OTHER, 0.0f};
    lost = false;
    again = false;
    period = 0u;
    window = 0u;
    traced = 0;
}

static inline double torque_of_current(void)
{
    return KT * cimag(machine.current * cexp(-J * machine.theta));
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
        J * POLE_PAIRS * machine.omega_m * PSI * cexp(J * machine.theta) - machine.wrong_r * machine.current;
    estimate.emf = to_ab(emf);
    estimate.amplitude = (float)cabs(emf);
    if (fast.tracking != 0u) {
        estimate.frame = true_frame();
        if (machine.astray != 0.0) {
            estimate.frame.omega_e = (float)machine.astray;
        }
        estimate.omega_smooth = estimate.frame.omega_e;
        estimate.detector = in_window < machine.coasts ? 0.0f : (float)machine.detector;
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

/* Adds a period to the sums of the fast task. */
static inline void sum_up(void)
{
    sum.tracked += in_window < machine.coasts ? 0u : fast.tracking;
    sum.current += machine.current;
    sum.emf += of_ab(estimate.emf);
    sum.scatter += (double)estimate.detector * (double)estimate.detector;
}

/* The mean of a window's sum, rotated from the middle of the window to its end by the estimate. */
static inline ab_t mean_at_end(double complex of)
{
    const double turn = 0.5 * (W - 1) * T * (double)estimate.omega_smooth;
    const double complex mean = of / W * cexp(J * turn);
    return to_ab(mean);
}

/* The i_q [A] that the newest setpoint gives at the speed of the machine. */
static inline double made_i_q(void)
{
    return (double)made.current.q - (double)made.stiffness * machine.omega_m;
}

/* Runs the medium task: its result of this window takes effect in the window after the next. */
static inline void close_window(const position_t *encoder, float omega_m)
{
    estimate_t seen = estimate;
    seen.emf_loop = frames_park(mean_at_end(sum.emf), estimate.frame.rotation);
    seen.flux = params.motor_flux_linkage;
    seen.coasted = sum.tracked < W ? 1u : 0u;
    const manoeuvres_input_t input = {
        .estimate = &seen,
        .current = frames_park(mean_at_end(sum.current), estimate.frame.rotation),
        .sample = {(float)creal(machine.current), (float)cimag(machine.current)},
        .scatter = (float)(sum.scatter / W),
        .tracked = sum.tracked,
        .encoder = *encoder,
        .omega_m = omega_m,
        .wish = wish,
        .losses = lost ? 1u : 0u,
        .outcome = fast.outcome,
        .setpoint = setpoint.number,
    };
    next = made;
    made.number = ++window;
    forget_orders();
    run_limit(&m.run, -params.current_limit, params.current_limit);
    manoeuvres_step(&m, &input, &made);
    if (again) {
        tune();
        manoeuvres_take(&m, &tuning);
    }
    memset(&sum, 0, sizeof sum);
    in_window = 0u;
}

/* Runs a period. */
static inline void step(void)
{
    const double angle = (double)demand.frame.theta_e + T * (double)demand.frame.omega_e;
    const double complex asked = of_dq(demand.current);
    if (in_window == 0u) {
        setpoint = next;
        reference_take(&fast, &fast_tuning, &setpoint);
    }
    machine.current = asked * cexp(J * angle);
    turn_machine();
    reference_advance(&fast, &fast_tuning);
    observe();
    const frame_t encoder = true_frame();
    const position_t position = {encoder.theta_e, encoder.omega_e};
    const frame_t rotor = reference_tracks(&fast) ? estimate.frame : reference_rotor(&fast, &encoder);
    const reference_input_t input = {
        .u_dc = U_DC,
        .estimate = &estimate,
        .position = &position,
        .encoder = &encoder,
        .omega_m = rotor.omega_e * m.limits.pole_pairs_inverse,
        .estimating = 1u,
        .period = in_window,
    };
    sum_up();
    period++;
    in_window++;
    reference_step(&fast, &fast_tuning, &setpoint, &input, &demand);
    if (fast.source == (int32_t)SOURCE_ESTIMATE || fast.source == (int32_t)SOURCE_ENCODER) {
        demand.current.q = bounds_clamp(demand.current.q, run_room(&m.run));
    }
    if (fast.locking != 0u) {
        estimate.frame = (frame_t){fast.locked.theta_e, fast.locked.omega_e, {0.0f, 1.0f}};
        estimate.omega_smooth = fast.locked.omega_e;
    }
    if (in_window == W) {
        close_window(&position, rotor.omega_e * m.limits.pole_pairs_inverse);
    }
    note();
}

/* Runs to the end of the window. */
static inline void window_step(void)
{
    do {
        step();
    } while (in_window != 0u);
}

static inline void windows(uint32_t count)
{
    for (uint32_t n = 0; n < count; n++) {
        window_step();
    }
}

static inline void steps(double seconds)
{
    for (double t = 0.5 * T; t < seconds; t += T) {
        step();
    }
}

/* Runs periods until this manoeuvre is active. */
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

/* The current in a frame at this angle: d + j q [A]. */
static inline double complex current_in(double theta)
{
    return machine.current * cexp(-J * theta);
}

static inline void make_heavy(void)
{
    params.motor_inertia = 0.0636f;
    machine.inertia = 0.0636;
    machine.friction = 1.32;
}

/* The lock is lost in this window. */
static inline void lose(void)
{
    lost = true;
    window_step();
    lost = false;
    TEST_ASSERT_EQUAL_INT32(MANOEUVRE_RELOCK, m.now);
}

#endif
