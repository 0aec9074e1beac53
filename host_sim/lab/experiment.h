/* clang-format off */
/* An experiment described in a TOML file: a scenario that is run at every point of a grid, numbers that are measured
 * in each run, and claims about these numbers. With it a user checks a paper or a data sheet.
 *
 *   all of a scenario (host_sim/lab/scenario.h): schema, title, text, [run], [start], [params], [requests],
 *   [plant], [rig], [[at]], [[expect]]. A run is lost if the drive latches a fault or an
 *   expectation is not met. Claims that need a lost run are not met.
 *
 *   [experiment]
 *   id = "my_motor"                        # prefix of its rows; default: the name of the file
 *   claim = "..."                          # one line: what the experiment shows
 *   source = "Fig. 13"                     # printed source; without it a claim holds or does not hold, instead of being reproduced
 *   use = ["paper"]                        # named sets of rows (experiment_functions.c); rows of the file have priority
 *   each = ["real", "ideal"]               # points of one sweep: each claim is judged for each of them
 *   curve = "loop_filters"                 # the CSV contains a theoretical curve (experiment_curves.c)
 *   condition = "{load}, J {plant.inertia} kg m^2"  # condition of a row; {SWEEP}: text of the point, {ROW}: value at t = 0,
 *                                          # {EXPRESSION}: its number; also in where, why_not and the text of a point
 *   whole_turns = true                     # durations are rounded up to whole electrical turns at the first speed_request
 *
 *   [begin]                                # the time before t = 0; without it: power-on
 *   by = "dynamometer"                     # a dynamometer turns the shaft until the drive, with its position_source, keeps
 *                                          # speed_request and plant.load_torque of t = 0; then it releases the shaft
 *   settle = "0.5 s"                       # waiting time afterwards; default 0
 *   plant.current_offset_a = "30 mA"       # rows that change after the calibration of the drive
 *
 *   [[sweep]]                              # a dimension of the grid; the first sweep varies fastest
 *   name = "load"
 *   row = "plant.load_torque"              # one row over values ...
 *   values = ["0 N m", "5 N m"]            # or from, to and steps: this number of equal steps, with both ends
 *   names = ["none", "rated"]              # of the points; default: the values as they are written
 *                                          # row = "run.seed": seeds of the noise
 *   [[sweep]]
 *   name = "flavour"
 *   [[sweep.point]]                        # ... or points of any rows
 *   name = "ideal"
 *   text = "ideal inverter"                # used in the condition; default: the name
 *   number = 3.25                          # value of the point in expressions
 *   only = {load = ["rated"]}              # points of other sweeps with which this point is combined; others are omitted
 *   use = ["ideal"]
 *   plant.current_noise = 0                # rows of params, requests, plant, rig
 *   begin.settle = "3 s"                   # rows of [begin]
 *   at = [{time = "1 s", params.lag_compensation = "exact"}]  # additional events
 *
 *   [[measure]]                            # numbers from a window of each run
 *   name = "up"
 *   signal = "theta_hat_err"               # a row of any table
 *   minus = "..."                          # optional: the difference of the two is measured
 *   through = "sigmoid_gain"               # optional: a function of each sample (experiment_functions.c)
 *   unit = "mrad"                          # optional: unit of the number; default: SI
 *   from = "2 s"                           # from <= t_k < to; default: the whole run
 *   to = "6 s"
 *   between = {signal = "true_omega_m", begin = "1150 r/min", end = "1290 r/min"}  # optional: only from the time at which the
 *                                          # signal passes `begin` to the time at which it first reaches `end`
 *
 *   [let]                                  # expressions with a name
 *   ratio = "up.peak / down.peak"
 *
 *   [table]                                # the CSV, instead of a [trace]
 *   lines = ["load"]                       # sweeps whose points are the lines; default: all
 *   column = [{name = "load", sweep = "load"}, {name = "peak", unit = "mrad", value = "up.peak"}]
 *
 *   [[claim]]                              # in the order of the file
 *   id = "up"
 *   text = "error while accelerating"
 *   unit = "mrad"
 *   each = ["real"]                        # optional: subset of the experiment's `each`
 *   measure = "up"                         # and `of` its statistic: mean, min, max, peak, sd, rms, last; or
 *   of = "mean"                            # value = "abs(up.mean)": an expression (below)
 *   at = {load = "none"}                   # the point of each other sweep that has several points, unless `each` or a `for`
 *                                          # uses this sweep; a list: the point with the largest number
 *   printed = 355                          # number of the source; if there is none:
 *   theory = 350                           # number or expression; without printed and theory only holds_if is judged
 *   tolerance = 10                         # or one for each flavour: {real = 4, ideal = 1}
 *   holds_if = "up.mean < down.mean"       # optional: condition for "reproduced in kind" or "holds"
 *   why_not = "..."                        # text that is printed if the number differs from the printed one
 *   where = "worst of six"                 # optional: text before the condition
 *
 * Expressions: + - * /, < > <= >=, `and`, parentheses, numbers, pi, rpm (2 pi/60), mrad; MEASURE.STATISTIC of the
 * claim's point; params.ROW, plant.ROW and so on: value at t = 0 in SI; SWEEP: number of the present point; `lost`: 1 or 0; names
 * of [let]; `value`: the number of the claim; and the functions of experiment_functions.c. @POINT after one of these gives
 * its value at the point with this name (quoted '5 N m' if it is not a plain word), and @before(SWEEP) its value at
 * the previous point of the sweep. sum, mean, max, min, worst and lowest_at combine points:
 * sum(lost for load, seed if load > 2). Without any point they are 0, none, -inf, inf, none, none.
 *
 * A file without [run] contains only claims of theory.
 *
 * The same file and seed give the same bits with any number of threads. */
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

/* Reads a file and judges everything that can be judged without running: the scenario of each point, and
 * every expression. NULL: the file is wrong; `error` has the message. */
experiment_t *experiment_read(const char *path, scenario_error_t *error);
void experiment_free(experiment_t *experiment);

const char *experiment_id(const experiment_t *experiment);
const char *experiment_title(const experiment_t *experiment);
const char *experiment_claim(const experiment_t *experiment);  /* "" */
const char *experiment_source(const experiment_t *experiment); /* NULL: none */
uint64_t experiment_seed(const experiment_t *experiment);

size_t experiment_run_count(const experiment_t *experiment);

/* Runs point n with this seed on its own rig, and stores the traces if `traced`. false: it could not run;
 * `why` has the message. */
bool experiment_measure(experiment_t *experiment, size_t n, uint64_t seed, bool traced, char why[POOL_WHY]);

/* A measured claim of one flavour. The texts belong to the experiment. */
typedef struct {
    const char *id, *text, *unit;
    const char *flavour;
    uint32_t each;   /* index in `each` */
    double printed;  /* [unit]; NAN: the source has no number */
    double expected; /* [unit] the printed number, else that of theory; INFINITY: neither */
    double tolerance, ours;
    bool kind;    /* holds_if is given and holds */
    bool stopped; /* a run that it needs is lost */
    char condition[640], why_not[200];
} experiment_row_t;

uint32_t experiment_each_count(const experiment_t *experiment); /* >= 1 */

/* The rows: claims of each flavour in the order of the file. All runs must have been measured before. */
size_t experiment_row_count(const experiment_t *experiment);
void experiment_row(const experiment_t *experiment, size_t n, experiment_row_t *row);

/* Writes the traces of all runs as CSV. If the file has no [trace], writes a table of the measured numbers,
 * one line per run. */
void experiment_write_csv(const experiment_t *experiment, FILE *file);

/* Writes the events of the first run, and the list of runs, as JSON for the report. */
void experiment_write_events(const experiment_t *experiment, FILE *file);
void experiment_write_runs(const experiment_t *experiment, FILE *file);

#endif
