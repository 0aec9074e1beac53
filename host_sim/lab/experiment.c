/* An experiment and its rows. */
#include "host_sim/lab/experiment.h"

#include <assert.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host_sim/lab/experiment_parts.h"

void experiment_free(experiment_t *experiment)
{
    if (experiment == NULL) {
        return;
    }
    for (uint32_t n = 0; n < experiment->run_count; n++) {
        scenario_free(experiment->runs[n].scenario);
        free(experiment->runs[n].trace);
    }
    scenario_free(experiment->base);
    free(experiment);
}

const char *experiment_id(const experiment_t *experiment)
{
    return experiment->id;
}

const char *experiment_title(const experiment_t *experiment)
{
    return experiment->base->title;
}

const char *experiment_claim(const experiment_t *experiment)
{
    return experiment->claim;
}

const char *experiment_source(const experiment_t *experiment)
{
    return experiment->source;
}

uint64_t experiment_seed(const experiment_t *experiment)
{
    return experiment->base->seed;
}

size_t experiment_run_count(const experiment_t *experiment)
{
    return experiment->idle ? 0u : experiment->run_count;
}

uint32_t experiment_each_count(const experiment_t *experiment)
{
    return experiment->each_count;
}

size_t experiment_row_count(const experiment_t *experiment)
{
    size_t count = 0;
    for (uint32_t n = 0; n < experiment->claim_count; n++) {
        for (uint32_t each = 0; each < experiment->each_count; each++) {
            count += experiment->claims[n].each[each];
        }
    }
    return count;
}

/* ---- a row ---- */

static double number_of(value_t *value, const claim_t *claim)
{
    if (claim->value != NULL) {
        return experiment_evaluate(value, claim->value);
    }
    const experiment_run_t *run = experiment_run_at(value->experiment, value->point);
    value->lost = value->lost || run->lost;
    return tally_value(&run->tallies[claim->measure], claim->of);
}

/* Finds the point with the largest number, and whether one of the runs is lost. */
static void find_worst(const experiment_t *experiment, const claim_t *claim, uint32_t each,
                       uint32_t point[SWEEPS_MAX], experiment_row_t *row)
{
    for (size_t n = 0; n < experiment_claim_points(experiment, claim); n++) {
        uint32_t here[SWEEPS_MAX] = {0};
        experiment_claim_point(experiment, claim, each, n, here);
        value_t value = {.experiment = experiment, .point = here, .own = (double)NAN};
        const double number = number_of(&value, claim);
        row->stopped = row->stopped || value.lost;
        if (n == 0u || fabs(number) > fabs(row->ours)) {
            row->ours = isfinite(number) ? number : (double)NAN;
            memcpy(point, here, sizeof here);
        }
    }
}

static void fill_in(const experiment_t *experiment, const uint32_t *point, const char *text,
                    const experiment_row_t *row, char *to, size_t size)
{
    value_t value = {.experiment = experiment, .point = point, .own = row->ours};
    (void)experiment_text(&value, text, to, size);
}

/* Row n: `claim` and which of each. */
static const claim_t *find_row(const experiment_t *experiment, size_t n, uint32_t *each)
{
    for (*each = 0; *each < experiment->each_count; (*each)++) {
        for (uint32_t c = 0; c < experiment->claim_count; c++) {
            if (experiment->claims[c].each[*each] && n-- == 0u) {
                return &experiment->claims[c];
            }
        }
    }
    assert(false);
    return NULL;
}

void experiment_row(const experiment_t *experiment, size_t n, experiment_row_t *row)
{
    uint32_t each;
    const claim_t *claim = find_row(experiment, n, &each);
    uint32_t point[SWEEPS_MAX] = {0};
    char where[160];
    char condition[480];
    *row = (experiment_row_t){
        .id = claim->id,
        .text = claim->text,
        .unit = claim->unit,
        .flavour = experiment->idle ? "formula" : "run",
        .each = each,
        .printed = claim->printed,
        .expected = isnan(claim->printed) ? claim->theory_number : claim->printed,
        .tolerance = claim->tolerance[each],
    };
    if (experiment->each_sweep < experiment->sweep_count) {
        row->flavour = experiment->sweeps[experiment->each_sweep].points[experiment->each[each]].name;
    }
    find_worst(experiment, claim, each, point, row);
    if (claim->theory != NULL) {
        value_t value = {.experiment = experiment, .point = point, .own = row->ours};
        row->expected = experiment_evaluate(&value, claim->theory);
    }
    if (claim->holds_if != NULL) {
        value_t value = {.experiment = experiment, .point = point, .own = row->ours};
        row->kind = experiment_evaluate(&value, claim->holds_if) == 1.0;
    }
    fill_in(experiment, point, claim->why_not, row, row->why_not, sizeof row->why_not);
    fill_in(experiment, point, claim->where, row, where, sizeof where);
    fill_in(experiment, point, experiment->condition, row, condition, sizeof condition);
    snprintf(row->condition, sizeof row->condition, "%.150s%s%s", where,
             where[0] != '\0' && condition[0] != '\0' ? "; " : "", condition);
}
