/* Measures the paper's figures again and judges them, together with three experiments beyond the paper. fig04
 * and fig08 follow from formulas in double precision, independent of the firmware (experiment_curves.c). The
 * others run the real interrupt code in the rig, one run per curve.
 *
 * All but beyond_map (map.h) are files of host_sim/experiments; experiment.h describes their language. Values
 * that the paper does not print (inertia, friction, the definition of the bandwidth, k_s, omega_c) are
 * derived from its numbers (docs/theory.md, 19; errata 5, 11, 13). Each experiment has one or two flavours:
 *
 *     ideal  inverter and sensors without error, as the theory assumes
 *     real   inverter of the plant's defaults (2.5 us dead time, delays, drops), compensated, 12-bit ADC,
 *            noise 10 mA, and an offset of 30 mA and a gain error of 0.2 % on sensor a after calibration
 *
 * In the real flavour of fig16 the EMF also has 1 % of 5th and 0.5 % of 7th harmonic. In fig15 some loops run
 * with an uncompensated dead time. All but beyond_map use mean voltages over a period (map.h describes the
 * effect). The control uses the estimate, except in fig05 and fig10, where it uses the encoder, because the
 * observer with the sign function is lost at 100 r/min without load (docs/theory.md, 21). Errors are
 * theta_hat - theta, electrical.
 *
 * Verdicts are computed. A row of the paper's figures is "reproduced" if our number is within the tolerance
 * of the paper's number. It is "reproduced in kind" if the number differs or the paper has none, but the
 * statement of the claim holds. Otherwise it is "not reproduced". A claim beyond the paper holds or does not
 * hold. A row whose drive stopped is not reproduced and does not hold, independent of its number.
 *
 * The bits are the same with any number of threads. */
#ifndef HOST_SIM_LAB_PAPER_H
#define HOST_SIM_LAB_PAPER_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include "host_sim/lab/pool.h"

#define PAPER_FIGURES  14u
#define PAPER_ROWS_MAX 1000u         /* largest number of rows of an experiment from a file */
#define PAPER_OWN      PAPER_FIGURES /* index of an experiment from a file, instead of a figure */

typedef struct {
    const char *id;    /* "fig04" */
    const char *title; /* one line; NULL in paper_figures: the title is in the file (paper_about) */
    const char *claim; /* claim of the paper's figure, or of our experiment; one line */
    const char *paper; /* "Fig. 4"; NULL: beyond the paper */
    const char *more;  /* "dead_time": the figure has a second file with further data, ID_dead_time.toml */
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
    size_t figure;       /* index in paper_figures, or PAPER_OWN */
    bool beyond;         /* [-] not in the paper: the claim holds or does not hold */
    char id[96];         /* "fig13.accelerating.real" */
    const char *flavour; /* "ideal", "real", "formula" */
    char claim[200];     /* one line */
    double paper;        /* [unit] number of the paper; NAN: none */
    double expected; /* [unit] number with which the measured one is compared: that of the paper, or else that
                        of theory */
    double ours;     /* [unit] measured number; NAN: nothing could be measured */
    const char *unit;        /* "mrad" */
    double tolerance;        /* [unit] accepted difference from `expected` */
    bool kind;               /* [-] the statement of the claim holds for our number */
    bool stopped;            /* [-] the drive stopped with a fault in a run of this row */
    paper_verdict_t verdict; /* [-] result of paper_judge */
    char because[200];       /* reason if the verdict is not "reproduced" or "holds"; else "" */
    char condition[640];     /* one line */
} paper_row_t;

/* Judges the row by its fields beyond, paper, expected, ours, tolerance, kind and stopped. */
paper_verdict_t paper_judge(const paper_row_t *row);

/* "reproduced", "reproduced in kind", "not reproduced", "holds", "does not hold". */
const char *paper_verdict_name(paper_verdict_t verdict);

typedef struct paper paper_t;

typedef struct {
    char text[POOL_WHY]; /* one line */
} paper_error_t;

/* Called after each of `total` runs, by one thread at a time. */
typedef void (*paper_progress_t)(void *context, size_t done, size_t total);

/* The paper's numbers and the tolerances are for a PWM of 10 kHz. false: they are not valid for a rig with
 * this period [1/150 MHz]; `why` has the message. */
bool paper_is_for(uint64_t period_ticks, paper_error_t *why);

/* Runs the experiments of these figures with this number of threads (at least 1) and judges them. `seed` is
 * that of all noise; progress may be NULL. It needs about 50 MB. Returns NULL if something was refused, also
 * a rig with another PWM; `why` has the message. */
paper_t *paper_run(const bool wanted[PAPER_FIGURES], uint64_t seed, unsigned threads,
                   paper_progress_t progress, void *context, paper_error_t *why);

/* The same for the file of an experiment (host_sim/lab/experiment.h), with the seed of the file. Traces are
 * stored if `traced`. NULL: the rig refused something; `why` has the message. */
struct experiment;
paper_t *paper_run_file(struct experiment *own, bool traced, unsigned threads, paper_progress_t progress,
                        void *context, paper_error_t *why);

/* Frees the results, and the experiment of paper_run_file. */
void paper_free(paper_t *paper);

/* Title and claim of a figure that was run, or of PAPER_OWN. */
const paper_figure_t *paper_about(const paper_t *paper, size_t figure);

/* The rows, figure by figure. */
size_t paper_row_count(const paper_t *paper);
const paper_row_t *paper_row(const paper_t *paper, size_t n);
const paper_row_t *paper_row_by_id(const paper_t *paper, const char *id); /* NULL: none */

/* Writes the figure's data as CSV: a line of names with units (`text` for words), then values; cells are
 * empty if a run is shorter than another. Writes nothing for a figure that was not selected. */
void paper_write_csv(const paper_t *paper, size_t figure, FILE *file);

/* The same for the figure's second file, if it has one. */
void paper_write_more(const paper_t *paper, size_t figure, FILE *file);

/* Writes conditions, figures with their runs, and rows as one JSON object. The CSV file of a figure is
 * data/ID.csv. `seconds` is the duration of the run. */
void paper_write_manifest(const paper_t *paper, const char *commit, double seconds, FILE *file);

#endif
