/* Common parts of the tests of the start without an encoder: two shafts, the values that are measured in
 * every period, grids of starts, and the line of measured values that each grid prints. Inverter and
 * sensors have realistic errors (defaults and run_real()). Angles are spread over an electrical turn; each
 * point of a grid has noise of its own. */
#ifndef TESTS_RIG_START_H
#define TESTS_RIG_START_H

#include "tests/rig/run.h"

#define PI 3.14159265358979323846

#define POLE_PAIRS   4.0
#define RATED_TORQUE 5.0 /* [N m] */

/* the manoeuvres */
enum { OFF, CATCHES, ALIGNS, RAMPS, HANDS_OVER, RUNS, FORCES, REVERSES, RELOCKS };

/* ---- shafts ---- */

/* HEAVY: the paper's test rig. LIGHT: the bare motor, with the bandwidths that a light rotor needs. BARE:
 * as LIGHT, without friction. */
typedef enum { HEAVY, LIGHT, BARE } start_shaft_t;
#define START_SHAFT_NAMES "HLB" /* letters in the printed lines */

typedef struct {
    double inertia, friction; /* [kg m^2], [N m] */
} start_shaft_data_t;
static const start_shaft_data_t start_shaft_data[] = {{0.0636, 1.32}, {0.003, 0.05}, {0.003, 0.0}};

/* The number of shafts of a case in a table, counted from the first one on. */
#define START_BOTH 2u
#define START_ALL  3u

/* A row that a test changes. */
typedef struct {
    const char *name;
    double value;
} start_row_t;

/* A simulation at power-on, before any parameters are applied. */
static inline rig_t *start_on_desk(start_shaft_t shaft, uint32_t seed)
{
    rig_t *rig = run_rig(seed);
    if (shaft != HEAVY) {
        run_put(rig, "inertia", start_shaft_data[shaft].inertia);
        run_put(rig, "friction_coulomb", start_shaft_data[shaft].friction);
        run_put(rig, "motor_inertia", start_shaft_data[shaft].inertia);
        run_put(rig, "pll_bandwidth", 400.0);
        run_put(rig, "feedforward_cutoff", 125.0);
    }
    return rig;
}

/* Applies the parameters and runs to the state ready, with the rotor at rest at this electrical angle
 * [rad]. The errors of the sensors are set after their calibration. */
static inline void start_ready(rig_t *rig, double theta_e)
{
    if (!rig_apply(rig)) {
        TEST_FAIL_MESSAGE(rig_error(rig));
    }
    rig_set_motion(rig, theta_e / POLE_PAIRS, 0.0);
    run_to_ready(rig);
    run_real(rig);
}

/* ---- measurements in every period ---- */

typedef struct {
    /* of the last period */
    double current;    /* length of the current vector [A] */
    double error, err; /* [rad] theta_hat - true theta_e; error of the angle in use */
    double speed;      /* [r/min] true speed */
    double torque;     /* [N m] true torque */
    int manoeuvre, start_try, losses, fault, state;
    /* since the begin of the recording */
    double peak; /* largest true phase current [A] */
    /* [s] time for which the angle in use has been wrong by 0.8 rad, and the longest such time. */
    double bad, bad_most;
    /* [-]; [periods] present one; the one of the first fault or warning. */
    uint32_t warnings, period, noticed;
} start_seen_t;

#define START_SEEN_FLOATS 9u
static const char *const start_seen_rows[] = {"i_alpha",     "i_beta",    "theta_hat_err", "true_omega_m",
                                              "true_torque", "theta_err", "true_i_a",      "true_i_b",
                                              "true_i_c",    "manoeuvre", "start_try",     "state",
                                              "lock_losses", "warnings",  "fault_reason"};
#define START_SEEN_ROWS (sizeof start_seen_rows / sizeof start_seen_rows[0])

static inline void start_see(void *context, uint32_t period, const uint32_t *slots, uint32_t count)
{
    start_seen_t *seen = context;
    float value[START_SEEN_FLOATS];
    (void)count;
    memcpy(value, slots, sizeof value);
    seen->current = hypot((double)value[0], (double)value[1]);
    seen->error = (double)value[2];
    seen->speed = (double)value[3] / RPM;
    seen->torque = (double)value[4];
    seen->err = (double)value[5];
    for (uint32_t n = 6u; n < START_SEEN_FLOATS; n++) {
        seen->peak = fmax(seen->peak, fabs((double)value[n]));
    }
    slots += START_SEEN_FLOATS;
    seen->manoeuvre = (int)slots[0];
    seen->start_try = (int)slots[1];
    seen->state = (int)slots[2];
    seen->losses = (int)slots[3];
    seen->warnings |= slots[4];
    seen->fault = (int)slots[5];
    seen->period = period;
    if (seen->noticed == 0u && (seen->fault != 0 || seen->warnings != 0u)) {
        seen->noticed = period;
    }
    const bool wrong = seen->fault == 0 && fabs(seen->err) > 0.8 && fabs(seen->speed) > 20.0;
    seen->bad = wrong ? seen->bad + RIG_PERIOD_SECONDS : 0.0;
    seen->bad_most = fmax(seen->bad_most, seen->bad);
}

/* Writes the values of each period into `seen` from now on. */
static inline void start_watch(rig_t *rig, start_seen_t *seen)
{
    *seen = (start_seen_t){0};
    run_tap(rig, start_seen_rows, START_SEEN_ROWS, start_see, seen);
}

/* ---- results of a grid ---- */

static inline void start_raise(double *largest, double value)
{
    *largest = fmax(*largest, value);
}

/* The seconds since this period. */
static inline double start_time(uint32_t periods)
{
    return periods * RIG_PERIOD_SECONDS;
}

#endif
