/* The names that the file of an experiment may use: sets of rows, functions of a sample, functions of
 * numbers.
 */
#include <math.h>
#include <string.h>

#include "host_sim/lab/experiment_parts.h"
#include "host_sim/lab/paper_drive.h"
#include "host_sim/lab/paper_theory.h"

/* ---- sets of rows ---- */

const char *const experiment_set_names = "paper|ideal";

#define SET_MAX 48u

static scenario_setting_t paper_rows[SET_MAX];
static scenario_setting_t ideal_rows[SET_MAX];
static experiment_set_t sets[] = {{"paper", paper_rows, 0u}, {"ideal", ideal_rows, 0u}};

static void fill(experiment_set_t *set, scenario_setting_t *to, const setting_t *from, size_t count)
{
    for (size_t n = 0; n < count && set->count < SET_MAX; n++) {
        to[set->count++] = (scenario_setting_t){rig_row_by_name(from[n].row), from[n].value, {0u, 0u}};
    }
}

const experiment_set_t *experiment_set(const char *name)
{
    if (sets[0].count == 0u) {
        const setting_t machine[] = {
            {"plant.flux_linkage", paper_machine.flux_linkage},
            {"plant.inertia", paper_machine.inertia},
            {"plant.friction_coulomb", paper_machine.friction},
            {"params.current_limit", paper_machine.current_limit},
        };
        fill(&sets[0], paper_rows, machine, sizeof machine / sizeof machine[0]);
        fill(&sets[0], paper_rows, paper_drive, paper_drive_count);
        fill(&sets[0], paper_rows, paper_common, paper_common_count);
        fill(&sets[1], ideal_rows, paper_ideal, paper_ideal_count);
    }
    for (size_t n = 0; n < sizeof sets / sizeof sets[0]; n++) {
        if (strcmp(sets[n].name, name) == 0) {
            return &sets[n];
        }
    }
    return NULL;
}

/* ---- of a sample ---- */

static double row_of(const experiment_run_t *run, const char *name)
{
    return experiment_initial(run, rig_row_by_name(name));
}

/* f(x)/x of eq. (12), of a current. */
static double sigmoid_gain(double x, const experiment_run_t *run)
{
    (void)run;
    return paper_sigmoid_gain(x);
}

static double sign_gain(double x, const experiment_run_t *run)
{
    (void)run;
    return paper_sign_gain(x);
}

/* The switching function of the run's observer. */
static double switching_gain(double x, const experiment_run_t *run)
{
    return row_of(run, "params.observer_switching") == 0.0 ? sign_gain(x, run) : sigmoid_gain(x, run);
}

static double per_pole_pair(double x, const experiment_run_t *run)
{
    return x / row_of(run, "plant.pole_pairs");
}

/* The lag of the sampled observer at this mechanical speed, with k_s and slope of the run. */
static double observer_lag(double x, const experiment_run_t *run)
{
    return paper_lag_sampled(row_of(run, "params.observer_gain"), row_of(run, "params.observer_slope"),
                             row_of(run, "plant.pole_pairs") * x);
}

/* The error of a conventional loop with k_i of the run, while this torque accelerates the rotor. */
static double loop_error(double x, const experiment_run_t *run)
{
    const double torque = x - run->load - row_of(run, "plant.friction_coulomb");
    return paper_tracking_error(run->ki,
                                row_of(run, "plant.pole_pairs") * torque / row_of(run, "plant.inertia"));
}

const char *const experiment_through_names =
    "sigmoid_gain|sign_gain|switching_gain|per_pole_pair|observer_lag|loop_error";
static const experiment_through_t throughs[] = {
    {"sigmoid_gain", "1/A", sigmoid_gain},     {"sign_gain", "1/A", sign_gain},
    {"switching_gain", "1/A", switching_gain}, {"per_pole_pair", UNITS_SPEED, per_pole_pair},
    {"observer_lag", "rad", observer_lag},     {"loop_error", "rad", loop_error},
};

const experiment_through_t *experiment_through(const char *name)
{
    for (size_t n = 0; n < sizeof throughs / sizeof throughs[0]; n++) {
        if (strcmp(throughs[n].name, name) == 0) {
            return &throughs[n];
        }
    }
    return NULL;
}

/* ---- of numbers ---- */

static double f_abs(const double *x, uint32_t count)
{
    (void)count;
    return fabs(x[0]);
}

static double f_sqrt(const double *x, uint32_t count)
{
    (void)count;
    return sqrt(x[0]);
}

static double f_sin(const double *x, uint32_t count)
{
    (void)count;
    return sin(x[0]);
}

static double f_cos(const double *x, uint32_t count)
{
    (void)count;
    return cos(x[0]);
}

static double f_tan(const double *x, uint32_t count)
{
    (void)count;
    return tan(x[0]);
}

static double f_asin(const double *x, uint32_t count)
{
    (void)count;
    return asin(x[0]);
}

static double f_max(const double *x, uint32_t count)
{
    double most = x[0];
    for (uint32_t n = 1; n < count; n++) {
        most = x[n] > most || isnan(x[n]) ? x[n] : most;
    }
    return most;
}

static double f_min(const double *x, uint32_t count)
{
    double least = x[0];
    for (uint32_t n = 1; n < count; n++) {
        least = x[n] < least || isnan(x[n]) ? x[n] : least;
    }
    return least;
}

/* The number with the largest magnitude, with its sign. */
static double f_worst(const double *x, uint32_t count)
{
    double worst = x[0];
    for (uint32_t n = 1; n < count; n++) {
        worst = fabs(x[n]) > fabs(worst) || isnan(x[n]) ? x[n] : worst;
    }
    return worst;
}

static double f_sum(const double *x, uint32_t count)
{
    double sum = 0.0;
    for (uint32_t n = 0; n < count; n++) {
        sum += x[n];
    }
    return sum;
}

static double f_mean(const double *x, uint32_t count)
{
    return f_sum(x, count) / count;
}

/* For pairs x, y with ascending x: the x of the least y. Between the points it follows from the parabola
 * through the lowest point and its two neighbours. NAN: it is at an end. */
static double f_lowest_at(const double *pair, uint32_t count)
{
    uint32_t low = 0;
    for (uint32_t n = 0; n < count; n += 2u) {
        low = pair[n + 1u] < pair[low + 1u] ? n : low;
    }
    if (low == 0u || low + 2u >= count) {
        return (double)NAN;
    }
    const double *left = &pair[low - 2u];
    const double *middle = &pair[low];
    const double *right = &pair[low + 2u];
    const double slope_left = (middle[1] - left[1]) / (middle[0] - left[0]);
    const double slope_right = (right[1] - middle[1]) / (right[0] - middle[0]);
    const double curvature = (slope_right - slope_left) / (right[0] - left[0]);
    return 0.5 * (left[0] + middle[0]) - 0.5 * slope_left / curvature;
}

static double f_lag_sampled(const double *x, uint32_t count)
{
    (void)count;
    return paper_lag_sampled(x[0], x[1], x[2]);
}

static double f_lag_printed(const double *x, uint32_t count)
{
    (void)count;
    return paper_lag_printed(x[0], x[1], x[2]);
}

static double f_loop_kp(const double *x, uint32_t count)
{
    double kp = (double)NAN;
    double ki = (double)NAN;
    (void)count;
    (void)paper_loop(x[0], x[1], &kp, &ki);
    return kp;
}

static double f_loop_ki(const double *x, uint32_t count)
{
    double kp = (double)NAN;
    double ki = (double)NAN;
    (void)count;
    (void)paper_loop(x[0], x[1], &kp, &ki);
    return ki;
}

static double f_tracking_error(const double *x, uint32_t count)
{
    (void)count;
    return paper_tracking_error(x[0], x[1]);
}

static double f_tracking_error_at_limit(const double *x, uint32_t count)
{
    (void)count;
    return paper_tracking_error_at_limit(x[0], x[1]);
}

const char *const experiment_function_names =
    "abs|sqrt|sin|cos|tan|asin|max|min|worst|sum|mean|lowest_at|lag_sampled|lag_printed|loop_kp|loop_ki|"
    "tracking_error|"
    "tracking_error_at_limit|sigmoid_gain_most|sign_gain_most|loop_filter_not_lower|loop_filter_lower";
static const experiment_function_t functions[] = {
    {"abs", 1, 1, f_abs, 0, 0.0},
    {"sqrt", 1, 1, f_sqrt, 0, 0.0},
    {"sin", 1, 1, f_sin, 0, 0.0},
    {"cos", 1, 1, f_cos, 0, 0.0},
    {"tan", 1, 1, f_tan, 0, 0.0},
    {"asin", 1, 1, f_asin, 0, 0.0},
    {"max", 1, ARGUMENTS_MAX, f_max, 1, -(double)INFINITY},
    {"min", 1, ARGUMENTS_MAX, f_min, 1, (double)INFINITY},
    {"worst", 1, ARGUMENTS_MAX, f_worst, 1, (double)NAN},
    {"sum", 1, ARGUMENTS_MAX, f_sum, 1, 0.0},
    {"mean", 1, ARGUMENTS_MAX, f_mean, 1, (double)NAN},
    {"lowest_at", 6, ARGUMENTS_MAX, f_lowest_at, 2, (double)NAN},
    {"lag_sampled", 3, 3, f_lag_sampled, 0, 0.0},
    {"lag_printed", 3, 3, f_lag_printed, 0, 0.0},
    {"loop_kp", 2, 2, f_loop_kp, 0, 0.0},
    {"loop_ki", 2, 2, f_loop_ki, 0, 0.0},
    {"tracking_error", 2, 2, f_tracking_error, 0, 0.0},
    {"tracking_error_at_limit", 2, 2, f_tracking_error_at_limit, 0, 0.0},
    {"sigmoid_gain_most", 0, 0, experiment_sigmoid_gain_most, 0, 0.0},
    {"sign_gain_most", 0, 0, experiment_sign_gain_most, 0, 0.0},
    {"loop_filter_not_lower", 1, 1, experiment_loop_filter_not_lower, 0, 0.0},
    {"loop_filter_lower", 2, 2, experiment_loop_filter_lower, 0, 0.0},
};

const experiment_function_t *experiment_function(const char *name, size_t length)
{
    for (size_t n = 0; n < sizeof functions / sizeof functions[0]; n++) {
        if (strlen(functions[n].name) == length && strncmp(functions[n].name, name, length) == 0) {
            return &functions[n];
        }
    }
    return NULL;
}
