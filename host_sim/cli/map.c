/* `lagless map`: how far the estimated angle is off when the drive believes something wrong, and whether that
 * is what theory says. */
#include <argp.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "host_sim/cli/cli.h"
#include "host_sim/cli/output.h"
#include "host_sim/lab/json.h"
#include "host_sim/lab/map.h"

#define CONDITIONS_SIZE 128

typedef struct {
    bool json;
    const char *folder;
    map_setup_t setup;
} options_t;

/* What each claim of theory reads like. */
static const char *const claims[MAP_CLAIMS] = {
    [MAP_CLAIM_INDUCTANCE] = "L wrong: mean = nominal - atan(dL i_q/psi_f), dL = believed - true",
    [MAP_CLAIM_NO_EFFECT] = "psi_f, R wrong: mean = nominal",
};

/* ---- the command line ---- */

static int ascending(const void *a, const void *b)
{
    const double x = *(const double *)a;
    const double y = *(const double *)b;
    return (x > y) - (x < y);
}

static void read_speeds(struct argp_state *state, const char *text, map_setup_t *setup)
{
    const char *rest = text;
    setup->speed_count = 0;
    for (;;) {
        char *end = NULL;
        const double rpm = strtod(rest, &end);
        if (end == rest || (*end != ',' && *end != '\0') || !(rpm >= MAP_RPM_MIN && rpm <= MAP_RPM_MAX)) {
            argp_error(state, "--speeds %s: accepted numbers %g to %g, in r/min, separated by commas", text,
                       MAP_RPM_MIN, MAP_RPM_MAX);
        }
        if (setup->speed_count == MAP_SPEEDS_MAX) {
            argp_error(state, "--speeds %s: at most %u of them", text, MAP_SPEEDS_MAX);
        }
        setup->speeds[setup->speed_count++] = rpm;
        if (*end == '\0') {
            break;
        }
        rest = end + 1;
    }
    qsort(setup->speeds, setup->speed_count, sizeof setup->speeds[0], ascending);
    for (size_t n = 1; n < setup->speed_count; n++) {
        if (setup->speeds[n] == setup->speeds[n - 1u]) {
            argp_error(state, "--speeds %s: %g is there twice", text, setup->speeds[n]);
        }
    }
}

static error_t parse(int key, char *argument, struct argp_state *state)
{
    options_t *options = state->input;
    switch (key) {
    case 'n':
        read_speeds(state, argument, &options->setup);
        return 0;
    case 'i':
        options->setup.ideal = true;
        return 0;
    case 'a':
        options->setup.averaged = true;
        return 0;
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

/* ---- the points as JSON ---- */

static void print_key(FILE *file, const char *key, double value)
{
    fprintf(file, ", \"%s\": ", key);
    json_number(file, value);
}

/* All: with what the picture needs besides. */
static void print_points(FILE *file, const map_point_t *points, size_t count, bool all)
{
    for (size_t n = 0; n < count; n++) {
        const map_point_t *point = &points[n];
        fprintf(file, "%s{\"rpm\": ", n == 0 ? "[" : ",\n ");
        json_number(file, point->rpm);
        print_key(file, "load_nm", point->load);
        fprintf(file, ", \"deviation\": ");
        json_text(file, map_deviation_name(point->deviation));
        print_key(file, "mean_mrad", point->mean_mrad);
        print_key(file, "sd_mrad", point->sd_mrad);
        print_key(file, "peak_mrad", point->peak_mrad);
        fprintf(file, ", \"locked\": %s", point->locked ? "true" : "false");
        if (all) {
            print_key(file, "theory_mrad", point->theory_mrad);
        }
        fprintf(file, "}");
    }
    fprintf(file, "]\n");
}

/* ---- the points as a table ---- */

/* Three digits that count, more if there are more before the point; blank if there is no number. */
static void print_mrad(int places, double mrad)
{
    const double size = fabs(mrad);
    if (isnan(mrad)) {
        printf(" %*s", places, "");
    } else {
        printf(" %*.*f", places, size < 9.995 ? 2 : size < 999.95 ? 1 : 0, size < 0.005 ? 0.0 : mrad);
    }
}

static const char *conditions(const map_setup_t *setup, char to[CONDITIONS_SIZE])
{
    snprintf(to, CONDITIONS_SIZE, "%s; %s",
             setup->ideal
                 ? "ideal inverter and sensors"
                 : "2.5 us dead time, compensated; 12-bit ADC, noise 10 mA, offset 30 mA, gain error 0.2 %",
             setup->averaged ? "mean voltages" : "every gate edge");
    return to;
}

/* Points of one row: same deviation, load and direction, by speed from low to high. */
static const map_point_t *point_of(const map_setup_t *setup, const map_point_t *row, bool forward,
                                   size_t speed)
{
    return forward ? &row[setup->speed_count + speed] : &row[setup->speed_count - 1u - speed];
}

static void print_row(const map_setup_t *setup, const map_point_t *row, bool forward)
{
    bool theory = false;
    printf("%-17s", map_deviation_name(row->deviation));
    for (size_t s = 0; s < setup->speed_count; s++) {
        const map_point_t *point = point_of(setup, row, forward, s);
        print_mrad(6, point->mean_mrad);
        print_mrad(5, point->sd_mrad);
        print_mrad(5, point->peak_mrad);
        printf("%s", point->locked ? " " : "!");
        theory = theory || !isnan(point->theory_mrad);
    }
    printf("\n");
    if (theory) {
        printf("%-17s", "  theory");
        for (size_t s = 0; s < setup->speed_count; s++) {
            print_mrad(6, point_of(setup, row, forward, s)->theory_mrad);
            printf("%13s", "");
        }
        printf("\n");
    }
}

static void print_table(const map_setup_t *setup, const map_point_t *points, size_t count)
{
    char text[CONDITIONS_SIZE];
    const size_t per_row = 2u * setup->speed_count;
    printf("theta_hat - theta, electrical, in mrad: mean, standard deviation, peak; ! = not locked\n%s\n",
           conditions(setup, text));
    for (size_t half = 0; half < 2u * setup->load_count; half++) {
        const bool forward = half % 2u == 0u;
        const double load = setup->loads[half / 2u];
        printf("\n%-8s %3g N m", forward ? "forward" : "reverse", load);
        for (size_t s = 0; s < setup->speed_count; s++) {
            printf(" %12g r/min ", (forward ? 1.0 : -1.0) * setup->speeds[s]);
        }
        printf("\n");
        for (size_t n = 0; n < count; n += per_row) {
            if (points[n].load == load) {
                print_row(setup, &points[n], forward);
            }
        }
    }
    printf("\n");
}

/* ---- judgement ---- */

static void print_verdict(FILE *file, const char *claim, const map_verdict_t *verdict)
{
    fprintf(file, "%-7s %s, within %g mrad: ", verdict->met ? "met" : "FAILED", claim, verdict->limit_mrad);
    if (verdict->worst != NULL) {
        const map_point_t *worst = verdict->worst;
        fprintf(file, "at most %.2f mrad (%s, %g r/min, %g N m), %zu points", verdict->worst_mrad,
                map_deviation_name(worst->deviation), worst->rpm, worst->load, verdict->judged);
    }
    if (verdict->lost > 0u) {
        fprintf(file, "%s%zu not locked", verdict->worst != NULL ? ", " : "", verdict->lost);
    }
    fprintf(file, "\n");
}

/* On stdout below the table; beside JSON only what failed, as a message. */
static bool judge(const options_t *options, const map_point_t *points, size_t count)
{
    bool met = true;
    for (map_claim_t claim = 0; claim < MAP_CLAIMS; claim++) {
        const map_verdict_t verdict = map_judge(points, count, claim);
        if (!options->json || !verdict.met) {
            print_verdict(options->json ? stderr : stdout, claims[claim], &verdict);
        }
        met = met && verdict.met;
    }
    return met;
}

/* ---- all of it ---- */

static int show(const options_t *options, const map_point_t *points, size_t count)
{
    if (options->json) {
        print_points(stdout, points, count, false);
    } else {
        print_table(&options->setup, points, count);
    }
    return judge(options, points, count) ? EXIT_DONE : EXIT_FAILED;
}

static bool draw(const options_t *options, const char *data_path, const char *png_path)
{
    char text[CONDITIONS_SIZE];
    char title[CONDITIONS_SIZE + 40];
    snprintf(title, sizeof title, "Error of the estimated angle. %s", conditions(&options->setup, text));
    if (!output_picture("plot/map.py", data_path, png_path, title)) {
        return false;
    }
    fprintf(stderr, "\npicture: %s\ndata:    %s\n", png_path, data_path);
    return true;
}

int command_map(int argc, char **argv)
{
    static const struct argp_option rows[] = {
        {"speeds", 'n', "LIST", 0, "r/min, separated by commas, each in both directions", 0},
        {"ideal", 'i', NULL, 0, "ideal inverter and sensors; deviations of the machine only", 0},
        {"averaged", 'a', NULL, 0, "mean voltages instead of every gate edge", 0},
        {"json", 'j', NULL, 0, "one JSON list of points on stdout", 0},
        {"out", 'o', "FOLDER", 0, "write map.json and the picture map.png there", 0},
        {0},
    };
    static const struct argp argp = {rows,
                                     parse,
                                     NULL,
                                     "Error of the sensorless angle over speed, load, direction and what the "
                                     "drive believes wrongly; judged "
                                     "against theory.",
                                     NULL,
                                     NULL,
                                     NULL};
    options_t options = {.setup = map_setup_default()};
    char data_path[PATH_SIZE];
    char png_path[PATH_SIZE];
    FILE *data = NULL;
    map_error_t why;
    if (argp_parse(&argp, argc, argv, 0, NULL, &options) != 0) {
        return EXIT_USAGE;
    }
    if (options.folder != NULL) {
        if (!output_folder(options.folder) || !output_path(data_path, options.folder, "map.json") ||
            !output_path(png_path, options.folder, "map.png")) {
            return EXIT_USAGE;
        }
        data = output_open(data_path);
        if (data == NULL) {
            return EXIT_USAGE;
        }
    }

    const double started = output_seconds();
    const long cores = sysconf(_SC_NPROCESSORS_ONLN);
    const size_t count = map_count(&options.setup);
    map_point_t *points = calloc(count, sizeof *points);
    bool done = points != NULL;
    if (done && !map_run(&options.setup, points, cores > 0 ? (unsigned)cores : 1u, &why)) {
        fprintf(stderr, "lagless map: %s\n", why.text);
        done = false;
    }
    if (data != NULL) {
        if (done) {
            print_points(data, points, count, true);
        }
        done = output_close(data, data_path) && done;
    }
    int exit_code = EXIT_INTERNAL;
    if (done) {
        exit_code = show(&options, points, count);
        fflush(stdout);
        fprintf(stderr, "%zu points in %.1f s\n", count, output_seconds() - started);
        if (data != NULL && !draw(&options, data_path, png_path)) {
            exit_code = EXIT_INTERNAL;
        }
    }
    free(points);
    return exit_code;
}
