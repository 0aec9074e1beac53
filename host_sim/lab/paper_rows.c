/* Makes a row of a claim and a number, and a verdict of a row. */
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

static void tell_why(paper_row_t *row, const char *why_not)
{
    const bool no = row->verdict == PAPER_NOT_REPRODUCED || row->verdict == PAPER_DOES_NOT_HOLD;
    if (row->stopped) {
        snprintf(row->because, sizeof row->because, "because the drive stopped or lost the rotor");
    } else if (isnan(row->ours)) {
        snprintf(row->because, sizeof row->because, "because there is nothing to measure");
    } else if (no && isinf(row->expected)) {
        snprintf(row->because, sizeof row->because, "because the claim does not hold for it");
    } else if (row->verdict == PAPER_NOT_REPRODUCED && isnan(row->paper)) {
        snprintf(row->because, sizeof row->because, "because theory gives %.4g within %.2g", row->expected,
                 row->tolerance);
    } else if (no || row->verdict == PAPER_IN_KIND) {
        snprintf(row->because, sizeof row->because, "because %.190s", why_not);
    }
}

void paper_row_add(paper_t *paper, size_t figure, const experiment_row_t *of)
{
    assert(paper->row_count < PAPER_ROWS_MAX);
    paper_row_t *row = &paper->rows[paper->row_count++];
    *row = (paper_row_t){
        .figure = figure,
        .beyond = paper->about[figure].paper == NULL,
        .flavour = of->flavour,
        .paper = of->printed,
        .expected = of->expected,
        .ours = of->ours,
        .unit = of->unit,
        .tolerance = of->tolerance,
        .kind = of->kind,
        .stopped = of->stopped,
    };
    snprintf(row->id, sizeof row->id, "%s.%s.%s", paper->about[figure].id, of->id, of->flavour);
    snprintf(row->claim, sizeof row->claim, "%s", of->text);
    snprintf(row->condition, sizeof row->condition, "%s", of->condition);
    row->verdict = paper_judge(row);
    tell_why(row, of->why_not);
}
