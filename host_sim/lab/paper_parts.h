/* What the files of paper.h share: a run and what it needs, its numbers, and how rows are made of them. */
#ifndef HOST_SIM_LAB_PAPER_PARTS_H
#define HOST_SIM_LAB_PAPER_PARTS_H

#include "host_sim/lab/experiment.h"
#include "host_sim/lab/map.h"
#include "host_sim/lab/paper.h"
#include "host_sim/lab/paper_drive.h"
#include "host_sim/lab/paper_theory.h"
#include "host_sim/rig/rig.h"

#define RPM   0.10471975511965977462 /* 2 pi/60 [rad/s] */
#define MRAD  1e-3                   /* [rad] */
#define RATED 5.0                    /* [N m] */
#define KS    200.0                  /* [V] k_s by the rule of erratum 5 */

/* Indices in paper_figures. */
typedef enum {
    FIG04,
    FIG05,
    FIG08,
    FIG10,
    FIG11,
    FIG12,
    FIG13,
    FIG14,
    FIG15,
    FIG16,
    FIG17,
    BEYOND_SPEED,
    BEYOND_BANDWIDTH,
    BEYOND_MAP
} figure_t;

/* ---- a run ---- */

typedef enum { SIGN, SIGMOID, SIGMOID_VECTOR } switching_t; /* as the choices of observer_switching */
typedef enum { LAG_NONE, LAG_PRINTED, LAG_CORRECTED, LAG_EXACT } lag_t; /* of lag_compensation */
typedef enum { HOLD, STEPS, QUICK_STEPS, PROFILES } profile_t;
typedef enum { BOTH, REAL } flavours_t;

typedef struct {
    figure_t figure;
    char name[32]; /* of its traces and for the judgement; unique in the figure */
    profile_t profile;
    double rpm;    /* of HOLD [r/min] */
    double length; /* of HOLD, rounded up to whole electrical periods [s] */
    flavours_t flavours;
    double load;           /* from the start [N m] */
    switching_t switching; /* slope 1/A */
    double gain;           /* k_s [V] */
    double omega_s;        /* of the EMF filter [rad/s]; 0: none */
    lag_t lag;
    double bandwidth; /* -3 dB [rad/s], damping 1 */
    double omega_c;   /* [rad/s]; 0: conventional */
    bool torque;      /* [-] the torque is fed forward too */
    double dead_time; /* lost of each edge, and nothing compensated [us]; 0: the plant's, compensated */
    uint64_t reseed;  /* added to the seed of the noise */
    bool sweep;       /* [-] of fig15's dead times: no trace */
} run_t;

/* Every run of these figures, the two flavours of one beside each other. Their number; `runs` may be NULL. */
typedef struct {
    run_t run;
    bool real; /* [-] else ideal */
} flavoured_t;
size_t paper_plan(const bool wanted[PAPER_FIGURES], flavoured_t *to);

extern const char *const load_names[2]; /* of no load and RATED */
/* Beyond the paper. */
#define SPEEDS_BEYOND     8
#define BANDWIDTHS_BEYOND 7
#define VARIANTS_BEYOND   3
extern const double speeds_beyond[SPEEDS_BEYOND];         /* [r/min] */
extern const double bandwidths_beyond[BANDWIDTHS_BEYOND]; /* [rad/s] */
extern const char *const speed_variants[VARIANTS_BEYOND];
extern const char *const bandwidth_variants[VARIANTS_BEYOND];
enum { V_UNCOMPENSATED, V_PRINTED, V_LAGLESS };               /* of speed_variants */
enum { V_CONVENTIONAL, V_FEEDFORWARD, V_TORQUE_FEEDFORWARD }; /* of bandwidth_variants */

/* The run's conditions in one line. */
void paper_describe(char *to, size_t size, const run_t *run, bool real);
extern const char *const paper_switching_names[], *const paper_lag_names[];

/* ---- what happens during a run ---- */

typedef struct {
    double time;  /* [s] */
    double speed; /* that is asked for from then on [r/min] */
} event_t;

/* A window's numbers are taken from begin to end. */
typedef struct {
    double begin, end; /* [s] */
    double from, to;   /* [r/min]; equal: a steady speed */
} window_t;

#define EVENTS_MAX  4
#define WINDOWS_MAX 5

typedef struct {
    double rpm;    /* at the start */
    double length; /* [s] */
    event_t events[EVENTS_MAX];
    size_t event_count;
    window_t windows[WINDOWS_MAX];
    size_t window_count;
} course_t;

course_t paper_course(const run_t *run);

/* Names of the windows. */
enum { SLOW = 0, UP = 1, FAST = 2, DOWN = 3, MIDDLE = 4 }; /* STEPS, QUICK_STEPS */

/* ---- traces ---- */

enum { C_SPEED, C_SPEED_HAT, C_ERROR, COLUMNS };
#define BIT(column) (1u << (column))

/* What a figure shows of each run over time. */
typedef struct {
    unsigned columns; /* bits; 0: no trace */
    uint32_t every;   /* [periods] a row */
} shown_t;
extern const shown_t paper_shown[PAPER_FIGURES];
size_t paper_columns(size_t figure); /* their number */

/* ---- what came of a run ---- */

/* A window's numbers. Angles [mrad], speeds [r/min]. */
typedef struct {
    double count;
    double mean, sd;             /* of the angle's error */
    double peak;                 /* its largest magnitude */
    double speed;                /* mean of the true one */
    double speed_sd, speed_peak; /* of the estimated speed less the true one */
    double plateau;              /* mean error late in a speed change; NAN: none */
    double acceleration;         /* mean there [rad/s^2], electrical */
} numbers_t;

typedef struct {
    run_t run;
    bool real;     /* [-] */
    int32_t fault; /* [-] the drive's reason; 0: none */
    bool lost;     /* [-] fault, or a steady window's mean speed is far off */
    numbers_t numbers[WINDOWS_MAX];
    float *trace; /* the figure's columns, row by row; NULL: not recorded */
    size_t rows, rows_max;
} result_t;

/* Runs it on a rig of its own; false: why not, one line. */
bool paper_measure(result_t *result, uint64_t seed, char why[POOL_WHY]);

struct paper {
    bool wanted[PAPER_FIGURES + 1u];
    paper_figure_t about[PAPER_FIGURES + 1u];
    experiment_t *files[PAPER_FIGURES + 1u]; /* NULL: the figure is none of a file */
    experiment_t *more[PAPER_FIGURES + 1u];  /* their second files; NULL: none */
    uint64_t seed;
    bool traced; /* the traces of files are kept */
    result_t *results;
    size_t result_count;
    map_point_t *points; /* of beyond_map; NULL: not wanted */
    size_t point_count;
    paper_row_t rows[PAPER_ROWS_MAX];
    size_t row_count;
};

/* The run must be there. */
const result_t *paper_find(const paper_t *paper, figure_t figure, const char *name, bool real);

/* Of beyond_speed or beyond_bandwidth: which of its variants this is. */
const char *paper_variant(const run_t *run);

/* Does the run belong to what the figure's main CSV shows? */
bool paper_of_figure(const result_t *result, size_t figure);

/* ---- judgement ---- */

/* What the row says beside its number. */
typedef struct {
    figure_t figure;
    const char *id; /* after the figure's */
    const char *claim;
    const char *unit;
    double paper; /* NAN: none; then `theory` is what ours is judged against */
    double theory;
    double tolerance;
    const char *because; /* if ours is not the paper's, or the claim does not hold */
} claim_t;

/* Judged against the paper's number. */
claim_t paper_claim(figure_t figure, const char *id, const char *claim, const char *unit, double number,
                    double tolerance, const char *because);

/* The print has no number: judged against what theory says; INFINITY: against `kind` alone. */
claim_t paper_claim_of_theory(figure_t figure, const char *id, const char *claim, const char *unit,
                              double theory_number, double tolerance, const char *because);

/* Rows. kind: the claim holds. Of one run; of several runs, one of which stands for the
 * conditions, `stopped` if a run among them was lost that should not have been. */
void paper_row_of(paper_t *paper, const claim_t *claim, const result_t *result, double ours, bool kind);
void paper_row_of_several(paper_t *paper, const claim_t *claim, const result_t *one, bool stopped,
                          double ours, bool kind, const char *condition);
/* Of a run that may well be lost: that is what the row is about. */
void paper_row_of_loss(paper_t *paper, const claim_t *claim, const result_t *result);
/* As a file's experiment says. */
void paper_row_of_file(paper_t *paper, size_t figure, const experiment_row_t *of);
/* Of the map. */
void paper_row_of_map(paper_t *paper, const claim_t *claim, bool stopped, double ours, const char *condition);

/* Judges what is beyond the paper. */
void paper_judge_beyond(paper_t *paper, figure_t figure);

#endif
