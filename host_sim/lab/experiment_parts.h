/* Data and functions that the sources of experiment.h share. */
#ifndef HOST_SIM_LAB_EXPERIMENT_PARTS_H
#define HOST_SIM_LAB_EXPERIMENT_PARTS_H

#include "host_sim/lab/experiment.h"
#include "host_sim/lab/scenario_parts.h"
#include "host_sim/lab/tally.h"

#define SWEEPS_MAX  6u
#define EACH_MAX    4u
#define COLUMNS_MAX 16u
#define NAME_MAX    96u
#define WHY_MAX     400u /* [octets] of a message about a text */
#define TEXT_MAX    640u /* [octets] of a text with its values */

/* ---- names that a file may use (experiment_functions.c) ---- */

typedef struct {
    const char *name;
    const scenario_setting_t *settings;
    uint32_t count;
} experiment_set_t;
const experiment_set_t *experiment_set(const char *name); /* NULL: none */
extern const char *const experiment_set_names;            /* "paper|ideal" */

struct experiment_run;

/* Function of a sample [SI] with a result [unit]; `run` is the run of the sample. */
typedef struct {
    const char *name, *unit;
    double (*of)(double sample, const struct experiment_run *run);
} experiment_through_t;
const experiment_through_t *experiment_through(const char *name);
extern const char *const experiment_through_names;

/* Function of numbers, also of the numbers of several points: NAME(... for SWEEP). */
#define ARGUMENTS_MAX 16u
typedef struct {
    const char *name;
    uint32_t least, most; /* arguments */
    double (*of)(const double *arguments, uint32_t count);
    uint32_t each; /* arguments per point; 0: not a function of points */
    double none;   /* result without any point */
} experiment_function_t;
const experiment_function_t *experiment_function(const char *name, size_t length);
extern const char *const experiment_function_names;

/* Theoretical curves, which are the whole CSV (experiment_curves.c). */
typedef struct {
    const char *name;
    void (*write)(FILE *file);
} experiment_curve_t;
const experiment_curve_t *experiment_curve(const char *name);
extern const char *const experiment_curve_names;

/* Values of these curves for claims. sigmoid_gain_most, sign_gain_most: largest f(x)/x over the inputs of the
 * curve [1/A]. loop_filter_not_lower: number of frequencies at which a larger omega_c does not reduce the
 * gain, for this -3 dB bandwidth [rad/s]. loop_filter_lower: least difference [dB] by which the gain with
 * this omega_c is below that of the conventional loop. NAN: not a bandwidth of the curve. */
double experiment_sigmoid_gain_most(const double *none, uint32_t count);
double experiment_sign_gain_most(const double *none, uint32_t count);
double experiment_loop_filter_not_lower(const double *bandwidth, uint32_t count);
double experiment_loop_filter_lower(const double *loop, uint32_t count);

/* ---- a file ---- */

typedef struct {
    const char *name, *text;
    uint32_t entry;             /* a table of rows; 0: this setting */
    scenario_setting_t setting; /* name of a point in a sweep of one row over values */
    const experiment_set_t *uses[4];
    uint32_t use_count;
    scenario_event_t ready; /* rows of its begin */
    double settle;          /* [s]; NAN: not given */
    double number;          /* value of the point in expressions; NAN: none */
    bool *only[SWEEPS_MAX]; /* points of another sweep with which it is combined; NULL: all */
} point_t;

typedef struct {
    const char *name;
    point_t *points;
    uint32_t count;
    bool of_seed; /* the numbers are seeds */
    scenario_place_t place;
} sweep_t;

/* A signal with the processing of its samples. */
typedef struct {
    const char *name;
    const table_row_t *row, *minus; /* minus NULL: none */
    const experiment_through_t *through;
    const char *unit; /* of the numbers */
    double scale;     /* [SI] of one of them */
} look_t;

typedef struct {
    look_t look;
    double from, to;     /* [s] */
    uint32_t begin, end; /* [periods]; end UINT32_MAX: that of the run */
    const table_row_t *progress;
    double past, until; /* [unit of progress] */
    scenario_place_t place;
} measure_t;

typedef struct {
    const char *id, *text, *unit, *why_not, *where;
    const char *value;    /* expression; NULL: `of` of `measure` */
    const char *theory;   /* expression; NULL: theory_number */
    const char *holds_if; /* NULL: none */
    uint32_t measure;
    statistic_t of;
    double printed, theory_number;
    double tolerance[EACH_MAX];
    bool each[EACH_MAX];      /* judged for this entry of the experiment's `each` */
    uint32_t unsaid;          /* one bit for each sweep that `at` does not contain */
    uint32_t *at[SWEEPS_MAX]; /* the points */
    uint32_t at_count[SWEEPS_MAX];
} claim_t;

/* An expression with a name. */
typedef struct {
    const char *name, *text;
    scenario_place_t place;
} named_t;

/* A column of the table. */
typedef struct {
    const char *name, *unit;
    const char *value; /* expression; NULL: the name of the point of `sweep` */
    uint32_t sweep;
    scenario_place_t place;
} cell_t;

typedef struct experiment_run {
    uint32_t point[SWEEPS_MAX];
    char name[NAME_MAX];    /* names of the points without the flavour */
    const char *flavour;    /* "" if there is no `each` */
    uint64_t reseed;        /* added to the seed of the noise */
    scenario_t *scenario;   /* of this point */
    scenario_event_t ready; /* rows that change when the drive is ready */
    double settle;          /* [s] */
    double ki;              /* [rad/s^2] of its tracking loop, for theory; NAN: there is none */
    double load;            /* [N m] present load */
    tally_t *tallies;       /* of the measures */
    bool lost;
    int32_t fault;
    float *trace;
    size_t rows, rows_max;
} experiment_run_t;

struct experiment {
    scenario_t *base; /* holds the file and all memory */
    const char *id, *claim, *source, *condition;
    const experiment_curve_t *curve; /* NULL: none */
    bool dynamometer;
    bool whole_turns; /* durations are rounded up to them, electrical */
    point_t begin;    /* settle and rows of [begin]; uses of [experiment] */
    sweep_t *sweeps;
    uint32_t sweep_count;
    uint32_t each_sweep; /* sweep_count: none */
    uint32_t each[EACH_MAX];
    uint32_t each_count; /* >= 1 */
    named_t *lets;
    uint32_t let_count;
    measure_t *measures;
    uint32_t measure_count;
    claim_t *claims;
    uint32_t claim_count;
    look_t columns[COLUMNS_MAX];
    uint32_t column_count;
    uint32_t every;            /* [periods] of the trace */
    look_t reference;          /* row NULL: none */
    cell_t cells[COLUMNS_MAX]; /* of the table */
    uint32_t cell_count;       /* 0: no table */
    bool lines[SWEEPS_MAX];    /* the sweeps whose points make its lines */
    experiment_run_t *runs;
    uint32_t run_count;
    uint32_t
        *run_of; /* index of the run by place in the grid, the first sweep varies fastest; NO_RUN: none */
    bool idle;   /* nothing runs */
};

#define NO_RUN UINT32_MAX

/* ---- values (experiment_value.c, experiment_expression.c) ---- */

/* Value of a row at t = 0 [unit of the row] as it is written, not rounded to the type of the drive. */
double experiment_initial(const experiment_run_t *run, const table_row_t *row);

typedef struct {
    const experiment_t *experiment;
    const uint32_t *point; /* [sweep_count] */
    double own;            /* `value`; NAN: there is none yet */
    bool unmeasured;       /* only the text is checked, before the runs */
    uint32_t nested;       /* nesting depth of texts of points */
    uint32_t ranged;       /* result: one bit for each sweep that a `for` uses */
    bool lost;             /* result: a needed run is lost */
    char why[WHY_MAX];     /* result: error of the text; "": none */
} value_t;

/* The number of an expression. NAN: the expression is wrong; value->why has the message. */
double experiment_evaluate(value_t *value, const char *text);

/* The run at these points; NULL: there is none. */
const experiment_run_t *experiment_run_at(const experiment_t *experiment, const uint32_t *point);

/* The measure of this name; measure_count: none. */
uint32_t experiment_measure_of(const experiment_t *experiment, const char *name, size_t length);

/* Replaces {SWEEP} in a text by the text of its point, and {EXPRESSION} by its number. false: value->why has
 * the message. */
bool experiment_text(value_t *value, const char *text, char *to, size_t size);

/* Number of points of a claim for one entry of `each`, and the n-th of them; the first sweep varies fastest.
 */
size_t experiment_claim_points(const experiment_t *experiment, const claim_t *claim);
void experiment_claim_point(const experiment_t *experiment, const claim_t *claim, uint32_t each, size_t n,
                            uint32_t point[SWEEPS_MAX]);

/* Advances to the next point of these sweeps (one bit each); the first sweep varies fastest. false: it was
 * the last point. */
bool experiment_next(const experiment_t *experiment, uint32_t sweeps, uint32_t *point);

#endif
