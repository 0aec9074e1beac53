/* Curves of theory that an experiment's file refers to: as CSV, and their values for claims. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "host_sim/lab/experiment_parts.h"
#include "host_sim/lab/paper_theory.h"

#define DEGREE (3.14159265358979323846 / 180.0) /* [rad] */

/* ---- sign and sigmoid over the input, -10 to 10 A in steps of 10 mA ---- */

#define INPUTS 1000

static double input(int n)
{
    return 0.01 * n;
}

static void write_switching(FILE *file)
{
    fprintf(file, "x[A],sign[-],sigmoid[-],k_f_sign[1/A],k_f_sigmoid[1/A]\n");
    for (int n = -INPUTS; n <= INPUTS; n++) {
        const double x = input(n);
        fprintf(file, "%.2f,%d,%.6g,", x, (n > 0) - (n < 0), paper_sigmoid(x));
        if (n != 0) { /* the gain of the sign function has no value at zero */
            fprintf(file, "%.6g", paper_sign_gain(x));
        }
        fprintf(file, ",%.6g\n", paper_sigmoid_gain(x));
    }
}

double experiment_sigmoid_gain_most(const double *none, uint32_t count)
{
    double most = 0.0;
    (void)none;
    (void)count;
    for (int n = -INPUTS; n <= INPUTS; n++) {
        most = fmax(most, paper_sigmoid_gain(input(n)));
    }
    return most;
}

double experiment_sign_gain_most(const double *none, uint32_t count)
{
    double most = 0.0;
    (void)none;
    (void)count;
    for (int n = 1; n <= INPUTS; n++) {
        most = fmax(most, fmax(paper_sign_gain(input(n)), paper_sign_gain(input(-n))));
    }
    return most;
}

/* ---- loop filters of equal bandwidth over the frequency ---- */

#define FREQUENCIES 251
#define BANDWIDTHS  2
#define CUTOFFS     4
static const double bandwidths[BANDWIDTHS] = {100.0, 200.0}; /* [rad/s] */
static const double cutoffs[BANDWIDTHS][CUTOFFS] = {{0.0, 12.0, 25.0, 40.0}, {0.0, 25.0, 50.0, 81.0}};

static double frequency(int n) /* [rad/s] 0.1 to 10^4 */
{
    return 0.1 * pow(10.0, n / 50.0);
}

static double loop_gain(double bandwidth, double omega_c, double omega)
{
    double gain = 0.0;
    double phase = 0.0;
    paper_loop_filter(bandwidth, omega_c, omega, &gain, &phase);
    return gain;
}

static void write_loop_filters(FILE *file)
{
    fprintf(file, "omega[rad/s]");
    for (int b = 0; b < BANDWIDTHS; b++) {
        for (int c = 0; c < CUTOFFS; c++) {
            fprintf(file, ",b%g_wc%g_gain[dB],b%g_wc%g_phase[deg]", bandwidths[b], cutoffs[b][c],
                    bandwidths[b], cutoffs[b][c]);
        }
    }
    fprintf(file, "\n");
    for (int n = 0; n < FREQUENCIES; n++) {
        const double omega = frequency(n);
        fprintf(file, "%.6g", omega);
        for (int b = 0; b < BANDWIDTHS; b++) {
            for (int c = 0; c < CUTOFFS; c++) {
                double gain = 0.0;
                double phase = 0.0;
                paper_loop_filter(bandwidths[b], cutoffs[b][c], omega, &gain, &phase);
                fprintf(file, ",%.6g,%.6g", 20.0 * log10(gain), phase / DEGREE);
            }
        }
        fprintf(file, "\n");
    }
}

static const double *cutoffs_of(double bandwidth)
{
    for (int b = 0; b < BANDWIDTHS; b++) {
        if (bandwidths[b] == bandwidth) {
            return cutoffs[b];
        }
    }
    return NULL;
}

double experiment_loop_filter_not_lower(const double *bandwidth, uint32_t count)
{
    const double *of = cutoffs_of(bandwidth[0]);
    int not_lower = 0;
    (void)count;
    for (int c = 1; c < CUTOFFS && of != NULL; c++) {
        for (int n = 0; n < FREQUENCIES; n++) {
            not_lower += loop_gain(bandwidth[0], of[c], frequency(n)) >=
                         loop_gain(bandwidth[0], of[c - 1], frequency(n));
        }
    }
    return of != NULL ? not_lower : (double)NAN;
}

double experiment_loop_filter_lower(const double *loop, uint32_t count)
{
    double least = (double)INFINITY;
    (void)count;
    for (int n = 0; n < FREQUENCIES; n++) {
        const double conventional = loop_gain(loop[0], 0.0, frequency(n));
        least = fmin(least, 20.0 * log10(conventional / loop_gain(loop[0], loop[1], frequency(n))));
    }
    return least;
}

/* ---- by name ---- */

const char *const experiment_curve_names = "switching_functions|loop_filters";

static const experiment_curve_t curves[] = {{"switching_functions", write_switching},
                                            {"loop_filters", write_loop_filters}};

const experiment_curve_t *experiment_curve(const char *name)
{
    for (size_t n = 0; n < sizeof curves / sizeof curves[0]; n++) {
        if (strcmp(curves[n].name, name) == 0) {
            return &curves[n];
        }
    }
    return NULL;
}
