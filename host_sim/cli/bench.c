/* `lagless bench`: the speed of the whole simulation relative to real time, and the time and the instructions
 * of the interrupt and of one step of the estimator on this machine.
 *
 * Instructions are counted by callgrind, on this very program: it runs itself under valgrind with the hidden
 * option --replay, once with the estimator and once with an empty function in its place, and takes the
 * difference. The same build gives the same number every time. */
#include <argp.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include "host_sim/cli/arguments.h"
#include "host_sim/cli/cli.h"
#include "host_sim/cli/library.h"
#include "host_sim/cli/output.h"
#include "host_sim/lab/course.h"
#include "host_sim/lab/json.h"
#include "host_sim/lab/paper_drive.h"
#include "host_sim/lab/units.h"
#include "host_sim/rig/rig.h"

#define RUNS          5
#define SPEED_RPM     1000.0
#define LOAD_NM       5.0
#define WORST_RPM     165.0 /* 69 rad/s electrical: slow enough for the signed EMF, fast enough to adapt */
#define SETTLE        0.5   /* [s] */
#define RPM           (2.0 * 3.14159265358979 / 60.0) /* [rad/s] */
#define NOT_INSTALLED 127

typedef struct {
    bool json;
    double seconds;
    const char *replay;   /* "estimator" or "empty", in the process that valgrind watches; else NULL */
    const char *scenario; /* NULL: the conditions above */
} options_t;

static error_t parse(int key, char *argument, struct argp_state *state)
{
    options_t *options = state->input;
    char *end = NULL;
    switch (key) {
    case 'j':
        options->json = true;
        return 0;
    case 's':
        options->seconds = strtod(argument, &end);
        if (end == argument || *end != '\0' || !(options->seconds >= 0.01 && options->seconds <= 1000.0)) {
            argp_error(state, "--seconds %s: accepted: 0.01 to 1000, in simulated seconds", argument);
        }
        return 0;
    case 'r':
        options->replay = argument;
        return 0;
    case ARGP_KEY_ARG:
        if (options->scenario != NULL) {
            argp_error(state, "%s: a second scenario; accepted: one", argument);
        }
        options->scenario = argument;
        return 0;
    default:
        return ARGP_ERR_UNKNOWN;
    }
}

static int ascending(const void *a, const void *b)
{
    const double x = *(const double *)a;
    const double y = *(const double *)b;
    return (x > y) - (x < y);
}

static double median(double values[RUNS])
{
    qsort(values, RUNS, sizeof values[0], ascending);
    return values[RUNS / 2];
}

typedef enum { ENCODER, SENSORLESS } source_t;

static rig_t *running_rig(bool averaged, source_t source, double rpm)
{
    rig_t *rig = rig_create(1);
    if (rig == NULL) {
        return NULL;
    }
    rig_put(rig, "fidelity", averaged ? 1.0 : 0.0);
    paper_drive_put(rig, paper_drive, paper_drive_count);
    rig_apply(rig);
    rig_set_motion(rig, 0.0, rpm * RPM);
    rig_put(rig, "speed_request", rpm * RPM);
    rig_put(rig, "enable", 1.0);
    rig_run(rig, rig_periods(SETTLE));
    if (source == SENSORLESS) {
        paper_drive_without_encoder(rig);
    }
    rig_put(rig, "load_torque", LOAD_NM);
    rig_run(rig, rig_periods(SETTLE));
    return rig;
}

/* At the end of the scenario, where its drive has to be on; NULL: the reason has been printed. */
static rig_t *rig_after(const scenario_t *scenario, bool averaged)
{
    course_t course = {0};
    scenario_error_t error = {.message = "no memory"};
    rig_t *rig = rig_create(scenario->seed);
    bool good = rig != NULL && course_init(&course, scenario, rig) && course_start(&course, &error) &&
                rig_put(rig, "fidelity", averaged ? 1.0 : 0.0);
    good = good && course_run(&course, 0u, scenario->periods, &error) != COURSE_NEVER;
    course_free(&course);
    const table_row_t *state = rig_row_by_name("state");
    if (good && (int32_t)rig_value(rig, "state") != table_choice(state, "operation_enabled")) {
        char name[UNITS_TEXT_SIZE];
        snprintf(error.message, sizeof error.message,
                 "the drive is not on at the end of the scenario, its state is %s; accepted: a scenario "
                 "whose drive runs at its end",
                 units_row_text(name, rig_value(rig, "state"), state));
        good = false;
    }
    if (!good) {
        fprintf(stderr, "lagless bench: %s: %s\n", scenario->path, error.message);
        rig_free(rig);
        rig = NULL;
    }
    return rig;
}

/* The measurement runs the scenario, or the conditions of `bench` itself. */
static rig_t *rig_of(const scenario_t *scenario, bool averaged, source_t source)
{
    return scenario != NULL ? rig_after(scenario, averaged) : running_rig(averaged, source, SPEED_RPM);
}

static double times_realtime(const scenario_t *scenario, bool averaged, double seconds)
{
    double values[RUNS];
    rig_t *rig = rig_of(scenario, averaged, ENCODER);
    if (rig == NULL) {
        return 0.0;
    }
    for (int n = 0; n < RUNS; n++) {
        const double start = output_seconds();
        rig_run(rig, rig_periods(seconds));
        values[n] = rig_periods(seconds) * RIG_PERIOD_SECONDS / (output_seconds() - start);
    }
    rig_free(rig);
    return median(values);
}

static double interrupt_ns(const scenario_t *scenario)
{
    double values[RUNS];
    rig_t *rig = rig_of(scenario, true, ENCODER);
    if (rig == NULL) {
        return 0.0;
    }
    for (int n = 0; n < RUNS; n++) {
        values[n] = 1e9 * rig_interrupt_seconds(rig, 50000u);
    }
    rig_free(rig);
    return median(values);
}

/* ---- one step of the estimator ---- */

/* The estimator of a running sensorless drive, and its inputs; NULL: the reason has been printed. `worst`:
 * every optional part is switched on, and a criterion of validity fails in every period, each time for too
 * short a time for the drive to report a fault. */
static void *estimator_record(const scenario_t *scenario, bool worst)
{
    static const struct {
        const char *name;
        double value;
    } settings[] = {
        {"flux_adaptation", 2.0},       /* on */
        {"torque_feedforward", 1.0},    /* on */
        {"estimate_current_max", 1e-3}, /* [A] less than the current of any step */
        {"estimate_time", 10.0},        /* [s] */
        {"doubtful_current",
         0.0}, /* [A] so that every period has a step of the estimator and none is coasted */
    };
    rig_t *rig = worst ? running_rig(true, SENSORLESS, WORST_RPM) : rig_of(scenario, true, SENSORLESS);
    void *record = malloc(rig_estimator_size());
    bool good = rig != NULL && record != NULL;
    for (size_t n = 0; good && worst && n < sizeof settings / sizeof settings[0]; n++) {
        good = rig_put(rig, settings[n].name, settings[n].value);
    }
    if (good && rig_apply(rig)) {
        rig_estimator_record(rig, record);
        good = rig_value(rig, "fault_reason") == 0.0;
    }
    if (!good) {
        fprintf(stderr, "lagless bench: the sensorless drive does not run: %s\n",
                rig != NULL ? rig_error(rig) : "no memory");
        free(record);
        record = NULL;
    }
    rig_free(rig);
    return record;
}

static double estimator_ns(const void *record)
{
    double values[RUNS];
    for (int n = 0; n < RUNS; n++) {
        values[n] = 1e9 * rig_estimator_seconds(record);
    }
    return median(values);
}

/* Runs in the process that valgrind measures, with the record on standard input. */
static int replay(const char *what)
{
    const size_t size = rig_estimator_size();
    const bool empty = strcmp(what, "empty") == 0;
    void *record = malloc(size);
    const bool good = record != NULL && fread(record, 1, size, stdin) == size;
    if (good) {
        (void)rig_estimator_replay(record, empty);
    } else {
        fprintf(stderr, "lagless bench: --replay: no record on standard input; this option is only for the "
                        "program itself\n");
    }
    free(record);
    return good ? EXIT_DONE : EXIT_USAGE;
}

static void become_valgrind(const char *what, int input, int messages)
{
    char program[PATH_SIZE];
    const ssize_t length = readlink("/proc/self/exe", program, sizeof program - 1u);
    if (length < 0 || dup2(input, STDIN_FILENO) < 0 || dup2(messages, STDERR_FILENO) < 0) {
        _exit(EXIT_INTERNAL);
    }
    program[length] = '\0';
    execlp("valgrind", "valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null",
           "--toggle-collect=rig_estimator_replay*", program, "bench", "--replay", what, (char *)NULL);
    _exit(NOT_INSTALLED);
}

/* The number of instructions that callgrind reports; NAN: no number was found. */
static double collected(int messages)
{
    char line[512];
    double count = (double)NAN;
    FILE *file = fdopen(messages, "r");
    if (file == NULL) {
        close(messages);
        return (double)NAN;
    }
    while (fgets(line, sizeof line, file) != NULL) {
        (void)sscanf(line, "==%*d== Collected : %lf", &count);
    }
    fclose(file);
    return count;
}

/* Instructions of a replay; NAN: `why` has what is missing. */
static double instructions_of(const char *what, FILE *record, const char **why)
{
    int messages[2];
    int status = -1;
    rewind(record);
    fflush(NULL);
    if (pipe(messages) != 0) {
        *why = "no pipe could be had";
        return (double)NAN;
    }
    const pid_t child = fork();
    if (child == 0) {
        close(messages[0]);
        become_valgrind(what, fileno(record), messages[1]);
    }
    close(messages[1]);
    const double count = collected(messages[0]);
    const bool ended = child > 0 && waitpid(child, &status, 0) == child && WIFEXITED(status);
    if (ended && WEXITSTATUS(status) == NOT_INSTALLED) {
        *why = "valgrind is not installed";
    } else if (!ended || WEXITSTATUS(status) != 0 || !(count > 0.0)) {
        *why = "this build does not run under valgrind";
    } else {
        return count;
    }
    return (double)NAN;
}

/* Time and instructions of one step, mean over the record; NAN: `why` has the reason. */
static double estimator_instructions(const void *record, const char **why)
{
    FILE *file = tmpfile();
    double count = (double)NAN;
    if (file == NULL || fwrite(record, 1, rig_estimator_size(), file) != rig_estimator_size()) {
        *why = "no temporary file could be written";
    } else {
        count = instructions_of("estimator", file, why);
        count -= isnan(count) ? 0.0 : instructions_of("empty", file, why);
    }
    if (file != NULL) {
        fclose(file);
    }
    return count / RIG_ESTIMATOR_STEPS;
}

/* ---- the whole command ---- */

typedef struct {
    double ns;           /* [ns] a step */
    double instructions; /* [-] a step; NAN: not counted */
} step_cost_t;

static bool measure(const scenario_t *scenario, bool worst, step_cost_t *cost, const char **why)
{
    void *record = estimator_record(scenario, worst);
    if (record == NULL) {
        return false;
    }
    cost->ns = estimator_ns(record);
    cost->instructions = estimator_instructions(record, why);
    free(record);
    return true;
}

static void print_cost(const char *name, const step_cost_t *cost, const char *conditions)
{
    printf("  %-10s %7.0f ns   ", name, cost->ns);
    if (isnan(cost->instructions)) {
        printf("     not counted");
    } else {
        printf("%4.0f instructions", cost->instructions);
    }
    printf("   %s\n", conditions);
}

typedef struct {
    double switched, averaged; /* [-] times real time */
    double interrupt;          /* [ns] */
    step_cost_t typical, worst;
} costs_t;

static void print_json(const options_t *options, const costs_t *costs)
{
    printf("{\"switched_x_realtime\": %.1f, \"averaged_x_realtime\": %.1f, \"isr_ns\": %.1f, "
           "\"estimator_ns\": %.1f",
           costs->switched, costs->averaged, costs->interrupt, costs->typical.ns);
    if (options->scenario == NULL) {
        printf(", \"estimator_ns_worst\": %.1f", costs->worst.ns);
    }
    printf(", \"estimator_instructions\": ");
    json_number(stdout, costs->typical.instructions);
    if (options->scenario == NULL) {
        printf(", \"estimator_instructions_worst\": ");
        json_number(stdout, costs->worst.instructions);
    } else {
        printf(", \"scenario\": ");
        json_text(stdout, options->scenario);
    }
    printf(", \"build\": \"" LAGLESS_BUILD "\"}\n");
}

static void print_table(const options_t *options, const costs_t *costs)
{
    if (options->scenario != NULL) {
        printf("whole simulation, one core, at the end of %s, median of %d runs of %g s\n", options->scenario,
               RUNS, options->seconds);
    } else {
        printf("whole simulation, one core, %g r/min, %g N m, median of %d runs of %g s\n", SPEED_RPM,
               LOAD_NM, RUNS, options->seconds);
    }
    printf("  switched   %7.0f x real time   %6.0f ns a period\n", costs->switched,
           1e9 * RIG_PERIOD_SECONDS / costs->switched);
    printf("  averaged   %7.0f x real time   %6.0f ns a period\n", costs->averaged,
           1e9 * RIG_PERIOD_SECONDS / costs->averaged);
    printf("  interrupt  %7.0f ns\n", costs->interrupt);
    printf("one estimator_step, " LAGLESS_BUILD "\n");
    if (options->scenario != NULL) {
        print_cost("here", &costs->typical, "with the state of the drive at the end of the scenario");
        return;
    }
    print_cost("typical", &costs->typical, "1000 r/min, 5 N m");
    print_cost("worst", &costs->worst,
               "165 r/min, 5 N m: e_q instead of |e|, K, flux adaptation, a criterion that fails");
}

/* scenario: NULL: bench's own conditions, the worst case among them. */
static int bench(const options_t *options, const scenario_t *scenario)
{
    const char *why = NULL;
    costs_t costs = {.switched = times_realtime(scenario, false, options->seconds)};
    if (!(costs.switched > 0.0)) {
        return scenario != NULL ? EXIT_USAGE : EXIT_INTERNAL;
    }
    costs.averaged = times_realtime(scenario, true, options->seconds);
    costs.interrupt = interrupt_ns(scenario);
    if (!(costs.averaged > 0.0) || !measure(scenario, false, &costs.typical, &why) ||
        (scenario == NULL && !measure(NULL, true, &costs.worst, &why))) {
        return EXIT_INTERNAL;
    }
    if (why != NULL) {
        fprintf(stderr, "lagless bench: instructions were not counted: %s\n", why);
    }
    if (options->json) {
        print_json(options, &costs);
    } else {
        print_table(options, &costs);
    }
    return EXIT_DONE;
}

int command_bench(int argc, char **argv)
{
    static const struct argp_option rows[] = {
        {"json", 'j', NULL, 0, "one JSON object on stdout", 0},
        {"seconds", 's', "S", 0, "simulated time of each run (default 2)", 0},
        ARGUMENTS_BOARD,
        {"replay", 'r', "WHAT", OPTION_HIDDEN, NULL, 0},
        {0},
    };
    static const char doc[] = "Measures the speed of the simulation and the cost of the interrupt and of one "
                              "step of the estimator, "
                              "median of 5 runs. Instructions are counted if valgrind is installed.\vWith a "
                              "SCENARIO (a TOML file, or a "
                              "name of `lagless scenarios`) its motor, inverter, sensors and settings are "
                              "simulated from the end of the "
                              "scenario on; the drive must run there. Without one, the paper's drive runs at "
                              "1000 r/min and 5 N m, and "
                              "the worst case of the estimator is measured too.";
    static const struct argp argp = {rows, parse, "[SCENARIO]", doc, NULL, NULL, NULL};
    options_t options = {.seconds = 2.0};
    if (!arguments_parse(&argp, argc, argv, &options)) {
        return EXIT_USAGE;
    }
    if (options.replay != NULL) {
        return replay(options.replay);
    }
    if (options.scenario == NULL) {
        return bench(&options, NULL);
    }
    scenario_t *scenario = library_read("bench", &(arguments_scenario_t){.scenario = options.scenario});
    const int exit_code = scenario != NULL ? bench(&options, scenario) : EXIT_USAGE;
    scenario_free(scenario);
    return exit_code;
}
