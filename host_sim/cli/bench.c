/* `lagless bench`: how much faster than real time the whole ring runs, and what the interrupt costs on this
 * machine. */
#include <argp.h>
#include <stdio.h>
#include <stdlib.h>

#include "host_sim/cli/cli.h"
#include "host_sim/cli/output.h"
#include "host_sim/rig/rig.h"

#define RUNS           5
#define SPEED_RPM      1000.0
#define LOAD_NM        5.0
#define SETTLE_PERIODS 5000u
#define RPM            (2.0 * 3.14159265358979 / 60.0) /* [rad/s] */

typedef struct {
    bool json;
    double seconds;
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
            argp_error(state, "--seconds %s: accepted 0.01 to 1000", argument);
        }
        return 0;
    case ARGP_KEY_ARG:
        argp_error(state, "%s: no argument is expected", argument);
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

static rig_t *running_rig(bool averaged)
{
    rig_t *rig = rig_create(1);
    if (rig == NULL) {
        return NULL;
    }
    rig_put(rig, "fidelity", averaged ? 1.0 : 0.0);
    rig_put(rig, "load_torque", LOAD_NM);
    rig_set_motion(rig, 0.0, SPEED_RPM * RPM);
    rig_put(rig, "speed_request", SPEED_RPM * RPM);
    rig_put(rig, "enable", 1.0);
    rig_run(rig, SETTLE_PERIODS);
    return rig;
}

static double times_realtime(bool averaged, double seconds)
{
    double values[RUNS];
    rig_t *rig = running_rig(averaged);
    if (rig == NULL) {
        return 0.0;
    }
    for (int n = 0; n < RUNS; n++) {
        const double start = output_seconds();
        rig_run(rig, (uint32_t)(seconds / RIG_PERIOD_SECONDS));
        values[n] = seconds / (output_seconds() - start);
    }
    rig_free(rig);
    return median(values);
}

static double interrupt_ns(void)
{
    double values[RUNS];
    rig_t *rig = running_rig(true);
    if (rig == NULL) {
        return 0.0;
    }
    for (int n = 0; n < RUNS; n++) {
        values[n] = 1e9 * rig_interrupt_seconds(rig, 50000u);
    }
    rig_free(rig);
    return median(values);
}

int command_bench(int argc, char **argv)
{
    static const struct argp_option rows[] = {
        {"json", 'j', NULL, 0, "one JSON object on stdout", 0},
        {"seconds", 's', "S", 0, "simulated time of each run (default 2)", 0},
        {0},
    };
    static const struct argp argp = {
        rows, parse, NULL, "Speed of the ring and cost of the interrupt, median of 5 runs.",
        NULL, NULL,  NULL};
    options_t options = {false, 2.0};
    if (argp_parse(&argp, argc, argv, 0, NULL, &options) != 0) {
        return EXIT_USAGE;
    }

    const double switched = times_realtime(false, options.seconds);
    const double averaged = times_realtime(true, options.seconds);
    const double isr_ns = interrupt_ns();
    if (options.json) {
        printf("{\"switched_x_realtime\": %.1f, \"averaged_x_realtime\": %.1f, \"isr_ns\": %.1f}\n", switched,
               averaged, isr_ns);
    } else {
        printf("whole ring, one core, %g r/min, %g N m, median of %d runs of %g s\n", SPEED_RPM, LOAD_NM,
               RUNS, options.seconds);
        printf("  switched   %7.0f x real time   %6.0f ns a period\n", switched, 1e5 / switched);
        printf("  averaged   %7.0f x real time   %6.0f ns a period\n", averaged, 1e5 / averaged);
        printf("  interrupt  %7.0f ns\n", isr_ns);
    }
    return switched > 0.0 && averaged > 0.0 ? EXIT_DONE : EXIT_INTERNAL;
}
