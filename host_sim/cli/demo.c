/* `lagless demo`: the drive in commissioning mode (encoder) through speed steps and a load step on the
 * switched plant. */
#include <argp.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "host_sim/cli/cli.h"
#include "host_sim/cli/output.h"
#include "host_sim/lab/paper_drive.h"
#include "host_sim/lab/times.h"
#include "host_sim/rig/rig.h"

#define RPM        (2.0 * 3.14159265358979 / 60.0) /* [rad/s] */
#define PI         3.14159265358979
#define DECIMATION 4u
#define READY      1.0   /* [s] offsets are measured by then, or never */
#define TRANSIENT  0.005 /* [s] after each step that the i_d figure leaves out */
#define SETTLED    1.0   /* [r/min] */
#define WINDOW     0.1   /* [s] at the end of a segment over which the settled speed is averaged */

typedef struct {
    double duration; /* [s] */
    double rpm;      /* [r/min] reference */
    double load;     /* [N m] */
} segment_t;

static const segment_t profile[] = {
    {2.0, 100.0, 0.0}, {2.8, 1500.0, 0.0}, {2.2, 1000.0, 0.0}, {1.8, 1000.0, 5.0}, {3.6, -1000.0, 5.0},
};
#define SEGMENTS (sizeof profile / sizeof profile[0])

typedef struct {
    double settled_rpm;   /* mean over the last WINDOW */
    double settle_s;      /* from the step until the speed stays within SETTLED; NAN: it does not */
    double i_d_peak;      /* [A] largest deviation of i_d after TRANSIENT */
    double i_peak;        /* [A] largest phase current */
    double theta_sd_mrad; /* angle that the drive uses against the true one */
} result_t;

/* Rows of the tap, in this order. */
static const char *const tapped[] = {"omega_m_ref", "true_omega_m", "i_d_ref",  "true_i_d", "i_q_ref",
                                     "true_i_q",    "true_i_a",     "true_i_b", "true_i_c", "theta_err",
                                     "true_torque", "duty_a",       "duty_b",   "duty_c"};
#define TAPPED (sizeof tapped / sizeof tapped[0])
enum {
    OMEGA_REF,
    OMEGA,
    I_D_REF,
    I_D,
    I_Q_REF,
    I_Q,
    I_A,
    I_B,
    I_C,
    THETA_ERR,
    TORQUE,
    DUTY_A,
    DUTY_B,
    DUTY_C
};

typedef struct {
    FILE *csv;
    uint32_t first;      /* [periods] of the recording */
    uint32_t begin, end; /* [periods] of the segment */
    const segment_t *segment;
    result_t result;
    double last_unsettled; /* [s] in the segment */
    double speed_sum, theta_sum, theta_squares;
    uint32_t window_count, count;
} watch_t;

static void watch(void *context, uint32_t period, const uint32_t *slots, uint32_t count)
{
    watch_t *w = context;
    float value[TAPPED];
    memcpy(value, slots, count * sizeof value[0]);

    const double rpm = (double)value[OMEGA] / RPM;
    const double time = (period - w->begin) * RIG_PERIOD_SECONDS;
    const double theta_mrad = 1e3 * (double)value[THETA_ERR];
    if (fabs(rpm - w->segment->rpm) > SETTLED) {
        w->last_unsettled = time + RIG_PERIOD_SECONDS;
    }
    if (time >= TRANSIENT) {
        w->result.i_d_peak = fmax(w->result.i_d_peak, fabs((double)(value[I_D] - value[I_D_REF])));
    }
    for (int n = I_A; n <= I_C; n++) {
        w->result.i_peak = fmax(w->result.i_peak, fabs((double)value[n]));
    }
    if (period >= w->end - rig_periods(WINDOW)) {
        w->speed_sum += rpm;
        w->window_count++;
    }
    w->theta_sum += theta_mrad;
    w->theta_squares += theta_mrad * theta_mrad;
    w->count++;

    if (w->csv != NULL && (period - w->first) % DECIMATION == 0u) {
        char when[TIMES_TEXT_SIZE];
        fprintf(w->csv, "%s,%.6g,%.6g,%.5g,%.5g,%.5g,%.5g,%.5g,%.5g,%.5g,%.5g,%.5g,%.5g\n",
                times_text(when, period - w->first), (double)value[OMEGA_REF] / RPM, rpm,
                (double)value[I_D_REF], (double)value[I_D], (double)value[I_Q_REF], (double)value[I_Q],
                (double)value[I_A], theta_mrad, (double)value[TORQUE], (double)value[DUTY_A],
                (double)value[DUTY_B], (double)value[DUTY_C]);
    }
}

static bool go(rig_t *rig, const char *name, double value)
{
    if (!rig_put(rig, name, value)) {
        fprintf(stderr, "lagless demo: %s\n", rig_error(rig));
        return false;
    }
    return true;
}

static bool run_profile(rig_t *rig, FILE *csv, result_t results[SEGMENTS])
{
    watch_t w = {.csv = csv};
    uint32_t ids[TAPPED];
    for (size_t n = 0; n < TAPPED; n++) {
        ids[n] = rig_row_by_name(tapped[n])->id;
    }

    if (!paper_drive_put(rig, paper_drive, paper_drive_count) || !rig_apply(rig)) {
        fprintf(stderr, "lagless demo: %s\n", rig_error(rig));
        return false;
    }
    /* Offsets are measured with the rotor at rest; then the drive is switched on at zero speed. */
    const double ready = 1.0;
    rig_stop_when(rig, rig_row_by_name("state")->id, RIG_EQUAL, ready);
    if (rig_run(rig, rig_periods(READY)) == rig_periods(READY)) {
        fprintf(stderr, "lagless demo: the drive did not become ready\n");
        return false;
    }
    rig_stop_when(rig, rig_row_by_name("state")->id, RIG_NEVER, 0.0);
    if (!go(rig, "enable", 1.0) || !rig_tap(rig, ids, TAPPED, 1u, watch, &w)) {
        return false;
    }

    w.first = rig_period(rig);
    for (size_t n = 0; n < SEGMENTS; n++) {
        const uint32_t periods = rig_periods(profile[n].duration);
        w = (watch_t){.csv = csv, .first = w.first, .begin = rig_period(rig), .segment = &profile[n]};
        w.end = w.begin + periods;
        if (!go(rig, "speed_request", profile[n].rpm * RPM) || !go(rig, "load_torque", profile[n].load)) {
            return false;
        }
        rig_run(rig, periods);
        const double mean = w.theta_sum / w.count;
        w.result.settled_rpm = w.speed_sum / w.window_count;
        w.result.settle_s = w.last_unsettled < profile[n].duration ? w.last_unsettled : (double)NAN;
        w.result.theta_sd_mrad = sqrt(w.theta_squares / w.count - mean * mean);
        results[n] = w.result;
    }
    const double fault = rig_value(rig, "fault_reason");
    if (fault != 0.0) {
        fprintf(stderr, "lagless demo: the drive stopped with fault reason %.0f\n", fault);
    }
    return fault == 0.0;
}

static void print_number(double value)
{
    if (isnan(value)) {
        printf("null");
    } else {
        printf("%.4g", value);
    }
}

static void print_json(const result_t results[SEGMENTS])
{
    printf("{\"segments\": [");
    for (size_t n = 0; n < SEGMENTS; n++) {
        printf("%s{\"reference_rpm\": %g, \"load_nm\": %g, \"settled_rpm\": %.3f, \"settle_s\": ",
               n == 0 ? "" : ", ", profile[n].rpm, profile[n].load, results[n].settled_rpm);
        print_number(results[n].settle_s);
        printf(", \"i_d_peak_a\": %.3f, \"i_peak_a\": %.3f, \"theta_sd_mrad\": %.3f}", results[n].i_d_peak,
               results[n].i_peak, results[n].theta_sd_mrad);
    }
    printf("]}\n");
}

static void print_table(const result_t results[SEGMENTS])
{
    printf(
        "encoder mode, switched inverter, paper's motor on its rig (J 0.0636 kg m^2, friction 1.32 N m)\n\n");
    printf("reference   load   settled    within    |i_d| after  largest phase  angle\n");
    printf("[r/min]    [N m]   [r/min]    1 r/min   5 ms [A]     current [A]    SD [mrad]\n");
    for (size_t n = 0; n < SEGMENTS; n++) {
        printf("%7.0f  %7.1f  %9.2f  ", profile[n].rpm, profile[n].load, results[n].settled_rpm);
        if (isnan(results[n].settle_s)) {
            printf("   never");
        } else {
            printf("%6.2f s", results[n].settle_s);
        }
        printf("  %11.3f  %13.2f  %9.2f\n", results[n].i_d_peak, results[n].i_peak, results[n].theta_sd_mrad);
    }
}

typedef struct {
    bool json;
    const char *folder;
} options_t;

static error_t parse(int key, char *argument, struct argp_state *state)
{
    options_t *options = state->input;
    switch (key) {
    case 'j':
        options->json = true;
        return 0;
    case 'o':
        options->folder = argument;
        return 0;
    case ARGP_KEY_ARG:
        argp_error(state, "%s: no argument is expected", argument);
        return 0;
    default:
        return ARGP_ERR_UNKNOWN;
    }
}

int command_demo(int argc, char **argv)
{
    static const struct argp_option rows[] = {
        {"json", 'j', NULL, 0, "one JSON object on stdout", 0},
        {"out", 'o', "FOLDER", 0, "write demo.csv and the picture demo.png there", 0},
        {0},
    };
    static const struct argp argp = {
        rows, parse, NULL, "Speed steps, a load step and a reversal with the encoder.", NULL, NULL, NULL};
    options_t options = {false, NULL};
    char csv_path[PATH_SIZE];
    char png_path[PATH_SIZE];
    FILE *csv = NULL;
    result_t results[SEGMENTS];
    if (argp_parse(&argp, argc, argv, 0, NULL, &options) != 0) {
        return EXIT_USAGE;
    }
    if (options.folder != NULL) {
        if (!output_folder(options.folder) || !output_path(csv_path, options.folder, "demo.csv") ||
            !output_path(png_path, options.folder, "demo.png")) {
            return EXIT_USAGE;
        }
        csv = output_open(csv_path);
        if (csv == NULL) {
            return EXIT_USAGE;
        }
        fprintf(csv, "time[s],speed_ref[r/min],speed[r/min],i_d_ref[A],i_d[A],i_q_ref[A],i_q[A],i_a[A],"
                     "theta_err[mrad],torque[N m],duty_a[-],duty_b[-],duty_c[-]\n");
    }

    rig_t *rig = rig_create(1);
    bool done = rig != NULL && run_profile(rig, csv, results);
    rig_free(rig);
    if (csv != NULL) {
        done = output_close(csv, csv_path) && done;
    }
    if (!done) {
        return EXIT_INTERNAL;
    }
    if (options.json) {
        print_json(results);
    } else {
        print_table(results);
    }
    if (csv != NULL) {
        if (!output_picture("plot/demo.py", csv_path, png_path,
                            "Encoder mode, switched inverter, 0 to 5 N m, rig J 0.0636 kg m^2")) {
            return EXIT_INTERNAL;
        }
        fprintf(stderr, "\npicture: %s\ndata:    %s\n", png_path, csv_path);
    }
    return EXIT_DONE;
}
