/* Points of the grid, values of rows at t = 0, and texts with numbers in them. */
#include <stdio.h>
#include <string.h>

#include "host_sim/lab/experiment_parts.h"

const experiment_run_t *experiment_run_at(const experiment_t *experiment, const uint32_t *point)
{
    size_t n = 0;
    for (uint32_t s = experiment->sweep_count; s-- > 0u;) {
        n = n * experiment->sweeps[s].count + point[s];
    }
    return experiment->run_of[n] != NO_RUN ? &experiment->runs[experiment->run_of[n]] : NULL;
}

bool experiment_next(const experiment_t *experiment, uint32_t sweeps, uint32_t *point)
{
    for (uint32_t s = 0; s < experiment->sweep_count; s++) {
        if ((sweeps & (UINT32_C(1) << s)) == 0u) {
            continue;
        }
        if (++point[s] < experiment->sweeps[s].count) {
            return true;
        }
        point[s] = 0;
    }
    return false;
}

size_t experiment_claim_points(const experiment_t *experiment, const claim_t *claim)
{
    size_t count = 1;
    for (uint32_t s = 0; s < experiment->sweep_count; s++) {
        count *= claim->at_count[s];
    }
    return count;
}

void experiment_claim_point(const experiment_t *experiment, const claim_t *claim, uint32_t each, size_t n,
                            uint32_t point[SWEEPS_MAX])
{
    for (uint32_t s = 0; s < experiment->sweep_count; s++) {
        point[s] =
            s == experiment->each_sweep ? experiment->each[each] : claim->at[s][n % claim->at_count[s]];
        n /= claim->at_count[s];
    }
}

uint32_t experiment_measure_of(const experiment_t *experiment, const char *name, size_t length)
{
    uint32_t n = 0;
    while (n < experiment->measure_count && (strlen(experiment->measures[n].look.name) != length ||
                                             strncmp(experiment->measures[n].look.name, name, length) != 0)) {
        n++;
    }
    return n;
}

double experiment_initial(const experiment_run_t *run, const table_row_t *row)
{
    const scenario_event_t *initial = &run->scenario->events[0];
    for (uint32_t n = 0; n < initial->count; n++) {
        if (initial->settings[n].row == row) {
            return initial->settings[n].value;
        }
    }
    return rig_initial(row);
}

/* ---- texts ---- */

static bool fill(value_t *value, const char *name, char *to, size_t size)
{
    const experiment_t *experiment = value->experiment;
    scenario_error_t error;
    for (uint32_t s = 0; s < experiment->sweep_count; s++) {
        if (strcmp(experiment->sweeps[s].name, name) == 0) {
            if (value->nested == SWEEPS_MAX) {
                snprintf(value->why, sizeof value->why,
                         "the texts of points refer to each other in a circle");
                return false;
            }
            value->nested++;
            const bool filled =
                experiment_text(value, experiment->sweeps[s].points[value->point[s]].text, to, size);
            value->nested--;
            return filled;
        }
    }
    const table_row_t *row = scenario_row(name, &error);
    const experiment_run_t *run = experiment_run_at(experiment, value->point);
    if (row != NULL && row->access != TABLE_READ && row->kind == SLOT_ENUM && run != NULL) {
        char text[UNITS_TEXT_SIZE];
        snprintf(to, size, "%s", units_row_text(text, experiment_initial(run, row), row));
        return true;
    }
    const double number = experiment_evaluate(value, name);
    if (value->why[0] != '\0') {
        char why[WHY_MAX];
        snprintf(why, sizeof why, "{%.60s}: %.300s", name, value->why);
        memcpy(value->why, why, sizeof why);
        return false;
    }
    snprintf(to, size, "%g", number);
    return true;
}

bool experiment_text(value_t *value, const char *text, char *to, size_t size)
{
    size_t used = 0;
    to[0] = '\0';
    for (const char *c = text; *c != '\0' && used + 1u < size; c++) {
        char name[TEXT_MAX];
        const size_t length = strcspn(c, "}");
        if (*c != '{' || c[length] == '\0' || length > sizeof name) {
            to[used++] = *c;
            to[used] = '\0';
            continue;
        }
        snprintf(name, sizeof name, "%.*s", (int)(length - 1u), c + 1);
        if (!fill(value, name, to + used, size - used)) {
            return false;
        }
        used += strlen(to + used);
        c += length;
    }
    return true;
}
