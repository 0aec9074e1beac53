/* `lagless map`: error of the estimated angle with wrong assumed values, compared with the theory. */
#include <argp.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "host_sim/cli/arguments.h"
#include "host_sim/cli/cli.h"
#include "host_sim/cli/library.h"
#include "host_sim/cli/output.h"
#include "host_sim/lab/json.h"
#include "host_sim/lab/map.h"

#define CONDITIONS_SIZE 240
#define THEORY_SHOWN    0.5 /* [mrad] a smaller deviation from theory is not printed */

typedef struct {
    arguments_output_t output;
    const char *scenario; /* NULL: none */
    bool has_speeds;
    map_setup_t setup;
} options_t;

/* Text of each claim of the theory. */
static const char *const claims[MAP_CLAIMS] = {
    [MAP_CLAIM_INDUCTANCE] = "L wrong: mean = nominal - asin(dL i_q/psi_f), dL = configured - true",
    [MAP_CLAIM_NO_EFFECT] =
        "psi_f, R wrong, adaptation off: mean = nominal + asin(dR i_d/(omega psi_f)) +- a fifth",
    [MAP_CLAIM_LEARNT] = "L wrong, adaptation on and inductance_confidence high: mean = nominal",
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
        if (end == rest || (*end != ',' && *end != '\0') || !(rpm >= MAP_RPM_MIN && rpm < (double)INFINITY)) {
            argp_error(state, "--speeds %s: accepted: numbers %g to %g, in r/min, separated by commas", text,
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
            argp_error(state, "--speeds %s: %g is given twice; accepted: once", text, setup->speeds[n]);
        }
    }
}

static void read_columns(struct argp_state *state, const char *text, map_setup_t *setup)
{
    const bool both = strcmp(text, "both") == 0;
    bool any = false;
    for (map_adaptation_t a = MAP_ADAPTATION_OFF; a < MAP_ADAPTATIONS; a++) {
        setup->columns[a] = both || strcmp(text, map_adaptation_name(a)) == 0;
        any = any || setup->columns[a];
    }
    if (!any) {
        argp_error(state, "--adaptation %s: accepted: off, on, both", text);
    }
}

/* Checks that need the whole command line. */
static void check_line(struct argp_state *state, const options_t *options)
{
    const double fastest = options->setup.speeds[options->setup.speed_count - 1u];
    if (options->scenario == NULL && fastest > MAP_RPM_MAX) {
        argp_error(state, "--speeds: %g: accepted: numbers %g to %g, in r/min", fastest, MAP_RPM_MIN,
                   MAP_RPM_MAX);
    }
    if (options->scenario != NULL && options->setup.ideal) {
        argp_error(state,
                   "--ideal cannot be used with a scenario, which defines its inverter and sensors itself");
    }
}

static error_t parse(int key, char *argument, struct argp_state *state)
{
    options_t *options = state->input;
    switch (key) {
    case 'n':
        read_speeds(state, argument, &options->setup);
        options->has_speeds = true;
        return 0;
    case 'd':
        read_columns(state, argument, &options->setup);
        return 0;
    case 'i':
        options->setup.ideal = true;
        return 0;
    case 'a':
        options->setup.averaged = true;
        return 0;
    case ARGP_KEY_ARG:
        if (options->scenario != NULL) {
            argp_error(state, "%s: a second scenario; accepted: one", argument);
        }
        options->scenario = argument;
        return 0;
    case ARGP_KEY_END:
        check_line(state, options);
        return 0;
    default:
        return arguments_output(key, argument, &options->output);
    }
}

/* ---- the points as JSON ---- */

static void print_key(FILE *file, const char *key, double value)
{
    fprintf(file, ", \"%s\": ", key);
    json_number(file, value);
}

/* `all`: also the members that only the picture needs. */
static void print_points(FILE *file, const map_point_t *points, size_t count, bool all)
{
    for (size_t n = 0; n < count; n++) {
        const map_point_t *point = &points[n];
        fprintf(file, "%s{\"rpm\": ", n == 0 ? "[" : ",\n ");
        json_number(file, point->rpm);
        print_key(file, "load_nm", point->load);
        fprintf(file, ", \"deviation\": ");
        json_text(file, map_deviation_name(point->deviation));
        fprintf(file, ", \"adaptation\": \"%s\"", map_adaptation_name(point->adaptation));
        print_key(file, "mean_mrad", point->mean_mrad);
        print_key(file, "sd_mrad", point->sd_mrad);
        print_key(file, "peak_mrad", point->peak_mrad);
        fprintf(file, ", \"locked\": %s", point->locked ? "true" : "false");
        if (all) {
            print_key(file, "theory_mrad", point->theory_mrad);
            print_key(file, "inductance_h", point->inductance);
            print_key(file, "confidence", point->confidence);
        }
        fprintf(file, "}");
    }
    fprintf(file, "]\n");
}

/* ---- the points as a table ---- */

/* Three significant digits, more if there are more before the point; blank if there is no number. */
static void print_mrad(int places, double mrad)
{
    const double size = fabs(mrad);
    if (isnan(mrad)) {
        printf(" %*s", places, "");
    } else {
        printf(" %*.*f", places, size < 9.995 ? 2 : size < 999.95 ? 1 : 0, size < 0.005 ? 0.0 : mrad);
    }
}

static const char *conditions(const options_t *options, char to[CONDITIONS_SIZE])
{
    const map_setup_t *setup = &options->setup;
    if (setup->scenario != NULL) {
        snprintf(to, CONDITIONS_SIZE, "%.180s%s", setup->scenario->title,
                 setup->averaged ? "; mean voltages" : "");
    } else {
        snprintf(
            to, CONDITIONS_SIZE, "%s; %s",
            setup->ideal
                ? "ideal inverter and sensors"
                : "2.5 us dead time, compensated; 12-bit ADC, noise 10 mA, offset 30 mA, gain error 0.2 %",
            setup->averaged ? "mean voltages" : "every gate edge");
    }
    return to;
}

/* A line of the table: a deviation at one speed and load, adaptation off and on, in both directions. */
typedef struct {
    const map_point_t *points[2 * MAP_ADAPTATIONS];
    size_t count;
} line_t;

static line_t line_of(const map_setup_t *setup, const map_point_t *points, size_t count,
                      map_deviation_t deviation, double rpm, double load)
{
    line_t line = {.count = 0};
    for (int direction = 1; direction >= -1; direction -= 2) {
        for (map_adaptation_t a = MAP_ADAPTATION_OFF; a < MAP_ADAPTATIONS; a++) {
            if (setup->columns[a]) {
                line.points[line.count++] = map_find(points, count, deviation, direction * rpm, load, a);
            }
        }
    }
    return line;
}

static void print_line(const line_t *line)
{
    bool theory = false;
    printf("%-17s", map_deviation_name(line->points[0]->deviation));
    for (size_t n = 0; n < line->count; n++) {
        const map_point_t *point = line->points[n];
        print_mrad(6, point->mean_mrad);
        print_mrad(5, point->sd_mrad);
        print_mrad(5, point->peak_mrad);
        printf("%s", point->locked ? " " : "!");
        theory = theory || fabs(point->theory_mrad) >= THEORY_SHOWN;
    }
    printf("\n");
    if (theory) {
        printf("%-17s", "  theory");
        for (size_t n = 0; n < line->count; n++) {
            print_mrad(6, line->points[n]->theory_mrad);
            printf("%13s", "");
        }
        printf("\n");
    }
}

static void print_block(const map_setup_t *setup, const map_point_t *points, size_t count, double rpm,
                        double load)
{
    char place[40];
    bool first = true;
    snprintf(place, sizeof place, "%.4g r/min, %.4g N m", rpm, load);
    printf("\n%-17s", place);
    for (map_deviation_t d = MAP_NOMINAL; d < MAP_DEVIATIONS; d++) {
        if (map_find(points, count, d, rpm, load,
                     setup->columns[MAP_ADAPTATION_OFF] ? MAP_ADAPTATION_OFF : MAP_ADAPTATION_ON) == NULL) {
            continue;
        }
        const line_t line = line_of(setup, points, count, d, rpm, load);
        for (size_t n = 0; n < line.count && first; n++) {
            char what[40];
            snprintf(what, sizeof what, "%s, %s", line.points[n]->rpm > 0.0 ? "forward" : "reverse",
                     map_adaptation_name(line.points[n]->adaptation));
            printf(" %18s ", what);
        }
        printf("%s", first ? "\n" : "");
        first = false;
        print_line(&line);
    }
}

static void print_table(const options_t *options, const map_point_t *points, size_t count)
{
    const map_setup_t *setup = &options->setup;
    char text[CONDITIONS_SIZE];
    printf("theta_hat - theta, electrical, in mrad: mean, standard deviation, peak; ! = not locked\n%s\n"
           "off, on: without and with adaptation of the motor data\n",
           conditions(options, text));
    for (size_t l = 0; l < setup->load_count; l++) {
        for (size_t s = 0; s < setup->speed_count; s++) {
            print_block(setup, points, count, setup->speeds[s], setup->loads[l]);
        }
    }
    printf("\n");
}

/* ---- judgement ---- */

static const char *word(const map_verdict_t *verdict)
{
    return verdict->met ? "met" : verdict->silent ? "-" : "FAILED";
}

static void print_verdict(FILE *file, const char *claim, const map_verdict_t *verdict)
{
    fprintf(file, "%-7s %s, within %g mrad: ", word(verdict), claim, verdict->limit_mrad);
    if (verdict->worst != NULL) {
        const map_point_t *worst = verdict->worst;
        fprintf(file, "at most %.2f mrad (%s, %g r/min, %g N m, adaptation %s), %zu points",
                verdict->worst_mrad, map_deviation_name(worst->deviation), worst->rpm, worst->load,
                map_adaptation_name(worst->adaptation), verdict->judged);
    }
    if (verdict->lost > 0u) {
        fprintf(file, "%s%zu not locked", verdict->worst != NULL ? ", " : "", verdict->lost);
    }
    fprintf(file, "%s\n", verdict->silent ? "no such point" : "");
}

static const char *place_of(const map_point_t *point, char to[100])
{
    snprintf(to, 100, "%s, %.4g r/min, %.4g N m, adaptation %s", map_deviation_name(point->deviation),
             point->rpm, point->load, map_adaptation_name(point->adaptation));
    return to;
}

static void print_promise(FILE *file, bool json, bool kept, const char *text)
{
    if (!json || !kept) {
        fprintf(json ? stderr : file, "%-7s %s\n", kept ? "met" : "FAILED", text);
    }
}

/* For the user's own motor: the promises of the drive, and its numbers. */
static bool judge_own(const options_t *options, const map_point_t *points, size_t count)
{
    const map_own_t own = map_judge_own(points, count);
    const bool json = options->output.json;
    char place[100];
    char other[100];
    char text[400];
    if (!json && own.largest != NULL) {
        printf("largest error %.3g mrad (%s)\n", fabs(own.largest->mean_mrad), place_of(own.largest, place));
    }
    if (own.lost != NULL) {
        snprintf(text, sizeof text,
                 "the rotor is not lost at any point: %zu of %zu are lost, the first is %s", own.lost_count,
                 count, place_of(own.lost, place));
    } else {
        snprintf(text, sizeof text, "the rotor is not lost at any point: none of %zu is lost", count);
    }
    print_promise(stdout, json, own.held, text);
    if (own.nominal != NULL) {
        snprintf(text, sizeof text,
                 "with right data the angle is within %g mrad, SD within %g mrad: %.3g mrad (%s), SD %.3g "
                 "mrad (%s)",
                 own.limit_mrad, MAP_OWN_SD, fabs(own.nominal->mean_mrad), place_of(own.nominal, place),
                 own.restless->sd_mrad, place_of(own.restless, other));
    } else {
        snprintf(text, sizeof text, "with right data the angle is within %g mrad: every such point is lost",
                 own.limit_mrad);
    }
    print_promise(stdout, json, own.accurate, text);
    return own.held && own.accurate;
}

/* On stdout below the table. With JSON only failed verdicts are printed, as messages. */
static bool judge(const options_t *options, const map_point_t *points, size_t count)
{
    bool good = true;
    if (options->setup.scenario != NULL) {
        return judge_own(options, points, count);
    }
    for (map_claim_t claim = 0; claim < MAP_CLAIMS; claim++) {
        const map_verdict_t verdict = map_judge(points, count, claim);
        const bool failed = !verdict.met && !verdict.silent;
        if (!options->output.json || failed) {
            print_verdict(options->output.json ? stderr : stdout, claims[claim], &verdict);
        }
        good = good && !failed;
    }
    return good;
}

/* ---- the whole command ---- */

static int show(const options_t *options, const map_point_t *points, size_t count)
{
    if (options->output.json) {
        print_points(stdout, points, count, false);
    } else {
        print_table(options, points, count);
    }
    return judge(options, points, count) ? EXIT_DONE : EXIT_FAILED;
}

static bool draw(const options_t *options, const char *data_path, const char *png_path)
{
    char text[CONDITIONS_SIZE];
    char title[CONDITIONS_SIZE + 40];
    snprintf(title, sizeof title, "Error of the estimated angle. %s", conditions(options, text));
    if (!output_picture("plot/map.py", data_path, png_path, title)) {
        return false;
    }
    fprintf(stderr, "\npicture: %s\ndata:    %s\n", png_path, data_path);
    return true;
}

/* Runs the map and prints it; data: of map.json, NULL without a folder. */
static int run(const options_t *options, FILE *data, const char *data_path)
{
    const map_setup_t *setup = &options->setup;
    const double started = output_seconds();
    const long cores = sysconf(_SC_NPROCESSORS_ONLN);
    const size_t count = map_count(setup);
    map_point_t *points = calloc(count, sizeof *points);
    map_error_t why;
    int exit_code = EXIT_INTERNAL;
    output_progress_t progress = output_progress_begin();
    map_setup_t shown = *setup;
    shown.progress = output_progress;
    shown.progress_context = &progress;
    const bool ran = points != NULL && map_run(&shown, points, cores > 0 ? (unsigned)cores : 1u, &why);
    output_progress_end(&progress);
    if (points != NULL && !ran) {
        fprintf(stderr, "lagless map: %s%s%s\n", setup->scenario != NULL ? setup->scenario->path : "",
                setup->scenario != NULL ? ": " : "", why.text);
        exit_code = setup->scenario != NULL ? EXIT_USAGE : EXIT_INTERNAL;
    } else if (points != NULL) {
        if (data != NULL) {
            print_points(data, points, count, true);
        }
        exit_code = show(options, points, count);
        fflush(stdout);
        fprintf(stderr, "%zu points in %.1f s\n", count, output_seconds() - started);
    }
    free(points);
    if (exit_code > EXIT_FAILED) {
        output_abandon(data, data_path);
        return exit_code;
    }
    return data == NULL || output_close(data, data_path) ? exit_code : EXIT_INTERNAL;
}

static int run_into(const options_t *options)
{
    char data_path[PATH_SIZE];
    char png_path[PATH_SIZE];
    if (options->output.folder == NULL) {
        return run(options, NULL, NULL);
    }
    if (!output_claim(options->output.folder) || !output_path(png_path, options->output.folder, "map.png")) {
        return EXIT_INTERNAL;
    }
    if (!output_allowed_in(options->output.folder, "map", ".json") || !output_allowed(png_path)) {
        return EXIT_USAGE;
    }
    FILE *data = output_open_in(data_path, options->output.folder, "map.json");
    if (data == NULL) {
        return EXIT_INTERNAL;
    }
    const int exit_code = run(options, data, data_path);
    const bool drawn = exit_code > EXIT_FAILED || draw(options, data_path, png_path);
    return drawn ? exit_code : EXIT_INTERNAL;
}

/* Reads the entries of the scenario; false: the reason has been printed. */
static bool take_scenario(options_t *options, const scenario_t *scenario)
{
    scenario_error_t error;
    options->setup.speed_count = options->has_speeds ? options->setup.speed_count : 0u;
    if (!map_of_scenario(&options->setup, scenario, &error)) {
        library_say("map", &error);
        return false;
    }
    return true;
}

int command_map(int argc, char **argv)
{
    static const struct argp_option rows[] = {
        {"speeds", 'n', "LIST", 0, "r/min, separated by commas, each in both directions", 0},
        {"adaptation", 'd', "WHICH", 0, "off, on, both (default): without or with the drive's adaptation", 0},
        {"ideal", 'i', NULL, 0, "ideal inverter and sensors; only values of the machine are wrong", 0},
        {"averaged", 'a', NULL, 0, "mean voltages instead of every gate edge", 0},
        ARGUMENTS_BOARD,
        ARGUMENTS_OUTPUT("one JSON list of points on stdout", "write map.json and the picture map.png there"),
        {0},
    };
    static const char doc[] =
        "Measures the error of the sensorless angle over speed, load, direction and wrong parameters of the "
        "drive, without and with adaptation. The errors are compared with theory. With a SCENARIO the map "
        "fails instead if the drive loses the rotor at a point, or if with right data the mean error exceeds "
        "30 mrad or its SD 50 mrad.\vA SCENARIO (a TOML file, or a name of `lagless scenarios`) gives the "
        "motor, inverter, sensors and parameters at t = 0, and the speeds (speed_request) and loads "
        "(plant.load_torque), also those of its events; --speeds replaces the speeds. Without a SCENARIO the "
        "map is that of the paper's motor and drive.";
    static const struct argp argp = {rows, parse, "[SCENARIO]", doc, NULL, NULL, NULL};
    options_t options = {.setup = map_setup_default()};
    if (!arguments_parse(&argp, argc, argv, &options)) {
        return EXIT_USAGE;
    }
    if (options.scenario == NULL) {
        return run_into(&options);
    }
    const arguments_scenario_t of = {.scenario = options.scenario};
    scenario_t *scenario = library_read("map", &of);
    if (scenario == NULL) {
        return EXIT_USAGE;
    }
    const int exit_code = take_scenario(&options, scenario) ? run_into(&options) : EXIT_USAGE;
    scenario_free(scenario);
    return exit_code;
}
