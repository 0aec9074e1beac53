/* What an experiment is, and its rows. */
#include "host_sim/lab/experiment.h"

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
    return experiment->measure_count > 0u || experiment->column_count > 0u ? experiment->run_count : 0u;
}

size_t experiment_row_count(const experiment_t *experiment)
{
    return (size_t)experiment->each_count * experiment->claim_count;
}

/* ---- a row ---- */

/* The points of a claim one after the other, the first sweep the fastest. */
static size_t point_count(const experiment_t *experiment, const claim_t *claim)
{
    size_t count = 1;
    for (uint32_t s = 0; s < experiment->sweep_count; s++) {
        count *= claim->at_count[s];
    }
    return count;
}

static void point_of(const experiment_t *experiment, const claim_t *claim, uint32_t each, size_t n,
                     uint32_t point[SWEEPS_MAX])
{
    for (uint32_t s = 0; s < experiment->sweep_count; s++) {
        point[s] =
            s == experiment->each_sweep ? experiment->each[each] : claim->at[s][n % claim->at_count[s]];
        n /= claim->at_count[s];
    }
}

static double number_of(value_t *value, const claim_t *claim)
{
    if (claim->value != NULL) {
        return experiment_evaluate(value, claim->value);
    }
    const experiment_run_t *run = experiment_run_at(value->experiment, value->point);
    value->lost = value->lost || run->lost;
    return tally_value(&run->tallies[claim->measure], claim->of);
}

/* The point at which the number is largest, and whether a run among them is lost. */
static void find_worst(const experiment_t *experiment, const claim_t *claim, uint32_t each,
                       uint32_t point[SWEEPS_MAX], experiment_row_t *row)
{
    for (size_t n = 0; n < point_count(experiment, claim); n++) {
        uint32_t here[SWEEPS_MAX] = {0};
        point_of(experiment, claim, each, n, here);
        value_t value = {.experiment = experiment, .point = here, .own = (double)NAN};
        const double number = number_of(&value, claim);
        row->stopped = row->stopped || value.lost;
        if (n == 0u || fabs(number) > fabs(row->ours)) {
            row->ours = number;
            memcpy(point, here, sizeof here);
        }
    }
}

void experiment_row(const experiment_t *experiment, size_t n, experiment_row_t *row)
{
    const uint32_t each = (uint32_t)(n / experiment->claim_count);
    const claim_t *claim = &experiment->claims[n % experiment->claim_count];
    uint32_t point[SWEEPS_MAX] = {0};
    char condition[480];
    char why[WHY_MAX];
    *row = (experiment_row_t){
        .id = claim->id,
        .text = claim->text,
        .unit = claim->unit,
        .why_not = claim->why_not,
        .flavour = experiment_run_count(experiment) == 0u ? "formula" : "run",
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
    (void)experiment_condition(experiment, point, condition, sizeof condition, why);
    snprintf(row->condition, sizeof row->condition, "%.150s%s%s", claim->where,
             claim->where[0] != '\0' && condition[0] != '\0' ? "; " : "", condition);
}
