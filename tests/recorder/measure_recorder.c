/* What recording costs: the averaged ring with and without a tap of 12 rows every period, and writing
 * afterwards. Prints the best of 7 runs, in turns, so that both see the same machine; measured by hand, not a
 * test.
 *
 * usage: measure_recorder FOLDER */
#define _POSIX_C_SOURCE 200809L

#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "host_sim/lab/recorder.h"
#include "host_sim/rig/rig.h"

#define RUNS    7
#define PERIODS 200000u
#define ROWS    12u

static double now(void)
{
    struct timespec time;
    clock_gettime(CLOCK_MONOTONIC, &time);
    return (double)time.tv_sec + 1e-9 * (double)time.tv_nsec;
}

static rig_t *running_rig(void)
{
    rig_t *rig = rig_create(1);
    if (rig == NULL) {
        exit(1);
    }
    rig_put(rig, "fidelity", 1.0);
    rig_put(rig, "speed_request", 104.7);
    rig_put(rig, "enable", 1.0);
    rig_run(rig, 5000);
    return rig;
}

/* [ns a period] */
static double run(rig_t *rig)
{
    const double start = now();
    rig_run(rig, PERIODS);
    return (now() - start) / PERIODS * 1e9;
}

static void keep_least(double *least, double value)
{
    *least = value < *least ? value : *least;
}

int main(int argc, char **argv)
{
    static const uint32_t ids[ROWS] = {2015, 2016, 2022, 2023, 2024, 2025,
                                       2030, 2031, 2032, 3002, 3003, 3010};
    static const uint32_t formats[2] = {RECORDER_CSV, RECORDER_MAT};
    double bare = 1e9;
    double tapped = 1e9;
    double written[2] = {1e9, 1e9};
    if (argc != 2) {
        fprintf(stderr, "usage: measure_recorder FOLDER\n");
        return 2;
    }
    for (int n = 0; n < RUNS; n++) {
        rig_t *rig = running_rig();
        keep_least(&bare, run(rig));
        rig_free(rig);
        for (int f = 0; f < 2; f++) {
            recorder_error_t error;
            const recorder_options_t options = {
                .folder = argv[1],
                .name = "measure",
                .formats = formats[f],
                .ids = ids,
                .count = ROWS,
                .every = 1,
                .meta = {.program = "", .commit = "", .scenario = "", .scenario_text = "", .title = ""}};
            recorder_t *recorder = recorder_open(&options, &error);
            if (recorder == NULL) {
                fprintf(stderr, "%s\n", error.text);
                return 1;
            }
            rig = running_rig();
            rig_tap(rig, ids, ROWS, 1, recorder_sink, recorder);
            keep_least(&tapped, run(rig));
            rig_free(rig);
            const double start = now();
            if (!recorder_close(recorder, "complete", &error)) {
                fprintf(stderr, "%s\n", error.text);
                return 1;
            }
            keep_least(&written[f], (now() - start) / PERIODS * 1e9);
        }
    }
    printf("averaged ring, %u rows every period, least of %d runs of %u periods\n", ROWS, RUNS, PERIODS);
    printf("  without tap   %6.1f ns a period\n", bare);
    printf("  with tap      %6.1f ns a period, %.1f %% more\n", tapped, 100.0 * (tapped / bare - 1.0));
    printf("  CSV at close  %6.1f ns a row\n", written[0]);
    printf("  MAT at close  %6.1f ns a row, read back and compared\n", written[1]);
    return 0;
}
