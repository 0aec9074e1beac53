/* The rows of the paper's figures. */
#include <math.h>
#include <stdio.h>

#include "host_sim/lab/paper_parts.h"

/* ---- measured figures ---- */

/* The largest error while accelerating of the feed-forward loops of a sweep, by magnitude. */
static const result_t *worst_of_sweep(const paper_t *paper, figure_t figure, int b, const char *load,
                                      bool real, bool *stopped)
{
    const result_t *worst = NULL;
    *stopped = false;
    for (int c = 1; c < 4; c++) {
        char name[40];
        snprintf(name, sizeof name, "%s_%s", sweep_14[b][c], load);
        const result_t *result = paper_find(paper, figure, name, real);
        *stopped = *stopped || result->lost;
        if (worst == NULL || fabs(result->numbers[UP].plateau) > fabs(worst->numbers[UP].plateau)) {
            worst = result;
        }
    }
    return worst;
}

static void judge_sweep(paper_t *paper, figure_t figure, const char *load, bool real)
{
    for (int b = 0; b < 2; b++) {
        char name[40];
        char condition[80];
        bool stopped = false;
        snprintf(name, sizeof name, "%s_%s", sweep_14[b][0], load);
        const result_t *conventional = paper_find(paper, figure, name, real);
        const result_t *worst = worst_of_sweep(paper, figure, b, load, real, &stopped);
        double kp = 0.0;
        double ki = 0.0;
        (void)paper_loop(conventional->run.bandwidth, 0.0, &kp, &ki);
        const claim_t none =
            paper_claim(figure, b == 0 ? "b100_feedforward" : "b200_feedforward",
                        b == 0 ? "100 rad/s: largest error while accelerating over omega_c"
                               : "200 rad/s: largest error while accelerating over omega_c",
                        "mrad", 0.0, real ? 6.0 : 3.0,
                        "a slow pole (small omega_c or k_i) has not settled in the time of the acceleration");
        const claim_t late = paper_claim_of_theory(
            figure, b == 0 ? "b100_conventional" : "b200_conventional",
            b == 0 ? "100 rad/s: the conventional PLL's error" : "200 rad/s: the conventional PLL's error",
            "mrad", paper_tracking_error(ki, conventional->numbers[UP].acceleration) / MRAD,
            0.03 * 355.0 / (b == 0 ? 1.0 : 4.0), "the print has no number here; this is a/k_i");
        snprintf(condition, sizeof condition, "worst of omega_c %s rad/s",
                 b == 0 ? "12, 25, 40" : "25, 50, 81");
        const double error = worst->numbers[UP].plateau;
        paper_row_of_several(paper, &none, worst, stopped, error,
                             fabs(error) < 0.1 * fabs(conventional->numbers[UP].plateau), condition);
        paper_row_of(paper, &late, conventional, conventional->numbers[UP].plateau, false);
    }
}

/* How many of the dead times, from the least, the loop holds with every seed. */
static int held_dead_times(const paper_t *paper, int loop)
{
    for (int n = 0; n < DEAD_TIMES_15; n++) {
        for (int seed = 0; seed < SEEDS_15; seed++) {
            if (paper_dead_time_run(paper, loop, n, seed)->lost) {
                return n;
            }
        }
    }
    return DEAD_TIMES_15;
}

static void judge_losses(paper_t *paper)
{
    static const struct {
        const char *id, *name, *claim, *because;
        double paper;
    } at_once[] = {
        {"conventional", "b200_wc0_uncompensated",
         "200 rad/s, conventional, not compensated: loses the rotor (1)", "it holds", 1.0},
        {"feedforward", "b200_wc25_uncompensated",
         "200 rad/s, omega_c 25, not compensated: loses the rotor (1)", "it is lost too", 0.0},
        {"moderate", "b100_wc0_uncompensated",
         "100 rad/s, conventional, not compensated: loses the rotor (1)",
         "it is lost too: not the k_i is the cause", 0.0},
    };
    for (size_t n = 0; n < sizeof at_once / sizeof at_once[0]; n++) {
        const claim_t claim = paper_claim(FIG15, at_once[n].id, at_once[n].claim, "-", at_once[n].paper, 0.0,
                                          at_once[n].because);
        paper_row_of_loss(paper, &claim, paper_find(paper, FIG15, at_once[n].name, true));
    }

    int held[LOOPS_15];
    for (int n = 0; n < LOOPS_15; n++) {
        held[n] = held_dead_times(paper, n);
    }
    const char *none = "the print does not say how long the dead time was";
    const char *condition = "eight dead times from 2.5 to 4.75 us, each with three seeds";
    /* docs/theory.md, 21: held at 3.0 us, lost at 3.25 (see dead_times_15). */
    const claim_t lost =
        paper_claim_of_theory(FIG15, "b200_wc0_dead_time",
                              "200 rad/s, conventional: lost from this dead time on", "us", 3.25, 0.25, none);
    paper_row_of_several(paper, &lost, paper_dead_time_run(paper, 0, 0, 0), false,
                         held[0] < DEAD_TIMES_15 ? dead_times_15[held[0]] : (double)NAN, false, condition);
    static const char *const ids[LOOPS_15] = {NULL, "b200_wc25_dead_time", "b100_wc0_dead_time"};
    static const char *const texts[LOOPS_15] = {
        NULL, "200 rad/s, omega_c 25: holds where the conventional loop is lost, up to",
        "100 rad/s, conventional: holds where that of 200 rad/s is lost, up to"};
    for (int n = 1; n < LOOPS_15; n++) {
        const claim_t longer = paper_claim_of_theory(FIG15, ids[n], texts[n], "us", INFINITY, 0.0, none);
        paper_row_of_several(paper, &longer, paper_dead_time_run(paper, n, 0, 0), false,
                             held[n] > 0 ? dead_times_15[held[n] - 1] : (double)NAN, held[n] > held[0],
                             condition);
    }
}

static void judge_fig15(paper_t *paper, bool real)
{
    judge_sweep(paper, FIG15, "rated", real);
    const claim_t compensated = paper_claim(
        FIG15, "compensated", "200 rad/s, conventional, inverter compensated: loses the rotor (1)", "-", 1.0,
        0.0, "it holds: no k_i of this size loses the rotor if the dead time is compensated");
    paper_row_of_loss(paper, &compensated, paper_find(paper, FIG15, "b200_wc0_rated", real));
    if (real) { /* the ideal drive has no dead time */
        judge_losses(paper);
    }
}

static const result_t *of_16(const paper_t *paper, int b, int c, int load, bool real)
{
    char name[40];
    snprintf(name, sizeof name, "%s_%s", sweep_16[b][c], load_names[load]);
    return paper_find(paper, FIG16, name, real);
}

static double position_sd(const result_t *result, int window)
{
    return result->numbers[window].sd;
}

static double speed_sd(const result_t *result, int window)
{
    return result->numbers[window].speed_sd;
}

/* Pairs of which the claim does not hold, and where they are. */
typedef struct {
    int slow, fast; /* at 100 and 1500 r/min */
    int least;      /* of their places in the order of omega_c */
} exceptions_t;

static void except(exceptions_t *exceptions, int window, int c)
{
    exceptions->slow += window == SLOW;
    exceptions->fast += window == FAST;
    exceptions->least = c < exceptions->least ? c : exceptions->least;
}

/* Does the deviation fall as omega_c rises? */
static exceptions_t over_cutoff(const paper_t *paper, double (*sd)(const result_t *, int), bool real)
{
    exceptions_t exceptions = {.least = SWEEP_16 - 1};
    for (int n = 0; n < 2 * 2 * (SWEEP_16 - 1); n++) {
        const int c = 1 + n / 4;
        const result_t *before = of_16(paper, n % 2, c - 1, n / 2 % 2, real);
        const result_t *after = of_16(paper, n % 2, c, n / 2 % 2, real);
        for (int window = SLOW; window <= FAST; window += FAST - SLOW) {
            if (sd(after, window) >= sd(before, window)) {
                except(&exceptions, window, c);
            }
        }
    }
    return exceptions;
}

/* Does it grow with the bandwidth? */
static exceptions_t over_bandwidth(const paper_t *paper, double (*sd)(const result_t *, int), bool real)
{
    exceptions_t exceptions = {.least = SWEEP_16 - 1};
    for (int n = 0; n < 2 * SWEEP_16; n++) {
        const int c = n / 2;
        const result_t *narrow = of_16(paper, 0, c, n % 2, real);
        const result_t *wide = of_16(paper, 1, c, n % 2, real);
        for (int window = SLOW; window <= FAST; window += FAST - SLOW) {
            if (sd(wide, window) <= sd(narrow, window)) {
                except(&exceptions, window, c);
            }
        }
    }
    return exceptions;
}

static bool any_lost_16(const paper_t *paper, bool real)
{
    bool lost = false;
    for (int n = 0; n < 4 * SWEEP_16; n++) {
        lost = lost || of_16(paper, n % 2, n / 4, n / 2 % 2, real)->lost;
    }
    return lost;
}

/* In kind if the claim holds at 100 r/min, where the deviations are large. */
static void judge_deviations(paper_t *paper, bool stopped)
{
    const struct {
        const char *id, *claim;
        exceptions_t exceptions;
    } claims[] = {
        {"speed_sd", "neighbours of 40 whose speed SD does not fall as omega_c rises",
         over_cutoff(paper, speed_sd, true)},
        {"position_sd", "neighbours of 40 whose position SD does not fall as omega_c rises",
         over_cutoff(paper, position_sd, true)},
        {"speed_sd_bandwidth", "pairs of 24 whose speed SD does not grow with bandwidth",
         over_bandwidth(paper, speed_sd, true)},
        {"position_sd_bandwidth", "pairs of 24 whose position SD does not grow with bandwidth",
         over_bandwidth(paper, position_sd, true)},
    };
    for (size_t n = 0; n < sizeof claims / sizeof claims[0]; n++) {
        const exceptions_t *e = &claims[n].exceptions;
        char because[180];
        snprintf(because, sizeof because,
                 "%d at 100 and %d at 1500 r/min are not so, from omega_c %g or %g rad/s up: there the slow "
                 "settling of a small k_i adds to it",
                 e->slow, e->fast, of_16(paper, 0, e->least, 0, true)->run.omega_c,
                 of_16(paper, 1, e->least, 0, true)->run.omega_c);
        const claim_t claim = paper_claim(FIG16, claims[n].id, claims[n].claim, "-", 0.0, 0.0, because);
        paper_row_of_several(paper, &claim, of_16(paper, 0, 0, 0, true), stopped, e->slow + e->fast,
                             e->slow == 0, "bandwidths 100 and 200 rad/s x six omega_c x no load and 5 N m");
    }
}

/* omega_c of the least overshoot, between the grid's points by a parabola through the three about the
 * lowest; NAN: it is at the grid's end. */
static double best_cutoff(const paper_t *paper, int b, int load, int window, bool speed, bool real)
{
    double x[SWEEP_16];
    double y[SWEEP_16];
    int low = 0;
    for (int c = 0; c < SWEEP_16; c++) {
        const result_t *result = of_16(paper, b, c, load, real);
        x[c] = result->run.omega_c;
        y[c] = speed ? result->numbers[window].speed_peak : result->numbers[window].peak;
        low = y[c] < y[low] ? c : low;
    }
    if (low == 0 || low == SWEEP_16 - 1) {
        return (double)NAN;
    }
    const double slope_left = (y[low] - y[low - 1]) / (x[low] - x[low - 1]);
    const double slope_right = (y[low + 1] - y[low]) / (x[low + 1] - x[low]);
    const double curvature = (slope_right - slope_left) / (x[low + 1] - x[low - 1]);
    return 0.5 * (x[low - 1] + x[low]) - 0.5 * slope_left / curvature;
}

static void judge_fig16(paper_t *paper, bool real)
{
    const bool stopped = any_lost_16(paper, real);
    if (real) { /* an ideal drive has no deviation to speak of */
        judge_deviations(paper, stopped);
    }
    static const struct {
        int window;
        const char *word;
    } changes[2] = {{UP, "accelerating"}, {DOWN, "decelerating"}};
    for (int b = 0; b < 2; b++) {
        for (int load = 0; load < 2; load++) {
            for (int n = 0; n < 2; n++) {
                char id[40];
                char text[120];
                char where[80];
                snprintf(id, sizeof id, "b%d_%s_%s", b == 0 ? 100 : 200, load_names[load], changes[n].word);
                snprintf(text, sizeof text, "%d rad/s, %s: omega_c of the least position overshoot, %s",
                         b == 0 ? 100 : 200, load == 0 ? "no load" : "5 N m", changes[n].word);
                snprintf(where, sizeof where, "six omega_c from 0 to %d rad/s", b == 0 ? 60 : 121);
                /* Noise adds some two SD to a peak, which fall as omega_c rises: by as much as a flat
                 * overshoot grows from the least to the next omega_c of the grid, 1.62 times it. */
                const double centre = b == 0 ? 25.0 : 50.0;
                const claim_t minimum = paper_claim_of_theory(
                    FIG16, id, text, "rad/s", centre, (real ? 0.62 : 0.32) * centre,
                    "the print names an inflection and no number; damping 1 gives 0.62 of the "
                    "conventional loop's natural frequency");
                const double best = best_cutoff(paper, b, load, changes[n].window, false, real);
                paper_row_of_several(paper, &minimum, of_16(paper, b, 3, load, real), stopped, best, false,
                                     where);
            }
        }
    }
}

/* ---- all of them ---- */

void paper_judge_measured(paper_t *paper, figure_t figure)
{
    for (int real = 1; real >= 0; real--) {
        if (figure == FIG15) {
            judge_fig15(paper, real != 0);
        } else {
            judge_fig16(paper, real != 0);
        }
    }
}
