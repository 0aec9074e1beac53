/* The paper's figures, each measured again and judged: fig04 and fig08 from the formulas, in double and
 * independent of the firmware; the others on the real interrupt code in the rig, one run per curve.
 *
 * The conditions of every run are the table `runs` of paper.c: what is not in the print (inertia, friction,
 * bandwidth's meaning, k_s, omega_c) is what physics.md infers from the paper's numbers (errata 5, 11, 13).
 * Two flavours of each, where both mean something:
 *
 *     ideal  inverter and sensors without error, as the theory assumes
 *     real   inverter of the plant's defaults (2.5 us dead time, delays, drops), compensated, 12-bit ADC,
 *            noise 10 mA, and an offset of 30 mA and a gain error of 0.2 % on sensor a after calibration
 *
 * In fig16 the real machine's EMF has 1 % of 5th and 0.5 % of 7th harmonic besides, and in fig15 three loops
 * run with a dead time that nothing compensates. Mean voltages over a period in all (see map.h for what that
 * leaves out). The estimate closes the loop but in fig05 and fig10, which run beside the encoder: the sign
 * SMO loses 100 r/min without load (physics.md, section 4). Errors are theta_hat - theta, electrical.
 *
 * Verdicts are computed: reproduced, if our number is within the row's tolerance of the paper's; reproduced
 * in kind, if it is not, or the print has no number, but what the claim says of it holds; else not
 * reproduced. A row whose drive stopped is not reproduced, whatever its number.
 *
 * Same bits in any number of threads. */
#ifndef HOST_SIM_LAB_PAPER_H
#define HOST_SIM_LAB_PAPER_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#define PAPER_FIGURES  11u
#define PAPER_ROWS_MAX 128u

typedef struct {
    const char *id;    /* "fig04" */
    const char *title; /* one line */
} paper_figure_t;

extern const paper_figure_t paper_figures[PAPER_FIGURES];

/* Index in paper_figures; PAPER_FIGURES: no such figure. */
size_t paper_figure(const char *id);

typedef enum { PAPER_REPRODUCED, PAPER_IN_KIND, PAPER_NOT_REPRODUCED } paper_verdict_t;

/* One claim, judged. */
typedef struct {
    size_t figure;           /* index in paper_figures */
    char id[40];             /* "fig13.accelerating.real" */
    const char *flavour;     /* "ideal", "real", "formula" */
    char claim[120];         /* one line */
    double paper;            /* [unit] the paper's number; NAN: it has none */
    double expected;         /* [unit] what ours is judged against: the paper's, else what theory says */
    double ours;             /* [unit]; NAN: nothing could be measured */
    const char *unit;        /* "mrad" */
    double tolerance;        /* [unit] that ours may be from `expected` */
    bool kind;               /* [-] what the claim says holds of our number */
    bool stopped;            /* [-] a drive that it was measured on stopped with a fault */
    paper_verdict_t verdict; /* [-] paper_judge of the above */
    char because[200];       /* why it is not simply reproduced; "" if it is */
    char condition[400];     /* one line */
} paper_row_t;

/* From paper, expected, ours, tolerance, kind and stopped alone. */
paper_verdict_t paper_judge(const paper_row_t *row);

/* "reproduced", "reproduced in kind", "not reproduced". */
const char *paper_verdict_name(paper_verdict_t verdict);

typedef struct paper paper_t;

typedef struct {
    char text[320]; /* one line */
} paper_error_t;

/* Called after each of `total` runs, by one thread at a time. */
typedef void (*paper_progress_t)(void *context, size_t done, size_t total);

/* Runs the experiments of these figures in this many threads (at least 1) and judges them; seed: of all
 * noise. progress may be NULL. NULL: `why` says what was refused. Some 60 MB. */
paper_t *paper_run(const bool wanted[PAPER_FIGURES], uint64_t seed, unsigned threads,
                   paper_progress_t progress, void *context, paper_error_t *why);
void paper_free(paper_t *paper);

/* The rows, figure by figure. */
size_t paper_row_count(const paper_t *paper);
const paper_row_t *paper_row(const paper_t *paper, size_t n);
const paper_row_t *paper_row_by_id(const paper_t *paper, const char *id); /* NULL: none */

/* The figure's traces as CSV: a line of names with units, then numbers; empty where a run is shorter than
 * another. Nothing for a figure that was not wanted. */
void paper_write_csv(const paper_t *paper, size_t figure, FILE *file);

/* ---- theory, independent of the firmware ---- */

/* k_p [rad/s], k_i [rad/s^2] of the loop (22) with damping 1 whose -3 dB bandwidth [rad/s] this is. false: no
 * such loop (omega_c too large for it). */
bool paper_loop(double bandwidth, double omega_c, double *kp, double *ki);

/* Lag of the sampled observer with one sigmoid per axis and no filter [rad], negative for positive omega_e
 * [rad/s]: k_f by its describing function, voltages held over a period. */
double paper_lag_sampled(double gain, double slope, double omega_e);

/* Eq. (14) with (13) as printed and the same k_f [rad]. */
double paper_lag_printed(double gain, double slope, double omega_e);

#endif
