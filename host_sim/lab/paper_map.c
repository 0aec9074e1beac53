/* The error map as a figure beyond the paper: runs, rows and data. It is not described by an experiment's
 * file, because each deviation is compared with a run without it, on gate edges, and the drive learns in the
 * second half. host_sim/lab/map.h runs it, also for `lagless map`.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host_sim/lab/paper_parts.h"

bool paper_map_run(paper_t *paper, unsigned threads, char why[POOL_WHY])
{
    map_error_t refused;
    map_setup_t setup = map_setup_default();
    setup.seed = paper->seed;
    paper->point_count = map_count(&setup);
    paper->points = calloc(paper->point_count, sizeof *paper->points);
    if (paper->points == NULL) {
        snprintf(why, POOL_WHY, "no memory");
        return false;
    }
    if (!map_run(&setup, paper->points, threads, &refused)) {
        memcpy(why, refused.text, sizeof refused.text);
        return false;
    }
    return true;
}

void paper_map_judge(paper_t *paper)
{
    static const struct {
        const char *id, *claim;
    } claims[MAP_CLAIMS] = {
        [MAP_CLAIM_INDUCTANCE] = {"inductance", "L off by 20 %: distance from -asin(dL i_q/psi_f)"},
        [MAP_CLAIM_NO_EFFECT] = {"no_effect", "psi_f off by 10 %, R by 50 %: change of the mean error"},
        [MAP_CLAIM_LEARNT] = {"learnt", "L off by 20 %, adaptation on and confident: remaining mean error"},
    };
    for (map_claim_t n = MAP_CLAIM_INDUCTANCE; n < MAP_CLAIMS; n++) {
        const map_verdict_t verdict = map_judge(paper->points, paper->point_count, n);
        experiment_row_t row = {
            .id = claims[n].id,
            .text = claims[n].claim,
            .unit = "mrad",
            .flavour = "real",
            .printed = (double)NAN,
            .tolerance = verdict.limit_mrad,
            .ours = verdict.judged > 0u ? verdict.worst_mrad : (double)NAN,
            .stopped = verdict.lost > 0u,
            .why_not = "the difference is larger",
        };
        snprintf(
            row.condition, sizeof row.condition,
            "every gate edge; worst of %zu points, 100 to 1490 r/min in both directions, no load and 5 N "
            "m; vector sigmoid, exact lag, PLL 200 rad/s, omega_c 50 rad/s; inverter compensated",
            verdict.judged);
        paper_row_add(paper, PAPER_MAP, &row);
    }
}

/* Writes a number; the cell stays empty if a lost run has no such number. */
static void write_number(FILE *file, double number)
{
    fputc(',', file);
    if (isfinite(number)) {
        fprintf(file, "%.5g", number);
    }
}

void paper_map_write(const paper_t *paper, FILE *file)
{
    fprintf(file, "deviation[text],adaptation[text],load[N "
                  "m],speed[r/min],mean[mrad],sd[mrad],peak[mrad],theory[mrad],lost[-]\n");
    for (size_t n = 0; n < paper->point_count; n++) {
        const map_point_t *point = &paper->points[n];
        fprintf(file, "%s,%s,%g,%g", map_deviation_name(point->deviation),
                map_adaptation_name(point->adaptation), point->load, point->rpm);
        write_number(file, point->mean_mrad);
        write_number(file, point->sd_mrad);
        write_number(file, point->peak_mrad);
        write_number(file, point->theory_mrad);
        fprintf(file, ",%d\n", !point->locked);
    }
}
