/* All runs, on several threads, and the rows. */
#include "host_sim/lab/paper.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "host_sim/lab/paper_parts.h"

typedef struct {
    paper_t *paper;
    paper_progress_t progress;
    void *context;
    size_t total;
} work_t;

static bool measure(void *context, size_t n, char why[POOL_WHY])
{
    const work_t *work = context;
    return paper_measure(&work->paper->results[n], work->paper->seed, why);
}

static void tell(void *context, size_t done)
{
    const work_t *work = context;
    if (work->progress != NULL) {
        work->progress(work->context, done, work->total);
    }
}

/* The map counts as one run. */
static bool run_all(work_t *work, unsigned threads, char why[POOL_WHY])
{
    paper_t *paper = work->paper;
    const pool_t pool = {.count = paper->result_count, .piece = measure, .progress = tell, .work = work};
    work->total = pool.count + (paper->wanted[BEYOND_MAP] ? 1u : 0u);
    if (!pool_run(&pool, threads, why)) {
        return false;
    }
    if (paper->wanted[BEYOND_MAP]) {
        map_error_t refused;
        map_setup_t setup = map_setup_default();
        setup.seed = paper->seed;
        if (!map_run(&setup, paper->points, threads, &refused)) {
            memcpy(why, refused.text, sizeof refused.text);
            return false;
        }
        tell(work, work->total);
    }
    return true;
}

static bool lay_out(paper_t *paper)
{
    const map_setup_t setup = map_setup_default();
    const size_t count = paper_plan(paper->wanted, NULL);
    flavoured_t *planned = calloc(count + 1u, sizeof *planned);
    paper->results = calloc(count + 1u, sizeof *paper->results);
    paper->points = calloc(map_count(&setup), sizeof *paper->points);
    const bool done = planned != NULL && paper->results != NULL && paper->points != NULL;
    if (done) {
        paper->point_count = map_count(&setup);
        paper->result_count = paper_plan(paper->wanted, planned);
        for (size_t n = 0; n < count; n++) {
            paper->results[n].run = planned[n].run;
            paper->results[n].real = planned[n].real;
        }
    }
    free(planned);
    return done;
}

static void judge(paper_t *paper)
{
    for (figure_t figure = FIG04; figure <= BEYOND_MAP; figure++) {
        if (!paper->wanted[figure]) {
            continue;
        }
        if (figure == FIG04 || figure == FIG08) {
            paper_judge_formulas(paper, figure);
        } else if (paper_figures[figure].paper != NULL) {
            paper_judge_measured(paper, figure);
        } else {
            paper_judge_beyond(paper, figure);
        }
    }
}

bool paper_is_for(uint64_t period_ticks, paper_error_t *why)
{
    if (period_ticks == PAPER_PERIOD_TICKS) {
        return true;
    }
    snprintf(why->text, sizeof why->text,
             "the paper's experiments need a PWM of %g kHz; this board's has %g kHz",
             150e3 / (double)PAPER_PERIOD_TICKS, 150e3 / (double)period_ticks);
    return false;
}

paper_t *paper_run(const bool wanted[PAPER_FIGURES], uint64_t seed, unsigned threads,
                   paper_progress_t progress, void *context, paper_error_t *why)
{
    if (!paper_is_for(RIG_PERIOD_TICKS, why)) {
        return NULL;
    }
    paper_t *paper = calloc(1, sizeof *paper);
    if (paper != NULL) {
        memcpy(paper->wanted, wanted, sizeof paper->wanted);
        paper->seed = seed;
    }
    if (paper == NULL || !lay_out(paper)) {
        paper_free(paper);
        snprintf(why->text, sizeof why->text, "no memory");
        return NULL;
    }
    work_t work = {.paper = paper, .progress = progress, .context = context};
    if (!run_all(&work, threads, why->text)) {
        paper_free(paper);
        return NULL;
    }
    judge(paper);
    return paper;
}

void paper_free(paper_t *paper)
{
    if (paper != NULL) {
        for (size_t n = 0; n < paper->result_count; n++) {
            free(paper->results[n].trace);
        }
        free(paper->results);
        free(paper->points);
        free(paper);
    }
}

size_t paper_figure(const char *id)
{
    size_t n = 0;
    while (n < PAPER_FIGURES && strcmp(paper_figures[n].id, id) != 0) {
        n++;
    }
    return n;
}

bool paper_of_figure(const result_t *result, size_t figure)
{
    return (size_t)result->run.figure == figure && !result->run.sweep;
}

const result_t *paper_find(const paper_t *paper, figure_t figure, const char *name, bool real)
{
    for (size_t n = 0; n < paper->result_count; n++) {
        const result_t *result = &paper->results[n];
        if (result->run.figure == figure && result->real == real && strcmp(result->run.name, name) == 0) {
            return result;
        }
    }
    assert(false);
    return NULL;
}

const result_t *paper_dead_time_run(const paper_t *paper, int loop, int dead_time, int seed)
{
    char name[32];
    snprintf(name, sizeof name, "%s_%d_%d", loops_15[loop], dead_time, seed);
    return paper_find(paper, FIG15, name, true);
}

size_t paper_row_count(const paper_t *paper)
{
    return paper->row_count;
}

const paper_row_t *paper_row(const paper_t *paper, size_t n)
{
    assert(n < paper->row_count);
    return &paper->rows[n];
}

const paper_row_t *paper_row_by_id(const paper_t *paper, const char *id)
{
    for (size_t n = 0; n < paper->row_count; n++) {
        if (strcmp(paper->rows[n].id, id) == 0) {
            return &paper->rows[n];
        }
    }
    return NULL;
}
