/* The rows of the paper's figures. */
#include <math.h>
#include <stdio.h>

#include "host_sim/lab/paper_parts.h"

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
        if (figure == FIG16) {
            judge_fig16(paper, real != 0);
        }
    }
}
