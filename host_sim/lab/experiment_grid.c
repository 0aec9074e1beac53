/* The grid of an experiment: the run of each of its points, read. */
#include "host_sim/lab/experiment_read.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* All points except the flavour, as one name. */
static void name_run(const experiment_t *experiment, experiment_run_t *run)
{
    for (uint32_t s = 0; s < experiment->sweep_count; s++) {
        const char *name = experiment->sweeps[s].points[run->point[s]].name;
        if (s == experiment->each_sweep) {
            run->flavour = name;
        } else {
            const size_t used = strlen(run->name);
            snprintf(run->name + used, sizeof run->name - used, "%s%s", used > 0u ? "_" : "", name);
        }
    }
}

/* Adds the named sets and the rows of a point. */
static void add_layers(const point_t *point, bool under, scenario_layer_t *layers, uint32_t *count)
{
    for (uint32_t n = 0; n < point->use_count; n++) {
        layers[(*count)++] = (scenario_layer_t){under, 0u, point->uses[n]->settings, point->uses[n]->count};
    }
    if (point->entry != 0u) {
        layers[(*count)++] = (scenario_layer_t){.entry = point->entry};
    } else if (point->setting.row != NULL) {
        layers[(*count)++] = (scenario_layer_t){.settings = &point->setting, .count = 1u};
    }
}

static bool add_ready(const file_t *file, experiment_run_t *run)
{
    const experiment_t *experiment = file->experiment;
    const point_t *points[SWEEPS_MAX + 1u] = {&experiment->begin};
    uint32_t all = experiment->begin.ready.count;
    for (uint32_t s = 0; s < experiment->sweep_count; s++) {
        points[s + 1u] = &experiment->sweeps[s].points[run->point[s]];
        all += points[s + 1u]->ready.count;
    }
    run->ready.settings = file_take(file, all, sizeof *run->ready.settings);
    for (uint32_t n = 0; n <= experiment->sweep_count && run->ready.settings != NULL; n++) {
        run->settle = isnan(points[n]->settle) ? run->settle : points[n]->settle;
        for (uint32_t k = 0; k < points[n]->ready.count; k++) {
            run->ready.settings[run->ready.count++] = points[n]->ready.settings[k];
        }
    }
    return run->ready.settings != NULL;
}

/* Rounds the duration up to whole electrical turns at the speed of t = 0, then to whole periods. */
static bool round_up(const file_t *file, const experiment_run_t *run)
{
    const double speed = experiment_initial(run, rig_row_by_name("plant.pole_pairs")) *
                         fabs(experiment_initial(run, rig_row_by_name("speed_request")));
    const double turn = 2.0 * 3.14159265358979323846 / speed;
    const double most = 1e-9; /* largest rounding error of a whole number */
    const toml_entry_t *table = reading_find(&file->reading, file_top(file), "experiment");
    if (!(speed > 0.0)) {
        return file_fail(file, reading_find(&file->reading, table, "whole_turns"),
                         "speed_request is 0 at t = 0; accepted: a speed that makes turns");
    }
    const double turns = ceil(run->scenario->duration / turn * (1.0 - most));
    run->scenario->duration = ceil(turns * turn / RIG_PERIOD_SECONDS * (1.0 - most)) * RIG_PERIOD_SECONDS;
    return true;
}

/* The scenario of this point, judged. */
static bool read_scenario(const file_t *file, const scenario_more_t *more, experiment_run_t *run)
{
    const experiment_t *experiment = file->experiment;
    const toml_file_t *whole = file->reading.file;
    run->scenario =
        scenario_read_more(experiment->base->path, whole->source, whole->octets, more, file->reading.error);
    return run->scenario != NULL && (!experiment->whole_turns || round_up(file, run)) &&
           scenario_check(run->scenario, file->reading.error);
}

static bool read_run(const file_t *file, experiment_run_t *run)
{
    const experiment_t *experiment = file->experiment;
    scenario_layer_t layers[(SWEEPS_MAX + 1u) * 5u];
    scenario_more_t more = {
        .keys = EXPERIMENT_KEYS, .accepted = EXPERIMENT_ACCEPTED, .layers = layers, .unchecked = true};
    for (uint32_t s = 0; s < experiment->sweep_count; s++) {
        add_layers(&experiment->sweeps[s].points[run->point[s]], false, layers, &more.layer_count);
    }
    add_layers(&experiment->begin, true, layers, &more.layer_count);
    name_run(experiment, run);
    if (!read_scenario(file, &more, run)) {
        scenario_error_t *error = file->reading.error;
        const size_t used = strlen(error->message);
        if (run->name[0] != '\0' || run->flavour[0] != '\0') {
            snprintf(error->message + used, sizeof error->message - used, " (at %s%s%s)", run->name,
                     run->name[0] != '\0' && run->flavour[0] != '\0' ? ", " : "", run->flavour);
        }
        return false;
    }
    run->tallies = file_take(file, experiment->measure_count, sizeof *run->tallies);
    for (uint32_t n = 0; n < experiment->measure_count && run->tallies != NULL; n++) {
        run->tallies[n] = tally_empty();
    }
    return run->tallies != NULL && add_ready(file, run);
}

/* True if each of these points can be combined with the others. */
static bool go_together(const experiment_t *experiment, const uint32_t *point)
{
    for (uint32_t s = 0; s < experiment->sweep_count; s++) {
        for (uint32_t other = 0; other < experiment->sweep_count; other++) {
            const bool *only = experiment->sweeps[s].points[point[s]].only[other];
            if (only != NULL && !only[point[other]]) {
                return false;
            }
        }
    }
    return true;
}

/* The seeds of the points of such a sweep. */
static uint64_t reseed(const experiment_t *experiment, const uint32_t *point)
{
    uint64_t seed = experiment->base->seed;
    for (uint32_t s = 0; s < experiment->sweep_count; s++) {
        const sweep_t *sweep = &experiment->sweeps[s];
        seed = sweep->of_seed ? (uint64_t)sweep->points[point[s]].number : seed;
    }
    return seed - experiment->base->seed;
}

bool file_read_runs(const file_t *file)
{
    experiment_t *experiment = file->experiment;
    const uint32_t all = (UINT32_C(1) << experiment->sweep_count) - 1u;
    uint32_t point[SWEEPS_MAX] = {0};
    uint32_t count = 1;
    for (uint32_t s = 0; s < experiment->sweep_count; s++) {
        count *= experiment->sweeps[s].count;
    }
    experiment->runs = file_take(file, count, sizeof *experiment->runs);
    experiment->run_of = file_take(file, count, sizeof *experiment->run_of);
    if (experiment->runs == NULL || experiment->run_of == NULL) {
        return false;
    }
    for (uint32_t n = 0; n < count; n++) {
        experiment->run_of[n] = NO_RUN;
        if (go_together(experiment, point)) {
            experiment_run_t *run = &experiment->runs[experiment->run_count];
            experiment->run_of[n] = experiment->run_count++;
            memcpy(run->point, point, sizeof point);
            run->flavour = "";
            run->reseed = reseed(experiment, point);
            if (!read_run(file, run)) {
                return false;
            }
        }
        (void)experiment_next(experiment, all, point);
    }
    return experiment->run_count > 0u ||
           file_fail(file, reading_find(&file->reading, file_top(file), "sweep"),
                     "the experiment has no run, because no points can be combined; accepted: at least one "
                     "point of each sweep");
}
