/* The conditions: which run each figure needs. */
#include <math.h>
#include <stdio.h>

#include "host_sim/lab/paper_parts.h"

#define OMEGA_S 2500.0 /* [rad/s] of the EMF filter (11); the print has none */

const paper_figure_t paper_figures[PAPER_FIGURES] = {
    [FIG04] = {.id = "fig04"},
    [FIG05] = {.id = "fig05"},
    [FIG08] = {.id = "fig08"},
    [FIG10] = {.id = "fig10"},
    [FIG11] = {.id = "fig11"},
    [FIG12] = {.id = "fig12"},
    [FIG13] = {.id = "fig13"},
    [FIG14] = {.id = "fig14"},
    [FIG15] = {.id = "fig15", .more = "dead_time"},
    [FIG16] = {.id = "fig16"},
    [FIG17] = {.id = "fig17"},
    [BEYOND_SPEED] = {.id = "beyond_speed",
                      .title = "what each lag compensation leaves over speed",
                      .claim =
                          "lagless leaves less than a milliradian where the paper's formula leaves tens"},
    [BEYOND_BANDWIDTH] =
        {.id = "beyond_bandwidth",
         .title = "tracking error through speed steps over bandwidth",
         .claim = "feed-forward needs no bandwidth to track; told the torque, the loop hardly errs"},
    [BEYOND_MAP] =
        {.id = "beyond_map",
         .title = "what wrong beliefs about machine and sensors cost",
         .claim = "a wrong L turns the angle by -asin(dL i_q/psi_f); wrong R and psi_f do not; and what the "
                  "drive learns takes L and dead time away"},
};

const char *const load_names[2] = {"nl", "rated"};
#define SMOOTH(ks, cutoff) .switching = SIGMOID, .gain = ks, .omega_s = cutoff
#define LOOP(b, wc)        SMOOTH(KS, OMEGA_S), .lag = LAG_EXACT, .bandwidth = b, .omega_c = wc

/* ---- sweeps ---- */

/* None is a whole number of samples per revolution (see map_setup_default). */
const double speeds_beyond[SPEEDS_BEYOND] = {101.0, 203.0, 307.0, 503.0, 757.0, 1013.0, 1259.0, 1490.0};
const double bandwidths_beyond[BANDWIDTHS_BEYOND] = {50.0, 75.0, 100.0, 150.0, 200.0, 300.0, 400.0};
const char *const speed_variants[VARIANTS_BEYOND] = {"uncompensated", "printed", "lagless"};
const char *const bandwidth_variants[VARIANTS_BEYOND] = {"conventional", "feedforward", "torque_feedforward"};

static run_t speed_run(int variant, int speed, int load)
{
    run_t run = {.figure = BEYOND_SPEED,
                 .profile = HOLD,
                 .rpm = speeds_beyond[speed],
                 .length = 1.0,
                 .load = load == 0 ? 0.0 : RATED,
                 LOOP(200.0, 50.0)};
    if (variant == V_LAGLESS) {
        run.switching = SIGMOID_VECTOR;
    } else { /* (14) knows no filter */
        run.omega_s = 0.0;
        run.lag = variant == V_PRINTED ? LAG_PRINTED : LAG_NONE;
    }
    snprintf(run.name, sizeof run.name, "%s_%s_%d", speed_variants[variant], load_names[load], speed);
    return run;
}

static run_t bandwidth_run(int variant, int bandwidth, int load)
{
    const double b = bandwidths_beyond[bandwidth];
    run_t run = {.figure = BEYOND_BANDWIDTH,
                 .profile = QUICK_STEPS,
                 .load = load == 0 ? 0.0 : RATED,
                 LOOP(b, variant == V_CONVENTIONAL ? 0.0 : 0.25 * b),
                 .torque = variant == V_TORQUE_FEEDFORWARD};
    run.switching = SIGMOID_VECTOR;
    snprintf(run.name, sizeof run.name, "%s_%s_%d", bandwidth_variants[variant], load_names[load], bandwidth);
    return run;
}

const char *paper_variant(const run_t *run)
{
    if (run->figure == BEYOND_SPEED) {
        return speed_variants[run->lag == LAG_NONE      ? V_UNCOMPENSATED
                              : run->lag == LAG_PRINTED ? V_PRINTED
                                                        : V_LAGLESS];
    }
    return bandwidth_variants[run->torque           ? V_TORQUE_FEEDFORWARD
                              : run->omega_c == 0.0 ? V_CONVENTIONAL
                                                    : V_FEEDFORWARD];
}

/* ---- all of them ---- */

typedef struct {
    const bool *wanted;
    flavoured_t *to;
    size_t count;
} plan_t;

static void plan(plan_t *plan, const run_t *run)
{
    for (int real = run->flavours == BOTH ? 0 : 1; real <= 1 && plan->wanted[run->figure]; real++) {
        if (plan->to != NULL) {
            plan->to[plan->count] = (flavoured_t){*run, real != 0};
        }
        plan->count++;
    }
}

size_t paper_plan(const bool wanted[PAPER_FIGURES], flavoured_t *to)
{
    plan_t all = {.wanted = wanted, .to = to};
    for (int n = 0; n < VARIANTS_BEYOND * 2 * SPEEDS_BEYOND; n++) {
        const run_t run = speed_run(n / (2 * SPEEDS_BEYOND), n % SPEEDS_BEYOND, n / SPEEDS_BEYOND % 2);
        plan(&all, &run);
    }
    for (int n = 0; n < VARIANTS_BEYOND * 2 * BANDWIDTHS_BEYOND; n++) {
        const run_t run =
            bandwidth_run(n / (2 * BANDWIDTHS_BEYOND), n % BANDWIDTHS_BEYOND, n / BANDWIDTHS_BEYOND % 2);
        plan(&all, &run);
    }
    return all.count;
}

/* ---- what happens during each ---- */

/* At 10 A the rotor takes 1.0 s from 100 to 1500 r/min, 2.0 s with 5 N m; the speed control settles with a
 * time constant of 0.2 s. */
static const course_t courses[PROFILES] = {
    [HOLD] = {.window_count = 1},
    [STEPS] = {100.0,
               11.0,
               {{2.0, 1500.0}, {8.0, 1000.0}},
               2,
               {{0.0, 2.0, 100.0, 100.0},
                {2.0, 6.0, 100.0, 1500.0},
                {6.5, 8.0, 1500.0, 1500.0},
                {8.0, 10.5, 1500.0, 1000.0},
                {10.5, 11.0, 1000.0, 1000.0}},
               5},
    [QUICK_STEPS] = {100.0,
                     6.0,
                     {{1.0, 1500.0}, {4.5, 1000.0}},
                     2,
                     {{0.0, 1.0, 100.0, 100.0},
                      {1.0, 4.0, 100.0, 1500.0},
                      {4.0, 4.5, 1500.0, 1500.0},
                      {4.5, 5.5, 1500.0, 1000.0},
                      {5.5, 6.0, 1000.0, 1000.0}},
                     5},
};

course_t paper_course(const run_t *run)
{
    course_t course = courses[run->profile];
    if (run->profile == HOLD) {
        const double turn = 60.0 / (paper_machine.pole_pairs * run->rpm); /* electrical [s] */
        course.length = ceil(run->length / turn) * turn;
        course.windows[0].end = course.length;
    }
    if (run->profile == HOLD) {
        course.rpm = run->rpm;
        for (size_t n = 0; n < course.window_count; n++) {
            course.windows[n].from = run->rpm;
            course.windows[n].to = run->rpm;
        }
    }
    return course;
}

/* ---- in words ---- */

const char *const paper_switching_names[] = {"sign", "sigmoid", "vector sigmoid"};
const char *const paper_lag_names[] = {"none", "printed", "corrected", "exact"};

void paper_describe(char *to, size_t size, const run_t *run, bool real)
{
    static const char *const switchings[] = {"sign", "sigmoid 1/A per axis", "sigmoid 1/A of the vector"};
    static const char *const lags[] = {"none", "(14) as printed", "(14) corrected", "exact"};
    static const char *const profiles[PROFILES] = {
        [STEPS] = "100-1500-1000 r/min", [QUICK_STEPS] = "100-1500-1000 r/min"};
    char flavour[120] = "ideal inverter and sensors";
    char profile[40];
    if (real) {
        char dead_time[60] = "2.5 us dead time, compensated";
        if (run->dead_time > 0.0) {
            snprintf(dead_time, sizeof dead_time, "%g us dead time in effect, not compensated",
                     run->dead_time);
        }
        snprintf(flavour, sizeof flavour, "%s, 12-bit ADC, noise 10 mA, offset 30 mA, gain error 0.2 %%",
                 dead_time);
    }
    if (profiles[run->profile] != NULL) {
        snprintf(profile, sizeof profile, "%s", profiles[run->profile]);
    } else {
        snprintf(profile, sizeof profile, "%g r/min", run->rpm);
    }
    snprintf(to, size,
             "%s%s; %s, load %g N m, friction %g N m, J %g kg m^2; %s; %s, k_s %g V, omega_s %g rad/s, lag "
             "compensation %s; PLL %g rad/s, damping 1, omega_c %g rad/s%s; speed PI 0.5, 2.5, 10 A",
             flavour, real && run->figure == FIG16 ? ", EMF with 1 % 5th and 0.5 % 7th" : "", profile,
             run->load, paper_machine.friction, paper_machine.inertia, "sensorless",
             switchings[run->switching], run->gain, run->omega_s, lags[run->lag], run->bandwidth,
             run->omega_c, run->torque ? ", told the torque" : "");
}
