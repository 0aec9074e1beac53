/* The paper's figures, each measured again and judged, and three experiments beyond it: fig04 and fig08 from
 * the formulas (experiment_curves.c), in double and independent of the firmware; the others on the real
 * interrupt code in the rig, one run per curve.
 *
 * All but beyond_map (map.h) are files of host_sim/experiments, their language: experiment.h. What is not in
 * the print (inertia, friction, bandwidth's meaning, k_s, omega_c) is inferred from the paper's numbers
 * (docs/theory.md, 19; errata 5, 11, 13). Two flavours of each, where both mean something:
 *
 *     ideal  inverter and sensors without error, as the theory assumes
 *     real   inverter of the plant's defaults (2.5 us dead time, delays, drops), compensated, 12-bit ADC,
 *            noise 10 mA, and an offset of 30 mA and a gain error of 0.2 % on sensor a after calibration
 *
 * In fig16 the real machine's EMF has 1 % of 5th and 0.5 % of 7th harmonic besides, and in fig15 some loops
 * run with a dead time that nothing compensates. Mean voltages over a period in all but beyond_map (see map.h
 * for what that leaves out). The estimate closes the loop but in fig05 and fig10, which run beside the
 * encoder: the sign SMO loses 100 r/min without load (docs/theory.md, 21). Errors are theta_hat - theta,
 * electrical.
 *
 * Verdicts are computed. Of the paper's figures: reproduced, if our number is within the row's tolerance of
 * the paper's; reproduced in kind, if it is not, or the print has no number, but what the claim says of it
 * holds; else not reproduced. Beyond the paper: the claim holds, or does not. A row whose drive stopped is
 * not reproduced and does not hold, whatever its number.
 *
 * Same bits in any number of threads. */
#ifndef HOST_SIM_LAB_PAPER_H
#define HOST_SIM_LAB_PAPER_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include "host_sim/lab/pool.h"

#define PAPER_FIGURES  14u
#define PAPER_ROWS_MAX 1000u         /* what an experiment of a file may have */
#define PAPER_OWN      PAPER_FIGURES /* in the place of a figure: an experiment that is not the paper's */

typedef struct {
    const char *id;    /* "fig04" */
    const char *title; /* one line; NULL in paper_figures: its file says (paper_about) */
    const char *claim; /* what the paper's figure says; beyond the paper, what ours does; one line */
    const char *paper; /* "Fig. 4"; NULL: beyond the paper */
    const char *more; /* "dead_time": the figure has a second file, ID_dead_time.toml, with data of its own */
} paper_figure_t;

extern const paper_figure_t paper_figures[PAPER_FIGURES];

/* Index in paper_figures; PAPER_FIGURES: no such figure. */
size_t paper_figure(const char *id);

typedef enum {
    PAPER_REPRODUCED,
    PAPER_IN_KIND,
    PAPER_NOT_REPRODUCED,
    PAPER_HOLDS,
    PAPER_DOES_NOT_HOLD,
    PAPER_VERDICTS
} paper_verdict_t;

/* One claim, judged. */
typedef struct {
    size_t figure;           /* index in paper_figures, or PAPER_OWN */
    bool beyond;             /* [-] nobody has printed it: the claim holds or does not */
    char id[96];             /* "fig13.accelerating.real" */
    const char *flavour;     /* "ideal", "real", "formula" */
    char claim[200];         /* one line */
    double paper;            /* [unit] the paper's number; NAN: it has none */
    double expected;         /* [unit] what ours is judged against: the paper's, else what theory says */
    double ours;             /* [unit]; NAN: nothing could be measured */
    const char *unit;        /* "mrad" */
    double tolerance;        /* [unit] that ours may be from `expected` */
    bool kind;               /* [-] what the claim says holds of our number */
    bool stopped;            /* [-] a drive that it was measured on stopped with a fault */
    paper_verdict_t verdict; /* [-] paper_judge of the above */
    char because[200];       /* why it is not simply reproduced; "" if it is, or holds */
    char condition[640];     /* one line */
} paper_row_t;

/* From beyond, paper, expected, ours, tolerance, kind and stopped alone. */
paper_verdict_t paper_judge(const paper_row_t *row);

/* "reproduced", "reproduced in kind", "not reproduced", "holds", "does not hold". */
const char *paper_verdict_name(paper_verdict_t verdict);

typedef struct paper paper_t;

typedef struct {
    char text[POOL_WHY]; /* one line */
} paper_error_t;

/* Called after each of `total` runs, by one thread at a time. */
typedef void (*paper_progress_t)(void *context, size_t done, size_t total);

/* The paper's numbers, and so the tolerances, are those of a PWM of 10 kHz. false: a rig with such a period
 * [1/150 MHz] can not be judged by them, as `why` says. */
bool paper_is_for(uint64_t period_ticks, paper_error_t *why);

/* Runs the experiments of these figures in this many threads (at least 1) and judges them; seed: of all
 * noise. progress may be NULL. NULL: `why` says what was refused, a rig with another PWM too. Some 50 MB. */
paper_t *paper_run(const bool wanted[PAPER_FIGURES], uint64_t seed, unsigned threads,
                   paper_progress_t progress, void *context, paper_error_t *why);

/* The same of an experiment's file (host_sim/lab/experiment.h), with the seed that it names; its traces are
 * kept only if they are to be written. NULL: `why` says what the rig refused. */
struct experiment;
paper_t *paper_run_file(struct experiment *own, bool traced, unsigned threads, paper_progress_t progress,
                        void *context, paper_error_t *why);

/* Frees the experiment, too. */
void paper_free(paper_t *paper);

/* What the figure is about, or PAPER_OWN. It was wanted. */
const paper_figure_t *paper_about(const paper_t *paper, size_t figure);

/* The rows, figure by figure. */
size_t paper_row_count(const paper_t *paper);
const paper_row_t *paper_row(const paper_t *paper, size_t n);
const paper_row_t *paper_row_by_id(const paper_t *paper, const char *id); /* NULL: none */

/* The figure's data as CSV: a line of names with units (`text` for words), then values; empty where a run is
 * shorter than another. Nothing for a figure that was not wanted. */
void paper_write_csv(const paper_t *paper, size_t figure, FILE *file);

/* The same for the figure's second file, if it has one. */
void paper_write_more(const paper_t *paper, size_t figure, FILE *file);

/* What was run and what came of it, as one JSON object: conditions, figures with their runs, rows. The CSV of
 * a figure is named data/ID.csv. seconds: that the run took. */
void paper_write_manifest(const paper_t *paper, const char *commit, double seconds, FILE *file);

#endif
