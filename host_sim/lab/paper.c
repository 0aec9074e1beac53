/* All runs, on several threads, and the rows. */
#include "host_sim/lab/paper.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "host_sim/lab/paper_parts.h"
#include "host_sim/lab/paper_theory.h"
#include "host_sim/rig/rig.h"

const paper_figure_t paper_figures[PAPER_FIGURES] = {
    {.id = "fig04"},
    {.id = "fig05"},
    {.id = "fig08"},
    {.id = "fig10"},
    {.id = "fig11"},
    {.id = "fig12"},
    {.id = "fig13"},
    {.id = "fig14"},
    {.id = "fig15", .more = "dead_time"},
    {.id = "fig16"},
    {.id = "fig17"},
    {.id = "beyond_speed"},
    {.id = "beyond_bandwidth"},
    [PAPER_MAP] = {.id = "beyond_map",
                   .title = "effect of wrong data of motor and sensors",
                   .claim = "a wrong L shifts the angle by -asin(dL i_q/psi_f), and wrong R and psi_f do "
                            "not; learning removes the errors of L and dead time"},
};

/* The experiment and the number of run n of the files. */
typedef struct {
    experiment_t *experiment;
    size_t n;
} filed_t;

typedef struct {
    paper_t *paper;
    filed_t *filed;
    size_t filed_count;
    paper_progress_t progress;
    void *context;
    size_t total;
} work_t;

static bool measure(void *context, size_t n, char why[POOL_WHY])
{
    const work_t *work = context;
    return experiment_measure(work->filed[n].experiment, work->filed[n].n, work->paper->seed,
                              work->paper->traced, why);
}

static void tell(void *context, size_t done)
{
    const work_t *work = context;
    if (work->progress != NULL) {
        work->progress(work->context, done, work->total);
    }
}

static size_t runs_of(const experiment_t *file)
{
    return file != NULL ? experiment_run_count(file) : 0u;
}

static void list_runs(work_t *work, experiment_t *file)
{
    for (size_t k = 0; k < runs_of(file); k++) {
        work->filed[work->filed_count++] = (filed_t){file, k};
    }
}

/* The runs of all files; false: no memory. */
static bool list_filed(work_t *work)
{
    size_t count = 0;
    for (size_t n = 0; n <= PAPER_FIGURES; n++) {
        count += runs_of(work->paper->files[n]) + runs_of(work->paper->more[n]);
    }
    work->filed = calloc(count + 1u, sizeof *work->filed);
    for (size_t n = 0; n <= PAPER_FIGURES && work->filed != NULL; n++) {
        list_runs(work, work->paper->files[n]);
        list_runs(work, work->paper->more[n]);
    }
    return work->filed != NULL;
}

/* The map counts as one run. */
static bool run_all(work_t *work, unsigned threads, char why[POOL_WHY])
{
    paper_t *paper = work->paper;
    const pool_t pool = {.count = work->filed_count, .piece = measure, .progress = tell, .work = work};
    work->total = pool.count + (paper->wanted[PAPER_MAP] ? 1u : 0u);
    if (!pool_run(&pool, threads, why)) {
        return false;
    }
    if (paper->wanted[PAPER_MAP]) {
        if (!paper_map_run(paper, threads, why)) {
            return false;
        }
        tell(work, work->total);
    }
    return true;
}

/* The rows for this point of the experiment's `each`. */
static void judge_file(paper_t *paper, size_t figure, const experiment_t *file, uint32_t each)
{
    for (size_t n = 0; n < experiment_row_count(file); n++) {
        experiment_row_t row;
        experiment_row(file, n, &row);
        if (row.each == each) {
            paper_row_add(paper, figure, &row);
        }
    }
}

static void judge_files(paper_t *paper, size_t figure)
{
    const uint32_t flavours = experiment_each_count(paper->files[figure]);
    for (uint32_t each = 0; each < flavours; each++) {
        judge_file(paper, figure, paper->files[figure], each);
        if (paper->more[figure] != NULL) {
            judge_file(paper, figure, paper->more[figure], each);
        }
    }
}

static void judge(paper_t *paper)
{
    for (size_t n = 0; n <= PAPER_OWN; n++) {
        if (paper->files[n] != NULL) {
            judge_files(paper, n);
        }
    }
    if (paper->wanted[PAPER_MAP]) {
        paper_map_judge(paper);
    }
}

const paper_figure_t *paper_about(const paper_t *paper, size_t figure)
{
    return &paper->about[figure];
}

static void tell_of(paper_figure_t *about, const experiment_t *file)
{
    *about = (paper_figure_t){.id = experiment_id(file),
                              .title = experiment_title(file),
                              .claim = experiment_claim(file),
                              .paper = experiment_source(file)};
}

/* The experiment NAME_MORE of the paper; more = NULL: NAME. */
static experiment_t *read_file(const char *name, const char *more, paper_error_t *why)
{
    const char *folder = getenv("LAGLESS_EXPERIMENTS");
    folder = folder != NULL && folder[0] != '\0' ? folder : LAGLESS_EXPERIMENTS;
    char path[4096];
    scenario_error_t error;
    snprintf(path, sizeof path, "%s/%s%s%s.toml", folder, name, more != NULL ? "_" : "",
             more != NULL ? more : "");
    experiment_t *file = experiment_read(path, &error);
    if (file == NULL) {
        char text[1200];
        snprintf(why->text, sizeof why->text, "%.300s", scenario_error_text(&error, text, sizeof text));
    }
    return file;
}

/* Reads the figures that are files. */
static bool read_files(paper_t *paper, paper_error_t *why)
{
    for (size_t n = 0; n < PAPER_FIGURES; n++) {
        const paper_figure_t *figure = &paper_figures[n];
        paper->about[n] = *figure;
        if (!paper->wanted[n] || n == PAPER_MAP) {
            continue;
        }
        paper->files[n] = read_file(figure->id, NULL, why);
        if (paper->files[n] == NULL) {
            return false;
        }
        tell_of(&paper->about[n], paper->files[n]);
        if (figure->more != NULL) {
            paper->more[n] = read_file(figure->id, figure->more, why);
            if (paper->more[n] == NULL) {
                return false;
            }
        }
    }
    return true;
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

static bool run_and_judge(paper_t *paper, unsigned threads, paper_progress_t progress, void *context,
                          paper_error_t *why)
{
    work_t work = {.paper = paper, .progress = progress, .context = context};
    bool done = list_filed(&work);
    if (!done) {
        snprintf(why->text, sizeof why->text, "no memory");
    }
    done = done && run_all(&work, threads, why->text);
    free(work.filed);
    if (done) {
        judge(paper);
    }
    return done;
}

paper_t *paper_run(const bool wanted[PAPER_FIGURES], uint64_t seed, unsigned threads,
                   paper_progress_t progress, void *context, paper_error_t *why)
{
    if (!paper_is_for(RIG_PERIOD_TICKS, why)) {
        return NULL;
    }
    paper_t *paper = calloc(1, sizeof *paper);
    if (paper == NULL) {
        snprintf(why->text, sizeof why->text, "no memory");
        return NULL;
    }
    memcpy(paper->wanted, wanted, PAPER_FIGURES * sizeof wanted[0]);
    paper->seed = seed;
    paper->traced = true;
    if (!read_files(paper, why) || !run_and_judge(paper, threads, progress, context, why)) {
        paper_free(paper);
        return NULL;
    }
    return paper;
}

paper_t *paper_run_file(experiment_t *own, bool traced, unsigned threads, paper_progress_t progress,
                        void *context, paper_error_t *why)
{
    paper_t *paper = calloc(1, sizeof *paper);
    if (paper == NULL) {
        experiment_free(own);
        snprintf(why->text, sizeof why->text, "no memory");
        return NULL;
    }
    paper->seed = experiment_seed(own);
    paper->traced = traced;
    paper->wanted[PAPER_OWN] = true;
    paper->files[PAPER_OWN] = own;
    tell_of(&paper->about[PAPER_OWN], own);
    if (!run_and_judge(paper, threads, progress, context, why)) {
        paper_free(paper);
        return NULL;
    }
    return paper;
}

void paper_free(paper_t *paper)
{
    if (paper != NULL) {
        for (size_t n = 0; n <= PAPER_FIGURES; n++) {
            experiment_free(paper->files[n]);
            experiment_free(paper->more[n]);
        }
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

void paper_write_csv(const paper_t *paper, size_t figure, FILE *file)
{
    assert(figure <= PAPER_OWN);
    if (paper->files[figure] != NULL) {
        experiment_write_csv(paper->files[figure], file);
    } else if (figure == PAPER_MAP && paper->wanted[figure]) {
        paper_map_write(paper, file);
    }
}

void paper_write_more(const paper_t *paper, size_t figure, FILE *file)
{
    if (paper->more[figure] != NULL) {
        experiment_write_csv(paper->more[figure], file);
    }
}
