/* A claim and a number make a row, a row makes a verdict. */
#include <assert.h>
#include <math.h>
#include <stdio.h>

#include "host_sim/lab/paper_parts.h"

paper_verdict_t paper_judge(const paper_row_t *row)
{
    const paper_verdict_t no = row->beyond ? PAPER_DOES_NOT_HOLD : PAPER_NOT_REPRODUCED;
    if (row->stopped || isnan(row->ours)) {
        return no;
    }
    const bool same = fabs(row->ours - row->expected) <= row->tolerance;
    if (row->beyond) {
        return same || row->kind ? PAPER_HOLDS : no;
    }
    if (same && !isnan(row->paper)) {
        return PAPER_REPRODUCED;
    }
    return same || row->kind ? PAPER_IN_KIND : no;
}

const char *paper_verdict_name(paper_verdict_t verdict)
{
    static const char *const names[PAPER_VERDICTS] = {
        [PAPER_REPRODUCED] = "reproduced",         [PAPER_IN_KIND] = "reproduced in kind",
        [PAPER_NOT_REPRODUCED] = "not reproduced", [PAPER_HOLDS] = "holds",
        [PAPER_DOES_NOT_HOLD] = "does not hold",
    };
    return names[verdict];
}

claim_t paper_claim(figure_t figure, const char *id, const char *claim, const char *unit, double number,
                    double tolerance, const char *because)
{
    return (claim_t){figure, id, claim, unit, number, (double)NAN, tolerance, because};
}

claim_t paper_claim_of_theory(figure_t figure, const char *id, const char *claim, const char *unit,
                              double theory_number, double tolerance, const char *because)
{
    return (claim_t){figure, id, claim, unit, (double)NAN, theory_number, tolerance, because};
}

static paper_row_t *add(paper_t *paper, const claim_t *claim, const char *flavour, double ours, bool kind)
{
    assert(paper->row_count < PAPER_ROWS_MAX);
    paper_row_t *row = &paper->rows[paper->row_count++];
    *row = (paper_row_t){
        .figure = claim->figure,
        .beyond = paper->about[claim->figure].paper == NULL,
        .flavour = flavour,
        .paper = claim->paper,
        .expected = isnan(claim->paper) ? claim->theory : claim->paper,
        .ours = ours,
        .unit = claim->unit,
        .tolerance = claim->tolerance,
        .kind = kind,
    };
    snprintf(row->id, sizeof row->id, "%s.%s.%s", paper->about[claim->figure].id, claim->id, flavour);
    snprintf(row->claim, sizeof row->claim, "%s", claim->claim);
    return row;
}

static void conclude_row(paper_row_t *row, const claim_t *claim)
{
    row->verdict = paper_judge(row);
    const bool no = row->verdict == PAPER_NOT_REPRODUCED || row->verdict == PAPER_DOES_NOT_HOLD;
    if (row->stopped) {
        snprintf(row->because, sizeof row->because, "because the drive stopped or lost the rotor");
    } else if (isnan(row->ours)) {
        snprintf(row->because, sizeof row->because, "because there is nothing to measure");
    } else if (no && isinf(row->expected)) {
        snprintf(row->because, sizeof row->because, "because the claim does not hold of it");
    } else if (row->verdict == PAPER_NOT_REPRODUCED && isnan(row->paper)) {
        snprintf(row->because, sizeof row->because, "because theory says %.4g within %.2g", row->expected,
                 row->tolerance);
    } else if (no || row->verdict == PAPER_IN_KIND) {
        snprintf(row->because, sizeof row->because, "because %s", claim->because);
    }
}

void paper_row_of(paper_t *paper, const claim_t *claim, const result_t *result, double ours, bool kind)
{
    paper_row_t *row = add(paper, claim, result->real ? "real" : "ideal", ours, kind);
    row->stopped = result->lost;
    paper_describe(row->condition, sizeof row->condition, &result->run, result->real);
    conclude_row(row, claim);
}

void paper_row_of_several(paper_t *paper, const claim_t *claim, const result_t *one, bool stopped,
                          double ours, bool kind, const char *condition)
{
    paper_row_t *row = add(paper, claim, one->real ? "real" : "ideal", ours, kind);
    row->stopped = stopped;
    char text[480];
    paper_describe(text, sizeof text, &one->run, one->real);
    snprintf(row->condition, sizeof row->condition, "%.150s; %s", condition, text);
    conclude_row(row, claim);
}

void paper_row_of_loss(paper_t *paper, const claim_t *claim, const result_t *result)
{
    paper_row_t *row = add(paper, claim, result->real ? "real" : "ideal", result->lost ? 1.0 : 0.0, false);
    paper_describe(row->condition, sizeof row->condition, &result->run, result->real);
    conclude_row(row, claim);
}

void paper_row_of_file(paper_t *paper, size_t figure, const experiment_row_t *of)
{
    const claim_t claim = {(figure_t)figure, of->id,       of->text,      of->unit,
                           of->printed,      of->expected, of->tolerance, of->why_not};
    paper_row_t *row = add(paper, &claim, of->flavour, of->ours, of->kind);
    row->stopped = of->stopped;
    snprintf(row->condition, sizeof row->condition, "%s", of->condition);
    conclude_row(row, &claim);
}

void paper_row_of_map(paper_t *paper, const claim_t *claim, bool stopped, double ours, const char *condition)
{
    paper_row_t *row = add(paper, claim, "real", ours, false);
    row->stopped = stopped;
    snprintf(row->condition, sizeof row->condition, "%s", condition);
    conclude_row(row, claim);
}
