/* clang-format off */
/* An experiment described in a TOML file: a scenario, run at every point of a grid, what is measured of each
 * run, and what somebody claims of that. A user judges his own paper or data sheet with it.
 *
 *   all of a scenario (host_sim/lab/scenario.h): schema, title, text, [run], [start], [params], [requests],
 *   [plant], [rig], [[at]], [[expect]]. A run whose drive latches a fault, or that does not meet an
 *   expectation, is lost: claims that need it are not met.
 *
 *   [experiment]
 *   id = "my_motor"                        # of its rows; default: the name of the file
 *   claim = "..."                          # one line: what all of it shows
 *   source = "Fig. 13"                     # in print; without: a claim holds or does not, instead of being reproduced
 *   use = ["paper"]                        # named sets of rows (experiment_functions.c); what the file sets stays
 *   each = ["real", "ideal"]               # points of one sweep: each claim is judged of each
 *   curve = "loop_filters"                 # a curve of theory is the CSV (experiment_curves.c)
 *   condition = "{load}, J {plant.inertia} kg m^2"  # of a row; {SWEEP}: the point's text, {ROW}: its value at t = 0,
 *                                          # {EXPRESSION}: its number; also in where, why_not and the text of a point
 *   whole_turns = true                     # durations are rounded up to whole electrical turns at the first speed_request
 *
 *   [begin]                                # what comes before t = 0; without: power-on
 *   by = "dynamometer"                     # turned until the drive holds speed_request and plant.load_torque of t = 0,
 *                                          # by the source that position_source asks for; then the shaft is free
 *   settle = "0.5 s"                       # then; default 0
 *   plant.current_offset_a = "30 mA"       # rows that change when the drive is ready, after its calibration
 *
 *   [[sweep]]                              # a dimension of the grid; the first one varies fastest
 *   name = "load"
 *   row = "plant.load_torque"              # one row over values ...
 *   values = ["0 N m", "5 N m"]            # or from, to, steps: so many even steps, both ends included
 *   names = ["none", "rated"]              # of the points; default: the values as they are written
 *                                          # row = "run.seed": seeds of the noise
 *   [[sweep]]
 *   name = "flavour"
 *   [[sweep.point]]                        # ... or points of any rows
 *   name = "ideal"
 *   text = "ideal inverter"                # for the condition; default: the name
 *   number = 3.25                          # that it stands for in expressions
 *   only = {load = ["rated"]}              # points of other sweeps that it goes with; nothing runs at others
 *   use = ["ideal"]
 *   plant.current_noise = 0                # rows of params, requests, plant, rig
 *   begin.settle = "3 s"                   # and of [begin]
 *   at = [{time = "1 s", params.lag_compensation = "exact"}]  # and events
 *
 *   [[measure]]                            # numbers of a window of each run
 *   name = "up"
 *   signal = "theta_hat_err"               # a row of any table
 *   minus = "..."                          # optional: the difference counts
 *   through = "sigmoid_gain"               # optional: a function of it (experiment_functions.c), sample by sample
 *   unit = "mrad"                          # optional: the number's; default: SI
 *   from = "2 s"                           # from <= t_k < to; default: the whole run
 *   to = "6 s"
 *   between = {signal = "true_omega_m", begin = "1150 r/min", end = "1290 r/min"}  # optional: only once it is past
 *                                          # `begin`, until it first comes to `end`
 *
 *   [let]                                  # expressions with a name
 *   ratio = "up.peak / down.peak"
 *
 *   [table]                                # the CSV in the place of a [trace]
 *   lines = ["load"]                       # sweeps whose points make the lines; default: all
 *   column = [{name = "load", sweep = "load"}, {name = "peak", unit = "mrad", value = "up.peak"}]
 *
 *   [[claim]]                              # in the order of the file
 *   id = "up"
 *   text = "error while accelerating"
 *   unit = "mrad"
 *   each = ["real"]                        # optional: of which of the experiment's `each`
 *   measure = "up"                         # `of` which statistic of it: mean, min, max, peak, sd, rms, last; or
 *   of = "mean"                            # value = "abs(up.mean)": an expression (below)
 *   at = {load = "none"}                   # the point of each sweep that `each` is not of, that has more than one and
 *                                          # that no `for` goes over; a list: the one at which the number is largest
 *   printed = 355                          # what the source says; if it has no number:
 *   theory = 350                           # number or expression; without both, holds_if alone judges
 *   tolerance = 10                         # or one a flavour: {real = 4, ideal = 1}
 *   holds_if = "up.mean < down.mean"       # optional: then it is reproduced in kind, or holds
 *   why_not = "..."                        # told where the number is not the printed one
 *   where = "worst of six"                 # optional: before the condition
 *
 * Expressions: + - * /, < > <= >=, `and`, parentheses, numbers, pi, rpm (2 pi/60), mrad; MEASURE.STATISTIC of the
 * claim's point; params.ROW and so on: its value at t = 0 in SI; SWEEP: the number of its point; `lost`: 1 or 0; names
 * of [let]; behind each of them @POINT: at the one that differs by this name (quoted '5 N m' if it is no plain word),
 * @before(SWEEP): at the one before in it; `value`: the claim's own number; and the functions of
 * experiment_functions.c, theory's among them. sum, mean, max, min, worst, lowest_at go over points:
 * sum(lost for load, seed if load > 2). Of no points: 0, none, -inf, inf, none, none.
 *
 * A file without [run] runs nothing: claims of theory alone.
 *
 * Same file, same seed: same bits in any number of threads. */
/* clang-format on */
#ifndef HOST_SIM_LAB_EXPERIMENT_H
#define HOST_SIM_LAB_EXPERIMENT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include "host_sim/lab/pool.h"
#include "host_sim/lab/scenario.h"

#define EXPERIMENT_RUNS_MAX 2000u
#define EXPERIMENT_ROWS_MAX 1000u

typedef struct experiment experiment_t;

/* Reads a file and judges all that can be judged without running, every point's scenario and every
 * expression. NULL: `error`. */
experiment_t *experiment_read(const char *path, scenario_error_t *error);
void experiment_free(experiment_t *experiment);

const char *experiment_id(const experiment_t *experiment);
const char *experiment_title(const experiment_t *experiment);
const char *experiment_claim(const experiment_t *experiment);  /* "" */
const char *experiment_source(const experiment_t *experiment); /* NULL: none */
uint64_t experiment_seed(const experiment_t *experiment);

size_t experiment_run_count(const experiment_t *experiment);

/* Runs point n with this seed on a rig of its own; the traces are kept if `traced`. false: why not, one line.
 */
bool experiment_measure(experiment_t *experiment, size_t n, uint64_t seed, bool traced, char why[POOL_WHY]);

/* A claim of one flavour, measured. What is pointed at belongs to the experiment. */
typedef struct {
    const char *id, *text, *unit;
    const char *flavour;
    uint32_t each;   /* which of `each` */
    double printed;  /* [unit]; NAN: the source has no number */
    double expected; /* [unit] the printed number, else theory's; INFINITY: neither */
    double tolerance, ours;
    bool kind;    /* holds_if is given and holds */
    bool stopped; /* a run that it needs is lost */
    char condition[640], why_not[200];
} experiment_row_t;

uint32_t experiment_each_count(const experiment_t *experiment); /* >= 1 */

/* Rows: each flavour's claims in the order of the file. All runs must have been measured. */
size_t experiment_row_count(const experiment_t *experiment);
void experiment_row(const experiment_t *experiment, size_t n, experiment_row_t *row);

/* The traces of all runs as CSV, or a table of what is measured, a line a run, if the file has no [trace]. */
void experiment_write_csv(const experiment_t *experiment, FILE *file);

/* For the report: the events of the first run, and what was run, as JSON lists. */
void experiment_write_events(const experiment_t *experiment, FILE *file);
void experiment_write_runs(const experiment_t *experiment, FILE *file);

#endif
