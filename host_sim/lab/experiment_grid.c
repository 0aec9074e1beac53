/* The grid of an experiment: the run of each of its points, read. */
#include "host_sim/lab/experiment_read.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* Points but for the flavour, as one name. */
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

/* The uses of a point and its own rows. */
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

static bool read_run(const file_t *file, experiment_run_t *run)
{
    const experiment_t *experiment = file->experiment;
    scenario_layer_t layers[(SWEEPS_MAX + 1u) * 5u];
    scenario_more_t more = {.keys = EXPERIMENT_KEYS, .accepted = EXPERIMENT_ACCEPTED, .layers = layers};
    for (uint32_t s = 0; s < experiment->sweep_count; s++) {
        add_layers(&experiment->sweeps[s].points[run->point[s]], false, layers, &more.layer_count);
    }
    add_layers(&experiment->begin, true, layers, &more.layer_count);
    name_run(experiment, run);
    const toml_file_t *whole = file->reading.file;
    run->scenario =
        scenario_read_more(experiment->base->path, whole->source, whole->octets, &more, file->reading.error);
    if (run->scenario == NULL) {
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

bool file_read_runs(const file_t *file)
{
    experiment_t *experiment = file->experiment;
    uint32_t count = 1;
    for (uint32_t s = 0; s < experiment->sweep_count; s++) {
        count *= experiment->sweeps[s].count;
    }
    experiment->runs = file_take(file, count, sizeof *experiment->runs);
    while (experiment->runs != NULL && experiment->run_count < count) {
        experiment_run_t *run = &experiment->runs[experiment->run_count];
        uint32_t rest = experiment->run_count++;
        run->flavour = "";
        for (uint32_t s = 0; s < experiment->sweep_count; s++) {
            run->point[s] = rest % experiment->sweeps[s].count;
            rest /= experiment->sweeps[s].count;
        }
        if (!read_run(file, run)) {
            return false;
        }
    }
    return experiment->runs != NULL;
}
